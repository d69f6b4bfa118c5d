// The first lines of the page: the runs shown, and notices for the viewer.
import { element } from './text.js';

const kSound = { stable: true, unknown: null };

function chip(run) {
  if (!run.is_run) return element('span', { class: 'chip' }, 'not run');
  if (run.status !== 'done') return element('span', { class: 'chip bad' }, run.status);
  if (run.verdict === 'unknown')
    return element('span', { class: 'chip' },
      `no verdict: ${run.has_configurations ? 'nothing is simulated' : 'record has no stability'}`);
  if (kSound[run.verdict] && run.unchecked)
    return element('span', { class: 'chip good', title: `not checked: ${run.unchecked}` },
      `✓ ${run.verdict}, as far as was checked`);
  const from = run.first_bad_cycle >= 0 ? ` from cycle ${run.first_bad_cycle}` : '';
  return element('span', { class: `chip ${kSound[run.verdict] ? 'good' : 'bad'}` },
    `${kSound[run.verdict] ? '✓' : '✗'} ${run.verdict}${run.criterion ? ` (${run.criterion})` : ''}${from}`);
}

function lineOf(recording, index, isOne) {
  const { run } = recording;
  const facts = [run.name, `${recording.count} ${recording.count === 1 ? 'object' : 'objects'}`, run.name.includes('detector') ? '' : `detector ${run.detector}`,
    !run.cycles ? '' : run.has_configurations ? `${run.cycles} configurations`
      : `${run.cycles} cycles of ${Number((run.timestep * 1000).toPrecision(4))} ms`];
  return element('p', { class: 'run' }, ...(isOne ? [] : [element('b', { class: `run${index}` }, `${'AB'[index]} `)]),
    chip(run), ` ${facts.filter(Boolean).join(' · ')} · ${run.file}`,
    ...(run.message ? [element('br'), element('span', { class: 'message' }, run.message)] : []));
}

export function makeHead(title, recordings) {
  const notices = new Set(recordings.flatMap(({ run }) => run.notices));
  return element('header', {}, element('h1', {}, title),
    ...recordings.map((recording, i) => lineOf(recording, i, recordings.length === 1)),
    ...[...notices].map((notice) => element('p', { class: 'notice' }, notice)));
}
