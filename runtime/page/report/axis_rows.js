// The rows behind a figure over the axes: one for each mark.
import { valueText } from './document.js';
import { group, pool } from './pool.js';

const text = (axis, i) => (i < 0 ? '' : valueText(axis, i));

/** The rows that a figure draws, one for each group of points, in order of panel, colour, x. */
export function rowsOf(doc, view, quantity) {
  const estimates = quantity.estimates(view.statistic);
  const grouped = group(doc, view, estimates.value);
  const axes = ['x', 'colour', 'panel'].map((role) => doc.axes[view.roles.indexOf(role)]);
  const rows = [];
  for (const each of grouped.groups) {
    const pooled = pool(each.points, estimates, quantity.mean);
    if (pooled === null) continue;
    rows.push({
      ...each,
      ...pooled,
      x: each.x < 0 ? 0 : axes[0].isText ? each.x : axes[0].values[each.x],
      xIndex: each.x,
      points: each.points.length,
      own: each.own,
    });
  }
  rows.sort(
    (a, b) => a.panel - b.panel || a.colour - b.colour || (axes[0]?.isText ? 0 : a.x - b.x) || a.xIndex - b.xIndex,
  );
  return { rows, grouped, axes };
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
