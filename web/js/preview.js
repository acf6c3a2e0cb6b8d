// The result of a preview or a dry run: duration, the peaks of each axis against its limits, the first limit exceeded.

import { fill, h } from "./dom.js";
import { duration, short } from "./format.js";

/** @import { Simulated } from "../types/protocol.js" */

/** A small table of the facts of a preview; empty without one. */
export class PreviewFacts {
  /** @param {import("./app.js").App} app */
  constructor(app) {
    this.app = app;
    this.element = h("div.preview-facts", { "aria-live": "polite", hidden: true });
  }

  /** Shows a preview or, with `null`, nothing. @param {Simulated | null} preview */
  show(preview) {
    this.element.hidden = !preview;
    if (!preview) return;
    const { limit, duration_s: seconds, ticks } = preview;
    const rows = (preview.peaks ?? []).filter(({ velocity, acceleration }) => velocity > 0 || acceleration > 0).map((peak) => {
      const axis = this.app.store.configuredAxis(peak.axis);
      return h("tr", {}, h("th", { scope: "row" }, peak.axis),
        cell(peak.velocity, axis.max_speed), cell(peak.acceleration, axis.max_acceleration), cell(peak.jerk, axis.max_acceleration_jerk));
    });
    fill(this.element,
      h("p", {}, h("b", {}, "Takes "), seconds === null ? "no end" : duration(seconds), ticks ? ` (${ticks} ticks)` : "",
        limit ? h("span.limit", {}, ` First limit: ${limit.text}`) : h("span.within", {}, rows.length ? " Within every limit." : "")),
      rows.length > 0 && h("table", {}, h("thead", {}, h("tr", {}, ["Peak", "Speed", "Acceleration", "Jerk"].map((name) => h("th", { scope: "col" }, name)))),
        h("tbody", {}, rows)));
  }
}

/** @param {number} value @param {number} limit */
function cell(value, limit) {
  const over = Number.isFinite(limit) && value > limit * (1 + 1e-6);
  return h(over ? "td.number.over" : "td.number", { title: Number.isFinite(limit) ? `limit ${short(limit)}` : null }, short(value));
}
