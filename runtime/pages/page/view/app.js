// One or two runs on a page: bodies in 3-D, and the times below them.
import { Controls } from './controls.js';
import { kColourModes } from './colours.js';
import { makeHead } from './head.js';
import { Player } from './player.js';
import { readAddress, writeAddress } from './address.js';
import { Recording } from './recording.js';
import { Stage } from './stage.js';
import { element } from './text.js';

export class App {
  // Fills `root`, which has the class `app`.
  constructor({ title, runs }, root) {
    this.listeners = new AbortController();
    this.title = title;
    this.recordings = runs.map((run) => new Recording(run));
    this.begin = Math.min(...this.recordings.map(({ begin }) => begin));
    this.end = Math.max(...this.recordings.map(({ end }) => end));
    this.theme = this.readTheme();
    this.canvas = element('canvas', { id: 'scene', 'aria-label': 'the bodies in 3-D' });
    this.sizeTag = element('span', { class: 'tag low', hidden: true });
    this.stageBox = element('div', { id: 'stage' }, this.canvas, ...this.tags(), this.sizeTag);
    this.controls = new Controls(this.recordings, this);
    this.player = new Player(this.recordings, this, () => this.theme);
    root.replaceChildren(makeHead(title, this.recordings), this.stageBox, this.controls.object,
      this.player.object);
    this.makeStage();
    this.state = this.initialState();
    this.listen();
    this.resize();
    this.stage?.frameAll();
    this.apply(readAddress());
  }

  tags() {
    if (this.recordings.length < 2) return [];
    return this.recordings.map(({ run }, i) => element('span', { class: `tag tag${i}` },
      element('b', { class: `run${i}` }, 'AB'[i]), ` ${run.name || run.file}`));
  }

  makeStage() {
    try {
      this.stage = new Stage(this.recordings, this.canvas, () => this.cameraMoved());
    } catch {
      this.stage = null;
      this.canvas.remove();
      this.stageBox.append(element('p', { class: 'notice' },
        'This browser has no WebGL, so the bodies cannot be drawn; the time line still works.'));
    }
  }

  initialState() {
    const isThere = (id) => !kColourModes.find((mode) => mode.id === id).why(this.recordings);
    const groups = Math.max(...this.recordings.map(({ run }) => run.groups.length));
    const colour = isThere('speed') ? 'speed' : groups > 1 ? 'group' : 'shape';
    const series = this.recordings.flatMap((recording) => recording.series.map(({ name }) => name));
    return { time: this.begin, isPlaying: false, speed: this.player.suitableSpeed(), colour,
      series: series.includes('pairs') ? 'pairs' : series[0], show: ['walls', 'shadows'], picked: null,
      magnify: this.stage?.magnify ?? 1 };
  }

  // Applies the state from an address; settings that it does not name are kept.
  apply({ camera, ...state }) {
    const known = Object.fromEntries(Object.entries(state).filter(([, value]) => value !== undefined));
    const mode = kColourModes.find(({ id }) => id === known.colour);
    if (!mode || mode.why(this.recordings)) delete known.colour;
    if (known.picked && !(known.picked.body < this.recordings[known.picked.run]?.count)) delete known.picked;
    if (camera && this.stage) {
      this.stage.camera.position.set(...camera.slice(0, 3));
      this.stage.controls.target.set(...camera.slice(3));
      this.stage.controls.update();
    }
    this.set(known);
  }

  set(changes) {
    const { state } = this;
    const isNewColour = !this.colours || (changes.colour && changes.colour !== state.colour);
    if (changes.isPlaying && state.time >= this.end - 1e-9) state.time = this.begin;
    Object.assign(state, changes);
    state.time = Math.min(Math.max(state.time, this.begin), this.end);
    if (isNewColour) {
      this.colours = kColourModes.find(({ id }) => id === state.colour).make(this.recordings);
      this.controls.setLegend(this.colours.legend);
    }
    this.controls.update(state);
    this.sizeTag.hidden = state.magnify === 1;
    this.sizeTag.textContent = `bodies are drawn at ${state.magnify} times their size`;
    this.player.update(state);
    this.frames = null; // redraws everything
    this.refresh();
    this.remember();
    if (state.isPlaying && !this.clockTick) {
      this.lastTick = performance.now();
      this.clockTick = requestAnimationFrame((now) => this.tick(now));
    }
  }

  seek(time) { this.set({ time, isPlaying: false }); }

  step(by) {
    const [recording] = [...this.recordings].sort((a, b) => a.run.timestep * a.run.frames.every - b.run.timestep * b.run.frames.every);
    const frame = Math.min(Math.max(recording.frameAt(this.state.time) + by, 0), recording.frames - 1);
    this.seek(recording.timeOf(frame));
  }

  tick(now) {
    this.clockTick = null;
    if (!this.state.isPlaying) return;
    // After the page was hidden, the run continues where it was.
    this.state.time += Math.min((now - this.lastTick) / 1000, 0.5) * this.state.speed;
    this.lastTick = now;
    if (this.state.time >= this.end) {
      this.set({ time: this.end, isPlaying: false });
      return;
    }
    this.refresh();
    this.clockTick = requestAnimationFrame((next) => this.tick(next));
  }

  // Draws the frames of the current time, unless they are drawn already.
  refresh() {
    const frames = this.recordings.map((recording) => recording.frameAt(this.state.time));
    if (this.frames && frames.every((frame, i) => frame === this.frames[i])) return;
    this.frames = frames;
    const { show, picked, magnify } = this.state;
    const switches = Object.fromEntries(show.map((id) => [id, true]));
    if (this.stage) {
      this.stage.setMagnify(magnify);
      this.stage.setShadows(Boolean(switches.shadows));
      this.stage.panels.forEach((panel, i) => { panel.bodies.picked = picked?.run === i ? picked.body : -1; });
      this.stage.show(frames, this.colours, switches);
    }
    this.player.setClock(frames);
    this.player.timeline.draw(this.recordings.map((recording, i) => recording.timeOf(frames[i])));
    this.controls.setFacts(picked, frames);
    this.controls.setNote(this.noteOf(frames, switches));
    this.requestDraw();
  }

  noteOf(frames, switches) {
    const words = [];
    const gridStep = this.stage?.panels[0].overlays.gridStep;
    if (switches.walls && gridStep) words.push(`Grid: ${gridStep} m.`);
    if (switches.pairs) words.push(`${this.recordings.map((r, i) => (r.boxes ? r.pairs(frames[i]).length : 0)).join(' / ')} pairs of objects; walls are not counted.`);
    if (switches.contacts) {
      const counts = this.recordings.map((r, i) => (r.contacts ? r.contactRange(frames[i])[1] - r.contactRange(frames[i])[0] : 0));
      const depth = Math.max(...this.stage.panels.map(({ overlays }) => overlays.maxDepth));
      words.push(`${counts.join(' / ')} contacts: blue if apart, yellow to red by depth, at most ${Number(depth.toPrecision(3))} m in the run.`);
    }
    return words.join(' ');
  }

  requestDraw() {
    if (!this.stage || this.drawTick) return;
    this.drawTick = requestAnimationFrame(() => {
      this.drawTick = null;
      this.stage.draw();
      this.stageBox.dataset.drawn = this.stage.drawn;
    });
  }

  cameraMoved() {
    this.requestDraw();
    this.remember();
  }

  // Updates the address after a while without changes, because browsers limit how often it may change.
  remember() {
    clearTimeout(this.rememberTimer);
    this.rememberTimer = setTimeout(() => {
      if (this.state.isPlaying) return;
      const { camera, controls } = this.stage ?? {};
      writeAddress({ ...this.state, camera: camera ? [...camera.position.toArray(), ...controls.target.toArray()] : [] });
    }, 250);
  }

  frameAll() {
    this.stage?.frameAll();
    this.requestDraw();
  }

  readTheme() {
    const style = getComputedStyle(document.documentElement);
    const of = (name) => style.getPropertyValue(`--${name}`).trim();
    return { ...Object.fromEntries(['stage', 'panel', 'ink', 'muted', 'line', 'accent', 'bad'].map((name) => [name, of(name)])),
      isDark: matchMedia('(prefers-color-scheme: dark)').matches };
  }

  resize() {
    this.theme = this.readTheme();
    const { width, height } = this.stageBox.getBoundingClientRect();
    this.stage?.resize(width, height);
    this.stage?.setTheme(this.theme);
    this.frames = null;
    if (this.colours) this.refresh();
  }

  listen() {
    const { signal } = this.listeners;
    this.observer = new ResizeObserver(() => this.resize());
    this.observer.observe(this.stageBox);
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => this.resize(), { signal });
    addEventListener('hashchange', () => this.apply(readAddress()), { signal });
    addEventListener('keydown', (event) => this.key(event), { signal });
    let down = null;
    this.canvas.addEventListener('pointerdown', (event) => { down = [event.clientX, event.clientY]; });
    this.canvas.addEventListener('pointerup', (event) => {
      if (!down || event.button !== 0 || Math.hypot(event.clientX - down[0], event.clientY - down[1]) > 4) return;
      const box = this.canvas.getBoundingClientRect();
      this.set({ picked: this.stage.pick(event.clientX - box.left, event.clientY - box.top) });
      this.controls.showBodyPanel();
    });
  }

  // Call this before another app replaces it.
  dispose() {
    this.state.isPlaying = false;
    this.listeners.abort();
    this.observer.disconnect();
    clearTimeout(this.rememberTimer);
    cancelAnimationFrame(this.drawTick);
    this.stage?.renderer.dispose();
    this.stage?.renderer.forceContextLoss();
  }

  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey || event.target.closest('input, select, textarea, [contenteditable]')) return;
    if (event.key === ' ' && event.target.closest('button, summary')) return; // the key presses it
    const far = event.shiftKey ? 10 : 1;
    const actions = {
      ' ': () => this.set({ isPlaying: !this.state.isPlaying }),
      ArrowLeft: () => this.step(-far),
      ArrowRight: () => this.step(far),
      Home: () => this.seek(this.begin),
      End: () => this.seek(this.end),
      '[': () => this.set({ speed: this.player.nextSpeed(this.state.speed, -1) }),
      ']': () => this.set({ speed: this.player.nextSpeed(this.state.speed, 1) }),
      Escape: () => this.set({ picked: null }),
    };
    const action = actions[event.key];
    if (!action) return;
    event.preventDefault();
    action();
  }

  // Saves the scene as it is shown, with a caption.
  savePng() {
    if (!this.stage) return;
    this.stage.draw();
    const { width, height } = this.canvas;
    const line = Math.max(24, Math.round(height / 26));
    const image = element('canvas', { width, height: height + line });
    const pen = image.getContext('2d');
    pen.fillStyle = this.theme.panel;
    pen.fillRect(0, 0, width, height + line);
    pen.drawImage(this.canvas, 0, 0);
    pen.fillStyle = this.theme.ink;
    pen.font = `${Math.round(line * 0.55)}px system-ui, sans-serif`;
    pen.fillText([this.title, ...this.recordings.map(({ run }) => run.name), this.player.clock.textContent,
      `colour: ${this.state.colour}`].filter(Boolean).join(' · '), line * 0.4, height + line * 0.68);
    image.toBlob((blob) => {
      const link = element('a', { href: URL.createObjectURL(blob), download: `${this.recordings[0].run.benchmark}.png` });
      link.click();
      setTimeout(() => URL.revokeObjectURL(link.href), 10000);
    });
  }
}
