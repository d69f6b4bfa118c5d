// The phases of each cycle, stacked (figure 3 of the paper).
import * as Plot from '@observablehq/plot';
import * as d3 from 'd3';
import { columnsOf, cycleScale, layout, panelTitle, parts, usedBins } from './cycle_points.js';
import { pointText } from './document.js';
import { number, timeUnit } from './format.js';
import { extent, scale } from './scales.js';

/** The upper end of the axis if spikes would flatten the rest, otherwise null. */
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

/** The longest cycles, of those given, whose labels do not overlap. */
function apart(rows, last, width) {
  const chosen = [];
  for (const row of [...rows].sort((a, b) => b.y2 - a.y2))
    if (chosen.every((other) => (Math.abs(other.cycle - row.cycle) / Math.max(last, 1)) * width > 64)) chosen.push(row);
  return chosen.slice(0, 4);
}

/** Labels of times beyond the scale; those at an end of the axis stay inside the panel. */
function labelsBeyond(beyond, last, { width, limit, theme }) {
  const labels = apart(beyond, last, width);
  const edge = (28 / width) * Math.max(last, 1);
  const anchorOf = ({ cycle }) => (cycle < edge ? 'start' : cycle > last - edge ? 'end' : 'middle');
  return ['start', 'middle', 'end'].map((textAnchor) =>
    Plot.text(
      labels.filter((row) => anchorOf(row) === textAnchor),
      {
        x: 'cycle',
        y: limit ?? 0,
        text: (row) => `▲\u2009${number(row.y2)}`,
        textAnchor,
        dy: -7,
        fill: theme.ink,
        fontSize: 10,
      },
    ),
  );
}

function stackPanel(rows, { theme, names, y, limit, unit }) {
  return ({ width, height }) => {
    const colours = theme.phases;
    const top = names.at(-1);
    const beyond = limit === null ? [] : rows.filter((row) => row.phase === top && row.y2 > limit);
    return {
      width,
      height,
      marginLeft: 44,
      marginTop: limit === null ? 24 : 36,
      marginBottom: 36,
      marginRight: 10,
      x: cycleScale(width),
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
        ...labelsBeyond(beyond, rows.at(-1)?.cycle ?? 1, { width, limit, theme }),
        Plot.ruleY([0], { stroke: theme.muted }),
      ],
    };
  };
}

/** The phases of each cycle end to end, a panel for each configuration. */
export function describeStack(doc, view, { theme, width }, chosen) {
  const { cycles } = doc.raw;
  const bins = usedBins(cycles, chosen);
  const names = parts.filter((name) => cycles[name]?.some((values) => values?.some((value) => value !== null)));
  const title = 'Phases of each cycle';
  if (names.length === 0) return { title, empty: 'The file has no times of individual cycles.' };
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
    return { title: panelTitle(doc, each), options: stackPanel(own, { theme, names, y, limit, unit }) };
  });
  return {
    title,
    rows,
    panels,
    ...layout(chosen, width),
    columns: columnsOf(unit),
    legend: names.map((name) => ({ label: name, colour: theme.phases[name], isArea: true })),
    notes: limit === null ? [] : ['▲: beyond the scale, with its time.'],
  };
}
