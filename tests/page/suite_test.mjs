// The tab of the standard suite, on the page of `cdb suite`.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { blemishes, folder, launch, openTab, settle, visit, writePage } from './browser.mjs';
import { first } from './fixtures.mjs';

let browser;
let tab;
before(async () => {
  browser = await launch();
  tab = await openTab(browser);
});
after(() => browser.close());

const text = (selector) => tab.$eval(selector, (element) => element.innerText);
const hash = () => tab.evaluate(() => location.hash);
async function clean(name) {
  assert.deepEqual(tab.faults, []);
  assert.deepEqual(await blemishes(tab), []);
  await tab.screenshot({ path: `${folder}/${name}.png`, fullPage: true });
}

/** As written by `cdb suite`: two detectors in one scene; sap32 is wrong. @param {string} [what] */
const suiteOf = (what = 'debris') => {
  const configuration = (name, more) => ({
    name,
    fault: null,
    speedup: 1,
    disturbed: null,
    interval: [1, 1],
    ms_per_s: 60,
    step_ns: 1e6,
    slow_step_ns: 2e6,
    time_step: 1 / 60,
    error: 0,
    verdict: 'stable',
    memory: 2e7,
    repeats: 5,
    noisy: 0,
    bullets_own: true,
    on_front: false,
    fits: [true, true, false],
    ...more,
  });
  const fault = 'tunnelled from cycle 12';
  const none = { speedup: null, interval: null, fits: [false, false, false] };
  return {
    suite: 1,
    variant: 'short',
    seed: null,
    missing: ['games/rubble'],
    machine: { cpu: 'a processor', host: 'a host' },
    build: { cdb: '0.1.0' },
    defaults: 'In none of 1 scenes.',
    budgets: ['1/30 s', '1/60 s', '1 ms'],
    kinds: [
      {
        kind: 'games',
        what: 'many objects',
        baseline: 'dbvt',
        scenes: ['debris'],
        scores: [
          { name: 'auto', score: 2, interval: [1.9, 2.1], memory: 2e7, faults: [] },
          { name: 'dbvt', score: 1, interval: [1, 1], memory: 2e7, faults: [] },
          { name: 'sap32', score: null, interval: [null, null], memory: 2e7, faults: [`debris: ${fault}`] },
        ],
      },
    ],
    scenes: [
      {
        kind: 'games',
        name: 'debris',
        what,
        file: 'standard_debris.h5',
        sha256: 'a'.repeat(64),
        plan_sha256: 'b'.repeat(64),
        host: 'a host',
        error: { name: 'pairs_missed', bound: 0, doc: 'pairs that are not found' },
        answer: 'auto: 500 us a step.',
        picks: [['auto'], ['auto'], []],
        picks_of_bullet: [['dbvt'], ['dbvt'], []],
        configurations: [
          configuration('dbvt'),
          configuration('auto', { speedup: 2, interval: [1.9, 2.1], bullets_own: false }),
          configuration('sap32', { ...none, fault, verdict: 'tunnelled' }),
          configuration('grid', { ...none, fault: 'noisy in 5 of 5 runs', disturbed: 1.5, noisy: 5 }),
        ],
      },
    ],
  };
};

test('the suite has the first tab, and its scenes the others', async () => {
  await visit(tab, writePage('suite', { suite: suiteOf(), documents: [first()] }));
  assert.equal((await tab.$$('.tabs a')).length, 2);
  assert.match(await text('#take'), /dbvt 1.00×/);
  assert.match(await text('#take'), /auto 2.00×/);
  assert.match(await text('#take'), /none/); // within 1 ms
  assert.match(await text('.warnings'), /without games\/rubble/);
  const scores = await tab.$$eval('#scores tbody tr', (rows) => rows.map((row) => row.innerText));
  assert.match(scores[0], /auto\s+2.00\s+1.90 .. 2.10/);
  assert.match(scores[2], /sap32\s+none\s.*debris: tunnelled from cycle 12/s);
  assert.match(await text('#scenes'), /\(1.50\)/); // disturbed
  assert.match(await text('#scenes'), /1\/60 s/);
  await clean('suite');
  await tab.click('#take a');
  await settle(tab);
  assert.equal(await text('h1'), 'A test');
  assert.equal(await hash(), '#doc=0');
  await tab.goBack();
  await settle(tab);
  assert.match(await text('h1'), /Which detector/);
  await tab.click('.contents li:nth-child(2) a');
  await settle(tab);
  assert.equal(await hash(), '#section=scores');
  await visit(tab, writePage('suite-hostile', { suite: suiteOf('<b onclick="x()">\u202e'), documents: [first()] }));
  assert.equal(await tab.$('#take b'), null);
  await clean('suite-hostile');
});

/** As written by `cdb suite --page`: two machines that disagree, one that is not sound, and an older version. */
const placeOf = (name = 'intel-xeon-cdb-0.1.0-1f2e3d4c5b6a') => {
  const entry = (of, cpu, more = {}) => ({
    name: of,
    faults: [],
    signature: { state: 'none', text: 'not signed' },
    variant: 'short',
    seed: null,
    measured: '2026-11-28',
    machine: { cpu, host: 'a host', cores: '8', system: 'Debian' },
    build: { cdb: '0.1.0', commit: 'c0ffeec0ffee', compiler: 'GNU 12.2.0' },
    scores: [
      { kind: 'games', name: 'auto', score: 2, interval: [1.9, 2.1], faults: [] },
      { kind: 'games', name: 'sap32', score: null, interval: null, faults: ['debris: tunnelled'] },
    ],
    verified: [],
    ...more,
  });
  const by = (other, outcome, reasons = []) => ({ by: other, outcome, scenes: 16, same_states: 4, reasons });
  const other = 'amd-epyc-cdb-0.1.0-99aabbccdd00';
  const key = `SHA256:${'k'.repeat(43)}`;
  return {
    suite: 3,
    kinds: [{ kind: 'games', what: 'many objects' }],
    left_out: [{ folder: 'scripts', why: 'it has no results of the suite' }],
    versions: [
      {
        version: 3,
        is_checked: true,
        entries: [
          entry(other, 'AMD EPYC 7B13', {
            signature: { state: 'good', text: `signed by ann@example.org, key ${key}` },
            verified: [by(name, 'disagrees', ['games/debris: auto: speedup 1.90, here 1.10'])],
          }),
          entry(name, 'Intel(R) Xeon(R) CPU @ 2.1GHz', {
            signature: { state: 'stranger', text: `signed by key ${key}, which is not in allowed_signers` },
            verified: [by(other, 'agrees')],
          }),
          entry('spoilt', 'another', { faults: ['suite.json: it is not the summary of these results'] }),
        ],
      },
      { version: 2, is_checked: false, entries: [entry('old-cdb-0.1.0-123412341234', 'Old', { scores: [] })] },
    ],
  };
};

test('a place has the scores of each machine, and says which results are not sound', async () => {
  const name = 'intel-xeon-cdb-0.1.0-1f2e3d4c5b6a';
  await visit(tab, writePage('place', { place: placeOf(name) }));
  assert.equal(await text('h1'), 'Results of 3 machines');
  assert.match(await text('.warnings'), /1 folder of 4 not sound/);
  assert.match(await text('.warnings'), /1 result contradicted/);
  const section = await text('#version-3');
  for (const part of [/Intel Xeon/, /ann@example.org/, /unknown key/, /1 of 1 disagree/, /equal states: 4 of 16 scenes/])
    assert.match(section, part);
  assert.match(section, /AMD EPYC 7B13 is contradicted by Intel Xeon\s+games\/debris: auto: speedup 1.90, here 1.10/);
  assert.match(section, /spoilt.*\s+suite.json: it is not the summary/);
  assert.match(section, /2.00 1.90 .. 2.10/);
  assert.match(section, /debris: tunnelled/);
  assert.match(await text('#version-2'), /Figures as they were published/);
  assert.match(await text('#how'), /scripts: it has no results of the suite/);
  assert.equal(await tab.$eval('#version-3 a', (link) => link.getAttribute('href')), 'amd-epyc-cdb-0.1.0-99aabbccdd00/suite.json');
  await clean('place');
  await visit(tab, writePage('place-hostile', { place: placeOf('<b onclick="x()">\u202e') }));
  assert.equal(await tab.$('#version-3 b'), null);
  await clean('place-hostile');
});
