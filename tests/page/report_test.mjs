// The page of `cdb report` in a browser: compares the figures with the numbers of the document; controls; special cases.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import {
  blemishes,
  folder,
  launch,
  marksOf,
  openTab,
  parseCsv,
  saveFile,
  settle,
  visit,
  writePage,
} from './browser.mjs';
import { accuracy, cases, first, hostile, large, mixed } from './fixtures.mjs';

let browser;
let tab;
before(async () => {
  browser = await launch();
  tab = await openTab(browser);
});
after(() => browser.close());

const open = (name, ...documents) => visit(tab, writePage(name, { documents }));
const text = (selector) => tab.$eval(selector, (element) => element.textContent);
const hash = () => tab.evaluate(() => location.hash);
const clean = async () => {
  assert.deepEqual(tab.faults, []);
  assert.deepEqual(await blemishes(tab), []);
};

/** The residual, in px, of the best straight line through [u, v]. */
function residual(pairs) {
  const n = pairs.length;
  const mean = (k) => pairs.reduce((sum, pair) => sum + pair[k], 0) / n;
  const [u, v] = [mean(0), mean(1)];
  const slope =
    pairs.reduce((sum, pair) => sum + (pair[0] - u) * (pair[1] - v), 0) /
    pairs.reduce((sum, pair) => sum + (pair[0] - u) ** 2, 0);
  return Math.max(...pairs.map((pair) => Math.abs(pair[1] - v - slope * (pair[0] - u))));
}

test('the first screen has what swept, warnings, conclusions and a figure', async () => {
  await open('first', first());
  assert.match(await text('.sweep'), /144 runs: 4 values of detector × 4 of quantity × 9 repeats, 100 cycles each/);
  assert.equal(await text('.warnings li'), 'A debug build: its times say nothing.');
  assert.match(await text('.conclusions'), /least time for a step\?sap32: 0.35 of simple’s time. clear/);
  const place = await tab.$eval('#times', (figure) => figure.getBoundingClientRect().top);
  assert.ok(place < 900, `the figure is at ${place}`);
  await tab.screenshot({ path: `${folder}/first-screen.png` });
  await clean();
});

test('marks stand where the document says', async () => {
  const document = first();
  const rows = parseCsv(String(await saveFile(tab, 'times', 'CSV')));
  assert.deepEqual(rows[0], ['detector', 'quantity', 'time of step, ms', 'low, ms', 'high, ms']);
  assert.equal(rows.length - 1, document.points.at.length);
  for (const [detector, quantity, value, low] of rows.slice(1)) {
    const point = document.points.at.findIndex(
      ([d, q]) => document.axes[0].values[d] === detector && document.axes[1].values[q] === Number(quantity),
    );
    assert.ok(
      Math.abs(Number(value) * 1e6 - document.points.times.step.mean[point]) <
        1e-6 * document.points.times.step.mean[point],
    );
    assert.ok(Math.abs(Number(low) * 1e6 - document.points.times.step.low[point]) < 1);
  }
  const marks = await marksOf(tab, 'times');
  assert.equal(marks.length, document.points.at.length);
  const of = (mark) => rows[mark.row + 1];
  const squares = marks.filter((mark) => of(mark)[0] === 'sap'); // of one symbol
  assert.ok(residual(squares.map((mark) => [Math.log(Number(of(mark)[2])), mark.y])) < 1);
  assert.ok(residual(squares.map((mark) => [Math.log(Number(of(mark)[1])), mark.x])) < 1);
});

test('figures save as SVG and PNG that stand alone', async () => {
  const svg = String(await saveFile(tab, 'times', 'SVG'));
  assert.match(svg, /^<svg xmlns="http:\/\/www.w3.org\/2000\/svg"/);
  assert.match(svg, /<rect width="820" height="\d+" fill="#ffffff"\/>/);
  assert.match(svg, /Time of step over quantity/);
  assert.match(svg, /Median over 9 repeats per cycle/);
  assert.doesNotMatch(svg, /var\(|<script|<foreignObject|href|NaN/);
  const png = await saveFile(tab, 'times', 'PNG');
  assert.equal(png.toString('latin1', 1, 4), 'PNG');
  assert.equal(png.readUInt32BE(16), 1640);
  assert.ok(png.length > 10000);
  assert.deepEqual(tab.faults, []);
});

test('the keyboard reaches the controls, the address follows, and it goes back', async () => {
  await tab.focus('select[name="role.detector"]');
  await tab.keyboard.press('ArrowDown'); // colour, panels
  await settle(tab);
  assert.equal(await hash(), '#role.detector=panel');
  assert.equal(await tab.evaluate(() => document.activeElement.name), 'role.detector');
  assert.equal((await tab.$$('#times .panel-title')).length, 4);
  await tab.reload({ waitUntil: 'load' });
  assert.equal((await tab.$$('#times .panel-title')).length, 4);
  assert.equal(await tab.$eval('select[name="role.detector"]', (element) => element.value), 'panel');
  await tab.goBack();
  await settle(tab);
  assert.equal(await hash(), '');
  assert.equal((await tab.$$('#times .panel-title')).length, 0);
  await clean();
});

test('arrow keys visit the marks of a figure', async () => {
  await tab.$eval('#times svg', (svg) => svg.focus());
  await tab.keyboard.press('ArrowRight');
  assert.match(await text('#tip'), /detector simplequantity 100time of step, ms 0\.1/);
  await tab.keyboard.press('ArrowRight');
  assert.match(await text('#tip'), /quantity 200/);
  await tab.keyboard.press('Escape');
  assert.equal(await tab.$eval('#tip', (tip) => tip.hidden), true);
  const [mark] = await marksOf(tab, 'times');
  await tab.mouse.move(mark.x + 2, mark.y);
  assert.match(await text('#tip'), /quantity 100/);
});

test('the mouse changes quantity, statistic, scale and value', async () => {
  const rowsNow = async () => parseCsv(String(await saveFile(tab, 'times', 'CSV')));
  await tab.select('select[name=statistic]', 'p95');
  await settle(tab);
  assert.equal(await hash(), '#statistic=p95');
  assert.equal((await rowsNow())[0].length, 3); // no interval
  assert.match(await text('#times .note'), /95th percentile over the cycles/);
  await tab.select('select[name=quantity]', 'ratio:step');
  await settle(tab);
  assert.equal(Number((await rowsNow()).find(([name]) => name === 'sap')[2]), 1.5 / 4);
  await tab.select('select[name="role.quantity"]', 'fixed');
  await settle(tab);
  await tab.select('select[name="at.quantity"]', '1');
  await settle(tab);
  assert.equal((await rowsNow()).length, 5);
  assert.match(await text('#times .note'), /At quantity 200/);
  await tab.click('button[name=reset]');
  await settle(tab);
  assert.equal((await rowsNow()).length, 17);
  await clean();
});

test('the table under a figure has its data', async () => {
  await tab.click('#times .data summary');
  await tab.waitForSelector('#times .data tbody tr');
  assert.equal((await tab.$$('#times .data tbody tr')).length, 16);
  await tab.click('#times .data summary');
});

test('ratios are those of the document', async () => {
  const rows = parseCsv(String(await saveFile(tab, 'rivals', 'CSV')));
  const mean = rows.find(([group, name]) => group === 'geometric mean' && name === 'sap32');
  assert.ok(Math.abs(Number(mean[2]) - 1.4 / 4) < 1e-9);
  const marks = await marksOf(tab, 'rivals');
  assert.equal(marks.length, rows.length - 1);
  const circles = marks.filter(
    (mark) => rows[mark.row + 1][0] !== 'geometric mean' && rows[mark.row + 1][1] !== 'sap32',
  );
  assert.ok(residual(circles.map((mark) => [Math.log(Number(rows[mark.row + 1][2])), mark.x])) < 1);
});

test('phases over the cycles stack up to the step', async () => {
  const rows = parseCsv(String(await saveFile(tab, 'cycles', 'CSV')));
  const at = rows.filter((row) => row.at(-3) === '50' && row.join().includes('sap32'));
  assert.deepEqual(
    at.map((row) => row.at(-2)),
    ['broad', 'narrow', 'solve', 'integrate'],
  );
  const document = first();
  const point = document.points.at.findIndex(([d, q]) => d === 2 && q === 3);
  const wanted = document.cycles.step[document.cycles.points.indexOf(point)][50];
  assert.ok(Math.abs((at.reduce((sum, row) => sum + Number(row.at(-1)), 0) * 1e6) / wanted - 1) < 1e-9);
  await tab.select('select[name=cycles]', 'lines');
  await settle(tab);
  assert.match(await text('#cycles .legend'), /broadnarrowsolveintegratestep/);
  await clean();
  await tab.select('select[name=cycles]', 'points');
  await settle(tab);
  assert.match(await text('#cycles h3'), /Time of step in each cycle/);
  await clean();
});

test('errors stand against speed, small ones at the bottom and fast ones on the right', async () => {
  await open('accuracy', accuracy());
  const [header, ...rows] = parseCsv(String(await saveFile(tab, 'errors', 'CSV')));
  const [speed, error, state] = ['speed, simulated s per s', 'position error', 'front'].map((name) =>
    header.indexOf(name),
  );
  const marks = (await marksOf(tab, 'errors'))
    .map((mark) => ({ ...mark, cells: rows[mark.row] }))
    .filter(({ cells }) => cells[0].endsWith('iterations 20'))
    .sort((a, b) => a.row - b.row);
  assert.deepEqual(
    marks.map(({ cells }) => cells[0]),
    [60, 120, 240].map((hz) => `hz ${hz}, iterations 20`),
  );
  for (const mark of marks)
    assert.ok(Math.abs(Number(mark.cells[error]) * Number(/hz (\d+)/.exec(mark.cells[0])[1]) * 20 - 10) < 1e-9);
  marks.sort((a, b) => a.x - b.x);
  assert.ok(Number(marks[0].cells[speed]) < Number(marks[2].cells[speed]), 'fast ones are on the right');
  assert.ok(
    marks[0].y > marks[2].y && Number(marks[0].cells[error]) < Number(marks[2].cells[error]),
    'small errors are at the bottom',
  );
  assert.deepEqual(
    rows.map((cells) => cells[state]),
    ['front', '', 'front', 'front', 'front', 'front', 'void'],
  );
  assert.match(await text('#errors .note'), /lower right is best.* Order: the power of the time step/);
  assert.match(await text('#errors .legend'), /iterations 20(: |, )order 1\.00 \[0\.90, –\]/);
  await tab.select('select[name=error]', 'energy');
  await settle(tab);
  assert.match(await text('#errors h3'), /energy/);
  assert.doesNotMatch(await text('#errors'), /order/i);
  await clean();
});

test('void points are hollow, apart and said; verdicts have names and cycles', async () => {
  await open('mixed', mixed());
  const hollow = await tab.$$eval(
    '#times [data-row]',
    (marks) => marks.filter((mark) => mark.getAttribute('fill') === '#ffffff').length,
  );
  assert.equal(hollow, 4);
  assert.match(await text('#times .note'), /Hollow: the verdict voids the time \(frozen\)/);
  assert.match(await text('#times .note'), /Pooled over seed/);
  assert.match(await text('#stability svg'), /frozen/);
  const map = parseCsv(String(await saveFile(tab, 'stability', 'CSV')));
  assert.ok(map.some((row) => row.join().includes('sap32,1000,frozen,9')));
  assert.match(await text('.conclusions dt'), /fastest/); // which the first figure shows
  assert.match(await text('#failures'), /cdb run test.cdb --only 0123/);
  assert.match(await text('#left-out'), /no object can reach them/);
  assert.match(
    await text('#left-out details'),
    /2 of 24detector simple, speed 1, seed 1detector simple, speed 1, seed 2/,
  );
  assert.match(await text('#findings'), /sap/);
  assert.match(await text('#findings'), /bullet\s*100\s*70\s*72\s*5/);
  await tab.click('#failures .copy');
  await tab.waitForFunction(() => document.querySelector('#failures .copy').textContent !== 'Copy');
  assert.equal(await text('#failures .copy'), 'Copied');
  await tab.select('select[name=mapX]', '0');
  await settle(tab);
  assert.match(await hash(), /mapX=detector&mapY=speed/);
  await clean();
});

test('several documents have a tab each', async () => {
  await open('several', first(), { ...accuracy(), sources: [{ file: 'b.h5' }] });
  assert.equal((await tab.$$('.tabs a')).length, 2);
  await tab.click('.tabs a:nth-child(2)');
  await settle(tab);
  assert.equal(await text('h1'), 'Errors');
  assert.equal(await hash(), '#doc=1');
  await tab.goBack();
  await settle(tab);
  assert.equal(await text('h1'), 'A test');
  await clean();
});

test('hostile text is text', async () => {
  await open('hostile', hostile());
  for (const role of ['x', 'panel', 'fixed']) {
    await tab.evaluate((value) => {
      const select = document.querySelector('.controls [name="role.detector"]');
      select.value = value;
      select.dispatchEvent(new Event('change'));
    }, role);
    await settle(tab);
    assert.deepEqual(await blemishes(tab), []);
  }
  for (const figure of ['times', 'errors']) await saveFile(tab, figure, 'SVG');
  assert.equal(await tab.evaluate(() => window.hacked), undefined);
  assert.equal((await tab.$$('script')).length, 2);
  assert.equal((await tab.$$('img, iframe, object, [onerror], [onload]')).length, 0);
  assert.match(await text('h1'), /^<script>window.hacked = 1<\/script><img/);
  assert.deepEqual(tab.faults, []);
  await tab.goto('about:blank');
});

test('hostile addresses are not markup', async () => {
  await visit(
    tab,
    `${folder}/first.html`,
    'quantity=<img src=x onerror=hacked=1>&section=__proto__&at.quantity=-1&doc=9&role.detector=constructor',
  );
  assert.equal(await tab.evaluate(() => window.hacked), undefined);
  await clean();
});

for (const [name, make] of Object.entries(cases))
  test(`case: ${name.replace(/_/g, ' ')}`, async () => {
    await open(name, make());
    await clean();
    assert.ok((await text('#page')).length > 10);
    const blank = await tab.$$eval('figure', (figures) =>
      figures
        .filter(
          (figure) =>
            !figure.querySelector('svg [data-row], svg path, svg rect') &&
            figure.querySelector('.note').textContent.length < 5,
        )
        .map((figure) => figure.id),
    );
    assert.deepEqual(blank, []);
    await tab.screenshot({ path: `${folder}/case-${name}.png`, fullPage: true });
  });

test('no results at all', async () => {
  await visit(tab, writePage('none', { documents: [] }));
  assert.match(await text('#page'), /no results/);
});

test('10^5 points are drawn as aggregates', async () => {
  const file = writePage('large', { documents: [large()] });
  const began = performance.now();
  await visit(tab, file);
  console.log(`10^5 points: ${Math.round(performance.now() - began)} ms from the address to the page`);
  const elements = await tab.evaluate(() => document.querySelectorAll('*').length);
  assert.ok(elements < 20000, `${elements} elements`);
  await clean();
});

const looks = {
  light: [{}, ['first', 'accuracy', 'mixed', 'many_detectors']],
  dark: [{ scheme: 'dark' }, ['first', 'mixed', 'hostile']],
  phone: [{ width: 360, height: 740 }, ['first', 'accuracy', 'mixed', 'many_detectors']],
  print: [{ media: 'print', width: 794 }, ['first', 'accuracy', 'mixed']],
};
for (const [name, [how, pages]] of Object.entries(looks))
  test(`screenshots: ${name}`, async () => {
    const other = await openTab(browser, how);
    for (const page of pages) {
      await visit(other, `${folder}/${page}.html`);
      await settle(other);
      assert.deepEqual(await blemishes(other), [], `${page}, ${name}`);
      await other.screenshot({ path: `${folder}/${page}-${name}.png`, fullPage: true });
      const isShown = await other.$eval('.actions', (actions) => getComputedStyle(actions).display !== 'none');
      assert.equal(isShown, name !== 'print');
      const colour = await other.evaluate(() => getComputedStyle(document.body).backgroundColor);
      assert.equal(colour, name === 'dark' ? 'rgb(21, 24, 28)' : 'rgb(255, 255, 255)');
    }
    assert.deepEqual(other.faults, []);
    await other.close();
  });
