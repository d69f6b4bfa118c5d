// The races of a scenario: how each configuration did.
import { valueText } from './document.js';
import { bdi, h, table } from './dom.js';
import { count, short } from './format.js';

const mostRows = 400;

/** @returns {boolean} */
export const hasRaces = (doc) => (doc.raw.races?.races ?? []).length > 0;

/** `Race of detector by mean(step)`. */
export const racesTitle = (doc) => `Race of ${short(doc.raw.races.axes.join(', '), 60)} by ${doc.raw.races.by}`;

/** A row for each configuration of each race, the fastest first, and what to know of them. */
export function raceTable(doc) {
  const { axes, others, races, notes } = doc.raw.races;
  const columns = [...others, ...axes];
  const indices = columns.map((name) => doc.axes.findIndex((axis) => axis.name === name));
  const rows = races.flatMap((race) =>
    race.racers.map((racer) => [
      ...indices.map((a) => bdi(valueText(doc.axes[a], racer.at[a]))),
      racer.outcome === 'won' ? h('strong', {}, racer.text) : bdi(racer.text),
      count(racer.repeats),
      racer.ratio_text || null,
    ]),
  );
  return [
    table(
      [...columns.map((label) => ({ label })), { label: 'outcome' }, { label: 'repeats', isNumber: true }, { label: 'ratio' }],
      rows.slice(0, mostRows),
      'Races',
    ),
    ...(rows.length > mostRows
      ? [h('p', { class: 'note' }, `The first ${count(mostRows)} of ${count(rows.length)} configurations; cdb show has all.`)]
      : []),
    ...notes.map((text) => h('p', { class: 'note' }, text)),
  ];
}
