// The parts of the page that need no browser: pooling, state, formats.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import {
  budgetOf,
  budgetText,
  column,
  openDocument,
  pointText,
  quantities,
} from '../../runtime/pages/page/report/document.js';
import { rowsOf } from '../../runtime/pages/page/report/axis_rows.js';
import { count, csv, number, short } from '../../runtime/pages/page/report/format.js';
import { entriesOf, thin } from '../../runtime/pages/page/report/pooled.js';
import { assign, decode, defaultRoles, defaultView, encode, unknownEntry } from '../../runtime/pages/page/report/state.js';
import { documentOf, first, large, mixed, numbers, texts } from './fixtures.mjs';

test('numbers have three digits, and exponents where they are far from one', () => {
  assert.deepEqual(
    [0, 1, 1234.5, 0.12345, 1e6, 2.5e-7, -3, null, NaN].map((v) => number(v)),
    ['0', '1', '1235', '0.123', '10⁶', '2.5 × 10⁻⁷', '−3', '–', '–'],
  );
  assert.equal(count(1234567), '1\u202f234\u202f567');
});

test('a budget is drawn for its phase, if it is the same at all points', () => {
  const of = (budget) => openDocument({ axes: [], points: { at: [] }, budget });
  assert.equal(budgetOf(of({ ns: 4e6, phase: 'step' }), 'step', 1e6), 4);
  assert.equal(budgetOf(of({ ns: 4e6, phase: 'step' }), 'detect', 1e6), null);
  assert.equal(budgetOf(of({ ns: null, phase: 'step' }), 'step', 1e6), null);
  assert.equal(budgetOf(of(null), 'step', 1e6), null);
  assert.deepEqual([4e6, 2.5e5, 8333333].map(budgetText), ['4 ms', '250 µs', '8.333 ms']);
});

test('text of one line has no control characters and no changes of direction', () => {
  assert.equal(short('a\u202eb\nc'), 'a b c');
  assert.equal([...short('x'.repeat(500), 20)].length, 20);
});

test('CSV quotes commas, quotes and lines', () => {
  assert.equal(
    csv(
      [
        { key: 'a', label: 'x,y' },
        { key: 'b', label: 'b' },
      ],
      [{ a: 'q"', b: null }],
    ),
    '"x,y",b\r\n"q""",\r\n',
  );
});

test('a column may be an array, one value, or words and indices', () => {
  assert.deepEqual(column([1, 2], 2), [1, 2]);
  assert.deepEqual(column(7, 2), [7, 7]);
  assert.deepEqual(column({ constant: null }, 2), [null, null]);
  assert.deepEqual(column({ words: ['', 'frozen'], index: [1, 0] }, 2), ['frozen', '']);
});

test('points may be runs of the grid, whose last axis is the fastest', () => {
  const doc = openDocument({
    axes: [numbers('a', [1, 2]), numbers('b', [1, 2, 3])],
    points: {
      at: {
        grid: [
          [0, 2],
          [4, 2],
        ],
      },
    },
  });
  assert.deepEqual(doc.at, [
    [0, 0],
    [0, 1],
    [1, 1],
    [1, 2],
  ]);
});

test('by default the axis of numbers is along x and the detectors have colours', () => {
  assert.deepEqual(defaultRoles(openDocument(first())), ['colour', 'x']);
  assert.deepEqual(defaultRoles(openDocument(mixed())), ['colour', 'x', 'pooled']);
  assert.deepEqual(defaultRoles(openDocument(documentOf([texts('detector', ['a', 'b'])], () => 1))), ['x']);
  assert.deepEqual(defaultRoles(openDocument(documentOf([numbers('quantity', [5])], () => 1))), ['fixed']);
});

test('an axis that takes the role of another gives it the old one', () => {
  const view = defaultView(openDocument(first()));
  assert.deepEqual(assign(view, 0, 'x').roles, ['x', 'colour']);
  assert.deepEqual(assign(view, 0, 'pooled').roles, ['pooled', 'x']);
});

test('the address has what differs from the defaults, and reads back', () => {
  const doc = openDocument(mixed());
  const view = defaultView(doc);
  assert.equal(encode(doc, view), '');
  const changed = {
    ...assign(view, 2, 'panel'),
    quantity: 'time:narrow',
    statistic: 'p95',
    yScale: 'log',
    mapX: 2,
    mapY: 1,
    at: [1, 0, 1],
  };
  assert.deepEqual(decode(doc, encode(doc, changed)), changed);
});

test('an entry of an address that no view takes is named', () => {
  const doc = openDocument(first());
  for (const known of ['', 'quantity=time:narrow&statistic=p95', 'role.detector=x&at.quantity=1', 'mapX=detector', 'section=times'])
    assert.equal(unknownEntry([doc], known), null, known);
  for (const unknown of ['nonsense=abc', 'quantity=time:detekt', 'role.detector=nonsense', 'at.quantity=99', 'mapX=other'])
    assert.equal(unknownEntry([doc], unknown), unknown);
});

test('an address that does not apply is as by default', () => {
  const doc = openDocument(first());
  assert.deepEqual(
    decode(doc, 'role.detector=nonsense&at.quantity=99&quantity=<script>&statistic=&section=%3Cscript%3E&role.other=x'),
    defaultView(doc),
  );
  const both = decode(doc, 'role.detector=x&role.quantity=x');
  assert.deepEqual(both.roles, ['x', 'pooled']);
});

const step = (doc) => quantities(doc).find((each) => each.id === 'time:step');
const entries = (doc, view) => entriesOf(doc, view, step(doc));

test('void points stand apart, and a hole leaves its cell out of every mark of its kind', () => {
  const doc = openDocument(mixed());
  const found = entries(doc, defaultView(doc));
  assert.deepEqual(found.pooled, [2]);
  assert.equal(found.isUnmatched, false);
  // Simple has no time at speed 10, seed 2: the sound marks only have seed 1, and the void ones seed 2, as one of them has
  // no other.
  for (const each of found.entries) assert.equal(each.points, 1);
  assert.equal(found.entries.filter((each) => each.isVoid).length, 4);
});

test('pooled values are those of the document', () => {
  const doc = openDocument(mixed());
  const view = { ...defaultView(doc), roles: ['pooled', 'x', 'pooled'] };
  const { rows } = doc.raw.pooled.find(({ axes }) => axes.join() === '1');
  const found = entries(doc, view).entries;
  assert.deepEqual(
    found.map(({ value, low, high, points, own }) => [value, low, high, points, own]),
    rows.at.map((_, i) => [
      ...['mean', 'low', 'high'].map((key) => rows.times.step[key][i]),
      rows.points[i],
      rows.own[i],
    ]),
  );
  assert.deepEqual(
    found.map(({ place }) => place),
    rows.at.map(([i]) => [-1, i, -1]),
  );
});

test('sampled points are drawn over each parameter, or over the one that matters most', () => {
  const sampled = [
    { name: 'mu', log: false, values: [0.5, 0.1, 0.9, 0.3] },
    { name: 'n', log: true, values: [10, 1000, 100, 1] },
  ];
  const design = numbers('design', [1, 2, 3, 4], { sampled });
  const doc = openDocument(documentOf([design], ([i]) => sampled[1].values[i - 1] * 5));
  const view = defaultView(doc);
  const step = quantities(doc).find(({ id }) => id === 'time.step');
  const over = (...single) => rowsOf(doc, view, step ?? quantities(doc)[0], ...single);
  const all = over();
  assert.deepEqual(all.axes[2].values, ['mu', 'n']);
  assert.deepEqual(
    all.rows.map(({ panel, x, xIndex }) => [panel, x, xIndex]),
    [
      ...[[0.1, 1], [0.3, 3], [0.5, 0], [0.9, 2]].map((of) => [0, ...of]),
      ...[[1, 3], [10, 0], [100, 2], [1000, 1]].map((of) => [1, ...of]),
    ],
  );
  const best = over(true);
  assert.equal(best.axes[0].name, 'n');
  assert.deepEqual(
    best.rows.map(({ x }) => x),
    [1, 10, 100, 1000],
  );
});

test('a fixed axis chooses among the pooled rows', () => {
  const doc = openDocument(mixed());
  const view = { ...defaultView(doc), roles: ['fixed', 'x', 'pooled'], at: [1, 0, 0] };
  const whole = entries(doc, { ...view, roles: ['colour', 'x', 'pooled'] }).entries;
  assert.deepEqual(
    entries(doc, view).entries,
    whole.filter(({ place }) => place[0] === 1),
  );
});

test('a set of axes that the document did not pool has no entries', () => {
  const doc = openDocument({ ...mixed(), pooled: [] });
  assert.equal(entries(doc, defaultView(doc)), null);
});

test('fixed axes select', () => {
  const doc = openDocument(first());
  const view = { ...defaultView(doc), roles: ['colour', 'fixed'], at: [0, 2] };
  assert.deepEqual(
    entries(doc, view).entries.map(({ place }) => pointText(doc, doc.at.findIndex((at) => at.join() === place.join()))),
    ['simple', 'sap', 'sap32', 'dbvt'].map((name) => `detector ${name}, quantity 400`),
  );
});

test('long series are thinned to bins that keep their range', () => {
  const bins = thin(
    Array.from({ length: 1000 }, (_, i) => ({ x: i, value: i, low: null, high: null })),
    10,
  );
  assert.equal(bins.length, 10);
  assert.deepEqual(bins[0], { x: 49.5, value: 49.5, count: 100, low: 0, high: 99 });
});

test('10^5 points have pooled rows', () => {
  const doc = openDocument(large());
  const found = entries(doc, defaultView(doc)).entries;
  assert.equal(found.length, 1000);
  assert.ok(found.every((each) => each.points === 100));
});

test('what can be drawn', () => {
  assert.deepEqual(
    quantities(openDocument(first())).map((each) => each.id),
    [
      'time:broad',
      'time:narrow',
      'time:detect',
      'time:solve',
      'time:integrate',
      'time:step',
      'ratio:step',
      'ratio:detect',
      'count:pairs',
    ],
  );
});
