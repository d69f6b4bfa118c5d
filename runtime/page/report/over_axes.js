// A quantity over the axes: lines over numbers, dots in rows over texts (figures 4 and 5 of the paper).
import * as Plot from '@observablehq/plot';
import { axisTitle, quantities, valueText } from './document.js';
import { short, timeUnit } from './format.js';
import { phaseColours, style } from './palette.js';
import { group, pool, thin } from './pool.js';
import { extent, labelMargin, poolNotes, rowLabel, scale, unitOf, valueScale } from './scales.js';
import { statistics } from './document.js';

const mostMarks = 600; // of a series; longer ones are drawn in bins

const text = (axis, i) => (i < 0 ? '' : valueText(axis, i));

/** The rows that a figure draws, one for each group of points, in order of panel, colour, x. */
export function rowsOf(doc, view, quantity) {
  const estimates = quantity.estimates(view.statistic);
  const grouped = group(doc, view, estimates.value);
  const axes = ['x', 'colour', 'panel'].map((role) => doc.axes[view.roles.indexOf(role)]);
  const rows = [];
  for (const each of grouped.groups) {
    const pooled = pool(each.points, estimates, quantity.mean);
    if (pooled === null) continue;
    rows.push({ ...each, ...pooled, x: each.x < 0 ? 0 : axes[0].isText ? each.x : axes[0].values[each.x], xIndex: each.x,
      points: each.points.length, own: each.own });
  }
  rows.sort((a, b) => a.panel - b.panel || a.colour - b.colour || (axes[0]?.isText ? 0 : a.x - b.x) || a.xIndex - b.xIndex);
  return { rows, grouped, axes };
}

/** Columns of the table, in the unit of the figure. */
function tableOf(rows, axes, unit, quantity) {
  const [x, colour, panel] = axes;
  const columns = [];
  const add = (key, label, isNumber = false) => columns.push({ key, label, isNumber });
  if (panel) add('panelText', panel.name);
  if (colour) add('colourText', colour.name);
  if (x) add('xText', x.name, !x.isText);
  const suffix = unit.unit ? `, ${unit.unit}` : '';
  add('value', `${quantity.short}${suffix}`, true);
  if (rows.some((row) => row.low !== null)) {
    add('low', `low${suffix}`, true);
    add('high', `high${suffix}`, true);
  }
  if (rows.some((row) => row.points > 1)) add('points', 'points', true);
  if (rows.some((row) => row.mark)) add('mark', 'mark');
  const scaled = (value) => (value === null ? null : value / unit.factor);
  return { columns, rows: rows.map((row) => ({ ...row, panelText: text(panel, row.panel), colourText: text(colour, row.colour),
    xText: !x ? '' : x.isText ? text(x, row.xIndex) : row.x, value: scaled(row.value), low: scaled(row.low), high: scaled(row.high) })) };
}

function legendOf(rows, colour, theme, isRows) {
  if (!colour) return [];
  return [...new Set(rows.map((row) => row.colour))].sort((a, b) => a - b).map((i) => {
    const { colour: ink, symbol, dash } = style(theme, i);
    return { label: colour.isText ? valueText(colour, i) : `${colour.name} ${valueText(colour, i)}`, colour: ink, symbol, ...(isRows ? {} : { dash }) };
  });
}

/** Runs of neighbours of a series with the same mark, which a line may join. */
function seriesOf(rows) {
  const series = new Map();
  for (const row of rows) {
    if (row.isVoid) continue;
    const key = `${row.colour} ${row.mark}`;
    series.set(key, [...(series.get(key) ?? []), row]);
  }
  return [...series.values()];
}

function dots(rows, theme, at, className = 'hot') {
  const styleOf = (row) => style(theme, row.colour);
  return [
    Plot.dot(rows.filter((row) => row.mark && !row.isVoid), { ...at, r: 7.5, stroke: (row) => styleOf(row).colour, strokeWidth: 1 }),
    Plot.dot(rows, { ...at, className, strokeWidth: 1.6, r: 3.8, symbol: (row) => styleOf(row).symbol, stroke: (row) => styleOf(row).colour,
      fill: (row) => (row.isVoid ? theme.background : styleOf(row).colour) }),
  ];
}

const coloursOf = (rows) => [...new Set(rows.map((row) => row.colour))].sort((a, b) => a - b);
/** The rows of the table that the marks of each colour are of. */
const hotOf = (rows, colours) => Object.fromEntries(colours.map((c) => [`hot-${c + 1}`, rows.filter((row) => row.colour === c).map((row) => row.index)]));

/** Marks of the same x stand side by side, so that none hides another. */
const asides = (colours) => (colour) => (colours.indexOf(colour) - (colours.length - 1) / 2) * Math.min(4, 16 / colours.length);

/** Lines over an axis of numbers. */
function linePanel(rows, { theme, colours, x, y, xLabel, yLabel }) {
  const aside = asides(colours);
  return ({ width, height }) => {
    const scaleX = x(width - 58);
    const at = (row) => scaleX.place(row.x);
    const marks = [Plot.gridY({ ticks: y.ticks, stroke: theme.grid, strokeOpacity: 1 })];
    const isThin = rows.length > mostMarks;
    const isLast = (i) => Number(i === theme.highlight);
    for (const series of seriesOf(rows).sort((a, b) => isLast(a[0].colour) - isLast(b[0].colour))) {
      const { colour, dash } = style(theme, series[0].colour);
      const dx = aside(series[0].colour);
      const shown = series.length > mostMarks ? thin(series, mostMarks / 2) : series;
      if (series.length > mostMarks) marks.push(Plot.areaY(shown, { x: at, y1: 'low', y2: 'high', fill: colour, fillOpacity: 0.2 }));
      else marks.push(Plot.ruleX(series.filter((row) => row.low !== null), { x: at, y1: 'low', y2: 'high', dx, stroke: colour, strokeWidth: 1.3 }));
      if (series.length > 1) marks.push(Plot.line(shown, { x: at, y: 'value', dx, stroke: colour, strokeWidth: 1.6, strokeDasharray: dash ?? undefined }));
    }
    if (!isThin) for (const i of [...colours].sort((a, b) => isLast(a) - isLast(b)))
      marks.push(...dots(rows.filter((row) => row.colour === i), theme, { x: at, y: 'value', dx: aside(i) }, `hot hot-${i + 1}`));
    return { width, height, marginLeft: 46, marginTop: 24, marginBottom: 38, marginRight: 12,
      x: { ...scaleX, label: scaleX.isEven ? `${xLabel}, evenly spaced` : xLabel, labelAnchor: 'right', labelArrow: 'right' },
      y: { ...y, label: yLabel, labelArrow: 'up' }, marks };
  };
}

/** Dots in rows: texts down, the quantity along. */
function rowPanel(rows, { theme, scaleX, rowsShown, label, margin, xLabel }) {
  return ({ width, height }) => {
    const y = (row) => row.xIndex;
    const spread = rowsShown.colours.length > 1 ? Math.min(18 / rowsShown.colours.length, 6) : 0;
    const lift = (row) => (rowsShown.colours.indexOf(row.colour) - (rowsShown.colours.length - 1) / 2) * spread;
    const marks = [Plot.gridX({ ticks: scaleX.ticks, stroke: theme.grid, strokeOpacity: 1 }),
      Plot.ruleY(rowsShown.values, { y: (i) => i, stroke: theme.grid, strokeDasharray: '1 3' })];
    for (const colour of rowsShown.colours) {
      const own = rows.filter((row) => row.colour === colour);
      const dy = own.length ? lift(own[0]) : 0;
      marks.push(Plot.ruleY(own.filter((row) => row.low !== null), { y, x1: 'low', x2: 'high', dy, stroke: style(theme, colour).colour, strokeWidth: 1.4 }));
      marks.push(...dots(own, theme, { y, x: 'value', dy }, `hot hot-${colour + 1}`));
    }
    return { width, height, marginLeft: margin, marginRight: 14, marginTop: 6, marginBottom: 38,
      x: { ...scaleX, label: scaleX.isEven ? `${xLabel}, evenly spaced` : xLabel, labelAnchor: 'right', labelArrow: 'right' },
      y: { type: 'band', domain: rowsShown.values, tickFormat: (i) => rowLabel(label(i), margin), label: null, tickSize: 0 }, marks };
  };
}

function textDrawing(doc, view, { rows, axes, how, yLabel, isSorted = true }) {
  const [x] = axes;
  const isSingle = new Set(rows.map((row) => row.panel)).size <= 1;
  const values = [...new Set(rows.map((row) => row.xIndex))];
  const best = (i) => rows.filter((row) => row.xIndex === i).reduce((least, row) => Math.min(least, row.value), Infinity);
  if (isSingle && isSorted) values.sort((a, b) => best(a) - best(b));
  else values.sort((a, b) => a - b);
  const colours = coloursOf(rows);
  const label = (i) => (i < 0 ? 'all' : valueText(x, i));
  const panels = [...new Set(rows.map((row) => row.panel))].sort((a, b) => a - b);
  const perRow = Math.max(1, Math.min(panels.length, Math.floor(how.width / 380)));
  const each = (how.width - 22 * (perRow - 1)) / perRow;
  const margin = labelMargin(values.map(label), each);
  const scaleX = scale(rows.flatMap((row) => [row.value, row.low, row.high]), view.yScale, { room: Math.max(3, Math.floor((each - margin) / 55)) });
  return { perRow, values, panels: panels.map((panel) => {
    const own = rows.map((row, i) => ({ ...row, index: i })).filter((row) => row.panel === panel);
    return { title: panel < 0 ? '' : `${axes[2].name} ${valueText(axes[2], panel)}`, height: values.length * Math.max(22, colours.length * 6 + 8) + 50,
      options: rowPanel(own, { theme: how.theme, scaleX, rowsShown: { values, colours }, label, margin, xLabel: yLabel }),
      hot: hotOf(own, colours) };
  }) };
}

function lineDrawing(doc, view, { rows, axes, how, yLabel, height }) {
  const [x, , panel] = axes;
  const y = scale(rows.flatMap((row) => [row.value, row.low, row.high]), view.yScale);
  const colours = coloursOf(rows);
  const xOf = (width) => valueScale([...new Set(rows.map((row) => row.x))], view.xScale, width);
  const panels = [...new Set(rows.map((row) => row.panel))].sort((a, b) => a - b);
  return { height: panels.length > 3 ? Math.min(height, 240) : height, panels: panels.map((i) => {
    const own = rows.map((row, index) => ({ ...row, index })).filter((row) => row.panel === i);
    return { title: i < 0 ? '' : `${panel.name} ${valueText(panel, i)}`, hot: hotOf(own, colours),
      options: linePanel(own, { theme: how.theme, colours, x: xOf, y, xLabel: axisTitle(x), yLabel }) };
  }) };
}

const statisticText = (doc, view) => (view.statistic === 'mean' ? doc.raw.statistic ?? ''
  : `Drawn: ${statistics[view.statistic]} over the cycles; the time of a cycle is its median over the repeats.`);

/** @param {import('./document.js').Quantity} quantity */
export function describeQuantity(doc, view, plainHow, quantity, { height = 340, isSmall = false } = {}) {
  const how = { ...plainHow, theme: { ...plainHow.theme, highlight: view.highlight } };
  const found = rowsOf(doc, view, quantity);
  const title = `${quantity.short[0].toUpperCase()}${quantity.short.slice(1)}${found.axes[0] ? ` over ${found.axes[0].name}` : ''}`;
  if (found.rows.length === 0) return { title, empty: 'No point has a value here.' };
  const unit = unitOf(quantity, extent(found.rows.map((row) => row.value))[1]);
  const { columns, rows } = tableOf(found.rows, found.axes, unit, quantity);
  // Without an axis along x, the colours make the rows.
  let axes = found.axes;
  let drawn = rows;
  if (!axes[0]) {
    axes = [axes[1], undefined, axes[2]];
    drawn = rows.map((row) => ({ ...row, xIndex: row.colour, colour: -1 }));
  }
  const isRows = !axes[0] || axes[0].isText;
  const label = isSmall ? unit.unit : `${quantity.short}${unit.unit ? `, ${unit.unit}` : ''}`;
  const drawing = (isRows ? textDrawing : lineDrawing)(doc, view, { rows: drawn, axes, how, yLabel: label, height });
  const isTime = quantity.dimension === 'time';
  const statistic = isTime ? statisticText(doc, view)
    : quantity.dimension === 'ratio' ? `Paired: each point over the one of ${short(doc.raw.ratios.baseline, 40)} at the same place.` : `Mean over the cycles.`;
  return { title, columns, rows, legend: legendOf(drawn, axes[1], how.theme, isRows), ...drawing,
    notes: [statistic, ...poolNotes(doc, view, found.grouped, found.rows, quantity.mean, { hasIntervals: isTime || quantity.dimension === 'ratio' })] };
}

export function describeOverAxes(doc, view, how) {
  const quantity = quantities(doc).find((each) => each.id === view.quantity);
  if (!quantity) return { title: 'Over the axes', empty: 'There is nothing to draw: no run has times.' };
  return describeQuantity(doc, view, how, quantity);
}

/** One configuration: a row for each phase, on one scale. */
function describePhaseRows(doc, view, how, phases) {
  const found = phases.map((phase, i) => rowsOf(doc, view, phase).rows.map((row) => ({ ...row, xIndex: i, name: phase.id.slice(5) }))).flat();
  const title = 'Phases of a cycle';
  if (found.length === 0) return { title, empty: 'No point has a value here.' };
  const unit = unitOf(phases[0], extent(found.map((row) => row.value))[1]);
  const { columns, rows } = tableOf(found, [], unit, { short: 'time' });
  const axis = { name: 'phase', isText: true, values: phases.map((phase) => phase.id.slice(5)) };
  const { grouped } = rowsOf(doc, view, phases[0]);
  return { title, columns: [{ key: 'name', label: 'phase' }, ...columns], rows, legend: [],
    ...textDrawing(doc, view, { rows, axes: [axis], how, yLabel: `time, ${unit.unit}`, isSorted: false }),
    notes: [statisticText(doc, view), ...poolNotes(doc, view, grouped, found, 'arithmetic')] };
}

const stackedPhases = ['broad', 'narrow', 'solve', 'integrate'];

/** Texts down: a bar for each, of the phases that make up its step. */
function describeStackedRows(doc, view, { theme, width }) {
  const names = stackedPhases.filter((name) => doc.phases.some((phase) => phase.name === name));
  const parts = names.map((name) => rowsOf(doc, view, quantities(doc).find((each) => each.id === `time:${name}`)));
  const title = `Phases over ${parts[0]?.axes[0].name ?? 'the axis'}`;
  const order = new Map();
  const found = parts.flatMap(({ rows }, i) => rows.filter((row) => !row.isVoid).map((row) => {
    const y1 = order.get(row.xIndex) ?? 0;
    order.set(row.xIndex, y1 + row.value);
    return { xIndex: row.xIndex, phase: names[i], value: row.value, y1, y2: y1 + row.value };
  }));
  if (found.length === 0) return { title, empty: 'No sound point has times of single phases.' };
  const { unit, factor } = timeUnit(Math.max(...order.values()));
  const axis = parts[0].axes[0];
  const values = [...order.keys()].sort((a, b) => order.get(a) - order.get(b));
  const margin = labelMargin(values.map((i) => valueText(axis, i)), width);
  const rows = found.map((row) => ({ ...row, xText: valueText(axis, row.xIndex), value: row.value / factor, y1: row.y1 / factor, y2: row.y2 / factor }));
  const scaleX = scale(rows.map((row) => row.y2), 'linear', { room: Math.max(3, Math.floor((width - margin) / 70)) });
  const options = ({ width: w, height }) => ({ width: w, height, marginLeft: margin, marginRight: 14, marginTop: 6, marginBottom: 38,
    x: { ...scaleX, label: `time of a cycle, ${unit}`, labelAnchor: 'right', labelArrow: 'right' },
    y: { type: 'band', domain: values, padding: 0.3, tickFormat: (i) => rowLabel(valueText(axis, i), margin), label: null, tickSize: 0 },
    marks: [Plot.gridX({ ticks: scaleX.ticks, stroke: theme.grid, strokeOpacity: 1 }),
      Plot.barX(rows, { y: 'xIndex', x1: 'y1', x2: 'y2', fill: (row) => phaseColours(theme)[row.phase], className: 'hot' })] });
  return { title, rows, legend: names.map((name) => ({ label: name, colour: phaseColours(theme)[name], isArea: true })),
    columns: [{ key: 'xText', label: axis.name }, { key: 'phase', label: 'phase' }, { key: 'value', label: `time, ${unit}`, isNumber: true }],
    panels: [{ title: '', height: values.length * 22 + 50, options, hot: { hot: rows.map((_, i) => i) } }],
    notes: [statisticText(doc, view), ...poolNotes(doc, view, parts[0].grouped, [], 'arithmetic', { hasIntervals: false })] };
}

/** Every phase in a panel, with the axes of the view but its panels pooled away. */
export function describePhases(doc, view, how) {
  const title = 'Every phase';
  const phases = quantities(doc).filter((each) => each.dimension === 'time');
  if (phases.length < 2) return { title, empty: '' };
  if (view.roles.every((role) => role === 'fixed' || role === 'pooled')) return describePhaseRows(doc, view, how, phases);
  const own = { ...view, roles: view.roles.map((role) => (role === 'panel' ? 'pooled' : role)) };
  if (doc.axes[own.roles.indexOf('x')]?.isText && !own.roles.includes('colour')) return describeStackedRows(doc, own, how);
  const x = doc.axes[own.roles.indexOf('x')];
  const fit = Math.max(1, Math.min(3, Math.floor(how.width / (x && !x.isText ? 240 : 360))));
  const perRow = Math.ceil(phases.length / Math.ceil(phases.length / fit));
  const small = { ...how, width: (how.width - 22 * (perRow - 1)) / perRow };
  const parts = phases.map((phase) => describeQuantity(doc, own, small, phase, { height: 210, isSmall: true })).filter((part) => !part.empty);
  if (parts.length === 0) return { title, empty: 'No point has a value here.' };
  const rows = [];
  const panels = parts.map((part, i) => {
    const first = rows.length;
    const name = phases[i].id.slice(5);
    const unit = part.columns.find((column) => column.key === 'value').label.split(', ').at(-1);
    rows.push(...part.rows.map((row) => ({ ...row, phase: name, unit })));
    const [panel] = part.panels;
    return { ...panel, title: name, hot: Object.fromEntries(Object.entries(panel.hot).map(([key, list]) => [key, list.map((row) => row + first)])) };
  });
  const columns = [{ key: 'phase', label: 'phase' }, ...parts[0].columns.map((column) =>
    (['value', 'low', 'high'].includes(column.key) ? { ...column, label: column.key === 'value' ? 'time' : column.key } : column)), { key: 'unit', label: 'unit' }];
  const pooledPanel = view.roles.includes('panel');
  return { title: `${title}${parts[0].title.includes(' over ') ? ` over ${parts[0].title.split(' over ').at(-1)}` : ''}`, columns, rows,
    panels, legend: parts[0].legend, height: 210, perRow,
    notes: [...parts[0].notes, ...(pooledPanel ? ['Here the axis of the panels is pooled.'] : [])] };
}
