// The player below the scene: play, step, speed, clock and time line.
import { Timeline } from './timeline.js';
import { element, number } from './text.js';

const kSpeeds = [0.001, 0.01, 0.1, 0.25, 0.5, 1, 2, 4, 10, 100];

export class Player {
  constructor(recordings, app, theme) {
    this.recordings = recordings;
    this.timeline = new Timeline(recordings, { onSeek: (time) => app.seek(time), theme });
    const button = (id, text, label, action) =>
      element('button', { type: 'button', id, 'aria-label': label, title: label, onclick: action }, text);
    this.play = button('play', '▶', 'play or pause (space)', () => app.set({ isPlaying: !app.state.isPlaying }));
    this.speed = element('select', { id: 'speed', 'aria-label': 'speed',
      onchange: () => app.set({ speed: Number(this.speed.value) }) },
    ...kSpeeds.map((speed) => element('option', { value: speed }, speed === 1 ? 'real time' : `${speed} × real time`)));
    const series = [...new Set(recordings.flatMap((recording) => recording.series.map(({ name }) => name)))];
    this.series = element('select', { id: 'series', 'aria-label': 'series below the times', hidden: series.length === 0,
      onchange: () => app.set({ series: this.series.value }) },
    ...series.map((name) => element('option', { value: name }, name.replaceAll('_', ' '))));
    this.clock = element('output', { id: 'clock' });
    const isStill = recordings.every(({ frames }) => frames < 2);
    this.object = element('footer', { class: recordings.length > 1 ? 'two' : '' },
      element('div', { class: 'bar' },
        ...(isStill ? [] : [button('home', '«', 'first frame (Home)', () => app.seek(0)),
          button('back', '‹', 'previous frame (←)', () => app.step(-1)), this.play,
          button('forward', '›', 'next frame (→)', () => app.step(1)),
          button('end', '»', 'last frame (End)', () => app.seek(Infinity)), this.speed]),
        this.clock, element('span', { class: 'gap' }), ...this.timeline.legend(), this.series),
      ...(recordings.some(({ run }) => run.cycles > 0) ? [this.timeline.object] : []));
  }

  // The initial speed: runs longer than a minute play in 30 s; others at most in real time, for at least
  // 1.5 s.
  suitableSpeed() {
    const span = Math.max(...this.recordings.map(({ begin, end }) => end - begin));
    if (!(span > 0)) return 1;
    if (span > 60) return kSpeeds.find((speed) => span / speed <= 30) ?? kSpeeds.at(-1);
    return [...kSpeeds].reverse().find((speed) => speed <= 1 && span / speed >= 1.5) ?? kSpeeds[0];
  }
  nextSpeed(speed, by) {
    const at = kSpeeds.indexOf(speed) + by;
    return kSpeeds[Math.min(Math.max(at, 0), kSpeeds.length - 1)];
  }

  update(state) {
    this.play.textContent = state.isPlaying ? '▮▮' : '▶';
    this.speed.value = state.speed;
    this.timeline.series = this.series.hidden ? null : state.series;
    this.series.value = state.series;
  }

  setClock(frames) {
    const texts = this.recordings.map((recording, i) => {
      const tag = this.recordings.length > 1 ? `${'AB'[i]} ` : '';
      if (recording.isStart) return `${tag}start`;
      return `${tag}cycle ${recording.cycleOf(frames[i])} of ${recording.run.cycles}, ${number(recording.timeOf(frames[i]))} s`;
    });
    this.clock.textContent = texts.join(' · ');
  }
}
