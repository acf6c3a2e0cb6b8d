// The view of events: the execution of every instruction, and the cause and remedy of each error.

import { fill, h, icon, segmented } from "./dom.js";
import { clock, duration, timestamp } from "./format.js";
import { standing } from "./executions.js";
import { explanation } from "./toasts.js";

/** @import { Execution } from "./executions.js" */
/** @import { Store } from "./store.js" */
/** @import { FaultEvent } from "../types/protocol.js" */

const SHOWN = 200;

export class Events {
  title = "Events";
  #dirty = true;
  /** The keys of the executions that are opened. @type {Set<Execution["key"]>} */
  #open = new Set();
  /** @type {Map<Execution["key"], { mark: string, element: HTMLElement }>} */
  #drawn = new Map();

  /** @param {import("./app.js").App} app */
  constructor(app) {
    this.app = app;
    this.search = h("input", { type: "search", placeholder: "Tag, instruction, object or fault", "aria-label": "Search events", oninput: () => this.#touch() });
    this.kind = "all";
    const kinds = segmented("Which events", [["all", "All"], ["bad", "Errors"], ["busy", "Running"]], "all", (kind) => {
      this.kind = kind;
      this.#touch();
    });
    this.follow = h("input", { type: "checkbox", checked: true, onchange: () => this.#touch() });
    this.list = h("ol.event-list");
    this.empty = h("p.empty", {}, "No events yet. Instructions from this page and from the network, and faults of axes, appear here.");
    this.element = h("section.view.events", { "aria-label": this.title },
      h("div.toolbar", {}, kinds.element, this.search, h("span.spring"), h("label.check", {}, this.follow, "Follow")),
      this.empty, h("div.scroll.event-scroll", {}, this.list));
    app.executions.on("change", () => (this.#dirty = true));
  }

  show() {
    this.#touch();
  }

  /** Shows one execution, opened. @param {Execution} execution */
  reveal(execution) {
    this.#open.add(execution.key);
    this.#touch();
  }

  #touch() {
    this.#dirty = true;
    this.update();
  }

  update() {
    if (!this.#dirty || (!this.follow.checked && this.list.children.length && this.search !== document.activeElement && this.stale)) return;
    this.#dirty = false;
    this.stale = !this.follow.checked;
    const wanted = this.search.value.trim().toLowerCase();
    const chosen = this.app.executions.list.filter((execution) => {
      if (this.kind !== "all" && standing(execution)[0] !== this.kind) return false;
      return !wanted || `${execution.tag} ${execution.instruction} ${execution.object} ${(execution.fault?.set ?? []).join(" ")}`.toLowerCase().includes(wanted);
    }).slice(-SHOWN).reverse();
    this.empty.hidden = chosen.length > 0;
    const kept = new Map();
    const rows = chosen.map((execution) => {
      const mark = `${execution.steps.length} ${execution.error ? 1 : 0} ${execution.remain?.length ?? 0}`;
      const known = this.#drawn.get(execution.key);
      const row = known?.mark === mark ? known : { mark, element: this.#row(execution) };
      kept.set(execution.key, row);
      return row.element;
    });
    this.#drawn = kept;
    const focused = this.list.contains(document.activeElement);
    if (!focused || rows.some((row, k) => this.list.children[k] !== row)) fill(this.list, rows);
  }

  /** @param {Execution} execution */
  #row(execution) {
    const [kind, word, why] = standing(execution);
    const last = execution.steps[execution.steps.length - 1];
    const toggled = () => {
      if (details.open) this.#open.add(execution.key);
      else this.#open.delete(execution.key);
    };
    const details = h("details", { open: this.#open.has(execution.key), ontoggle: toggled },
      h("summary", {},
        h("time", { title: timestamp(execution.at) }, clock(execution.began, 3)),
        h("b", {}, execution.instruction), h("span.event-tag", {}, execution.tag || "unnamed"), h("span.event-object", {}, execution.object ?? ""),
        h("span.event-took", {}, execution.fault || execution.rest ? "" : duration(last.time_s - execution.began)),
        h("span.pill", { "data-kind": kind }, word),
        execution.error ? h("span.event-error", {}, execution.error.text) : why && h(`span.event-why.${kind}`, {}, why)),
      h("p.event-when", {}, timestamp(execution.at)),
      why && h(`p.event-reason.${kind}`, {}, execution.ended ? `${why}, at ${timestamp(execution.ended.at)} (${clock(execution.ended.time, 3)})` : why),
      execution.fault && faultAdvice(execution.fault, this.app.store),
      execution.error && explanation(execution.error),
      execution.text && h("div.line", {}, h("code", {}, execution.text)),
      h("ol.steps", {}, execution.steps.map((step) => h("li", {},
        h("time", {}, `+${duration(step.time_s - execution.began)}`),
        changes(step).set.map((bit) => h("span.chip.set", {}, bit)), changes(step).clear.map((bit) => h("span.chip.clear", { title: `${bit} cleared` }, bit)),
        h("small", {}, `tick ${step.tick}`)))),
      h("p.event-by", {}, execution.viewer && h("span", {}, `By ${execution.viewer}`),
        h("button", { type: "button", onclick: () => this.#showTime(execution) }, icon("trends"), "Show this moment")));
    return h(`li.event.${kind}`, {}, details);
  }

  /** Shows the trends of the moment in which the execution began, if they are still stored. @param {Execution} execution */
  #showTime(execution) {
    const { tick } = execution.steps[execution.steps.length - 1];
    const { samples, timeCursor, toasts } = this.app;
    if (tick < samples.first) {
      toasts.bad("That moment is no longer stored", { text: `The oldest stored moment is ${clock(samples.time(samples.first))}.` });
      return;
    }
    timeCursor.scrub(tick);
    location.hash = "#/trends";
  }
}

/** The bits or faults that an event set and cleared. @param {Execution["steps"][number]} step @returns {{ set: string[], clear: string[] }} */
function changes(step) {
  if ("rest" in step) return { set: [], clear: [] };
  return "fault" in step ? step.fault : step;
}

/** The meaning of each fault that was raised. @param {FaultEvent} fault @param {Store} store */
function faultAdvice({ set, refused }, store) {
  return [...set.map((word) => h("p", {}, store.faultText(word))), refused && h("p", {}, `${refused.text}.`)];
}
