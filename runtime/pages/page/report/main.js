// The page of `cdb report`: figures of results documents.
import { boundariesTitle, boundaryTable, describeBoundaries, hasBoundaries } from './boundaries.js';
import { compareParts } from './compare.js';
import { controls, cycleTools, errorTools, mapTools, placeTools } from './controls.js';
import { openDocument } from './document.js';
import { bdi, h } from './dom.js';
import { describeDistributions, describeRepeats } from './distributions.js';
import { describeErrors } from './errors.js';
import { sizeOf } from './export.js';
import { createFigure, replaceControls } from './figure.js';
import { short } from './format.js';
import { historyParts } from './history.js';
import { describeOverAxes } from './over_axes.js';
import { describeCycles } from './over_cycles.js';
import { describePhases } from './phases.js';
import { hasRaces, racesTitle, raceTable } from './races.js';
import { describeRatios } from './ratios.js';
import * as parts from './sections.js';
import { describeStability } from './stability.js';
import { decode, encode, unknownEntry } from './state.js';
import { placeParts } from './suite/place.js';
import { suiteParts } from './suite/suite.js';

const page = document.getElementById('page');

/** True if an object of the document has something to draw. */
const has = {
  times: (doc) => doc.phases.length > 0,
  ratios: (doc) => doc.raw.ratios && doc.detectorAxis >= 0 && doc.axes[doc.detectorAxis].values.length > 1,
  errors: (doc) => (doc.raw.fronts ?? []).some((front) => front.rows?.length),
  cycles: (doc) => doc.raw.cycles && (doc.raw.cycles.points?.length ?? doc.count) > 0,
  unsound: (doc) => doc.verdict.some((name) => !['stable', 'unknown'].includes(name)),
};

const isSingle = (doc) => doc.axes.every((axis) => axis.values.length < 2);

/** The figure at the top of the page. @param {import('./document.js').Doc} doc */
function keyFigure(doc) {
  if (hasBoundaries(doc)) return 'boundaries';
  const kind = doc.raw.conclusions?.[0]?.kind;
  if (kind === 'error' && has.errors(doc)) return 'errors';
  if (kind === 'stability' && has.unsound(doc)) return 'stability';
  if (has.errors(doc)) return 'errors';
  const isTexts = doc.axes.every((axis) => axis.isText || axis.values.length < 2);
  if (has.ratios(doc) && isTexts && doc.axes[doc.detectorAxis].values.length > 8) return 'rivals';
  if (has.times(doc)) return isSingle(doc) ? (has.cycles(doc) ? 'cycles' : 'phases') : 'times';
  return has.unsound(doc) ? 'stability' : '';
}

/** @param {import('./document.js').Doc} doc @param {(view: import('./state.js').View) => void} change */
function figuresOf(doc, change) {
  const tools = (own) => (_, view) => own(doc, view, change);
  const all = {
    times: () => createFigure({ id: 'times', describe: describeOverAxes }),
    phases: () => createFigure({ id: 'phases', describe: describePhases }),
    rivals: () => createFigure({ id: 'rivals', describe: describeRatios }),
    cycles: () => createFigure({ id: 'cycles', describe: describeCycles, tools: tools(cycleTools) }),
    distribution: () =>
      createFigure({
        id: 'distribution',
        describe: describeDistributions,
        tools: tools((d, v, c) => placeTools(d, v, c, doc.raw.distributions?.points)),
      }),
    repeats: () => createFigure({ id: 'repeats', describe: describeRepeats }),
    boundaries: () => createFigure({ id: 'boundaries', describe: describeBoundaries }),
    errors: () => createFigure({ id: 'errors', describe: describeErrors, tools: tools(errorTools) }),
    stability: () =>
      createFigure({
        id: 'stability',
        describe: describeStability,
        tools: tools((d, v, c) => (has.unsound(d) ? mapTools(d, v, c) : [])),
      }),
  };
  return Object.fromEntries(Object.entries(all).map(([name, make]) => [name, make()]));
}

/** Sections in order: [id, heading, figures and elements]. */
function sectionsOf(doc, figures, key) {
  const take = (...names) => names.filter((name) => name !== key).map((name) => figures[name]);
  const requirements = parts.requirements(doc);
  return [
    hasBoundaries(doc) && ['boundaries', boundariesTitle(doc), [...take('boundaries'), ...boundaryTable(doc)]],
    hasRaces(doc) && ['races', racesTitle(doc), raceTable(doc)],
    requirements && ['requirements', parts.requirementsTitle(doc), requirements],
    ['machine', 'What ran, and where', parts.machine(doc)],
    has.times(doc) && [
      'over-axes',
      isSingle(doc) ? 'Phases' : 'Over the axes',
      isSingle(doc) ? take('phases') : take('times', 'phases'),
    ],
    parts.budget(doc) && ['budget', parts.budgetTitle(doc), parts.budget(doc)],
    has.ratios(doc) && ['paired', 'Detectors compared', take('rivals')],
    has.errors(doc) && ['accuracy', 'Error against run time', take('errors')],
    (has.cycles(doc) || doc.raw.distributions) && [
      'over-cycles',
      'Over the cycles',
      [
        ...(has.cycles(doc) ? take('cycles') : []),
        ...(doc.raw.steady ? [h('p', { class: 'note' }, doc.raw.steady.text)] : []),
        ...(doc.raw.distributions ? take('distribution', 'repeats') : []),
      ],
    ],
    doc.count > 0 && ['soundness', 'Stability', take('stability')],
    parts.findings(doc) && ['findings', 'Pairs and contacts', parts.findings(doc)],
    parts.failures(doc) && ['failures', 'Failures', parts.failures(doc)],
    doc.count > 0 && ['left-out', 'What was left out', parts.omissions(doc)],
  ].filter((section) => section && section[2].length);
}

/**
 * @type {{doc: any, update: (view: any) => void, redraw: () => void, encode: (view: any) => string, decode: (text:
 *   string) => any} | null}
 */
let current = null;
let documents = [];
/** The results of `cdb suite`, if any, which are the first tab. */
let suite = null;
/** The results of `cdb compare`, if any, which are the first tab. */
let comparison = null;
/** The results of `cdb history`, if any, which are the only tab. */
let history = null;
/** The results of many machines, of `cdb suite --page`, if any, which are the only tab. */
let place = null;

/** The tab that the address need not name: that of the suite, the comparison, the history or the place, or the first document's. */
const firstTab = () => (suite || comparison || history || place ? -1 : 0);
const tabAddress = (index) => (index === firstTab() ? '' : `doc=${index}`);
const addressOf = (index, doc, view) => [tabAddress(index), encode(doc, view)].filter(Boolean).join('&');
const indexIn = (address) => {
  const index = Number(new URLSearchParams(address).get('doc') ?? firstTab());
  return Number.isInteger(index) && index >= 0 && index < documents.length ? index : firstTab();
};

function tabName(doc, i) {
  const sources = (doc.raw.sources ?? []).map((source) => source.file || source.benchmark);
  return short(sources.join(', ') || doc.raw.title || `Results ${i + 1}`, 48);
}

function tabs(index) {
  if (documents.length < 2 - (firstTab() < 0)) return null;
  const link = (i, name) =>
    h('a', { href: `#${tabAddress(i)}`, 'aria-current': i === index ? 'page' : null }, bdi(name));
  const links = documents.map((doc, i) =>
    link(i, suite?.scenes[i].name ?? comparison?.benchmarks[0].files[i] ?? tabName(doc, i)),
  );
  if (firstTab() < 0) links.unshift(link(-1, suite ? 'Suite' : 'Comparison'));
  return h('nav', { class: 'tabs', 'aria-label': 'Results' }, ...links);
}

/** The sidebar: the contents and the controls. */
function asideOf(links, panel) {
  const items = links.map(({ link }) => h('li', {}, link));
  const contents = h('nav', { class: 'contents', 'aria-label': 'Contents' }, h('ol', {}, ...items));
  const isWide = matchMedia('(min-width: 1100px)').matches;
  const view = panel && h('details', { open: isWide, class: 'view' }, h('summary', {}, 'View'), panel);
  return h('aside', { 'aria-label': 'View' }, contents, view);
}

/** The kind of conclusion that a figure shows. */
const answeredBy = { times: 'fastest', rivals: 'fastest', errors: 'error', stability: 'stability' };

const element = (each) => (each instanceof Node ? each : (each?.element ?? null));

const shellWord = (text) => (/^[\w./-]+$/.test(text) ? text : `'${text.replace(/'/g, "'\\''")}'`);

function bodyOf(doc, sections, key, keyElement) {
  const [above, below] = parts.conclusions(doc, answeredBy[key]);
  const heading = h('h2', { class: 'unseen' }, 'Summary');
  const generator = short(doc.raw.generator ?? 'cdb', 80);
  const file = short(doc.raw.sources?.[0]?.file ?? '', 200);
  return h(
    'div',
    { class: 'body' },
    parts.head(doc),
    parts.warnings(doc),
    h('section', { id: 'summary', 'aria-label': 'Summary' }, heading, above, keyElement, below),
    ...sections.map((each) => sectionOf(...each)),
    h(
      'footer',
      {},
      file && h('p', {}, 'The tables of this page for LaTeX: ', parts.command(`cdb show ${shellWord(file)} --all --latex`)),
      h('p', {}, `Written by ${generator}. Figures by Observable Plot and D3; their licences are below.`),
    ),
  );
}

const sectionOf = (id, title, items) =>
  h(
    'section',
    { id, 'aria-labelledby': `${id}-title`, tabindex: '-1' },
    h('h2', { id: `${id}-title` }, title),
    ...items.map(element),
  );

/** The parts of the first tab, and the command that wrote it. */
function firstParts() {
  if (place) return { ...placeParts(place), by: 'suite' };
  if (history) return { ...historyParts(history), by: 'history' };
  if (comparison) return { ...compareParts(comparison), by: 'compare' };
  return { ...suiteParts(suite, (scene) => `#${tabAddress(scene)}`), by: 'suite' };
}

/** Builds the tab of the suite, the comparison, the history or the place, which has no controls. */
function showFirst() {
  const { head, sections, by, figures = [] } = firstParts();
  const links = sections.map(([id, title]) => ({ id, link: h('a', { href: `#section=${id}` }, title) }));
  const footer = h('footer', {}, `Written by cdb ${by}.`);
  const items = [...head.filter(Boolean), ...sections.map((each) => sectionOf(...each)), footer];
  const body = h('div', { class: 'body wide' }, ...items);
  const layout = h('div', { class: 'layout' }, asideOf(links, null), body);
  page.replaceChildren(...[tabs(-1), layout].filter(Boolean));
  for (const { figure, doc } of figures) figure.update(doc, null);
  current = { index: -1, redraw: () => figures.forEach(({ figure }) => figure.redraw()) };
}

/** Builds the page of one document. */
function show(index) {
  const doc = documents[index];
  let view = decode(doc, location.hash.slice(1));
  const change = (next) => {
    location.hash = addressOf(index, doc, { ...next, section: '' }) || '!';
  };
  const key = keyFigure(doc);
  const figures = figuresOf(doc, change);
  const sections = sectionsOf(doc, figures, key);
  const links = sections.map(([id, title]) => ({ id, link: h('a', {}, title) }));
  const panel = doc.count > 0 ? h('form', { class: 'controls', submit: (event) => event.preventDefault() }) : null;
  const body = bodyOf(doc, sections, key, element(figures[key]));
  page.replaceChildren(...[tabs(index), h('div', { class: 'layout' }, asideOf(links, panel), body)].filter(Boolean));
  const drawn = Object.values(figures).filter((figure) => figure.element.isConnected);
  const plainAddress = (each) => addressOf(index, doc, { ...each, section: '' });
  let isDrawn = false;
  current = {
    doc,
    index,
    update(next) {
      const isSame = isDrawn && plainAddress(next) === plainAddress(view);
      view = next;
      isDrawn = true;
      for (const { id, link } of links)
        link.setAttribute('href', `#${addressOf(index, doc, { ...view, section: id })}`);
      if (!isSame) {
        if (panel) replaceControls(panel, controls(doc, view, change));
        for (const figure of drawn) figure.update(doc, view);
      }
      if (view.section) document.getElementById(view.section)?.scrollIntoView();
    },
    drawn,
    redraw: () => drawn.forEach((figure) => figure.redraw()),
  };
  current.update(view);
}

function follow() {
  const address = location.hash.slice(1);
  const index = indexIn(address);
  if (index < 0) {
    if (current?.index !== index) showFirst();
    const section = new URLSearchParams(address).get('section') ?? '';
    if (/^[a-z\d-]{1,40}$/.test(section)) document.getElementById(section)?.scrollIntoView();
    return;
  }
  if (!current || index !== current.index) show(index);
  else current.update(decode(current.doc, address));
}

/**
 * Replaces the page by the figures as files, for `cdb report --svg`: in ASCII, which no markup changes. The rest of the
 * address has their size, and a view as that of the page.
 */
function writeFigures() {
  const entries = new URLSearchParams(location.hash.slice(1));
  const size = sizeOf(entries.get('size') ?? 'screen');
  for (const own of ['figures', 'size']) entries.delete(own);
  const files = {};
  const unknown = unknownEntry(documents, entries.toString());
  if (unknown) files.unknown = unknown;
  documents.forEach((doc, i) => {
    show(i);
    const stem = documents.length > 1 && short(doc.raw.sources?.[0]?.file ?? '', 60).replace(/\.h5$/, '');
    for (const figure of current.drawn) {
      const file = figure.svg(size);
      if (!file) continue;
      const wanted = stem ? `${stem.replace(/[^\w-]+/g, '_')}-${file.id}` : file.name;
      let name = wanted;
      for (let n = 2; files[`${name}.svg`]; ++n) name = `${wanted}-${n}`; // files of one name
      files[`${name}.svg`] = file.text;
    }
  });
  const escaped = (unit) => `\\u${unit.charCodeAt(0).toString(16).padStart(4, '0')}`;
  const text = JSON.stringify(files).replace(/[<>&]|[^\x20-\x7e]/g, escaped);
  document.body.replaceChildren(h('pre', { id: 'figures' }, text));
}

function start() {
  const data = JSON.parse(document.getElementById('data').textContent);
  documents = (data.documents ?? []).map(openDocument);
  suite = data.suite ?? null;
  comparison = data.comparison ?? null;
  history = data.history ?? null;
  place = data.place ?? null;
  if (documents.length === 0 && !comparison && !history && !place) {
    page.replaceChildren(h('p', {}, 'This page has no results.'));
    return;
  }
  if (/^#figures(&|$)/.test(location.hash)) {
    writeFigures();
    return;
  }
  follow();
  addEventListener('hashchange', follow);
  let waiting = 0;
  new ResizeObserver(() => {
    cancelAnimationFrame(waiting);
    waiting = requestAnimationFrame(() => current?.redraw());
  }).observe(page);
  for (const query of ['(prefers-color-scheme: dark)', 'print'])
    matchMedia(query).addEventListener('change', () => current?.redraw());
  document.documentElement.dataset.ready = 'yes';
}

try {
  start();
} catch (error) {
  page.replaceChildren(h('p', { class: 'warnings' }, `The page cannot be drawn: ${error.message}`));
  throw error;
}
