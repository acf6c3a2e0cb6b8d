// The picture of a coordinate system: programmed path, preview, trail, tolerances, present position. Units: position units.
// For a robot it shows the tool, in the frame of the base. It draws the data of the page, and makes no requests to the server.

import { Camera, LOOKS } from "./camera.js";
import { Stage, gestures } from "./canvas.js";
import { flatGrid, groundGrid, triad } from "./grid.js";
import { axisColour, palette } from "./theme.js";

/** @import { Box, Look, Point, Projection } from "./camera.js" */
/** @import { Series } from "./samples.js" */
/** @import { Palette } from "./theme.js" */
/** @import { Circle, Paths, Simulated, SystemConfiguration } from "../types/protocol.js" */

const TRAIL_POINTS = 1600;
const TRAIL_SHADES = 6;
const LEAST_BOX = 10;
/** The names of the directions of a robot's base. */
export const BASE = ["X1", "X2", "X3"];

/** A path picture in `host`. */
export class PathCanvas {
  /** The coordinate system that is shown. @type {SystemConfiguration | null} */
  system = null;
  /** The answer of a preview or dry run. @type {Simulated | null} */
  preview = null;
  /** Length of the trail in seconds. */
  trailSeconds = 20;
  /** Returns the areas that cover the top of the picture: `{left, right, bottom}` in its pixels. @type {() => { left: number, right: number, bottom: number }[]} */
  covers = () => [];
  /** The drawn layers. */
  layers = { path: true, trail: true, tolerance: true };
  #untouched = true;
  /** @type {Box | null} */
  #fitted = null;
  /** @type {Point[]} */
  #points = [];

  /** @param {HTMLElement} host @param {import("./app.js").App} app @param {string} label */
  constructor(host, app, label = "Path of the coordinate system") {
    this.app = app;
    this.camera = new Camera();
    this.stage = new Stage(host, (context, width, height) => this.#draw(context, width, height), {
      tabindex: "0", role: "img", "aria-label": `${label}. Drag to move or turn, wheel to zoom, F to fit.`,
    });
    this.stage.onresize = (width, height) => {
      Object.assign(this.camera, { width, tall: height });
      if (this.#untouched) this.fit();
    };
    gestures(this.stage.element, {
      drag: (dx, dy, event, fingers) => this.#drag(dx, dy, event, fingers),
      zoom: (factor, x, y) => {
        this.camera.zoom(factor, x, y);
        this.#touched();
      },
    });
    this.stage.element.addEventListener("dblclick", () => this.fit());
    this.stage.element.addEventListener("keydown", (event) => this.#key(event));
  }

  /** Shows a coordinate system, from above or in space. @param {string} name @param {Look | null} look */
  show(name, look = null) {
    this.system = this.app.store.configuredSystem(name);
    this.look(look ?? (this.system.axes.length > 2 ? "space" : "top"));
  }

  /** Takes one of the fixed looks. @param {Look} name */
  look(name) {
    this.camera.look(LOOKS[name]);
    this.fit();
  }

  /** Shows everything. */
  fit() {
    if (!this.system) return;
    this.#points = this.#trail();
    const box = this.#box();
    this.#fitted = this.#place() && box;
    this.camera.fit(box, this.covers());
    this.#untouched = true;
    this.stage.touch();
  }

  /** Shows a preview, whole. @param {Simulated | null} preview */
  setPreview(preview) {
    this.preview = preview;
    if (preview || this.#untouched) this.fit();
    this.stage.touch();
  }

  #touched() {
    this.#untouched = false;
    this.stage.touch();
  }

  /** @param {number} dx @param {number} dy @param {PointerEvent} event @param {number} fingers */
  #drag(dx, dy, event, fingers) {
    const panning = fingers > 1 || event.shiftKey || event.buttons !== 1 || this.camera.plane !== null;
    if (panning) this.camera.pan(dx, dy);
    else this.camera.orbit(dx, dy);
    this.#touched();
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    const step = 40;
    /** @type {Partial<Record<string, [number, number]>>} */
    const moves = { ArrowLeft: [step, 0], ArrowRight: [-step, 0], ArrowUp: [0, step], ArrowDown: [0, -step] };
    const middle = [this.camera.width / 2, this.camera.tall / 2];
    const move = moves[event.key];
    if (move) {
      if (event.shiftKey || this.camera.plane) this.camera.pan(...move);
      else this.camera.orbit(...move);
    } else if (event.key === "+" || event.key === "=") this.camera.zoom(1.25, middle[0], middle[1]);
    else if (event.key === "-") this.camera.zoom(0.8, middle[0], middle[1]);
    else if (event.key === "f" || event.key === "F") {
      this.fit();
      return;
    } else return;
    event.preventDefault();
    this.#touched();
  }

  /** The trail as points of three numbers, oldest first, up to the moment that is shown. */
  #trail() {
    const { samples, timeCursor } = this.app;
    const axes = this.#series();
    const end = timeCursor.tick ?? samples.end - 1;
    const span = Math.round(this.trailSeconds / samples.period);
    const step = Math.max(1, Math.ceil(span / TRAIL_POINTS));
    const from = Math.max(samples.first, end - span);
    // Points that would fall on the same pixel are one: a rest does not use up the shades.
    const least = 0.4 / this.camera.scale;
    const points = [];
    /** @type {number[] | null} */
    let last = null;
    for (let tick = Math.ceil(from / step) * step; tick < end; tick += step) {
      const next = point(axes, tick);
      if (last && Math.hypot(next[0] - last[0], next[1] - last[1], next[2] - last[2]) < least) continue;
      points.push(next);
      last = next;
    }
    if (end >= samples.first && end >= 0) points.push(point(axes, end));
    return points;
  }

  /** The series of the trail: the actual positions of the axes, or of the tool. */
  #series() {
    const { samples } = this.app;
    if (!this.system) return [];
    return samples.system(this.system.name).tool ?? this.system.axes.slice(0, 3).map((name) => samples.axis(name).actual);
  }

  /** The directions of the picture. */
  #names() {
    return this.system?.robot ? BASE : this.system?.axes ?? [];
  }

  /** The position at the displayed moment; `null` before the first sample. */
  #place() {
    const { samples, timeCursor, store } = this.app;
    if (!this.system) return null;
    const end = timeCursor.tick ?? samples.end - 1;
    const place = point(this.#series(), end);
    if (place.every(Number.isFinite)) return place;
    if (this.system.robot) return null;
    return store.status && spread(this.system.axes.map((name) => store.axisStatus(name)?.actual ?? 0));
  }

  /** The programmed paths are those of the present: an earlier moment has none. @returns {Paths} */
  #paths() {
    const path = this.app.timeCursor.tick === null && this.system ? this.app.store.systemStatus(this.system.name)?.path : null;
    return path ?? { active: [], pending: [], tolerance: [] };
  }

  #previewPaths() {
    return (this.preview?.paths ?? []).filter((path) => path.coordinate_system === this.system?.name);
  }

  /** The least and the greatest coordinates of all that is drawn. @returns {Box} */
  #box() {
    /** @type {Point} */
    const low = [Infinity, Infinity, Infinity];
    /** @type {Point} */
    const high = [-Infinity, -Infinity, -Infinity];
    const take = (/** @type {number[]} */ p) => spread(p).forEach((value, k) => {
      if (!Number.isFinite(value)) return;
      low[k] = Math.min(low[k], value);
      high[k] = Math.max(high[k], value);
    });
    if (this.system) {
      const { active, pending } = this.#paths();
      [active, ...pending].flat().forEach(take);
      this.#previewPaths().flatMap((path) => path.points).forEach(take);
      this.#points.forEach(take);
      const place = this.#place();
      if (place) take(place);
    }
    for (let k = 0; k < 3; k++) {
      if (!Number.isFinite(low[k])) low[k] = high[k] = 0;
      // A flat picture needs no height of its own.
      if (high[k] - low[k] < LEAST_BOX && (k < 2 || high[k] > low[k])) {
        const middle = (low[k] + high[k]) / 2;
        low[k] = Math.min(low[k], middle - LEAST_BOX / 2);
        high[k] = Math.max(high[k], middle + LEAST_BOX / 2);
      }
    }
    return [low, high];
  }

  /** @param {CanvasRenderingContext2D} context @param {number} width @param {number} height */
  #draw(context, width, height) {
    const colours = palette();
    context.fillStyle = colours.canvas;
    context.fillRect(0, 0, width, height);
    if (!this.system) return;
    this.#points = this.layers.trail ? this.#trail() : [];
    const box = this.#box();
    if (this.#untouched) this.#keepInside(box);
    const project = this.camera.projection();
    const { plane } = this.camera;
    if (plane) flatGrid(context, this.camera, plane, colours, this.#names());
    else groundGrid(context, project, this.#fitted ?? box, colours);
    context.lineJoin = "round";
    context.lineCap = "round";
    const { active, pending, tolerance } = this.#paths();
    if (this.layers.path) {
      context.setLineDash([7, 5]);
      for (const line of pending) stroke(context, project, line, colours.pending, 1.75);
      context.setLineDash([]);
      stroke(context, project, active, colours.path, 3);
    }
    // Over the path, so that it shows how far the move has come.
    if (this.layers.trail) this.#drawTrail(context, project, colours);
    if (this.layers.tolerance) circles(context, project, this.camera.scale, tolerance, colours.warn);
    for (const path of this.#previewPaths()) {
      stroke(context, project, path.points, colours.preview, 2.25);
      if (this.layers.tolerance) circles(context, project, this.camera.scale, path.blends, colours.preview);
      ends(context, project, path.points, colours.preview);
    }
    this.#drawPlace(context, project, colours);
    if (!plane) triad(context, this.camera, colours, this.#names(), (name, k) => axisColour(this.system?.robot ? k : this.app.store.place(name)));
  }

  /** Until a person moves the picture, it grows with the points that it shows; it does not shrink by itself. @param {Box} shown */
  #keepInside([low, high]) {
    const [left, right] = this.#fitted ?? [low, high];
    const outside = low.some((value, k) => value < left[k] - 1e-9 || high[k] > right[k] + 1e-9);
    if (this.#fitted && !outside) return;
    /** @type {Box} */
    const box = [spread(low.map((value, k) => Math.min(value, left[k]))), spread(high.map((value, k) => Math.max(value, right[k])))];
    this.#fitted = this.#place() && box;
    this.camera.fit(box, this.covers());
  }

  /** @param {CanvasRenderingContext2D} context @param {Projection} project @param {Palette} colours */
  #drawTrail(context, project, colours) {
    const points = this.#points;
    const part = Math.ceil(points.length / TRAIL_SHADES);
    for (let shade = 0; shade < TRAIL_SHADES && part > 0; shade++) {
      context.globalAlpha = (shade + 1) / TRAIL_SHADES;
      stroke(context, project, points.slice(Math.max(0, shade * part - 1), (shade + 1) * part), colours.trail, 2);
    }
    context.globalAlpha = 1;
  }

  /** @param {CanvasRenderingContext2D} context @param {Projection} project @param {Palette} colours */
  #drawPlace(context, project, colours) {
    const place = this.#place();
    if (!place) return;
    const [x, y] = project(...place);
    context.strokeStyle = colours.text;
    context.lineWidth = 1;
    context.beginPath();
    for (const [dx, dy] of [[1, 0], [-1, 0], [0, 1], [0, -1]]) {
      context.moveTo(x + 8 * dx, y + 8 * dy);
      context.lineTo(x + 15 * dx, y + 15 * dy);
    }
    context.stroke();
    context.beginPath();
    context.arc(x, y, 5, 0, 2 * Math.PI);
    context.fillStyle = colours.text;
    context.fill();
    context.lineWidth = 2;
    context.strokeStyle = colours.canvas;
    context.stroke();
  }
}

/** @param {number[]} values @returns {Point} */
function spread(values) {
  return [values[0] ?? 0, values[1] ?? 0, values[2] ?? 0];
}

/** @param {Series[]} axes @param {number} tick */
function point(axes, tick) {
  return spread(axes.map((series) => series.at(tick)));
}

/** @param {CanvasRenderingContext2D} context @param {Projection} project @param {number[][]} points @param {string} colour @param {number} width */
function stroke(context, project, points, colour, width) {
  if (points.length < 2) return;
  context.strokeStyle = colour;
  context.lineWidth = width;
  context.beginPath();
  let pen = false;
  for (const [a, b, c] of points) {
    const [x, y] = project(a, b ?? 0, c ?? 0);
    if (!Number.isFinite(x) || !Number.isFinite(y)) pen = false;
    else if (pen) context.lineTo(x, y);
    else {
      context.moveTo(x, y);
      pen = true;
    }
  }
  context.stroke();
}

/**
 * Tolerances are spheres, so every look shows them as circles.
 * @param {CanvasRenderingContext2D} context
 * @param {Projection} project
 * @param {number} scale
 * @param {Circle[]} list
 * @param {string} colour
 */
function circles(context, project, scale, list, colour) {
  context.strokeStyle = colour;
  context.lineWidth = 1.25;
  for (const { centre, radius } of list) {
    const [x, y] = project(...spread(centre));
    context.beginPath();
    context.arc(x, y, Math.max(radius * scale, 2), 0, 2 * Math.PI);
    context.stroke();
  }
}

/** @param {CanvasRenderingContext2D} context @param {Projection} project @param {number[][]} points @param {string} colour */
function ends(context, project, points, colour) {
  const last = points.at(-1);
  if (!last) return;
  const [x, y] = project(...spread(last));
  context.fillStyle = colour;
  context.fillRect(x - 3.5, y - 3.5, 7, 7);
}
