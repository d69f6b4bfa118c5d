// Results documents for the tests of the page, and the cases that real results rarely have.

const phases = ['broad', 'narrow', 'detect', 'solve', 'integrate', 'step'].map((name) => ({
  name,
  label: `${name} phase`,
  definition: `What ${name} is.`,
}));
const shares = { broad: 0.2, narrow: 0.3, detect: 0.5, solve: 0.4, integrate: 0.1, step: 1 };

/** Every combination of indices; the last axis varies fastest. */
function grid(axes) {
  return axes.reduce((places, axis) => places.flatMap((place) => axis.values.map((_, i) => [...place, i])), [[]]);
}

export const numbers = (name, values, more = {}) => ({
  name,
  label: name,
  unit: '',
  is_text: false,
  kind: name,
  values,
  ...more,
});
export const texts = (name, values, more = {}) => ({
  name,
  label: name,
  unit: '',
  is_text: true,
  kind: name,
  values,
  ...more,
});

/** A document without pooled rows whose step takes `time(values)` ns at each point. */
function pointsDocument(axes, time, { repeats = 9, cycles = 100, ...more } = {}) {
  const at = grid(axes);
  const step = at.map((place) => time(axes.map((axis, a) => axis.values[place[a]])));
  const times = Object.fromEntries(
    phases.map(({ name }) => {
      const mean = step.map((value) => (value === null ? null : value * shares[name]));
      const scaled = (factor) => mean.map((value) => (value === null ? null : value * factor));
      const none = mean.map(() => null);
      return [
        name,
        {
          mean,
          low: repeats > 1 ? scaled(0.95) : none,
          high: repeats > 1 ? scaled(1.08) : none,
          median: scaled(0.98),
          p5: scaled(0.8),
          p95: scaled(1.3),
          min: scaled(0.7),
          max: scaled(2),
        },
      ];
    }),
  );
  const bins = Array.from({ length: cycles }, (_, i) => [i, i + 1]);
  const points = at.map((_, i) => i).slice(0, 60);
  const detector = axes.findIndex((axis) => axis.kind === 'detector');
  return {
    document: 1,
    generator: 'cdb test',
    sources: [{ file: 'test.h5', benchmark: 'test', title: 'A test' }],
    title: 'A test',
    runs: { all: at.length * repeats, good: at.length * repeats, void: 0, failed: 0, skipped: 0, missing: 0, repeats },
    warnings: [],
    conclusions: [],
    axes,
    detector_axis: detector < 0 ? null : detector,
    statistic: 'Median over 9 repeats per cycle, then mean over cycles.',
    interval:
      repeats > 1
        ? { name: '95 % interval', text: 'By bootstrap over the repeats.' }
        : { name: null, text: 'No interval: one repeat.' },
    phases,
    points: {
      at,
      mark: at.map(() => ''),
      is_void: at.map(() => false),
      repeats: at.map(() => repeats),
      verdict: at.map(() => 'stable'),
      first_bad_cycle: at.map(() => null),
      time_step: at.map(() => 1 / 60),
      cycles: at.map(() => cycles),
      times,
      counts: { pairs: at.map((_, i) => 10 * i) },
      memory: {},
    },
    ratios: detector < 0 ? null : ratiosOf(axes, at, detector, step),
    fronts: [],
    omissions: [],
    findings: [],
    failures: [],
    cycles: {
      points,
      bins,
      ...Object.fromEntries(
        phases.map(({ name }) => [
          name,
          points.map((p) =>
            bins.map((_, i) => (step[p] === null ? null : step[p] * shares[name] * (1 + 0.2 * Math.sin(i / 7)))),
          ),
        ]),
      ),
    },
    distributions: {
      percents: [0, 5, 25, 50, 75, 95, 100],
      quantiles: Object.fromEntries(
        phases.map(({ name }) => [
          name,
          step.map((value) =>
            value === null ? null : [0.7, 0.8, 0.9, 1, 1.1, 1.2, 1.5].map((q) => q * value * shares[name]),
          ),
        ]),
      ),
      repeat_means: {
        step: step.map((value) =>
          Array.from({ length: repeats }, (_, r) => (value === null ? null : value * (1 + 0.01 * r))),
        ),
      },
    },
    noise: { judgement: 'quiet', text: [] },
    machine: { host: 'h', cpu: 'c' },
    build: { type: 'Release' },
    provenance: { scenario: 'benchmark test\n{ }' },
    ...more,
  };
}

function ratiosOf(axes, at, detector, step) {
  const index = new Map(at.map((place, i) => [place.join(), i]));
  const base = at.map((place) => step[index.get(place.map((i, a) => (a === detector ? 0 : i)).join())]);
  const value = step.map((each, i) => (each === null || base[i] === null ? null : each / base[i]));
  const columns = {
    value,
    low: value.map((v) => v && v * 0.9),
    high: value.map((v) => v && v * 1.1),
    is_matched: value.map((v) => v !== null),
  };
  const cells = at.length / axes[detector].values.length;
  const means = axes[detector].values.map((name, d) => {
    const own = value.filter((v, i) => at[i][detector] === d && v > 0);
    const mean = own.length ? Math.exp(own.reduce((sum, v) => sum + Math.log(v), 0) / own.length) : null;
    return {
      detector: name,
      value: mean,
      low: mean && mean * 0.95,
      high: mean && mean * 1.05,
      least: Math.min(...own),
      most: Math.max(...own),
      cells,
      of: cells,
    };
  });
  return {
    baseline: axes[detector].values[0],
    phases: { step: columns, detect: columns },
    means: { step: means, detect: means },
  };
}

/** Groups `items` by `keyOf`, in order of first appearance. */
function groupBy(items, keyOf) {
  const groups = new Map();
  for (const item of items) {
    const key = keyOf(item);
    if (!groups.has(key)) groups.set(key, []);
    groups.get(key).push(item);
  }
  return [...groups.values()];
}

const severities = ['stable', 'tunnelled', 'frozen', 'crashed'];
const average = (values) =>
  values.some((value) => value === null) ? null : values.reduce((sum, value) => sum + value, 0) / values.length;

/** The pooled rows that cdb would write for a document, but with the means of the ends of intervals. */
function tableOf({ axes, points, detector_axis: detector, ratios }, at, kept) {
  const column = (values) => (Array.isArray(values) ? (i) => values[i] : () => values.constant);
  const [mark, isVoid, verdict, cycle] = ['mark', 'is_void', 'verdict', 'first_bad_cycle'].map((key) =>
    column(points[key]),
  );
  const place = (i) => kept.map((a) => at[i][a]);
  const cell = (i) => at[i].filter((_, a) => !kept.includes(a)).join();
  const timed = at.map((_, i) => i).filter((i) => points.times.step.mean[i] !== null);
  const rows = groupBy(timed, (i) => `${place(i)} ${isVoid(i)} ${mark(i)}`).map((own) => ({ own, points: own }));
  let isUnmatched = false;
  for (const kind of groupBy(rows, ({ own: [i] }) => `${isVoid(i)} ${mark(i)}`)) {
    const seen = new Map();
    for (const { own } of kind) for (const i of own) seen.set(cell(i), (seen.get(cell(i)) ?? 0) + 1);
    const isCommon = (i) => seen.get(cell(i)) === kind.length;
    if (!kind.some(({ own }) => own.some(isCommon))) isUnmatched = true;
    else for (const row of kind) row.points = row.own.filter(isCommon);
  }
  const means = (table) =>
    Object.fromEntries(
      Object.entries(table).map(([key, values]) => [key, rows.map((row) => average(row.points.map((i) => values[i])))]),
    );
  const places = groupBy(
    at.map((_, i) => i),
    (i) => place(i).join(),
  );
  const worst = (own) => own.reduce((a, b) => (severities.indexOf(verdict(b)) > severities.indexOf(verdict(a)) ? b : a));
  const ratiosOf = ({ value, low, high, is_matched: isMatched }) => {
    const used = places.map((own) => own.filter((i) => isMatched[i] && value[i] > 0));
    const of = (values) => used.map((own) => (own.length ? average(own.map((i) => values[i])) : null));
    return {
      ...{ value: of(value), low: of(low), high: of(high) },
      ...{ cells: used.map((own) => own.length), of: places.map((own) => own.length) },
      ...{ is_matched: used.map((own) => own.length > 0), is_void: places.map(() => false) },
    };
  };
  return {
    axes: kept,
    is_unmatched: isUnmatched,
    rows: {
      at: rows.map(({ own: [i] }) => place(i)),
      mark: rows.map(({ own: [i] }) => mark(i)),
      is_void: rows.map(({ own: [i] }) => isVoid(i)),
      points: rows.map((row) => row.points.length),
      own: rows.map((row) => row.own.length),
      times: Object.fromEntries(Object.entries(points.times).map(([phase, table]) => [phase, means(table)])),
      counts: means(points.counts ?? {}),
      memory: {},
    },
    places: {
      at: places.map(([i]) => place(i)),
      points: places.map((own) => own.length),
      verdict: places.map((own) => verdict(worst(own))),
      first_bad_cycle: places.map((own) => cycle(worst(own))),
      ...(ratios && kept.includes(detector)
        ? { ratios: Object.fromEntries(Object.entries(ratios.phases).map(([name, each]) => [name, ratiosOf(each)])) }
        : {}),
    },
  };
}

/** Adds the pooled rows of a document. */
export function pooled(document) {
  const { axes, points } = document;
  const at = Array.isArray(points.at) ? points.at : grid(axes);
  const varied = axes.map((_, a) => a).filter((a) => axes[a].values.length > 1);
  const tables = [];
  for (let bits = 0; bits < 2 ** varied.length - 1; ++bits)
    tables.push(tableOf(document, at, varied.filter((_, k) => (bits >> k) & 1)));
  return { ...document, pooled: tables };
}

/** A document whose step takes `time(values)` ns at each point. */
export const documentOf = (...parts) => pooled(pointsDocument(...parts));

const detectors = ['simple', 'sap', 'sap32', 'dbvt'];
const speed = { simple: 4, sap: 1.5, sap32: 1.4, dbvt: 2 };

/** Like examples/first.cdb, with conclusions. */
export const first = () =>
  documentOf(
    [texts('detector', detectors), numbers('quantity', [100, 200, 400, 800], { label: 'number of objects' })],
    ([detector, quantity]) => speed[detector] * 100 * quantity ** 1.2,
    {
      warnings: [
        { kind: 'debug', text: 'A debug build: its times say nothing.' },
        { kind: 'noise', text: 'The machine was noisy.' },
      ],
      conclusions: [
        {
          question: 'Which detector takes the least time for a step?',
          answer: 'sap32: 0.35 of simple’s time.',
          kind: 'fastest',
          certainty: 'clear',
        },
        { question: 'Which has the least error?', answer: 'Cannot tell.', kind: 'error', certainty: 'unknown' },
      ],
    },
  );

/** Void points, marks, verdicts, failures, findings and omissions; a third axis that is pooled; a missing point. */
export function mixed() {
  const document = documentOf(
    [texts('detector', detectors.slice(0, 3)), numbers('speed', [1, 10, 100, 1000]), numbers('seed', [1, 2])],
    ([detector, size, seed]) =>
      detector === 'simple' && size === 10 && seed === 2 ? null : speed[detector] * 1000 * size ** 0.3 * seed,
  );
  const { points } = document;
  points.at.forEach(([d, s, seed], i) => {
    const isFrozen = s === 3 || (d === 1 && s === 2 && seed === 1); // one of two points that would be pooled
    if (isFrozen) points.mark[i] = 'frozen';
    if (isFrozen) [points.is_void[i], points.verdict[i], points.first_bad_cycle[i]] = [true, 'frozen', 7 + d];
    else if (s === 2 && seed === 1) [points.verdict[i], points.first_bad_cycle[i]] = ['tunnelled', 17];
  });
  return pooled({
    ...document,
    conclusions: [
      { question: 'Which takes the least memory?', answer: 'None.', kind: 'memory', certainty: 'tie' },
      { question: 'Which is the fastest?', answer: 'sap32.', kind: 'fastest', certainty: 'clear' },
    ],
    failures: [{ place: 'detector sap, speed 1000', why: 'timed_out', command: 'cdb run test.cdb --only 0123' }],
    omissions: [{ parts: 'walls', points: 2, of: 24, why: 'no object can reach them', at: [0, 1] }],
    findings: [
      {
        detector: 'sap',
        cycles: 100,
        exact: 1000,
        missed: 3,
        false_positives: 0,
        duplicate: 0,
        missed_contacts: 0,
        wrong_runs: 1,
      },
    ],
    contact_findings: [{ narrow_phase: 'bullet', runs: 1, cycles: 100, compared: 70, of: 72, missed: 5 }],
  });
}

export function accuracy() {
  const hz = [60, 120, 240];
  const document = documentOf([numbers('hz', hz), numbers('iterations', [5, 20])], ([f, n]) => 1000 * n + f, {
    detector_axis: null,
  });
  const row = (f, n, on_front, more = {}) => ({
    at: { hz: f, iterations: n },
    ms_per_s: (f * n) / 200,
    low: (f * n) / 210,
    high: (f * n) / 190,
    error: 10 / f / n,
    error_low: 9 / f / n,
    error_high: 12 / f / n,
    floor: 1e-5,
    on_front,
    is_tie: false,
    is_void: false,
    points: [0],
    ...more,
  });
  return {
    ...document,
    title: 'Errors',
    fronts: ['position', 'energy'].map((error) => ({
      error,
      each: {},
      orders: error === 'position' ? [{ at: { iterations: 20 }, p: 1, low: 0.9, high: null }] : [],
      rows: [
        ...hz.flatMap((f) => [row(f, 5, true), row(f, 20, f > 60)]),
        row(480, 5, false, { error: 0, is_void: true }),
      ],
    })),
  };
}

const script = '<script>window.hacked = 1</script><img src=x onerror="window.hacked = 1">';
/** Markup, quotes, bidirectional characters and long names wherever there can be text. */
export function hostile() {
  const evil = [script, '"\'`&amp;</script><!--', '\u202eright to left\u202c עברית', 'x'.repeat(500), '=1+1', ''];
  const document = documentOf(
    [texts('detector', evil, { label: script, unit: script }), numbers('quantity', [1, 2])],
    ([name, n]) => 1000 * n * (name.length + 1),
  );
  document.points.mark[1] = script;
  document.points.verdict[1] = script;
  return pooled({
    ...document,
    title: script,
    generator: script,
    statistic: script,
    interval: { name: script, text: script },
    sources: [{ file: script, benchmark: `../../${script}`, title: script }],
    warnings: [{ kind: `" onload="window.hacked=1`, text: script }],
    conclusions: [{ question: script, answer: script, kind: script, certainty: script }],
    phases: [{ name: 'step', label: script, definition: script }],
    failures: [{ place: script, why: script, command: script }],
    omissions: [{ parts: script, points: 1, why: script }],
    findings: [{ detector: script, cycles: 1, missed: 1 }],
    machine: { [script]: script },
    build: { script },
    provenance: { script, long: `${script}\n${script}` },
    noise: { judgement: script, text: [script] },
    fronts: [
      {
        error: script,
        each: { [script]: script },
        rows: [
          {
            at: { detector: evil[0], [script]: script },
            ms_per_s: 1,
            low: null,
            high: null,
            error: 1,
            floor: null,
            on_front: true,
          },
        ],
      },
    ],
  });
}

export const cases = {
  empty: () => ({ document: 1, title: 'Empty', runs: { all: 0 }, axes: [], points: { at: [] } }),
  bare: () => ({}),
  no_axis: () => documentOf([], () => 5000),
  one_value: () => documentOf([numbers('quantity', [100])], () => 5000, { repeats: 1 }),
  all_failed: () => {
    const document = documentOf([texts('detector', ['a', 'b']), numbers('quantity', [1, 2])], () => null);
    document.points.is_void.fill(true);
    document.points.mark.fill('crashed');
    document.points.verdict.fill('crashed');
    return {
      ...pooled(document),
      cycles: null,
      distributions: null,
      failures: [{ place: 'all', why: 'crashed', command: 'cdb run' }],
    };
  },
  many_detectors: () =>
    documentOf(
      [
        texts(
          'detector',
          Array.from({ length: 23 }, (_, i) => `detector_with_a_name_${i}`),
        ),
      ],
      ([name]) => 1000 + 50 * name.length * Number(name.split('_').at(-1)),
    ),
  many_detectors_over_quantity: () =>
    documentOf(
      [
        texts(
          'detector',
          Array.from({ length: 23 }, (_, i) => `detector_${i}`),
        ),
        numbers('quantity', [1, 10, 100, 1000]),
      ],
      ([name, n]) => 1000 * n * (1 + Number(name.split('_').at(-1))),
    ),
  nulls: () =>
    documentOf([numbers('quantity', [1, 2, 3])], ([n]) => (n === 2 ? null : 1000 * n), {
      repeats: 1,
      interval: null,
      statistic: null,
    }),
  negative: () => documentOf([numbers('gravity', [-1e19, -1e9, -10, 0])], ([g]) => 1000 + Math.abs(g) ** 0.1),
  long_axis: () =>
    documentOf(
      [
        numbers(
          'size',
          Array.from({ length: 3000 }, (_, i) => i + 1),
        ),
        texts('detector', ['a', 'b']),
      ],
      ([n, d]) => n * (d === 'a' ? 10 : 20),
      { cycles: 1 },
    ),
  spikes_at_both_ends: () => {
    const document = documentOf([texts('detector', ['a', 'b', 'c', 'd', 'e', 'f'])], () => 5000, { cycles: 400 });
    for (const rows of Object.values(document.cycles).slice(2))
      for (const row of rows) for (const i of [0, 200, 399]) row[i] *= 1234;
    return document;
  },
};

/** 10^5 points in the compact forms. */
export function large() {
  const axes = [
    numbers(
      'quantity',
      Array.from({ length: 50 }, (_, i) => 10 * (i + 1)),
    ),
    texts(
      'detector',
      Array.from({ length: 20 }, (_, i) => `d${i}`),
    ),
    numbers(
      'seed',
      Array.from({ length: 100 }, (_, i) => i),
    ),
  ];
  const count = 1e5;
  const mean = Array.from({ length: count }, (_, i) =>
    Math.round(10 * (Math.floor(i / 2000) + 1) * (1 + (Math.floor(i / 100) % 20)) * (100 + (i % 100))),
  );
  const times = { mean, low: mean.map((v) => v - 10), high: mean.map((v) => v + 20) };
  return pooled({
    ...documentOf([], () => 1),
    axes,
    detector_axis: 1,
    ratios: null,
    cycles: null,
    distributions: null,
    runs: { all: count, good: count, repeats: 5 },
    points: {
      at: { grid: [[0, count]] },
      mark: { constant: '' },
      is_void: { constant: false },
      repeats: { constant: 5 },
      verdict: { constant: 'stable' },
      first_bad_cycle: { constant: null },
      cycles: { constant: 100 },
      times: { step: times, detect: { mean: times.mean } },
    },
  });
}
