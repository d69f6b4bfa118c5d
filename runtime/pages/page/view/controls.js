// The panel beside the scene: colour, switches, view, and the picked body.
import { kColourModes, rampGradient, shapeOf } from './colours.js';
import { element, number } from './text.js';

const needs = (word) => `not recorded: add ${word} to record`;

export const kSwitches = [
  { id: 'walls', name: 'walls and grid', why: () => false },
  { id: 'shadows', name: 'shadows', why: () => false },
  { id: 'boxes', name: 'boxes', why: (recordings) => recordings.every(({ boxes }) => !boxes) && needs('boxes') },
  { id: 'pairs', name: 'pairs: boxes that overlap',
    why: (recordings) => recordings.every(({ boxes }) => !boxes) && needs('boxes') },
  { id: 'contacts', name: 'contacts with normals',
    why: (recordings) => recordings.every(({ contacts }) => !contacts) && needs('contacts') },
];

function row(control, name, why) {
  return element('label', { class: why ? 'row off' : 'row', title: why || undefined }, control,
    element('span', {}, name, ...(why ? [element('small', {}, why)] : [])));
}

export class Controls {
  constructor(recordings, app) {
    this.recordings = recordings;
    this.app = app;
    this.colour = element('select', { id: 'colour', 'aria-label': 'colour by',
      onchange: () => app.set({ colour: this.colour.value }) },
    ...kColourModes.map(({ id, name, why }) => {
      const reason = why(recordings);
      return element('option', { value: id, disabled: Boolean(reason) }, reason ? `${name} (${reason})` : name);
    }));
    this.switches = kSwitches.map(({ id, name, why }) => {
      const reason = why(recordings);
      const box = element('input', { type: 'checkbox', id: `show-${id}`, disabled: Boolean(reason),
        onchange: () => app.set({ show: this.shown() }) });
      return { id, box, row: row(box, name, reason) };
    });
    this.magnify = element('input', { type: 'number', id: 'magnify', min: 0.1, step: 'any',
      onchange: () => app.set({ magnify: Math.max(Number(this.magnify.value) || 1, 1e-3) }) });
    this.legend = element('div', { class: 'legend' });
    this.note = element('small', {});
    this.makeBodyPanel();
    this.object = element('aside', {},
      element('fieldset', {}, element('legend', {}, 'Colour by'), this.colour, this.legend),
      element('fieldset', {}, element('legend', {}, 'Show'), ...this.switches.map((each) => each.row), this.note),
      this.bodyPanel,
      element('fieldset', {}, element('legend', {}, 'View'),
        row(this.magnify, '× size of the bodies'),
        element('div', { class: 'buttons' },
          element('button', { type: 'button', id: 'frame', onclick: () => app.frameAll() }, 'Frame all'),
          element('button', { type: 'button', id: 'png', onclick: () => app.savePng() }, 'Save PNG')),
        element('small', {}, 'Drag: rotate. Right button or two fingers: pan. Wheel: zoom. Space: play. ← →: one frame '
          + '(shift: ten). Home, End. [ ]: slower, faster. Click a body to see its data.')));
  }

  makeBodyPanel() {
    const { recordings, app } = this;
    this.run = element('select', { 'aria-label': 'run', hidden: recordings.length < 2, onchange: () => this.pickTyped() },
      ...recordings.map((_, i) => element('option', { value: i }, 'AB'[i])));
    this.body = element('input', { type: 'number', id: 'body', min: 0, placeholder: 'index', 'aria-label': 'index of a body',
      onchange: () => this.pickTyped() });
    this.facts = element('dl', { id: 'facts' });
    this.bodyPanel = element('fieldset', {}, element('legend', {}, 'Body'),
      element('div', { class: 'buttons' }, this.run, this.body,
        element('button', { type: 'button', onclick: () => app.set({ picked: null }) }, 'Clear')), this.facts);
  }

  pickTyped() {
    const run = Number(this.run.value || 0), body = Number(this.body.value);
    const isThere = this.body.value !== '' && Number.isInteger(body) && body >= 0 && body < this.recordings[run].count;
    this.app.set({ picked: isThere ? { run, body } : null });
  }

  // Scrolls only the panel, not the page.
  showBodyPanel() {
    const { bodyPanel, object } = this;
    object.scrollTop = Math.max(object.scrollTop, bodyPanel.offsetTop + bodyPanel.offsetHeight - object.clientHeight);
  }

  shown() { return this.switches.filter(({ box }) => box.checked).map(({ id }) => id); }

  update(state) {
    this.colour.value = state.colour;
    for (const { id, box } of this.switches) box.checked = state.show.includes(id) && !box.disabled;
    this.magnify.value = state.magnify;
    this.run.value = state.picked?.run ?? this.run.value;
    this.body.value = state.picked?.body ?? '';
  }

  setLegend({ ends, note, swatches }) {
    const made = swatches
      ? swatches.map(({ name, colour }) => element('span', { class: 'swatch' },
        element('i', { style: `background:${colour}` }), name))
      : [element('div', { class: 'ramp', style: `background:${rampGradient()}` }),
        element('div', { class: 'ends' }, ...ends.map((end) => element('span', {}, end)))];
    this.legend.replaceChildren(...made, ...(note ? [element('small', {}, note)] : []));
  }

  setNote(text) { this.note.textContent = text; }

  // The data of the picked body in this frame.
  setFacts(picked, frames) {
    if (!picked) {
      this.facts.replaceChildren(element('dd', {}, 'Click a body, or type its index.'));
      return;
    }
    const { run, body } = picked;
    const recording = this.recordings[run], frame = frames[run];
    const list = (values, digits) => values.map((value) => Number(value.toPrecision(digits))).join(' ');
    const facts = {
      index: `${body}`,
      group: recording.run.groups[recording.group[body]].name,
      shape: shapeOf(recording, body),
      sides: `${list([...recording.sides.subarray(3 * body, 3 * body + 3)], 3)} m`,
      mass: recording.mass[body] > 0 ? `${number(recording.mass[body])} kg` : 'fixed',
      position: `${list(recording.positionOf(frame, body, [0, 0, 0]), 7)} m`,
      turn: `${list(recording.orientationOf(frame, body, [0, 0, 0, 1]), 4)} (x y z w)`,
    };
    if (recording.frames > 1) facts.speed = `${number(recording.speeds(frame)[body])} m/s`;
    if (recording.contacts) facts.contacts = `${recording.contactCounts(frame)[body]}`;
    if (!recording.isStart) facts.unmoved = recording.isUnmoved(frame, body) ? 'since the previous cycle' : 'no';
    this.facts.replaceChildren(...Object.entries(facts).flatMap(([name, value]) =>
      [element('dt', {}, name), element('dd', { id: `fact-${name}` }, value)]));
  }
}
