// The view of signals over time: lanes, cursors with values, scrubbing, export.

import { Stage, gestures } from "./canvas.js";
import { h, icon, fill, segmented, seldom, state, text } from "./dom.js";
import { csv, fileName, save, savePicture } from "./export.js";
import { clock, duration, rate, short, timestamp } from "./format.js";
import { keep } from "./keep.js";
import { withLegend } from "./legend.js";
import { drawCoarse, drawCursor, drawLanes, tickAt } from "./plot.js";
import { KINDS } from "./samples.js";
import { SERIES, SYSTEMS, axisColour, dashes, onchange, palette, seriesOf, systemColour } from "./theme.js";
import { Timebar } from "./timebar.js";

/** @import { Lane, Line } from "./plot.js" */
/** @import { Series } from "./samples.js" */

const KEY = "arcline.trends";
const NARROW = matchMedia("(max-width: 680px)");
/** @type {[number, string][]} */
const SPANS = [[1, "1 s"], [5, "5 s"], [20, "20 s"], [60, "1 min"], [600, "10 min"]];
/** Between two readings of live values, and at most between two pictures. */
const READ_MS = 100;
const SPEED = { kind: "speed", title: "Path speed", order: 1 };
/** A lane never shows less than this much of a value, so that rounding does not look like motion. */
const LEAST = { position: 0.01, velocity: 0.1, acceleration: 1, jerk: 10, error: 0.0002, speed: 0.1 };

export class Trends {
  title = "Trends";
  /** This view shows the chosen moment. */
  hasTime = true;
  #ticks = 20_000;
  /** @type {Lane[]} */
  #lanes = [];
  /** @type {number | null} */
  #hover = null;
  /** @type {(number | null)[]} */
  #cursors = [null, null];
  /** The last picture: its end, what was drawn beside the lanes, and its time. */
  #drawn = { to: NaN, beside: "", at: -Infinity };
  #readingIsDue = seldom(READ_MS);
  /** @type {{ line: Line, cells: HTMLElement[], row: HTMLElement }[]} */
  rows = [];
  /** @type {HTMLElement[]} */
  times = [];

  /** @param {import("./app.js").App} app */
  constructor(app) {
    this.app = app;
    const { machine } = app.store;
    const kept = keep.lists(KEY);
    this.axes = new Set(kept.axes ?? machine.axes.slice(0, 3).map((axis) => axis.name));
    this.kinds = new Set(kept.kinds ?? (NARROW.matches ? ["position", "velocity", "error"] : ["position", "velocity", "acceleration", "error", "speed"]));
    this.systems = new Set(kept.systems ?? machine.coordinate_systems.slice(0, 1).map((system) => system.name));
    const host = h("div.plot");
    this.values = h("div.cursor-values", { tabindex: "0", role: "region", "aria-label": "Values at the cursors" });
    this.spans = segmented("Time that is shown", SPANS, 20, (seconds) => this.#span(seconds / app.samples.period));
    this.timebar = new Timebar(app, () => this.#window());
    this.element = h("section.view.trends", { "aria-label": this.title },
      h("div.toolbar", {}, this.spans.element, h("span.spring"),
        h("button", { type: "button", onclick: () => this.#clear(), title: "Remove both cursors" }, "Clear cursors"),
        h("button", { type: "button", onclick: () => this.#csv() }, icon("save"), "CSV"),
        h("button", { type: "button", onclick: () => this.#png() }, icon("save"), "PNG")),
      h("div.toolbar.series", {}, this.#laneButtons(), this.#seriesButtons()),
      h("div.plot-and-values", {}, host, this.values),
      this.timebar.element);
    this.stage = new Stage(host, (context, width, height) => this.#draw(context, width, height), {
      tabindex: "0", role: "img",
      "aria-label": "Signals over time. Drag to scrub, wheel to zoom, click to set cursor A, with Shift cursor B.",
    });
    gestures(this.stage.element, {
      drag: (dx) => this.#pan(dx),
      zoom: (factor, x) => this.#zoom(factor, x),
      tap: (x, _y, event) => this.#place(x, event.shiftKey ? 1 : 0),
    });
    this.stage.element.addEventListener("pointermove", (event) => {
      this.#hover = event.offsetX;
    });
    this.stage.element.addEventListener("pointerleave", () => {
      this.#hover = null;
    });
    this.stage.element.addEventListener("keydown", (event) => this.#key(event));
    this.#rebuild();
    this.#span(20 / app.samples.period);
    onchange(() => this.#rebuild());
  }

  show() {
    this.stage.start(() => this.#isNew());
    this.timebar.start();
  }

  hide() {
    this.stage.stop();
    this.timebar.stop();
  }

  /** The picture would differ to the eye: it has moved by a pixel, or something beside it has changed. */
  #isNew() {
    const { to, beside, at } = this.#drawn;
    const moved = ((this.#window()[1] - to) / this.#ticks) * this.stage.width;
    return Math.abs(moved) >= 1 || beside !== this.#beside() || performance.now() - at >= READ_MS;
  }

  #beside() {
    return [this.#hover, ...this.#cursors, this.#ticks].join();
  }

  #laneButtons() {
    const buttons = [...KINDS, SPEED].map(({ kind, title }) => this.#choice(this.kinds, kind, title));
    return h("div.choices", { role: "group", "aria-label": "Lanes" }, buttons);
  }

  #seriesButtons() {
    const { machine } = this.app.store;
    const axes = machine.axes.map((axis) => this.#choice(this.axes, axis.name, axis.name, { "data-series": seriesOf(this.app.store.place(axis.name)) }));
    const systems = machine.coordinate_systems.map((system, k) => this.#choice(this.systems, system.name, `${system.name} speed`, { "data-system": k % SYSTEMS }));
    return [h("div.choices", { role: "group", "aria-label": "Axes" }, axes),
      h("div.choices", { role: "group", "aria-label": "Path speeds" }, systems)];
  }

  /** @param {Set<string>} set @param {string} value @param {string} title @param {Record<string, string | number> | null} colour */
  #choice(set, value, title, colour = null) {
    const button = h("button.choice", {
      type: "button", "aria-pressed": String(set.has(value)),
      onclick: () => {
        if (!set.delete(value)) set.add(value);
        button.setAttribute("aria-pressed", String(set.has(value)));
        this.#rebuild();
      },
    }, colour && h("span.swatch", colour), title);
    return button;
  }

  #rebuild() {
    this.stage.touch();
    const { samples, store } = this.app;
    /** @type {Lane[]} */
    const lanes = [];
    const lane = (/** @type {keyof typeof LEAST} */ kind, /** @type {string} */ title, /** @type {Line[]} */ lines) => {
      const unit = [...new Set(lines.map((line) => line.unit))].join(", ");
      if (lines.length) lanes.push({ kind, title, lines, unit, least: LEAST[kind], range: this.#lanes.find((other) => other.kind === kind)?.range });
    };
    for (const { kind, title, order } of KINDS) {
      if (!this.kinds.has(kind)) continue;
      lane(kind, title, store.machine.axes.filter(({ name }) => this.axes.has(name)).map((axis) => ({
        name: `${axis.name} ${title}`, colour: axisColour(store.place(axis.name)), dashes: dashes(store.place(axis.name), SERIES), series: samples.axis(axis.name)[kind], unit: rate(axis.units, order),
      })));
    }
    if (this.kinds.has("speed")) {
      lane("speed", SPEED.title, store.machine.coordinate_systems.filter(({ name }) => this.systems.has(name)).map((system) => ({
        name: `${system.name} path speed`, series: samples.system(system.name).speed,
        colour: systemColour(store.machine.coordinate_systems.indexOf(system)), dashes: dashes(store.machine.coordinate_systems.indexOf(system), SYSTEMS),
        unit: rate(store.axis(system.axes[0])?.units ?? "", 1),
      })));
    }
    this.#lanes = lanes;
    this.#table();
    keep.set(KEY, JSON.stringify({ axes: [...this.axes], kinds: [...this.kinds], systems: [...this.systems] }));
    this.stage?.touch();
  }

  #table() {
    const head = h("tr", {}, h("th", { scope: "col" }, "Signal"), h("th", { scope: "col" }, "A"), h("th", { scope: "col" }, "B"), h("th", { scope: "col" }, "B − A"));
    this.rows = this.#lanes.flatMap(({ lines }) => lines).map((line) => {
      const cells = [h("td"), h("td"), h("td")];
      const swatch = h("span.swatch");
      swatch.style.backgroundColor = line.colour;
      return { line, cells, row: h("tr", {}, h("th", { scope: "row" }, swatch, line.name, h("small", {}, ` ${line.unit}`)), cells) };
    });
    this.times = [h("td"), h("td"), h("td")];
    fill(this.values, h("table", {}, h("thead", {}, head),
      h("tbody", {}, h("tr.times", {}, h("th", { scope: "row" }, "Time"), this.times), this.rows.map(({ row }) => row))));
  }

  /** The ticks that are shown. @returns {[number, number]} */
  #window() {
    const end = this.app.timeCursor.tick === null ? this.app.samples.end : this.app.timeCursor.tick + 1;
    return [end - this.#ticks, end];
  }

  /** @param {number} ticks */
  #span(ticks) {
    const { samples } = this.app;
    this.#ticks = Math.min(samples.capacity, Math.max(16, ticks));
    this.spans.choose(Math.round(this.#ticks * samples.period));
  }

  /** @param {number} dx */
  #pan(dx) {
    if (!dx) return;
    const per = this.#ticks / Math.max(this.stage.width - 74, 1);
    this.app.timeCursor.scrub(this.app.timeCursor.shown - dx * per);
  }

  /** @param {number} factor @param {number} x */
  #zoom(factor, x) {
    const [from, to] = this.#window();
    const tick = tickAt(x, this.stage.width, from, to);
    this.#span(this.#ticks / factor);
    if (this.app.timeCursor.tick === null) return;
    const share = (tick - from) / (to - from);
    this.app.timeCursor.scrub(tick + (1 - share) * this.#ticks);
  }

  /** @param {number} x @param {number} which */
  #place(x, which) {
    this.#cursors[which] = Math.round(tickAt(x, this.stage.width, ...this.#window()));
    this.app.timeCursor.pause();
  }

  #clear() {
    this.#cursors = [null, null];
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    const which = event.shiftKey ? 1 : 0;
    const step = event.key === "ArrowLeft" ? -1 : event.key === "ArrowRight" ? 1 : 0;
    const middle = this.stage.width / 2;
    if (step) {
      this.app.timeCursor.pause();
      this.#cursors[which] = (this.#cursors[which] ?? this.app.timeCursor.shown) + step * (event.altKey ? 10 : 1);
    } else if (event.key === "+" || event.key === "=") this.#zoom(1.25, middle);
    else if (event.key === "-") this.#zoom(0.8, middle);
    else return;
    event.preventDefault();
  }

  /** @param {CanvasRenderingContext2D} context @param {number} width @param {number} height */
  #draw(context, width, height) {
    const { samples } = this.app;
    const colours = palette();
    const [from, to] = this.#window();
    this.#drawn = { to, beside: this.#beside(), at: performance.now() };
    drawLanes(context, width, height, this.#lanes, from, to, samples, colours);
    drawCoarse(context, width, height, samples.coarse, from, to, samples, colours);
    if (!this.#lanes.length) {
      context.fillStyle = colours.muted;
      context.textAlign = "center";
      context.font = `13px ${colours.font}`;
      context.fillText("Select lanes and axes above", width / 2, height / 2);
    }
    if (this.#hover !== null) {
      drawCursor(context, width, height, tickAt(this.#hover, width, from, to), null, from, to, colours.muted, colours);
    }
    this.#cursors.forEach((tick, k) => {
      if (tick !== null) drawCursor(context, width, height, tick, "AB"[k], from, to, k ? colours.warn : colours.accent, colours);
    });
    if (this.#readingIsDue() || this.app.timeCursor.tick !== null) this.#readout(from, to);
  }

  /** @param {number} from @param {number} to */
  #readout(from, to) {
    const { samples } = this.app;
    const free = this.#hover === null ? samples.end - 1 : Math.round(tickAt(this.#hover, this.stage.width, from, to));
    const [a, b] = [this.#cursors[0] ?? (this.app.timeCursor.tick === null ? free : this.app.timeCursor.shown), this.#cursors[1]];
    const time = (/** @type {number | null} */ tick) => (tick === null ? "" : `${short(samples.time(tick))} s`);
    text(this.times[0], time(a));
    text(this.times[1], time(b));
    text(this.times[2], b === null ? "" : duration((b - a) * samples.period));
    for (const { line, cells } of this.rows) {
      const [at, other] = [line.series.at(a), b === null ? NaN : line.series.at(b)];
      text(cells[0], short(at));
      text(cells[1], b === null ? "" : short(other));
      text(cells[2], b === null ? "" : short(other - at));
    }
    state(this.element, "cursors", String(b !== null));
  }

  #csv() {
    const { samples, store } = this.app;
    const [from, to] = this.#window();
    const columns = store.machine.axes.filter(({ name }) => this.axes.has(name)).flatMap(({ name }) => {
      const axis = samples.axis(name);
      const members = { CommandPosition: axis.position, CommandVelocity: axis.velocity, CommandAcceleration: axis.acceleration, ActualPosition: axis.actual };
      return Object.entries(members).map(([member, series]) => ({ name: `${name}.${member}`, /** @type {Series} */ series }));
    });
    for (const name of this.systems) columns.push({ name: `${name}.PathSpeed`, series: samples.system(name).speed });
    save(csv(samples, columns, from, to), fileName("trend", samples, to, "csv"));
  }

  #png() {
    const { samples, store } = this.app;
    const [from, to] = this.#window();
    // The clock of the page: the newest tick is now.
    const until = timestamp(Date.now() - (samples.end - to) * samples.period * 1000);
    const heading = `${store.machine.name} · ${duration((to - from) * samples.period)} until ${until} · machine time ${clock(samples.time(to), 1)}`;
    this.stage.paint();
    const picture = withLegend(this.stage.element, this.stage.width, heading, this.#lanes.flatMap(({ lines }) => lines), palette());
    savePicture(picture, fileName("trend", samples, to, "png"));
  }
}
