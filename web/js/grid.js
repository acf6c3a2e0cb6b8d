// The ground of a path picture: a grid with round steps and numbers, and the three directions.

import { decimals, fixed, niceStep } from "./format.js";

/** @import { Box, Camera, Plane, Projection } from "./camera.js" */
/** @import { Palette } from "./theme.js" */

const LABEL_EVERY = 72;
const EDGE = 4;
/** Free room around a number. */
const CLEAR = 3;

/** For each fixed look: the coordinates of the world that are the picture's x and y. @type {Record<Plane, [number, number]>} */
const PLANES = { top: [0, 1], front: [0, 2], side: [1, 2] };

/** Writes numbers that are inside the picture and do not touch each other: of two that would, the first stays. */
class Labels {
  /** The boxes of the numbers: left, top, right, bottom. @type {[number, number, number, number][]} */
  #taken = [];

  /** @param {CanvasRenderingContext2D} context */
  constructor(context) {
    this.context = context;
    const { canvas } = context;
    const { a: ratio } = context.getTransform();
    this.width = canvas.width / ratio;
    this.height = canvas.height / ratio;
  }

  /** Writes a text at a place with the alignment of the context, if there is room for it. @param {string} text @param {number} x @param {number} y */
  write(text, x, y) {
    const { width, actualBoundingBoxLeft: left, actualBoundingBoxAscent: above, actualBoundingBoxDescent: below } = this.context.measureText(text);
    /** @type {[number, number, number, number]} */
    const box = [x - left - CLEAR, y - above - CLEAR, x - left + width + CLEAR, y + below + CLEAR];
    if (box[0] < -CLEAR || box[1] < -CLEAR || box[2] > this.width + CLEAR || box[3] > this.height + CLEAR) return;
    if (this.#taken.some((other) => box[0] < other[2] && other[0] < box[2] && box[1] < other[3] && other[1] < box[3])) return;
    this.#taken.push(box);
    this.context.fillText(text, x, y);
  }
}

/**
 * Draws the grid of a look along an axis over the whole picture, with numbers at its edges.
 * @param {CanvasRenderingContext2D} context
 * @param {Camera} camera
 * @param {Plane} plane
 * @param {Palette} colours
 * @param {string[]} names
 */
export function flatGrid(context, camera, plane, colours, names) {
  const [across, along] = PLANES[plane];
  const step = niceStep(LABEL_EVERY / camera.scale);
  const places = decimals(step);
  const { width, tall, scale, centre } = camera;
  const sign = plane === "side" ? camera.axes().right[1] : camera.axes().right[0];
  const x = (/** @type {number} */ value) => width / 2 + sign * scale * (value - centre[across]);
  const y = (/** @type {number} */ value) => tall / 2 - scale * (value - centre[along]);
  const span = (/** @type {number} */ size, /** @type {number} */ middle) => {
    const half = size / 2 / scale;
    return [Math.ceil((middle - half) / step), Math.floor((middle + half) / step)];
  };
  const labels = new Labels(context);
  context.lineWidth = 1;
  context.font = `11px ${colours.font}`;
  for (const [vertical, [from, to]] of /** @type {const} */ ([[true, span(width, centre[across])], [false, span(tall, centre[along])]])) {
    for (let k = from; k <= to; k++) {
      const at = Math.round((vertical ? x : y)(k * step)) + 0.5;
      context.strokeStyle = k === 0 ? colours.line : colours.grid;
      context.beginPath();
      context.moveTo(vertical ? at : 0, vertical ? 0 : at);
      context.lineTo(vertical ? at : width, vertical ? tall : at);
      context.stroke();
      context.fillStyle = colours.faint;
      context.textAlign = vertical ? "center" : "left";
      context.textBaseline = vertical ? "bottom" : "middle";
      if (vertical ? at > 60 : at < tall - 24) labels.write(fixed(k * step, places), vertical ? at : EDGE, vertical ? tall - EDGE : at);
    }
  }
  context.fillStyle = colours.muted;
  context.textAlign = "right";
  context.textBaseline = "bottom";
  context.fillText(`${names[across] ?? ""} →`, width - 8, tall - 20);
  context.fillText(names[along] ? `↑ ${names[along]}` : "", width - 8, tall - 36);
}

/**
 * Draws a grid on the ground of the third dimension, a little larger than a box.
 * @param {CanvasRenderingContext2D} context
 * @param {Projection} project
 * @param {Box} box
 * @param {Palette} colours
 */
export function groundGrid(context, project, box, colours) {
  const [low, high] = box;
  const span = Math.max(high[0] - low[0], high[1] - low[1], 1e-6);
  const step = niceStep(span / 8);
  const range = (/** @type {number} */ k) => [Math.floor(low[k] / step), Math.ceil(high[k] / step)];
  const [x0, x1] = range(0);
  const [y0, y1] = range(1);
  const ground = Math.min(low[2], 0);
  context.lineWidth = 1;
  const line = (/** @type {number[]} */ a, /** @type {number[]} */ b, /** @type {boolean} */ strong) => {
    context.strokeStyle = strong ? colours.line : colours.grid;
    context.beginPath();
    context.moveTo(...project(a[0], a[1], ground));
    context.lineTo(...project(b[0], b[1], ground));
    context.stroke();
  };
  for (let k = x0; k <= x1; k++) line([k * step, y0 * step], [k * step, y1 * step], k === 0);
  for (let k = y0; k <= y1; k++) line([x0 * step, k * step], [x1 * step, k * step], k === 0);
  context.font = `11px ${colours.font}`;
  context.fillStyle = colours.faint;
  context.textAlign = "center";
  context.textBaseline = "middle";
  const places = decimals(step);
  const labels = new Labels(context);
  for (let k = x0; k <= x1; k += k % 2 ? 1 : 2) labels.write(fixed(k * step, places), ...project(k * step, (y0 - 0.4) * step, ground));
  for (let k = y0; k <= y1; k += k % 2 ? 1 : 2) labels.write(fixed(k * step, places), ...project((x0 - 0.5) * step, k * step, ground));
}

/**
 * Draws the directions of the axes in the lower left corner.
 * @param {CanvasRenderingContext2D} context
 * @param {Camera} camera
 * @param {Palette} colours
 * @param {string[]} names
 * @param {(name: string, k: number) => string} axisColour
 */
export function triad(context, camera, colours, names, axisColour) {
  const { right, up } = camera.axes();
  const [x, y, length] = [46, camera.tall - 46, 26];
  context.lineWidth = 2;
  context.font = `600 11px ${colours.font}`;
  context.textAlign = "center";
  context.textBaseline = "middle";
  names.forEach((name, k) => {
    const [dx, dy] = [right[k] * length, -up[k] * length];
    if (Math.hypot(dx, dy) < 4) return;
    context.strokeStyle = axisColour(name, k);
    context.fillStyle = axisColour(name, k);
    context.beginPath();
    context.moveTo(x, y);
    context.lineTo(x + dx, y + dy);
    context.stroke();
    context.fillText(name, x + dx * 1.4, y + dy * 1.4);
  });
}
