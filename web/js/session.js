// The session of this page: its user with the role, log in, lock and log out. STOP works without a session.

import { fill, h, icon, seldom, state, text } from "./dom.js";

/** @import { SessionRow } from "../types/protocol.js" */

/** Shortest time between two reports of input by a person to the server. */
const ACTIVE_MS = 10_000;

/** The answers of the server that a person can remedy. @type {Record<number, string>} */
const REFUSED = { 401: "The user or the password is wrong.", 403: "Log in over HTTPS." };

/** Time between two looks at the sessions of all users. */
const LIST_MS = 2000;

/** A time without input, in whole minutes. @param {number} seconds */
function idleText(seconds) {
  const minutes = Math.floor(seconds / 60);
  return minutes < 1 ? "below 1 min" : minutes < 60 ? `${minutes} min` : `${Math.floor(minutes / 60)} h ${minutes % 60} min`;
}

/** The button in the bar and the note above the view. */
export class Session {
  #tellingIsDue = seldom(ACTIVE_MS);
  #open = false;
  #key = "";
  #leaving = false;
  /** The sessions of all users, for an administrator. */
  #list = h("table.sessions");
  #listed = "";

  /** @param {import("./app.js").App} app */
  constructor(app) {
    this.app = app;
    this.name = h("span.session-name");
    this.button = h("button.session", { type: "button", hidden: true, "aria-expanded": "false", "aria-controls": "session", onclick: () => this.#toggle() }, icon("lock"), this.name);
    this.note = h("div.session-note", { id: "session", role: "region", "aria-label": "Session", hidden: true });
    app.store.on("session", () => this.#update());
    app.connection.on("ended", (reason) => this.#ended(reason));
    setInterval(() => this.#look(), LIST_MS);
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
    if (session.user !== null && !session.locked && this.#tellingIsDue()) this.app.connection.tell("active", {});
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
    else fill(this.note, h("span", {}, h("b", {}, user), ` is logged in as ${role}.`), h("button", { type: "button", onclick: () => this.#ask("/lock") }, icon("lock"), "Lock"), this.#logOut(), role === "administrator" && h("div.sessions-box", {}, this.#list));
    this.#look();
  }

  /** Whether the list of all sessions is shown. */
  get #lists() {
    return this.#list.isConnected && !this.note.hidden;
  }

  /** Asks for the sessions of all users while they are shown. */
  async #look() {
    if (!this.#lists || !this.app.connection.isOpen) return;
    try {
      this.#show((await this.app.connection.request("sessions", {})).sessions);
    } catch {
      // The role or the connection has gone meanwhile; the bar says so.
    }
  }

  /** @param {SessionRow[]} sessions */
  #show(sessions) {
    const rows = sessions.map(({ session, user, script, role, locked, address, pages, idle_s: idle, own }) => ({
      session, user, own, cells: [user, script ? `script, ${role}` : locked ? `${role}, locked` : role, address, pages === 1 ? "1 page" : `${pages} pages`, script ? "" : idleText(idle)],
    }));
    const key = JSON.stringify(rows);
    if (key === this.#listed && this.#list.rows.length) return;
    this.#listed = key;
    const heads = ["Session of", "Role", "From", "Open", "Without input", ""];
    // The focus stays on the button of its session, if that is still there.
    const at = /** @type {HTMLElement | null} */ (this.#list.contains(document.activeElement) ? document.activeElement : null)?.dataset.session;
    fill(this.#list, h("caption", {}, "Sessions"), h("thead", {}, h("tr", {}, heads.map((head) => h("th", { scope: "col" }, head)))),
      h("tbody", {}, rows.map(({ session, user, own, cells }) => h("tr", {}, cells.map((cell) => h("td", {}, cell)),
        h("td", {}, own ? "this page" : h("button", { type: "button", "data-session": session, "aria-label": `End session ${session} of ${user}`, onclick: () => this.#end(session, user) }, "End"))))));
    if (at) /** @type {HTMLElement | null} */ (this.#list.querySelector(`[data-session="${at}"]`))?.focus();
  }

  /** @param {number} session @param {string} user */
  async #end(session, user) {
    try {
      await this.app.connection.request("end_session", { session });
      this.app.toasts.good(`The session of ${user} has ended`);
    } catch (error) {
      this.app.toasts.bad(`The session of ${user} was not ended`, error);
    }
    this.#look();
  }

  /** Says why the session has ended, unless a person at this page ended it. @param {string} reason */
  #ended(reason) {
    if (!this.#leaving) this.app.toasts.bad("You are logged out", { text: reason });
    this.#leaving = false;
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
    this.#leaving = path === "/logout";
    try {
      const answer = await fetch(path, { method: "POST" });
      if (!answer.ok) throw new Error(`the server answered ${answer.status}`);
    } catch (error) {
      this.#leaving = false;
      this.app.toasts.bad(path === "/lock" ? "The page was not locked" : "You were not logged out", error);
    }
  }
}
