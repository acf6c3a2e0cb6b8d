// The view of the path: one coordinate system, large, with its numbers over it.

import { h, icon, options, segmented, text, toggle } from "./dom.js";
import { duration, fixed, rate } from "./format.js";
import { BASE, PathCanvas } from "./path_canvas.js";
import { Timebar } from "./timebar.js";

/** @import { Look } from "./camera.js" */

/** @type {[Look, string][]} */
const LOOKS = [["space", "3D"], ["top", "Top"], ["front", "Front"], ["side", "Side"]];
/** @type {[number, string][]} */
const TRAILS = [[5, "5 s"], [20, "20 s"], [60, "1 min"], [600, "10 min"]];

export class Path {
  title = "Path";
  /** This view shows the chosen moment. */
  hasTime = true;
  /** The rows of the axes. @type {{ axis: string, command: HTMLElement, error: HTMLElement }[]} */
  rows = [];
  /** The rows of a robot's tool. @type {{ series: import("./samples.js").Series, place: HTMLElement }[]} */
  tool = [];

  /** @param {import("./app.js").App} app */
  constructor(app) {
    this.app = app;
    const host = h("div.path-canvas");
    this.canvas = new PathCanvas(host, app);
    const names = app.store.machine.coordinate_systems.map((system) => system.name);
    this.choice = h("select", { "aria-label": "Coordinate system", onchange: () => {
      this.#show(this.choice.value);
    } });
    options(this.choice, names);
    this.looks = segmented("Look", LOOKS, "space", (look) => this.canvas.look(look));
    const trail = segmented("Length of the trail", TRAILS, 20, (seconds) => (this.canvas.trailSeconds = seconds));
    this.speed = h("output");
    this.rest = h("small");
    this.readout = h("div.dro", { "aria-label": "Positions" });
    this.legend = this.#legend();
    this.canvas.covers = () => [this.readout, this.legend].filter((over) => over.offsetWidth > 0).map((over) =>
      ({ left: over.offsetLeft, right: over.offsetLeft + over.offsetWidth, bottom: over.offsetTop + over.offsetHeight }));
    this.old = h("p.moment-note", { hidden: true }, "An earlier moment is shown. The paths that are programmed now are not.");
    this.timebar = new Timebar(app, () => [app.timeCursor.shown - this.canvas.trailSeconds / app.samples.period, app.timeCursor.shown]);
    this.clear = h("button", { type: "button", hidden: true, onclick: () => app.setPreview(null), title: "Remove the preview" }, "Clear preview");
    this.element = h("section.view.path", { "aria-label": this.title },
      h("div.toolbar", {}, this.choice, this.looks.element, trail.element, this.#layers(), h("span.spring"),
        h("button", { type: "button", onclick: () => this.canvas.fit() }, icon("fit"), "Fit"),
        this.clear),
      h("div.path-stage", {}, host, this.readout, this.old, this.legend),
      this.timebar.element);
    app.on("preview", () => this.#preview());
    app.timeCursor.on("change", () => {
      this.old.hidden = app.timeCursor.tick === null;
      this.update();
    });
    if (names.length) this.#show(names[0]);
  }

  show() {
    this.canvas.stage.start(() => true);
    this.timebar.start();
    this.update();
  }

  hide() {
    this.canvas.stage.stop();
    this.timebar.stop();
  }

  #layers() {
    /** @type {[keyof PathCanvas["layers"], string][]} */
    const titles = [["path", "Path"], ["trail", "Trail"], ["tolerance", "Tolerances"]];
    const boxes = titles.map(([layer, title]) => {
      const box = h("input", { type: "checkbox", checked: true, onchange: () => {
        this.canvas.layers[layer] = box.checked;
      } });
      return h("label.check", {}, box, title);
    });
    return h("div.choices", { role: "group", "aria-label": "What is drawn" }, boxes);
  }

  #legend() {
    const items = [["path", "active"], ["pending", "pending"], ["trail", "actual"], ["warn", "tolerance"], ["preview", "preview"]];
    return h("ul.legend", { "aria-label": "Colours" }, items.map(([colour, title]) => h("li", {}, h("span", { "data-colour": colour }), title)));
  }

  /** @param {string} name */
  #show(name) {
    this.canvas.show(name);
    const system = this.app.store.configuredSystem(name);
    this.looks.choose(system.axes.length > 2 ? "space" : "top");
    this.rows = system.axes.map((axis) => ({ axis, command: h("output"), error: h("small") }));
    this.tool = (this.app.samples.system(name).tool ?? []).map((series) => ({ series, place: h("output") }));
    const { store } = this.app;
    this.readout.replaceChildren(
      ...this.rows.map(({ axis, command, error }) => h("div", {}, h("span.dro-axis", { "data-series": store.series(axis) }, axis), command, h("abbr", {}, store.configuredAxis(axis).units), error)),
      ...this.tool.map(({ place }, k) => h("div", {}, h("span.dro-axis", { "data-series": k, title: "The tool in the frame of the base" }, BASE[k]), place, h("abbr", {}, store.toolUnits()))),
      h("div.dro-speed", {}, h("span.dro-axis", {}, "v"), this.speed, h("abbr", {}, rate(store.axis(system.axes[0])?.units ?? "", 1)), this.rest));
    this.update();
  }

  #preview() {
    const { preview } = this.app;
    this.clear.hidden = !preview;
    const first = preview?.paths?.[0]?.coordinate_system;
    if (first && first !== this.canvas.system?.name) {
      this.choice.value = first;
      this.#show(first);
    }
    this.canvas.setPreview(preview);
  }

  update() {
    const { store, samples, timeCursor } = this.app;
    const tick = timeCursor.shown;
    for (const { axis, command, error } of this.rows) {
      const kept = samples.axis(axis);
      const status = store.axisStatus(axis);
      const live = timeCursor.tick === null;
      text(command, fixed(live ? status?.actual ?? NaN : kept.actual.at(tick), 3));
      text(error, `Δ ${fixed(live ? status?.error ?? NaN : kept.error.at(tick), 4)}`);
    }
    for (const { series, place } of this.tool) text(place, fixed(series.at(tick), 3));
    const name = this.canvas.system?.name;
    if (name === undefined) return;
    const system = store.systemStatus(name);
    text(this.speed, fixed(timeCursor.tick === null ? system?.speed ?? NaN : samples.system(name).speed.at(tick), 2));
    const active = timeCursor.tick === null ? system?.active : null;
    text(this.rest, active ? `${active.tag} ${Math.round(100 * (active.progress ?? 0))} % · ${duration(active.eta_s ?? NaN)}` : "");
    toggle(this.readout, "old", timeCursor.tick !== null);
  }
}
