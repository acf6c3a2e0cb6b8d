// The strip below the pictures: the whole history at a glance, the moment that is shown, pause and live.

import { Stage, gestures } from "./canvas.js";
import { h, icon, fill, state, text } from "./dom.js";
import { clock, duration } from "./format.js";
import { palette } from "./theme.js";

const HEIGHT = 36;

/** A time bar; `window()` gives the ticks that the view beside it shows, or `null`. */
export class Timebar {
  /** @type {boolean | null} */
  #shown = null;

  /** @param {import("./app.js").App} app @param {() => number[] | null} window */
  constructor(app, window = () => null) {
    this.app = app;
    this.window = window;
    this.button = h("button.timebar-button", { type: "button", onclick: () => this.#toggle() });
    this.label = h("output.timebar-time", { "aria-live": "off" });
    const strip = h("div.timebar-strip");
    this.element = h("div.timebar", {}, this.button, strip, this.label);
    this.stage = new Stage(strip, (context, width) => this.#draw(context, width), {
      tabindex: "0", role: "slider", "aria-label": "Moment that is shown", "aria-valuemin": "0", "aria-valuemax": "0", "aria-valuenow": "0",
    });
    gestures(this.stage.element, {
      start: (event) => this.#to(event.offsetX),
      drag: (_dx, _dy, event) => this.#to(event.offsetX),
      zoom: () => {},
    });
    this.stage.element.addEventListener("keydown", (event) => this.#key(event));
    app.timeCursor.on("change", () => this.#tell());
    this.#tell();
  }

  start() {
    this.stage.start(() => true);
  }

  stop() {
    this.stage.stop();
  }

  #toggle() {
    if (this.app.timeCursor.tick === null) this.app.timeCursor.pause();
    else this.app.timeCursor.live();
  }

  /** @param {number} x */
  #to(x) {
    const { first, end } = this.app.samples;
    const share = Math.min(1, Math.max(0, x / this.stage.width));
    this.app.timeCursor.scrub(first + share * (end - 1 - first));
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    const second = Math.round(1 / this.app.samples.period);
    /** @type {Partial<Record<string, number>>} */
    const steps = { ArrowLeft: -1, ArrowRight: 1, PageUp: -second, PageDown: second };
    const { timeCursor, samples } = this.app;
    const step = steps[event.key];
    if (step) timeCursor.scrub(timeCursor.shown + step * (event.shiftKey ? second / 10 : 1));
    else if (event.key === "Home") timeCursor.scrub(samples.first);
    else if (event.key === "End") timeCursor.live();
    else if (event.key === " ") this.#toggle();
    else return;
    event.preventDefault();
  }

  #tell() {
    const paused = this.app.timeCursor.tick !== null;
    if (this.#shown === paused) return;
    this.#shown = paused;
    fill(this.button, icon(paused ? "live" : "pause"), paused ? "Live" : "Pause");
    state(this.element, "paused", String(paused));
  }

  /** @param {CanvasRenderingContext2D} context @param {number} width */
  #draw(context, width) {
    const { samples, timeCursor } = this.app;
    const colours = palette();
    const { first, end } = samples;
    context.fillStyle = colours.canvas;
    context.fillRect(0, 0, width, HEIGHT);
    const span = Math.max(end - first, 1);
    const x = (/** @type {number} */ tick) => ((tick - first) / span) * width;
    const bucket = span > 128 * width ? 256 : 16;
    const step = Math.max(bucket, Math.ceil(span / width / bucket) * bucket);
    const pair = [0, 0];
    for (const { speed } of samples.systems) {
      let most = 1e-9;
      const tops = [];
      for (let tick = Math.floor(first / step) * step; tick < end; tick += step) {
        speed.extrema(tick, tick + step, bucket, pair);
        tops.push([tick, pair[1]]);
        if (pair[1] > most) most = pair[1];
      }
      context.fillStyle = colours.accent;
      context.globalAlpha = 0.4;
      for (const [tick, value] of tops) {
        if (value > 0) context.fillRect(x(tick), HEIGHT - (HEIGHT - 6) * (value / most), Math.max(1, (step / span) * width), HEIGHT);
      }
      context.globalAlpha = 1;
    }
    const shown = this.window();
    if (shown) {
      context.fillStyle = colours.text;
      context.globalAlpha = 0.09;
      context.fillRect(x(Math.max(shown[0], first)), 0, Math.max(2, x(shown[1]) - x(Math.max(shown[0], first))), HEIGHT);
      context.globalAlpha = 1;
    }
    context.fillStyle = timeCursor.tick === null ? colours.ok : colours.warn;
    context.fillRect(Math.min(width - 2, Math.max(0, x(timeCursor.shown) - 1)), 0, 2, HEIGHT);
    const ago = (end - 1 - timeCursor.shown) * samples.period;
    const time = timeCursor.tick === null ? `live ${clock(samples.time(timeCursor.shown), 1)}` : `${duration(ago)} ago`;
    text(this.label, time);
    const { element } = this.stage;
    element.setAttribute("aria-valuemax", String(Math.max(end - 1 - first, 0)));
    element.setAttribute("aria-valuenow", String(timeCursor.shown - first));
    element.setAttribute("aria-valuetext", time);
  }
}
