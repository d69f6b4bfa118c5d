// Files of a figure: SVG and PNG with title, notes and background on white, and CSV of its own data.
import { compose } from './compose.js';
import { csv } from './format.js';
import { themes } from './palette.js';

/**
 * Sizes of exported figures. In print, texts of 11 px become `pt`; the drawing is as wide as they then leave room for.
 * @type {Record<string, {label: string, cm?: number, pt?: number}>}
 */
export const sizes = {
  screen: { label: 'for the screen' },
  column: { label: 'one column: 8.5 cm, 8 pt', cm: 8.5, pt: 8 },
  page: { label: 'two columns: 17.5 cm, 8 pt', cm: 17.5, pt: 8 },
};
/** A size by its name, or a width in print: `84mm`. */
export const sizeOf = (name) => sizes[name] ?? { label: name, cm: parseFloat(name) / 10, pt: 8 };
const screenWidth = 820; // px
const smallText = 11; // px, of labels
const pixelRatio = { screen: 2, print: 4 };

const widthOf = ({ cm, pt }) => (cm ? Math.round(((cm / 2.54) * 72 * smallText) / pt) : screenWidth);

/** @param {Blob} blob @param {string} name */
function download(blob, name) {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(blob);
  link.download = name;
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

/**
 * A figure for the screen has its title, notes and a margin; for print they are left to the caption.
 * @param {(how: {theme: import('./palette.js').Theme, width: number}) => import('./compose.js').Drawing} describe
 */
export function svgText(describe, size = sizes.screen) {
  const width = widthOf(size);
  const isWhole = !size.cm;
  const drawing = describe({ theme: themes.light, width: isWhole ? width - 40 : width });
  const svg = compose(drawing, { width, theme: themes.light, isWhole });
  const height = Number(svg.getAttribute('height'));
  if (size.cm) {
    svg.setAttribute('width', `${size.cm}cm`);
    svg.setAttribute('height', `${((size.cm * height) / width).toFixed(3)}cm`);
  }
  return { text: new XMLSerializer().serializeToString(svg), width, height };
}

async function png(describe, size) {
  const { text, width, height } = svgText(describe, size);
  const ratio = size.cm ? pixelRatio.print : pixelRatio.screen;
  const image = new Image();
  image.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(text)}`;
  await image.decode();
  const canvas = document.createElement('canvas');
  canvas.width = width * ratio;
  canvas.height = height * ratio;
  canvas.getContext('2d').drawImage(image, 0, 0, canvas.width, canvas.height);
  return new Promise((resolve) => canvas.toBlob(resolve, 'image/png'));
}

/** @param {'svg' | 'png' | 'csv'} format @param {string} name  of the file, without its ending */
export async function save(format, name, describe, size = sizes.screen) {
  if (format === 'svg') download(new Blob([svgText(describe, size).text], { type: 'image/svg+xml' }), `${name}.svg`);
  if (format === 'png') download(await png(describe, size), `${name}.png`);
  if (format === 'csv') {
    const { columns, rows } = describe({ theme: themes.light, width: screenWidth });
    download(new Blob([csv(columns, rows)], { type: 'text/csv;charset=utf-8' }), `${name}.csv`);
  }
}
