// The session of this page: its user with the role, log in, lock and log out. STOP works without a session.

import { fill, h, icon, state, text } from "./dom.js";

/** Shortest time between two reports of input by a person to the server. */
const ACTIVE_MS = 10_000;

/** The answers of the server that a person can remedy. @type {Record<number, string>} */
const REFUSED = { 401: "The user or the password is wrong.", 403: "Log in over HTTPS." };

/** The button in the bar and the note above the view. */
export class Session {
  #told = -Infinity;
  #open = false;
  #key = "";

  /** @param {import("./app.js").App} app */
  constructor(app) {
    this.app = app;
    this.name = h("span.session-name");
    this.button = h("button.session", { type: "button", hidden: true, "aria-expanded": "false", "aria-controls": "session", onclick: () => this.#toggle() }, icon("lock"), this.name);
    this.note = h("div.session-note", { id: "session", role: "region", "aria-label": "Session", hidden: true });
    app.store.on("session", () => this.#update());
    for (const input of ["pointerdown", "keydown", "wheel"]) addEventListener(input, () => this.#active(), { capture: true, passive: true });
  }

  /** Shows the form of a log-in. */
  open() {
    if (!this.#open) this.#toggle();
    this.#focus();
  }

  /** Puts the cursor where something is to be filled in. */
  #focus() {
    /** @type {HTMLInputElement | null} */ (this.note.querySelector("input:not([readonly])"))?.focus();
  }

  #toggle() {
    this.#open = !this.#open;
    this.#update();
    if (this.#open) this.#focus();
  }

  #active() {
    const { session } = this.app.store;
    if (session.user === null || session.locked || performance.now() - this.#told < ACTIVE_MS) return;
    this.#told = performance.now();
    this.app.connection.tell("active", {});
  }

  #update() {
    const { session } = this.app.store;
    const { role, user, locked } = session;
    // A page without log-ins shows its role only where that role is below the usual one.
    this.button.hidden = user === null && !session.can_log_in && this.app.store.may("operator");
    this.button.disabled = user === null && !session.can_log_in;
    text(this.name, user === null ? (session.can_log_in ? "Log in" : `You are ${role}`) : locked ? `${user}, locked` : `${user}, ${role}`);
    state(this.button, "kind", locked ? "warn" : user === null ? "calm" : "mine");
    const shown = locked || (this.#open && !this.button.hidden && !this.button.disabled);
    this.button.setAttribute("aria-expanded", String(shown));
    this.note.hidden = !shown;
    const key = JSON.stringify([role, user, locked, shown]);
    if (key === this.#key) return;
    this.#key = key;
    if (!shown) fill(this.note);
    else if (user === null || locked) fill(this.note, this.#form(locked ? user : null));
    else fill(this.note, h("span", {}, h("b", {}, user), ` is logged in as ${role}.`), h("button", { type: "button", onclick: () => this.#ask("/lock") }, icon("lock"), "Lock"), this.#logOut());
  }

  #logOut() {
    return h("button", { type: "button", onclick: () => this.#ask("/logout") }, "Log out");
  }

  /** @param {string | null} locked The user of a locked session. */
  #form(locked) {
    const user = h("input", { type: "text", name: "user", autocomplete: "username", autocapitalize: "none", spellcheck: "false", required: true, maxlength: 64, value: locked ?? "", readonly: locked !== null });
    const password = h("input", { type: "password", name: "password", autocomplete: "current-password", required: true, maxlength: 256 });
    const submit = h("button.primary", { type: "submit" }, icon("unlock"), locked === null ? "Log in" : "Unlock");
    const problem = h("span.bad", { role: "alert" });
    const send = async () => {
      submit.disabled = true;
      text(problem, "");
      text(problem, await this.#logIn(user.value, password.value));
      submit.disabled = false;
      password.value = "";
      password.focus();
    };
    const notice = locked === null ? this.app.store.machine.login_notice : null;
    return h("form", { onsubmit: (event) => {
      event.preventDefault();
      send();
    } },
    h("p.login-notice", { hidden: notice === null }, notice ?? ""),
    h("span", {}, locked === null ? "Until you log in you may look and stop." : "This page is locked. You may look and stop."),
    h("label", {}, "User ", user), h("label", {}, "Password ", password), submit,
    locked === null ? h("button", { type: "button", onclick: () => this.#toggle() }, "Cancel") : this.#logOut(), problem);
  }

  /** The reason for the refusal of the log-in; empty after a log-in. @param {string} user @param {string} password */
  async #logIn(user, password) {
    try {
      const answer = await fetch("/login", { method: "POST", headers: { "content-type": "application/json" }, body: JSON.stringify({ user, password }) });
      if (!answer.ok) {
        const later = answer.headers.get("retry-after");
        return later ? `Too many attempts. Try again in ${later} s.` : (REFUSED[answer.status] ?? `The server answered ${answer.status}.`);
      }
    } catch (error) {
      return `The server did not answer: ${error instanceof Error ? error.message : error}`;
    }
    this.#open = false;
    this.app.connection.renew();
    return "";
  }

  /** @param {"/lock" | "/logout"} path */
  async #ask(path) {
    this.#open = false;
    try {
      const answer = await fetch(path, { method: "POST" });
      if (!answer.ok) throw new Error(`the server answered ${answer.status}`);
    } catch (error) {
      this.app.toasts.bad(path === "/lock" ? "The page was not locked" : "You were not logged out", error);
    }
  }
}
