// Hold to move. While a button or key is held the server hears so every 50 ms; whatever lets go, the axis stops:
// release, leaving the window, hiding the page, a cancelled touch, the Esc key, a closed page, a broken network.

import { Emitter } from "./emitter.js";

/** @import { App } from "./app.js" */

const KEEP_MS = 50;

/**
 * All jogs of this page.
 * @extends {Emitter<{ change: void }>}
 */
export class Jogger extends Emitter {
  /** The speeds of the axes that are held. @type {Map<string, number>} */
  #held = new Map();
  #timer = 0;

  /** @param {App} app */
  constructor(app) {
    super();
    this.app = app;
    const endAll = () => this.endAll();
    addEventListener("blur", endAll);
    addEventListener("pagehide", endAll);
    document.addEventListener("visibilitychange", () => document.hidden && endAll());
    app.connection.on("lost", () => this.#forget());
  }

  /** Whether the jog button of an axis is held. @param {string} axis */
  holds(axis) {
    return this.#held.has(axis);
  }

  /** Moves an axis at a speed in units/s, its sign the direction, until `end`. Speed 0 is no jog. @param {string} axis @param {number} speed */
  async begin(axis, speed) {
    if (!speed || this.#held.has(axis) || document.hidden) return;
    this.#held.set(axis, speed);
    if (!this.#timer) this.#timer = setInterval(() => this.#keep(), KEEP_MS);
    this.emit("change", undefined);
    try {
      await this.app.connection.request("jog", { axis, speed });
    } catch (error) {
      this.end(axis);
      this.app.toasts.bad(`${axis} cannot be jogged`, error);
    }
  }

  /** Lets go of an axis. @param {string} axis */
  end(axis) {
    if (!this.#held.delete(axis)) return;
    this.app.connection.tell("jog_end", { axis });
    this.#rest();
  }

  /** Lets go of everything. */
  endAll() {
    for (const axis of [...this.#held.keys()]) this.end(axis);
  }

  #keep() {
    for (const axis of this.#held.keys()) this.#keepOne(axis);
  }

  /** A server that has stopped the axis by itself, since it heard nothing for too long, is believed. @param {string} axis */
  async #keepOne(axis) {
    try {
      await this.app.connection.request("keep", { axis });
    } catch (error) {
      if (!this.#held.has(axis)) return;
      this.end(axis);
      this.app.toasts.bad(`The jog of ${axis} has ended`, error);
    }
  }

  /** The server has stopped the axes by itself. */
  #forget() {
    this.#held.clear();
    this.#rest();
  }

  #rest() {
    if (!this.#held.size) {
      clearInterval(this.#timer);
      this.#timer = 0;
    }
    this.emit("change", undefined);
  }

  /**
   * Makes a button that is held: by pointer, or by Space or Enter while it has the focus.
   * @param {HTMLButtonElement} button
   * @param {string} axis
   * @param {() => number} speed
   */
  attach(button, axis, speed) {
    const end = () => this.end(axis);
    button.addEventListener("pointerdown", (event) => {
      if (event.button !== 0 || button.disabled) return;
      event.preventDefault();
      button.focus();
      button.setPointerCapture(event.pointerId);
      this.begin(axis, speed());
    });
    for (const type of ["pointerup", "pointercancel", "lostpointercapture", "blur"]) button.addEventListener(type, end);
    button.addEventListener("keydown", (event) => {
      // Without a speed, a click on the button makes a step.
      if ((event.key !== " " && event.key !== "Enter") || !speed()) return;
      event.preventDefault();
      if (!event.repeat && !button.disabled) this.begin(axis, speed());
    });
    button.addEventListener("keyup", (event) => (event.key === " " || event.key === "Enter") && end());
    button.addEventListener("contextmenu", (event) => event.preventDefault());
  }
}
