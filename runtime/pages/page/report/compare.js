// The tab of `cdb compare --page`: what the terminal prints, with figures of the ratios.
import * as Plot from '@observablehq/plot';
import { bdi, h, table } from './dom.js';
import { createFigure } from './figure.js';
import { number, plural, short } from './format.js';
import { style } from './palette.js';
import { extent, labelMargin, logTicks, rowBand } from './scales.js';

const rowHeight = 22; // px
const mostPoints = 60; // with a row for each
const verdicts = {
  faster: { colour: 2, symbol: 'triangle' },
  slower: { colour: 1, symbol: 'square' },
  same: { colour: 0, symbol: 'circle' },
  'cannot tell': { colour: -1, symbol: 'circle' },
};
const inkOf = (theme, verdict) => {
  const { colour } = verdicts[verdict] ?? verdicts['cannot tell'];
  return colour < 0 ? theme.muted : theme.colours[colour];
};
const symbolOf = (verdict) => (verdicts[verdict] ?? verdicts['cannot tell']).symbol;

const legendOf = (rows, theme) =>
  Object.keys(verdicts)
    .filter((verdict) => rows.some((row) => row.verdict === verdict))
    .map((verdict) => ({
      label: verdict,
      colour: inkOf(theme, verdict),
      symbol: symbolOf(verdict),
      isHollow: verdict === 'cannot tell',
    }));

const isCounted = (comparison) => comparison.times.clock === 'instructions';
const what = (comparison) => (isCounted(comparison) ? 'Instructions' : 'Time');
const unit = (comparison) => (isCounted(comparison) ? 'instructions' : 'ns');

const columnsOf = (comparison) => [
  { key: 'phase', label: 'phase' },
  { key: 'name', label: 'of' },
  { key: 'a', label: `before, ${unit(comparison)}`, isNumber: true },
  { key: 'b', label: `after, ${unit(comparison)}`, isNumber: true },
  { key: 'value', label: 'ratio', isNumber: true },
  { key: 'low', label: 'low', isNumber: true },
  { key: 'high', label: 'high', isNumber: true },
  { key: 'verdict', label: 'verdict' },
];

const rowOf = (name, change) => ({
  name,
  phase: change.phase,
  a: change.a_ns ?? change.a_instructions,
  b: change.b_ns ?? change.b_instructions,
  value: change.ratio,
  low: change.interval[0],
  high: change.interval[1],
  verdict: change.verdict,
});

function scaleOf(values, room) {
  const [low, high] = extent([...values, 1]);
  const pad = Math.max((high / low) ** 0.06, 1.02);
  const domain = [low / pad, high * pad];
  return { type: 'log', domain, ticks: logTicks(...domain, room), tickFormat: (v) => number(v, 6) };
}

/** The ratio 1, and the ratio beyond which something is worse. */
const lines = (rule, margin, theme) => [
  rule([1], { stroke: theme.ink, strokeWidth: 1 }),
  rule([1 + margin], { stroke: theme.muted, strokeWidth: 1, strokeDasharray: '3 3' }),
];

function ratioPanel(rows, { theme, margin, x, worse, label }) {
  const ink = (row) => inkOf(theme, row.verdict);
  return ({ width, height }) => ({
    width,
    height,
    marginLeft: margin,
    marginRight: 16,
    marginTop: 4,
    marginBottom: label ? 38 : 24,
    x: { ...x, label: label || null, labelAnchor: 'right', labelArrow: 'none' },
    y: rowBand({ margin, domain: [...new Set(rows.map((row) => row.name))] }),
    marks: [
      Plot.gridX({ ticks: x.ticks, stroke: theme.grid, strokeOpacity: 1 }),
      ...lines(Plot.ruleX, worse, theme),
      Plot.ruleY(
        rows.filter((row) => row.low !== null && row.high !== null),
        { y: 'name', x1: 'low', x2: 'high', stroke: ink, strokeWidth: 2.4, strokeOpacity: 0.75 },
      ),
      Plot.dot(rows, {
        y: 'name',
        x: 'value',
        r: 4,
        className: 'hot',
        symbol: (row) => symbolOf(row.verdict),
        stroke: ink,
        strokeWidth: 1.6,
        fill: (row) => (row.verdict === 'cannot tell' ? theme.background : ink(row)),
      }),
    ],
  });
}

/** A panel for each phase, with a row for each group or point. */
function describeRows(given, { comparison, title, worse, notes, ratios }, { theme, width }) {
  const { a, b } = comparison;
  const [better, slower] = isCounted(comparison) ? ['fewer', 'more'] : ['faster', 'slower'];
  const rows = given.filter((row) => row.value > 0);
  if (rows.length === 0) return { title, empty: '' };
  const phases = [...new Set(rows.map((row) => row.phase))];
  const names = [...new Set(rows.map((row) => row.name))];
  const perRow = Math.max(1, Math.min(phases.length, Math.floor(width / 400)));
  const margin = labelMargin(names, width / perRow);
  const x = scaleOf(
    ratios,
    Math.max(3, Math.floor((width / perRow - margin) / 55)),
  );
  const ordered = phases.flatMap((phase) => rows.filter((row) => row.phase === phase));
  return {
    title,
    columns: columnsOf(comparison),
    rows: ordered,
    perRow,
    legend: legendOf(rows, theme),
    notes,
    panels: phases.map((phase, i) => {
      const own = rows.filter((row) => row.phase === phase);
      const isLast = i >= phases.length - perRow;
      const first = ordered.indexOf(own[0]);
      return {
        title: phase,
        height: new Set(own.map((row) => row.name)).size * rowHeight + (isLast ? 46 : 32),
        hot: { hot: own.map((_, k) => first + k) },
        options: ratioPanel(own, {
          theme,
          margin,
          x,
          worse,
          label: isLast ? `← ${better}   ${short(b, 24)} over ${short(a, 24)}   ${slower} →` : '',
        }),
      };
    }),
  };
}

const noteOf = (comparison, worse) => [
  isCounted(comparison)
    ? 'Bars: the noise of a count.'
    : comparison.times.has_intervals
      ? 'Bars: 95 % intervals, by bootstrap over the repeats.'
      : 'No intervals: too few repeats.',
  `Dashed: ${number(100 * worse)} % ${isCounted(comparison) ? 'more' : 'slower'}.`,
];

/** The groups of a comparison. `ratios`: that its axis shows. */
const groupFigure = (comparison, { worse, ratios }, id) =>
  createFigure({
    id,
    describe: (_, __, how) =>
      describeRows(
        comparison.times.groups.flatMap(({ name, phases }) => phases.map((change) => rowOf(name, change))),
        {
          title: `${what(comparison)} of a cycle: ${short(comparison.b, 40)} over ${short(comparison.a, 40)}`,
          comparison,
          worse,
          ratios,
          notes: [
            comparison.times.groups.some((group) => group.points > 1) &&
              `Geometric means over the points of each ${comparison.times.group ?? 'group'}.`,
            ...noteOf(comparison, worse),
          ].filter(Boolean),
        },
        how,
      ),
  });

const placeText = (place) =>
  Object.entries(place)
    .map(([axis, value]) => `${axis} ${value}`)
    .join(', ');

/** The points, in the phase by which the groups change the most. */
const pointFigure = (comparison, { worse, ratios }, id) =>
  createFigure({
    id,
    describe: (_, __, how) => {
      const all = comparison.times.points.flatMap(({ point, phases }) =>
        phases.map((change) => rowOf(placeText(point), change)),
      );
      const phases = all.map((row) => row.phase);
      const phase = phases.includes('step') ? 'step' : phases[0];
      const own = all.filter((row) => row.phase === phase && row.value > 0);
      const size = (row) => Math.abs(Math.log(row.value));
      const largest = [...own].sort((p, q) => size(q) - size(p)).slice(0, mostPoints);
      const rows = own.filter((row) => largest.includes(row));
      return describeRows(
        rows,
        {
          title: `Each point: ${phase} in ${short(comparison.b, 40)} over ${short(comparison.a, 40)}`,
          comparison,
          worse,
          ratios,
          notes: [
            rows.length < own.length && `The ${rows.length} largest of ${own.length} changes.`,
            ...noteOf(comparison, worse),
          ].filter(Boolean),
        },
        how,
      );
    },
  });

/** Each file relative to the first; a file is a place on the x axis. */
function historyRows(benchmark) {
  const toFirst = [benchmark.comparisons[0], ...(benchmark.relative_to_the_first ?? [])];
  const phaseOf = (group) => (group.phases.find((each) => each.phase === 'step') ?? group.phases[0])?.phase;
  const rows = [];
  for (const { name, phases } of toFirst[0].times.groups) {
    const phase = phaseOf({ phases });
    rows.push({ name, phase, file: 0, value: 1, low: null, high: null, verdict: 'same' });
    toFirst.forEach((comparison, i) => {
      const group = comparison.times.groups.find((each) => each.name === name);
      const change = group?.phases.find((each) => each.phase === phase);
      if (change && change.ratio > 0) rows.push({ ...rowOf(name, change), file: i + 1 });
    });
  }
  return rows;
}

const historyFigure = (benchmark, { worse, historyRatios }, id) =>
  createFigure({
    id,
    describe: (_, __, { theme }) => {
      const found = historyRows(benchmark);
      const title = `${what(benchmark.comparisons[0])} of a cycle over that of ${short(benchmark.files[0], 40)}`;
      if (found.length === 0) return { title, empty: '' };
      const names = [...new Set(found.map((row) => row.name))];
      // Intervals of one file must not hide each other.
      const shift = (name) => (names.indexOf(name) - (names.length - 1) / 2) * Math.min(0.05, 0.4 / names.length);
      const rows = found.map((row) => ({
        ...row,
        of: short(benchmark.files[row.file], 40),
        place: row.file + shift(row.name),
      }));
      const y = scaleOf(historyRatios, 7);
      const ink = (row) => style(theme, names.indexOf(row.name)).colour;
      const at = { x: 'place', y: 'value', stroke: ink };
      return {
        title,
        columns: [{ key: 'of', label: 'file' }, ...columnsOf(benchmark.comparisons[0])],
        rows,
        height: 320,
        legend: names.map((label, i) => {
          const { colour, symbol } = style(theme, i);
          return { label, colour, symbol, dash: null };
        }),
        notes: [
          `Of ${rows[0].phase}. Hollow: not certain to have changed, or the same.`,
          ...noteOf(benchmark.comparisons[0], worse),
        ],
        panels: [
          {
            title: '',
            hot: { hot: rows.map((_, i) => i) },
            options: ({ width, height }) => ({
              width,
              height,
              marginLeft: 52,
              marginBottom: 36,
              x: {
                type: 'linear',
                domain: [-0.3, benchmark.files.length - 0.7],
                ticks: benchmark.files.map((_, i) => i),
                tickFormat: (i) => short(benchmark.files[i], Math.max(6, Math.floor(width / benchmark.files.length / 8))),
                label: null,
              },
              y: { ...y, label: 'ratio', labelArrow: 'none' },
              marks: [
                Plot.gridY({ ticks: y.ticks, stroke: theme.grid, strokeOpacity: 1 }),
                ...lines(Plot.ruleY, worse, theme),
                Plot.line(rows, { ...at, z: 'name', strokeWidth: 1.75 }),
                Plot.ruleX(
                  rows.filter((row) => row.low !== null && row.high !== null),
                  { x: 'place', y1: 'low', y2: 'high', stroke: ink, strokeWidth: 1.5, strokeOpacity: 0.7 },
                ),
                Plot.dot(rows, {
                  ...at,
                  r: 4,
                  className: 'hot',
                  symbol: (row) => style(theme, names.indexOf(row.name)).symbol,
                  fill: (row) => (['faster', 'slower'].includes(row.verdict) ? ink(row) : theme.background),
                }),
              ],
            }),
          },
        ],
      };
    },
  });

const linesOf = (list) => {
  const items = [];
  // A line that begins with spaces continues the one above.
  for (const line of list) {
    if (/^\s/.test(line) && items.length) items[items.length - 1] += ` ${line.trim()}`;
    else items.push(line);
  }
  return items;
};

/** A section of the terminal. */
export function sectionItems({ lines: list, columns: heads, rows, notes }) {
  const items = linesOf(list).map((line) => h('li', {}, bdi(line)));
  return [
    items.length ? h('ul', { class: 'findings' }, ...items) : null,
    rows.length ? table(heads.map(({ label, is_number }) => ({ label, isNumber: is_number })), rows, 'Comparison') : null,
    ...linesOf(notes).map((note) => h('p', { class: 'note' }, bdi(note))),
  ].filter(Boolean);
}

/** The figures of a benchmark. `prefix`: of the ids of its elements. */
function figuresOf(benchmark, axes, prefix) {
  if (benchmark.comparisons.length > 1) return [historyFigure(benchmark, axes, `${prefix}history`)];
  const [comparison] = benchmark.comparisons;
  const { groups, points } = comparison.times;
  return [
    groups.length && groupFigure(comparison, axes, `${prefix}groups`),
    points.length > groups.length && pointFigure(comparison, axes, `${prefix}points`),
  ].filter(Boolean);
}

const rangeOf = ({ value, low, high }) => [value, low, high];

/** What all axes of the page show, so that lengths can be compared between benchmarks. */
function axesOf({ benchmarks, fail_above: limits }) {
  const worse = limits.slower;
  const changes = benchmarks.flatMap(({ comparisons: [{ times }] }) =>
    [...times.groups, ...times.points].flatMap(({ phases }) => phases.map((change) => rowOf('', change))),
  );
  const ratios = changes.filter((row) => row.value > 0).flatMap(rangeOf);
  const history = benchmarks.filter(({ comparisons }) => comparisons.length > 1).flatMap(historyRows);
  return { worse, ratios: [...ratios, 1 + worse], historyRatios: [...history.flatMap(rangeOf), 1 + worse] };
}

function head(comparison) {
  const { names, benchmarks } = comparison;
  const title =
    benchmarks.length === 1
      ? benchmarks[0].title || benchmarks[0].benchmark
      : plural(benchmarks.length + comparison.other_scenes.length, 'benchmark');
  return h(
    'header',
    {},
    h('p', { class: 'kind' }, 'Comparison'),
    h('h1', {}, bdi(short(title, 200))),
    h('p', { class: 'sweep' }, 'From ', bdi(names.map((name) => short(name, 80)).join(' to '))),
  );
}

function warnings(comparison) {
  const missing =
    comparison.unmatched.length > 0 && `Not compared, because not in all folders: ${comparison.unmatched.join(', ')}.`;
  const list = [comparison.is_worse && comparison.headline, missing].filter(Boolean);
  return list.length
    ? h('ul', { class: 'warnings' }, ...list.map((text) => h('li', { class: 'warning' }, bdi(short(text, 1000)))))
    : null;
}

/**
 * The head, the sections as [id, heading, items], and the figures, with what they draw.
 * @param {any} comparison  of the data of the page
 */
export function compareParts(comparison) {
  const sections = comparison.sections.map((each, i) => [`all-${i}`, each.title, sectionItems(each)]);
  const figures = [];
  const axes = axesOf(comparison);
  comparison.benchmarks.forEach((benchmark, b) => {
    const doc = { raw: { sources: [{ benchmark: benchmark.benchmark }] } };
    const name = comparison.benchmarks.length > 1 ? `${short(benchmark.files[0].split('/').at(-1), 60)}: ` : '';
    const own = figuresOf(benchmark, axes, `b${b}-`);
    figures.push(...own.map((figure) => ({ figure, doc })));
    const texts = benchmark.sections.map((each, i) => [
      `b${b}-${i}`,
      i === 0 ? `${name}What was compared` : name + each.title,
      sectionItems(each),
    ]);
    // The first sections are what a reader must know before any figure, and the summary.
    texts.splice(2, 0, ...(own.length ? [[`b${b}-times`, `${name}Ratios of times`, own]] : []));
    sections.push(...texts);
  });
  return { head: [head(comparison), warnings(comparison)], sections, figures };
}
