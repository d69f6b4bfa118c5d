// The colour modes of bodies, with their legends.
import { Color } from 'three';
import { interpolateViridis } from 'd3-scale-chromatic';
import { number } from './text.js';

// The palette of Okabe and Ito, which colour-blind readers can distinguish, without black.
const kCategories = ['#0072b2', '#e69f00', '#009e73', '#cc79a7', '#56b4e9', '#d55e00', '#f0e442'];
const kNone = '#9a9a9a';

const linear = (text) => new Color(text).toArray();
// Viridis without its darkest part, in which shading would be invisible.
const rampText = (part) => interpolateViridis(0.2 + 0.8 * part);
const ramp = Array.from({ length: 256 }, (_, i) => linear(rampText(i / 255)));
const categories = kCategories.map(linear);
const none = linear(kNone);

export const rampGradient = () =>
  `linear-gradient(to right, ${Array.from({ length: 11 }, (_, i) => rampText(i / 10)).join(', ')})`;

// The value below which a given fraction of all values lies.
function quantile(values, part) {
  const sorted = values.filter(Number.isFinite).sort((a, b) => a - b);
  return sorted.length ? sorted[Math.min(sorted.length - 1, Math.floor(part * sorted.length))] : 0;
}

function sampledMaximum(recordings, valuesAt) {
  const values = [];
  for (const recording of recordings)
    for (let k = 0; k < 30; ++k) for (const value of valuesAt(recording, Math.floor((recording.frames - 1) * k / 29))) values.push(value);
  return quantile(values, 0.998) || quantile(values, 1) || 1;
}

// A continuous scale from `low` to `high`. `power` 0.5 uses the square root, for values that are mostly
// small.
function continuous(low, high, unit, valuesAt, { note, power = 1 } = {}) {
  const part = (value) => ((value - low) / (high - low || 1)) ** power;
  const middle = low + (high - low) * 0.5 ** (1 / power);
  return {
    colour(recording, frame) {
      const values = valuesAt(recording, frame);
      // An object that has just come has no speed.
      return (body) => ramp[Math.min(255, Math.max(0, Math.round(part(Math.max(values[body], low)) * 255)))] ?? none;
    },
    legend: { ends: [number(low), number(middle), `${number(high)} ${unit}`], note },
  };
}

// A category for each body, -1 for none.
function categorical(names, categoryAt, noneName) {
  const legend = names.slice(0, 12).map((name, i) => ({ name, colour: kCategories[i % kCategories.length] }));
  if (names.length > 12) legend.push({ name: `${names.length - 12} more`, colour: 'transparent' });
  if (noneName) legend.push({ name: noneName, colour: kNone });
  return {
    colour(recording, frame) {
      const category = categoryAt(recording, frame);
      return (body) => {
        const value = category(body);
        return value < 0 ? none : categories[value % categories.length];
      };
    },
    legend: { swatches: legend },
  };
}

function groupColours(recordings) {
  const names = [...new Set(recordings.flatMap(({ run }) => run.groups.map(({ name }) => name)))];
  return categorical(names, (recording) => {
    const of = recording.run.groups.map(({ name }) => names.indexOf(name));
    return (body) => of[recording.group[body]];
  });
}

const shapeName = (name) => (name.startsWith('capsule') ? 'capsule' : name);
export const shapeOf = (recording, body) => shapeName(recording.meshes[recording.meshOfBody[body]].name);

function shapeColours(recordings) {
  const names = [...new Set(recordings.flatMap(({ meshes }) => meshes.map(({ name }) => shapeName(name))))];
  return categorical(names, (recording) => {
    const of = recording.meshes.map(({ name }) => names.indexOf(shapeName(name)));
    return (body) => of[recording.meshOfBody[body]];
  });
}

function massColours(recordings) {
  const masses = recordings.flatMap(({ mass }) => [...mass].filter((value) => value > 0));
  const low = masses.reduce((a, b) => Math.min(a, b)), high = masses.reduce((a, b) => Math.max(a, b));
  const scale = continuous(low, high, 'kg', (recording) => recording.mass);
  return {
    colour(recording, frame) {
      const colour = scale.colour(recording, frame);
      return (body) => (recording.mass[body] > 0 ? colour(body) : none);
    },
    legend: { ...scale.legend, note: 'grey: fixed' },
  };
}

const needs = (word) => `not recorded: add ${word} to record`;

// All modes; `why` is the reason why one is not available.
export const kColourModes = [
  { id: 'speed', name: 'speed',
    why: (recordings) => recordings.every(({ frames }) => frames < 2) && 'needs poses of more than one cycle',
    make: (recordings) => continuous(0, sampledMaximum(recordings, (r, frame) => r.speeds(frame)), 'm/s',
      (recording, frame) => recording.speeds(frame),
      { note: 'displacement between frames over time; root scale', power: 0.5 }) },
  { id: 'group', name: 'object group', why: () => false, make: groupColours },
  { id: 'shape', name: 'shape', why: () => false, make: shapeColours },
  { id: 'mass', name: 'mass',
    why: (recordings) => {
      const masses = new Set(recordings.flatMap(({ mass }) => [...mass].filter((value) => value > 0)));
      return masses.size < 2 && 'all masses are equal';
    },
    make: massColours },
  { id: 'contacts', name: 'number of contacts',
    why: (recordings) => recordings.some(({ contacts }) => !contacts) && needs('contacts'),
    make: (recordings) => continuous(0, sampledMaximum(recordings, (r, frame) => r.contactCounts(frame)),
      'contacts', (recording, frame) => recording.contactCounts(frame)) },
  { id: 'island', name: 'island',
    why: (recordings) => recordings.some(({ contacts }) => !contacts) && needs('contacts'),
    make: () => ({
      ...categorical([], (recording, frame) => {
        const islands = recording.islands(frame);
        return (body) => (islands[body] < 0 ? -1 : (islands[body] * 2654435761 >>> 16) % kCategories.length);
      }),
      legend: { swatches: [{ name: 'no contact', colour: kNone }],
        note: 'bodies that touch share a colour; seven colours in all' },
    }) },
  { id: 'rest', name: 'at rest',
    why: (recordings) => recordings.every(({ isStart }) => isStart) && 'needs poses',
    make: () => ({
      ...categorical(['moves', 'unmoved'],
        (recording, frame) => (body) => (recording.isUnmoved(frame, body) ? 1 : 0)),
      legend: { swatches: [{ name: 'moves', colour: kCategories[0] }, { name: 'unmoved', colour: kCategories[1] }],
        note: 'unmoved: the same pose as in the previous cycle, to the last bit, like a sleeping object; '
          + 'which objects sleep is not recorded' },
    }) },
];
