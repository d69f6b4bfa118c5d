// The spread of times: over the cycles of a run, as quantiles, and over its repeats.
import * as Plot from '@observablehq/plot';
import * as d3 from 'd3';
import { budgetOf, budgetText, pointText } from './document.js';
import { short, timeUnit } from './format.js';
import { phaseOf, representatives, whereText } from './cycle_points.js';
import { budgetStyle, style } from './palette.js';
import { extent, labelMargin, rowAxes, scale } from './scales.js';

const rowHeight = 24;

function chosenOf(doc, view) {
  const { distributions } = doc.raw;
  if (!distributions) return [];
  return representatives(doc, view, distributions.points ?? doc.at.map((_, i) => i));
}

const labelOf = (each) => each.label || 'the run';

function frame({ theme, width, height, chosen, x, label }, marks) {
  const margin = labelMargin(chosen.map(labelOf), width);
  return {
    width,
    height,
    ...rowAxes({
      margin,
      marginRight: 20,
      x,
      xLabel: label,
      domain: chosen.map((_, i) => i),
      labelOf: (i) => labelOf(chosen[i]),
      padding: 0.25,
    }),
    marks: [Plot.gridX({ ticks: x.ticks, stroke: theme.grid, strokeOpacity: 1 }), ...marks],
  };
}

const quantileKeys = [
  ['min', 'least', 0],
  ['p5', '5 %', 5],
  ['p25', '25 %', 25],
  ['median', 'median', 50],
  ['p75', '75 %', 75],
  ['p95', '95 %', 95],
  ['max', 'greatest', 100],
];

const inkOf = (theme) => (row) => style(theme, row.colour).colour;
const roomOf = (width) => Math.max(3, Math.floor(width / 110));

/** The columns that the rows of both figures share. */
const placeOf = (doc, each, i) => ({
  i,
  colour: each.colour,
  place: pointText(doc, each.point),
  isVoid: doc.isVoid[each.point],
});

const atText = (doc, view, chosen) => {
  const where = whereText(doc, view, chosen);
  return where ? [`At ${short(where, 200)}.`] : [];
};

function quantileMarks(rows, theme) {
  const ink = inkOf(theme);
  const fill = (row) => (row.isVoid ? theme.background : ink(row));
  const gap = { stroke: theme.background, strokeWidth: 4, insetTop: 0.5, insetBottom: 0.5 };
  return [
    Plot.ruleY(rows, { y: 'i', x1: 'min', x2: 'max', stroke: ink, strokeWidth: 1 }),
    Plot.barX(rows, { y: 'i', x1: 'p5', x2: 'p95', fill: ink, fillOpacity: 0.3, insetTop: 3, insetBottom: 3 }),
    Plot.barX(rows, { y: 'i', x1: 'p25', x2: 'p75', fill, stroke: ink, fillOpacity: 0.75 }),
    Plot.tickX(rows, { y: 'i', x: 'median', ...gap }),
    Plot.tickX(rows, { y: 'i', x: 'median', stroke: theme.ink, strokeWidth: 2, className: 'hot' }),
  ];
}

/** The quantiles of each configuration, in ns / `factor`. */
function quantileRows(doc, chosen, quantiles, factor) {
  const levels = doc.raw.distributions.levels ?? doc.raw.distributions.percents ?? d3.range(0, 101, 5);
  return chosen.flatMap((each, i) => {
    const values = quantiles[each.entry] ?? [];
    if (values.every((value) => value === null)) return [];
    const at = (level) => {
      const value = values[levels.indexOf(level)];
      return value === null || value === undefined ? null : value / factor;
    };
    return [
      { ...placeOf(doc, each, i), ...Object.fromEntries(quantileKeys.map(([key, , level]) => [key, at(level)])) },
    ];
  });
}

/** A row for each chosen point. @param marksOf  makes the marks of the rows in a theme */
function rowsPanel(rows, { theme, chosen, x, label }, marksOf) {
  return {
    title: '',
    height: rowHeight * chosen.length + 50,
    hot: { hot: rows.map((_, i) => i) },
    options: (size) => frame({ theme, ...size, chosen, x, label }, marksOf(rows, theme)),
  };
}

export function describeDistributions(doc, view, { theme, width }) {
  const phase = phaseOf(doc, view);
  const title = `Time of ${phase}: distribution over the cycles`;
  const chosen = chosenOf(doc, view);
  const quantiles = doc.raw.distributions?.quantiles?.[phase];
  if (!quantiles || chosen.length === 0) return { title, empty: 'This document has no distributions.' };
  const { unit, factor } = timeUnit(extent(chosen.flatMap(({ entry }) => quantiles[entry] ?? []))[1]);
  const rows = quantileRows(doc, chosen, quantiles, factor);
  if (rows.length === 0) return { title, empty: `The file has no times of ${phase} of individual cycles.` };
  const budget = budgetOf(doc, phase, factor);
  const ends = [...rows.flatMap((row) => [row.min, row.max]), budget];
  const x = scale(ends, view.yScale, { ratio: 8, room: roomOf(width) });
  const label = `time of ${phase}, ${unit}`;
  const repeats = (doc.raw.runs?.repeats ?? 1) > 1 ? ['The time of a cycle is its median over the repeats.'] : [];
  return {
    title,
    rows,
    legend: [],
    columns: [
      { key: 'place', label: 'point' },
      ...quantileKeys.map(([key, name]) => ({ key, label: `${name}, ${unit}`, isNumber: true })),
    ],
    panels: [
      rowsPanel(rows, { theme, chosen, x, label }, (...of) => [
        ...quantileMarks(...of),
        ...(budget === null ? [] : [Plot.ruleX([budget], budgetStyle(theme))]),
      ]),
    ],
    notes: [
      ...(budget === null ? [] : [`Dashed: the budget, ${budgetText(doc.raw.budget.ns)}.`]),
      'Line: least to greatest cycle. Pale: 5 to 95 % of the cycles. Dark: 25 to 75 %. Tick: median.',
      ...repeats,
      ...atText(doc, view, chosen),
    ],
  };
}

/** The repeats of each configuration, and their distance from the median one. */
function repeatRows(doc, chosen, means) {
  return chosen.flatMap((each, i) => {
    const given = means[each.entry] ?? [];
    const values = given.map((value, repeat) => ({ value, repeat })).filter(({ value }) => value !== null);
    if (values.length < 2) return [];
    const middle = d3.median(values, ({ value }) => value);
    const { unit, factor } = timeUnit(middle);
    return values.map(({ value, repeat }) => ({
      ...placeOf(doc, each, i),
      repeat,
      value: value / factor,
      unit,
      percent: 100 * (value / middle - 1),
    }));
  });
}

function repeatMarks(rows, theme) {
  const ink = inkOf(theme);
  return [
    Plot.ruleX([0], { stroke: theme.muted }),
    Plot.dot(rows, {
      y: 'i',
      x: 'percent',
      className: 'hot',
      r: 3.6,
      symbol: (row) => style(theme, row.colour).symbol,
      stroke: ink,
      strokeWidth: 1.4,
      fill: (row) => (row.isVoid ? theme.background : ink(row)),
      fillOpacity: 0.45,
    }),
  ];
}

export function describeRepeats(doc, view, { theme, width }) {
  const phase = phaseOf(doc, view);
  const title = `Time of ${phase}: spread over the repeats`;
  const chosen = chosenOf(doc, view);
  const means = doc.raw.distributions?.repeat_means?.[phase];
  if (!means || chosen.length === 0) return { title, empty: 'This document has no times of individual repeats.' };
  const rows = repeatRows(doc, chosen, means);
  if (rows.length === 0)
    return { title, empty: 'Each point has one repeat, so the spread between repeats is unknown.' };
  const percents = rows.map((row) => row.percent);
  const x = scale(percents, 'linear', { fromZero: false, room: roomOf(width) });
  const label = 'from the median repeat, %';
  return {
    title,
    rows,
    legend: [],
    columns: [
      { key: 'place', label: 'point' },
      { key: 'repeat', label: 'repeat', isNumber: true },
      { key: 'value', label: 'mean of a cycle', isNumber: true },
      { key: 'unit', label: 'unit' },
      { key: 'percent', label, isNumber: true },
    ],
    panels: [rowsPanel(rows, { theme, chosen, x, label }, repeatMarks)],
    notes: [
      'Each mark is a repeat: its mean over the cycles, compared with the median of the repeats of the same point.',
      ...atText(doc, view, chosen),
    ],
  };
}
