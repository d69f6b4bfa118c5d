// The frame of a figure: heading, notes, export, its data as a table, and a pointer that also follows the arrow keys.
import { compose } from './compose.js';
import { h, table } from './dom.js';
import { save, sizes, svgText } from './export.js';
import { number, short } from './format.js';
import { themes } from './palette.js';
import { describeRow } from './scales.js';

const mostTableRows = 300;
const reach = 40; // px from the pointer to a mark
const dark = matchMedia('(prefers-color-scheme: dark)');
const printing = matchMedia('print');
export const currentTheme = () => (dark.matches && !printing.matches ? themes.dark : themes.light);

const tip = h('div', { id: 'tip', role: 'status', 'aria-live': 'polite', hidden: true });

/** Shows the row of a mark beside it. */
function showTip(mark, drawing) {
  const row = drawing.rows[Number(mark.dataset.row)];
  if (!row) return;
  tip.replaceChildren(
    ...describeRow(drawing.columns, row).map(([label, text]) =>
      h('div', {}, h('span', {}, `${short(label, 40)} `), h('b', {}, short(text, 80))),
    ),
  );
  if (!tip.isConnected) document.body.append(tip);
  tip.hidden = false;
  const box = mark.getBoundingClientRect();
  const x = Math.min(Math.max(8, box.x + box.width / 2 + 12), innerWidth - tip.offsetWidth - 8);
  const above = box.y - tip.offsetHeight - 8;
  tip.style.left = `${x + scrollX}px`;
  tip.style.top = `${(above > 4 ? above : box.bottom + 10) + scrollY}px`;
}
const hideTip = () => {
  tip.hidden = true;
};

/** Pointer and arrow keys choose a mark; Escape leaves it. */
function listen(svg, drawing) {
  const marks = [...svg.querySelectorAll('[data-row]')].sort((a, b) => a.dataset.row - b.dataset.row);
  if (marks.length === 0) return;
  let chosen = -1;
  const choose = (i) => {
    marks[chosen]?.classList.remove('chosen');
    chosen = i;
    if (i < 0) return hideTip();
    marks[i].classList.add('chosen');
    showTip(marks[i], drawing);
  };
  svg.addEventListener('pointermove', (event) => {
    let [best, least] = [-1, reach ** 2];
    marks.forEach((mark, i) => {
      const box = mark.getBoundingClientRect();
      const dx = Math.max(box.left - event.clientX, 0, event.clientX - box.right);
      const dy = Math.max(box.top - event.clientY, 0, event.clientY - box.bottom);
      const centre = Math.hypot(event.clientX - box.x - box.width / 2, event.clientY - box.y - box.height / 2);
      const distance = dx * dx + dy * dy + Math.min(centre, 1000) / 1000;
      if (distance < least) [best, least] = [i, distance];
    });
    if (best !== chosen) choose(best);
  });
  svg.addEventListener('pointerleave', () => choose(-1));
  svg.addEventListener('blur', () => choose(-1));
  svg.addEventListener('keydown', (event) => {
    const step = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
    if (event.key === 'Escape') choose(-1);
    if (step === undefined) return;
    event.preventDefault();
    choose((Math.max(chosen, step > 0 ? -1 : 0) + step + marks.length) % marks.length);
  });
}

function dataTable(drawing) {
  const shown = drawing.rows.slice(0, mostTableRows);
  const element = table(
    drawing.columns,
    shown.map((row) =>
      drawing.columns.map(({ key }) => (typeof row[key] === 'number' ? number(row[key], 5) : (row[key] ?? null))),
    ),
    `Data of ${drawing.title}`,
  );
  return drawing.rows.length > shown.length
    ? [element, h('p', { class: 'note' }, `The first ${shown.length} of ${drawing.rows.length} rows; the CSV has all.`)]
    : [element];
}

/**
 * @typedef {object} Figure
 * @property {HTMLElement} element
 * @property {(doc: import('./document.js').Doc, view: import('./state.js').View) => void} update
 * @property {() => {id: string, name: string, text: string} | null} svg
 * @property {() => void} redraw
 */
/** A button that saves the figure in a format. `message` shows why it failed. */
function saveButton(format, id, { getName, getDescribe, getSize, message }) {
  const click = async () => {
    try {
      await save(format, getName(), getDescribe(), getSize());
      message.textContent = '';
    } catch (error) {
      message.textContent = `Not saved: ${error.message}`;
    }
  };
  const label = format.toUpperCase();
  return h('button', { type: 'button', 'aria-label': `Save ${id} as ${label}`, click }, label);
}

/** The elements of a figure; `data` holds its table while it is open. */
function elementsOf(id) {
  const parts = {
    heading: h('h3'),
    toolbar: h('div', { class: 'tools' }),
    plot: h('div', { class: 'plot' }),
    notes: h('p', { class: 'note' }),
    data: h('details', { class: 'data' }, h('summary', {}, 'Data')),
    message: h('span', { role: 'status' }),
    actions: h('div', { class: 'actions' }),
  };
  const { heading, toolbar, plot, notes, actions } = parts;
  return { ...parts, element: h('figure', { id }, h('figcaption', {}, heading), toolbar, plot, notes, actions) };
}

/** Replaces the old drawing. */
function show(parts, drawing, how) {
  const isEmpty = 'empty' in drawing;
  parts.element.classList.toggle('empty', isEmpty);
  parts.element.hidden = drawing.empty === '';
  parts.actions.hidden = isEmpty;
  parts.heading.textContent = drawing.title ?? '';
  parts.notes.textContent = isEmpty ? drawing.empty : drawing.notes.join(' ');
  if (isEmpty) return parts.plot.replaceChildren();
  const svg = compose(drawing, how);
  const values = `${drawing.rows.length} values; the arrow keys visit them, and they are in the table below.`;
  for (const [name, value] of Object.entries({
    role: 'img',
    tabindex: '0',
    'aria-label': `${drawing.title}. ${values}`,
  }))
    svg.setAttribute(name, value);
  parts.plot.replaceChildren(svg);
  listen(svg, drawing);
  return parts.data.dispatchEvent(new Event('toggle'));
}

/**
 * Replaces controls, and restores the focus.
 * @param {HTMLElement} holder
 * @param {Node[]} controls
 */
export function replaceControls(holder, controls) {
  const focused = holder.contains(document.activeElement) ? document.activeElement.name : '';
  holder.replaceChildren(...controls);
  if (focused) holder.querySelector(`[name="${CSS.escape(focused)}"]`)?.focus();
}

/**
 * @param {object} options
 * @param {string} options.id       of the element, and the name of exported files
 * @param {(doc, view, how: {theme: import('./palette.js').Theme, width: number}) => import('./compose.js').Drawing
 *   | {empty: string}} options.describe
 * @param {(doc, view) => Node[]} [options.tools]  controls of this figure
 * @returns {Figure}
 */
export function createFigure({ id, describe, tools = () => [] }) {
  const parts = elementsOf(id);
  let doc;
  let view;
  let drawing;
  let drawnAt = '';
  const options = Object.entries(sizes).map(([value, { label }]) => h('option', { value }, label));
  const sizeMenu = h('select', { 'aria-label': `Size of saved ${id}` }, ...options);
  const source = {
    getName: () => `${short(doc.raw.sources?.[0]?.benchmark ?? 'cdb', 60).replace(/[^\w-]+/g, '_')}-${id}`,
    getDescribe: () => (how) => describe(doc, view, how),
    getSize: () => sizes[sizeMenu.value],
    message: parts.message,
  };
  parts.actions.append(
    ...['svg', 'png', 'csv'].map((format) => saveButton(format, id, source)),
    sizeMenu,
    parts.message,
    parts.data,
  );
  parts.data.addEventListener('toggle', () => {
    while (parts.data.children.length > 1) parts.data.lastChild.remove();
    if (parts.data.open && drawing?.rows) parts.data.append(...dataTable(drawing));
  });
  const size = () => ({ width: parts.plot.clientWidth || 720, theme: currentTheme() });
  const key = ({ width, theme }) => `${width} ${theme.name}`;
  const redraw = () => {
    const how = size();
    drawnAt = key(how);
    drawing = describe(doc, view, how);
    show(parts, drawing, how);
  };
  return {
    element: parts.element,
    update(newDoc, newView) {
      [doc, view] = [newDoc, newView];
      replaceControls(parts.toolbar, tools(doc, view));
      redraw();
    },
    /** The name of an exported file, and SVG of a size; null if there is nothing to draw. */
    svg: (size) =>
      !drawing || 'empty' in drawing
        ? null
        : { id, name: source.getName(), text: svgText(source.getDescribe(), size).text },
    redraw: () => doc && drawnAt !== key(size()) && redraw(),
  };
}
