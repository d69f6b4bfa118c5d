// The points that represent a sweep in figures over single cycles, and helpers shared by these figures.
import { valueText } from './document.js';
import { short } from './format.js';

/** Phases that make up a step, in the order in which they run. */
export const parts = ['broad', 'narrow', 'solve', 'integrate'];

/** The phase that the view shows. */
export function phaseOf(doc, view) {
  const name = view.quantity.split(':')[1];
  if (doc.phases.some((phase) => phase.name === name)) return name;
  return (
    ['step', 'detect'].find((each) => doc.phases.some((phase) => phase.name === each)) ?? doc.phases[0]?.name ?? 'step'
  );
}

/** `sap`, `quantity 400` */
const labelOf = (axis, i) => (axis.isText ? valueText(axis, i) : `${axis.name} ${valueText(axis, i)}`);

/**
 * One point for each colour, of those that a part of the document has: the nearest to the values of the view.
 * @param {number[]} available
 * @returns {{entry: number, point: number, colour: number}[]}  entry: position in `available`
 */
export function representatives(doc, view, available) {
  const colour =
    view.roles.indexOf('colour') >= 0
      ? view.roles.indexOf('colour')
      : view.roles.findIndex((role, a) => role === 'x' && doc.axes[a].isText);
  const best = new Map();
  available.forEach((point, entry) => {
    const misses = doc.axes.reduce((sum, _, a) => sum + (a !== colour && doc.at[point][a] !== view.at[a] ? 1 : 0), 0);
    const key = colour < 0 ? -1 : doc.at[point][colour];
    if (!best.has(key) || misses < best.get(key).misses) best.set(key, { entry, point, colour: key, misses });
  });
  return [...best.values()]
    .sort((a, b) => a.colour - b.colour)
    .map((each) => ({
      ...each,
      label: colour < 0 ? '' : labelOf(doc.axes[colour], each.colour),
    }));
}

/** The coordinates of the points on the other axes: `quantity 400`. */
export function whereText(doc, view, chosen) {
  const [first] = chosen;
  if (!first) return '';
  const same = doc.axes
    .map((axis, a) => [axis, a])
    .filter(
      ([axis, a]) => axis.values.length > 1 && chosen.every(({ point }) => doc.at[point][a] === doc.at[first.point][a]),
    );
  return same.map(([axis, a]) => `${axis.name} ${short(valueText(axis, doc.at[first.point][a]), 40)}`).join(', ');
}

/** The bins up to the last one with a value. */
export function usedBins(cycles, chosen) {
  const bins = cycles.bins ?? [];
  const phases = Object.keys(cycles).filter((name) => !['points', 'of', 'bins'].includes(name));
  const isUsed = (_, b) => chosen.some(({ entry }) => phases.some((name) => cycles[name]?.[entry]?.[b] != null));
  return bins.slice(0, bins.findLastIndex(isUsed) + 1);
}

/** The x axis. @param {number} width px */
export const cycleScale = (width) => ({
  label: 'cycle',
  labelAnchor: 'right',
  labelArrow: 'right',
  ticks: Math.max(2, Math.floor(width / 80)),
  tickFormat: (v) => String(v),
});

/** The layout of the panels of some configurations. */
export const layout = (chosen, width) => ({
  perRow: Math.max(1, Math.min(chosen.length, chosen.length > 4 ? 4 : 3, Math.floor(width / 250))),
  height: chosen.length === 1 ? 300 : chosen.length > 8 ? 150 : 200,
});

/** @param {string} unit  of the times */
export const columnsOf = (unit) => [
  { key: 'place', label: 'point' },
  { key: 'cycle', label: 'cycle', isNumber: true },
  { key: 'phase', label: 'phase' },
  { key: 'value', label: `time, ${unit}`, isNumber: true },
];

/** The title of a panel. */
export const panelTitle = (doc, { label, point }) => label + (doc.isVoid[point] ? ` (void: ${doc.mark[point]})` : '');
