// A quantity over the axes (figures 4 and 5 of the paper).
import { legendOf, lineDrawing, textDrawing } from './axis_panels.js';
import { rowsOf, tableOf } from './axis_rows.js';
import { budgetOf, budgetText, quantities, statistics, valueText } from './document.js';
import { short } from './format.js';
import { noTable } from './pooled.js';
import { extent, poolNotes, unitOf } from './scales.js';

const mostNamed = 12; // values without a mark

/** The statistic of the times in a figure. */
export const statisticText = (doc, view) =>
  view.statistic === 'mean'
    ? (doc.raw.statistic ?? '')
    : `Drawn: ${statistics[view.statistic]} over the cycles; the time of a cycle is its median over the repeats.`;

/** @param {import('./document.js').Quantity} quantity */
export function describeQuantity(doc, view, plainHow, quantity, { height = 340, isSmall = false } = {}) {
  const how = { ...plainHow, theme: { ...plainHow.theme, highlight: view.highlight } };
  const found = rowsOf(doc, view, quantity, isSmall);
  if (!found) return { title: quantity.label, empty: noTable };
  const over = found.axes[0] ? ` over ${found.axes[0].name}` : '';
  const title = `${quantity.short[0].toUpperCase()}${quantity.short.slice(1)}${over}`;
  if (found.rows.length === 0) return { title, empty: 'No point has a value here.' };
  const unit = unitOf(quantity, extent(found.rows.map((row) => row.value))[1]);
  const { columns, rows } = tableOf(found.rows, found.axes, unit, quantity);
  // Without an axis along x, the axis of colours makes the rows.
  let axes = found.axes;
  let drawn = rows;
  if (!axes[0]) {
    axes = [axes[1], undefined, axes[2]];
    drawn = rows.map((row) => ({ ...row, xIndex: row.colour, colour: -1 }));
  }
  const has = new Set(drawn.map((row) => row.xIndex));
  const missing = axes[0] ? axes[0].values.map((_, i) => i).filter((i) => !has.has(i) && axes === found.axes) : [];
  const isRows = !axes[0] || axes[0].isText;
  const budget = quantity.dimension === 'time' ? budgetOf(doc, quantity.id.slice(5), unit.factor) : null;
  const label = isSmall ? unit.unit : `${quantity.short}${unit.unit ? `, ${unit.unit}` : ''}`;
  const drawing = (isRows ? textDrawing : lineDrawing)(doc, view, {
    rows: drawn,
    axes,
    how,
    yLabel: label,
    height,
    missing,
    budget,
  });
  const isTime = quantity.dimension === 'time';
  const statistic = isTime
    ? statisticText(doc, view)
    : quantity.dimension === 'ratio'
      ? `Paired: each point divided by that of ${short(doc.raw.ratios.baseline, 40)} at the same point.`
      : `Mean over the cycles.`;
  return {
    title,
    columns,
    rows,
    legend: legendOf(drawn, axes[1], how.theme, isRows),
    ...drawing,
    notes: [
      statistic,
      ...(budget === null
        ? []
        : [`Dashed: the budget, ${budgetText(doc.raw.budget.ns)}, which is for the 99th percentile of the cycles.`]),
      ...(missing.length > 0 && missing.length <= mostNamed
        ? [`No value at ${axes[0].name} ${missing.map((i) => short(valueText(axes[0], i), 40)).join(', ')}.`]
        : []),
      ...poolNotes(doc, view, found, quantity, {
        hasIntervals: isTime || quantity.dimension === 'ratio',
      }),
    ],
  };
}

export function describeOverAxes(doc, view, how) {
  const quantity = quantities(doc).find((each) => each.id === view.quantity);
  if (!quantity) return { title: 'Over the axes', empty: 'There is nothing to draw: no run has times.' };
  return describeQuantity(doc, view, how, quantity);
}
