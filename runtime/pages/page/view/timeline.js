// The run's times and series over simulated time, with a cursor. A click seeks.
import { duration, element, number } from './text.js';

const kPhases = ['broad', 'narrow', 'solve', 'integrate'];
const kLeft = 64, kRight = 14, kAxis = 20, kGap = 12;

const phaseColours = { broad: '#0072b2', narrow: '#56b4e9', solve: '#e69f00', integrate: '#009e73', other: '#a0a0a0' };
export const kRunColours = ['#0072b2', '#d55e00'];

function percentile(values, part) {
  const sorted = Float32Array.from(values.filter(Number.isFinite)).sort();
  return sorted.length ? sorted[Math.floor(part * (sorted.length - 1))] : 0;
}

// Two to five round numbers from low to high.
function ticks(low, high, count = 4) {
  const raw = (high - low) / count;
  if (!(raw > 0)) return [low];
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = power * [1, 2, 5, 10].find((factor) => factor * power >= raw);
  const all = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + step * 1e-9; ++k) all.push(k * step);
  return all;
}

export class Timeline {
  constructor(recordings, { onSeek, theme }) {
    this.recordings = recordings;
    this.theme = theme;
    this.canvas = element('canvas', { tabindex: 0, role: 'slider', 'aria-label': 'time line', 'aria-valuemin': 0 });
    this.tip = element('div', { class: 'tip', hidden: true });
    this.object = element('div', { class: 'timeline' }, this.canvas, this.tip);
    this.times = [0];
    this.begin = 0;
    this.end = Math.max(...recordings.map(({ run, end }) =>
      Math.max(end, (run.warmup + run.cycles) * run.timestep)));
    this.series = null;
    this.steps = recordings.map(({ durations }) => durations.find(({ name }) => name === 'step')?.values);
    this.setLimits();
    const timeAt = (event) => {
      const box = this.canvas.getBoundingClientRect();
      const part = (event.clientX - box.left - kLeft) / (box.width - kLeft - kRight);
      return Math.min(Math.max(part, 0), 1) * this.end;
    };
    this.canvas.addEventListener('pointerdown', (event) => {
      this.canvas.setPointerCapture(event.pointerId);
      this.isDragged = true;
      onSeek(timeAt(event));
    });
    this.canvas.addEventListener('pointermove', (event) => {
      if (this.isDragged) onSeek(timeAt(event));
      this.showTip(event, timeAt(event));
    });
    this.canvas.addEventListener('pointerup', () => { this.isDragged = false; });
    this.canvas.addEventListener('pointerleave', () => { this.tip.hidden = true; });
  }

  // The axis ends at the longest step. If a few cycles are far longer than all others, it ends below
  // them, and they get a mark.
  setLimits() {
    const all = this.steps.flatMap((values) => (values ? [...values] : []));
    const most = percentile(all, 1), usual = percentile(all, 0.95);
    this.stepLimit = most > 6 * usual && usual > 0 ? 3 * usual : most * 1.05 || 1;
  }

  get lanes() {
    return [...this.steps.map((steps, run) => (steps ? { run } : null)).filter(Boolean),
      ...(this.series ? [{ series: this.series }] : [])];
  }

  showTip(event, time) {
    const lines = this.recordings.map((recording, run) => {
      const { timestep, warmup, cycles } = recording.run;
      const cycle = Math.min(Math.max(Math.round(time / timestep - warmup - 1), 0), cycles - 1);
      if (cycles === 0) return '';
      const words = recording.durations.filter(({ name }) => name === 'step' || kPhases.includes(name))
        .map(({ name, values, unit }) => `${name} ${duration(values[cycle], unit)}`).reverse();
      const series = recording.series.find(({ name }) => name === this.series);
      if (series) words.push(`${series.name} ${number(series.values[series.interval ? Math.round(time / series.interval) : cycle])} ${series.unit}`);
      return `${this.recordings.length > 1 ? `${'AB'[run]} ` : ''}cycle ${cycle}: ${words.join(', ')}`;
    }).filter(Boolean);
    this.tip.replaceChildren(...lines.map((line) => element('div', {}, line)));
    this.tip.hidden = lines.length === 0;
    const box = this.object.getBoundingClientRect();
    this.tip.style.left = `${Math.min(Math.max(event.clientX - box.left - 120, 4), Math.max(box.width - 320, 4))}px`;
  }

  x(time) { return kLeft + time / this.end * (this.width - kLeft - kRight); }

  draw(times) {
    this.times = times;
    const box = this.object.getBoundingClientRect();
    const ratio = devicePixelRatio || 1;
    [this.width, this.height] = [box.width, box.height];
    this.canvas.width = Math.round(box.width * ratio);
    this.canvas.height = Math.round(box.height * ratio);
    this.canvas.setAttribute('aria-valuemax', this.end.toFixed(4));
    this.canvas.setAttribute('aria-valuenow', times[0].toFixed(4));
    const pen = this.canvas.getContext('2d');
    pen.scale(ratio, ratio);
    pen.font = '11px system-ui, sans-serif';
    this.drawAxis(pen);
    const { lanes } = this;
    const room = (this.height - kAxis - 4) / (lanes.length || 1);
    lanes.forEach((lane, i) => {
      const area = { top: 8 + i * room, bottom: i * room + room - kGap + 6 };
      if (lane.series) this.drawSeries(pen, area, lane.series);
      else this.drawSteps(pen, area, lane.run);
    });
    this.drawMarks(pen);
    this.drawCursor(pen);
  }

  drawAxis(pen) {
    pen.fillStyle = this.theme().muted;
    pen.textAlign = 'center';
    const all = ticks(0, this.end, Math.max(2, Math.floor(this.width / 120)));
    for (const time of all) {
      pen.fillRect(this.x(time), this.height - kAxis, 1, 4);
      pen.fillText(`${number(time)}${time === all.at(-1) ? ' s' : ''}`, this.x(time), this.height - 5);
    }
  }

  drawScale(pen, area, low, high, text, name) {
    const { muted, line } = this.theme();
    const y = (value) => area.bottom - (value - low) / (high - low || 1) * (area.bottom - area.top);
    pen.textAlign = 'right';
    for (const value of ticks(low, high, area.bottom - area.top > 60 ? 3 : 2)) {
      pen.fillStyle = line;
      pen.fillRect(kLeft, y(value), this.width - kLeft - kRight, 0.5);
      pen.fillStyle = muted;
      pen.fillText(text(value), kLeft - 5, y(value) + 4);
    }
    pen.textAlign = 'left';
    this.label = { pen, name, x: kLeft + 5, y: area.top + 9 };
    return y;
  }

  // Draws a label over the lane, on a nearly opaque background.
  drawLabel(colour) {
    const { pen, name, x, y } = this.label;
    pen.textAlign = 'left';
    pen.fillStyle = this.theme().panel;
    pen.globalAlpha = 0.85;
    pen.fillRect(x - 3, y - 10, pen.measureText(name).width + 6, 14);
    pen.globalAlpha = 1;
    pen.fillStyle = colour;
    pen.fillText(name, x, y);
  }

  // In each column of pixels, the longest cycle.
  columns(run) {
    const steps = this.steps[run], recording = this.recordings[run];
    const longest = new Map();
    for (let cycle = 0; cycle < steps.length; ++cycle) {
      const column = Math.round(this.x(recording.timeOfCycle(cycle)));
      if (!longest.has(column) || steps[cycle] > steps[longest.get(column)]) longest.set(column, cycle);
    }
    return [...longest];
  }

  drawSteps(pen, area, run) {
    const recording = this.recordings[run];
    const tag = this.recordings.length > 1 ? `${'AB'[run]}: ` : '';
    const { unit } = recording.durations[0];
    const label = `${tag}${unit === 'ns' ? 'time' : unit} of a cycle`;
    const y = this.drawScale(pen, area, 0, this.stepLimit, (value) => duration(value, unit), label);
    const values = Object.fromEntries(recording.durations.map((each) => [each.name, each.values]));
    const columns = this.columns(run);
    const width = Math.max(1, (this.width - kLeft - kRight) / Math.max(columns.length, 1) * 1.02);
    for (const [x, cycle] of columns) {
      let sum = 0;
      const bar = (size, colour) => {
        const from = Math.min(sum, this.stepLimit), to = Math.min(sum + size, this.stepLimit);
        sum += size;
        pen.fillStyle = colour;
        pen.fillRect(x - width, y(to), width, y(from) - y(to));
      };
      for (const phase of kPhases) if (values[phase]?.[cycle] > 0) bar(values[phase][cycle], phaseColours[phase]);
      const rest = values.step[cycle] - sum;
      if (rest > 0) bar(rest, phaseColours.other);
      if (values.step[cycle] > this.stepLimit) this.drawSpike(pen, x, area.top);
    }
    this.drawLabel(this.theme().ink);
  }

  drawSpike(pen, x, top) {
    pen.fillStyle = this.theme().bad;
    pen.beginPath();
    pen.moveTo(x - 4, top + 5);
    pen.lineTo(x + 4, top + 5);
    pen.lineTo(x, top - 3);
    pen.fill();
  }

  drawSeries(pen, area, name) {
    const of = this.recordings.map(({ series }) => series.find((each) => each.name === name));
    const all = of.flatMap((series) => (series ? [...series.values].filter(Number.isFinite) : []));
    let low = Infinity, high = -Infinity;
    for (const value of all) { low = Math.min(low, value); high = Math.max(high, value); }
    if (low > 0 && low < 0.7 * high) low = 0;
    if (low === high) high = low + (Math.abs(low) || 1);
    const unit = of.find(Boolean)?.unit;
    const y = this.drawScale(pen, area, low, high, number, `${name.replaceAll('_', ' ')}${unit ? `, ${unit}` : ''}`);
    of.forEach((series, run) => {
      if (!series) return;
      pen.strokeStyle = this.recordings.length > 1 ? kRunColours[run] : this.theme().ink;
      pen.lineWidth = 1.3;
      pen.beginPath();
      let isOn = false;
      const timeOf = (at) => (series.interval ? at * series.interval : this.recordings[run].timeOfCycle(at));
      series.values.forEach((value, at) => {
        if (!Number.isFinite(value)) { isOn = false; return; }
        const x = this.x(timeOf(at));
        if (isOn) pen.lineTo(x, y(value)); else pen.moveTo(x, y(value));
        isOn = true;
      });
      pen.stroke();
    });
    this.drawLabel(this.theme().ink);
  }

  drawMarks(pen) {
    this.recordings.forEach(({ run, timeOfCycle }, i) => {
      if (!(run.first_bad_cycle >= 0)) return;
      const x = this.x(timeOfCycle.call(this.recordings[i], run.first_bad_cycle));
      pen.strokeStyle = this.theme().bad;
      pen.setLineDash([4, 3]);
      pen.beginPath();
      pen.moveTo(x, 0);
      pen.lineTo(x, this.height - kAxis);
      pen.stroke();
      pen.setLineDash([]);
      const text = `${this.recordings.length > 1 ? `${'AB'[i]} ` : ''}${run.verdict} from cycle ${run.first_bad_cycle}`;
      const width = pen.measureText(text).width;
      const isLeft = x + width + 8 > this.width;
      pen.fillStyle = this.theme().panel;
      pen.fillRect(isLeft ? x - width - 8 : x + 2, this.height - kAxis - 17 - 14 * i, width + 6, 14);
      pen.fillStyle = this.theme().bad;
      pen.textAlign = isLeft ? 'right' : 'left';
      pen.fillText(text, isLeft ? x - 5 : x + 5, this.height - kAxis - 6 - 14 * i);
    });
  }

  drawCursor(pen) {
    const x = this.x(Math.max(...this.times));
    pen.fillStyle = this.theme().ink;
    pen.fillRect(x - 1, 0, 2, this.height - kAxis + 4);
    pen.beginPath();
    pen.arc(x, this.height - kAxis + 3, 4.5, 0, 7);
    pen.fill();
  }

  // Swatches of the series in the lanes.
  legend() {
    if (!this.steps.some(Boolean)) return [];
    return [...kPhases, 'other'].map((phase) => element('span', { class: 'swatch' },
      element('i', { style: `background:${phaseColours[phase]}` }), phase));
  }
}
