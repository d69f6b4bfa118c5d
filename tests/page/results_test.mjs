// Pages that `cdb report` writes for real results: compares the figures with `cdb show --json` and the document in the page.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { mkdirSync, readdirSync, readFileSync, rmSync, statSync, writeFileSync } from 'node:fs';
import { resolve } from 'node:path';
import { after, before, test } from 'node:test';
import { blemishes, folder, launch, marksOf, openTab, parseCsv, saveFile, settle, visit } from './browser.mjs';

const work = resolve('results');
const { CDB, EXAMPLES } = process.env;
/** Status 3: complete, but a run failed. */
function cdb(...args) {
  const { status, stdout, stderr } = spawnSync(CDB, args, { cwd: work, encoding: 'utf8', maxBuffer: 1 << 28 });
  assert.ok([0, 3].includes(status), `cdb ${args.join(' ')}: ${stderr}`);
  return stdout;
}

let browser;
let tab;
before(async () => {
  rmSync(work, { recursive: true, force: true });
  mkdirSync(work);
  browser = await launch();
  tab = await openTab(browser);
});
after(() => browser.close());

/** An example with other settings, run and reported. @returns {Promise<any>} the document in the page */
async function report(name, example, benchmark, settings) {
  writeFileSync(
    `${work}/${name}.cdb`,
    `use "${EXAMPLES}/${example}.cdb"\n\nbenchmark ${name} from ${benchmark} {\n${settings}\n}\n`,
  );
  cdb('run', '-q', '-b', name, `${name}.cdb`, '-o', `${name}.h5`);
  cdb('report', `${name}.h5`, '-o', `${name}.html`);
  assert.ok(statSync(`${work}/${name}.html`).size < 5e6);
  await visit(tab, `${work}/${name}.html`);
  const { documents } = await tab.evaluate(() => JSON.parse(document.getElementById('data').textContent));
  return documents[0];
}

async function clean(name) {
  assert.deepEqual(tab.faults, []);
  assert.deepEqual(await blemishes(tab), []);
  await tab.screenshot({ path: `${folder}/result-${name}.png`, fullPage: true });
}

/** Each value of a figure's CSV is that of the document, in ns. */
async function compareTimes(document, axes) {
  const [header, ...rows] = parseCsv(String(await saveFile(tab, 'times', 'CSV')));
  const column = header.findIndex((label) => label.startsWith('time of step'));
  const factor = { ns: 1, µs: 1e3, ms: 1e6, s: 1e9 }[header[column].split(', ')[1]];
  let compared = 0;
  for (const row of rows) {
    const wanted = document.points.at.findIndex((place) =>
      axes.every(({ name, values }, a) => {
        const given = row[header.indexOf(name)];
        return given === undefined || String(values[place[a]]) === given;
      }),
    );
    const time = document.points.times.step.mean[wanted];
    assert.ok(Math.abs((Number(row[column]) * factor) / time - 1) < 1e-9, `${row}: ${time}`);
    ++compared;
  }
  assert.equal((await marksOf(tab, 'times')).length, compared);
  return compared;
}

test('a sweep of detectors', async () => {
  const document = await report(
    'rain',
    'first',
    'first',
    '  cycles 20\n  repeats 2\n  objects { quantity sweep(20, 40) }',
  );
  assert.equal(await compareTimes(document, document.axes), 8);
  assert.match(
    await tab.$eval('.sweep', (element) => element.textContent),
    /16 runs: 4 values of detector × 2 of quantity × 2 repeats, 20 cycles each/,
  );
  const shown = await tab.$$eval('.warnings li', (items) => items.map((item) => item.textContent));
  assert.deepEqual(
    shown,
    document.warnings.map((warning) => warning.text),
  );
  // The number of the document is that of the results.
  const point = document.points.at.findIndex((place) => place.every((i) => i === 0));
  const summary = JSON.parse(cdb('show', 'rain.h5', '--json'));
  const other = (summary.documents?.[0] ?? summary).points.times.step.mean[point];
  assert.equal(document.points.times.step.mean[point], other);
  await tab.focus('select[name="role.detector"]');
  await tab.keyboard.press('ArrowUp'); // colour, along x
  await settle(tab);
  assert.equal(await compareTimes(document, document.axes), 8);
  await clean('rain');
});

test('figures as files', async () => {
  await report('files', 'first', 'first', '  cycles 20\n  repeats 2\n  objects { quantity sweep(20, 40) }');
  const names = await tab.$$eval('figure:not(.empty):not([hidden])', (figures) => figures.map((each) => each.id));
  cdb('report', 'files.h5', '-o', 'files.html', '--svg', 'files');
  assert.deepEqual(readdirSync(`${work}/files`), names.map((name) => `files-${name}.svg`).sort());
  // As saved from the page.
  assert.equal(readFileSync(`${work}/files/files-times.svg`, 'utf8'), String(await saveFile(tab, 'times', 'SVG')));
});

test('errors against run time', async () => {
  const document = await report('stack', 'accuracy', 'accuracy', '  repeats 2');
  const front = document.fronts.find((each) => each.error === 'position');
  const [header, ...rows] = parseCsv(String(await saveFile(tab, 'errors', 'CSV')));
  assert.equal(rows.length, front.rows.length);
  const wanted = front.rows.map((row) => row.ms_per_s).sort();
  assert.deepEqual(rows.map((row) => Number(row[header.indexOf('run time, ms per simulated s')])).sort(), wanted);
  assert.equal(
    rows.filter((row) => row[header.indexOf('front')] === 'front').length,
    front.rows.filter((row) => row.on_front).length,
  );
  await clean('stack');
});

test('one configuration', async () => {
  const document = await report('single', 'first', 'first', '  cycles 30\n  detector dbvt\n  objects { quantity 30 }');
  assert.equal(document.points.at.length, 1);
  const rows = parseCsv(String(await saveFile(tab, 'cycles', 'CSV')));
  assert.equal(rows.length, 1 + 4 * document.cycles.bins.length);
  await clean('single');
});

test('pairs that were compared with exact ones', async () => {
  const document = await report(
    'pairs',
    'detectors',
    'detectors',
    '  cycles 10\n  detector sweep(dbvt, sap32)\n  objects { quantity 50 }',
  );
  assert.equal(document.findings.length, 2);
  assert.match(await tab.$eval('#findings', (section) => section.textContent), /sap32/);
  await clean('pairs');
});

test('every run failed', async () => {
  const document = await report(
    'late',
    'first',
    'first',
    '  cycles 1000000\n  timeout 1\n  detector dbvt\n  objects { quantity 100 }',
  );
  assert.equal(document.runs.good, 0);
  assert.match(await tab.$eval('#failures', (section) => section.textContent), /cdb run .*--only/);
  await clean('late');
});
