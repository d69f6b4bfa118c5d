// Groups the points that a mark of a figure represents, and pools their values. Pure functions.

/** @typedef {import('./document.js').Doc} Doc */
/** @typedef {import('./document.js').Estimates} Estimates */
/**
 * @typedef {object} Group  points with the same values on the axes that are drawn, and the same mark
 * @property {number} x       index on the axis of that role, -1 without one
 * @property {number} colour
 * @property {number} panel
 * @property {string} mark
 * @property {boolean} isVoid
 * @property {number[]} points  the matched ones
 * @property {number} own       points that it had before they were matched
 */
/**
 * @typedef {object} Groups
 * @property {Group[]} groups
 * @property {number[]} pooled    axes
 * @property {boolean} isUnmatched  no cell is common to all groups of a kind; they keep all their points
 */

const roleAxis = (view, role) => view.roles.indexOf(role);

/** Points at the fixed values. @param {Doc} doc @param {import('./state.js').View} view @returns {number[]} */
export function selected(doc, view) {
  const fixed = view.roles
    .map((role, a) => [role, a])
    .filter(([role]) => role === 'fixed')
    .map(([, a]) => a);
  const points = [];
  for (let p = 0; p < doc.count; ++p) if (fixed.every((a) => doc.at[p][a] === view.at[a])) points.push(p);
  return points;
}

/**
 * Removes from groups of the same mark the cells that not all of them have.
 * @param {Doc} doc
 * @param {Group[]} groups
 * @param {number[]} pooled
 */
function match(doc, groups, pooled) {
  const cell = (point) => pooled.map((a) => doc.at[point][a]).join();
  const kinds = new Map();
  for (const group of groups) {
    const kind = `${group.isVoid} ${group.mark}`;
    kinds.set(kind, [...(kinds.get(kind) ?? []), group]);
  }
  let isUnmatched = false;
  for (const [, kind] of kinds) {
    const seen = new Map();
    for (const group of kind) for (const point of group.points) seen.set(cell(point), (seen.get(cell(point)) ?? 0) + 1);
    const common = new Set([...seen].filter(([, n]) => n === kind.length).map(([each]) => each));
    if (common.size === 0) isUnmatched = true;
    else for (const group of kind) group.points = group.points.filter((point) => common.has(cell(point)));
  }
  return isUnmatched;
}

/**
 * Groups the points that have a value. Void points are in other groups than sound ones.
 * @param {Doc} doc @param {import('./state.js').View} view @param {(number | null)[]} values @returns {Groups}
 */
export function group(doc, view, values, points = selected(doc, view)) {
  const axes = ['x', 'colour', 'panel'].map((role) => roleAxis(view, role));
  const pooled = view.roles.map((role, a) => (role === 'pooled' ? a : -1)).filter((a) => a >= 0);
  const found = new Map();
  for (const p of points) {
    if (values[p] === null || values[p] === undefined) continue;
    const [x, colour, panel] = axes.map((a) => (a < 0 ? -1 : doc.at[p][a]));
    const key = `${x} ${colour} ${panel} ${doc.isVoid[p]} ${doc.mark[p]}`;
    let group = found.get(key);
    if (!group)
      found.set(key, (group = { x, colour, panel, mark: doc.mark[p], isVoid: doc.isVoid[p], points: [], own: 0 }));
    group.points.push(p);
    ++group.own;
  }
  const groups = [...found.values()];
  const isUnmatched = pooled.length > 0 && match(doc, groups, pooled);
  return { groups, pooled, isUnmatched };
}

/**
 * @typedef {{value: number, low: number | null, high: number | null, interval: 'given' | 'quadrature' | 'range' |
 *   null}} Pooled
 */

/**
 * The mean over points, with an interval. For one point it is that of the point. For several it combines their
 * half-widths in quadrature, because the runs are independent; if a point has none, it is the range over the points.
 * Geometric means are computed from logarithms.
 * @param {number[]} points
 * @param {Estimates} estimates
 * @param {'arithmetic' | 'geometric'} mean
 * @returns {Pooled | null}
 */
export function pool(points, estimates, mean) {
  const has = (values, p) => values !== undefined && values[p] !== null && values[p] !== undefined;
  const into = mean === 'geometric' ? Math.log : (x) => x;
  const out = mean === 'geometric' ? Math.exp : (x) => x;
  const usable = points.filter((p) => has(estimates.value, p) && (mean === 'arithmetic' || estimates.value[p] > 0));
  if (usable.length === 0) return null;
  const value = usable.map((p) => into(estimates.value[p]));
  const n = usable.length;
  const hasAll = usable.every((p) => has(estimates.low, p) && has(estimates.high, p));
  if (n === 1) {
    const [p] = usable;
    return {
      value: estimates.value[p],
      low: hasAll ? estimates.low[p] : null,
      high: hasAll ? estimates.high[p] : null,
      interval: hasAll ? 'given' : null,
    };
  }
  const centre = value.reduce((sum, each) => sum + each, 0) / n;
  if (!hasAll)
    return {
      value: out(centre),
      low: out(value.reduce((a, b) => Math.min(a, b))),
      high: out(value.reduce((a, b) => Math.max(a, b))),
      interval: 'range',
    };
  const width = (side) =>
    Math.sqrt(usable.reduce((sum, p, i) => sum + (into(estimates[side][p]) - value[i]) ** 2, 0)) / n;
  return {
    value: out(centre),
    low: out(centre - width('low')),
    high: out(centre + width('high')),
    interval: 'quadrature',
  };
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
