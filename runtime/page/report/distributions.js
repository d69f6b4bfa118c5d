// How times spread: over the cycles of a run as quantiles, and over its repeats.
import * as Plot from '@observablehq/plot';
import * as d3 from 'd3';
import { pointText } from './document.js';
import { short, timeUnit } from './format.js';
import { phaseOf, representatives, whereText } from './cycle_points.js';
import { style } from './palette.js';
import { extent, labelMargin, rowLabel, scale } from './scales.js';

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
    marginLeft: margin,
    marginRight: 16,
    marginTop: 6,
    marginBottom: 38,
    x: { ...x, label, labelAnchor: 'right', labelArrow: 'right' },
    y: {
      type: 'band',
      domain: chosen.map((_, i) => i),
      tickFormat: (i) => rowLabel(labelOf(chosen[i]), margin),
      label: null,
      tickSize: 0,
      padding: 0.25,
    },
    marks: [Plot.gridX({ ticks: x.ticks, stroke: theme.grid, strokeOpacity: 1 }), ...marks],
  };
}

export function describeDistributions(doc, view, { theme, width }) {
  const phase = phaseOf(doc, view);
  const title = `Time of ${phase}: distribution over the cycles`;
  const chosen = chosenOf(doc, view);
  const { distributions } = doc.raw;
  const quantiles = distributions?.quantiles?.[phase];
  if (!quantiles || chosen.length === 0) return { title, empty: 'This document has no distributions.' };
  const levels = distributions.levels ?? distributions.percents ?? d3.range(0, 101, 5);
  const { unit, factor } = timeUnit(extent(chosen.flatMap(({ entry }) => quantiles[entry] ?? []))[1]);
  const rows = chosen.flatMap((each, i) => {
    const values = quantiles[each.entry] ?? [];
    if (values.every((value) => value === null)) return [];
    const at = (level) => {
      const value = values[levels.indexOf(level)];
      return value == null ? null : value / factor;
    };
    return [
      {
        i,
        colour: each.colour,
        place: pointText(doc, each.point),
        isVoid: doc.isVoid[each.point],
        min: at(0),
        p5: at(5),
        p25: at(25),
        median: at(50),
        p75: at(75),
        p95: at(95),
        max: at(100),
      },
    ];
  });
  if (rows.length === 0) return { title, empty: `The file has no times of ${phase} of single cycles.` };
  const x = scale(
    rows.flatMap((row) => [row.min, row.max]),
    view.yScale,
    { ratio: 8, room: Math.max(3, Math.floor(width / 110)) },
  );
  const ink = (row) => style(theme, row.colour).colour;
  const keys = [
    ['min', 'least'],
    ['p5', '5 %'],
    ['p25', '25 %'],
    ['median', 'median'],
    ['p75', '75 %'],
    ['p95', '95 %'],
    ['max', 'greatest'],
  ];
  return {
    title,
    rows,
    legend: [],
    columns: [
      { key: 'place', label: 'point' },
      ...keys.map(([key, label]) => ({ key, label: `${label}, ${unit}`, isNumber: true })),
    ],
    panels: [
      {
        title: '',
        height: rowHeight * chosen.length + 50,
        hot: { hot: rows.map((_, i) => i) },
        options: ({ width: w, height }) =>
          frame({ theme, width: w, height, chosen, x, label: `time of ${phase}, ${unit}` }, [
            Plot.ruleY(rows, { y: 'i', x1: 'min', x2: 'max', stroke: ink, strokeWidth: 1 }),
            Plot.barX(rows, { y: 'i', x1: 'p5', x2: 'p95', fill: ink, fillOpacity: 0.3, insetTop: 3, insetBottom: 3 }),
            Plot.barX(rows, {
              y: 'i',
              x1: 'p25',
              x2: 'p75',
              fill: (row) => (row.isVoid ? theme.background : ink(row)),
              stroke: ink,
              fillOpacity: 0.75,
            }),
            Plot.tickX(rows, {
              y: 'i',
              x: 'median',
              stroke: theme.background,
              strokeWidth: 4,
              insetTop: 0.5,
              insetBottom: 0.5,
            }),
            Plot.tickX(rows, { y: 'i', x: 'median', stroke: theme.ink, strokeWidth: 2, className: 'hot' }),
          ]),
      },
    ],
    notes: [
      `Line: least to greatest cycle. Pale: 5 to 95 % of the cycles. Dark: 25 to 75 %. Tick: median.${(doc.raw.runs?.repeats ?? 1) > 1 ? ' The time of a cycle is its median over the repeats.' : ''}`,
      ...(whereText(doc, view, chosen) ? [`At ${whereText(doc, view, chosen)}.`] : []),
    ],
  };
}

export function describeRepeats(doc, view, { theme, width }) {
  const phase = phaseOf(doc, view);
  const title = `Time of ${phase}: spread over the repeats`;
  const chosen = chosenOf(doc, view);
  const means = doc.raw.distributions?.repeat_means?.[phase];
  if (!means || chosen.length === 0) return { title, empty: 'This document has no figures of single repeats.' };
  const rows = chosen.flatMap((each, i) => {
    const values = (means[each.entry] ?? [])
      .map((value, repeat) => ({ value, repeat }))
      .filter(({ value }) => value !== null);
    const middle = d3.median(values, ({ value }) => value);
    const { unit, factor } = timeUnit(middle ?? 0);
    return values.length < 2
      ? []
      : values.map(({ value, repeat }) => ({
          i,
          colour: each.colour,
          place: pointText(doc, each.point),
          isVoid: doc.isVoid[each.point],
          repeat,
          value: value / factor,
          unit,
          percent: 100 * (value / middle - 1),
        }));
  });
  if (rows.length === 0)
    return { title, empty: 'Each point has one repeat: nothing says how much a repeat differs from the next.' };
  const x = scale(
    rows.map((row) => row.percent),
    'linear',
    { fromZero: false, room: Math.max(3, Math.floor(width / 110)) },
  );
  const ink = (row) => style(theme, row.colour).colour;
  return {
    title,
    rows,
    legend: [],
    columns: [
      { key: 'place', label: 'point' },
      { key: 'repeat', label: 'repeat', isNumber: true },
      { key: 'value', label: 'mean of a cycle', isNumber: true },
      { key: 'unit', label: 'unit' },
      { key: 'percent', label: 'from the median repeat, %', isNumber: true },
    ],
    panels: [
      {
        title: '',
        height: rowHeight * chosen.length + 50,
        hot: { hot: rows.map((_, i) => i) },
        options: ({ width: w, height }) =>
          frame({ theme, width: w, height, chosen, x, label: 'from the median repeat, %' }, [
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
          ]),
      },
    ],
    notes: [
      `Each mark is a repeat: its mean over the cycles, compared with the median of the repeats of the same point.`,
      ...(whereText(doc, view, chosen) ? [`At ${short(whereText(doc, view, chosen), 200)}.`] : []),
    ],
  };
}
