// The tab of `cdb history --page`: what the terminal prints, with a small figure of each series over the files.
import * as Plot from '@observablehq/plot';
import { sectionItems } from './compare.js';
import { bdi, h } from './dom.js';
import { createFigure } from './figure.js';
import { byteUnit, number, plural, short, timeUnit } from './format.js';
import { extent } from './scales.js';

const mostPanels = 36; // of a figure
const panelHeight = 132; // px

const isMemory = (series) => series.figure === 'peak_rss';
const isCount = (series) => series.figure.endsWith('_instructions');
const figureText = (series) => (isMemory(series) ? 'peak memory' : series.figure.replace('_instructions', ''));
const pointText = (series) => series.point || 'the only point';
/** @param {number} most  @returns {import('./format.js').Unit} */
const countUnit = (most) => {
  if (most >= 1e6) return { unit: 'million instructions', factor: 1e6 };
  return most >= 1e4 ? { unit: 'thousand instructions', factor: 1e3 } : { unit: 'instructions', factor: 1 };
};
const unitFor = (series, most) => (isMemory(series) ? byteUnit : isCount(series) ? countUnit : timeUnit)(most);

/** The mean of the values between two changes; a level is a line there. */
function levelsOf(series) {
  const last = series.values.length - 1;
  const bounds = [];
  let begin = 0;
  for (const { kind, from, to } of series.changes) {
    bounds.push({ begin, end: from });
    if (kind === 'drift') bounds.push({ begin: from, end: to, isRamp: true });
    begin = to;
  }
  bounds.push({ begin, end: last });
  const meanOf = ({ begin: first, end }) => {
    const own = series.values.slice(first, end + 1).filter((value) => value !== null);
    return Math.exp(own.reduce((sum, value) => sum + Math.log(value), 0) / own.length);
  };
  return bounds.flatMap((bound, i) => {
    if (!bound.isRamp) return [{ x1: bound.begin, x2: bound.end, y1: meanOf(bound), y2: meanOf(bound) }];
    return [{ x1: bound.begin, x2: bound.end, y1: meanOf(bounds[i - 1]), y2: meanOf(bounds[i + 1]) }];
  });
}

/** Ticks at a few files, by their labels. */
function fileTicks(history, width) {
  const count = history.files.length;
  const widest = Math.max(...history.files.map(({ label }) => Math.min([...label].length, 9)));
  const room = Math.max(1, Math.floor(width / (widest * 6.5 + 10)));
  const stride = Math.max(1, Math.ceil(count / room));
  return Array.from({ length: Math.ceil(count / stride) }, (_, i) => i * stride);
}

const changeInk = (theme, change) => (change.ratio > 1 ? theme.colours[1] : theme.colours[2]);

function seriesPanel(history, series, theme, rows, first) {
  const values = rows.map((row) => row.value);
  const unit = unitFor(series, extent(values)[1]);
  const shown = rows.map((row) => ({ ...row, value: row.value / unit.factor }));
  const levels = levelsOf(series).map((level) => ({ ...level, y1: level.y1 / unit.factor, y2: level.y2 / unit.factor }));
  const [low, high] = extent(shown.map((row) => row.value));
  // Noise of a few per cent must not look like a change.
  const pad = Math.max(0.12 * (high - low), 0.03 * high);
  const changes = series.changes.map((change) => ({ ...change, middle: (change.from + change.to) / 2 }));
  const steps = changes.filter(({ kind }) => kind === 'step');
  const drifts = changes.filter(({ kind }) => kind === 'drift');
  const motions = history.motions.map(({ from, to }) => (indexOf(history, from) + indexOf(history, to)) / 2);
  return {
    title: `${figureText(series)}, ${unit.unit} · ${pointText(series)}`,
    height: panelHeight,
    hot: { hot: rows.map((_, i) => first + i) },
    options: ({ width, height }) => ({
      width,
      height,
      marginLeft: 44,
      marginRight: 8,
      marginTop: 8,
      marginBottom: 22,
      x: {
        type: 'linear',
        domain: [-0.5, history.files.length - 0.5],
        ticks: fileTicks(history, width - 52),
        tickFormat: (i) => short(history.files[i]?.label ?? '', 9),
        label: null,
      },
      y: {
        type: 'linear',
        domain: [Math.max(0, low - pad), high + pad],
        ticks: 4,
        tickFormat: (v) => number(v, 4),
        label: null,
      },
      marks: [
        Plot.gridY({ ticks: 4, stroke: theme.grid, strokeOpacity: 1 }),
        Plot.rectX(drifts, {
          x1: 'from',
          x2: 'to',
          fill: (change) => changeInk(theme, change),
          fillOpacity: 0.14,
        }),
        Plot.ruleX(motions, { stroke: theme.muted, strokeDasharray: '2 3' }),
        Plot.ruleX(steps, { x: 'middle', stroke: (change) => changeInk(theme, change), strokeWidth: 1.6 }),
        Plot.link(levels, { x1: 'x1', x2: 'x2', y1: 'y1', y2: 'y2', stroke: theme.ink, strokeWidth: 1.4, strokeOpacity: 0.7 }),
        Plot.dot(shown, { x: 'file', y: 'value', r: 2.4, className: 'hot', fill: theme.colours[0], stroke: null }),
      ],
    }),
  };
}

const indexOf = (history, label) => history.files.findIndex((file) => file.label === label);

const columns = [
  { key: 'figure', label: 'of' },
  { key: 'point', label: 'point' },
  { key: 'label', label: 'file' },
  { key: 'day', label: 'measured' },
  { key: 'subject', label: 'commit' },
  { key: 'value', label: 'value (ns, bytes or instructions)', isNumber: true },
];

const rowsOf = (history, series) =>
  series.values.flatMap((value, file) =>
    value === null
      ? []
      : [
          {
            figure: figureText(series),
            point: pointText(series),
            file,
            label: history.files[file].label,
            day: history.files[file].day,
            subject: history.files[file].subject ?? '',
            value,
          },
        ],
  );

/** How much a series changed in all. */
const sizeOf = (series) => Math.max(0, ...series.changes.map(({ ratio }) => Math.abs(Math.log(ratio))));

const legendOf = (history, list, theme) => {
  const changes = list.flatMap((series) => series.changes);
  return [
    { label: 'a file', colour: theme.colours[0], symbol: 'circle' },
    { label: 'level', colour: theme.ink, dash: null },
    changes.some(({ ratio }) => ratio > 1) && { label: 'slower, or more', colour: theme.colours[1], dash: null },
    changes.some(({ ratio }) => ratio < 1) && { label: 'faster, or less', colour: theme.colours[2], dash: null },
    changes.some(({ kind }) => kind === 'drift') && { label: 'drift', colour: theme.faint, isArea: true },
    history.motions.length > 0 && { label: 'other motion', colour: theme.muted, dash: '2 3' },
  ].filter(Boolean);
};

/** The series of a history, as panels; those that changed most are the first. */
const seriesFigure = (history, given, title, id) =>
  createFigure({
    id,
    describe: (_, __, { theme, width }) => {
      const list = [...given].sort((p, q) => sizeOf(q) - sizeOf(p)).slice(0, mostPanels);
      if (list.length === 0) return { title, empty: '' };
      const rows = [];
      const panels = list.map((series) => {
        const first = rows.length;
        const own = rowsOf(history, series);
        rows.push(...own);
        return seriesPanel(history, series, theme, own, first);
      });
      return {
        title,
        columns: columns.filter(({ key }) => key !== 'subject' || history.files.some((file) => file.subject)),
        rows,
        perRow: Math.max(1, Math.floor(width / 330)),
        legend: legendOf(history, list, theme),
        notes: [
          `From ${history.files[0].label} to ${history.files.at(-1).label}, ${plural(history.files.length, 'file')}.`,
          list.length < given.length && `The first ${list.length} of ${given.length} series, the largest changes first.`,
        ].filter(Boolean),
        panels,
      };
    },
  });

/** The heading of a history; with the machine, if there are several. */
const nameOf = (all, history) =>
  all.histories.length > 1 ? `${short(history.title, 60)}: ${short(history.machine, 60)}` : short(history.title, 100);

function head(all) {
  const different = (key) => new Set(all.histories.map((history) => history[key])).size;
  const files = all.histories.reduce((sum, { files: own }) => sum + own.length, 0);
  return h(
    'header',
    {},
    h('p', { class: 'kind' }, 'History'),
    h('h1', {}, bdi(short(all.folder, 200))),
    h('p', { class: 'sweep' }, `${plural(files, 'file')} of ${plural(different('benchmark'), 'benchmark')} on ${plural(different('machine'), 'machine')}`),
  );
}

function warnings(all) {
  const worse = all.histories.filter(({ is_worse: isWorse }) => isWorse);
  return worse.length
    ? h('ul', { class: 'warnings' }, ...worse.map((each) => h('li', { class: 'warning' }, bdi(`Worse than allowed: ${nameOf(all, each)}`))))
    : null;
}

/**
 * The head, the sections as [id, heading, items], and the figures, with what they draw.
 * @param {any} all  of the data of the page
 */
export function historyParts(all) {
  const figures = [];
  const sections = all.histories.map((history, i) => {
    const doc = { raw: { sources: [{ benchmark: history.benchmark }] } };
    const changed = history.series.filter((series) => series.changes.length > 0);
    const others = history.series.filter((series) => series.changes.length === 0);
    const own = [
      changed.length && seriesFigure(history, changed, 'Series that changed', `h${i}-changed`),
      others.length && seriesFigure(history, others, 'Series without a change', `h${i}-others`),
    ].filter(Boolean);
    figures.push(...own.map((figure) => ({ figure, doc })));
    // The curves of the terminal are drawn below.
    const items = sectionItems({ ...history.section, columns: [], rows: [] });
    return [`h${i}`, nameOf(all, history), [...items, ...own]];
  });
  sections.push(['files', 'Files', sectionItems(all.section)]);
  return { head: [head(all), warnings(all)], sections, figures };
}
