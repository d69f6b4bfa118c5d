// The panels of a figure over the axes: lines for axes of numbers, rows of dots for axes of texts.
import * as Plot from '@observablehq/plot';
import { axisTitle, valueText } from './document.js';
import { budgetStyle, style } from './palette.js';
import { thin } from './pooled.js';
import { labelMargin, rowAxes, scale, valueScale } from './scales.js';

const mostMarks = 600; // in a series; longer ones are drawn in bins

const evenly = (scaleX, xLabel) => (scaleX.isEven ? `${xLabel}, evenly spaced` : xLabel);

export function legendOf(rows, colour, theme, isRows) {
  if (!colour) return [];
  return [...new Set(rows.map((row) => row.colour))]
    .sort((a, b) => a - b)
    .map((i) => {
      const { colour: ink, symbol, dash } = style(theme, i);
      return {
        label: colour.isText ? valueText(colour, i) : `${colour.name} ${valueText(colour, i)}`,
        colour: ink,
        symbol,
        ...(isRows ? {} : { dash }),
      };
    });
}

/** The rows that a line joins: those of each colour and mark, without void ones. */
function seriesOf(rows) {
  const series = new Map();
  for (const row of rows) {
    if (row.isVoid) continue;
    const key = `${row.colour} ${row.mark}`;
    series.set(key, [...(series.get(key) ?? []), row]);
  }
  return [...series.values()];
}

function dots(rows, theme, at, className = 'hot') {
  const styleOf = (row) => style(theme, row.colour);
  return [
    Plot.dot(
      rows.filter((row) => row.mark && !row.isVoid),
      { ...at, r: 7.5, stroke: (row) => styleOf(row).colour, strokeWidth: 1 },
    ),
    Plot.dot(rows, {
      ...at,
      className,
      strokeWidth: 1.6,
      r: 3.8,
      symbol: (row) => styleOf(row).symbol,
      stroke: (row) => styleOf(row).colour,
      fill: (row) => (row.isVoid ? theme.background : styleOf(row).colour),
    }),
  ];
}

const coloursOf = (rows) => [...new Set(rows.map((row) => row.colour))].sort((a, b) => a - b);
/** The rows of the table for the marks of each colour. */
const hotOf = (rows, colours) =>
  Object.fromEntries(
    colours.map((c) => [`hot-${c + 1}`, rows.filter((row) => row.colour === c).map((row) => row.index)]),
  );

/** Places marks with the same x side by side, so that none hides another. */
const asides = (colours) => (colour) =>
  (colours.indexOf(colour) - (colours.length - 1) / 2) * Math.min(4, 16 / colours.length);

/** A series as a line with its intervals; a long one as its means and the range around them. */
function seriesMarks(series, theme, { at, dx, isScattered }) {
  const { colour, dash } = style(theme, series[0].colour);
  const isLong = series.length > mostMarks;
  const shown = isLong ? thin(series, mostMarks / 2) : series;
  const spread = isLong
    ? Plot.areaY(shown, { x: at, y1: 'low', y2: 'high', fill: colour, fillOpacity: 0.2 })
    : Plot.ruleX(
        series.filter((row) => row.low !== null),
        { x: at, y1: 'low', y2: 'high', dx, stroke: colour, strokeWidth: 1.3 },
      );
  const line = { x: at, y: 'value', dx, stroke: colour, strokeWidth: 1.6, strokeDasharray: dash ?? undefined };
  return series.length > 1 && !isScattered ? [spread, Plot.line(shown, line)] : [spread];
}

/** Lines over an axis of numbers. */
function linePanel(rows, { theme, colours, x, y, xLabel, yLabel, budget, isScattered }) {
  const aside = asides(colours);
  const isLast = (i) => Number(i === theme.highlight);
  const series = seriesOf(rows).sort((a, b) => isLast(a[0].colour) - isLast(b[0].colour));
  const order = [...colours].sort((a, b) => isLast(a) - isLast(b));
  return ({ width, height }) => {
    const scaleX = x(width - 58);
    const at = (row) => scaleX.place(row.x);
    const marks = series.flatMap((each) => seriesMarks(each, theme, { at, dx: aside(each[0].colour), isScattered }));
    if (rows.length <= mostMarks)
      for (const i of order) {
        const own = rows.filter((row) => row.colour === i);
        marks.push(...dots(own, theme, { x: at, y: 'value', dx: aside(i) }, `hot hot-${i + 1}`));
      }
    if (budget !== null) marks.push(Plot.ruleY([budget], budgetStyle(theme)));
    return {
      width,
      height,
      marginLeft: 46,
      marginTop: 24,
      marginBottom: 38,
      marginRight: 12,
      x: { ...scaleX, label: evenly(scaleX, xLabel), labelAnchor: 'right', labelArrow: 'right' },
      y: { ...y, label: yLabel, labelArrow: 'up' },
      marks: [Plot.gridY({ ticks: y.ticks, stroke: theme.grid, strokeOpacity: 1 }), ...marks],
    };
  };
}

/** Dots in rows: the texts vertically, the quantity horizontally. */
function rowPanel(rows, { theme, scaleX, rowsShown, label, margin, xLabel, budget }) {
  return ({ width, height }) => {
    const y = (row) => row.xIndex;
    const spread = rowsShown.colours.length > 1 ? Math.min(18 / rowsShown.colours.length, 6) : 0;
    const lift = (row) => (rowsShown.colours.indexOf(row.colour) - (rowsShown.colours.length - 1) / 2) * spread;
    const marks = [
      Plot.gridX({ ticks: scaleX.ticks, stroke: theme.grid, strokeOpacity: 1 }),
      Plot.ruleY(rowsShown.values, { y: (i) => i, stroke: theme.grid, strokeDasharray: '1 3' }),
    ];
    for (const colour of rowsShown.colours) {
      const own = rows.filter((row) => row.colour === colour);
      const dy = own.length ? lift(own[0]) : 0;
      marks.push(
        Plot.ruleY(
          own.filter((row) => row.low !== null),
          { y, x1: 'low', x2: 'high', dy, stroke: style(theme, colour).colour, strokeWidth: 1.4 },
        ),
      );
      marks.push(...dots(own, theme, { y, x: 'value', dy }, `hot hot-${colour + 1}`));
    }
    if (budget !== null) marks.push(Plot.ruleX([budget], budgetStyle(theme)));
    const axes = { margin, x: scaleX, xLabel: evenly(scaleX, xLabel), domain: rowsShown.values, labelOf: label };
    return { width, height, ...rowAxes(axes), marks };
  };
}

/** Dots in rows, with a panel for each value of the axis of panels. */
export function textDrawing(doc, view, { rows, axes, how, yLabel, isSorted = true, missing = [], budget = null }) {
  const [x] = axes;
  const isSingle = new Set(rows.map((row) => row.panel)).size <= 1;
  const values = [...new Set(rows.map((row) => row.xIndex))];
  const best = (i) =>
    rows.filter((row) => row.xIndex === i).reduce((least, row) => Math.min(least, row.value), Infinity);
  if (isSingle && isSorted) values.sort((a, b) => best(a) - best(b));
  else values.sort((a, b) => a - b);
  values.push(...missing);
  const colours = coloursOf(rows);
  const label = (i) => (i < 0 ? 'all' : valueText(x, i));
  const panels = [...new Set(rows.map((row) => row.panel))].sort((a, b) => a - b);
  const perRow = Math.max(1, Math.min(panels.length, Math.floor(how.width / 380)));
  const each = (how.width - 22 * (perRow - 1)) / perRow;
  const margin = labelMargin(values.map(label), each);
  const scaleX = scale(
    [...rows.flatMap((row) => [row.value, row.low, row.high]), budget],
    view.yScale,
    { room: Math.max(3, Math.floor((each - margin) / 55)) },
  );
  return {
    perRow,
    values,
    panels: panels.map((panel) => {
      const own = rows.map((row, i) => ({ ...row, index: i })).filter((row) => row.panel === panel);
      return {
        title: panel < 0 ? '' : `${axes[2].name} ${valueText(axes[2], panel)}`,
        height: values.length * Math.max(22, colours.length * 6 + 8) + 50,
        options: rowPanel(own, {
          theme: how.theme,
          scaleX,
          rowsShown: { values, colours },
          label,
          margin,
          xLabel: yLabel,
          budget,
        }),
        hot: hotOf(own, colours),
      };
    }),
  };
}

/** Lines, with a panel for each value of the axis of panels. */
export function lineDrawing(doc, view, { rows, axes, how, yLabel, height, missing = [], budget = null }) {
  const [x, , panel] = axes;
  const y = scale(
    [...rows.flatMap((row) => [row.value, row.low, row.high]), budget],
    view.yScale,
  );
  const colours = coloursOf(rows);
  const values = [...new Set([...rows.map((row) => row.x), ...missing.map((i) => x.values[i])])];
  const xOf = (own, i) => (width) => {
    if (!x.isScattered) return valueScale(values, view.xScale, width);
    const { log } = panel?.isParameters ? x.sampled[i] : x;
    const wish = view.xScale === 'auto' ? (log ? 'log' : 'linear') : view.xScale;
    const room = Math.max(2, Math.floor(width / 60));
    return {
      ...scale(
        own.map((row) => row.x),
        wish,
        { room, fromZero: false },
      ),
      place: (v) => v,
    };
  };
  const panels = [...new Set(rows.map((row) => row.panel))].sort((a, b) => a - b);
  return {
    height: panels.length > 3 ? Math.min(height, 240) : height,
    panels: panels.map((i) => {
      const own = rows.map((row, index) => ({ ...row, index })).filter((row) => row.panel === i);
      return {
        title: i < 0 ? '' : `${panel.name} ${valueText(panel, i)}`,
        hot: hotOf(own, colours),
        options: linePanel(own, {
          theme: how.theme,
          colours,
          x: xOf(own, i),
          y,
          xLabel: panel?.isParameters ? valueText(panel, i) : axisTitle(x),
          yLabel,
          budget,
          isScattered: x.isScattered,
        }),
      };
    }),
  };
}
