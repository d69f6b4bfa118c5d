// Access to a results document (version 1), some parts of which may be missing.
import { number } from './format.js';

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

/** @param {any} json @returns {Doc} */
export function openDocument(json) {
  const points = json.points ?? {};
  const at = places(points.at, json.axes ?? []);
  const count = at.length;
  const axes = (json.axes ?? []).map((axis) => ({
    name: String(axis.name),
    label: String(axis.label || axis.name),
    unit: axis.unit ? String(axis.unit) : '',
    isText: axis.is_text ?? axis.values.some((value) => typeof value !== 'number'),
    kind: axis.kind ?? '',
    values: axis.values ?? [],
    labels: axis.value_labels ?? [],
  }));
  const times = {};
  for (const [phase, statistics] of Object.entries(points.times ?? {}))
    times[phase] = Object.fromEntries(
      Object.entries(statistics ?? {}).map(([name, values]) => [name, column(values, count)]),
    );
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
  };
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

/** @param {Doc} doc @param {string} phase @param {string} statistic @returns {Estimates} */
export function phaseTimes(doc, phase, statistic) {
  const times = doc.times[phase] ?? {};
  const value = times[statistic] ?? new Array(doc.count).fill(null);
  return statistic === 'mean' ? { value, low: times.low, high: times.high } : { value };
}

/**
 * A quantity that can be drawn over the axes: `time:step`, `ratio:step`, `count:pairs`, `memory:peak_rss`.
 * @typedef {{id: string, group: string, label: string, estimates: (statistic: string) => Estimates,
 *            mean: 'arithmetic' | 'geometric', dimension: 'time' | 'bytes' | 'number' | 'ratio'}} Quantity
 */
/** @param {Doc} doc @returns {Quantity[]} */
export function quantities(doc) {
  const points = doc.raw.points ?? {};
  const found = doc.phases.map(({ name, label }) => ({
    id: `time:${name}`,
    group: 'time of a cycle',
    label: label === name ? name : `${name}: ${label}`,
    short: `time of ${name}`,
    mean: 'arithmetic',
    dimension: 'time',
    estimates: (statistic) => phaseTimes(doc, name, statistic),
  }));
  for (const [phase, ratio] of Object.entries(doc.raw.ratios?.phases ?? {})) {
    const columns = Object.fromEntries(['value', 'low', 'high'].map((name) => [name, column(ratio[name], doc.count)]));
    const label = `${phase} over that of ${doc.raw.ratios.baseline}`;
    found.push({
      id: `ratio:${phase}`,
      group: 'ratio',
      label,
      short: label,
      mean: 'geometric',
      dimension: 'ratio',
      estimates: () => columns,
    });
  }
  for (const [group, dimension, table] of [
    ['count', 'number', points.counts],
    ['memory', 'bytes', points.memory],
  ])
    for (const [name, values] of Object.entries(table ?? {})) {
      const value = column(values, doc.count);
      if (value.every((each) => each === null)) continue;
      found.push({
        id: `${group}:${name}`,
        group: group === 'count' ? 'mean of a cycle' : 'memory',
        label: name,
        short: name.replace(/_/g, ' '),
        mean: 'arithmetic',
        dimension,
        estimates: () => ({ value }),
      });
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

/** @param {Axis} axis */
export const axisTitle = (axis) =>
  (axis.label === axis.name.replace(/_/g, ' ') ? axis.label : `${axis.name}: ${axis.label}`) +
  (axis.unit ? `, ${axis.unit}` : '');
