// Stacked lanes of signals over time on a canvas. Time in seconds, values in the units of the lane.
// A column, one pixel wide or a few where there are many lines, shows the least and the greatest value of its ticks, so no peak is lost at any zoom.

import { clock, decimals, duration, fixed, niceStep, short } from "./format.js";
import { Pen } from "./pen.js";

/** @import { Samples, Series } from "./samples.js" */
/** @import { Palette } from "./theme.js" */

/** @typedef {[least: number, greatest: number]} Range */

/**
 * A signal of a lane. `columns` is the memory of its last picture.
 * @typedef {{ name: string, unit: string, colour: string, series: Series, dashes?: number[], columns?: Float64Array }} Line
 */

/**
 * A lane: signals over one scale. The scale stays with it between frames, so that it does not tremble.
 * @typedef {{ kind: string, title: string, unit: string, least: number, lines: Line[], range?: Range }} Lane
 */

/** Room for the numbers at the left and the times below, in pixels. */
export const MARGIN = { left: 62, right: 12, top: 6, bottom: 22, gap: 8 };

const TITLE = 17;
/** Least height of a step between two numbers at the left. */
const LABEL = 24;
/** Columns that one picture has at most over all its lines; with more, each becomes wider. */
const COLUMNS = 24_000;

/** The position of each lane: `{top, height}` in pixels. @param {number} count @param {number} height */
export function places(count, height) {
  const room = height - MARGIN.top - MARGIN.bottom - MARGIN.gap * (count - 1);
  const each = room / Math.max(count, 1);
  return Array.from({ length: count }, (_, k) => ({ top: MARGIN.top + k * (each + MARGIN.gap), height: each }));
}

/** The tick at a pixel. @param {number} x @param {number} width @param {number} from @param {number} to */
export function tickAt(x, width, from, to) {
  return from + ((x - MARGIN.left) / (width - MARGIN.left - MARGIN.right)) * (to - from);
}

/** The pixel of a tick. @param {number} tick @param {number} width @param {number} from @param {number} to */
export function pixelOf(tick, width, from, to) {
  return MARGIN.left + ((tick - from) / (to - from)) * (width - MARGIN.left - MARGIN.right);
}

/**
 * Draws lanes for the ticks `from` to `to`.
 * @param {CanvasRenderingContext2D} context
 * @param {number} width
 * @param {number} height
 * @param {Lane[]} lanes
 * @param {number} from
 * @param {number} to
 * @param {Samples} samples
 * @param {Palette} colours
 */
export function drawLanes(context, width, height, lanes, from, to, samples, colours) {
  context.fillStyle = colours.canvas;
  context.fillRect(0, 0, width, height);
  const room = places(lanes.length, height);
  timeGrid(context, width, height, from, to, samples, colours);
  const lines = lanes.reduce((sum, lane) => sum + lane.lines.length, 0);
  const pixels = Math.max(1, width - MARGIN.left - MARGIN.right);
  const ticks = (to - from) / Math.min(pixels, COLUMNS / Math.max(lines, 1));
  lanes.forEach((lane, k) => {
    const { top, height: tall } = room[k];
    const columns = lane.lines.map((line) => (line.columns = extremaColumns(line.columns, line.series, from, to, ticks)));
    lane.range = settle(lane.range, reach(columns), lane.least);
    drawLane(context, width, lane, columns, { top, tall, from, to, range: lane.range }, colours);
  });
}

/**
 * Least and greatest of each column: `[tick, least, greatest, …]`, in the memory of the last picture if it is enough.
 * @param {Float64Array | undefined} memory
 * @param {Series} series
 * @param {number} from
 * @param {number} to
 * @param {number} ticks of a column, at least
 */
function extremaColumns(memory, series, from, to, ticks) {
  // Columns begin at multiples of their length, so that a moving window does not make them shimmer.
  const bucket = ticks >= 256 ? 256 : ticks >= 8 ? 16 : 1;
  const step = Math.max(1, Math.ceil(ticks / bucket) * bucket);
  const start = Math.floor(from / step) * step;
  const length = 3 * (Math.floor((to + step - start) / step) + 1);
  const out = memory && memory.length >= length ? memory : new Float64Array(length + 96);
  const pair = [0, 0];
  let at = 0;
  for (let tick = start; at < length; tick += step, at += 3) {
    series.extrema(tick, tick + step, bucket, pair);
    out[at] = step === 1 ? tick : tick + step / 2;
    out[at + 1] = pair[0];
    out[at + 2] = pair[1];
  }
  out.fill(NaN, length);
  return out;
}

/** @param {Float64Array[]} columns @returns {[number, number]} */
function reach(columns) {
  let [least, greatest] = [Infinity, -Infinity];
  for (const column of columns) {
    for (let k = 0; k < column.length; k += 3) {
      if (column[k + 1] < least) least = column[k + 1];
      if (column[k + 2] > greatest) greatest = column[k + 2];
    }
  }
  return least <= greatest ? [least, greatest] : [0, 0];
}

/** Grows at once and shrinks only when much room is unused. @param {Range | undefined} range @param {Range} reached @param {number} smallest @returns {Range} */
function settle(range, reached, smallest) {
  const [least, greatest] = reached;
  const middle = (least + greatest) / 2;
  const half = Math.max((greatest - least) / 2, smallest / 2);
  /** @type {Range} */
  const wanted = [middle - half * 1.08, middle + half * 1.08];
  if (!range) return wanted;
  const span = range[1] - range[0];
  const inside = least >= range[0] && greatest <= range[1];
  const small = wanted[1] - wanted[0] < 0.62 * span;
  return inside && !small ? range : wanted;
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {number} width
 * @param {number} height
 * @param {number} from
 * @param {number} to
 * @param {Samples} samples
 * @param {Palette} colours
 */
function timeGrid(context, width, height, from, to, samples, colours) {
  const seconds = (to - from) * samples.period;
  const step = niceStep((seconds * 92) / Math.max(width - MARGIN.left, 1));
  const places = decimals(step);
  context.font = `11px ${colours.font}`;
  context.textAlign = "center";
  context.textBaseline = "bottom";
  context.lineWidth = 1;
  // There is no time before the start of the server.
  const first = Math.max(0, Math.ceil((from * samples.period) / step));
  for (let k = first; k * step <= to * samples.period; k++) {
    const x = Math.round(pixelOf((k * step) / samples.period, width, from, to)) + 0.5;
    context.strokeStyle = colours.grid;
    context.beginPath();
    context.moveTo(x, MARGIN.top);
    context.lineTo(x, height - MARGIN.bottom);
    context.stroke();
    context.fillStyle = colours.faint;
    if (x > MARGIN.left + 16 && x < width - 20) context.fillText(clock(k * step, places), x, height - 4);
  }
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {number} width
 * @param {Lane} lane
 * @param {Float64Array[]} columns
 * @param {{ top: number, tall: number, from: number, to: number, range: Range }} frame
 * @param {Palette} colours
 */
function drawLane(context, width, lane, columns, { top, tall, from, to, range }, colours) {
  const [low, high] = range;
  const y = (/** @type {number} */ value) => top + tall - ((value - low) / (high - low)) * tall;
  const right = width - MARGIN.right;
  const step = niceStep(((high - low) * LABEL) / Math.max(tall, 1));
  const places = decimals(step);
  context.font = `11px ${colours.font}`;
  context.textAlign = "right";
  context.textBaseline = "middle";
  for (let k = Math.ceil(low / step); k * step <= high; k++) {
    const at = Math.round(y(k * step)) + 0.5;
    context.strokeStyle = k === 0 ? colours.line : colours.grid;
    context.beginPath();
    context.moveTo(MARGIN.left, at);
    context.lineTo(right, at);
    context.stroke();
    context.fillStyle = colours.faint;
    if (at > top + 6 && at < top + tall - 2) context.fillText(label(k * step, places), MARGIN.left - 6, at);
  }
  context.strokeStyle = colours.line;
  context.strokeRect(MARGIN.left + 0.5, Math.round(top) + 0.5, right - MARGIN.left - 1, Math.round(tall) - 1);
  context.save();
  context.beginPath();
  context.rect(MARGIN.left, top, right - MARGIN.left, tall);
  context.clip();
  for (const [k, line] of lane.lines.entries()) drawLine(context, columns[k], line, (tick) => pixelOf(tick, width, from, to), y);
  context.restore();
  const title = `${lane.title}  ${lane.unit}`;
  context.font = `600 11px ${colours.font}`;
  const wide = context.measureText(title).width;
  context.globalAlpha = 0.86;
  context.fillStyle = colours.canvas;
  context.fillRect(MARGIN.left + 3, top + 3, wide + 10, TITLE);
  context.globalAlpha = 1;
  context.fillStyle = colours.muted;
  context.textAlign = "left";
  context.fillText(title, MARGIN.left + 8, top + 3 + TITLE / 2);
}

/** @param {number} value @param {number} places */
function label(value, places) {
  return Math.abs(value) >= 1e5 ? short(value) : fixed(value, places);
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {Float64Array} column
 * @param {Line} line
 * @param {(tick: number) => number} x
 * @param {(value: number) => number} y
 */
function drawLine(context, column, { colour, dashes = [] }, x, y) {
  context.strokeStyle = colour;
  context.lineWidth = 1.4;
  context.lineJoin = "bevel";
  context.setLineDash(dashes);
  context.beginPath();
  const pen = new Pen(context);
  let last = 0;
  for (let k = 0; k < column.length; k += 3) {
    const [low, high] = [column[k + 1], column[k + 2]];
    if (Number.isNaN(low)) {
      pen.lift();
      continue;
    }
    const at = x(column[k]);
    const side = k && high !== low ? (at - x(column[k - 3])) / 4 : 0;
    // The nearer end first, so that a falling line is not drawn as a saw.
    const [near, far] = last - low > high - last ? [high, low] : [low, high];
    pen.to(at - side, y(near));
    if (far !== near) pen.to(at + side, y(far));
    last = far;
  }
  pen.lift();
  context.stroke();
  context.setLineDash([]);
}

/**
 * Draws a cursor through all lanes, with its name at the bottom.
 * @param {CanvasRenderingContext2D} context
 * @param {number} width
 * @param {number} height
 * @param {number} tick
 * @param {string | null} name
 * @param {number} from
 * @param {number} to
 * @param {string} colour
 * @param {Palette} colours
 */
export function drawCursor(context, width, height, tick, name, from, to, colour, colours) {
  const x = Math.round(pixelOf(tick, width, from, to)) + 0.5;
  if (x < MARGIN.left || x > width - MARGIN.right) return;
  context.strokeStyle = colour;
  context.lineWidth = 1;
  context.beginPath();
  context.moveTo(x, MARGIN.top);
  context.lineTo(x, height - MARGIN.bottom);
  context.stroke();
  if (!name) return;
  context.fillStyle = colour;
  context.fillRect(x - 8, height - MARGIN.bottom, 16, 16);
  context.font = `700 11px ${colours.font}`;
  context.fillStyle = colours.canvas;
  context.textAlign = "center";
  context.textBaseline = "middle";
  context.fillText(name, x, height - MARGIN.bottom + 8.5);
}

/**
 * Marks below the lanes where only a few ticks at a time are known.
 * @param {CanvasRenderingContext2D} context
 * @param {number} width
 * @param {number} height
 * @param {Samples["coarse"]} coarse
 * @param {number} from
 * @param {number} to
 * @param {Samples} samples
 * @param {Palette} colours
 */
export function drawCoarse(context, width, height, coarse, from, to, samples, colours) {
  for (const part of coarse) {
    const left = pixelOf(Math.max(part.from, from), width, from, to);
    const right = pixelOf(Math.min(part.to, to), width, from, to);
    if (right <= left) continue;
    context.fillStyle = colours.warn;
    context.fillRect(left, height - MARGIN.bottom, right - left, 2);
    const text = `steps of ${duration(part.every * samples.period)}`;
    context.font = `11px ${colours.font}`;
    if (right - left < context.measureText(text).width + 12) continue;
    context.textAlign = "left";
    context.textBaseline = "bottom";
    context.fillText(text, left + 6, height - MARGIN.bottom - 3);
  }
}
