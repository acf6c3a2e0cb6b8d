// The legend of a picture that is saved: a heading, and the name and line style of each signal, below the picture.

const LINE = 18;
const SWATCH = 22;
const GAP = 18;
const EDGE = 12;

/**
 * Rows of entries that are at most `width` wide together.
 * @template T
 * @param {T[]} entries
 * @param {(entry: T) => number} wide
 * @param {number} width
 * @returns {T[][]}
 */
export function rows(entries, wide, width) {
  /** @type {T[][]} */
  const out = [];
  let used = Infinity;
  for (const entry of entries) {
    const own = wide(entry);
    if (used + own > width) {
      out.push([]);
      used = 0;
    }
    out[out.length - 1].push(entry);
    used += own;
  }
  return out;
}

/**
 * A copy of a canvas with a legend below it.
 * @param {HTMLCanvasElement} picture
 * @param {number} width Width of the picture in pixels of the style sheet.
 * @param {string} heading
 * @param {{ name: string, unit: string, colour: string, dashes?: number[] }[]} lines
 * @param {import("./theme.js").Palette} colours
 */
export function withLegend(picture, width, heading, lines, colours) {
  const out = document.createElement("canvas");
  const context = /** @type {CanvasRenderingContext2D} */ (out.getContext("2d"));
  const font = `12px ${colours.font}`;
  context.font = font;
  /** @typedef {typeof lines[number]} Line */
  const name = (/** @type {Line} */ line) => `${line.name} (${line.unit})`;
  const wide = (/** @type {Line} */ line) => SWATCH + 6 + context.measureText(name(line)).width + GAP;
  const list = rows(lines, wide, width - 2 * EDGE);
  const height = LINE * (list.length + 1) + 2 * EDGE;
  const ratio = picture.width / width;
  out.width = picture.width;
  out.height = picture.height + Math.round(height * ratio);
  context.fillStyle = colours.canvas;
  context.fillRect(0, 0, out.width, out.height);
  context.drawImage(picture, 0, 0);
  context.setTransform(ratio, 0, 0, ratio, 0, picture.height);
  context.textBaseline = "middle";
  context.fillStyle = colours.text;
  context.font = `600 ${font}`;
  context.fillText(heading, EDGE, EDGE + LINE / 2);
  context.font = font;
  for (const [k, row] of list.entries()) {
    let x = EDGE;
    const y = EDGE + LINE * (k + 1.5);
    for (const line of row) {
      context.strokeStyle = line.colour;
      context.lineWidth = 2;
      context.setLineDash(line.dashes ?? []);
      context.beginPath();
      context.moveTo(x, y);
      context.lineTo(x + SWATCH, y);
      context.stroke();
      context.fillText(name(line), x + SWATCH + 6, y);
      x += wide(line);
    }
  }
  return out;
}
