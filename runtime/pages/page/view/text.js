// Formats numbers and creates elements. Text is never parsed as HTML.

// Three significant digits.
export function number(value) {
  if (!Number.isFinite(value)) return '–';
  if (value === 0) return '0';
  const size = Math.abs(value);
  if (size >= 1e6 || size < 1e-4) return value.toExponential(2).replace('e+', 'e');
  if (size >= 1000) return String(Math.round(value));
  return String(Number(value.toPrecision(3)));
}

/** @param {string} unit  of the clock of the run: ns, or instructions */
export function duration(ns, unit = 'ns') {
  if (!Number.isFinite(ns)) return '–';
  if (unit !== 'ns') return `${number(ns)} ${unit}`;
  for (const [name, size] of [['s', 1e9], ['ms', 1e6], ['µs', 1e3]])
    if (ns >= size) return `${number(ns / size)} ${name}`;
  return `${number(ns)} ns`;
}

export function element(name, attributes = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith('on')) made.addEventListener(key.slice(2), value);
    else if (value === true) made.setAttribute(key, '');
    else if (value !== false && value !== undefined && value !== null) made.setAttribute(key, value);
  }
  made.append(...children);
  return made;
}
