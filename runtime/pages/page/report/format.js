// Formats numbers and names for readers.

/** @typedef {{unit: string, factor: number}} Unit  a value divided by `factor` is in `unit` */

const superscripts = '⁰¹²³⁴⁵⁶⁷⁸⁹';
const superscript = (n) => (n < 0 ? '⁻' : '') + String(Math.abs(n)).replace(/\d/g, (d) => superscripts[d]);

/**
 * Up to `digits` significant digits; a power of ten from `most` on; a dash for a missing number.
 * @param {number | null | undefined} value
 */
export function number(value, digits = 3, most = 1e6) {
  if (value === null || value === undefined || Number.isNaN(value)) return '–';
  if (!Number.isFinite(value)) return value > 0 ? '∞' : '−∞';
  if (value === 0) return '0';
  const size = Math.abs(value);
  if (size >= most || size < 1e-3) {
    const [mantissa, exponent] = value.toExponential(digits - 1).split('e');
    const short = String(Number(mantissa));
    const power = `10${superscript(Number(exponent))}`;
    return short === '1' ? power : short === '-1' ? `−${power}` : `${short.replace('-', '−')} × ${power}`;
  }
  const rounded = Number(value.toPrecision(Math.max(digits, size >= 1 ? Math.floor(Math.log10(size)) + 1 : 1)));
  return String(rounded).replace('-', '−');
}

/** A whole number in groups of three. @param {number | null | undefined} value */
export function count(value) {
  if (value === null || value === undefined) return '–';
  return String(value).replace(/\B(?=(\d{3})+$)/g, '\u202f');
}

/** `a .. b` @param {number | null | undefined} low @param {number | null | undefined} high */
export function range(low, high) {
  return low === null || low === undefined || high === null || high === undefined
    ? ''
    : `${number(low)} .. ${number(high)}`;
}

/** The unit in which the largest of some times, in ns, is at least 1. @param {number} most @returns {Unit} */
export function timeUnit(most) {
  if (most >= 1e9) return { unit: 's', factor: 1e9 };
  if (most >= 1e6) return { unit: 'ms', factor: 1e6 };
  if (most >= 1e3) return { unit: 'µs', factor: 1e3 };
  return { unit: 'ns', factor: 1 };
}

/** The units of the terminal's tables. @param {number} most bytes @returns {Unit} */
export function byteUnit(most) {
  if (most >= 1e9) return { unit: 'GB', factor: 1e9 };
  if (most >= 1e6) return { unit: 'MB', factor: 1e6 };
  if (most >= 1e3) return { unit: 'kB', factor: 1e3 };
  return { unit: 'bytes', factor: 1 };
}

/** One line of text for a figure: at most `most` characters, without control and bidirectional characters. */
export function short(text, most = 28) {
  const plain = String(text).replace(/[\u0000-\u001f\u007f-\u009f\u200e\u200f\u202a-\u202e\u2066-\u2069]+/g, ' ');
  const letters = [...plain];
  return letters.length <= most ? plain : `${letters.slice(0, most - 1).join('')}…`;
}

/** A cell of CSV (RFC 4180). @param {unknown} value */
function csvCell(value) {
  if (value === null || value === undefined) return '';
  const text = String(value);
  return /[",\r\n]/.test(text) ? `"${text.replace(/"/g, '""')}"` : text;
}

/** @param {{key: string, label: string}[]} columns @param {Record<string, unknown>[]} rows */
export function csv(columns, rows) {
  const lines = [columns.map((column) => csvCell(column.label))];
  for (const row of rows) lines.push(columns.map((column) => csvCell(row[column.key])));
  return lines.map((line) => `${line.join(',')}\r\n`).join('');
}

/** `1 run`, `2 runs` @param {number} n @param {string} noun */
export const plural = (n, noun) => `${count(n)} ${noun}${n === 1 ? '' : 's'}`;
