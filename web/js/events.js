// The view of what happened: the life of every instruction, and of an error its cause and what to do.

import { fill, h, icon, segmented } from "./dom.js";
import { clock, duration, timestamp } from "./format.js";
import { standing } from "./lives.js";
import { explanation } from "./toasts.js";

const SHOWN = 200;

export class Events {
  title = "Events";
  #dirty = true;
  #open = new Set();
  #drawn = new Map();

  constructor(app) {
    this.app = app;
    this.search = h("input", { type: "search", placeholder: "Tag, instruction, object or fault", "aria-label": "Search events", oninput: () => this.#touch() });
    this.kind = "all";
    const kinds = segmented("Which events", [["all", "All"], ["bad", "Errors"], ["busy", "Running"]], "all", (kind) => {
      this.kind = kind;
      this.#touch();
    });
    this.follow = h("input", { type: "checkbox", checked: true, onchange: () => this.#touch() });
    this.list = h("ol.lives");
    this.empty = h("p.empty", {}, "Nothing yet. Every instruction that is executed, from here or over the network, and every fault appears here.");
    this.element = h("section.view.events", { "aria-label": this.title },
      h("div.toolbar", {}, kinds.element, this.search, h("span.spring"), h("label.check", {}, this.follow, "Follow")),
      this.empty, h("div.scroll.lives-scroll", {}, this.list));
    app.lives.addEventListener("change", () => (this.#dirty = true));
  }

  show() {
    this.#touch();
  }

  /** Shows one life, opened. */
  reveal(life) {
    this.#open.add(life.key);
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
    const chosen = this.app.lives.list.filter((life) => {
      if (this.kind !== "all" && standing(life)[0] !== this.kind) return false;
      return !wanted || `${life.tag} ${life.instruction} ${life.object} ${(life.fault?.set ?? []).join(" ")}`.toLowerCase().includes(wanted);
    }).slice(-SHOWN).reverse();
    this.empty.hidden = chosen.length > 0;
    const kept = new Map();
    const rows = chosen.map((life) => {
      const mark = `${life.steps.length} ${life.error ? 1 : 0} ${life.remain?.length ?? 0}`;
      const known = this.#drawn.get(life.key);
      const row = known?.mark === mark ? known : { mark, element: this.#row(life) };
      kept.set(life.key, row);
      return row.element;
    });
    this.#drawn = kept;
    const focused = this.list.contains(document.activeElement);
    if (!focused || rows.some((row, k) => this.list.children[k] !== row)) fill(this.list, rows);
  }

  #row(life) {
    const [kind, word, why] = standing(life);
    const last = life.steps.at(-1);
    const details = h("details", { open: this.#open.has(life.key), ontoggle: () => (details.open ? this.#open.add(life.key) : this.#open.delete(life.key)) },
      h("summary", {},
        h("time", { title: timestamp(life.at) }, clock(life.began, 3)),
        h("b", {}, life.instruction), h("span.life-tag", {}, life.tag || "unnamed"), h("span.life-object", {}, life.object ?? ""),
        h("span.life-took", {}, life.fault ? "" : duration(last.time_s - life.began)),
        h("span.pill", { "data-kind": kind }, word),
        life.error ? h("span.life-error", {}, life.error.text) : why && h(`span.life-why.${kind}`, {}, why)),
      h("p.life-when", {}, timestamp(life.at)),
      why && h(`p.life-reason.${kind}`, {}, life.ended ? `${why}, at ${timestamp(life.ended.at)} (${clock(life.ended.time, 3)})` : why),
      life.fault && faultAdvice(life.fault, this.app.store),
      life.error && explanation(life.error),
      life.text && h("div.line", {}, h("code", {}, life.text)),
      h("ol.steps", {}, life.steps.map((step) => h("li", {},
        h("time", {}, `+${duration(step.time_s - life.began)}`),
        (step.set ?? step.fault?.set ?? []).map((bit) => h("span.chip.set", {}, bit)), (step.clear ?? step.fault?.clear ?? []).map((bit) => h("span.chip.clear", { title: `${bit} cleared` }, bit)),
        h("small", {}, `tick ${step.tick}`)))),
      h("p.life-by", {}, life.viewer && h("span", {}, `By ${life.viewer}`),
        h("button", { type: "button", onclick: () => this.#moment(life) }, icon("trends"), "Show this moment")));
    return h(`li.life.${kind}`, {}, details);
  }

  /** Shows the trends of the moment in which it began, if they are still kept. */
  #moment(life) {
    const tick = life.steps.at(-1).tick;
    const { samples, moment, toasts } = this.app;
    if (tick < samples.first) {
      toasts.bad("That moment is not kept any more", { text: `The oldest that is kept is ${clock(samples.time(samples.first))}.` });
      return;
    }
    moment.scrub(tick);
    location.hash = "#/trends";
  }
}

/** What each fault that was raised means. */
function faultAdvice({ set, refused }, store) {
  return [...set.map((word) => h("p", {}, store.faultText(word))), refused && h("p", {}, `${refused.text}.`)];
}
