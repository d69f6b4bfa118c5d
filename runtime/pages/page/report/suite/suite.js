// The tab of the standard suite: recommendations, the scores of each kind, and each scene.
import { bdi, h, table } from '../dom.js';
import { byteUnit, number, plural, short, timeUnit } from '../format.js';

/** @param {number | null} ns */
function time(ns) {
  if (ns === null) return null;
  const { unit, factor } = timeUnit(ns);
  return `${number(ns / factor)} ${unit}`;
}

function memory(bytes) {
  if (bytes === null) return null;
  const { unit, factor } = byteUnit(bytes);
  return `${number(bytes / factor)} ${unit}`;
}

/** Two digits after the point, for ratios near 1. */
const ratio = (value) => (value === null ? null : value.toFixed(2));

/** `1.18× as fast`, or of a choice that is slower because it is more accurate `3.80× slower`. */
const speed = (value) => (value === null ? '' : value >= 1 ? `${ratio(value)}× as fast` : `${ratio(1 / value)}× slower`);

const ratioRange = ([low, high]) => (low === null ? '' : `${ratio(low)} .. ${ratio(high)}`);

const strong = (text) => h('strong', {}, bdi(text));

/** A ratio and a bar of proportional length. @param {number | null} value @param {number} most */
function bar(value, most) {
  if (value === null) return null;
  const length = (100 * value) / most;
  return h(
    'span',
    { class: 'ratio' },
    h('span', { class: 'bar', 'aria-hidden': 'true', style: `width: ${length.toFixed(1)}%` }),
    h('span', {}, ratio(value)),
  );
}

/** The recommendation for each scene: among Bullet's configurations, and within each time budget. */
function recommendations(suite, linkOf) {
  const pick = (scene, names) => {
    if (names.length === 0) return h('span', { class: 'muted' }, 'none');
    const best = scene.configurations.find((of) => of.name === names[0]);
    const others = names.length > 1 ? ` or ${short(names.slice(1).join(', '), 60)}` : '';
    return h('span', {}, strong(names[0]), h('span', { class: 'muted' }, ` ${speed(best.speedup)}${others}`));
  };
  const rows = suite.scenes.map((scene, i) => [
    h('a', { href: linkOf(i) }, bdi(scene.what)),
    pick(scene, scene.picks_of_bullet[0]),
    ...suite.budgets.map((_, b) => pick(scene, scene.picks[b])),
  ]);
  return [
    h('p', {}, bdi(suite.defaults)),
    table(
      [
        { label: 'scene' },
        { label: `Bullet's best in ${suite.budgets[0]}` },
        ...suite.budgets.map((name) => ({ label: `best of all in ${name}` })),
      ],
      rows,
      'Which one to use',
    ),
    h(
      'p',
      { class: 'note' },
      'Of the configurations that are correct and whose slow steps (the 99th percentile) fit the time: the most ',
      'accurate, and of equally accurate ones the fastest; so one that is slower is more accurate. Speeds are relative to ',
      'the baseline, which is dbvt, or Bullet with its own settings. Configurations after “or” tie with it: the 95 % intervals of the ratios of their ',
      'times include 1. Each scene links to its report.',
    ),
  ];
}

function scoreTable(kind, scenes) {
  const most = Math.max(1, ...kind.scores.map((score) => score.score ?? 0));
  const of = (scene, name) => scene.configurations.find((each) => each.name === name);
  const inScene = (scene, name) => {
    const found = of(scene, name);
    if (!found) return null;
    if (found.speedup !== null) return ratio(found.speedup);
    return found.disturbed !== null ? h('span', { class: 'muted' }, `(${ratio(found.disturbed)})`) : null;
  };
  const hasFaults = kind.scores.some((score) => score.faults.length);
  return table(
    [
      { label: 'configuration' },
      { label: 'score' },
      { label: '95 % interval', isNumber: true },
      { label: 'memory', isNumber: true },
      ...scenes.map((scene) => ({ label: scene.name.replace(/_/g, ' '), isNumber: true })),
      ...(hasFaults ? [{ label: 'why it has no score' }] : []),
    ],
    kind.scores.map((score) => [
      score.name,
      score.score === null ? h('span', { class: 'muted' }, 'none') : bar(score.score, most),
      ratioRange(score.interval),
      memory(score.memory),
      ...scenes.map((scene) => inScene(scene, score.name)),
      ...(hasFaults ? [score.faults.join('; ')] : []),
    ]),
    `Scores: ${kind.kind}`,
  );
}

const isDisturbed = (suite, kind) =>
  suite.scenes.some((scene) => scene.kind === kind && scene.configurations.some((of) => of.disturbed !== null));

function kinds(suite) {
  return suite.kinds.flatMap((kind) => [
    h('h3', { id: `kind-${kind.kind}` }, bdi(kind.kind), h('span', { class: 'muted' }, `: ${short(kind.what, 200)}`)),
    scoreTable(
      kind,
      suite.scenes.filter((scene) => scene.kind === kind.kind),
    ),
    h(
      'p',
      { class: 'note' },
      `Speed relative to ${short(kind.baseline)}: 2 is twice as fast.`,
      isDisturbed(suite, kind.kind) ? ' In brackets: disturbed runs.' : null,
    ),
  ]);
}

function sceneTable(suite, scene) {
  const fits = (of) => h('span', { class: 'whole' }, suite.budgets[of.fits.lastIndexOf(true)] ?? '');
  return table(
    [
      { label: 'configuration' },
      { label: 'speedup', isNumber: true },
      { label: '95 % interval', isNumber: true },
      { label: 'step', isNumber: true },
      { label: 'slow step', isNumber: true },
      { label: 'fits in' },
      { label: scene.error.name.replace(/_/g, ' '), isNumber: true },
      { label: 'front' },
      { label: 'memory', isNumber: true },
      { label: 'noisy runs', isNumber: true },
      { label: 'verdict, or why it has no score' },
    ],
    scene.configurations.map((of) => [
      of.name,
      of.speedup === null ? (of.disturbed === null ? null : `(${ratio(of.disturbed)})`) : ratio(of.speedup),
      of.interval ? ratioRange(of.interval) : '',
      time(of.step_ns),
      time(of.slow_step_ns),
      fits(of),
      number(of.error),
      of.on_front ? 'on it' : '',
      memory(of.memory),
      `${of.noisy} of ${of.repeats}`,
      of.fault ?? of.verdict,
    ]),
    scene.what,
  );
}

function scenes(suite, linkOf) {
  return suite.scenes.flatMap((scene, i) => [
    h('h3', { id: `scene-${scene.name}` }, h('a', { href: linkOf(i) }, bdi(scene.what))),
    h('p', {}, bdi(scene.answer)),
    sceneTable(suite, scene),
    h(
      'p',
      { class: 'note' },
      `Wrong beyond ${number(scene.error.bound)}: ${short(scene.error.doc, 200)}. `,
      h('code', {}, bdi(`cdb run standard/${scene.kind}/${scene.name}`)),
    ),
  ]);
}

/** @param {Record<string, string>} object */
function facts(object) {
  const entries = Object.entries(object ?? {});
  return h(
    'dl',
    { class: 'facts' },
    ...entries.flatMap(([key, value]) => [h('dt', {}, short(key)), h('dd', {}, bdi(value))]),
  );
}

function submission(suite) {
  const noisy = suite.scenes.flatMap((scene) => scene.configurations).reduce((sum, of) => sum + of.noisy, 0);
  const all = suite.scenes.flatMap((scene) => scene.configurations).reduce((sum, of) => sum + of.repeats, 0);
  return [
    h('p', {}, `${noisy} of ${plural(all, 'run')} noisy.`),
    h('div', { class: 'columns' }, h('div', {}, h('h3', {}, 'Machine'), facts(suite.machine)),
      h('div', {}, h('h3', {}, 'Build'), facts(suite.build))),
    table(
      [{ label: 'scene' }, { label: 'SHA-256 of the plan' }, { label: 'SHA-256 of the results' }],
      suite.scenes.map((scene) => [
        scene.name,
        h('code', {}, bdi(scene.plan_sha256)),
        h('code', {}, bdi(scene.sha256)),
      ]),
      'Digests',
    ),
    h('p', { class: 'note' }, 'cdb suite --check FOLDER says whether results are complete and comparable; ',
      'cdb suite --against FOLDER verifies those of another machine. See cdb doc suite.'),
  ];
}

function head(suite) {
  const variant = suite.seed === null ? suite.variant : `seed ${suite.seed}`;
  const scenes = plural(suite.scenes.length, 'scene');
  return h(
    'header',
    {},
    h('p', { class: 'kind' }, `Standard suite ${suite.suite} · ${variant}`),
    h('h1', {}, 'Which detector, and which settings?'),
    h('p', { class: 'sweep' }, `${scenes} of ${plural(suite.kinds.length, 'kind')} of application, on `,
      bdi(short(suite.machine?.cpu ?? 'an unknown processor', 80))),
  );
}

/** @param {any} suite  of the data of the page @param {(scene: number) => string} linkOf  the tab of a scene */
export function suiteParts(suite, linkOf) {
  const missing = `Not a complete suite: without ${suite.missing.join(', ')}.`;
  const warnings = suite.missing.length
    ? h('ul', { class: 'warnings' }, h('li', { class: 'warning' }, bdi(missing)))
    : null;
  return {
    head: [head(suite), warnings],
    sections: [
      ['take', 'Which one to use', recommendations(suite, linkOf)],
      ['scores', 'Scores', kinds(suite)],
      ['scenes', 'Scenes', scenes(suite, linkOf)],
      ['submission', 'What ran, and where', submission(suite)],
    ],
  };
}
