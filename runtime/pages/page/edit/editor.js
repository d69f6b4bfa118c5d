// The editor of a scenario: its text, its parameters from the schema, its scene, and a run of it.
// The server is `cdb view --serve`; runtime/pages/serve/server.h defines its answers.
import { App } from '../view/app.js';
import { element } from '../view/text.js';
import { Code } from './code.js';
import { levelOf, Problems } from './problems.js';

const kPause = 300; // ms after the last key before the text is checked

async function ask(what, question = {}) {
  const answer = await fetch(what, { method: 'POST', body: JSON.stringify(question) });
  if (!answer.ok) throw new Error((await answer.text()).trim() || `the server answers ${answer.status}`);
  return answer.json();
}

export class Editor {
  constructor(data, page) {
    const { editor } = data;
    page.className = 'editing';
    this.benchmark = editor.benchmark;
    this.view = element('div', { class: 'app' }, element('p', { class: 'notice' }, 'There is no scene yet: the text has errors.'));
    this.code = new Code({ text: editor.text, vocabulary: editor.vocabulary, onChange: () => this.checkSoon(),
      onSave: () => this.guard(() => this.save()),
      ask: (what, question) => ask(what, this.about(question)).catch((error) => { this.say(error); return null; }) });
    this.problems = new Problems((range) => this.code.goTo(range));
    this.choice = element('select', { id: 'benchmark', 'aria-label': 'benchmark', onchange: () => {
      this.benchmark = this.choice.value;
      this.guard(() => this.check());
    } });
    this.filter = element('input', { type: 'search', id: 'filter', placeholder: 'find a parameter', 'aria-label': 'find a parameter',
      oninput: () => this.showParameters() });
    this.parameters = element('div', { id: 'parameters' });
    this.log = element('pre', { id: 'log', role: 'status' });
    const button = (id, text, action, title) => element('button', { type: 'button', id, title, onclick: () => this.guard(action) }, text);
    this.saveButton = button('save', 'Save', () => this.save(), 'Ctrl-S');
    this.runButton = button('run', 'Save and run', () => this.run());
    this.stopButton = button('stop', 'Stop', () => ask('stop'));
    this.stopButton.disabled = true;
    page.replaceChildren(element('section', { id: 'editor' },
      element('div', { class: 'bar' }, element('h2', {}, editor.file), this.choice, element('span', { class: 'gap' }),
        this.saveButton, this.runButton, this.stopButton),
      this.log, this.code.object, this.problems.summary, this.problems.list,
      element('details', { id: 'values', open: innerWidth > 1000 }, element('summary', {}, 'Parameters'), this.filter, this.parameters)), this.view);
    this.saved = editor.text;
    this.take({ ...editor, scene: data.runs.length ? data : null });
    addEventListener('beforeunload', (event) => { if (this.isChanged()) event.preventDefault(); });
    addEventListener('keydown', (event) => {
      if (event.key !== 's' || !(event.ctrlKey || event.metaKey) || event.defaultPrevented) return;
      event.preventDefault();
      this.guard(() => this.save());
    });
  }

  about(question) { return { ...question, benchmark: this.benchmark }; }
  isChanged() { return this.code.text !== this.saved; }
  say(error) { this.log.textContent = error instanceof TypeError ? 'The server does not answer: is `cdb view --serve` still running?' : error.message; }

  // Shows the server's answer for a text. If the text has errors, the last scene is kept.
  take({ text, benchmark, benchmarks, notice, diagnostics, parameters, scene }) {
    this.code.text = text;
    const list = diagnostics.map((each) => ({ ...each, level: levelOf(each) }));
    this.code.mark(list);
    this.problems.show(list, !scene && this.app ? 'the scene is that of the last text without errors' : '');
    this.benchmark = benchmark;
    this.choice.replaceChildren(...benchmarks.map((name) => element('option', { value: name, selected: name === benchmark }, name)));
    this.choice.hidden = benchmarks.length < 2;
    if (notice) this.log.textContent = notice;
    if (parameters) {
      this.all = parameters;
      this.showParameters();
    }
    this.view.classList.toggle('stale', !scene);
    if (scene) this.show(scene);
    this.showState();
  }

  showState() {
    this.saveButton.textContent = this.isChanged() ? 'Save *' : 'Save';
    document.title = `${this.isChanged() ? '* ' : ''}${this.benchmark} (cdb view)`;
  }

  show(scene) {
    const radius = this.app?.stage?.radius;
    this.app?.dispose();
    this.app = new App(scene, this.view);
    // The camera stays, unless the scene has another size.
    const ratio = this.app.stage?.radius / radius;
    if (ratio > 1.25 || ratio < 0.8) this.app.frameAll();
  }

  async guard(action) {
    try {
      await action();
    } catch (error) {
      this.say(error);
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

  async setValue(group, name, value) {
    clearTimeout(this.timer);
    const asked = this.code.text;
    const answer = await ask('set', this.about({ text: asked, group, name, value }));
    if (answer.message) this.log.textContent = answer.message;
    else if (asked === this.code.text) this.take(answer);
  }

  checkSoon() {
    this.showState();
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.guard(() => this.check()), kPause);
  }

  // One question at a time. The answer is dropped if the text has changed meanwhile, and the new text is checked.
  async check() {
    this.isWanted = true;
    if (this.isChecking) return;
    this.isChecking = true;
    try {
      while (this.isWanted) {
        this.isWanted = false;
        const asked = this.code.text;
        const answer = await ask('check', this.about({ text: asked }));
        if (answer.message) throw new Error(answer.message);
        if (asked === this.code.text) this.take(answer);
      }
    } finally {
      this.isChecking = false;
    }
  }

  async save() {
    const { text } = this.code;
    const { message } = await ask('save', { text });
    if (message.startsWith('saved')) this.saved = text;
    this.log.textContent = message;
    this.showState();
  }

  async run() {
    const { text } = this.code;
    const { message } = await ask('run', this.about({ text }));
    this.log.textContent = message;
    if (message !== 'running') return;
    this.saved = text;
    this.showState();
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
