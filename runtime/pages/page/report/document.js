// Access to a results document (version 1), some parts of which may be missing.
import { number, short, timeUnit } from './format.js';

/**
 * @typedef {object} Axis
 * @property {string} name
 * @property {string} label
 * @property {string} unit
 * @property {boolean} isText
 * @property {string} kind
 * @property {(number | string)[]} values
 * @property {string[]} labels
 */
/**
 * @typedef {object} Doc
 * @property {any} raw            the JSON
 * @property {Axis[]} axes
 * @property {number} detectorAxis  -1 if there is none
 * @property {number} count       of points
 * @property {number[][]} at      of each point, its index on each axis
 * @property {string[]} mark
 * @property {boolean[]} isVoid
 * @property {string[]} verdict
 * @property {(number | null)[]} firstBadCycle
 * @property {{name: string, label: string, definition: string}[]} phases  those with times
 * @property {Map<string, any>} pooled  rows that are pooled over the other axes, by the axes that they keep: `0,2`
 */

/** A column in any of its forms: an array, one value for all, or words and indices. */
export function column(value, count) {
  if (Array.isArray(value)) return value;
  if (value !== null && typeof value === 'object' && 'constant' in value) return new Array(count).fill(value.constant);
  if (value !== null && typeof value === 'object' && Array.isArray(value.index))
    return value.index.map((i) => value.words[i]);
  return new Array(count).fill(value ?? null);
}

/**
 * The index of each point on each axis: given as such, or as runs [first, count] of the grid, whose last axis varies
 * fastest.
 */
function places(at, axes) {
  if (Array.isArray(at)) return at;
  const sizes = axes.map((axis) => axis.values.length);
  const found = [];
  for (const [first, count] of at?.grid ?? [])
    for (let flat = first; flat < first + count; ++flat) {
      const place = new Array(sizes.length);
      for (let a = sizes.length - 1, rest = flat; a >= 0; --a) {
        place[a] = rest % sizes[a];
        rest = Math.floor(rest / sizes[a]);
      }
      found.push(place);
    }
  return found;
}

const columnsOf = (table, count) =>
  Object.fromEntries(Object.entries(table ?? {}).map(([name, values]) => [name, column(values, count)]));

/** Columns of numbers in groups: `times.step.mean`. */
const groupsOf = (groups, count) =>
  Object.fromEntries(Object.entries(groups ?? {}).map(([name, table]) => [name, columnsOf(table, count)]));

/** A pooled table of the document, with the names of columns as the page has them. */
function openPooled({ axes, is_unmatched: isUnmatched, rows, places }) {
  return { axes, isUnmatched, rows: { ...rows, isVoid: rows.is_void }, places };
}

/** @param {any} json @returns {Doc} */
export function openDocument(json) {
  const points = json.points ?? {};
  const at = places(points.at, json.axes ?? []);
  const count = at.length;
  const axes = (json.axes ?? []).map((axis) => ({
    name: String(axis.name),
    label: String(axis.label || axis.name),
    hasTitle: Boolean(axis.has_title),
    unit: axis.unit ? String(axis.unit) : '',
    isText: axis.is_text ?? axis.values.some((value) => typeof value !== 'number'),
    kind: axis.kind ?? '',
    values: axis.values ?? [],
    labels: axis.value_labels ?? [],
    sampled: axis.sampled ?? [],
  }));
  const times = groupsOf(points.times, count);
  const known = (json.phases ?? []).map((phase) => ({
    name: String(phase.name),
    label: String(phase.label || phase.name),
    definition: String(phase.definition ?? ''),
  }));
  for (const name of Object.keys(times))
    if (!known.some((phase) => phase.name === name)) known.push({ name, label: name, definition: '' });
  const hasTimes = (name) => (times[name]?.mean ?? []).some((value) => value !== null);
  return {
    raw: json,
    axes,
    detectorAxis: json.detector_axis ?? -1,
    count,
    at,
    mark: column(points.mark ?? '', count).map((text) => text ?? ''),
    isVoid: column(points.is_void ?? false, count).map(Boolean),
    verdict: column(points.verdict ?? 'unknown', count).map((text) => text ?? 'unknown'),
    firstBadCycle: column(points.first_bad_cycle, count),
    phases: known.filter((phase) => hasTimes(phase.name)),
    times,
    pooled: new Map((json.pooled ?? []).map((table) => [table.axes.join(), openPooled(table)])),
  };
}

/** The budget of the scenario in ns / `factor`, if it is one of this phase and the same at all points; else null. */
export function budgetOf(doc, phase, factor) {
  const { budget } = doc.raw;
  return budget && budget.phase === phase && budget.ns !== null ? budget.ns / factor : null;
}

/** `4 ms`: a budget in ns. */
export function budgetText(ns) {
  const { unit, factor } = timeUnit(ns);
  return `${Number((ns / factor).toPrecision(4))} ${unit}`;
}

/** @typedef {{value: (number|null)[], low?: (number|null)[], high?: (number|null)[]}} Estimates */

export const statistics = {
  mean: 'mean',
  median: 'median',
  p5: '5th percentile',
  p95: '95th percentile',
  min: 'least',
  max: 'greatest',
};

/** The statistics of a phase in the document. @param {Doc} doc @param {string} phase */
export const statisticsOf = (doc, phase) =>
  Object.keys(statistics).filter((name) => (doc.times[phase]?.[name] ?? []).some((value) => value !== null));

/** The columns of a statistic; only the mean has intervals. @returns {Estimates} */
const timesOf = (times = {}, statistic, count) => {
  const value = times[statistic] ?? new Array(count).fill(null);
  return statistic === 'mean' ? { value, low: times.low, high: times.high } : { value };
};

/** The columns of a ratio: at the points, or at pooled places. @returns {Estimates & Record<string, any>} */
const ratioOf = (ratio, count) => {
  const { is_matched: isMatched, ...columns } = columnsOf(ratio, count);
  return { ...columns, isMatched };
};

function placeRatios({ places }, phase) {
  const count = places.at.length;
  const { cells, of, is_void: isVoid, ...columns } = ratioOf(places.ratios?.[phase], count);
  const value = columns.value ?? new Array(count).fill(null);
  return { ...columns, value, at: places.at, mark: new Array(count).fill(''), isVoid, points: cells, own: of };
}

/**
 * A quantity that can be drawn over the axes: `time:step`, `ratio:step`, `count:pairs`, `memory:peak_rss`.
 * `estimates`: at each point. `pooled`: of a pooled table, with the columns at, mark, isVoid, points, own.
 * @typedef {{id: string, group: string, label: string, estimates: (statistic: string) => Estimates,
 *            pooled: (table: any, statistic: string) => any, pooling: string,
 *            dimension: 'time' | 'bytes' | 'number' | 'ratio'}} Quantity
 */
/** @param {Doc} doc @returns {Quantity[]} */
export function quantities(doc) {
  const points = doc.raw.points ?? {};
  const found = doc.phases.map(({ name, label }) => ({
    id: `time:${name}`,
    group: 'time of a cycle',
    label: label === name ? name : `${name}: ${label}`,
    short: `time of ${name}`,
    pooling: 'mean',
    dimension: 'time',
    estimates: (statistic) => timesOf(doc.times[name], statistic, doc.count),
    pooled: ({ rows }, statistic) => ({ ...rows, ...timesOf(rows.times?.[name], statistic, rows.at.length) }),
  }));
  for (const [phase, ratio] of Object.entries(doc.raw.ratios?.phases ?? {})) {
    const label = `${phase} over that of ${doc.raw.ratios.baseline}`;
    found.push({
      id: `ratio:${phase}`,
      group: 'ratio',
      label,
      short: label,
      pooling: 'geometric mean',
      dimension: 'ratio',
      estimates: () => ratioOf(ratio, doc.count),
      pooled: (table) => placeRatios(table, phase),
    });
  }
  for (const [group, dimension, table] of [
    ['count', 'number', points.counts],
    ['memory', 'bytes', points.memory],
  ]) {
    const pooledGroup = group === 'count' ? 'counts' : group;
    for (const [name, values] of Object.entries(table ?? {})) {
      const value = column(values, doc.count);
      if (value.every((each) => each === null)) continue;
      found.push({
        id: `${group}:${name}`,
        group: group === 'count' ? 'mean of a cycle' : 'memory',
        label: name,
        short: name.replace(/_/g, ' '),
        pooling: group === 'count' ? 'mean' : 'maximum',
        dimension,
        estimates: () => ({ value }),
        pooled: ({ rows }) => ({ ...rows, value: rows[pooledGroup]?.[name] ?? [] }),
      });
    }
  }
  return found;
}

/** A value of an axis as text. @param {Axis} axis @param {number} index */
export const valueText = (axis, index) => {
  const value = axis.values[index];
  if (typeof value !== 'number') return String(value ?? '');
  return Math.abs(value) >= 1e6 ? number(value, 6) : String(axis.labels?.[index] ?? value).replace('-', '−');
};

/** `quantity 400, detector sap`: a point's values on axes with several. @param {Doc} doc @param {number} point */
export function pointText(doc, point) {
  const parts = doc.axes
    .map((axis, a) => [axis, doc.at[point][a]])
    .filter(([axis]) => axis.values.length > 1)
    .map(([axis, i]) => `${axis.name} ${valueText(axis, i)}`);
  return parts.join(', ') || 'the only point';
}

/** Below a scale: the title of the scenario, or name and meaning. @param {Axis} axis */
export const axisTitle = (axis) =>
  (axis.hasTitle || axis.label === axis.name.replace(/_/g, ' ')
    ? short(axis.label, 70)
    : `${axis.name}: ${axis.label}`) +
  (axis.unit ? `, ${axis.unit}` : '');
