// Edits and runs a scenario in headless Chromium, served by `cdb view --serve`:
//   node serve.mjs CDB SCENARIO FOLDER
import { spawn } from 'node:child_process';
import { deepStrictEqual as equal, ok } from 'node:assert';
import { copyFileSync, readFileSync, writeFileSync } from 'node:fs';
import { once } from 'node:events';
import http from 'node:http';
import puppeteer from 'puppeteer-core';

const [cdb, scenario, folder] = process.argv.slice(2);
process.chdir(folder);
copyFileSync(scenario, 'edited.cdb');
const server = spawn(cdb, ['view', '--serve', 'edited.cdb'], { stdio: ['ignore', 'pipe', 'inherit'] });
const [line] = await once(server.stdout, 'data');
const address = String(line).trim();
ok(/^http:\/\/127\.0\.0\.1:\d+\/[0-9a-f]{32}\/$/.test(address), address);

// Requests without the token, or to another name of this machine, are refused.
function statusOf(url, headers = {}, method = 'GET') {
  return new Promise((resolve, reject) => {
    http.request(url, { headers, method }, (response) => { response.resume(); resolve(response.statusCode); })
      .on('error', reject).end();
  });
}
const { host, origin } = new URL(address);
equal(await statusOf(address), 200);
equal(await statusOf(`${origin}/`), 404);
equal(await statusOf(`${origin}/${'0'.repeat(32)}/run`, {}, 'POST'), 404);
equal(await statusOf(address, { Host: host.replace('127.0.0.1', 'localhost') }), 403);
equal(await statusOf(address, { Host: 'elsewhere.example' }), 403);
equal(await statusOf(`${address}check`, {}, 'POST'), 400);

const browser = await puppeteer.launch({
  executablePath: process.env.CDB_BROWSER || '/usr/bin/chromium',
  args: ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'],
});
try {
  const page = await browser.newPage();
  page.setDefaultTimeout(180_000); // a busy machine is no error
  const troubles = [];
  page.on('console', (message) => {
    if (!/GPU stall|swiftshader|software WebGL/i.test(message.text())) troubles.push(message.text());
  });
  page.on('pageerror', (error) => troubles.push(String(error)));
  await page.goto(address);
  const holds = (selector, text) => page.waitForFunction((where, what) =>
    (document.querySelector(where)?.value || document.querySelector(where)?.textContent || '').includes(what), {}, selector, text);
  const put = (selector, value, event) => page.$eval(selector, (input, text, kind) => {
    input.value = text;
    input.dispatchEvent(new Event(kind));
  }, value, event);
  // The whole text is in view.
  await page.setViewport({ width: 1400, height: 1600 });
  const code = () => page.$$eval('.cm-content .cm-line', (lines) => lines.map((line) => line.textContent).join('\n'));
  const codeHas = (text) => page.waitForFunction((what) =>
    [...document.querySelectorAll('.cm-content .cm-line')].some((line) => line.textContent.includes(what)), {}, text);
  const press = async (...keys) => {
    for (const key of keys.slice(0, -1)) await page.keyboard.down(key);
    await page.keyboard.press(keys.at(-1));
    for (const key of keys.slice(0, -1)) await page.keyboard.up(key);
  };
  // Selects the first `from` of the text, as a mouse would, and types.
  const type = async (from, to) => {
    await page.evaluate((what) => {
      const walk = document.createTreeWalker(document.querySelector('.cm-content'), NodeFilter.SHOW_TEXT);
      while (walk.nextNode()) {
        const at = walk.currentNode.data.indexOf(what);
        if (at < 0) continue;
        document.querySelector('.cm-content').focus();
        getSelection().setBaseAndExtent(walk.currentNode, at, walk.currentNode, at + what.length);
        return;
      }
      throw new Error(`no ${what}`);
    }, from);
    await page.waitForFunction(() => document.querySelector('.cm-content').contains(getSelection().anchorNode));
    await new Promise((done) => setTimeout(done, 100)); // the editor reads the selection in an event
    await page.keyboard.type(to);
  };
  await holds('header', '25 objects');
  ok((await page.$$('.cm-line span[class]')).length > 20); // highlighting

  // A value changes the text and the scene.
  await put('[data-name="things.quantity"]', '40', 'change');
  await codeHas('quantity        40');
  await holds('header', '41 objects');
  // An error comes first and is red, warnings come below it; the scene stays.
  await put('[data-name="things.size"]', 'huge', 'change');
  await holds('#problems', "'size' cannot be");
  await holds('#summary', 'the scene is that of the last text without errors');
  const kinds = await page.$$eval('#problems li', (rows) => rows.map((row) => row.className));
  equal(kinds[0], 'error');
  equal([...kinds], [...kinds].sort()); // error, hint, info, warning: here there are only errors and warnings
  const colours = await page.$$eval('#problems li b', (rows) => rows.map((row) => getComputedStyle(row).color));
  equal(new Set(colours).size, new Set(kinds).size);
  await holds('header', '41 objects');
  // A click on it goes to its line.
  await page.click('#problems li.error button');
  await page.waitForFunction(() => document.querySelector('.cm-activeLine').textContent.includes('huge'));
  equal(await page.evaluate(() => String(getSelection())), 'huge');
  // What is typed there replaces it: the values and the scene follow.
  await page.keyboard.type('0.6');
  await page.waitForFunction(() => !document.querySelector('#problems li.error'));
  await type('40', '12');
  await codeHas('cycles            12');
  await holds('[data-name="cycles"]', '12');
  await type('40', '9');
  await holds('header', '10 objects');
  await holds('[data-name="things.quantity"]', '9');

  // Ctrl-Space completes; the reference of a word is shown below the pointer.
  await type('random', 'random');
  await press('Escape'); // the list that opened by itself, or was about to: on a busy machine Enter would take its word
  await press('Enter');
  await page.keyboard.type('restit');
  await press('Escape');
  await press('Control', ' ');
  await holds('.cm-tooltip-autocomplete', 'restitution');
  await new Promise((done) => setTimeout(done, 100)); // Enter is not taken as long as the list is new
  await press('Enter');
  await codeHas('restitution');
  await page.keyboard.type(' 0.25');
  await holds('[data-name="things.restitution"]', '0.25');
  const line = await page.evaluateHandle(() => [...document.querySelectorAll('.cm-line')].find((each) => each.textContent.includes('timestep')));
  const box = await line.asElement().boundingBox();
  await page.mouse.move(box.x + 40, box.y + box.height / 2);
  await holds('.cm-tooltip pre', 'simulated time of one cycle');

  // Tab indents; after Escape it leaves the text.
  const isInText = () => page.evaluate(() => Boolean(document.activeElement.closest('#text')));
  await page.mouse.move(1000, 400);
  await press('Tab');
  ok(await isInText());
  await press('Control', 'z');
  await press('Escape');
  await press('Tab');
  ok(!await isInText());

  // Ctrl-S saves, without a dialog of the browser.
  await holds('#save', 'Save *');
  await page.focus('#filter');
  await press('Control', 's');
  await holds('#log', 'saved edited.cdb');
  equal(readFileSync('edited.cdb', 'utf8').trimEnd(), (await code()).trimEnd());
  equal(await page.$eval('#save', (button) => button.textContent), 'Save');

  // A text with errors is not run. A renamed benchmark is followed: its scene, its parameters and its run.
  await type('12', 'twelve');
  await page.waitForSelector('#problems li.error');
  await page.click('#run');
  await holds('#log', 'not run and not saved: the text has 1 error');
  await type('twelve', '12');
  await page.waitForFunction(() => !document.querySelector('#problems li.error'));
  await type('scene', 'renamed');
  await holds('#log', "no longer has the benchmark 'scen");
  await put('[data-name="cycles"]', '14', 'change');
  await codeHas('cycles            14');
  await page.click('#run');
  await holds('#clock', 'of 14');
  await holds('header', 'renamed.view.h5');

  // Both widths show everything, beside or below each other.
  for (const width of [700, 1400]) {
    await page.setViewport({ width, height: 900 });
    equal(await page.evaluate(() => document.documentElement.scrollWidth > innerWidth), false);
    const boxes = await page.$$eval('#text, #problems, #values, .app', (all) => all.map((each) => each.getBoundingClientRect().toJSON()));
    boxes.forEach((a, i) => boxes.slice(i + 1).forEach((b) =>
      ok(a.right <= b.left + 1 || b.right <= a.left + 1 || a.bottom <= b.top + 1 || b.bottom <= a.top + 1, JSON.stringify([width, a, b]))));
  }

  // A file that another program changed is not overwritten.
  writeFileSync('edited.cdb', 'benchmark scene { }\n');
  await page.click('#save');
  await holds('#log', 'was changed by another program');
  equal(readFileSync('edited.cdb', 'utf8'), 'benchmark scene { }\n');
  equal(troubles, []);
} finally {
  await browser.close();
  server.kill('SIGTERM');
}
const [status] = await once(server, 'exit');
equal(status, 0);
