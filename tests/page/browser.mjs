// A headless browser that records everything that a page must not do.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { resolve } from 'node:path';
import { pathToFileURL } from 'node:url';
import puppeteer from 'puppeteer-core';

export const folder = resolve('pages');
mkdirSync(folder, { recursive: true });

/** @param {string} name @param {object} data  the JSON of the page */
export function writePage(name, data, kind = 'report') {
  const file = `${folder}/${name}.html`;
  writeFileSync(
    file,
    execFileSync(process.env.PAGE_FIXTURE, [kind], { input: JSON.stringify(data), maxBuffer: 1 << 28 }),
  );
  return file;
}

export const launch = () =>
  puppeteer.launch({
    executablePath: '/usr/bin/chromium',
    args: ['--no-sandbox', '--font-render-hinting=none', '--force-color-profile=srgb'],
  });

/** A tab whose `faults` are errors, violations of the policy, and requests beyond the page itself. */
export async function openTab(
  browser,
  { width = 1360, height = 900, scheme = 'light', media = 'screen' } = {},
) {
  const tab = await browser.newPage();
  const faults = [];
  tab.on('console', (message) => {
    if (['error', 'warn'].includes(message.type())) faults.push(message.text());
  });
  tab.on('pageerror', (error) => faults.push(String(error)));
  tab.on('dialog', (dialog) => {
    faults.push(`dialog ${dialog.message()}`);
    dialog.dismiss();
  });
  tab.on('request', (request) => {
    if (!/^(file|data|blob):/.test(request.url())) faults.push(`request ${request.url()}`);
  });
  await tab.evaluateOnNewDocument(() =>
    addEventListener('securitypolicyviolation', (event) =>
      console.error('policy', event.violatedDirective, event.blockedURI),
    ),
  );
  await tab.setViewport({ width, height });
  // One undoes the other.
  if (media === 'print') await tab.emulateMediaType(media);
  else await tab.emulateMediaFeatures([{ name: 'prefers-color-scheme', value: scheme }]);
  return Object.assign(tab, { faults });
}

export async function visit(tab, file, hash = '') {
  await tab.goto('about:blank');
  await tab.goto(pathToFileURL(file) + (hash ? `#${hash}` : ''), { waitUntil: 'load' });
  await tab.waitForFunction(
    () => document.documentElement.dataset.ready === 'yes' || document.querySelector('#page p'),
    { timeout: 20000 },
  );
}

export const settle = (tab) =>
  tab.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));

/**
 * Visible faults of a page: marks without a position, tick labels that overlap, a page wider than the screen.
 */
export async function blemishes(tab) {
  return tab.evaluate(() => {
    const found = [];
    const overlap = (a, b) =>
      Math.min(a.right, b.right) - Math.max(a.left, b.left) > 1 &&
      Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 2;
    if (document.documentElement.scrollWidth > innerWidth)
      found.push(`the page is ${document.documentElement.scrollWidth} wide`);
    for (const svg of document.querySelectorAll('figure svg[role=img]')) {
      const id = svg.closest('figure').id;
      if (/NaN|undefined|Infinity/.test(svg.outerHTML)) found.push(`${id}: a mark without a place`);
      for (const group of svg.querySelectorAll('[aria-label$="tick label"], .legend')) {
        const boxes = [...group.querySelectorAll('text')]
          .filter((each) => each.textContent)
          .map((each) => [each.textContent, each.getBoundingClientRect()]);
        for (let i = 1; i < boxes.length; ++i)
          for (let k = 0; k < i; ++k)
            if (overlap(boxes[i][1], boxes[k][1])) found.push(`${id}: '${boxes[k][0]}' and '${boxes[i][0]}' overlap`);
      }
      const frame = svg.getBoundingClientRect();
      for (const text of svg.querySelectorAll('text')) {
        const box = text.getBoundingClientRect();
        if (box.width && (box.left < frame.left - 3 || box.right > frame.right + 3))
          found.push(`${id}: '${text.textContent}' leaves its figure`);
      }
    }
    return found.slice(0, 20);
  });
}

/** Clicks a figure's button that saves a file. @returns {Promise<Buffer>} */
export async function saveFile(tab, figure, format) {
  const target = `${folder}/downloads`;
  mkdirSync(target, { recursive: true });
  const session = await tab.browser().target().createCDPSession();
  await session.send('Browser.setDownloadBehavior', { behavior: 'allow', downloadPath: target, eventsEnabled: true });
  const done = new Promise((accept, reject) => {
    let name;
    session.on('Browser.downloadWillBegin', (event) => {
      name = event.suggestedFilename;
    });
    session.on('Browser.downloadProgress', ({ state }) => {
      if (state === 'completed') accept(name);
      if (state === 'canceled') reject(new Error(`${name} was not saved`));
    });
  });
  await tab.click(`#${figure} button[aria-label$="${format}"]`);
  const name = await done;
  await session.detach();
  assert.match(name, /^[\w-]+\.(svg|png|csv)$/);
  return readFileSync(`${target}/${name}`);
}

/** The rows of a CSV. */
export const parseCsv = (text) =>
  text
    .trimEnd()
    .split('\r\n')
    .map((line) =>
      [...line.matchAll(/("(?:[^"]|"")*"|[^,]*)(?:,|$)/g)]
        .map(([, cell]) => (cell.startsWith('"') ? cell.slice(1, -1).replace(/""/g, '"') : cell))
        .slice(0, line.endsWith(',') ? undefined : -1),
    );

/** For each mark of a figure: its centre in px and its row of the data. */
export const marksOf = (tab, figure) =>
  tab.evaluate(
    (id) =>
      [...document.querySelectorAll(`#${id} [data-row]`)].map((mark) => {
        const box = mark.getBoundingClientRect();
        return { row: Number(mark.dataset.row), x: box.x + box.width / 2, y: box.y + box.height / 2 };
      }),
    figure,
  );
