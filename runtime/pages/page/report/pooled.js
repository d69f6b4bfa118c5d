// The values behind the marks of a figure: those of the points, or of the rows that cdb pooled. Pure functions.

/** @typedef {import('./document.js').Doc} Doc */
/**
 * @typedef {object} Entry  what a mark stands for
 * @property {number[]} place  index on each axis, -1 for an axis that is pooled
 * @property {string} mark
 * @property {boolean} isVoid
 * @property {number} points  that are pooled
 * @property {number} own     points before those were left out that not all marks have
 * @property {number} value
 * @property {number | null} low
 * @property {number | null} high
 */

const isVaried = (doc, a) => doc.axes[a].values.length > 1;
const axesOf = (doc, test) => doc.axes.map((_, a) => a).filter((a) => isVaried(doc, a) && test(a));

/** The axes of several values that a view pools. @param {Doc} doc */
export const pooledAxes = (doc, roles) => axesOf(doc, (a) => roles[a] === 'pooled');

/** The document's rows for the axes that are not pooled; null if it has none. @param {Doc} doc */
export const pooledTable = (doc, roles) =>
  doc.pooled.get(axesOf(doc, (a) => roles[a] !== 'pooled').join()) ?? null;

/** The place of a row on all axes of the document. */
function wholePlace(doc, table, at) {
  const place = doc.axes.map((_, a) => (isVaried(doc, a) ? -1 : 0));
  table.axes.forEach((a, k) => {
    place[a] = at[k];
  });
  return place;
}

/** True if a place has the values at which the view fixes axes. */
export const isShown = (doc, view, place) =>
  axesOf(doc, (a) => view.roles[a] === 'fixed').every((a) => place[a] === view.at[a]);

export const noTable = 'This page has no pooled values for these axes: fix one of them, or pool fewer.';

/**
 * The entries of a view that have a value; null if the document did not pool these axes.
 * @param {Doc} doc @param {import('./state.js').View} view @param {import('./document.js').Quantity} quantity
 * @returns {{entries: Entry[], pooled: number[], isUnmatched: boolean} | null}
 */
export function entriesOf(doc, view, quantity) {
  const pooled = pooledAxes(doc, view.roles);
  const table = pooled.length ? pooledTable(doc, view.roles) : null;
  if (pooled.length && !table) return null;
  const columns = table ? quantity.pooled(table, view.statistic) : quantity.estimates(view.statistic);
  const { at = doc.at, mark = doc.mark, isVoid = doc.isVoid, value, low, high, ...more } = columns;
  const entries = [];
  at.forEach((given, i) => {
    const place = table ? wholePlace(doc, table, given) : given;
    if (value[i] === null || value[i] === undefined || !isShown(doc, view, place)) return;
    entries.push({
      points: 1,
      own: 1,
      ...Object.fromEntries(Object.entries(more).map(([key, list]) => [key, list?.[i]])),
      place,
      mark: mark[i],
      isVoid: isVoid[i],
      value: value[i],
      low: low?.[i] ?? null,
      high: high?.[i] ?? null,
    });
  });
  return { entries, pooled, isUnmatched: table?.isUnmatched ?? false };
}

/**
 * At most `most` bins of adjacent rows, for series with more points than a figure has room for: the mean and the range
 * of each.
 * @template T @param {T[]} rows in order of x @param {number} most
 * @returns {{x: number, value: number, low: number, high: number, count: number}[]}
 */
export function thin(rows, most) {
  const size = Math.ceil(rows.length / most);
  const bins = [];
  for (let i = 0; i < rows.length; i += size) {
    const bin = rows.slice(i, i + size);
    const mean = (key) => bin.reduce((sum, row) => sum + row[key], 0) / bin.length;
    bins.push({
      x: mean('x'),
      value: mean('value'),
      count: bin.length,
      low: bin.reduce((least, row) => Math.min(least, row.low ?? row.value), Infinity),
      high: bin.reduce((greatest, row) => Math.max(greatest, row.high ?? row.value), -Infinity),
    });
  }
  return bins;
}

/** True if a logarithmic scale suits the numbers better. @param {number[]} values */
export function prefersLog(values, ratio = 20) {
  const positive = values.filter((value) => value > 0);
  if (positive.length < 2 || positive.length < values.length) return false;
  return positive.reduce((a, b) => Math.max(a, b)) / positive.reduce((a, b) => Math.min(a, b)) >= ratio;
}
