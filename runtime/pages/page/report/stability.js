// The stability map: verdicts over two axes, with the first bad cycle.
import * as Plot from '@observablehq/plot';
import { axisTitle, valueText } from './document.js';
import { number, short } from './format.js';
import { textWidth } from './compose.js';
import { inkOn, severity, verdicts } from './palette.js';
import { entriesOf, noTable } from './pooled.js';
import { labelMargin, rowBand } from './scales.js';

const mostPanels = 12;
const leastCell = 22; // px, with text
const wideCell = 62; // px, with full names

const plainName = (level) => verdicts[level].name.replace('_', ' ');
const nameOf = (axis, i) => (axis ? valueText(axis, i) : '');

/** Splits the other axes of the map into fixed ones, those that make panels, and those whose worst verdict counts. */
function split(doc, view) {
  const rest = doc.axes
    .map((_, a) => a)
    .filter((a) => a !== view.mapX && a !== view.mapY && doc.axes[a].values.length > 1);
  const fixed = rest.filter((a) => view.roles[a] === 'fixed');
  const panels = [];
  let product = 1;
  for (const a of rest) {
    if (fixed.includes(a) || doc.axes[a].name === 'seed' || product * doc.axes[a].values.length > mostPanels) continue;
    product *= doc.axes[a].values.length;
    panels.push(a);
  }
  return { fixed, panels, worstOver: rest.filter((a) => !fixed.includes(a) && !panels.includes(a)) };
}

/** The cells of the map, with the worst verdict over the axes that it does not show; null if the document has none. */
function cellsOf(doc, view, parts) {
  const roles = doc.axes.map((_, a) => {
    if (parts.worstOver.includes(a)) return 'pooled';
    return parts.fixed.includes(a) ? 'fixed' : 'x';
  });
  const found = entriesOf(doc, { ...view, roles }, verdictsOf(doc));
  return found?.entries.map(({ place, value, cycle, points }) => {
    const on = (a) => (a < 0 ? 0 : place[a]);
    const panelAt = parts.panels.map(on);
    const at = { panel: panelAt.join(), panelAt, x: on(view.mapX), y: on(view.mapY) };
    return { ...at, points, level: severity(value), cycle };
  });
}

/** Verdicts in place of numbers. */
const verdictsOf = (doc) => ({
  estimates: () => ({ value: doc.verdict, cycle: doc.firstBadCycle }),
  pooled: ({ places }) => {
    const { at, points, verdict: value, first_bad_cycle: cycle } = places;
    const none = at.map(() => '');
    return { at, points, own: points, value, cycle, mark: none, isVoid: none };
  },
});

/** The label of a column; large numbers are written as powers, which are shorter. */
function columnText(axis, i) {
  const value = axis?.values[i];
  return typeof value === 'number' && Math.abs(value) >= 1e4 ? number(value, 2, 1e4) : axis ? valueText(axis, i) : '';
}

/** The verdict in each cell, and the cycle below it. */
function cellTexts(rows, isWide) {
  const ink = (row) => inkOn(verdicts[row.level].colour);
  const at = { x: 'x', y: 'y', fill: ink };
  const verdict = {
    ...at,
    text: (row) => (isWide ? plainName(row.level) : verdicts[row.level].code),
    fontSize: isWide ? 10 : 9.5,
    fontWeight: 600,
  };
  const hasCycle = (row) => row.cycle !== null;
  return [
    Plot.text(rows, { ...verdict, filter: (row) => !hasCycle(row) }),
    Plot.text(rows, { ...verdict, dy: -5.5, filter: hasCycle }),
    Plot.text(rows, { ...at, text: (row) => String(row.cycle), fontSize: 9, dy: 6.5, filter: hasCycle }),
  ];
}

function panelOf(rows, { axisX, axisY, xs, ys, margin }) {
  return ({ width, height }) => {
    const cell = (width - margin - 10) / xs.length;
    const labels = xs.map((i) => short(columnText(axisX, i), 24));
    const every = Math.ceil((Math.max(...labels.map((label) => textWidth(label, 11))) + 8) / Math.max(cell, 1));
    const fill = (row) => verdicts[row.level].colour;
    return {
      width,
      height,
      marginLeft: margin,
      marginRight: 10,
      marginTop: 4,
      marginBottom: 36,
      x: {
        type: 'band',
        domain: xs,
        padding: 0,
        tickSize: 0,
        ticks: xs.filter((_, i) => i % every === 0),
        tickFormat: (i) => labels[xs.indexOf(i)],
        label: axisX ? axisTitle(axisX) : null,
        labelAnchor: 'right',
        labelArrow: 'right',
      },
      y: rowBand({ margin, domain: ys, labelOf: (i) => nameOf(axisY, i), padding: 0 }),
      marks: [
        Plot.cell(rows, { x: 'x', y: 'y', fill, inset: cell > 8 ? 0.75 : 0, rx: 2, className: 'hot' }),
        ...(cell > leastCell ? cellTexts(rows, cell > wideCell) : []),
      ],
    };
  };
}

/** The cells with their texts, in order of panels, rows, columns. */
function rowsOf(doc, cells, { parts, axisX, axisY }) {
  const panelText = (cell) =>
    parts.panels.map((a, k) => `${doc.axes[a].name} ${valueText(doc.axes[a], cell.panelAt[k])}`).join(', ');
  return cells
    .map((cell) => ({
      ...cell,
      panelText: panelText(cell),
      xText: nameOf(axisX, cell.x),
      yText: nameOf(axisY, cell.y),
      verdict: verdicts[cell.level].name,
    }))
    .sort((a, b) => a.panel.localeCompare(b.panel, undefined, { numeric: true }) || a.y - b.y || a.x - b.x);
}

function legendOf(rows) {
  const levels = [...new Set(rows.map((row) => row.level))].sort((a, b) => a - b);
  return levels.map((level) => ({
    label: `${plainName(level)} (${rows.filter((row) => row.level === level).length})`,
    colour: verdicts[level].colour,
    isArea: true,
    code: verdicts[level].code,
    ink: inkOn(verdicts[level].colour),
  }));
}

function columnsOf({ axisX, axisY, hasPanels }) {
  return [
    hasPanels && { key: 'panelText', label: 'panel' },
    axisY && { key: 'yText', label: axisY.name },
    axisX && { key: 'xText', label: axisX.name },
    { key: 'verdict', label: 'verdict' },
    { key: 'cycle', label: 'first bad cycle', isNumber: true },
    { key: 'points', label: 'points', isNumber: true },
  ].filter(Boolean);
}

function notesOf(doc, view, rows, parts) {
  const fixed = parts.fixed.map((a) => `${doc.axes[a].name} ${short(valueText(doc.axes[a], view.at[a]), 40)}`);
  return [
    'The worst verdict over the repeats; below it the first cycle at which it applies.',
    ...(fixed.length ? [`At ${fixed.join(', ')}.`] : []),
    ...(parts.worstOver.length ? [`The worst over ${parts.worstOver.map((a) => doc.axes[a].name).join(', ')}.`] : []),
    ...(rows.some((row) => row.level >= severity('frozen'))
      ? ['From the verdict frozen on, bodies did not move as they should have, and times do not count.']
      : []),
  ];
}

/** The number of panels side by side, and the margin for the labels of their rows. */
function layout(count, columns, labels, width) {
  const wanted = Math.max(300, Math.min(columns * 34 + 90, 520));
  const perRow = Math.max(1, Math.min(count, Math.floor(width / wanted)));
  const each = (width - 22 * (perRow - 1)) / perRow;
  return { perRow, margin: labels.length ? labelMargin(labels, each) : 10 };
}

export function describeStability(doc, view, { width }) {
  const title = 'Where it stays sound';
  const known = doc.verdict.filter((name) => name !== 'unknown');
  if (known.length === 0) return { title, empty: 'No run has a verdict.' };
  if (known.length === doc.count && known.every((name) => name === 'stable'))
    return { title, empty: `All ${doc.count} points are stable.` };
  const parts = split(doc, view);
  const [axisX, axisY] = [doc.axes[view.mapX], doc.axes[view.mapY]];
  const cells = cellsOf(doc, view, parts);
  if (!cells) return { title, empty: noTable };
  const rows = rowsOf(doc, cells, { parts, axisX, axisY });
  const xs = [...new Set(rows.map((row) => row.x))].sort((a, b) => a - b);
  const ys = [...new Set(rows.map((row) => row.y))].sort((a, b) => a - b);
  const keys = [...new Set(rows.map((row) => row.panel))];
  const { perRow, margin } = layout(keys.length, xs.length, axisY ? ys.map((i) => nameOf(axisY, i)) : [], width);
  const over = [axisX, axisY].filter(Boolean).map((axis) => axis.name);
  return {
    title: `${title}: verdict${over.length ? ` over ${over.join(' and ')}` : ''}`,
    columns: columnsOf({ axisX, axisY, hasPanels: parts.panels.length > 0 }),
    rows,
    perRow,
    panels: keys.map((key) => {
      const own = rows.map((row, index) => ({ ...row, index })).filter((row) => row.panel === key);
      return {
        title: own[0].panelText,
        height: ys.length * 34 + 44,
        hot: { hot: own.map((row) => row.index) },
        options: panelOf(own, { axisX, axisY, xs, ys, margin }),
      };
    }),
    legend: legendOf(rows),
    notes: notesOf(doc, view, rows, parts),
  };
}
