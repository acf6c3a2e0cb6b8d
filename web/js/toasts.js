// Short messages at the edge of the page: an error, its cause and its remedy. They do not take the focus.

import { refusalOf } from "./connection.js";
import { ControlBar } from "./control.js";
import { h, icon } from "./dom.js";

/** @import { Child } from "../types/dom.js" */

const GOOD_MS = 4000;
const BAD_MS = 15_000;
const MOST = 3;

/** The text, cause, operand at fault and remedy of an error as elements. @param {unknown} error */
export function explanation(error) {
  const { text, cause, concerns, remedy } = refusalOf(error);
  return h("div.explanation", {},
    h("p.explanation-text", {}, text),
    cause && h("p", {}, h("b", {}, "Cause "), cause),
    concerns && h("p", {}, h("b", {}, "Where "), concerns),
    remedy && h("p", {}, h("b", {}, "What to do "), remedy));
}

/** The place for messages. */
export class Toasts {
  element = h("div.toasts", { role: "region", "aria-label": "Messages" });
  /** @type {Map<HTMLElement, ControlBar>} */
  #bars = new Map();

  /** @param {import("./app.js").App} app */
  constructor(app) {
    this.app = app;
  }

  /** Says that an action has succeeded. @param {string} text */
  good(text) {
    this.#show("good", "status", h("p", {}, text), GOOD_MS, text);
  }

  /**
   * Shows an error with its cause and remedy from the server. The same error, which may arrive as a refusal and as an event,
   * is one message. If control was missing, the message offers to take it.
   * @param {string} what
   * @param {unknown} error
   */
  bad(what, error) {
    const { text, control } = refusalOf(error);
    const bar = control ? new ControlBar(this.app, [control]) : null;
    const toast = this.#show("bad", "alert", [h("strong", {}, what), explanation(error), bar?.element], BAD_MS, text);
    if (bar) this.#bars.set(toast, bar);
  }

  /** Shows in the messages which page has control now. */
  update() {
    for (const [toast, bar] of this.#bars) {
      if (toast.isConnected) bar.update();
      else this.#bars.delete(toast);
    }
  }

  /** @param {"good" | "bad"} kind @param {string} role @param {Child} content @param {number} time @param {string} key */
  #show(kind, role, content, time, key) {
    for (const other of this.element.querySelectorAll("[data-key]")) if (/** @type {HTMLElement} */ (other).dataset.key === key) other.remove();
    const toast = h(`div.toast.${kind}`, { role, "data-key": key }, icon(kind === "bad" ? "warning" : "check"), h("div", {}, content),
      h("button.bare", { type: "button", "aria-label": "Close this message", onclick: () => {
        toast.remove();
      } }, icon("close")));
    this.element.append(toast);
    while (this.element.children.length > MOST) this.element.firstElementChild?.remove();
    setTimeout(() => toast.remove(), time);
    return toast;
  }
}
