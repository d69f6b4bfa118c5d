// The stability map: verdicts over two axes, with the first bad cycle.
import * as Plot from '@observablehq/plot';
import { valueText } from './document.js';
import { number, short } from './format.js';
import { textWidth } from './compose.js';
import { inkOn, severity, verdicts } from './palette.js';
import { labelMargin, rowLabel } from './scales.js';

const mostPanels = 12;

/** The worst verdict of some points, and its earliest bad cycle. */
export function worst(doc, points) {
  let [level, cycle] = [-1, null];
  for (const p of points) {
    const own = severity(doc.verdict[p]);
    const bad = doc.firstBadCycle[p];
    if (own > level) [level, cycle] = [own, bad];
    else if (own === level && bad !== null && (cycle === null || bad < cycle)) cycle = bad;
  }
  return { level, cycle };
}

/** Axes beside the two of the map: fixed ones, those that make panels, and the rest, of which the worst counts. */
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

function cellsOf(doc, view, parts) {
  const cells = new Map();
  for (let p = 0; p < doc.count; ++p) {
    if (!parts.fixed.every((a) => doc.at[p][a] === view.at[a])) continue;
    const on = (a) => (a < 0 ? 0 : doc.at[p][a]);
    const panel = parts.panels.map((a) => doc.at[p][a]);
    const key = `${panel.join()};${on(view.mapX)};${on(view.mapY)}`;
    const cell = cells.get(key) ?? {
      panel: panel.join(),
      panelAt: panel,
      x: on(view.mapX),
      y: on(view.mapY),
      points: [],
    };
    cell.points.push(p);
    cells.set(key, cell);
  }
  return [...cells.values()].map((cell) => ({ ...cell, ...worst(doc, cell.points) }));
}

/** A value below a column; large numbers as powers, which are shorter. */
function columnText(axis, i) {
  const value = axis?.values[i];
  return typeof value === 'number' && Math.abs(value) >= 1e4 ? number(value, 2, 1e4) : axis ? valueText(axis, i) : '';
}

function panelOf(rows, { doc, view, theme, xs, ys, margin }) {
  const text = (a, i) => (a < 0 ? '' : valueText(doc.axes[a], i));
  return ({ width, height }) => {
    const cell = (width - margin - 10) / xs.length;
    const labels = xs.map((i) => short(columnText(doc.axes[view.mapX], i), 24));
    const every = Math.ceil((Math.max(...labels.map((label) => textWidth(label, 11))) + 8) / Math.max(cell, 1));
    const isWide = cell > 62;
    const fill = (row) => verdicts[row.level].colour;
    const ink = (row) => inkOn(fill(row));
    const marks = [Plot.cell(rows, { x: 'x', y: 'y', fill, inset: cell > 8 ? 0.75 : 0, rx: 2, className: 'hot' })];
    if (cell > 22) {
      marks.push(
        Plot.text(rows, {
          x: 'x',
          y: 'y',
          text: (row) => (isWide ? verdicts[row.level].name.replace('_', ' ') : verdicts[row.level].code),
          fill: ink,
          fontSize: isWide ? 10 : 9.5,
          fontWeight: 600,
          filter: (row) => row.cycle === null,
        }),
      );
      marks.push(
        Plot.text(rows, {
          x: 'x',
          y: 'y',
          text: (row) => (isWide ? verdicts[row.level].name.replace('_', ' ') : verdicts[row.level].code),
          fill: ink,
          fontSize: isWide ? 10 : 9.5,
          fontWeight: 600,
          dy: -5.5,
          filter: (row) => row.cycle !== null,
        }),
      );
      marks.push(
        Plot.text(rows, {
          x: 'x',
          y: 'y',
          text: (row) => String(row.cycle),
          fill: ink,
          fontSize: 9,
          dy: 6.5,
          filter: (row) => row.cycle !== null,
        }),
      );
    }
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
        label:
          view.mapX < 0
            ? null
            : doc.axes[view.mapX].name + (doc.axes[view.mapX].unit ? `, ${doc.axes[view.mapX].unit}` : ''),
        labelAnchor: 'right',
        labelArrow: 'right',
      },
      y: {
        type: 'band',
        domain: ys,
        padding: 0,
        tickSize: 0,
        label: null,
        tickFormat: (i) => rowLabel(text(view.mapY, i), margin),
      },
      marks,
    };
  };
}

export function describeStability(doc, view, { theme, width }) {
  const title = 'Where it stays sound';
  const known = doc.verdict.filter((name) => name !== 'unknown');
  if (known.length === 0) return { title, empty: 'No run has a verdict.' };
  if (known.length === doc.count && known.every((name) => name === 'stable'))
    return { title, empty: `All ${doc.count} points are stable.` };
  const parts = split(doc, view);
  const cells = cellsOf(doc, view, parts);
  const xs = [...new Set(cells.map((cell) => cell.x))].sort((a, b) => a - b);
  const ys = [...new Set(cells.map((cell) => cell.y))].sort((a, b) => a - b);
  const name = (a, i) => (a < 0 ? '' : valueText(doc.axes[a], i));
  const panelText = (cell) => parts.panels.map((a, k) => `${doc.axes[a].name} ${name(a, cell.panelAt[k])}`).join(', ');
  const rows = cells
    .map((cell) => ({
      ...cell,
      points: cell.points.length,
      panelText: panelText(cell),
      xText: name(view.mapX, cell.x),
      yText: name(view.mapY, cell.y),
      verdict: verdicts[cell.level].name,
    }))
    .sort((a, b) => a.panel.localeCompare(b.panel, undefined, { numeric: true }) || a.y - b.y || a.x - b.x);
  const keys = [...new Set(rows.map((row) => row.panel))];
  const labelsY = ys.map((i) => name(view.mapY, i));
  const perRow = Math.max(
    1,
    Math.min(keys.length, Math.floor(width / Math.max(300, Math.min(xs.length * 34 + 90, 520)))),
  );
  const each = (width - 22 * (perRow - 1)) / perRow;
  const margin = view.mapY < 0 ? 10 : labelMargin(labelsY, each);
  const present = [...new Set(rows.map((row) => row.level))].sort((a, b) => a - b);
  const columns = [
    ['panelText', 'panel'],
    ['yText', view.mapY < 0 ? '' : doc.axes[view.mapY].name],
    ['xText', view.mapX < 0 ? '' : doc.axes[view.mapX].name],
    ['verdict', 'verdict'],
    ['cycle', 'first bad cycle', true],
    ['points', 'points', true],
  ]
    .map(([key, label, isNumber = false]) => ({ key, label, isNumber }))
    .filter(({ key, label }) => label && (key !== 'panelText' || parts.panels.length));
  const fixed = parts.fixed.map((a) => `${doc.axes[a].name} ${short(name(a, view.at[a]), 40)}`).join(', ');
  return {
    title: `${title}: verdict${view.mapX < 0 ? '' : ` over ${doc.axes[view.mapX].name}`}${view.mapY < 0 ? '' : ` and ${doc.axes[view.mapY].name}`}`,
    columns,
    rows,
    perRow,
    panels: keys.map((key) => {
      const own = rows.map((row, index) => ({ ...row, index })).filter((row) => row.panel === key);
      return {
        title: own[0].panelText,
        height: ys.length * 34 + 44,
        hot: { hot: own.map((row) => row.index) },
        options: panelOf(own, { doc, view, theme, xs, ys, margin }),
      };
    }),
    legend: present.map((level) => ({
      label: `${verdicts[level].name.replace('_', ' ')} (${rows.filter((row) => row.level === level).length})`,
      colour: verdicts[level].colour,
      isArea: true,
      code: verdicts[level].code,
      ink: inkOn(verdicts[level].colour),
    })),
    notes: [
      'The worst verdict over the repeats; below it the first cycle at which it applies.',
      ...(fixed ? [`At ${fixed}.`] : []),
      ...(parts.worstOver.length ? [`The worst over ${parts.worstOver.map((a) => doc.axes[a].name).join(', ')}.`] : []),
      ...(present.some((level) => level >= severity('frozen'))
        ? ['From frozen on, bodies did not move as they were told, and times do not count.']
        : []),
    ],
  };
}
