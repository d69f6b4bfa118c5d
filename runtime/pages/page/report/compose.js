// Puts the panels of a drawing, its legend and, for export, its title and notes into one SVG.
import * as Plot from '@observablehq/plot';
import * as d3 from 'd3';
import { s } from './dom.js';
import { short } from './format.js';

/** @typedef {import('./palette.js').Theme} Theme */
/**
 * @typedef {{label: string, colour: string, symbol?: string | null, dash?: string | null, isHollow?: boolean,
 *   isArea?: boolean, isText?: boolean, code?: string, ink?: string}} Entry
 */
/**
 * @typedef {object} Panel
 * @property {string} title
 * @property {(size: {width: number, height: number}) => object} options  of Plot.plot
 * @property {Record<string, number[]>} [hot]  by class of a mark: the row of the drawing's table for each of its data
 * @property {number} [height]
 */
/**
 * @typedef {object} Drawing
 * @property {string} title
 * @property {string[]} notes
 * @property {{key: string, label: string, isNumber?: boolean}[]} columns
 * @property {Record<string, any>[]} rows   the figure's own data
 * @property {Entry[]} legend
 * @property {Panel[]} panels
 * @property {number} [perRow]   panels side by side; as many as fit by default
 * @property {number} [height]   of a panel
 */

export const font = 'system-ui, -apple-system, "Segoe UI", Roboto, "Helvetica Neue", Arial, "DejaVu Sans", sans-serif';
const gap = 22; // px between panels
const context = document.createElement('canvas').getContext('2d');

/** @param {string} text @param {number} size px @param {boolean} [isBold] */
export function textWidth(text, size, isBold = false) {
  context.font = `${isBold ? '600 ' : ''}${size}px ${font}`;
  return context.measureText(text).width;
}

/** Lines no wider than `width`. */
function wrap(text, width, size, isBold) {
  const lines = [];
  let line = '';
  for (const word of short(text, 2000).split(/\s+/)) {
    const longer = line ? `${line} ${word}` : word;
    if (line && textWidth(longer, size, isBold) > width) {
      lines.push(line);
      line = short(word, 80);
    } else line = longer;
  }
  return [...lines, line];
}

const types = {
  circle: d3.symbolCircle,
  square: d3.symbolSquare,
  triangle: d3.symbolTriangle,
  diamond: d3.symbolDiamond,
  star: d3.symbolStar,
  wye: d3.symbolWye,
  cross: d3.symbolCross,
};

/** @param {Entry} entry @param {Theme} theme */
function key(entry, theme) {
  const group = s('g');
  if (entry.isText) return { group, width: -6 };
  if (entry.isArea) {
    group.append(s('rect', { x: 0, y: -6, width: entry.code ? 20 : 12, height: 12, fill: entry.colour, rx: 1.5 }));
    if (entry.code)
      group.append(
        s(
          'text',
          { x: 10, y: 3.5, 'font-size': 9, 'text-anchor': 'middle', fill: entry.ink, 'font-weight': 600 },
          entry.code,
        ),
      );
    return { group, width: entry.code ? 20 : 12 };
  }
  if (entry.dash !== undefined)
    group.append(
      s('line', { x1: 0, x2: 22, stroke: entry.colour, 'stroke-width': 1.75, 'stroke-dasharray': entry.dash }),
    );
  if (entry.symbol)
    group.append(
      s('path', {
        d: d3.symbol(types[entry.symbol], 42)(),
        transform: `translate(${entry.dash !== undefined ? 11 : 6},0)`,
        fill: entry.isHollow ? theme.background : entry.colour,
        stroke: entry.colour,
        'stroke-width': 1.5,
      }),
    );
  return { group, width: entry.dash !== undefined ? 22 : 12 };
}

/** @param {Entry[]} entries @returns {{group: SVGElement, height: number}} */
function legend(entries, width, theme) {
  const group = s('g', { class: 'legend' });
  let x = 0;
  let y = 8;
  for (const entry of entries) {
    const label = short(entry.label, 60);
    const { group: sample, width: sampleWidth } = key(entry, theme);
    const whole = sampleWidth + 6 + textWidth(label, 12);
    if (x > 0 && x + whole > width) {
      x = 0;
      y += 19;
    }
    sample.setAttribute('transform', `translate(${x},${y})`);
    group.append(sample, s('text', { x: x + sampleWidth + 6, y: y + 4, 'font-size': 12, fill: theme.ink }, label));
    x += whole + 18;
  }
  return { group, height: entries.length ? y + 16 : 0 };
}

/** Labels every tick of logarithmic axes, because D3 leaves out some of them. */
function labelTicks(options) {
  const labelled = { ...options, marks: [...options.marks] };
  for (const [name, axisMark] of [
    ['x', Plot.axisX],
    ['y', Plot.axisY],
  ]) {
    const { ticks, tickFormat, label, labelAnchor, labelArrow, axis, ...scale } = options[name];
    if (scale.type !== 'log' || axis === null) continue;
    labelled[name] = { ...scale, axis: null };
    labelled.marks.push(axisMark(ticks, { text: tickFormat, label, labelAnchor, labelArrow }));
  }
  return labelled;
}

/** A panel of Plot as a nested element of the given position and size. */
function panelElement(panel, x, y, width, height, theme) {
  const options = labelTicks(panel.options({ width, height }));
  const plot = Plot.plot({
    ...options,
    width,
    height,
    style: { fontFamily: font, fontSize: '11px', color: theme.ink, background: 'none', overflow: 'visible' },
  });
  const svg = plot.tagName.toLowerCase() === 'svg' ? plot : plot.querySelector('svg');
  for (const [name, value] of Object.entries({ x, y, width, height, 'font-family': font, 'font-size': 11 }))
    svg.setAttribute(name, value);
  svg.setAttribute('aria-hidden', 'true'); // the whole figure has a label
  svg.removeAttribute('class');
  for (const rule of svg.querySelectorAll('style')) rule.remove();
  svg.setAttribute('style', `color:${theme.ink};overflow:visible;width:${width}px;height:${height}px`);
  for (const [name, rows] of Object.entries(panel.hot ?? {}))
    for (const mark of svg.querySelectorAll(`.${name} > *`)) {
      const row = rows[mark.__data__];
      if (row !== undefined) mark.setAttribute('data-row', row);
    }
  return svg;
}

/** Adds the panels in rows of nearly the same length, below `top`. @returns {number}  y of their lower end */
function addPanels(parent, drawing, top, width, theme) {
  const count = drawing.panels.length;
  const fit = Math.max(1, Math.min(count, drawing.perRow ?? Math.floor(width / 300)));
  const perRow = Math.ceil(count / Math.ceil(count / fit));
  const each = (width - gap * (perRow - 1)) / perRow;
  let y = top;
  for (let i = 0; i < count; i += perRow) {
    const row = drawing.panels.slice(i, i + perRow);
    const titleHeight = row.some((panel) => panel.title) ? 20 : 0;
    const heightOf = (panel) => panel.height ?? drawing.height ?? 300;
    row.forEach((panel, k) => {
      const x = k * (each + gap);
      const title = short(panel.title, Math.max(12, Math.floor(each / 7)));
      const look = { 'font-size': 12, 'font-weight': 600, fill: theme.ink, class: 'panel-title' };
      if (titleHeight) parent.append(s('text', { x, y: y + 13, ...look }, title));
      parent.append(panelElement(panel, x, y + titleHeight, each, heightOf(panel), theme));
    });
    y += Math.max(...row.map(heightOf)) + titleHeight + (i + perRow < count ? 10 : 0);
  }
  return y;
}

/** Adds wrapped text below `top`. @returns {number}  y of its lower end */
function addLines(parent, text, top, { width, size, isBold = false, fill }) {
  let y = top;
  for (const line of wrap(text, width, size, isBold)) {
    y += size * 1.35;
    const look = { 'font-size': size, 'font-weight': isBold ? 600 : null, fill };
    parent.append(s('text', { y: y - size * 0.3, ...look }, line));
  }
  return y;
}

/**
 * @param {Drawing} drawing
 * @param {{width: number, theme: Theme, isWhole?: boolean}} how  isWhole: with title, notes, background
 */
export function compose(drawing, { width: outer, theme, isWhole = false }) {
  const margin = isWhole ? 20 : 0;
  const width = outer - 2 * margin;
  const svg = s('svg', { xmlns: 'http://www.w3.org/2000/svg', 'font-family': font, fill: theme.ink, color: theme.ink });
  const inner = s('g', { transform: `translate(${margin},${margin})` });
  svg.append(inner);
  let y = isWhole ? addLines(inner, drawing.title, 0, { width, size: 16, isBold: true, fill: theme.ink }) + 10 : 0;
  const keys = legend(drawing.legend, width, theme);
  keys.group.setAttribute('transform', `translate(0,${y})`);
  inner.append(keys.group);
  y = addPanels(inner, drawing, y + keys.height, width, theme);
  if (isWhole) y = addLines(inner, drawing.notes.join(' '), y + 12, { width, size: 11, fill: theme.muted });
  const height = Math.ceil(y + 2 * margin);
  if (isWhole) svg.prepend(s('rect', { width: outer, height, fill: theme.background }));
  for (const [name, value] of Object.entries({ viewBox: `0 0 ${outer} ${height}`, width: outer, height }))
    svg.setAttribute(name, String(value));
  return svg;
}
