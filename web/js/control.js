// Control of objects: one page has it, visibly; the others watch. A stop needs no control.

import { fill, h, icon, state } from "./dom.js";

const SURE_MS = 4000;

/** A bar that shows which page has control of some objects, and takes or gives back control of them. */
export class ControlBar {
  #key = "";
  /** @type {string[]} */
  objects = [];

  /** @param {import("./app.js").App} app @param {string[]} objects */
  constructor(app, objects = []) {
    this.app = app;
    this.element = h("div.control-bar", { role: "status" });
    this.sure = 0;
    this.show(objects);
  }

  /** Shows other objects. @param {string[]} objects */
  show(objects) {
    this.objects = objects;
    this.update();
  }

  /** Whether this page may move all of the objects. */
  get mine() {
    return this.app.store.may("operator") && this.objects.every((object) => this.app.store.drives(object));
  }

  update() {
    const { store } = this.app;
    const missing = this.objects.filter((object) => !store.drives(object));
    const holder = missing.map((object) => store.driver(object)).find((driver) => driver !== null && driver !== store.viewer) ?? null;
    const asked = performance.now() < this.sure;
    const { role, locked, can_log_in: canLogIn } = store.session;
    const may = store.may("operator");
    const key = [...this.objects, "of", ...missing, holder, asked, role, locked, canLogIn].join("|");
    if (key === this.#key) return;
    this.#key = key;
    const focused = this.element.contains(document.activeElement);
    state(this.element, "kind", this.mine && may ? "mine" : holder ? "other" : "free");
    const names = (/** @type {string[]} */ list) => list.join(", ");
    if (!may) fill(this.element, icon("lock"), h("span", {}, locked ? "This page is locked: you may look and stop" : `As ${role} you may look and stop`), canLogIn && !locked && this.#button("Log in", () => this.app.session.open(), "primary"));
    else if (this.mine) fill(this.element, icon("unlock"), h("span", {}, h("b", {}, "You have control of "), names(this.objects)), this.#button("Release", () => this.#release()));
    else if (holder) fill(this.element, icon("lock"), h("span", {}, h("b", {}, holder), ` has control of ${names(missing)}`), this.#takeOver(holder, asked));
    else fill(this.element, icon("lock"), h("span", {}, `No page has control of ${names(missing)}`), this.#button("Take control", () => this.#take(), "primary"));
    if (focused) this.element.querySelector("button")?.focus();
  }

  /** @param {string} title @param {() => void} onclick @param {string} kind */
  #button(title, onclick, kind = "") {
    return h(kind ? `button.${kind}` : "button", { type: "button", onclick }, title);
  }

  /** @param {string} holder @param {boolean} asked */
  #takeOver(holder, asked) {
    if (asked) return this.#button("Take over now", () => this.#take(true), "danger");
    return h("button", { type: "button", title: `Takes control away from ${holder}; a second press confirms it`, onclick: () => {
      this.sure = performance.now() + SURE_MS;
      this.update();
      setTimeout(() => this.update(), SURE_MS + 50);
    } }, "Take over…");
  }

  /** @param {boolean} force */
  async #take(force = false) {
    this.sure = 0;
    for (const object of this.objects.filter((name) => !this.app.store.drives(name))) {
      try {
        await this.app.connection.request("take", { object, ...(force && { force }) });
      } catch (error) {
        this.app.toasts.bad(`Control of ${object} was not granted`, error);
      }
    }
  }

  /** Gives back all control that this page has of the axes of the objects: it may have come with a larger object. */
  async #release() {
    for (const object of new Set(this.objects.flatMap((name) => this.app.store.taken(name)))) {
      try {
        await this.app.connection.request("release", { object });
      } catch (error) {
        this.app.toasts.bad(`Control of ${object} was not released`, error);
      }
    }
  }
}
