// Every phase of a cycle over the axes.
import * as Plot from '@observablehq/plot';
import { textDrawing } from './axis_panels.js';
import { rowsOf, tableOf } from './axis_rows.js';
import { quantities, valueText } from './document.js';
import { timeUnit } from './format.js';
import { describeQuantity, statisticText } from './over_axes.js';
import { noTable } from './pooled.js';
import { extent, labelMargin, poolNotes, rowAxes, scale, unitOf } from './scales.js';

/** One configuration: a row for each phase, on one scale. */
function describePhaseRows(doc, view, how, phases) {
  const parts = phases.map((phase) => rowsOf(doc, view, phase));
  const title = 'Phases of a cycle';
  if (parts.includes(null)) return { title, empty: noTable };
  const found = parts.flatMap(({ rows }, i) =>
    rows.map((row) => ({ ...row, xIndex: i, name: phases[i].id.slice(5) })),
  );
  if (found.length === 0) return { title, empty: 'No point has a value here.' };
  const unit = unitOf(phases[0], extent(found.map((row) => row.value))[1]);
  const { columns, rows } = tableOf(found, [], unit, { short: 'time' });
  const axis = { name: 'phase', isText: true, values: phases.map((phase) => phase.id.slice(5)) };
  return {
    title,
    columns: [{ key: 'name', label: 'phase' }, ...columns],
    rows,
    legend: [],
    ...textDrawing(doc, view, { rows, axes: [axis], how, yLabel: `time, ${unit.unit}`, isSorted: false }),
    notes: [statisticText(doc, view), ...poolNotes(doc, view, { ...parts[0], rows: found }, phases[0])],
  };
}

const stackedPhases = ['broad', 'narrow', 'solve', 'integrate'];

/** The mean times of the phases, stacked, for each text and mark; null if the document did not pool the axes. */
function stackedRows(doc, view, names) {
  const parts = names.map((name) =>
    rowsOf(
      doc,
      view,
      quantities(doc).find((each) => each.id === `time:${name}`),
    ),
  );
  if (parts.includes(null)) return null;
  const totals = new Map();
  const rows = parts.flatMap((part, i) =>
    part.rows
      .filter((row) => !row.isVoid)
      .map((row) => {
        const label = `${valueText(part.axes[0], row.xIndex)}${row.mark ? ` (${row.mark})` : ''}`;
        const y1 = totals.get(label) ?? 0;
        totals.set(label, y1 + row.value);
        return { label, phase: names[i], value: row.value, y1, y2: y1 + row.value };
      }),
  );
  return { rows, totals, first: parts[0] };
}

function stackedPanel(rows, { theme, labels, margin, scaleX, unit }) {
  return ({ width, height }) => ({
    width,
    height,
    ...rowAxes({ margin, x: scaleX, xLabel: `time of a cycle, ${unit}`, domain: labels, padding: 0.3 }),
    marks: [
      Plot.gridX({ ticks: scaleX.ticks, stroke: theme.grid, strokeOpacity: 1 }),
      Plot.barX(rows, { y: 'label', x1: 'y1', x2: 'y2', fill: (row) => theme.phases[row.phase], className: 'hot' }),
    ],
  });
}

/** A horizontal bar for each text, stacked from the phases that make up its step. */
function describeStackedRows(doc, view, { theme, width }) {
  const names = stackedPhases.filter((name) => doc.phases.some((phase) => phase.name === name));
  if (names.length < 2) return { title: 'Phases', empty: '' };
  const stacked = stackedRows(doc, { ...view, statistic: 'mean' }, names);
  if (!stacked) return { title: 'Phases', empty: noTable };
  const { rows: found, totals, first } = stacked;
  const [axis] = first.axes;
  const title = `Phases over ${axis?.name ?? 'the axis'}`;
  if (found.length === 0) return { title, empty: 'No sound point has times of individual phases.' };
  const { unit, factor } = timeUnit(Math.max(...totals.values()));
  const labels = [...totals.keys()].sort((a, b) => totals.get(a) - totals.get(b));
  const margin = labelMargin(labels, width);
  const rows = found.map((row) => ({ ...row, value: row.value / factor, y1: row.y1 / factor, y2: row.y2 / factor }));
  const ends = rows.map((row) => row.y2);
  const scaleX = scale(ends, 'linear', { room: Math.max(3, Math.floor((width - margin) / 70)) });
  return {
    title,
    rows,
    legend: names.map((name) => ({ label: name, colour: theme.phases[name], isArea: true })),
    columns: [
      { key: 'label', label: axis.name },
      { key: 'phase', label: 'phase' },
      { key: 'value', label: `time, ${unit}`, isNumber: true },
    ],
    panels: [
      {
        title: '',
        height: labels.length * 22 + 50,
        options: stackedPanel(rows, { theme, labels, margin, scaleX, unit }),
        hot: { hot: rows.map((_, i) => i) },
      },
    ],
    notes: [
      doc.raw.statistic ?? '',
      ...poolNotes(doc, view, first, { pooling: 'mean' }, { hasIntervals: false }),
    ],
  };
}

/** Every phase in a panel, with the axes of the view but its panels pooled away. */
export function describePhases(doc, view, how) {
  const title = 'Every phase';
  const phases = quantities(doc).filter((each) => each.dimension === 'time');
  if (phases.length < 2) return { title, empty: '' };
  if (view.roles.every((role) => role === 'fixed' || role === 'pooled'))
    return describePhaseRows(doc, view, how, phases);
  const own = { ...view, roles: view.roles.map((role) => (role === 'panel' ? 'pooled' : role)) };
  if (doc.axes[own.roles.indexOf('x')]?.isText && !own.roles.includes('colour'))
    return describeStackedRows(doc, own, how);
  const x = doc.axes[own.roles.indexOf('x')];
  const fit = Math.max(1, Math.min(3, Math.floor(how.width / (x && !x.isText ? 240 : 360))));
  const perRow = Math.ceil(phases.length / Math.ceil(phases.length / fit));
  const small = { ...how, width: (how.width - 22 * (perRow - 1)) / perRow };
  const parts = phases
    .map((phase) => ({
      name: phase.id.slice(5),
      ...describeQuantity(doc, own, small, phase, { height: 210, isSmall: true }),
    }))
    .filter((part) => !part.empty);
  if (parts.length === 0) return { title, empty: 'No point has a value here.' };
  const rows = [];
  const panels = parts.map((part) => {
    const first = rows.length;
    const { name } = part;
    const unit = part.columns
      .find((column) => column.key === 'value')
      .label.split(', ')
      .at(-1);
    rows.push(...part.rows.map((row) => ({ ...row, phase: name, unit })));
    const [panel] = part.panels;
    return {
      ...panel,
      title: name,
      hot: Object.fromEntries(Object.entries(panel.hot).map(([key, list]) => [key, list.map((row) => row + first)])),
    };
  });
  const columns = [
    { key: 'phase', label: 'phase' },
    ...parts[0].columns.map((column) =>
      ['value', 'low', 'high'].includes(column.key)
        ? { ...column, label: column.key === 'value' ? 'time' : column.key }
        : column,
    ),
    { key: 'unit', label: 'unit' },
  ];
  const pooledPanel = view.roles.includes('panel');
  return {
    title: `${title}${parts[0].title.includes(' over ') ? ` over ${parts[0].title.split(' over ').at(-1)}` : ''}`,
    columns,
    rows,
    panels,
    legend: parts[0].legend,
    height: 210,
    perRow,
    notes: [...parts[0].notes, ...(pooledPanel ? ['Here the axis of the panels is pooled.'] : [])],
  };
}
