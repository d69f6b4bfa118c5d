// Error against speed: both axes logarithmic, small errors at the bottom, fast configurations on the right.
import * as Plot from '@observablehq/plot';
import { number, short } from './format.js';
import { style } from './palette.js';
import { extent, intervalText, logTicks } from './scales.js';
import { textWidth } from './compose.js';

const mostLabels = 14;
const mostNamed = 40; // configurations in a panel, above which the front has no names
const mostLabelLength = 40;
const speedLabel = 'speed, simulated s per s';

const errorInfo = (doc, name) => doc.raw.points?.errors?.[name] ?? {};

/** The axis of `at` that the colours show, and all axes of `at` that vary. */
function styleAxes(doc, view, rows) {
  const names = [...new Set(rows.flatMap((row) => Object.keys(row.at ?? {})))];
  const varied = doc.axes
    .map((axis, a) => ({ axis, a }))
    .filter(({ axis }) => names.includes(axis.name) && new Set(rows.map((row) => row.at[axis.name])).size > 1);
  const colour =
    varied.find(({ a }) => view.roles[a] === 'colour') ?? varied.find(({ a }) => a === doc.detectorAxis) ?? varied[0];
  return { colour, varied };
}

/** A value of an axis: 1/60 is 0.01667. */
const valueText = (value) => (typeof value === 'number' ? number(value, 4) : short(value, 24));
const atText = (at) =>
  Object.entries(at ?? {})
    .map(([name, value]) => `${name} ${valueText(value)}`)
    .join(', ');

const corners = [
  { side: 'start', dy: -9 },
  { side: 'end', dy: -9 },
  { side: 'start', dy: 14 },
  { side: 'end', dy: 14 },
];

/** Labels beside the front's marks, without those that would cover another. */
function labels(rows, x, y, width, height) {
  const placed = [];
  const place = (value, domain, size) => (Math.log(value / domain[0]) / Math.log(domain[1] / domain[0])) * size;
  const out = [];
  for (const row of rows) {
    const px = place(row.speed, x, width);
    const py = height - place(row.error, y, height);
    const w = textWidth(row.label, 10.5);
    for (const { side, dy } of corners) {
      const left = side === 'start' ? px + 4 : px - w - 4;
      const box = [left, py + dy - 10, left + w, py + dy + 3];
      if (left < 0 || box[2] > width + 10 || box[1] < 0 || box[3] > height) continue;
      if (placed.some((other) => box[0] < other[2] && box[2] > other[0] && box[1] < other[3] && box[3] > other[1]))
        continue;
      placed.push(box);
      out.push({ ...row, side, dy });
      break;
    }
    placed.push([px - 6, py - 6, px + 6, py + 6]);
  }
  return out;
}

/** The front and the configurations with their intervals. */
function marksOf(rows, theme) {
  const ink = (row) => style(theme, row.colour).colour;
  const front = rows.filter((row) => row.onFront).sort((a, b) => a.speed - b.speed);
  const intervals = { stroke: ink, strokeWidth: 1.2 };
  return [
    Plot.line(front, {
      x: 'speed',
      y: 'error',
      curve: 'step-before',
      stroke: theme.muted,
      strokeWidth: 1.2,
      strokeDasharray: '4 3',
    }),
    Plot.ruleX(rows, { x: 'speed', y1: 'errorLow', y2: 'errorHigh', filter: (row) => row.errorLow > 0, ...intervals }),
    Plot.ruleY(rows, { y: 'error', x1: 'speedLow', x2: 'speedHigh', filter: (row) => row.speedLow > 0, ...intervals }),
    Plot.dot(rows, {
      x: 'speed',
      y: 'error',
      className: 'hot',
      symbol: (row) => style(theme, row.colour).symbol,
      stroke: ink,
      strokeWidth: 1.7,
      r: (row) => (row.onFront ? 5.4 : 3.6),
      fill: (row) => (row.isVoid ? theme.background : ink(row)),
      fillOpacity: (row) => (row.onFront ? 1 : row.isTie ? 0.65 : 0.35),
    }),
  ];
}

/** Names of the configurations on the front. */
function nameMarks(rows, { theme, x, y, width, height }) {
  const front = rows.filter((row) => row.onFront).sort((a, b) => a.speed - b.speed);
  const named = rows.length <= mostNamed ? labels(front.slice(0, mostLabels), x, y, width - 82, height - 66) : [];
  return corners.map(({ side, dy }) =>
    Plot.text(named, {
      x: 'speed',
      y: 'error',
      text: 'label',
      filter: (row) => row.side === side && row.dy === dy,
      textAnchor: side,
      dx: side === 'start' ? 4 : -4,
      dy,
      fill: theme.ink,
      fontSize: 10.5,
    }),
  );
}

function panelOf(rows, { theme, x, y, label }) {
  return ({ width, height }) => {
    const ticks = { x: logTicks(...x, Math.max(3, Math.floor(width / 90))), y: logTicks(...y, 7) };
    const common = { type: 'log', tickFormat: (v) => number(v) };
    const best = {
      frameAnchor: 'bottom-right',
      dx: -4,
      dy: -6,
      fill: theme.muted,
      fontStyle: 'italic',
      text: (d) => d,
    };
    return {
      width,
      height,
      marginLeft: 58,
      marginRight: 24, // half of the last tick's text
      marginTop: 26,
      marginBottom: 40,
      x: { ...common, domain: x, ticks: ticks.x, label: speedLabel, labelAnchor: 'right', labelArrow: 'right' },
      y: { ...common, domain: y, ticks: ticks.y, label: `${label} (down is better)`, labelArrow: 'none' },
      marks: [
        Plot.gridX({ stroke: theme.grid, strokeOpacity: 1, ticks: ticks.x }),
        Plot.gridY({ stroke: theme.grid, strokeOpacity: 1, ticks: ticks.y }),
        Plot.text(['best: fast and accurate ↘'], best),
        ...marksOf(rows, theme),
        ...nameMarks(rows, { theme, x, y, width, height }),
      ],
    };
  };
}

/** The coordinates that distinguish a configuration from others of the same colour: `hz 60`. */
function nameOf(row, varied, colour) {
  const others = varied.filter((each) => each !== colour);
  const text = ({ axis }) => (axis.isText ? row.at[axis.name] : `${axis.name} ${valueText(row.at[axis.name])}`);
  return (others.length ? others : varied).map(text).join(', ');
}

/** A row of the document for the figure. `least`: where an error of 0 is drawn. */
function rowOf(row, { each, colour, varied, least }) {
  const hasInterval = row.low > 0 && row.high > 0;
  return {
    configuration: atText(row.at) || 'the only configuration',
    label: short(nameOf(row, varied, colour), 30),
    each: atText(each),
    colour: colour ? colour.axis.values.indexOf(row.at[colour.axis.name]) : -1,
    speed: 1000 / row.ms_per_s,
    speedLow: hasInterval ? 1000 / row.high : null,
    speedHigh: hasInterval ? 1000 / row.low : null,
    msPerS: row.ms_per_s,
    low: row.low,
    high: row.high,
    given: row.error,
    error: Math.max(row.error, row.floor ?? 0) || least,
    errorLow: row.error_low ?? null,
    errorHigh: row.error_high ?? null,
    floor: row.floor ?? null,
    onFront: Boolean(row.on_front),
    isTie: Boolean(row.is_tie),
    isVoid: Boolean(row.is_void),
    state: row.is_void ? 'void' : row.unsound ? row.unsound : row.on_front ? 'front' : row.is_tie ? 'tie' : '',
  };
}

/** The columns that have values. */
function columnsOf(rows, name, unit) {
  return [
    ['each', 'group'],
    ['configuration', 'configuration'],
    ['msPerS', 'run time, ms per simulated s', true],
    ['low', 'low', true],
    ['high', 'high', true],
    ['speed', speedLabel, true],
    ['given', `${name} error${unit ? `, ${unit}` : ''}`, true],
    ['errorLow', 'error low', true],
    ['errorHigh', 'error high', true],
    ['floor', 'floor', true],
    ['state', 'front'],
  ]
    .map(([key, label, isNumber = false]) => ({ key, label, isNumber }))
    .filter(({ key }) => rows.some((row) => row[key] !== null && row[key] !== ''));
}

const mostOrders = 6; // in the legend
const orderText = ({ p, low, high }) => {
  const digits = (value) => (value === null ? '–' : value.toFixed(2).replace('-', '−'));
  return `order ${digits(p)} [${digits(low)}, ${digits(high)}]`;
};

/** The fitted orders of the fronts: of the values of `colour`, of whole panels, and the others, with their places. */
function ordersOf(fronts, colour) {
  const all = fronts.flatMap(({ each, orders = [] }, front) => orders.map((order) => ({ ...order, each, front })));
  const isOfColour = ({ at }) => colour && Object.keys(at).length === 1 && colour.axis.name in at;
  const isAlone = ({ front }) => fronts.length > 1 && fronts[front].orders.length === 1;
  if (fronts.length === 1 && all.length > 0 && all.every(isOfColour))
    return { all, ofValue: new Map(all.map((order) => [order.at[colour.axis.name], orderText(order)])), rest: [] };
  return {
    all,
    ofFront: new Map(all.filter(isAlone).map((order) => [order.front, orderText(order)])),
    rest: all
      .filter((order) => !isAlone(order))
      .map((order) => [atText(order.each), atText(order.at), orderText(order)].filter(Boolean).join(', ')),
  };
}

function notesOf(doc, view, rows, info, orders) {
  const some = (test, note) => (rows.some(test) ? [note] : []);
  const statistic = doc.raw.statistic?.replace(/\.$/, '') ?? 'the mean time of a cycle';
  const isLong = info.label && info.label.length > mostLabelLength;
  return [
    ...(isLong ? [`${short(view.error, 40)}: ${short(info.label, 300)}.`] : []),
    'The lower right is best: fast and accurate.',
    'Large: on the front, where no other configuration is both as fast and as accurate.',
    'Small: behind it, or darker if it ties with the front within the intervals.',
    `Speed: ${statistic.charAt(0).toLowerCase()}${statistic.slice(1)}, divided by the time step.`,
    rows.some((row) => row.speedLow !== null) ? intervalText(doc) : 'No intervals of the speed: one repeat.',
    ...(orders.all.length > 0
      ? [
          'Order: the power of the time step as which the error falls, fitted to the sound errors above the floor, with ' +
            'its 95 % interval.',
        ]
      : []),
    ...(orders.rest.length > mostOrders ? [`Not in the legend: ${orders.rest.slice(mostOrders).join('; ')}.`] : []),
    ...some((row) => row.errorLow !== null, 'Bars of errors: over the seeds.'),
    ...some((row) => row.given < row.floor, 'An error below its floor is not known, and is drawn at the floor.'),
    ...some((row) => row.given <= 0, 'An error of 0 is drawn at the lower edge.'),
    ...some((row) => row.isVoid, 'Hollow: the verdict voids the time.'),
  ];
}

function domainOf(values) {
  const [low, high] = extent(values.filter((value) => value > 0));
  const pad = Math.max((high / low) ** 0.08, 1.3);
  return [low / pad, high * pad];
}

/** The values of the axis of colours, and fitted orders. */
function legendOf(rows, colour, theme, orders) {
  const values = (colour?.axis.values ?? [])
    .map((value, i) => ({ value, i }))
    .filter(({ i }) => rows.some((row) => row.colour === i))
    .map(({ value, i }) => ({
      label: [`${colour.axis.name} ${valueText(value)}`, orders.ofValue?.get(value)].filter(Boolean).join(': '),
      colour: style(theme, i).colour,
      symbol: style(theme, i).symbol,
    }));
  const rest = orders.rest.slice(0, mostOrders).map((label) => ({ label, colour: theme.muted, isText: true }));
  return [...values, ...rest];
}

export function describeErrors(doc, view, { theme, width }) {
  const fronts = (doc.raw.fronts ?? []).filter((front) => front.error === view.error);
  const title = 'Error against run time';
  if (fronts.length === 0) return { title, empty: 'No errors were measured.' };
  const info = errorInfo(doc, view.error);
  const all = fronts.flatMap((front) => front.rows ?? []);
  const { colour, varied } = styleAxes(doc, view, all);
  const least = Math.min(...all.map((row) => Math.max(row.error, row.floor ?? 0)).filter((error) => error > 0), 1) / 2;
  const rows = [];
  const groups = fronts.map((front) => {
    const usable = (front.rows ?? []).filter((row) => row.error !== null && row.ms_per_s > 0);
    const own = usable.map((row) => rowOf(row, { each: front.each, colour, varied, least }));
    rows.push(...own);
    return { own, first: rows.length - own.length, title: atText(front.each) };
  });
  const orders = ordersOf(fronts, colour);
  groups.forEach((group, front) => {
    const order = orders.ofFront?.get(front);
    if (order) group.title = `${group.title}: ${order}`;
  });
  if (rows.length === 0) return { title, empty: 'No configuration has both an error and a time.' };
  const x = domainOf(rows.flatMap((row) => [row.speed, row.speedLow, row.speedHigh]));
  const y = domainOf(rows.flatMap((row) => [row.error, row.errorLow, row.errorHigh]));
  const name = info.label && info.label.length <= mostLabelLength ? info.label : `error in ${view.error}`;
  const label = `${name}${info.unit ? `, ${info.unit}` : ''}`;
  return {
    title: `Error in ${short(view.error, 40).replace(/_/g, ' ')} against speed`,
    columns: columnsOf(rows, view.error, info.unit),
    rows,
    perRow: Math.max(1, Math.floor(width / 340)),
    height: groups.length > 1 ? 300 : 400,
    panels: groups.map(({ own, first, title: each }) => ({
      title: each,
      hot: { hot: own.map((_, i) => first + i) },
      options: panelOf(own, { theme, x, y, label }),
    })),
    legend: legendOf(rows, colour, theme, orders),
    notes: notesOf(doc, view, rows, info, orders),
  };
}
