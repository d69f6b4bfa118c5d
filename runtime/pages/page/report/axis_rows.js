// The rows behind a figure over the axes: one for each mark.
import { valueText } from './document.js';
import { entriesOf } from './pooled.js';

const text = (axis, i) => (i < 0 ? '' : valueText(axis, i));

/** How much of the logarithm of the values a straight line over the parameter explains. */
function correlation(parameter, rows) {
  const pairs = rows
    .filter((row) => row.value > 0)
    .map((row) => {
      const at = parameter.values[row.xIndex];
      return [parameter.log ? Math.log(at) : at, Math.log(row.value)];
    });
  const mean = (k) => pairs.reduce((sum, pair) => sum + pair[k], 0) / pairs.length;
  const [mx, my] = [mean(0), mean(1)];
  const sum = (of) => pairs.reduce((all, [x, y]) => all + of(x - mx, y - my), 0);
  const scale = sum((x) => x * x) * sum((_, y) => y * y);
  return scale > 0 ? sum((x, y) => x * y) ** 2 / scale : 0;
}

/** Over sampled points: a panel for each parameter, or, in a single panel, over the one that matters most. */
function overParameters(rows, [x, colour, panel], isSingle) {
  const along = (of, k) => rows.map((row) => ({ ...row, panel: k ?? row.panel, x: of.values[row.xIndex] }));
  const sort = (all) => all.sort((a, b) => a.panel - b.panel || a.colour - b.colour || a.x - b.x);
  if (!panel && !isSingle) {
    const names = x.sampled.map((of) => of.name);
    const over = { name: 'over', label: 'over', isText: true, values: names, labels: names, isParameters: true };
    return { rows: sort(x.sampled.flatMap(along)), axes: [{ ...x, isScattered: true }, colour, over] };
  }
  const { name, values, log } = x.sampled.reduce((a, b) => (correlation(b, rows) > correlation(a, rows) ? b : a));
  const one = { ...x, name, label: name, values, labels: [], log, isScattered: true };
  return { rows: sort(along(one)), axes: [one, colour, panel] };
}

/**
 * The rows that a figure draws, in order of panel, colour, x, and the axes of these roles; null if the document did not
 * pool the axes.
 */
export function rowsOf(doc, view, quantity, isSingle = false) {
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
  const drawn = axes[0]?.sampled?.length > 0 ? overParameters(rows, axes, isSingle) : { rows, axes };
  return { ...drawn, pooled: found.pooled, isUnmatched: found.isUnmatched };
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
