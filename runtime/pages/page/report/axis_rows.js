// The rows behind a figure over the axes: one for each mark.
import { valueText } from './document.js';
import { entriesOf } from './pooled.js';

const text = (axis, i) => (i < 0 ? '' : valueText(axis, i));

/**
 * The rows that a figure draws, in order of panel, colour, x, and the axes of these roles; null if the document did not
 * pool the axes.
 */
export function rowsOf(doc, view, quantity) {
  const found = entriesOf(doc, view, quantity);
  if (!found) return null;
  const roles = ['x', 'colour', 'panel'].map((role) => view.roles.indexOf(role));
  const axes = roles.map((a) => doc.axes[a]);
  const rows = found.entries.map((entry) => {
    const [xIndex, colour, panel] = roles.map((a) => (a < 0 ? -1 : entry.place[a]));
    return { ...entry, xIndex, colour, panel, x: xIndex < 0 ? 0 : axes[0].isText ? xIndex : axes[0].values[xIndex] };
  });
  rows.sort(
    (a, b) => a.panel - b.panel || a.colour - b.colour || (axes[0]?.isText ? 0 : a.x - b.x) || a.xIndex - b.xIndex,
  );
  return { rows, axes, pooled: found.pooled, isUnmatched: found.isUnmatched };
}

/** Columns of the table, in the unit of the figure. */
export function tableOf(rows, axes, unit, quantity) {
  const [x, colour, panel] = axes;
  const columns = [];
  const add = (key, label, isNumber = false) => columns.push({ key, label, isNumber });
  if (panel) add('panelText', panel.name);
  if (colour) add('colourText', colour.name);
  if (x) add('xText', x.name, !x.isText);
  const suffix = unit.unit ? `, ${unit.unit}` : '';
  add('value', `${quantity.short}${suffix}`, true);
  if (rows.some((row) => row.low !== null)) {
    add('low', `low${suffix}`, true);
    add('high', `high${suffix}`, true);
  }
  if (rows.some((row) => row.points > 1)) add('points', 'points', true);
  if (rows.some((row) => row.mark)) add('mark', 'mark');
  const scaled = (value) => (value === null ? null : value / unit.factor);
  return {
    columns,
    rows: rows.map((row) => ({
      ...row,
      panelText: text(panel, row.panel),
      colourText: text(colour, row.colour),
      xText: !x ? '' : x.isText ? text(x, row.xIndex) : row.x,
      value: scaled(row.value),
      low: scaled(row.low),
      high: scaled(row.high),
    })),
  };
}
