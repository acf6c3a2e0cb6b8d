// The frame of every view: the bar with state and STOP, the list of views, the warning of a lost server.

import { h, icon, fill, state, text, toggle } from "./dom.js";
import { clock } from "./format.js";
import * as theme from "./theme.js";

/** @import { View } from "./app.js" */

/** @type {Record<theme.Choice, [icon: string, title: string]>} */
const THEMES = { auto: ["auto", "System setting"], light: ["sun", "Light"], dark: ["moon", "Dark"] };

/** The time for which the bar shows a missed tick; the machine view counts all of them. */
const MISSED_MS = 10_000;

/** The frame of the page. `views` are `[key, icon, view]` in the order of the list. */
export class Shell {
  /** @param {import("./app.js").App} app @param {[key: string, icon: string, view: View][]} views */
  constructor(app, views) {
    this.app = app;
    this.views = views;
    /** The view that is shown. @type {View | null} */
    this.view = null;
    /** @type {Map<string, HTMLElement>} */
    this.links = new Map();
    /** Missed ticks at the newest status. @type {number | undefined} */
    this.missed = undefined;
    this.newlyMissed = 0;
    this.missedAt = -Infinity;
    this.link = h("span.pill", { role: "status" });
    this.motion = h("span.pill.wide-only");
    this.control = h("span.pill.wide-only.narrow-too");
    this.tick = h("span.pill.wide-only");
    this.theme = h("button.bare.round", { type: "button", onclick: () => theme.next() });
    this.stop = h("button.stop", { type: "button", title: "Stops all motion. Key: Esc", onpointerdown: (event) => this.#press(event), onclick: (event) => event.detail === 0 && app.stop() },
      icon("stop"), h("span", {}, "STOP"), h("kbd", {}, "Esc"));
    this.heading = h("h1.heard");
    this.bar = h("header.bar", {},
      this.heading,
      h("a.brand", { href: "#/machine" }, icon("arc"), h("span.brand-name", {}, app.store.machine.name), h("span.heard", {}, ", machine view")),
      this.link, this.motion, this.control, this.tick, h("span.spring"), app.session.button, this.theme, this.stop);
    this.nav = h("nav.views", { "aria-label": "Views" }, views.map(([key, picture, view]) => {
      const link = h("a", { href: `#/${key}` }, icon(picture), h("span", {}, view.title));
      this.links.set(key, link);
      return link;
    }));
    this.banner = h("div.lost", { role: "alert", hidden: true });
    this.release = h("button.release-stop", { type: "button", onclick: () => app.releaseStop() }, "Release STOP");
    this.inhibited = h("div.paused-note", { role: "alert", hidden: true }, icon("stop"), h("span", {}, "Motion is inhibited by STOP. No axis can move until it is released."), this.release);
    this.auditText = h("span");
    this.audit = h("div.paused-note", { role: "alert", hidden: true }, icon("warning"), this.auditText);
    this.main = h("main", { id: "view", tabindex: "-1" });
    this.pausedText = h("span");
    this.paused = h("div.paused-note", { role: "status", hidden: true }, icon("pause"), this.pausedText,
      h("button", { type: "button", onclick: () => app.timeCursor.live() }, icon("live"), "Return to live"));
    app.timeCursor.on("change", () => this.#showPaused());
    this.element = h("div.shell", {}, h("a.skip", { href: "#view", onclick: (event) => this.#skip(event) }, "Skip to the view"),
      this.bar, this.banner, this.nav, h("div.page", {}, h("div.notes", {}, app.session.note, this.inhibited, this.audit, this.paused), this.main), app.toasts.element);
    theme.onchange(() => this.#showTheme());
    this.#showTheme();
    addEventListener("hashchange", () => this.#route());
    this.#route();
    setInterval(() => this.#age(), 200);
  }

  /** @param {Event} event */
  #skip(event) {
    event.preventDefault();
    this.main.focus();
  }

  /** The press stops, not the release: a person who presses STOP means it at once. @param {PointerEvent} event */
  #press(event) {
    if (event.button === 0) this.app.stop();
  }

  #route() {
    const wanted = location.hash.replace(/^#\//, "");
    const [key, , view] = this.views.find(([key]) => key === wanted) ?? this.views[0];
    if (this.view === view) return;
    this.view?.hide?.();
    this.view = view;
    fill(this.main, view.element);
    for (const [name, link] of this.links) {
      if (name === key) link.setAttribute("aria-current", "page");
      else link.removeAttribute("aria-current");
    }
    document.title = `${view.title} · ${this.app.store.machine.name}`;
    text(this.heading, `${view.title}, ${this.app.store.machine.name}`);
    this.#showPaused();
    view.show?.();
    if (this.app.store.status) view.update?.();
  }

  /** A view without time stays live while the pictures show an earlier moment: it says so. */
  #showPaused() {
    const { timeCursor } = this.app;
    if (!this.view) return;
    this.paused.hidden = timeCursor.tick === null || this.view.hasTime === true;
    text(this.pausedText, `Path and Trends are paused. ${this.view.title} shows the present.`);
  }

  #showTheme() {
    const [picture, title] = THEMES[theme.choice()];
    fill(this.theme, icon(picture));
    this.theme.setAttribute("aria-label", `Colours: ${title}. Change`);
    this.theme.title = `Colours: ${title}`;
  }

  /** Writes the newest status into the bar and the view. */
  update() {
    const { store } = this.app;
    const { status } = store;
    if (!status) return;
    const moving = status.axes.filter((axis) => axis.moving).length;
    const faulted = status.axes.filter((axis) => axis.faults?.length).length;
    text(this.motion, faulted ? `${faulted} ${faulted === 1 ? "axis" : "axes"} faulted` : moving ? `${moving} ${moving === 1 ? "axis" : "axes"} moving` : "Standing still");
    state(this.motion, "kind", faulted ? "bad" : moving ? "busy" : "calm");
    const taken = store.taken();
    const wide = taken.filter((name) => !store.axis(name));
    const driven = wide.length ? wide : taken;
    text(this.control, driven.length ? `You control ${driven.join(", ")}` : "Watching");
    state(this.control, "kind", driven.length ? "mine" : "calm");
    const { realtime } = status;
    if (realtime && realtime.missed !== this.missed) {
      this.missedAt = this.missed === undefined ? -Infinity : performance.now();
      this.newlyMissed = this.missed === undefined ? 0 : realtime.missed - this.missed;
      this.missed = realtime.missed;
    }
    const missed = performance.now() - (this.missedAt ?? -Infinity) < MISSED_MS;
    const ticks = `${this.newlyMissed} ${this.newlyMissed === 1 ? "tick" : "ticks"} missed`;
    text(this.tick, !realtime ? "" : missed ? ticks : `tick ${Math.round(realtime.p99_us)} µs late`);
    const title = missed ? "A tick ended after the next one was due. This does not change positions. The Machine view counts all missed ticks."
      : "Tick lateness: 99 of 100 ticks begin no later than this";
    if (this.tick.title !== title) this.tick.title = title;
    state(this.tick, "kind", missed ? "warn" : "calm");
    this.inhibited.hidden = !status.inhibited;
    this.audit.hidden = !status.audit_lost;
    text(this.auditText, `${status.audit_lost} ${status.audit_lost === 1 ? "event is" : "events are"} missing in the audit: its disk is full or too slow. The machine goes on.`);
    this.release.disabled = !store.may("operator");
    this.release.title = this.release.disabled ? "An operator may release STOP" : "";
    for (const [key, , view] of this.views) {
      const link = this.links.get(key);
      if (link) link.hidden = view.isHere === false && view !== this.view;
    }
    this.view?.update?.();
  }

  /** Shows unmistakably whether the page has the present state. @param {boolean} on */
  connected(on) {
    document.documentElement.dataset.connection = on ? "open" : "lost";
    text(this.link, on ? "Connected" : "No connection");
    state(this.link, "kind", on ? "good" : "bad");
    this.banner.hidden = on;
    toggle(this.stop, "useless", !on);
    if (!on) document.title = "No connection";
    else if (this.view) document.title = `${this.view.title} · ${this.app.store.machine.name}`;
  }

  #age() {
    const { connection } = this.app;
    if (connection.isOpen) return;
    const since = (performance.now() - connection.lostAt) / 1000;
    const words = `No connection to the server for ${since < 100 ? `${Math.max(1, Math.floor(since))} s` : clock(since, 0)}. What you see is old and STOP cannot reach the machine from here. Connecting again…`;
    text(this.banner, words);
  }
}
