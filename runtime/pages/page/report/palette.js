// Colours, symbols and dashes that colour-blind readers can distinguish (Okabe & Ito 2008), on light and on dark.

/**
 * @typedef {{name: string, ink: string, muted: string, faint: string, grid: string, background: string, colours:
 *   string[], phases: Record<string, string>, highlight?: number}} Theme  highlight: the only series with a colour;
 *   phases: colours of the phases that make up a step
 */
/** @type {Record<'light' | 'dark', Theme>} */
export const themes = {
  light: {
    name: 'light',
    ink: '#1b1e23',
    muted: '#5d6570',
    faint: '#c3c9d0',
    grid: '#dfe3e8',
    background: '#ffffff',
    colours: ['#0072b2', '#d55e00', '#009e73', '#cc79a7', '#a87500', '#3fa7dc', '#333a44', '#8a6fd1'],
    phases: {
      broad: '#0072b2',
      narrow: '#7cc0ea',
      solve: '#e08a2e',
      integrate: '#7a828c',
      detect: '#009e73',
      step: '#1b1e23',
    },
  },
  dark: {
    name: 'dark',
    ink: '#e8eaed',
    muted: '#a2abb6',
    faint: '#49515b',
    grid: '#343b44',
    background: '#15181c',
    colours: ['#56b4e9', '#ff8a3d', '#2ec79b', '#e59cc6', '#e6b422', '#9ad7ff', '#d0d5db', '#b39df0'],
    phases: {
      broad: '#3f97d4',
      narrow: '#a5d8f6',
      solve: '#f0a04b',
      integrate: '#79838f',
      detect: '#2ec79b',
      step: '#e8eaed',
    },
  },
};

const symbols = ['circle', 'square', 'triangle', 'diamond', 'star', 'wye', 'cross'];
const dashes = [null, '6 3', '2 3', '8 3 2 3'];

/** @typedef {{colour: string, symbol: string, dash: string | null}} Style */
/**
 * The style of the series `i`. 56 series differ in colour and symbol.
 * @param {Theme} theme
 * @param {number} i
 * @returns {Style}
 */
export function style(theme, i) {
  const n = Math.max(i, 0);
  const isFaint = theme.highlight >= 0 && theme.highlight !== i;
  return {
    colour: isFaint ? theme.faint : theme.colours[n % theme.colours.length],
    symbol: symbols[n % symbols.length],
    dash: dashes[Math.floor(n / theme.colours.length) % dashes.length],
  };
}

/** Verdicts by increasing severity; `frozen` and worse ones void the timings. */
export const verdicts = [
  { name: 'unknown', code: '?', colour: '#c9ced4' },
  { name: 'stable', code: 'St', colour: '#cfe3f1' },
  { name: 'drifting', code: 'Dr', colour: '#fbe9a9' },
  { name: 'penetrating', code: 'Pe', colour: '#f5cb5c' },
  { name: 'collapsed', code: 'Co', colour: '#e8a33a' },
  { name: 'clamped', code: 'Cl', colour: '#dd8452' },
  { name: 'tunnelled', code: 'Tu', colour: '#cc5a28' },
  { name: 'exploded', code: 'Ex', colour: '#9c2f14' },
  { name: 'frozen', code: 'Fr', colour: '#8f80bd' },
  { name: 'removed', code: 'Re', colour: '#6c5a9e' },
  { name: 'non_finite', code: 'NF', colour: '#4c3a7a' },
  { name: 'timed_out', code: 'TO', colour: '#5b6068' },
  { name: 'crashed', code: 'Cr', colour: '#16181b' },
];
/** The index of a verdict. One that the page does not know counts as `unknown`. @param {string} name */
export const severity = (name) =>
  Math.max(
    verdicts.findIndex((verdict) => verdict.name === name),
    0,
  );

/** Black or white, whichever is legible on a colour. @param {string} colour `#rrggbb` */
export function inkOn(colour) {
  const [red, green, blue] = [1, 3, 5].map((i) => parseInt(colour.slice(i, i + 2), 16) / 255);
  return 0.2126 * red ** 2.2 + 0.7152 * green ** 2.2 + 0.0722 * blue ** 2.2 > 0.3 ? '#14171a' : '#ffffff';
}

/** The line of a budget. */
export const budgetStyle = (theme) => ({
  stroke: theme.ink,
  strokeWidth: 1.5,
  strokeDasharray: '5 3',
  className: 'budget',
});
