// Short messages at the edge of the page: what went wrong, why, and what to do. They do not take the focus.

import { h, icon } from "./dom.js";

const GOOD_MS = 4000;
const BAD_MS = 15_000;
const MOST = 4;

/** What there is to say about a refusal or an error: text, cause, what EXERR points at, and remedy as elements. */
export function explanation(error) {
  return h("div.explanation", {},
    h("p.explanation-text", {}, error.text ?? error.message ?? String(error)),
    error.cause && h("p", {}, h("b", {}, "Cause "), error.cause),
    error.concerns && h("p", {}, h("b", {}, "Where "), error.concerns),
    error.remedy && h("p", {}, h("b", {}, "What to do "), error.remedy));
}

/** The place for messages. */
export class Toasts {
  element = h("div.toasts", { role: "region", "aria-label": "Messages" });

  /** Says that something went well. */
  good(text) {
    this.#show("good", "status", h("p", {}, text), GOOD_MS);
  }

  /** Tells an error with what the server knows about it. */
  bad(what, error) {
    this.#show("bad", "alert", [h("strong", {}, what), explanation(error)], BAD_MS);
  }

  #show(kind, role, content, time) {
    const toast = h(`div.toast.${kind}`, { role }, icon(kind === "bad" ? "warning" : "check"), h("div", {}, content),
      h("button.bare", { type: "button", "aria-label": "Close this message", onclick: () => toast.remove() }, icon("close")));
    this.element.append(toast);
    while (this.element.children.length > MOST) this.element.firstChild.remove();
    setTimeout(() => toast.remove(), time);
  }
}
