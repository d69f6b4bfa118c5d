// Opens the page of a real run in headless Chromium and compares it with the results file:
//   node scene.mjs CDB SCENARIO FOLDER
import { execFileSync } from 'node:child_process';
import { deepStrictEqual as equal, ok } from 'node:assert';
import { writeFileSync } from 'node:fs';
import h5wasm from 'h5wasm/node';
import puppeteer from 'puppeteer-core';

const [cdb, scenario, folder] = process.argv.slice(2);
process.chdir(folder);
const kBrowsers = ['/usr/bin/chromium', '/usr/bin/chromium-browser', '/usr/bin/google-chrome'];
const kDecimals = 6; // positions are shown with seven digits

const run = (...words) => execFileSync(cdb, words, { encoding: 'utf8', stdio: ['ignore', 'pipe', 'pipe'] });
run('run', '-q', '--fresh', scenario);
run('view', 'scene.h5', '--select', 'timestep=0.016667', '-o', 'scene.html');
run('view', 'scene.h5', '--select', 'timestep=0.016667', '--beside', 'timestep=0.0083333', '-o', 'beside.html');

await h5wasm.ready;
const file = new h5wasm.File('scene.h5', 'r');
const poses = file.get('poses');
const [, , cycles, bodies, components] = poses.shape;
const timesteps = [...file.get('timestep').value];
const coarse = timesteps.indexOf(Math.max(...timesteps));
const pose = (cycle, body, at = coarse) =>
  [...poses.slice([[at, at + 1], [0, 1], [cycle, cycle + 1], [body, body + 1], [0, components]])];

const browser = await puppeteer.launch({
  executablePath: process.env.CDB_BROWSER || kBrowsers.find((path) => {
    try { execFileSync('test', ['-x', path]); return true; } catch { return false; }
  }),
  args: ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'],
});

// Any message on the page's console fails the test.
async function open(name, hash = '', { width = 1100, height = 800, scheme = 'light' } = {}) {
  const page = await browser.newPage();
  page.setDefaultTimeout(180_000); // a busy machine is no error
  const troubles = [];
  page.on('console', (message) => {
    // The browser warns of software rendering.
    if (!/GPU stall|swiftshader|software WebGL/i.test(message.text())) troubles.push(message.text());
  });
  page.on('pageerror', (error) => troubles.push(String(error)));
  page.on('request', (request) => {
    if (!/^(file|data|blob):/.test(request.url())) troubles.push(`loads ${request.url()}`);
  });
  page.on('dialog', (dialog) => { troubles.push(`dialog ${dialog.message()}`); dialog.dismiss(); });
  await page.setViewport({ width, height });
  await page.emulateMediaFeatures([{ name: 'prefers-color-scheme', value: scheme }]);
  await page.goto(`file://${folder}/${name}${hash}`);
  await page.waitForFunction(() => Number(document.getElementById('stage').dataset.drawn) > 0);
  return { page, troubles };
}

const text = (page, id) => page.$eval(`#${id}`, (element) => element.textContent);
async function pickTyped(page, body) {
  await page.$eval('#body', (input, value) => {
    input.value = value;
    input.dispatchEvent(new Event('change'));
  }, String(body));
}

// The panel shows the position in the file, in float32.
async function expectPosition(page, cycle, body, at = coarse) {
  const shown = (await text(page, 'fact-position')).replace(' m', '').split(' ').map(Number);
  const expected = pose(cycle, body, at).slice(0, 3).map((value) => Number(Math.fround(value).toPrecision(7)));
  shown.forEach((value, i) => ok(Math.abs(value - expected[i]) <= 10 ** -kDecimals * Math.max(1, Math.abs(expected[i])),
    `cycle ${cycle}, body ${body}: ${shown} instead of ${expected}`));
}

// Each component is as exact as the document says for orientations.
async function expectTurn(page, cycle, body) {
  const shown = (await text(page, 'fact-turn')).split(' ').slice(0, 4).map(Number);
  const expected = pose(cycle, body).slice(3);
  const sign = Math.sign(shown.reduce((sum, value, i) => sum + value * expected[i], 0));
  shown.forEach((value, i) => ok(Math.abs(sign * value - expected[i]) < 2e-4, `${shown} instead of ${expected}`));
}

async function seeksByKeyboard() {
  const { page, troubles } = await open('scene.html');
  equal(await text(page, 'clock'), `cycle 0 of ${cycles}, 0.0167 s`);
  for (const body of [0, 1, bodies - 1]) {
    await pickTyped(page, body);
    await page.focus('#clock').catch(() => {});
    await page.evaluate(() => document.activeElement.blur());
    await page.keyboard.press('Home');
    await expectPosition(page, 0, body);
    await page.keyboard.press('ArrowRight');
    await page.keyboard.press('ArrowRight');
    equal(await text(page, 'clock'), `cycle 2 of ${cycles}, 0.05 s`);
    await expectPosition(page, 2, body);
    await expectTurn(page, 2, body);
    await page.keyboard.press('End');
    ok((await text(page, 'clock')).startsWith(`cycle ${cycles - 1} of`));
    await expectPosition(page, cycles - 1, body);
    await page.keyboard.press('ArrowLeft');
    await expectPosition(page, cycles - 2, body);
  }
  await page.keyboard.press('Home');
  await page.keyboard.press('Space');
  await page.waitForFunction((last) => document.getElementById('clock').textContent.startsWith(`cycle ${last}`), {}, cycles - 1);
  equal(troubles, []);
  await page.close();
}

// A click on the time line seeks, and the address restores the same view.
async function keepsItsStateInTheAddress() {
  const { page } = await open('scene.html');
  const line = await (await page.$('.timeline canvas')).boundingBox();
  await page.mouse.click(line.x + line.width * 0.6, line.y + line.height / 2);
  await page.select('#colour', 'island');
  await page.click('#show-contacts');
  await page.click('#show-boxes');
  await page.click('#show-pairs');
  const clock = await text(page, 'clock');
  ok(/cycle (1|2)\d of/.test(clock), clock);
  await page.waitForFunction(() => /island.*contacts|contacts.*island/.test(location.hash) && /boxes.*pairs|pairs.*boxes/.test(location.hash));
  const { page: other, troubles } = await open('scene.html', await page.evaluate(() => location.hash));
  equal(await text(other, 'clock'), clock);
  equal(await other.$eval('#colour', (select) => select.value), 'island');
  ok(await other.$eval('#show-contacts', (box) => box.checked));
  await other.screenshot({ path: 'contacts.png' });
  equal(troubles, []);
  await page.close();
  await other.close();
}

// The middle of the scene has more than one colour.
async function drawsBodies() {
  const { page, troubles } = await open('scene.html', '#colour=shape', { scheme: 'dark' });
  const colours = await page.evaluate(() => {
    const scene = document.getElementById('scene');
    const copy = Object.assign(document.createElement('canvas'), { width: 200, height: 150 });
    const pen = copy.getContext('2d');
    pen.drawImage(scene, 0, 0, 200, 150);
    const { data } = pen.getImageData(0, 0, 200, 150);
    const seen = new Set();
    for (let i = 0; i < data.length; i += 4) seen.add((data[i] >> 4) * 256 + (data[i + 1] >> 4) * 16 + (data[i + 2] >> 4));
    return seen.size;
  });
  ok(colours > 20, `${colours} colours`);
  await page.screenshot({ path: 'dark.png' });
  equal(troubles, []);
  await page.close();
}

// Both runs show the same simulated time.
async function showsTwoRunsInTime() {
  const { page, troubles } = await open('beside.html', '#time=0.2');
  equal(await text(page, 'clock'), `A cycle 11 of ${cycles}, 0.2 s · B cycle 23 of ${cycles}, 0.2 s`);
  await page.screenshot({ path: 'beside.png' });
  equal(troubles, []);
  await page.close();
  const { page: phone, troubles: others } = await open('beside.html', '', { width: 390, height: 844 });
  ok(await phone.evaluate(() => document.documentElement.scrollWidth <= innerWidth), 'wider than a phone');
  await phone.screenshot({ path: 'phone.png' });
  equal(others, []);
  await phone.close();
}

try {
  await seeksByKeyboard();
  await keepsItsStateInTheAddress();
  await drawsBodies();
  await showsTwoRunsInTime();
  writeFileSync('done', '');
} finally {
  await browser.close();
}
