// The frame of a figure: heading, notes, export, its data as a table, and a pointer that also follows the arrow keys.
import { compose } from './compose.js';
import { h, table } from './dom.js';
import { save } from './export.js';
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
 * @property {() => void} redraw
 */
/**
 * @param {object} options
 * @param {string} options.id       of the element, and the name of exported files
 * @param {(doc, view, how: {theme: import('./palette.js').Theme, width: number}) => import('./compose.js').Drawing | {empty: string}} options.describe
 * @param {(doc, view) => Node[]} [options.tools]  its own controls
 * @returns {Figure}
 */
export function createFigure({ id, describe, tools = () => [] }) {
  const heading = h('h3');
  const toolbar = h('div', { class: 'tools' });
  const plot = h('div', { class: 'plot' });
  const notes = h('p', { class: 'note' });
  const data = h('details', { class: 'data' }, h('summary', {}, 'Data'));
  const message = h('span', { role: 'status' });
  const element = h('figure', { id }, h('figcaption', {}, heading), toolbar, plot, notes);
  let doc;
  let view;
  let drawing;
  let drawnAt = '';
  const button = (format) =>
    h(
      'button',
      {
        type: 'button',
        'aria-label': `Save ${id} as ${format.toUpperCase()}`,
        click: async () => {
          try {
            await save(
              format,
              `${short(doc.raw.sources?.[0]?.benchmark ?? 'cdb', 60).replace(/[^\w-]+/g, '_')}-${id}`,
              (how) => describe(doc, view, how),
            );
            message.textContent = '';
          } catch (error) {
            message.textContent = `Not saved: ${error.message}`;
          }
        },
      },
      format.toUpperCase(),
    );
  const actions = h('div', { class: 'actions' }, button('svg'), button('png'), button('csv'), message, data);
  element.append(actions);
  data.addEventListener('toggle', () => {
    while (data.children.length > 1) data.lastChild.remove();
    if (data.open && drawing?.rows) data.append(...dataTable(drawing));
  });

  const redraw = () => {
    const width = plot.clientWidth || 720;
    const theme = currentTheme();
    drawnAt = `${width} ${theme.name}`;
    drawing = describe(doc, view, { theme, width });
    element.classList.toggle('empty', 'empty' in drawing);
    element.hidden = drawing.empty === '';
    actions.hidden = 'empty' in drawing;
    heading.textContent = drawing.title ?? '';
    if ('empty' in drawing) {
      plot.replaceChildren();
      notes.textContent = drawing.empty;
      return;
    }
    const svg = compose(drawing, { width, theme });
    for (const [name, value] of Object.entries({
      role: 'img',
      tabindex: '0',
      'aria-label': `${drawing.title}. ${drawing.rows.length} values; the arrow keys visit them, and they are in the table below.`,
    }))
      svg.setAttribute(name, value);
    plot.replaceChildren(svg);
    notes.textContent = drawing.notes.join(' ');
    listen(svg, drawing);
    data.dispatchEvent(new Event('toggle'));
  };
  return {
    element,
    update(newDoc, newView) {
      [doc, view] = [newDoc, newView];
      const own = tools(doc, view);
      const focused = toolbar.contains(document.activeElement) ? document.activeElement.name : '';
      toolbar.replaceChildren(...own);
      if (focused) toolbar.querySelector(`[name="${CSS.escape(focused)}"]`)?.focus();
      redraw();
    },
    redraw: () => doc && drawnAt !== `${plot.clientWidth || 720} ${currentTheme().name}` && redraw(),
  };
}
