// Scales and notes that the figures share.
import { valueText } from './document.js';
import { byteUnit, number, plural, short, timeUnit } from './format.js';
import { textWidth } from './compose.js';
import { prefersLog } from './pooled.js';

/** @param {number[]} values @returns {[number, number]} */
export function extent(values) {
  let [low, high] = [Infinity, -Infinity];
  for (const value of values) {
    if (value === null || value === undefined || !Number.isFinite(value)) continue;
    low = Math.min(low, value);
    high = Math.max(high, value);
  }
  return low > high ? [0, 1] : [low, high];
}

/** Ticks of a logarithmic scale: powers of ten, with 2 and 5 between them where there is room. */
export function logTicks(low, high, room = 8) {
  const [first, last] = [Math.floor(Math.log10(low)), Math.ceil(Math.log10(high))];
  for (const steps of [[1, 2, 3, 5, 7], [1, 2, 5], [1, 3], [1]]) {
    const ticks = [];
    for (let power = first; power <= last; ++power) for (const step of steps) ticks.push(step * 10 ** power);
    const inside = ticks.filter((tick) => tick >= low * 0.999 && tick <= high * 1.001);
    if (inside.length > room) continue;
    const more = inside.length >= 3 ? inside : finer(low, high);
    return more.length <= room || inside.length < 2 ? more : inside;
  }
  const stride = Math.ceil((last - first + 1) / room);
  return Array.from({ length: Math.ceil((last - first + 1) / stride) }, (_, i) => 10 ** (first + i * stride));
}

/** Multiples of 1, 2 or 5 times a power of ten: the fewest that are three or more. */
function finer(low, high) {
  const most = Math.floor(Math.log10(high - low || low));
  for (let power = most; power > most - 3; --power)
    for (const factor of [5, 2, 1]) {
      const step = factor * 10 ** power;
      const first = Math.ceil((low / step) * (1 - 1e-9));
      const count = Math.floor((high / step) * (1 + 1e-9)) - first + 1;
      if (count >= 3) return Array.from({ length: count }, (_, i) => Number(((first + i) * step).toPrecision(6)));
    }
  return [low, high];
}

/**
 * A scale of Plot for values of a figure.
 * @param {number[]} values
 * @param {'auto' | 'linear' | 'log'} wish
 * @param {{room?: number, ratio?: number, fromZero?: boolean}} [options]
 */
export function scale(values, wish, { room = 7, ratio = 20, fromZero = true } = {}) {
  const [low, high] = extent(values);
  const isLog = low > 0 && (wish === 'log' || (wish === 'auto' && prefersLog([low, high], ratio)));
  if (isLog) {
    const pad = Math.max((high / low) ** 0.06, 1.03);
    const domain = [low / pad, high * pad];
    return { type: 'log', domain, ticks: logTicks(domain[0], domain[1], room), tickFormat: (v) => number(v, 6) };
  }
  const span = high - (fromZero ? Math.min(low, 0) : low) || Math.abs(high) || 1;
  const domain = [fromZero && low >= 0 ? 0 : low - 0.05 * span, high + 0.05 * span];
  return { type: 'linear', domain, ticks: Math.min(room, 6), tickFormat: (v) => number(v) };
}

/** The unit of a quantity whose greatest value is `most`. @param {import('./document.js').Quantity} quantity */
export function unitOf(quantity, most) {
  if (quantity.dimension === 'time') return timeUnit(most);
  if (quantity.dimension === 'bytes') return byteUnit(most);
  return { unit: '', factor: 1 };
}

/** Evenly spaced values, for values of many magnitudes that are not all positive, which no other scale shows. */
function evenScale(values) {
  const sorted = [...values].sort((a, b) => a - b);
  const index = new Map(sorted.map((value, i) => [value, i]));
  return {
    type: 'linear',
    domain: [-0.3, sorted.length - 0.7],
    ticks: sorted.map((_, i) => i),
    tickFormat: (i) => number(sorted[i], 4),
    place: (v) => index.get(v),
    isEven: true,
  };
}

/** The x axis for an axis of numbers: a tick at each value for which there is room. */
export function valueScale(values, wish, width) {
  const [low, high] = extent(values);
  const isLog = low > 0 && (wish === 'log' || (wish === 'auto' && values.length > 2 && high / low >= 8));
  const sizes = values.map(Math.abs).filter((size) => size > 0);
  if (low <= 0 && wish === 'auto' && values.length > 2 && extent(sizes)[1] / extent(sizes)[0] >= 50)
    return evenScale(values);
  const into = isLog ? Math.log : (v) => v;
  const pad = (into(high) - into(low)) * 0.04 || (isLog ? 0.2 : Math.abs(high) * 0.2 || 1);
  const out = isLog ? Math.exp : (v) => v;
  const domain = [out(into(low) - pad), out(into(high) + pad)];
  const ticks = [];
  let last = -Infinity;
  for (const value of [...values].sort((a, b) => a - b)) {
    const x = ((into(value) - into(domain[0])) / (into(domain[1]) - into(domain[0]))) * width;
    const half = textWidth(number(value, 6), 11) / 2 + 5;
    if (x - half < last) continue;
    ticks.push(value);
    last = x + half;
  }
  return { type: isLog ? 'log' : 'linear', domain, ticks, tickFormat: (v) => number(v, 6), place: (v) => v };
}

/** Room for the labels of rows on the left. */
export function labelMargin(labels, width) {
  const widest = labels.reduce((most, label) => Math.max(most, textWidth(short(label, 34), 11)), 20);
  return Math.ceil(Math.min(widest + 14, Math.max(70, width * 0.38)));
}

/** Labels of rows, shortened to fit the margin. */
const rowLabel = (label, margin) => {
  let most = 34;
  while (most > 6 && textWidth(short(label, most), 11) > margin - 12) --most;
  return short(label, most);
};

/** The axis of labelled rows. */
export const rowBand = ({ margin, domain, labelOf = (label) => label, padding }) => ({
  type: 'band',
  domain,
  tickFormat: (value) => rowLabel(labelOf(value), margin),
  label: null,
  tickSize: 0,
  padding,
});

/** The margins and axes of a panel of labelled rows, with the scale `x` of numbers below. */
export const rowAxes = ({ margin, marginRight = 14, x, xLabel, ...rows }) => ({
  marginLeft: margin,
  marginRight,
  marginTop: 6,
  marginBottom: 38,
  x: { ...x, label: xLabel, labelAnchor: 'right', labelArrow: 'right' },
  y: rowBand({ margin, ...rows }),
});

/** `quantity 400` for the fixed axes of several values. */
export function fixedText(doc, view) {
  return doc.axes
    .map((axis, a) =>
      view.roles[a] === 'fixed' && axis.values.length > 1
        ? `${axis.name} ${short(valueText(axis, view.at[a]), 40)}`
        : '',
    )
    .filter(Boolean)
    .join(', ');
}

/** `Bars: 95 % interval, by bootstrap over the 9 repeats.` */
export function intervalText(doc) {
  const { name, text } = doc.raw.interval ?? {};
  const how = text ? `${text[0].toLowerCase()}${text.slice(1)}` : '';
  if (name && how.startsWith(name)) return `Bars: ${how}`;
  return `Bars: ${name ?? 'interval'}${how ? `, ${how}` : '.'}`;
}

/**
 * Notes on pooling and intervals, shown below a figure.
 * @param {{rows: any[], pooled: number[], isUnmatched: boolean}} found
 */
export function poolNotes(doc, view, { rows, pooled, isUnmatched }, quantity, { hasIntervals = true } = {}) {
  const notes = [];
  const fixed = fixedText(doc, view);
  if (fixed) notes.push(`At ${fixed}.`);
  if (pooled.length && rows.length) {
    const [least, most] = extent(rows.map((row) => row.points));
    const names = pooled.map((a) => doc.axes[a].name).join(', ');
    notes.push(
      `Pooled over ${names}: ${quantity.pooling} of ${least === most ? '' : `${least} to `}${plural(most, 'point')}` +
        (isUnmatched
          ? '; no cell is common to all marks, so that each has its own points.'
          : rows.some((row) => row.points < row.own)
            ? ', the cells that all marks have.'
            : '.'),
    );
  }
  if (hasIntervals) {
    if (rows.some((row) => row.low !== null)) notes.push(intervalText(doc));
    else
      notes.push(
        'No intervals: ' +
          (view.statistic === 'mean' || quantity.dimension === 'ratio'
            ? 'one repeat.'
            : 'they are made for the mean only.'),
      );
  }
  const marks = [...new Set(rows.filter((row) => row.mark && !row.isVoid).map((row) => row.mark))];
  if (rows.some((row) => row.isVoid)) {
    const words = [...new Set(rows.filter((row) => row.isVoid).map((row) => row.mark || 'void'))]
      .slice(0, 5)
      .join('; ');
    notes.push(`Hollow: the verdict voids the time (${short(words, 120)}); not joined, not pooled with sound points.`);
  }
  if (marks.length) notes.push(`In a ring: ${short(marks.slice(0, 5).join('; '), 120)}.`);
  return notes;
}

/** A row of a figure's table as a line of text. @param {{key: string, label: string, isNumber?: boolean}[]} columns */
export function describeRow(columns, row) {
  return columns
    .filter((column) => row[column.key] !== null && row[column.key] !== undefined && row[column.key] !== '')
    .map((column) => [
      column.label,
      typeof row[column.key] === 'number' ? number(row[column.key], 4) : String(row[column.key]),
    ]);
}
