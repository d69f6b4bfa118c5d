// Creates elements. Text of a document enters the page as text only, never as markup.

/**
 * @param {string} tag @param {Record<string, any>} [attributes]  a function is a listener; null and false leave one out
 * @param {...(Node | string | number | null | undefined | false)} children
 */
export function h(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (typeof value === 'function') element.addEventListener(name, value);
    else if (value !== null && value !== undefined && value !== false)
      element.setAttribute(name, value === true ? '' : String(value));
  }
  for (const child of children)
    if (child !== null && child !== undefined && child !== false)
      element.append(child instanceof Node ? child : String(child));
  return element;
}

/** The same for SVG. */
export function s(tag, attributes = {}, ...children) {
  const element = document.createElementNS('http://www.w3.org/2000/svg', tag);
  for (const [name, value] of Object.entries(attributes))
    if (value !== null && value !== undefined) element.setAttribute(name, String(value));
  for (const child of children) element.append(child instanceof Node ? child : String(child));
  return element;
}

/** Text from a file. Its writing direction must not affect the text around it. @param {string} text */
export const bdi = (text) => h('bdi', {}, text);

/**
 * A table. Numbers are right-aligned.
 * @param {{label: string, isNumber?: boolean}[]} columns @param {(string | number | Node | null)[][]} rows
 */
export function table(columns, rows, caption = null) {
  const style = (column) => ({ class: column.isNumber ? 'number' : null });
  const cell = (value, i) => h('td', style(columns[i]), value instanceof Node ? value : bdi(value ?? '–'));
  return h(
    'div',
    { class: 'scroll', tabindex: '0', role: 'region', 'aria-label': caption ?? 'Table' },
    h(
      'table',
      {},
      h(
        'thead',
        {},
        h('tr', {}, ...columns.map((column) => h('th', { scope: 'col', ...style(column) }, column.label))),
      ),
      h('tbody', {}, ...rows.map((row) => h('tr', {}, ...row.map(cell)))),
    ),
  );
}
