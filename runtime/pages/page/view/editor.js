// The editor of a scenario: its parameters from the schema, its text, its scene, and a run of it.
// The server is `cdb view --serve`; runtime/pages/serve/server.h defines its answers.
import { App } from './app.js';
import { element } from './text.js';

const kPause = 400; // ms after the last key before the text is checked

async function ask(what, question = {}) {
  const answer = await fetch(what, { method: 'POST', body: JSON.stringify(question) });
  if (!answer.ok) throw new Error(`the server answers ${answer.status}`);
  return answer.json();
}

export class Editor {
  constructor(data, page) {
    page.className = 'editing';
    this.view = element('div', { class: 'app' });
    this.filter = element('input', { type: 'search', id: 'filter', placeholder: 'find a parameter', 'aria-label': 'find a parameter',
      oninput: () => this.showParameters() });
    this.parameters = element('div', { id: 'parameters' });
    this.text = element('textarea', { id: 'text', spellcheck: 'false', 'aria-label': 'text of the scenario',
      oninput: () => this.checkSoon() });
    this.diagnostics = element('pre', { id: 'diagnostics', role: 'status' });
    this.log = element('pre', { id: 'log', role: 'status' });
    const button = (id, text, action) => element('button', { type: 'button', id, onclick: () => this.guard(action) }, text);
    this.runButton = button('run', 'Save and run', () => this.run());
    this.stopButton = button('stop', 'Stop', () => ask('stop'));
    this.stopButton.disabled = true;
    page.replaceChildren(element('section', { id: 'editor' }, element('h2', {}, data.editor.file), this.filter, this.parameters,
      this.text, this.diagnostics,
      element('div', { class: 'buttons' }, button('save', 'Save', () => this.save()), this.runButton, this.stopButton),
      this.log), this.view);
    this.saved = data.editor.text;
    this.take({ ...data.editor, scene: data.runs.length ? data : null });
    addEventListener('beforeunload', (event) => { if (this.text.value !== this.saved) event.preventDefault(); });
  }

  // Shows the server's answer for a text. If the text has errors, the last scene is kept.
  take({ text, diagnostics, parameters, scene }) {
    if (this.text.value !== text) this.text.value = text;
    this.diagnostics.textContent = diagnostics;
    if (parameters?.length) {
      this.all = parameters;
      this.showParameters();
    }
    if (scene) this.show(scene);
  }

  show(scene) {
    this.app?.dispose();
    this.app = new App(scene, this.view);
  }

  async guard(action) {
    try {
      await action();
    } catch (error) {
      this.log.textContent = `${error.message}: is \`cdb view --serve\` still running?`;
    }
  }

  showParameters() {
    const wanted = this.filter.value.trim().toLowerCase();
    const groups = new Map();
    for (const each of this.all ?? []) {
      if (wanted && !`${each.group} ${each.name} ${each.doc}`.toLowerCase().includes(wanted)) continue;
      if (!groups.has(each.group)) groups.set(each.group, []);
      groups.get(each.group).push(each);
    }
    const top = this.parameters.scrollTop;
    this.parameters.replaceChildren(...[...groups].flatMap(([group, list]) =>
      [element('h3', {}, group ? `objects: ${group}` : 'world and run'), ...list.map((each) => this.rowOf(each))]));
    this.parameters.scrollTop = top;
  }

  rowOf({ group, name, value, default: usual, takes, unit, doc }) {
    const input = element('input', { 'data-name': group ? `${group}.${name}` : name, placeholder: usual, title: takes,
      onchange: () => this.guard(() => this.setValue(group, name, input.value)) });
    input.value = value ?? '';
    return element('label', { class: value === null ? 'parameter' : 'parameter set' }, element('span', {}, name), input,
      element('small', {}, `${doc}${unit ? `, ${unit}` : ''}`));
  }

  // Sends one request at a time. The answer is dropped if the text has changed meanwhile.
  async update(what, question) {
    const asked = this.text.value;
    const number = this.question = (this.question ?? 0) + 1;
    const answer = await ask(what, { text: asked, ...question });
    if (number === this.question && asked === this.text.value) this.take(answer);
  }

  setValue(group, name, value) {
    clearTimeout(this.timer);
    return this.update('set', { group, name, value });
  }

  checkSoon() {
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.guard(() => this.update('check', {})), kPause);
  }

  async save() {
    const text = this.text.value;
    const { message } = await ask('save', { text });
    if (message.startsWith('saved')) this.saved = text;
    this.log.textContent = message;
  }

  async run() {
    const text = this.text.value;
    const { message } = await ask('run', { text });
    this.log.textContent = message;
    if (message !== 'running') return;
    this.saved = text;
    this.runButton.disabled = true;
    this.stopButton.disabled = false;
    this.watch();
  }

  watch() {
    setTimeout(() => this.guard(async () => {
      const { is_running: isRunning, log, scene } = await ask('progress');
      this.log.textContent = log || 'running';
      this.log.scrollTop = this.log.scrollHeight;
      if (isRunning) {
        this.watch();
        return;
      }
      this.runButton.disabled = false;
      this.stopButton.disabled = true;
      if (!scene) return;
      this.show(scene);
      this.app.set({ time: this.app.begin, isPlaying: true });
    }), 300);
  }
}
