// Times over the cycles of runs (figure 3 of the paper): phases stacked, or one phase of several configurations.
import * as Plot from '@observablehq/plot';
import * as d3 from 'd3';
import { pointText, valueText } from './document.js';
import { number, short, timeUnit } from './format.js';
import { phaseColours, style } from './palette.js';
import { extent, scale } from './scales.js';

const parts = ['broad', 'narrow', 'solve', 'integrate'];

/** The phase that the view is about. */
export function phaseOf(doc, view) {
  const name = view.quantity.split(':')[1];
  if (doc.phases.some((phase) => phase.name === name)) return name;
  return (
    ['step', 'detect'].find((each) => doc.phases.some((phase) => phase.name === each)) ?? doc.phases[0]?.name ?? 'step'
  );
}

/**
 * Of the points that a part of the document has, one for each colour: the nearest to the values of the view.
 * @param {number[]} available @returns {{entry: number, point: number, colour: number}[]}  entry: position in `available`
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
      label: colour < 0 ? '' : `${doc.axes[colour].name} ${valueText(doc.axes[colour], each.colour)}`,
    }));
}

/** Where the points are on the other axes: `quantity 400`. */
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

/** Above this a spike would flatten the rest. */
function limitOf(totals) {
  const sorted = totals.filter((value) => value !== null).sort((a, b) => a - b);
  const usual = d3.quantileSorted(sorted, 0.98) ?? 0;
  const most = sorted.at(-1) ?? 0;
  return most > 3 * usual && usual > 0 ? 1.6 * usual : null;
}

function stacked(cycles, bins, { entry }, names, factor) {
  return bins.flatMap(([from, to], b) => {
    let sum = 0;
    return names.map((name) => {
      const value = cycles[name]?.[entry]?.[b] ?? null;
      const y1 = sum;
      sum += (value ?? 0) / factor;
      return { cycle: (from + to - 1) / 2, phase: name, value: value === null ? null : value / factor, y1, y2: sum };
    });
  });
}

/** The greatest of some cycles whose labels do not meet. */
function apart(rows, last, width) {
  const chosen = [];
  for (const row of [...rows].sort((a, b) => b.y2 - a.y2))
    if (chosen.every((other) => (Math.abs(other.cycle - row.cycle) / Math.max(last, 1)) * width > 56)) chosen.push(row);
  return chosen.slice(0, 4);
}

function stackPanel(rows, { theme, names, y, limit, unit }) {
  return ({ width, height }) => {
    const colours = phaseColours(theme);
    const top = names.at(-1);
    const beyond = limit === null ? [] : rows.filter((row) => row.phase === top && row.y2 > limit);
    return {
      width,
      height,
      marginLeft: 44,
      marginTop: limit === null ? 24 : 36,
      marginBottom: 36,
      marginRight: 10,
      x: {
        label: 'cycle',
        labelAnchor: 'right',
        labelArrow: 'right',
        tickFormat: (v) => String(v),
        ticks: Math.max(2, Math.floor(width / 80)),
      },
      y: { ...y, label: `time, ${unit}`, labelArrow: 'up' },
      marks: [
        Plot.gridY({ ticks: y.ticks, stroke: theme.grid, strokeOpacity: 1 }),
        ...names.map((name) =>
          Plot.areaY(
            rows.filter((row) => row.phase === name),
            {
              x: 'cycle',
              y1: (row) => Math.min(row.y1, limit ?? Infinity),
              y2: (row) => Math.min(row.y2, limit ?? Infinity),
              fill: colours[name],
              className: `phase-${name}`,
            },
          ),
        ),
        Plot.text(apart(beyond, rows.at(-1)?.cycle ?? 1, width), {
          x: 'cycle',
          y: limit ?? 0,
          text: (row) => `▲\u2009${number(row.y2)}`,
          dx: 3,
          dy: -7,
          fill: theme.ink,
          fontSize: 10,
        }),
        Plot.ruleY([0], { stroke: theme.muted }),
      ],
    };
  };
}

/** The bins up to the last one with a value. */
function usedBins(cycles, chosen) {
  const bins = cycles.bins ?? [];
  const phases = Object.keys(cycles).filter((name) => !['points', 'of', 'bins'].includes(name));
  const isUsed = (_, b) => chosen.some(({ entry }) => phases.some((name) => cycles[name]?.[entry]?.[b] != null));
  return bins.slice(0, bins.findLastIndex(isUsed) + 1);
}

function describeStack(doc, view, { theme, width }, chosen) {
  const { cycles } = doc.raw;
  const bins = usedBins(cycles, chosen);
  const names = parts.filter((name) => cycles[name]?.some((values) => values?.some((value) => value !== null)));
  const title = 'Phases of each cycle';
  if (names.length === 0) return { title, empty: 'The file has no times of single cycles.' };
  const totals = chosen.flatMap(({ entry }) =>
    bins.map((_, b) => names.reduce((sum, name) => sum + (cycles[name]?.[entry]?.[b] ?? 0), 0)),
  );
  const { unit, factor } = timeUnit(extent(totals)[1]);
  const capped = limitOf(totals);
  const limit = capped === null ? null : capped / factor;
  const y = scale([0, limit ?? extent(totals)[1] / factor], 'linear', { room: 5 });
  if (limit !== null) y.domain = [0, limit];
  const rows = [];
  const panels = chosen.map((each) => {
    const own = stacked(cycles, bins, each, names, factor);
    rows.push(...own.map((row) => ({ ...row, place: pointText(doc, each.point) })));
    const mark = doc.isVoid[each.point] ? ` (void: ${doc.mark[each.point]})` : '';
    return { title: each.label + mark, options: stackPanel(own, { theme, names, y, limit, unit }) };
  });
  const perRow = Math.max(1, Math.min(chosen.length, chosen.length > 4 ? 4 : 3, Math.floor(width / 250)));
  return {
    title,
    rows,
    panels,
    perRow,
    height: chosen.length === 1 ? 300 : chosen.length > 8 ? 150 : 200,
    columns: [
      { key: 'place', label: 'point' },
      { key: 'cycle', label: 'cycle', isNumber: true },
      { key: 'phase', label: 'phase' },
      { key: 'value', label: `time, ${unit}`, isNumber: true },
    ],
    legend: names.map((name) => ({ label: name, colour: phaseColours(theme)[name], isArea: true })),
    notes: limit === null ? [] : ['▲: beyond the scale, with its time.'],
  };
}

function describeLines(doc, view, { theme: plain, width }, chosen) {
  const theme = { ...plain, highlight: view.highlight };
  const { cycles } = doc.raw;
  const phase = phaseOf(doc, view);
  const title = `Time of ${phase} in each cycle`;
  const values = cycles[phase];
  if (!values) return { title, empty: `The file has no times of ${phase} of single cycles.` };
  const all = chosen.flatMap(({ entry }) => values[entry] ?? []);
  const { unit, factor } = timeUnit(extent(all)[1]);
  const y = scale(
    all.map((value) => (value === null ? null : value / factor)),
    view.yScale,
    { ratio: 8 },
  );
  const rows = chosen.flatMap((each) =>
    usedBins(cycles, chosen).map(([from, to], b) => ({
      colour: each.colour,
      label: each.label,
      place: pointText(doc, each.point),
      cycle: (from + to - 1) / 2,
      value: values[each.entry]?.[b] == null ? null : values[each.entry][b] / factor,
    })),
  );
  const options = ({ width: w, height }) => ({
    width: w,
    height,
    marginLeft: 46,
    marginTop: 24,
    marginBottom: 36,
    marginRight: 10,
    x: {
      label: 'cycle',
      labelAnchor: 'right',
      labelArrow: 'right',
      ticks: Math.max(2, Math.floor(width / 90)),
      tickFormat: (v) => String(v),
    },
    y: { ...y, label: `time of ${phase}, ${unit}`, labelArrow: 'up' },
    marks: [
      Plot.gridY({ ticks: y.ticks, stroke: theme.grid, strokeOpacity: 1 }),
      ...chosen.map((each) =>
        Plot.line(
          rows.filter((row) => row.colour === each.colour),
          {
            x: 'cycle',
            y: 'value',
            stroke: style(theme, each.colour).colour,
            strokeWidth: 1.3,
            strokeDasharray: style(theme, each.colour).dash ?? undefined,
          },
        ),
      ),
    ],
  });
  return {
    title,
    rows,
    panels: [{ title: '', options }],
    height: 320,
    notes: [],
    columns: [
      { key: 'place', label: 'point' },
      { key: 'cycle', label: 'cycle', isNumber: true },
      { key: 'value', label: `time of ${phase}, ${unit}`, isNumber: true },
    ],
    legend: chosen
      .filter((each) => each.label)
      .map((each) => ({
        label: each.label,
        colour: style(theme, each.colour).colour,
        dash: style(theme, each.colour).dash,
      })),
  };
}

export function describeCycles(doc, view, how) {
  const { cycles } = doc.raw;
  const available = cycles?.points ?? (cycles ? doc.at.map((_, i) => i) : []);
  if (!cycles || available.length === 0)
    return { title: 'Over the cycles', empty: 'This document has no times of single cycles.' };
  const chosen = representatives(doc, view, available);
  const drawing = (view.cycles === 'phases' ? describeStack : describeLines)(doc, view, how, chosen);
  if (drawing.empty) return drawing;
  const widest = Math.max(...usedBins(cycles, chosen).map(([from, to]) => to - from), 1);
  const where = whereText(doc, view, chosen);
  const repeats = doc.raw.runs?.repeats ?? 1;
  return {
    ...drawing,
    notes: [
      `Each cycle: ${repeats > 1 ? 'median over the repeats' : 'one repeat'}${widest > 1 ? `, averaged over up to ${widest} cycles` : ''}.`,
      ...(where ? [`At ${where}.`] : []),
      ...drawing.notes,
      ...(available.length < doc.count
        ? [`The page has the cycles of ${available.length} of ${doc.count} points.`]
        : []),
    ],
  };
}
