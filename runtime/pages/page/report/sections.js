// The parts of the page that are text: the head, the machine, and the tables.
import { pointText } from './document.js';
import { bdi, h, table } from './dom.js';
import { count, number, plural, range, short, timeUnit } from './format.js';

const certainties = { clear: 'clear', tie: 'a tie', unknown: 'not certain', fault: 'unsound' };
const conclusionsAbove = 3; // number above the first figure
const mostAlike = 2; // conclusions of one form in sentences; more are a table

/** `4 values of detector × 2 of quantity × 9 repeats, 300 cycles` */
export function sweepText(doc) {
  const { runs = {} } = doc.raw;
  const parts = doc.axes
    .filter((axis) => axis.values.length > 1)
    .map((axis, i) => `${axis.values.length} ${i === 0 ? 'values of' : 'of'} ${short(axis.name, 60)}`);
  if (runs.repeats > 1) parts.push(`${runs.repeats} repeats`);
  const cycles = [...new Set(doc.raw.points?.cycles === undefined ? [] : [].concat(doc.raw.points.cycles))].filter(
    (value) => typeof value === 'number',
  );
  const length =
    cycles.length === 1
      ? `, ${plural(cycles[0], 'cycle')}${(runs.all ?? doc.count) > 1 ? ' each' : ''}`
      : cycles.length > 1
        ? `, ${count(Math.min(...cycles))} to ${count(Math.max(...cycles))} cycles`
        : '';
  return `${plural((runs.all ?? doc.count) - (runs.skipped ?? 0), 'run')}${parts.length ? `: ${parts.join(' × ')}` : ''}${length}`;
}

function outcomes(doc) {
  const { runs = {} } = doc.raw;
  return [
    ['good', doc.phases.length > 0 ? 'timed' : 'finished'],
    ['void', 'void'],
    ['failed', 'failed'],
    ['skipped', doc.raw.boundaries || doc.raw.races ? 'not needed' : 'skipped'],
    ['missing', 'missing'],
  ]
    .filter(([key]) => runs[key])
    .map(([key, word]) => `${count(runs[key])} ${word}`)
    .join(', ');
}

export function head(doc) {
  const { raw } = doc;
  const sources = (raw.sources ?? []).map((source) => source.file).filter(Boolean);
  return h(
    'header',
    {},
    h('p', { class: 'kind' }, 'Benchmark report', sources.length ? ' · ' : '', bdi(short(sources.join(', '), 200))),
    h('h1', {}, bdi(raw.title || raw.sources?.[0]?.title || raw.sources?.[0]?.benchmark || 'Results')),
    h(
      'p',
      { class: 'sweep' },
      sweepText(doc),
      outcomes(doc) ? h('span', { class: 'outcome' }, ` · ${outcomes(doc)}`) : null,
    ),
  );
}

export function warnings(doc) {
  const list = doc.raw.warnings ?? [];
  if (list.length === 0) return null;
  return h(
    'ul',
    { class: 'warnings', 'aria-label': 'Warnings' },
    ...list.map((warning) =>
      h(
        'li',
        {
          class: 'warning',
        },
        bdi(warning.text),
      ),
    ),
  );
}

const answers = (list) =>
  h(
    'dl',
    { class: 'conclusions' },
    ...list.map((each) =>
      h(
        'div',
        { class: each.certainty in certainties ? each.certainty : 'unknown' },
        h('dt', {}, bdi(each.question)),
        h(
          'dd',
          {},
          bdi(each.answer),
          ' ',
          h('span', { class: 'certainty' }, certainties[each.certainty] ?? short(each.certainty ?? '', 20)),
        ),
      ),
    ),
  );

/** Alike conclusions, on a ratio along each axis, as a table. */
function effects(doc, list) {
  const interval = ({ low, high }) => (low === null ? 'unknown' : range(low, high));
  return table(
    [
      { label: 'axis' },
      { label: 'from' },
      { label: 'to' },
      { label: 'step, times', isNumber: true },
      { label: doc.raw.interval?.name ?? 'interval', isNumber: true },
    ],
    list.map(({ effect }) => [effect.axis, effect.from, effect.to, number(effect.ratio), interval(effect)]),
    'How the time of a step changes along each axis',
  );
}

/**
 * The conclusions above and below the first figure. Those on the race and the budget of the scenario come first, then the
 * one that the figure shows.
 */
export function conclusions(doc, kind) {
  const given = doc.raw.conclusions ?? [];
  const shown = given.find((each) => each.kind === kind);
  const isFirst = (each) => ['race', 'budget'].includes(each.kind);
  const rest = given.filter((each) => each !== shown && !isFirst(each));
  const list = [...given.filter(isFirst), ...(shown ? [shown] : []), ...rest];
  if (list.length === 0)
    return [
      doc.count === 0
        ? h('p', { class: 'note' }, 'The file has no run with results, and nothing can be concluded.')
        : null,
      null,
    ];
  const alike = list.filter((each) => each.effect);
  const shownAlone = alike.length > mostAlike ? list.filter((each) => !each.effect) : list;
  const below = shownAlone.slice(conclusionsAbove);
  return [
    answers(shownAlone.slice(0, conclusionsAbove)),
    h('div', {}, below.length > 0 ? answers(below) : null, alike.length > mostAlike ? effects(doc, alike) : null),
  ];
}

const words = (key) => short(key.replace(/_/g, ' '), 60);

/** A value of the provenance as text; bytes and lists included. */
function valueNode(value) {
  if (value === null || value === undefined || value === '') return '–';
  if (Array.isArray(value))
    return value.length > 12
      ? `${value
          .slice(0, 12)
          .map((each) => (typeof each === 'number' ? number(each) : String(each)))
          .join(', ')}, …`
      : value
          .map((each) =>
            typeof each === 'number' ? number(each) : typeof each === 'object' ? JSON.stringify(each) : String(each),
          )
          .join(', ');
  if (typeof value === 'object')
    return Object.entries(value)
      .map(([key, each]) => `${words(key)} ${valueNode(each)}`)
      .join('; ');
  const kilobytes = /^(\d+) kB$/.exec(value);
  if (kilobytes) return `${number((Number(kilobytes[1]) * 1024) / 1e9)} GB`;
  const kilohertz = /^(\d+) kHz$/.exec(value);
  if (kilohertz) return `${number(Number(kilohertz[1]) / 1e6)} GHz`;
  return typeof value === 'number' ? count(value) : typeof value === 'boolean' ? (value ? 'yes' : 'no') : String(value);
}

function facts(title, object) {
  const entries = Object.entries(object ?? {}).filter(([, value]) => value !== null && value !== '' && !isLong(value));
  if (entries.length === 0) return null;
  return h(
    'div',
    {},
    h('h3', {}, title),
    h(
      'dl',
      { class: 'facts' },
      ...entries.flatMap(([key, value]) => [h('dt', {}, words(key)), h('dd', {}, bdi(valueNode(value)))]),
    ),
  );
}

const isLong = (value) => typeof value === 'string' && (value.includes('\n') || value.length > 400);

/** Texts of several lines, such as the scenario. */
function longTexts(object) {
  return Object.entries(object ?? {})
    .filter(([, value]) => isLong(value))
    .map(([key, value]) =>
      h('details', { class: 'text' }, h('summary', {}, words(key)), h('pre', { tabindex: '0' }, bdi(value))),
    );
}

/** The definition of each phase. */
function phaseTexts(doc) {
  const defined = doc.phases.filter((phase) => phase.definition);
  if (defined.length === 0) return null;
  return h(
    'details',
    { class: 'text' },
    h('summary', {}, 'phases of a cycle'),
    h(
      'dl',
      { class: 'facts' },
      ...defined.flatMap((phase) => [h('dt', {}, phase.name), h('dd', {}, bdi(phase.definition))]),
    ),
  );
}

const judgements = {
  quiet: 'The machine was quiet.',
  noisy: 'The machine was noisy.',
  unknown: 'How quiet the machine was is not recorded.',
};

/** Sentences to quote in a paper. */
function methodTexts(doc) {
  const text = [].concat(doc.raw.method ?? []).join(' ');
  return text ? [h('h3', {}, 'Method, in the words of a paper'), h('p', { class: 'method' }, bdi(text))] : [];
}

export function machine(doc) {
  const { noise = {}, machine: host, build, provenance } = doc.raw;
  const said = new Set((doc.raw.warnings ?? []).map((warning) => warning.text));
  const lines = [].concat(noise.text ?? []).filter((line) => line && !said.has(line));
  const judgement = judgements[noise.judgement] ?? judgements.unknown;
  return [
    h(
      'p',
      { class: `judgement ${noise.judgement in judgements ? noise.judgement : 'unknown'}` },
      judgement,
      lines.length ? ' ' : '',
      bdi(lines.map((line) => String(line).trim()).join(' ')),
    ),
    ...methodTexts(doc),
    h('div', { class: 'columns' }, facts('Machine', host), facts('Build', build), facts('Run', provenance)),
    phaseTexts(doc),
    ...longTexts(provenance),
  ].filter(Boolean);
}

const mostPlaces = 500;

/** The number of points of an omission, and the points. */
function places(doc, row) {
  const text = row.of ? `${count(row.points)} of ${count(row.of)}` : count(row.points);
  const points = (row.at ?? []).filter((p) => p < doc.count);
  if (points.length === 0 || points.length === doc.count) return text;
  const items = points.slice(0, mostPlaces).map((p) => h('li', {}, bdi(pointText(doc, p))));
  return h('details', {}, h('summary', {}, text), h('ul', { class: 'places' }, ...items));
}

export function omissions(doc) {
  const list = doc.raw.omissions ?? [];
  if (list.length === 0)
    return [h('p', { class: 'note' }, 'Nothing was left out: every point ran all parts of the engine.')];
  const columns = [
    'left out',
    'points',
    'why',
    ...(list.some((row) => row.changes) ? ['not included in the figures'] : []),
  ];
  const rows = list.map((row) => [row.parts, places(doc, row), row.why, row.changes ?? null].slice(0, columns.length));
  return [
    table(
      columns.map((label) => ({ label })),
      rows,
      'Parts that were left out',
    ),
  ];
}

/** Rows of counts; the first column is a name. Faults are emphasised. */
function comparedTable(list, columns, caption) {
  const keys = columns.filter((key) => list.some((row) => row[key] !== undefined));
  return table(
    keys.map((key, i) => ({ label: key.replace(/_/g, ' '), isNumber: i > 0 })),
    list.map((row) =>
      keys.map((key) => {
        const text = typeof row[key] === 'number' ? count(row[key]) : (row[key] ?? null);
        return ['missed', 'duplicate', 'wrong_runs'].includes(key) && row[key] > 0 ? h('strong', {}, text) : text;
      }),
    ),
    caption,
  );
}

export function findings(doc) {
  const list = doc.raw.findings ?? [];
  if (list.length === 0) return null;
  const contacts = doc.raw.contact_findings ?? [];
  return [
    comparedTable(
      list,
      ['detector', 'cycles', 'exact', 'missed', 'false_positives', 'duplicate', 'wrong_runs'],
      'Pairs compared with exact ones',
    ),
    ...(contacts.length > 0
      ? [
          comparedTable(
            contacts,
            ['narrow_phase', 'cycles', 'compared', 'of', 'missed'],
            'Contacts compared with exact ones',
          ),
        ]
      : []),
    h(
      'p',
      { class: 'note' },
      'Pairs of each cycle, compared with exact ones. ' +
        'A detector that misses pairs does less work, so that its times do not compare.',
    ),
  ];
}

async function copy(text) {
  try {
    await navigator.clipboard.writeText(text);
    return true;
  } catch {
    const area = h('textarea', { 'aria-hidden': 'true', class: 'copied' });
    area.value = text;
    document.body.append(area);
    area.select();
    const done = document.execCommand('copy');
    area.remove();
    return done;
  }
}

export function command(text) {
  const button = h('button', { type: 'button', class: 'copy', 'aria-label': `Copy ${short(text, 80)}` }, 'Copy');
  button.addEventListener('click', async () => {
    button.textContent = (await copy(text)) ? 'Copied' : 'Select it';
    setTimeout(() => {
      button.textContent = 'Copy';
    }, 1500);
  });
  return h('span', { class: 'command' }, h('code', {}, bdi(text)), button);
}

/** The heading of the budget. */
export const budgetTitle = (doc) => `Within the budget of ${doc.raw.budget.text} (99th percentile)`;

/** The points against the budget of the scenario. */
export function budget(doc) {
  const { budget: found } = doc.raw;
  if (!found) return null;
  const { unit, factor } = timeUnit(Math.max(...found.points.map((each) => each.ns)));
  const time = (ns) => number(ns / factor);
  const isNoisy = (each) => (each.at_least ?? null) !== null;
  const fits = (each) => (each.fits === 'cannot tell' && isNoisy(each) ? 'cannot tell: noisy' : each.fits);
  const hasIntervals = found.points.some((each) => each.low !== null);
  const columns = [
    ['configuration', (each) => pointText(doc, each.point) || 'the only one'],
    found.ns === null && [`budget, ${unit}`, (each) => time(each.ns)],
    ['cycles above', (each) => count(each.above)],
    ['of', (each) => count(each.cycles)],
    [`99th percentile, ${unit}`, (each) => time(each.p99)],
    hasIntervals && [doc.raw.interval?.name ?? 'interval', (each) => range(each.low / factor, each.high / factor)],
    found.points.some(isNoisy) && [`at least, ${unit}`, (each) => (isNoisy(each) ? time(each.at_least) : '-')],
    [`worst, ${unit}`, (each) => time(each.worst)],
    ['fits', (each) => (each.fits === 'yes' ? 'yes' : h('strong', {}, fits(each)))],
  ].filter(Boolean);
  return [
    table(
      columns.map(([label]) => ({ label, isNumber: !['configuration', 'fits'].includes(label) })),
      found.points.map((each) => columns.map(([, cell]) => cell(each))),
      'Steps against the budget',
    ),
    h(
      'p',
      { class: 'note' },
      `A configuration fits if the 99th percentile of the times of its cycles${hasIntervals ? ', with its interval,' : ''} `,
      'is within the budget. The worst is the longest cycle of any repeat, disturbances included.',
      found.points.some(isNoisy)
        ? ' At least: on a noisy machine, which only adds time, the 99th percentile of the fastest repeat of each cycle ' +
            '(the median if there is one repeat). Only above the budget is the answer no.'
        : '',
    ),
  ];
}

/** The heading of the requirements: how many are met. */
export function requirementsTitle(doc) {
  const all = requirementsOf(doc);
  const met = all.filter((each) => each.answer === 'met').length;
  return met === all.length ? 'Requirements: all met' : `Requirements: ${met} of ${all.length} met`;
}

/** Those of `require`, with the budget if there is one; none if the budget is the only one. */
function requirementsOf(doc) {
  const all = doc.raw.requirements ?? [];
  return all.every((each) => each.budget) ? [] : all;
}

/** The requirements of the scenario, and the points that do not meet them. */
export function requirements(doc) {
  const all = requirementsOf(doc);
  if (all.length === 0) return null;
  const emphasis = (answer) => (answer === 'met' ? answer : h('strong', {}, answer));
  const rows = table(
    [
      { label: 'requirement' },
      { label: 'answer' },
      ...['met', 'not met', 'cannot tell'].map((label) => ({ label, isNumber: true })),
    ],
    all.map((each) => [
      h('code', {}, bdi(each.text)),
      emphasis(each.answer),
      count(each.met),
      count(each.not_met),
      count(each.cannot_tell),
    ]),
    'Requirements of the scenario',
  );
  const open = all.flatMap((each) =>
    each.points
      .filter((point) => point.answer !== 'met')
      .map((point) => [
        h('code', {}, bdi(each.text)),
        pointText(doc, point.point) || 'the only one',
        emphasis(point.answer),
        point.text,
      ]),
  );
  if (open.length === 0) return [rows];
  const points = table(
    [{ label: 'requirement' }, { label: 'configuration' }, { label: 'answer' }, { label: 'figure' }],
    open.slice(0, mostFailures),
    'Points that do not meet a requirement',
  );
  const more = open.length - mostFailures;
  const head = h('p', { class: 'note' }, 'Where one is not met, or that cannot be told:');
  return [rows, head, points, more > 0 ? h('p', { class: 'note' }, `And ${more} more: cdb show --json.`) : null].filter(
    Boolean,
  );
}

const mostFailures = 200;

export function failures(doc) {
  const list = doc.raw.failures ?? [];
  if (list.length === 0) return null;
  const causes = Map.groupBy(list, (row) => row.why);
  const runs = (rows) => {
    if (rows.length === 1) return rows[0].place;
    const items = rows.slice(0, mostPlaces).map((row) => h('li', {}, bdi(row.place)));
    return h('details', {}, h('summary', {}, plural(rows.length, 'run')), h('ul', { class: 'places' }, ...items));
  };
  return [
    table(
      [{ label: 'why' }, { label: 'run' }, { label: 'replay the first' }],
      [...causes]
        .slice(0, mostFailures)
        .map(([why, rows]) => [why, runs(rows), rows[0].command ? command(rows[0].command) : null]),
      'Failed runs, by cause',
    ),
    causes.size > mostFailures
      ? h('p', { class: 'note' }, `The first ${mostFailures} of ${count(causes.size)} causes.`)
      : null,
  ];
}
