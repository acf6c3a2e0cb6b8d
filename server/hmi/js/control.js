// The right to drive an object: one viewer has it, visibly; the others watch. Stops need no right.

import { h, icon, fill, state } from "./dom.js";

const SURE_MS = 4000;

/** A bar that shows who drives an object and takes or gives back the right. */
export class ControlBar {
  #key = "";

  constructor(app) {
    this.app = app;
    this.object = null;
    this.element = h("div.control-bar", { role: "status" });
    this.sure = 0;
  }

  /** Shows another object. */
  show(object) {
    this.object = object;
    this.update();
  }

  /** Whether this page may move the object. */
  get mine() {
    return this.app.store.drives(this.object);
  }

  update() {
    const driver = this.app.store.driver(this.object);
    const asked = performance.now() < this.sure;
    const key = [this.object, driver, this.mine, asked].join("|");
    if (key === this.#key) return;
    this.#key = key;
    const focused = this.element.contains(document.activeElement);
    state(this.element, "kind", this.mine ? "mine" : driver ? "other" : "free");
    if (this.mine) fill(this.element, icon("unlock"), h("span", {}, h("b", {}, "You drive "), this.object), this.#button("Release", "release"));
    else if (driver) fill(this.element, icon("lock"), h("span", {}, h("b", {}, driver), ` drives ${this.object}`), this.#takeOver(driver, asked));
    else fill(this.element, icon("lock"), h("span", {}, `Nobody drives ${this.object}`), this.#button("Take control", "take", {}, "primary"));
    if (focused) this.element.querySelector("button")?.focus();
  }

  #button(title, what, fields = {}, kind = "") {
    return h(kind ? `button.${kind}` : "button", { type: "button", onclick: () => this.#ask(what, fields) }, title);
  }

  #takeOver(driver, asked) {
    if (asked) return this.#button(`Take over from ${driver} now`, "take", { force: true }, "danger");
    return h("button", { type: "button", onclick: () => {
      this.sure = performance.now() + SURE_MS;
      this.update();
      setTimeout(() => this.update(), SURE_MS + 50);
    } }, "Take over…");
  }

  async #ask(what, fields) {
    this.sure = 0;
    try {
      await this.app.connection.request(what, { object: this.object, ...fields });
    } catch (error) {
      this.app.toasts.bad(what === "take" ? `${this.object} cannot be driven` : "The right cannot be given back", error);
    }
  }
}
