// The text of the scenario: CodeMirror, with completion, descriptions and diagnostics by the server, whose positions
// are those of the language server: lines from 0, and UTF-16 units.
import { autocompletion, closeBrackets, closeBracketsKeymap, completionKeymap } from '@codemirror/autocomplete';
import { defaultKeymap, history, historyKeymap, indentWithTab } from '@codemirror/commands';
import { bracketMatching, indentOnInput, indentUnit } from '@codemirror/language';
import { lintGutter, lintKeymap, setDiagnostics } from '@codemirror/lint';
import { EditorState } from '@codemirror/state';
import { drawSelection, EditorView, highlightActiveLine, hoverTooltip, keymap, lineNumbers } from '@codemirror/view';
import { element } from '../view/text.js';
import { languageOf } from './language.js';

const kTheme = EditorView.theme({
  '&': { height: '100%', fontSize: '13px', backgroundColor: 'var(--panel)', color: 'var(--ink)' },
  '.cm-scroller': { fontFamily: 'ui-monospace, "DejaVu Sans Mono", monospace', lineHeight: '1.45' },
  '.cm-content': { caretColor: 'var(--ink)' },
  '.cm-cursor': { borderLeftColor: 'var(--ink)' },
  '.cm-gutters': { backgroundColor: 'var(--page)', color: 'var(--muted)', borderRight: '1px solid var(--line)' },
  '.cm-activeLine, .cm-activeLineGutter': { backgroundColor: 'var(--active)' },
  '&.cm-focused .cm-selectionBackground, .cm-selectionBackground': { backgroundColor: 'var(--selected) !important' },
  '.cm-tooltip': { backgroundColor: 'var(--panel)', color: 'var(--ink)', border: '1px solid var(--line)', borderRadius: '5px',
    zIndex: 5 },
  '.cm-tooltip pre': { margin: 0, padding: '6px 8px', maxWidth: 'min(80ch, 90vw)', maxHeight: '40vh', overflow: 'auto', whiteSpace: 'pre-wrap',
    fontSize: '12px' },
  '.cm-tooltip.cm-tooltip-autocomplete > ul': { maxHeight: '16em', fontFamily: 'inherit', maxWidth: 'min(60ch, 90vw)' },
  '.cm-tooltip-autocomplete ul li[aria-selected]': { backgroundColor: 'var(--chosen) !important', color: '#fff !important' },
  '.cm-completionDetail': { opacity: 0.75, fontStyle: 'normal' },
  '.cm-diagnostic': { whiteSpace: 'pre-wrap', maxWidth: '70ch' },
  '.cm-diagnostic-error': { borderLeftColor: 'var(--bad)' },
  '.cm-diagnostic-warning': { borderLeftColor: 'var(--warn)' },
});

export class Code {
  // `ask(what, question)` asks the server; `onChange`, `onSave` are called without arguments.
  constructor({ text, vocabulary, ask, onChange, onSave }) {
    this.ask = ask;
    this.object = element('div', { id: 'text' });
    this.view = new EditorView({
      parent: this.object,
      state: EditorState.create({ doc: text, extensions: [
        EditorState.lineSeparator.of(text.includes('\r\n') ? '\r\n' : '\n'), // kept in the file
        lineNumbers(), lintGutter(), history(), drawSelection(), indentOnInput(), bracketMatching(), closeBrackets(), highlightActiveLine(),
        indentUnit.of('  '), languageOf(vocabulary), kTheme,
        autocompletion({ icons: false, override: [(context) => this.complete(context)] }),
        hoverTooltip((view, at) => this.describe(at)),
        // Tab indents; Escape and then Tab leaves the text, by the view itself.
        keymap.of([{ key: 'Mod-s', preventDefault: true, run: () => { onSave(); return true; } },
          ...closeBracketsKeymap, ...completionKeymap, ...lintKeymap, ...historyKeymap, ...defaultKeymap, indentWithTab]),
        EditorView.contentAttributes.of({ 'aria-label': 'text of the scenario; Escape and then Tab leaves it', spellcheck: 'false' }),
        EditorView.updateListener.of((update) => { if (update.docChanged && !this.isTaking) onChange(); }),
      ] }),
    });
  }

  get text() { return this.view.state.sliceDoc(); }

  // Changes only the part that differs, so that the cursor and the history stay.
  set text(text) {
    const old = this.text;
    if (old === text) return;
    const now = this.view.state.toText(text).toString(), before = this.view.state.doc.toString();
    const most = Math.min(before.length, now.length);
    let begin = 0, end = 0;
    while (begin < most && before[begin] === now[begin]) ++begin;
    while (end < most - begin && before.at(-1 - end) === now.at(-1 - end)) ++end;
    this.isTaking = true;
    this.view.dispatch({ changes: { from: begin, to: before.length - end,
      insert: this.view.state.toText(now.slice(begin, now.length - end)) } });
    this.isTaking = false;
  }

  offsetOf({ line, character }) {
    const { doc } = this.view.state;
    if (line >= doc.lines) return doc.length;
    const { from, length } = doc.line(line + 1);
    return from + Math.min(character, length);
  }

  positionOf(offset) {
    const { number, from } = this.view.state.doc.lineAt(offset);
    return { line: number - 1, character: offset - from };
  }

  // Shows the diagnostics of the present text.
  mark(diagnostics) {
    const list = diagnostics.map(({ range, message, level }) =>
      ({ from: this.offsetOf(range.start), to: this.offsetOf(range.end), severity: level, message }));
    this.view.dispatch(setDiagnostics(this.view.state, list));
  }

  goTo({ start, end }) {
    this.view.dispatch({ selection: { anchor: this.offsetOf(start), head: this.offsetOf(end) }, scrollIntoView: true });
    this.view.focus();
  }

  async complete(context) {
    if (!context.explicit && !context.matchBefore(/[\w.("]$/)) return null;
    const items = await this.ask('complete', { text: this.text, ...this.positionOf(context.pos) });
    if (context.aborted || !items?.length) return null;
    const { start, end } = items[0].textEdit.range;
    return { from: this.offsetOf(start), to: this.offsetOf(end), validFor: /^[\w."]*$/,
      options: items.map(({ label, detail }) => ({ label, detail })) };
  }

  async describe(at) {
    const { text } = this;
    const answer = await this.ask('hover', { text, ...this.positionOf(at) });
    if (!answer || text !== this.text) return null;
    const words = answer.contents.value.replace(/^```text\n/, '').replace(/\n```$/, '');
    return { pos: this.offsetOf(answer.range.start), end: this.offsetOf(answer.range.end),
      create: () => ({ dom: element('pre', {}, words) }) };
  }
}
