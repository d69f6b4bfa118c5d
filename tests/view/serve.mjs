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
    (document.querySelector(where)?.value ?? document.querySelector(where)?.textContent ?? '').includes(what), {}, selector, text);
  const put = (selector, value, event) => page.$eval(selector, (input, text, kind) => {
    input.value = text;
    input.dispatchEvent(new Event(kind));
  }, value, event);
  await holds('header', '25 objects');

  // A value changes the text and the scene.
  await put('[data-name="things.quantity"]', '40', 'change');
  await holds('#text', 'quantity        40');
  await holds('header', '41 objects');
  // An error is shown, and the scene stays.
  await put('[data-name="things.size"]', 'huge', 'change');
  await holds('#diagnostics', "'size' cannot be");
  await holds('header', '41 objects');
  await put('[data-name="things.size"]', '0.6', 'change');
  await page.waitForFunction(() => !document.getElementById('diagnostics').textContent.includes("'size' cannot be"));
  // The text changes the values and the scene.
  const text = await page.$eval('#text', (area) => area.value);
  await put('#text', text.replace('quantity        40', 'quantity        12'), 'input');
  await holds('header', '13 objects');
  await holds('[data-name="things.quantity"]', '12');

  await page.click('#save');
  await holds('#log', 'saved edited.cdb');
  equal(readFileSync('edited.cdb', 'utf8'), await page.$eval('#text', (area) => area.value));
  await page.click('#run');
  await holds('#clock', 'of 40');
  await holds('header', 'scene.view.h5');

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
