// Times of each cycle as lines.
import * as Plot from '@observablehq/plot';
import { columnsOf, cycleScale, layout, panelTitle, parts, phaseOf, usedBins } from './cycle_points.js';
import { pointText } from './document.js';
import { timeUnit } from './format.js';
import { style } from './palette.js';
import { extent, scale } from './scales.js';

const symbolsPerLine = 9;

/** A line for each series, with some symbols that distinguish lines without colours. */
function lines(series) {
  return series.flatMap(({ rows, colour, dash, symbol }, k) => {
    const stride = Math.max(1, Math.ceil(rows.length / symbolsPerLine));
    const first = Math.floor((stride * k) / series.length);
    return [
      Plot.line(rows, { x: 'cycle', y: 'value', stroke: colour, strokeWidth: 1.3, strokeDasharray: dash ?? undefined }),
      Plot.dot(
        rows.filter((row, i) => i % stride === first && row.value !== null),
        { x: 'cycle', y: 'value', fill: colour, symbol, r: 3 },
      ),
    ];
  });
}

function linePanel(series, { theme, y, label }) {
  return ({ width, height }) => ({
    width,
    height,
    marginLeft: 46,
    marginTop: 24,
    marginBottom: 36,
    marginRight: 10,
    x: cycleScale(width),
    y: { ...y, label, labelArrow: 'up' },
    marks: [Plot.gridY({ ticks: y.ticks, stroke: theme.grid, strokeOpacity: 1 }), ...lines(series)],
  });
}

/** Rows of a phase of a configuration, in the unit of the figure. */
function rowsOf(doc, { bins, phase, each, factor }) {
  return bins.map(([from, to], b) => {
    const value = doc.raw.cycles[phase]?.[each.entry]?.[b] ?? null;
    return {
      place: pointText(doc, each.point),
      cycle: (from + to - 1) / 2,
      phase,
      value: value === null ? null : value / factor,
    };
  });
}

/** One phase of several configurations. */
export function describeLines(doc, view, { theme: plain }, chosen) {
  const theme = { ...plain, highlight: view.highlight };
  const phase = phaseOf(doc, view);
  const title = `Time of ${phase} in each cycle`;
  const values = doc.raw.cycles[phase];
  if (!values) return { title, empty: `The file has no times of ${phase} of individual cycles.` };
  const bins = usedBins(doc.raw.cycles, chosen);
  const { unit, factor } = timeUnit(extent(chosen.flatMap(({ entry }) => values[entry] ?? []))[1]);
  const series = chosen.map((each) => ({
    rows: rowsOf(doc, { bins, phase, each, factor }),
    label: each.label,
    ...style(theme, each.colour),
  }));
  const rows = series.flatMap((each) => each.rows);
  const drawn = rows.map((row) => row.value);
  return {
    title,
    rows,
    panels: [
      {
        title: '',
        options: linePanel(series, {
          theme,
          y: scale(drawn, view.yScale, { ratio: 8 }),
          label: `time of ${phase}, ${unit}`,
        }),
      },
    ],
    height: 320,
    notes: [],
    columns: columnsOf(unit),
    legend: series
      .filter((each) => each.label)
      .map(({ label, colour, dash, symbol }) => ({ label, colour, dash, symbol })),
  };
}

/** Each phase as a line, a panel for each configuration. */
export function describePhaseLines(doc, view, { theme, width }, chosen) {
  const { cycles } = doc.raw;
  const bins = usedBins(cycles, chosen);
  const names = [...parts, 'step'].filter((name) =>
    chosen.some(({ entry }) => cycles[name]?.[entry]?.some((value) => value !== null)),
  );
  const title = 'Phases of each cycle';
  if (names.length === 0) return { title, empty: 'The file has no times of individual cycles.' };
  const all = chosen.flatMap(({ entry }) => names.flatMap((name) => cycles[name][entry] ?? []));
  const { unit, factor } = timeUnit(extent(all)[1]);
  const y = scale(
    all.map((value) => (value === null ? null : value / factor)),
    view.yScale,
    { ratio: 8 },
  );
  const looks = names.map((name, i) => ({ ...style(theme, i), colour: theme.phases[name], label: name }));
  const panels = chosen.map((each) => ({
    each,
    series: names.map((phase, i) => ({ ...looks[i], rows: rowsOf(doc, { bins, phase, each, factor }) })),
  }));
  return {
    title,
    rows: panels.flatMap(({ series }) => series.flatMap((each) => each.rows)),
    panels: panels.map(({ each, series }) => ({
      title: panelTitle(doc, each),
      options: linePanel(series, { theme, y, label: `time, ${unit}` }),
    })),
    ...layout(chosen, width),
    notes: [],
    columns: columnsOf(unit),
    legend: looks.map(({ label, colour, symbol, dash }) => ({ label, colour, symbol, dash })),
  };
}
