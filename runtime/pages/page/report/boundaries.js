// The boundaries that the searches of a scenario found, over another axis, or in rows.
import { legendOf, lineDrawing, textDrawing } from './axis_panels.js';
import { valueText } from './document.js';
import { bdi, h, table } from './dom.js';
import { count, short } from './format.js';

const found = (doc) => doc.raw.boundaries ?? null;

/** @returns {boolean} */
export const hasBoundaries = (doc) => (found(doc)?.boundaries ?? []).length > 0;

/** `verdict != stable along ratio`. */
export const boundariesTitle = (doc) => `Where ${found(doc).until} along ${found(doc).axis}`;

/** The axes of x, colours and panels: the first of numbers, then the others in order. */
function rolesOf(doc, names) {
  const axes = names.map((name) => doc.axes.findIndex((axis) => axis.name === name));
  const several = axes.filter((a) => doc.axes[a].values.length > 1);
  const x = several.find((a) => !doc.axes[a].isText) ?? several[0] ?? -1;
  const [colour = -1, panel = -1] = several.filter((a) => a !== x);
  return [x, colour, panel];
}

/** A boundary beyond the range of its search is drawn hollow, at the end of the range. */
function rowOf(doc, one, names, [x, colour, panel]) {
  const at = (a) => (a < 0 ? -1 : one.at[names.indexOf(doc.axes[a].name)]);
  const isFound = one.value !== null;
  return {
    xIndex: at(x),
    colour: at(colour),
    panel: at(panel),
    x: x < 0 || doc.axes[x].isText ? at(x) : doc.axes[x].values[at(x)],
    value: one.value ?? one.low ?? one.high,
    low: isFound ? one.low : null,
    high: isFound ? one.high : null,
    isVoid: !isFound,
    mark: '',
    place: names.map((name, i) => `${name} ${valueText(doc.axes.find((axis) => axis.name === name), one.at[i])}`).join(', '),
    text: one.text,
    probes: one.probes,
  };
}

export function describeBoundaries(doc, view, plainHow) {
  const how = { ...plainHow, theme: { ...plainHow.theme, highlight: view.highlight } };
  const { axis, axes: names, boundaries, values, until } = found(doc);
  const title = boundariesTitle(doc);
  const roles = rolesOf(doc, names);
  const rows = boundaries.map((one) => rowOf(doc, one, names, roles)).filter((row) => row.value !== null);
  if (rows.length === 0) return { title, empty: 'No search has ended.' };
  rows.sort((a, b) => a.panel - b.panel || a.colour - b.colour || a.x - b.x);
  const axesOf = roles.map((a) => doc.axes[a]);
  const isRows = !axesOf[0] || axesOf[0].isText;
  const unit = doc.axes.find((each) => each.name === axis)?.unit;
  const drawing = (isRows ? textDrawing : lineDrawing)(doc, view, {
    rows,
    axes: axesOf,
    how,
    yLabel: unit ? `${axis}, ${unit}` : axis,
    height: 300,
    isSorted: false,
  });
  const columns = [
    { key: 'place', label: 'where' },
    { key: 'text', label: `from which ${axis} on` },
    { key: 'probes', label: 'points run', isNumber: true },
  ];
  const open = rows.filter((row) => row.isVoid).length;
  return {
    title,
    columns,
    rows,
    legend: legendOf(rows, axesOf[1], how.theme, isRows),
    ...drawing,
    notes: [
      `The first of ${values} values of ${short(axis, 40)} at which ${short(until, 80)}, by bisection.`,
      ...(open > 0 ? [`Hollow: not found in every search; drawn at the end of what is known.`] : []),
    ],
  };
}

/** The boundaries as a table, and what to know of them. */
export function boundaryTable(doc) {
  const { axis, axes: names, boundaries } = found(doc);
  const again = boundaries.reduce((sum, one) => sum + one.not_monotone, 0);
  const searches = boundaries.reduce((sum, one) => sum + one.searches, 0);
  const rows = boundaries.map((one) => [
    ...names.map((name, i) => bdi(valueText(doc.axes.find((each) => each.name === name), one.at[i]))),
    one.text,
    count(one.probes),
  ]);
  return [
    table(
      [...names.map((label) => ({ label })), { label: axis }, { label: 'points run', isNumber: true }],
      rows,
      'Boundaries of the searches',
    ),
    again > 0
      ? h(
          'p',
          { class: 'note' },
          `In ${again} of ${searches} searches the condition is met, and further along not met again: the first boundary is given.`,
        )
      : null,
  ].filter(Boolean);
}
