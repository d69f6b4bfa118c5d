// The reader's choices, their defaults for a document, and their encoding in the address.
import { quantities, statisticsOf } from './document.js';

/** @typedef {'x' | 'colour' | 'panel' | 'fixed' | 'pooled'} Role */
/**
 * @typedef {object} View
 * @property {Role[]} roles      of each axis
 * @property {number[]} at       of each axis, the index of the value that is used while the axis is fixed
 * @property {string} quantity   what is drawn over the axes: `time:step`
 * @property {string} statistic
 * @property {'auto' | 'linear' | 'log'} xScale
 * @property {'auto' | 'linear' | 'log'} yScale
 * @property {number} highlight  the only value of the axis of colours that is drawn in colour; -1 for all
 * @property {'phases' | 'lines' | 'points'} cycles  which figure over the cycles
 * @property {string} error
 * @property {number} mapX       axis of the stability map, -1 for none
 * @property {number} mapY
 * @property {string} section    where the page is scrolled to
 */
export const roleNames = /** @type {const} */ (['x', 'colour', 'panel', 'fixed', 'pooled']);
const single = new Set(['x', 'colour', 'panel']);
const mostPanels = 8;
const mostColours = 30;
const widest = 15; // ratio of times on one linear scale

const most = (axes, indices) =>
  indices.reduce((best, i) => (best < 0 || axes[i].values.length > axes[best].values.length ? i : best), -1);

/** @param {import('./document.js').Doc} doc @returns {Role[]} */
export function defaultRoles(doc) {
  const { axes } = doc;
  const roles = axes.map((axis) => (axis.values.length > 1 ? 'pooled' : 'fixed'));
  let free = axes.map((_, i) => i).filter((i) => roles[i] === 'pooled');
  const take = (role, i) => {
    if (i < 0) return;
    roles[i] = role;
    free = free.filter((other) => other !== i);
  };
  const isSeed = (i) => axes[i].kind === 'seed' || axes[i].name === 'seed';
  const useful = () => free.filter((i) => !isSeed(i));
  const x = most(
    axes,
    useful().filter((i) => !axes[i].isText),
  );
  take('x', x >= 0 ? x : most(axes, useful()));
  const few = (limit) => useful().filter((i) => axes[i].values.length <= limit);
  const detector = doc.detectorAxis;
  take('colour', few(mostColours).includes(detector) ? detector : most(axes, few(8)));
  take('panel', most(axes, few(mostPanels)));
  return roles;
}

/**
 * The values at which figures of a single point are drawn: those of the point with the greatest numbers and the first
 * texts, a sound one if there is any.
 */
function defaultAt(doc) {
  const order = doc.axes.map((_, a) => a).sort((a, b) => Number(doc.axes[a].isText) - Number(doc.axes[b].isText));
  const isBetter = (p, q) => {
    if (doc.isVoid[p] !== doc.isVoid[q]) return !doc.isVoid[p];
    for (const a of order) if (doc.at[p][a] !== doc.at[q][a]) return doc.at[p][a] > doc.at[q][a] !== doc.axes[a].isText;
    return false;
  };
  let best = 0;
  for (let p = 1; p < doc.count; ++p) if (isBetter(p, best)) best = p;
  return doc.count ? [...doc.at[best]] : doc.axes.map(() => 0);
}

/** True if the configurations compared over the cycles differ too much for one linear scale. */
function isWide(doc, roles, at) {
  const compared = roles.includes('colour')
    ? roles.indexOf('colour')
    : doc.axes.findIndex((axis, a) => roles[a] === 'x' && axis.isText);
  const times = (doc.times.step ?? doc.times.detect)?.mean ?? [];
  const beside = doc.at
    .map((_, p) => p)
    .filter((p) => times[p] > 0 && at.every((i, a) => a === compared || doc.at[p][a] === i));
  const values = beside.map((p) => times[p]);
  return values.length > 1 && Math.max(...values) > widest * Math.min(...values);
}

/**
 * The axes of the map: horizontally the axis of numbers with the most values, vertically that of the detectors, or the
 * one with the most values of the rest.
 * @param {import('./document.js').Doc} doc
 */
function defaultMap(doc) {
  const free = doc.axes.map((_, i) => i).filter((i) => doc.axes[i].values.length > 1);
  const x = most(
    doc.axes,
    free.filter((i) => !doc.axes[i].isText),
  );
  const mapX = x >= 0 ? x : most(doc.axes, free);
  const rest = free.filter((i) => i !== mapX);
  const mapY = rest.includes(doc.detectorAxis) ? doc.detectorAxis : most(doc.axes, rest);
  return { mapX, mapY };
}

/** @param {import('./document.js').Doc} doc @returns {View} */
export function defaultView(doc) {
  const roles = defaultRoles(doc);
  const at = defaultAt(doc);
  const all = quantities(doc);
  const has = (id) => all.some((quantity) => quantity.id === id);
  return {
    roles,
    at,
    quantity: has('time:step') ? 'time:step' : has('time:detect') ? 'time:detect' : (all[0]?.id ?? ''),
    statistic: 'mean',
    xScale: 'auto',
    yScale: 'auto',
    highlight: -1,
    cycles: isWide(doc, roles, at) ? 'points' : 'phases',
    error: doc.raw.fronts?.[0]?.error ?? '',
    ...defaultMap(doc),
    section: '',
  };
}

/** Gives an axis a role. If only one axis may have it, the axis that had it gets the other role. @param {View} view */
export function assign(view, axis, role) {
  const roles = [...view.roles];
  const holder = single.has(role) ? roles.indexOf(role) : -1;
  if (holder >= 0 && holder !== axis) roles[holder] = roles[axis];
  roles[axis] = role;
  return { ...view, roles, highlight: roles.indexOf('colour') === view.roles.indexOf('colour') ? view.highlight : -1 };
}

const choices = (doc) => ({
  quantity: quantities(doc).map((quantity) => quantity.id),
  statistic: doc.phases.length ? [...new Set(doc.phases.flatMap((phase) => statisticsOf(doc, phase.name)))] : ['mean'],
  xScale: ['auto', 'linear', 'log'],
  yScale: ['auto', 'linear', 'log'],
  cycles: ['phases', 'lines', 'points'],
  error: (doc.raw.fronts ?? []).map((front) => front.error),
});
const texts = ['quantity', 'statistic', 'xScale', 'yScale', 'cycles', 'error', 'section'];

/**
 * Encodes the differences from the defaults for the address.
 * @param {import('./document.js').Doc} doc
 * @param {View} view
 */
export function encode(doc, view) {
  const base = defaultView(doc);
  const entries = new URLSearchParams();
  doc.axes.forEach((axis, i) => {
    if (view.roles[i] !== base.roles[i]) entries.append(`role.${axis.name}`, view.roles[i]);
    if (view.at[i] !== base.at[i]) entries.append(`at.${axis.name}`, String(view.at[i]));
  });
  for (const key of texts) if (view[key] !== base[key]) entries.append(key, view[key]);
  if (view.highlight >= 0) entries.append('highlight', String(view.highlight));
  for (const key of ['mapX', 'mapY']) if (view[key] !== base[key]) entries.append(key, doc.axes[view[key]]?.name ?? '');
  return entries.toString();
}

/** The first entry of an address that no part of a view takes: `quantity=time:detekt`; null if there is none. */
export function unknownEntry(docs, text) {
  for (const [key, value] of new URLSearchParams(text)) {
    const fits = (doc) => {
      const [prefix, name] = key.split(/\.(.*)/);
      const axis = doc.axes.find((candidate) => candidate.name === name);
      if (prefix === 'role') return axis && roleNames.includes(value);
      if (prefix === 'at') return axis && /^\d+$/.test(value) && Number(value) < axis.values.length;
      if (['mapX', 'mapY'].includes(key)) return doc.axes.some((candidate) => candidate.name === value);
      if (key === 'highlight') return /^\d+$/.test(value);
      return key === 'section' || Boolean(choices(doc)[key]?.includes(value));
    };
    if (!docs.some(fits)) return `${key}=${value}`;
  }
  return null;
}

/** Decodes the parts of an address that apply to the document; the rest has defaults. @returns {View} */
export function decode(doc, text) {
  const entries = new URLSearchParams(text);
  const view = defaultView(doc);
  const allowed = choices(doc);
  doc.axes.forEach((axis, i) => {
    const role = entries.get(`role.${axis.name}`);
    if (roleNames.includes(role)) view.roles[i] = role;
    const at = entries.get(`at.${axis.name}`);
    if (/^\d+$/.test(at ?? '') && Number(at) < axis.values.length) view.at[i] = Number(at);
  });
  view.roles.forEach((role, i) => {
    if (single.has(role) && view.roles.indexOf(role) !== i) view.roles[i] = 'pooled';
  });
  for (const [key, values] of Object.entries(allowed))
    if (values.includes(entries.get(key))) view[key] = entries.get(key);
  for (const key of ['mapX', 'mapY'])
    if (entries.has(key)) view[key] = doc.axes.findIndex((axis) => axis.name === entries.get(key));
  const highlight = entries.get('highlight');
  if (/^\d+$/.test(highlight ?? '') && Number(highlight) < (doc.axes[view.roles.indexOf('colour')]?.values.length ?? 0))
    view.highlight = Number(highlight);
  if (view.mapX === view.mapY) view.mapY = -1;
  if (/^[a-z-]{1,40}$/.test(entries.get('section') ?? '')) view.section = entries.get('section');
  return view;
}
