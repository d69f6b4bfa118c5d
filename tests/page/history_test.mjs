// The page of `cdb history`: figures compared with the values of the series, and hostile text.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { blemishes, folder, launch, marksOf, openTab, parseCsv, saveFile, visit, writePage } from './browser.mjs';

let browser;
let tab;
before(async () => {
  browser = await launch();
  tab = await openTab(browser);
});
after(() => browser.close());

const count = 20;
const text = (selector) => tab.$eval(selector, (element) => element.innerText);
const files = (name) =>
  Array.from({ length: count }, (_, i) => ({ label: `${name}${i}`, file: `f-${i}.h5`, day: `2026-01-${10 + i}`, subject: `Change ${i}` }));
const step = (ratio) => ({ kind: 'step', from: 11, to: 12, ratio, interval: [ratio - 0.01, ratio + 0.01] });
const series = (figure, point, valueOf, changes = []) => ({
  figure,
  point,
  values: Array.from({ length: count }, (_, i) => valueOf(i)),
  changes,
});
const historyOf = (name, machine) => ({
  benchmark: 'crowd',
  title: name,
  machine,
  is_worse: true,
  files: files(name),
  motions: [{ from: `${name}4`, to: `${name}5`, states: [''], counts: [] }],
  series: [
    series('detect', 'detector sap', () => 4e5),
    series('step', 'detector sap', (i) => (i === 3 ? null : i < 12 ? 1e6 : 1.1e6), [step(1.1)]),
    series('peak_rss', 'detector sap', (i) => 1e7 * (1 + i / 50), [{ ...step(1.4), kind: 'drift', from: 0, to: 19 }]),
    series('step_instructions', '', () => 5e6),
  ],
  section: { title: name, lines: ['SLOWER between a and b', '  at 1 of 2 points'], columns: [], rows: [], notes: [] },
});
const pageOf = (...histories) => ({
  history: { folder: 'history', histories, section: { title: 'history', lines: ['20 results files'], columns: [], rows: [], notes: [] } },
});
async function clean(name) {
  assert.deepEqual(tab.faults, []);
  assert.deepEqual(await blemishes(tab), []);
  await tab.screenshot({ path: `${folder}/${name}.png`, fullPage: true });
}

test('series that changed, and the others', async () => {
  await visit(tab, writePage('history', pageOf(historyOf('A crowd', 'a processor'))));
  assert.equal(await text('h1'), 'history');
  assert.match(await text('.warnings'), /Worse than allowed: A crowd/);
  assert.match(await text('#h0'), /SLOWER between a and b at 1 of 2 points/);
  assert.equal((await marksOf(tab, 'h0-changed')).length, 2 * count - 1);
  assert.equal((await marksOf(tab, 'h0-others')).length, 2 * count);
  const [header, ...rows] = parseCsv(String(await saveFile(tab, 'h0-changed', 'CSV')));
  assert.deepEqual(header, ['of', 'point', 'file', 'measured', 'commit', 'value (ns, bytes or instructions)']);
  // The largest change is the first.
  assert.deepEqual(rows[0], ['peak memory', 'detector sap', 'A crowd0', '2026-01-10', 'Change 0', '10000000']);
  assert.equal(rows.filter((row) => row[0] === 'step').length, count - 1);
  // A higher value is a higher mark.
  const marks = await marksOf(tab, 'h0-changed');
  const yOf = (row) => marks.find((mark) => mark.row === row).y;
  assert.ok(yOf(count) > yOf(rows.length - 1));
  await clean('history');
});

test('machine by machine, with hostile text', async () => {
  const hostile = '<img src=x onerror=alert(1)>\u202e{"';
  await visit(tab, writePage('history-hostile', pageOf(historyOf(hostile, 'one'), historyOf('b', hostile))));
  assert.deepEqual(await tab.$$eval('.body h2', (heads) => heads.length), 3);
  assert.equal(await tab.$$eval('img', (images) => images.length), 0);
  assert.match(await text('.sweep'), /40 files of 1 benchmark on 2 machines/);
  await clean('history-hostile');
});
