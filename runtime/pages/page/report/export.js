// Files of a figure: SVG and PNG with title, notes and background on white, and CSV of its own data.
import { compose } from './compose.js';
import { csv } from './format.js';
import { themes } from './palette.js';

const exportWidth = 820;
const pixelRatio = 2;

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

/** @param {(how: {theme: import('./palette.js').Theme, width: number}) => import('./compose.js').Drawing} describe */
export function svgText(describe) {
  const drawing = describe({ theme: themes.light, width: exportWidth - 40 });
  const svg = compose(drawing, { width: exportWidth, theme: themes.light, isWhole: true });
  return {
    text: new XMLSerializer().serializeToString(svg),
    width: exportWidth,
    height: Number(svg.getAttribute('height')),
  };
}

async function png(describe) {
  const { text, width, height } = svgText(describe);
  const image = new Image();
  image.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(text)}`;
  await image.decode();
  const canvas = document.createElement('canvas');
  canvas.width = width * pixelRatio;
  canvas.height = height * pixelRatio;
  canvas.getContext('2d').drawImage(image, 0, 0, canvas.width, canvas.height);
  return new Promise((resolve) => canvas.toBlob(resolve, 'image/png'));
}

/** @param {'svg' | 'png' | 'csv'} format @param {string} name  of the file, without its ending */
export async function save(format, name, describe) {
  if (format === 'svg') download(new Blob([svgText(describe).text], { type: 'image/svg+xml' }), `${name}.svg`);
  if (format === 'png') download(await png(describe), `${name}.png`);
  if (format === 'csv') {
    const { columns, rows } = describe({ theme: themes.light, width: exportWidth });
    download(new Blob([csv(columns, rows)], { type: 'text/csv;charset=utf-8' }), `${name}.csv`);
  }
}
