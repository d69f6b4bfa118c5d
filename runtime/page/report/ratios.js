// Rivals: the time of each detector over that of the baseline in the same place.
import * as Plot from '@observablehq/plot';
import { column, valueText } from './document.js';
import { number, short } from './format.js';
import { style } from './palette.js';
import { pool, selected } from './pool.js';
import { extent, fixedText, intervalText, labelMargin, logTicks, rowLabel } from './scales.js';

const mostFacets = 6;
const mostRows = 60;
const rowHeight = 22;

const phaseOfRatios = (doc, view) => {
  const phases = Object.keys(doc.raw.ratios.phases ?? {});
  const wanted = view.quantity.split(':')[1];
  return phases.includes(wanted) ? wanted : phases.includes('step') ? 'step' : phases[0];
};

/** The axis whose values make groups of rows: x, else that of the panels, if it is not the detectors' and has few values. */
function facetAxis(doc, view) {
  for (const role of ['x', 'colour', 'panel']) {
    const a = view.roles.indexOf(role);
    if (a >= 0 && a !== doc.detectorAxis && doc.axes[a].values.length <= mostFacets) return a;
  }
  return -1;
}

/** For each value of the facets and each detector: the pooled ratio over the points that every detector has. */
function facetRows(doc, view, ratio, facet) {
  const d = doc.detectorAxis;
  const rows = [];
  const values = facet < 0 ? [-1] : doc.axes[facet].values.map((_, i) => i);
  const points = selected(doc, { ...view, roles: view.roles.map((role, a) => (a === d ? 'colour' : role)) });
  for (const value of values) {
    const own = points.filter((p) => facet < 0 || doc.at[p][facet] === value);
    for (let detector = 0; detector < doc.axes[d].values.length; ++detector) {
      const all = own.filter((p) => doc.at[p][d] === detector && ratio.value[p] !== null);
      const matched = all.filter((p) => ratio.is_matched[p] && !doc.isVoid[p]);
      const sound = all.filter((p) => !doc.isVoid[p]);
      const used = matched.length ? matched : sound.length ? sound : all;
      const pooled = pool(used, ratio, 'geometric');
      if (pooled)
        rows.push({
          facet: value,
          detector,
          ...pooled,
          points: used.length,
          isMatched: matched.length > 0,
          isVoid: sound.length === 0,
        });
    }
  }
  return rows;
}

/** The document's own geometric means over all cells; they apply where no axis is fixed to one of several values. */
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

function panelOf(rows, names, { theme, margin, x, isLast, baseline, phase }) {
  return ({ width, height }) => ({
    width,
    height,
    marginLeft: margin,
    marginRight: 16,
    marginTop: 4,
    marginBottom: isLast ? 38 : 8,
    x: {
      ...x,
      label: isLast ? `${phase} over that of ${short(baseline, 30)}   ← faster · slower` : null,
      labelAnchor: 'right',
      labelArrow: 'none',
      ...(isLast ? {} : { axis: null }),
    },
    y: {
      type: 'band',
      domain: rows.map((row) => row.detector),
      tickFormat: (i) => rowLabel(names[i], margin),
      label: null,
      tickSize: 0,
    },
    marks: [
      Plot.gridX({ ticks: x.ticks, stroke: theme.grid, strokeOpacity: 1 }),
      Plot.ruleX([1], { stroke: theme.ink, strokeWidth: 1 }),
      Plot.ruleY(
        rows.filter((row) => row.least != null),
        {
          y: 'detector',
          x1: 'least',
          x2: 'most',
          filter: (row) => row.most > row.least,
          stroke: theme.muted,
          strokeWidth: 1,
          strokeDasharray: '2 2',
        },
      ),
      Plot.ruleY(
        rows.filter((row) => row.low !== null),
        {
          y: 'detector',
          x1: 'low',
          x2: 'high',
          stroke: (row) => style(theme, row.detector).colour,
          strokeWidth: 2.4,
          strokeOpacity: 0.75,
        },
      ),
      Plot.dot(rows, {
        y: 'detector',
        x: 'value',
        r: (row) => (row.facet === 'mean' ? 5 : 4),
        className: 'hot',
        symbol: (row) => style(theme, row.detector).symbol,
        stroke: (row) => style(theme, row.detector).colour,
        strokeWidth: 1.6,
        sort: null,
        fill: (row) => (row.isVoid || !row.isMatched ? theme.background : style(theme, row.detector).colour),
      }),
    ],
  });
}

export function describeRatios(doc, view, { theme, width }) {
  const { ratios } = doc.raw;
  const title = 'Rivals';
  if (!ratios || doc.detectorAxis < 0 || !Object.keys(ratios.phases ?? {}).length)
    return { title, empty: 'There are no ratios: the sweep has no axis of detectors.' };
  const phase = phaseOfRatios(doc, view);
  const raw = ratios.phases[phase];
  const ratio = Object.fromEntries(
    ['value', 'low', 'high', 'is_matched'].map((name) => [name, column(raw[name], doc.count)]),
  );
  const names = doc.axes[doc.detectorAxis].values.map((_, i) => valueText(doc.axes[doc.detectorAxis], i));
  const facet = facetAxis(doc, view);
  const fixed = fixedText(doc, view);
  const means = fixed ? [] : meanRows(doc, view, phase);
  const cells = facetRows(doc, view, ratio, facet);
  // One group, or means of the document that say the same.
  const groups = [];
  const isShort = facet >= 0 && cells.length <= mostRows;
  if (isShort || means.length === 0)
    for (const value of new Set(cells.map((row) => row.facet)))
      groups.push([value, cells.filter((row) => row.facet === value)]);
  if (means.length) groups.push(['mean', means]);
  const all = groups.flatMap(([, own]) => own);
  if (all.length === 0) return { title, empty: 'No two detectors have a time in the same place.' };
  const best = new Map((means.length ? means : cells).map((row) => [row.detector, row.value]));
  for (const [, own] of groups)
    own.sort(
      (a, b) => (best.get(a.detector) ?? Infinity) - (best.get(b.detector) ?? Infinity) || a.detector - b.detector,
    );
  const isAlone = means.length > 0 && groups.length === 1 && means[0].of === 1; // no mean, but the only cell
  const rows = [];
  const [low, high] = extent(all.flatMap((row) => [row.value, row.low, row.high, row.least, row.most, 1]));
  const pad = Math.max((high / low) ** 0.05, 1.05);
  const margin = labelMargin(names, width);
  const domain = [low / pad, high * pad];
  const x = {
    type: 'log',
    domain,
    ticks: logTicks(...domain, Math.max(3, Math.floor((width - margin) / 50))),
    tickFormat: (v) => number(v),
  };
  const panels = groups.map(([value, own], g) => {
    const first = rows.length;
    const label =
      value === 'mean'
        ? isAlone
          ? ''
          : 'geometric mean'
        : value < 0
          ? ''
          : `${doc.axes[facet].name} ${valueText(doc.axes[facet], value)}`;
    rows.push(...own.map((row) => ({ ...row, group: label, name: names[row.detector] })));
    const isLast = g === groups.length - 1;
    return {
      title: label,
      height: own.length * rowHeight + (isLast ? 46 : 14),
      hot: { hot: own.map((_, i) => first + i) },
      options: panelOf(own, names, { theme, margin, x, isLast, baseline: ratios.baseline, phase }),
    };
  });
  const kinds = new Set(cells.map((row) => row.interval));
  const columns = [
    { key: 'group', label: 'group' },
    { key: 'name', label: doc.axes[doc.detectorAxis].name },
    { key: 'value', label: 'ratio', isNumber: true },
    { key: 'low', label: 'low', isNumber: true },
    { key: 'high', label: 'high', isNumber: true },
    { key: 'least', label: 'least', isNumber: true },
    { key: 'most', label: 'greatest', isNumber: true },
    { key: 'points', label: 'cells', isNumber: true },
  ];
  const [mean] = means;
  return {
    title: `Rivals: ${phase} over that of ${short(ratios.baseline, 40)}`,
    columns,
    rows,
    panels,
    perRow: 1,
    legend: [],
    notes: [
      ...(fixed ? [`At ${fixed}.`] : []),
      'Paired: a time over the baseline’s in the same cell.',
      ...(means.length && !isAlone
        ? [`Geometric mean over ${mean.points ?? '–'} of ${mean.of ?? '–'} cells; dashed: the range over the cells.`]
        : []),
      ...(kinds.has('given') || all.some((row) => row.facet === 'mean' && row.low !== null)
        ? [intervalText(doc)]
        : ['No intervals: one repeat.']),
      ...(kinds.has('quadrature') ? ['Bars of pooled cells: half-widths in quadrature, in logarithms.'] : []),
      ...(kinds.has('range') ? ['Bars of pooled cells without intervals: the range over them.'] : []),
      ...(all.some((row) => !row.isMatched || row.isVoid)
        ? ['Hollow: not all detectors have this cell, sound and with the same omissions.']
        : []),
    ],
  };
}
