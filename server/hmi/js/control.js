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
    if (this.mine) fill(this.element, icon("unlock"), h("span", {}, h("b", {}, "You drive "), this.object), this.#button("Release", () => this.#release()));
    else if (driver) fill(this.element, icon("lock"), h("span", {}, h("b", {}, driver), ` drives ${this.object}`), this.#takeOver(driver, asked));
    else fill(this.element, icon("lock"), h("span", {}, `Nobody drives ${this.object}`), this.#button("Take control", () => this.#take(), "primary"));
    if (focused) this.element.querySelector("button")?.focus();
  }

  #button(title, onclick, kind = "") {
    return h(kind ? `button.${kind}` : "button", { type: "button", onclick }, title);
  }

  #takeOver(driver, asked) {
    if (asked) return this.#button(`Take over from ${driver} now`, () => this.#take(true), "danger");
    return h("button", { type: "button", onclick: () => {
      this.sure = performance.now() + SURE_MS;
      this.update();
      setTimeout(() => this.update(), SURE_MS + 50);
    } }, "Take over…");
  }

  async #take(force = false) {
    this.sure = 0;
    try {
      await this.app.connection.request("take", { object: this.object, ...(force && { force }) });
    } catch (error) {
      this.app.toasts.bad(`${this.object} cannot be driven`, error);
    }
  }

  /** Gives back whatever moves the object: the right may have come with that of a larger one. */
  async #release() {
    for (const object of this.app.store.taken(this.object)) {
      try {
        await this.app.connection.request("release", { object });
      } catch (error) {
        this.app.toasts.bad(`${object} cannot be given back`, error);
      }
    }
  }
}
