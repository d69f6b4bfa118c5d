// The time of each detector over that of the baseline at the same point.
import * as Plot from '@observablehq/plot';
import { quantities, valueText } from './document.js';
import { number, short } from './format.js';
import { style } from './palette.js';
import { entriesOf, noTable } from './pooled.js';
import { extent, fixedText, intervalText, labelMargin, logTicks, rowBand } from './scales.js';

const mostFacets = 6;
const mostRows = 60;
const rowHeight = 22;

const phaseOfRatios = (doc, view) => {
  const phases = Object.keys(doc.raw.ratios.phases ?? {});
  const wanted = view.quantity.split(':')[1];
  return phases.includes(wanted) ? wanted : phases.includes('step') ? 'step' : phases[0];
};

/**
 * The axis whose values make groups of rows: the first of x, colours and panels that is not the axis of detectors and
 * has few values; -1 if there is none.
 */
function facetAxis(doc, view) {
  for (const role of ['x', 'colour', 'panel']) {
    const a = view.roles.indexOf(role);
    if (a >= 0 && a !== doc.detectorAxis && doc.axes[a].values.length <= mostFacets) return a;
  }
  return -1;
}

/** The ratio of each facet and detector, pooled over the other axes; null if the document did not pool them. */
function facetRows(doc, view, phase, facet) {
  const roles = view.roles.map((role, a) => {
    if (a === doc.detectorAxis) return 'colour';
    return a === facet ? 'x' : role === 'fixed' ? 'fixed' : 'pooled';
  });
  const quantity = quantities(doc).find((each) => each.id === `ratio:${phase}`);
  const found = entriesOf(doc, { ...view, roles }, quantity);
  if (!found) return null;
  return found.entries.map(({ place, value, low, high, points, isMatched, isVoid }) => {
    const at = { facet: facet < 0 ? -1 : place[facet], detector: place[doc.detectorAxis] };
    return { ...at, value, low, high, points, isMatched, isVoid };
  });
}

/** The document's own geometric means over all cells, if no axis is fixed to one of several values. */
function meanRows(doc, view, phase) {
  const names = doc.axes[doc.detectorAxis].values.map(String);
  return (doc.raw.ratios.means?.[phase] ?? [])
    .map((mean) => ({
      facet: 'mean',
      detector: names.indexOf(String(mean.detector)),
      value: mean.value,
      low: mean.low ?? null,
      high: mean.high ?? null,
      least: mean.least ?? null,
      most: mean.most ?? null,
      points: mean.cells ?? null,
      of: mean.of,
      isMatched: true,
      isVoid: false,
    }))
    .filter((row) => row.value !== null && row.detector >= 0);
}

function marksOf(rows, theme, ticks) {
  const ink = (row) => style(theme, row.detector).colour;
  const range = { stroke: theme.muted, strokeWidth: 1, strokeDasharray: '2 2' };
  return [
    Plot.gridX({ ticks, stroke: theme.grid, strokeOpacity: 1 }),
    Plot.ruleX([1], { stroke: theme.ink, strokeWidth: 1 }),
    Plot.ruleY(rows, { y: 'detector', x1: 'least', x2: 'most', filter: (row) => row.most > row.least, ...range }),
    Plot.ruleY(
      rows.filter((row) => row.low !== null),
      { y: 'detector', x1: 'low', x2: 'high', stroke: ink, strokeWidth: 2.4, strokeOpacity: 0.75 },
    ),
    Plot.dot(rows, {
      y: 'detector',
      x: 'value',
      r: (row) => (row.facet === 'mean' ? 5 : 4),
      className: 'hot',
      symbol: (row) => style(theme, row.detector).symbol,
      stroke: ink,
      strokeWidth: 1.6,
      fill: (row) => (row.isVoid || !row.isMatched ? theme.background : ink(row)),
    }),
  ];
}

/** @param {{isLast: boolean}} how  the last panel has the shared axis */
function panelOf(rows, names, { theme, margin, x, isLast, label }) {
  const axis = isLast ? { label, labelAnchor: 'right', labelArrow: 'none' } : { axis: null };
  return ({ width, height }) => ({
    width,
    height,
    marginLeft: margin,
    marginRight: 16,
    marginTop: 4,
    marginBottom: isLast ? 38 : 8,
    x: { ...x, ...axis },
    y: rowBand({ margin, domain: rows.map((row) => row.detector), labelOf: (i) => names[i] }),
    marks: marksOf(rows, theme, x.ticks),
  });
}

/** Groups of rows, from the top: one for each facet, then the means. Detectors are in order of their means. */
function groupsOf(cells, means, facet) {
  const isShort = facet >= 0 && cells.length <= mostRows;
  const facets = isShort || means.length === 0 ? [...new Set(cells.map((row) => row.facet))] : [];
  const groups = facets.map((value) => [value, cells.filter((row) => row.facet === value)]);
  if (means.length) groups.push(['mean', means]);
  const best = new Map((means.length ? means : cells).map((row) => [row.detector, row.value]));
  const rank = (row) => best.get(row.detector) ?? Infinity;
  for (const [, own] of groups) own.sort((a, b) => rank(a) - rank(b) || a.detector - b.detector);
  return groups;
}

function scaleOf(rows, width) {
  const [low, high] = extent(rows.flatMap((row) => [row.value, row.low, row.high, row.least, row.most, 1]));
  const pad = Math.max((high / low) ** 0.05, 1.05);
  const domain = [low / pad, high * pad];
  const ticks = logTicks(...domain, Math.max(3, Math.floor(width / 50)));
  return { type: 'log', domain, ticks, tickFormat: (v) => number(v, 6) };
}

function notesOf(doc, rows, { fixed, mean }) {
  const cells =
    mean && `Geometric mean over ${mean.points ?? '–'} of ${mean.of ?? '–'} cells; dashed: the range over them.`;
  return [
    fixed && `At ${fixed}.`,
    'Paired: each time divided by the baseline’s in the same cell.',
    cells,
    rows.some((row) => row.low !== null) ? intervalText(doc) : 'No intervals: one repeat.',
    rows.some((row) => !row.isMatched || row.isVoid) &&
      'Hollow: not all detectors have a sound run of this cell with the same omissions.',
  ].filter(Boolean);
}

const columnsOf = (detector) => [
  { key: 'group', label: 'group' },
  { key: 'name', label: detector },
  { key: 'value', label: 'ratio', isNumber: true },
  { key: 'low', label: 'low', isNumber: true },
  { key: 'high', label: 'high', isNumber: true },
  { key: 'least', label: 'least', isNumber: true },
  { key: 'most', label: 'greatest', isNumber: true },
  { key: 'points', label: 'cells', isNumber: true },
];

export function describeRatios(doc, view, { theme, width }) {
  const { ratios } = doc.raw;
  const title = 'Detectors compared';
  if (!ratios || doc.detectorAxis < 0 || !Object.keys(ratios.phases ?? {}).length)
    return { title, empty: 'There are no ratios: the sweep has no axis of detectors.' };
  const phase = phaseOfRatios(doc, view);
  const detectors = doc.axes[doc.detectorAxis];
  const names = detectors.values.map((_, i) => valueText(detectors, i));
  const facet = facetAxis(doc, view);
  const fixed = fixedText(doc, view);
  const means = fixed ? [] : meanRows(doc, view, phase);
  const cells = facetRows(doc, view, phase, facet);
  if (!cells) return { title, empty: noTable };
  const groups = groupsOf(cells, means, facet);
  const all = groups.flatMap(([, own]) => own);
  if (all.length === 0) return { title, empty: 'No two detectors have times for the same point.' };
  const isAlone = means.length > 0 && groups.length === 1 && means[0].of === 1; // not a mean, but the only cell
  const titleOf = (value) => {
    if (value === 'mean') return isAlone ? '' : 'geometric mean';
    return value < 0 ? '' : `${doc.axes[facet].name} ${valueText(doc.axes[facet], value)}`;
  };
  const margin = labelMargin(names, width);
  const x = scaleOf(all, width - margin);
  const label = `${phase} over that of ${short(ratios.baseline, 30)}   ← faster · slower`;
  const rows = [];
  const panels = groups.map(([value, own], g) => {
    const isLast = g === groups.length - 1;
    rows.push(...own.map((row) => ({ ...row, group: titleOf(value), name: names[row.detector] })));
    return {
      title: titleOf(value),
      height: own.length * rowHeight + (isLast ? 46 : 14),
      hot: { hot: own.map((_, i) => rows.length - own.length + i) },
      options: panelOf(own, names, { theme, margin, x, isLast, label }),
    };
  });
  return {
    title: `Detectors compared: ${phase} over that of ${short(ratios.baseline, 40)}`,
    columns: columnsOf(detectors.name),
    rows,
    panels,
    perRow: 1,
    legend: [],
    notes: notesOf(doc, all, { fixed, mean: isAlone ? null : means[0] }),
  };
}
