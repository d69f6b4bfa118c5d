// The page of `cdb suite --page`: the published results of many machines, and whether they are sound.
import { bdi, h, table } from '../dom.js';
import { plural, short } from '../format.js';

const ratio = (value) => (value === null ? '' : value.toFixed(2));
const muted = (text) => h('span', { class: 'muted' }, bdi(text));

const isSound = (entry) => entry.faults.length === 0;

/** `AMD EPYC 7B13`, without what all names have. */
const processor = (entry) =>
  short((entry.machine.cpu ?? 'unknown processor').replace(/\((R|TM)\)| CPU| Processor|@.*$/gi, ' ').replace(/\s+/g, ' ').trim(), 40);

/** Entries by their processors; those of one processor have their hosts, too, and then their digests. */
function labelsOf(entries) {
  const names = entries.map(processor);
  const add = (detail) => {
    const count = (name) => names.filter((other) => other === name).length;
    const isShared = names.map((name) => count(name) > 1);
    entries.forEach((entry, i) => {
      if (isShared[i]) names[i] = `${names[i]}, ${detail(entry)}`;
    });
  };
  add((entry) => short(entry.machine.host ?? '', 20));
  add((entry) => entry.name.slice(-12));
  return new Map(entries.map((entry, i) => [entry, names[i]]));
}

const variantOf = (entry) => (entry.seed === null ? (entry.variant ?? '') : `seed ${entry.seed}`);

const state = (kind, text) => h('span', { class: kind }, h('span', { class: 'certainty' }, text));

function signatureOf(entry) {
  const [, who, key] = entry.signature.text.match(/^signed by (?:(.*), )?key (SHA256:[\w+/]+)/) ?? [];
  if (entry.signature.state === 'none') return muted('nobody');
  if (entry.signature.state === 'unchecked') return muted('not checked');
  if (entry.signature.state === 'bad') return state('fault', 'does not match');
  const text = h('code', { title: key }, short(key.slice(7), 13));
  if (entry.signature.state === 'stranger') return h('span', {}, state('tie', 'unknown key'), ' ', text);
  return h('span', {}, who ? h('span', {}, bdi(who), ' ') : null, text);
}

function verifiedOf(entry) {
  if (entry.verified.length === 0) return muted('no other results');
  const count = (outcome) => entry.verified.filter((of) => of.outcome === outcome).length;
  const [agrees, partly, disagrees] = ['agrees', 'partly', 'disagrees'].map(count);
  const of = `of ${entry.verified.length}`;
  const parts = [
    agrees > 0 && state('clear', `${agrees} ${of} agree`),
    partly > 0 && state('tie', `${partly} ${of} agree in part`),
    disagrees > 0 && state('fault', `${disagrees} ${of} disagree`),
    agrees + partly + disagrees < entry.verified.length && muted('not compared with some'),
  ].filter(Boolean);
  const all = entry.verified.reduce((sum, other) => sum + other.scenes, 0);
  const equal = entry.verified.reduce((sum, other) => sum + other.same_states, 0);
  const states = all > 0 && muted(`equal states: ${equal} of ${plural(all, 'scene')}`);
  return h('span', {}, ...parts.flatMap((part) => [part, ' ']), h('br'), states);
}

function entriesTable(version, labels) {
  const { is_checked: isChecked } = version;
  const about = ({ machine, build }) =>
    [machine.cores && `${machine.cores} cores`, machine.system, build.compiler].filter(Boolean).join(', ');
  return table(
    [
      { label: 'machine' },
      { label: 'results' },
      { label: 'cdb' },
      { label: 'signed by' },
      ...(isChecked ? [{ label: 'verified by the others' }] : []),
    ],
    version.entries.filter(isSound).map((entry) => [
      h('span', {}, h('strong', {}, bdi(labels.get(entry))), h('br'), h('span', { class: 'muted about' }, short(about(entry), 100))),
      h('span', { class: 'whole' },
        h('a', { href: `${encodeURIComponent(entry.name)}/suite.json` }, bdi(entry.name.slice(-12))),
        h('br'), muted([entry.measured, variantOf(entry)].filter(Boolean).join(', '))),
      h('span', { class: 'whole' }, bdi(entry.build.cdb ?? ''), h('br'), h('code', {}, bdi((entry.build.commit ?? '').slice(0, 9)))),
      signatureOf(entry),
      ...(isChecked ? [verifiedOf(entry)] : []),
    ]),
    `Results of version ${version.version}`,
  );
}

/** A score, its interval and a bar. @param {any} score @param {number} most @param {boolean} isBest */
function scoreCell(score, most, isBest) {
  if (!score) return muted('–');
  if (score.score === null)
    return h('span', { class: 'muted', title: score.faults.join('; ') }, short(score.faults[0] ?? 'none', 40));
  // Not of the column, so that bars of all columns are comparable.
  const width = `width: ${((6 * score.score) / most).toFixed(2)}rem`;
  const value = ratio(score.score);
  return h(
    'span',
    { class: 'score' },
    isBest ? h('strong', {}, value) : h('span', {}, value),
    score.interval ? muted(` ${ratio(score.interval[0])} .. ${ratio(score.interval[1])}`) : null,
    h('span', { class: 'bar', 'aria-hidden': 'true', style: width }),
  );
}

function kindTables(place, version, labels) {
  const entries = version.entries.filter(isSound);
  return place.kinds.flatMap(({ kind, what }) => {
    const scoresOf = (entry) => entry.scores.filter((score) => score.kind === kind);
    const names = [...new Set(entries.flatMap((entry) => scoresOf(entry).map((score) => score.name)))];
    if (names.length === 0) return [];
    // As the first entry ranks them, which is an order that readers can follow over the machines.
    const most = Math.max(1, ...entries.flatMap((entry) => scoresOf(entry).map((score) => score.score ?? 0)));
    return [
      h('h3', { id: `version-${version.version}-${kind}` }, bdi(kind), muted(`: ${short(what, 200)}`)),
      table(
        [{ label: 'machine' }, ...names.map((name) => ({ label: short(name, 40) }))],
        entries.map((entry) => {
          const best = Math.max(...scoresOf(entry).map((score) => score.score ?? 0));
          return [
            labels.get(entry),
            ...names.map((name) => {
              const score = scoresOf(entry).find((of) => of.name === name);
              return scoreCell(score, most, score?.score === best);
            }),
          ];
        }),
        `Scores: ${kind}`,
      ),
    ];
  });
}

function disagreements(version, labels) {
  const nameOf = (name) => labels.get(version.entries.find((entry) => entry.name === name)) ?? name;
  const items = version.entries.flatMap((entry) =>
    entry.verified
      .filter((of) => of.reasons.length > 0)
      .map((of) =>
        h(
          'li',
          {},
          h('strong', {}, bdi(labels.get(entry))),
          of.outcome === 'disagrees' ? ' is contradicted by ' : ' was not compared in full with ',
          h('strong', {}, bdi(nameOf(of.by))),
          h('ul', { class: 'places' }, ...of.reasons.slice(0, 8).map((reason) => h('li', {}, bdi(reason)))),
          of.reasons.length > 8 ? muted(`and ${of.reasons.length - 8} more: cdb suite --against`) : null,
        ),
      ),
  );
  if (items.length === 0) return [];
  return [h('h3', {}, 'Disagreements'), h('ul', { class: 'findings' }, ...items)];
}

function unsound(version) {
  const entries = version.entries.filter((entry) => !isSound(entry));
  if (entries.length === 0) return [];
  return [
    h('h3', {}, 'Not sound: no figures are shown'),
    h(
      'ul',
      { class: 'findings' },
      ...entries.map((entry) =>
        h(
          'li',
          {},
          h('strong', {}, bdi(entry.name)),
          muted(entry.signature.text ? ` (${entry.signature.text})` : ''),
          h('ul', { class: 'places' }, ...entry.faults.slice(0, 8).map((fault) => h('li', {}, bdi(fault)))),
          entry.faults.length > 8 ? muted(`and ${entry.faults.length - 8} more: cdb suite --check`) : null,
        ),
      ),
    ),
  ];
}

function note(place, version) {
  if (version.version === null) return [];
  if (version.is_checked)
    return [
      h('p', { class: 'note' },
        'A score is the speed of a configuration relative to the baseline on the same machine, with its 95 % interval: 2 is ',
        'twice as fast. The best of a machine is bold. All figures were computed from the results files when this page was ',
        'written, and each file is as the digest of its folder says. Equal states: scenes in which all runs ended in the ',
        'same state as on another machine, to the last bit.'),
    ];
  return [
    h('p', { class: 'note' },
      `Figures as they were published, with files as their digests say. The cdb that wrote this page has version ${place.suite} `,
      'of the suite and cannot compute those of another version; scenes and settings differ, so that no figure is comparable ',
      'with one of another version.'),
  ];
}

function versionSection(place, version) {
  const sound = version.entries.filter(isSound);
  const labels = labelsOf(version.entries);
  const title = version.version === null ? 'Of no known version' : `Version ${version.version} of the suite`;
  return [
    `version-${version.version ?? 'unknown'}`,
    title,
    [
      ...note(place, version),
      ...(sound.length > 0 ? [entriesTable(version, labels)] : []),
      ...disagreements(version, labels),
      ...unsound(version),
      ...kindTables(place, version, labels),
    ],
  ];
}

function howTo(place) {
  const line = (command, text) => h('li', {}, h('code', {}, command), ` ${text}`);
  const leftOut = place.left_out.map((of) => h('li', {}, bdi(of.folder), muted(`: ${of.why}`)));
  return [
    h(
      'ul',
      { class: 'findings' },
      line('cdb suite --check FOLDER', 'checks one of these folders on your machine.'),
      line('cdb suite --against FOLDER -o mine', 'verifies it by your own results.'),
      line('cdb suite -o mine --publish PLACE', 'adds yours, and writes this page again.'),
      line('sha256sum -c digest.txt', 'in a folder checks its files without cdb.'),
    ),
    ...(leftOut.length ? [h('h3', {}, 'Folders that were left out'), h('ul', { class: 'findings' }, ...leftOut)] : []),
  ];
}

/** @param {any} place  of the data of the page */
export function placeParts(place) {
  const entries = place.versions.flatMap((version) => version.entries);
  const sound = entries.filter(isSound);
  const machines = new Set(sound.map((entry) => `${entry.machine.cpu}\n${entry.machine.host}`)).size;
  const bad = entries.length - sound.length;
  const contested = sound.filter((entry) => entry.verified.some((of) => of.outcome === 'disagrees')).length;
  const warnings = [
    bad > 0 && `${plural(bad, 'folder')} of ${entries.length} not sound: no figures of ${bad === 1 ? 'it' : 'them'} are shown.`,
    contested > 0 && `${plural(contested, 'result')} contradicted by others: see the disagreements.`,
  ].filter(Boolean);
  return {
    head: [
      h(
        'header',
        {},
        h('p', { class: 'kind' }, 'Standard suite of cdb'),
        h('h1', {}, `Results of ${plural(machines, 'machine')}`),
        h('p', { class: 'sweep' }, 'Which collision detector of Bullet and which settings are best, in each kind of application.'),
      ),
      warnings.length ? h('ul', { class: 'warnings' }, ...warnings.map((text) => h('li', { class: 'warning' }, text))) : null,
    ],
    sections: [...place.versions.map((version) => versionSection(place, version)), ['how', 'Check and add results', howTo(place)]],
  };
}
