// The tab of `cdb compare --page`: figures compared with the numbers of the comparison, and hostile text.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { blemishes, folder, launch, marksOf, openTab, parseCsv, saveFile, settle, visit, writePage } from './browser.mjs';
import { first } from './fixtures.mjs';

let browser;
let tab;
before(async () => {
  browser = await launch();
  tab = await openTab(browser);
});
after(() => browser.close());

const text = (selector) => tab.$eval(selector, (element) => element.innerText);
async function clean(name) {
  assert.deepEqual(tab.faults, []);
  assert.deepEqual(await blemishes(tab), []);
  await tab.screenshot({ path: `${folder}/${name}.png`, fullPage: true });
}

const change = (phase, ratio, verdict, bound = 0.02) => ({
  phase,
  a_ns: 1000,
  b_ns: 1000 * ratio,
  ratio,
  interval: bound ? [ratio - bound, ratio + bound] : [null, null],
  verdict,
});
const group = (name, step, points = 2) => ({ name, points, phases: [change('broad', 0.9, 'faster'), step] });
const comparisonOf = (a, b, ratio, verdict) => ({
  a,
  b,
  times: {
    has_intervals: true,
    group: 'detector',
    groups: [group('sap', change('step', ratio, verdict)), group('dbvt', change('step', 1, 'cannot tell', 0))],
    points: ['sap', 'dbvt'].flatMap((detector) =>
      ['10', '20'].map((quantity) => ({
        point: { detector, quantity },
        phases: [change('step', detector === 'sap' ? ratio : 1, detector === 'sap' ? verdict : 'same')],
      })),
    ),
  },
});
const section = (title, lines = [], rows = []) => ({
  title,
  lines,
  columns: [
    { label: 'fact', is_number: false },
    { label: 'better', is_number: true },
  ],
  rows,
  notes: ['A note', '  that goes on.'],
});
const dataOf = (more, title = 'Two builds') => ({
  documents: [first(), first()],
  comparison: {
    headline: 'FAIL (exit status 4): first: slower by more than 5 %: sap step',
    fail_above: { slower: 0.05, memory: 0.05, accuracy: 0.05 },
    is_worse: true,
    other_scenes: [],
    unmatched: [],
    names: ['a.h5', 'b.h5'],
    sections: [],
    benchmarks: [
      {
        benchmark: 'first',
        title,
        files: ['a.h5', 'b.h5'],
        comparisons: [comparisonOf('a.h5', 'b.h5', 1.08, 'slower')],
        sections: [
          section('Two builds: from a.h5 to b.h5', ['The same machine']),
          section('Result', ['SLOWER: sap', '  by far', title]),
          section('Facts', [], [['peak memory', '3']]),
        ],
      },
    ],
    ...more,
  },
});

test('two files: sections, groups and points', async () => {
  await visit(tab, writePage('compare', dataOf()));
  assert.equal(await text('h1'), 'Two builds');
  assert.match(await text('.warnings'), /FAIL \(exit status 4\): first: slower by more than 5 %: sap step/);
  assert.deepEqual(await tab.$$eval('.body h2', (heads) => heads.map((head) => head.innerText)), [
    'What was compared',
    'Result',
    'Ratios of times',
    'Facts',
  ]);
  assert.match(await text('#b0-1'), /SLOWER: sap by far/);
  assert.match(await text('#b0-2'), /peak memory\s+3/);
  const [header, ...rows] = parseCsv(String(await saveFile(tab, 'b0-groups', 'CSV')));
  assert.deepEqual(
    rows.map((row) => ['phase', 'of', 'ratio', 'low', 'verdict'].map((name) => row[header.indexOf(name)])),
    [
      ['broad', 'sap', '0.9', '0.88', 'faster'],
      ['broad', 'dbvt', '0.9', '0.88', 'faster'],
      ['step', 'sap', '1.08', '1.06', 'slower'],
      ['step', 'dbvt', '1', '', 'cannot tell'],
    ],
  );
  assert.equal((await marksOf(tab, 'b0-groups')).length, 4);
  assert.equal((await marksOf(tab, 'b0-points')).length, 4);
  await clean('compare');
  assert.deepEqual(await tab.$$eval('.tabs a', (links) => links.map((link) => link.innerText)), [
    'Comparison',
    'a.h5',
    'b.h5',
  ]);
  await tab.click('.tabs a:nth-child(3)');
  await settle(tab);
  assert.equal(await text('h1'), 'A test');
  await tab.goBack();
  await settle(tab);
  await tab.click('.contents li:nth-child(4) a');
  await settle(tab);
  assert.equal(await tab.evaluate(() => location.hash), '#section=b0-2');
});

test('several files: ratios to the first one', async () => {
  const history = dataOf({ sections: [section('History', ['b.h5 is slower'])] });
  const [benchmark] = history.comparison.benchmarks;
  Object.assign(benchmark, {
    files: ['a.h5', 'b.h5', 'c.h5'],
    sections: [],
    comparisons: [comparisonOf('a.h5', 'b.h5', 1.08, 'slower'), comparisonOf('b.h5', 'c.h5', 0.5, 'faster')],
    relative_to_the_first: [comparisonOf('a.h5', 'c.h5', 0.54, 'faster')],
  });
  history.documents = [];
  await visit(tab, writePage('compare-history', history));
  const [header, ...rows] = parseCsv(String(await saveFile(tab, 'b0-history', 'CSV')));
  const ratios = rows.filter((row) => row[header.indexOf('of')] === 'sap').map((row) => row[header.indexOf('ratio')]);
  assert.deepEqual(ratios, ['1', '1.08', '0.54']);
  assert.match(await text('#all-0'), /b.h5 is slower/);
  await clean('compare-history');
});

test('folders and hostile text', async () => {
  const bad = '<img src=x onerror="alert(1)">\u202e';
  const folders = dataOf({ unmatched: [bad] }, bad);
  folders.documents = [];
  folders.comparison.benchmarks.push(structuredClone(folders.comparison.benchmarks[0]));
  await visit(tab, writePage('compare-folders', folders));
  assert.equal(await text('h1'), '2 benchmarks');
  assert.equal(await tab.$('img'), null);
  assert.match(await text('.warnings'), /not in all folders: <img/);
  await clean('compare-folders');
});

for (const scheme of ['light', 'dark'])
  test(`a narrow page, ${scheme}`, async () => {
    const narrow = await openTab(browser, { width: 700, scheme });
    await visit(narrow, writePage('compare', dataOf()));
    assert.deepEqual(narrow.faults, []);
    assert.deepEqual(await blemishes(narrow), []);
    await narrow.screenshot({ path: `${folder}/compare-700-${scheme}.png`, fullPage: true });
    await narrow.close();
  });
