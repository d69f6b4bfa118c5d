// The diagnostics below the text: errors, then warnings, then hints; a click goes to the place.
import { element } from '../view/text.js';

const kLevels = ['error', 'warning', 'info', 'hint'];
const kUnnecessary = 1; // a tag of the language server

export const levelOf = ({ severity, tags }) => (tags?.includes(kUnnecessary) ? 'hint' : kLevels[severity - 1] ?? 'error');

const count = (number, word) => (number ? [`${number} ${word}${number === 1 ? '' : 's'}`] : []);

export class Problems {
  constructor(onChoose) {
    this.onChoose = onChoose;
    this.summary = element('p', { id: 'summary', role: 'status' });
    this.list = element('ul', { id: 'problems', 'aria-label': 'problems' });
  }

  // `diagnostics` have a `level`; `note` follows their number.
  show(diagnostics, note) {
    const sorted = [...diagnostics].sort((a, b) => kLevels.indexOf(a.level) - kLevels.indexOf(b.level) ||
      a.range.start.line - b.range.start.line);
    const of = (level) => diagnostics.filter((each) => each.level === level).length;
    this.summary.textContent = [...count(of('error'), 'error'), ...count(of('warning'), 'warning'),
      ...count(of('info') + of('hint'), 'hint')].join(', ') || 'no problems';
    if (note) this.summary.textContent += `; ${note}`;
    this.summary.className = of('error') ? 'error' : '';
    this.list.hidden = sorted.length === 0;
    this.list.replaceChildren(...sorted.map(({ level, message, range, code }) => {
      const [first, ...rest] = message.split('\n');
      return element('li', { class: level }, element('button', { type: 'button', onclick: () => this.onChoose(range) },
        element('b', {}, `${level}, line ${range.start.line + 1}`), ` ${first}${code ? ` [${code}]` : ''}`,
        ...(rest.length ? [element('small', {}, rest.join('\n'))] : [])));
    }));
  }
}
