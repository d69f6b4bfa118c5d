// The controls: the role of each axis, the quantity drawn, and the scales.
import { quantities, statistics, statisticsOf, valueText } from './document.js';
import { h } from './dom.js';
import { short } from './format.js';
import { phaseOf } from './cycle_points.js';
import { assign, defaultView, roleNames } from './state.js';

/** @typedef {(view: import('./state.js').View) => void} Change */

const roleLabels = { x: 'along x', colour: 'colour', panel: 'panels', fixed: 'fixed at', pooled: 'pooled' };

/**
 * A labelled choice.
 * @param {{name: string, label: string, value: string, options: {value: string, label: string, group?: string}[],
 *   change: (value: string) => void}} choice
 */
export function select({ name, label, value, options, change }) {
  const option = (each) => {
    const element = h('option', { value: each.value }, short(each.label, 48));
    element.selected = each.value === value;
    return element;
  };
  const groups = [...new Set(options.map((each) => each.group ?? ''))];
  const children = groups.flatMap((group) => {
    const own = options.filter((each) => (each.group ?? '') === group).map(option);
    return group ? [h('optgroup', { label: group }, ...own)] : own;
  });
  return h(
    'label',
    {},
    h('span', {}, short(label, 40)),
    h('select', { name, change: (event) => change(event.target.value) }, ...children),
  );
}

/** A choice of the value of a fixed axis. @param {number[]} [allowed] */
export function valueSelect(doc, view, a, change, allowed = doc.axes[a].values.map((_, i) => i), prefix = 'at') {
  const axis = doc.axes[a];
  return select({
    name: `${prefix}.${axis.name}`,
    label: prefix === 'at' ? `${axis.name} at` : axis.name,
    value: String(view.at[a]),
    options: allowed.map((i) => ({ value: String(i), label: valueText(axis, i) })),
    change: (value) => change({ ...view, at: view.at.map((old, i) => (i === a ? Number(value) : old)) }),
  });
}

function axisControl(doc, view, a, change) {
  const axis = doc.axes[a];
  const role = select({
    name: `role.${axis.name}`,
    label: axis.name,
    value: view.roles[a],
    options: roleNames.map((each) => ({ value: each, label: roleLabels[each] })),
    change: (value) => change(assign(view, a, value)),
  });
  role.title = short(`${axis.label}${axis.unit ? `, ${axis.unit}` : ''}: ${axis.values.length} values`, 200);
  return h('div', { class: 'axis' }, role, view.roles[a] === 'fixed' ? valueSelect(doc, view, a, change) : null);
}

/** A choice of one value of the axis of colours to highlight; the others are grey. */
function highlightSelect(doc, view, change) {
  const axis = doc.axes[view.roles.indexOf('colour')];
  if (!axis || axis.values.length < 3) return null;
  return select({
    name: 'highlight',
    label: 'highlight',
    value: String(view.highlight),
    options: [
      { value: '-1', label: 'all' },
      ...axis.values.map((_, i) => ({ value: String(i), label: valueText(axis, i) })),
    ],
    change: (value) => change({ ...view, highlight: Number(value) }),
  });
}

const group = (title, ...children) => h('fieldset', {}, h('legend', {}, title), ...children);

/** Choices of the quantity drawn over the axes, and of its statistic. */
function quantitySelects(doc, view, change) {
  const all = quantities(doc);
  const list = view.quantity.startsWith('time:') ? statisticsOf(doc, phaseOf(doc, view)) : [];
  const quantity = select({
    name: 'quantity',
    label: 'draw',
    value: view.quantity,
    options: all.map((each) => ({ value: each.id, label: each.label, group: each.group })),
    change: (value) => change({ ...view, quantity: value }),
  });
  const statistic = select({
    name: 'statistic',
    label: 'statistic',
    value: view.statistic,
    options: list.map((name) => ({ value: name, label: statistics[name] })),
    change: (value) => change({ ...view, statistic: value }),
  });
  return [all.length > 1 && quantity, list.length > 1 && statistic];
}

function scaleSelect(view, name, label, change) {
  const options = ['auto', 'linear', 'log'].map((value) => ({ value, label: value }));
  return select({ name, label, value: view[name], options, change: (value) => change({ ...view, [name]: value }) });
}

/** @param {import('./document.js').Doc} doc @param {import('./state.js').View} view @param {Change} change */
export function controls(doc, view, change) {
  const free = doc.axes.map((_, a) => a).filter((a) => doc.axes[a].values.length > 1);
  const axes = free.map((a) => axisControl(doc, view, a, change));
  return [
    quantities(doc).length > 1 && group('Figure', ...quantitySelects(doc, view, change)),
    free.length > 0 && group('Axes', ...axes, highlightSelect(doc, view, change)),
    group('Scales', scaleSelect(view, 'xScale', 'x', change), scaleSelect(view, 'yScale', 'times', change)),
    h('button', { type: 'button', name: 'reset', click: () => change(defaultView(doc)) }, 'Defaults'),
  ].filter(Boolean);
}

/** Choices for the figure over the cycles: its kind, and the values of the other axes. */
export function cycleTools(doc, view, change) {
  const { cycles } = doc.raw;
  if (!cycles) return [];
  return [
    select({
      name: 'cycles',
      label: 'draw',
      value: view.cycles,
      options: [
        { value: 'phases', label: 'phases, stacked' },
        { value: 'lines', label: 'phases as lines' },
        { value: 'points', label: `${phaseOf(doc, view)} as lines` },
      ],
      change: (value) => change({ ...view, cycles: value }),
    }),
    ...placeTools(doc, view, change, cycles.points),
  ];
}

/** The values at which the points of a figure are taken. @param {number[] | undefined} points  points of the figure */
export function placeTools(doc, view, change, points = doc.at.map((_, i) => i)) {
  const colour =
    view.roles.indexOf('colour') >= 0
      ? view.roles.indexOf('colour')
      : view.roles.findIndex((role, a) => role === 'x' && doc.axes[a].isText);
  return doc.axes
    .map((_, a) => a)
    .filter((a) => a !== colour && doc.axes[a].values.length > 1)
    .map((a) => [a, [...new Set(points.map((p) => doc.at[p][a]))].sort((x, y) => x - y)])
    .filter(([, allowed]) => allowed.length > 1)
    .map(([a, allowed]) => valueSelect(doc, view, a, change, allowed, 'where'));
}

export function errorTools(doc, view, change) {
  const names = [...new Set((doc.raw.fronts ?? []).map((front) => front.error))];
  return names.length < 2
    ? []
    : [
        select({
          name: 'error',
          label: 'error',
          value: view.error,
          options: names.map((name) => ({ value: name, label: String(name).replace(/_/g, ' ') })),
          change: (value) => change({ ...view, error: value }),
        }),
      ];
}

export function mapTools(doc, view, change) {
  const free = doc.axes.map((_, a) => a).filter((a) => doc.axes[a].values.length > 1);
  if (free.length < 2) return [];
  const options = [...free.map((a) => ({ value: String(a), label: doc.axes[a].name })), { value: '-1', label: 'none' }];
  const one = (key, other, label) =>
    select({
      name: key,
      label,
      value: String(view[key]),
      options,
      change: (value) =>
        change({
          ...view,
          [key]: Number(value),
          ...(Number(value) >= 0 && Number(value) === view[other] ? { [other]: view[key] } : {}),
        }),
    });
  return [one('mapX', 'mapY', 'across'), one('mapY', 'mapX', 'down')];
}
