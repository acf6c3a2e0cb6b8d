// The view of the controller's own program: tasks, programs and routines, the rungs or lines of one of them with power flow and values,
// the uses of a tag, forced inputs, the mode, and a fault at its rung.

import { calm, fill, h, icon, segmented, seldom, state, text } from "./dom.js";
import { RungPicture, shown } from "./ladder.js";
import { Rows } from "./rows.js";
import { TagPanel } from "./tag_panel.js";

/** @import { ControllerStatus, MonitorRow, PassedOver, RoutineList, RoutineRow, Rung, TextLine } from "../types/protocol.js" */

/** Rungs of one request, and the most that the page watches. */
const PAGE = 50;
const MOST_LOOKED = 100;
const SCROLLED_MS = 60;
/** Between two times of a scan that are shown. */
const SCAN_MS = 500;
const RUNG = 92;
const LINE = 22;
/** Height of a line of a comment or a note above a rung. */
const NOTE = 18;
/** @type {Record<ControllerStatus["state"], [word: string, kind: string]>} */
const STATES = { stopped: ["Program mode", "warn"], running: ["Run mode", "good"], faulted: ["Major fault", "bad"] };

/**
 * A routine that can be shown.
 * @typedef {RoutineRow & { owner: string, program: string | null, instances: string[] }} Routine
 */

export class Controller {
  title = "Logic";
  /** @type {RoutineList | null} */
  list = null;
  /** @type {Routine[]} */
  routines = [];
  /** The routine that is shown. @type {Routine | null} */
  routine = null;
  /** Its rungs or lines by place, and those that are asked for. @type {Map<number, Rung | TextLine>} */
  #known = new Map();
  /** @type {Set<number>} */
  #asked = new Set();
  /** The newest state by place. @type {Map<number, MonitorRow>} */
  #rows = new Map();
  /** The functions that update the picture of each drawn row. @type {Map<number, (row: MonitorRow | null) => void>} */
  #pictures = new Map();
  /** The row that a fault or a use is at. @type {number | null} */
  #marked = null;
  #loading = false;
  #version = 0;
  #scanIsDue = seldom(SCAN_MS);

  /** @param {import("./app.js").App} app */
  constructor(app) {
    this.app = app;
    this.state = h("span.pill", { role: "status" });
    this.scan = h("small");
    this.file = h("small.controller-file");
    this.mode = segmented("Mode of the controller", [["run", "Run", "The tasks run"], ["program", "Program", "The tasks and all motion stop"]], undefined, (mode) => this.#mode(mode === "run"));
    this.fault = h("div.problem", { role: "alert", hidden: true });
    this.forces = h("div.force-note", { role: "status", hidden: true });
    this.parts = h("details.parts-note", { hidden: true });
    this.tree = h("nav.routine-tree", { "aria-label": "Tasks, programs and routines" });
    this.heading = h("h2");
    this.instance = h("select", { "aria-label": "Instance whose values are shown", hidden: true, onchange: () => this.#look() });
    this.rows = new Rows({ estimate: RUNG, draw: (place) => this.#draw(place), onview: calm(SCROLLED_MS, () => this.#look()) });
    this.rows.element.setAttribute("aria-label", "Rungs");
    this.rows.element.addEventListener("click", (event) => this.#pick(event));
    this.rows.element.addEventListener("keydown", (event) => event.key === "Enter" && this.#pick(event));
    this.panel = new TagPanel(app, this);
    this.empty = h("p.empty", {}, "This controller has no program of its own. Start the server with one: arcline-server run Cell.L5X, or program = \"Cell.L5X\" under [controller] in the configuration.");
    this.body = h("div.controller-body", {}, h("div.panel.tree-panel", {}, this.tree),
      h("div.panel.routine-panel", {}, h("div.row", {}, this.heading, h("span.spring"), this.instance), this.rows.element), this.panel.element);
    this.bar = h("div.toolbar", {}, this.state, this.mode.element, this.scan, h("span.spring"), this.file);
    this.element = h("section.view.controller", { "aria-label": this.title }, this.bar, this.fault, this.forces, this.parts, this.empty, this.body);
    app.store.on("look", ({ routine, rows }) => this.#looked(routine, rows));
    app.connection.on("open", () => {
      this.#version = 0;
      if (this.element.isConnected) this.show();
    });
    this.#show(null);
  }

  /** Whether the controller has a program; without one the list of views does not name this view. */
  get isHere() {
    return Boolean(this.app.store.status?.controller);
  }

  show() {
    this.update();
    this.rows.known();
    this.#look();
  }

  hide() {
    this.app.connection.tell("look", { routine: null });
  }

  update() {
    const status = this.app.store.status?.controller ?? null;
    this.#show(status);
    if (status && status.version !== this.#version && !this.#loading) this.#load();
  }

  /** @param {ControllerStatus | null} status */
  #show(status) {
    this.empty.hidden = status !== null;
    this.body.hidden = this.bar.hidden = status === null;
    this.fault.hidden = !status?.fault;
    this.forces.hidden = !status?.forces.length;
    this.parts.hidden = status === null || !this.list?.passed_over_count;
    if (!status) return;
    const [word, kind] = STATES[status.state];
    text(this.state, word);
    state(this.state, "kind", kind);
    this.mode.choose(status.mode === "run" ? "run" : "program");
    const may = this.app.store.may("engineer");
    for (const button of this.mode.element.querySelectorAll("button")) button.disabled = !may;
    this.mode.element.title = may ? "" : "An engineer may change the mode";
    this.#showScan(status);
    const { fault } = status;
    if (fault && this.fault.dataset.text !== fault.text) {
      this.fault.dataset.text = fault.text;
      fill(this.fault, h("div.row", {}, h("strong", {}, fault.text), h("span.spring"),
        fault.routine !== null && h("button", { type: "button", onclick: () => this.#showFault() }, "Show the rung")));
    } else if (!fault && this.fault.dataset.text) {
      delete this.fault.dataset.text;
      this.#mark(null);
    }
    this.#showForces(status);
    this.panel.update(status);
  }

  /** @param {ControllerStatus} status */
  #showScan({ state: now, last_us, longest_us }) {
    if (now !== "running") text(this.scan, "");
    else if (this.#scanIsDue() || !this.scan.textContent) text(this.scan, `Scan ${last_us} µs, longest ${longest_us} µs`);
  }

  /** @param {ControllerStatus} status */
  #showForces({ forces }) {
    const key = JSON.stringify(forces);
    if (this.forces.dataset.key === key) return;
    this.forces.dataset.key = key;
    fill(this.forces, icon("warning"), h("strong", {}, `${forces.length} forced ${forces.length === 1 ? "input" : "inputs"}`),
      forces.map((force) => h("button.chip", { type: "button", onclick: () => this.panel.choose(force.tag, null) }, `${force.tag} = ${shown(force.value)}`)), h("span.spring"),
      h("button", { type: "button", onclick: () => this.#attempt("The forces were not removed", this.app.connection.request("remove_forces", {})) }, "Remove all forces"));
  }

  /** @param {boolean} run */
  async #mode(run) {
    await this.#attempt("The mode was not changed", this.app.connection.request("mode", { run }));
    this.update();
  }

  /** @param {string} what @param {Promise<unknown>} request */
  async #attempt(what, request) {
    try {
      await request;
    } catch (error) {
      this.app.toasts.bad(what, error);
    }
  }

  /** Reads the routines of a program that is new to the page. */
  async #load() {
    this.#loading = true;
    try {
      this.list = await this.app.connection.request("routines", {});
      this.#version = this.list.version;
      text(this.file, this.list.file);
      this.#fillTree(this.list);
      this.#fillParts(this.list);
      const before = this.routine;
      const main = this.list.programs.find(({ name }) => name === this.list?.tasks[0]?.programs[0]);
      const again = before && this.routines.find(({ owner, name }) => owner === before.owner && name === before.name);
      const first = this.routines.find(({ owner, name }) => owner === main?.name && name === main?.main);
      this.open(again ?? first ?? this.routines[0] ?? null);
    } catch (error) {
      // The next status asks again.
      if (this.app.connection.isOpen) this.app.toasts.bad("The routines cannot be listed", error);
    } finally {
      this.#loading = false;
    }
  }

  /** @param {RoutineList} list */
  #fillTree(list) {
    this.routines = [
      ...list.programs.flatMap((program) => program.routines.map((row) => ({ ...row, owner: program.name, program: program.name, instances: [] }))),
      ...list.add_ons.flatMap((one) => one.routines.map((row) => ({ ...row, owner: one.name, program: null, instances: one.instances }))),
    ];
    const buttons = (/** @type {string} */ owner, /** @type {RoutineRow[]} */ rows, /** @type {(row: RoutineRow) => string} */ note) => h("ul", {}, rows.map((row) => {
      const routine = this.routines.find((one) => one.routine === row.routine) ?? null;
      const unit = row.language === "ladder" ? "rung" : row.language === "text" ? "line" : null;
      const count = unit ? `${row.count} ${unit}${row.count === 1 ? "" : "s"}` : row.language;
      return h("li", {}, h("button.bare.routine", { type: "button", "data-routine": row.routine, "data-name": `${owner}/${row.name}`, onclick: () => this.open(routine) }, row.name, note(row) && [" ", h("small", {}, note(row))], " ", h("small", {}, count)));
    }));
    const program = (/** @type {string} */ name) => {
      const found = list.programs.find((one) => one.name === name);
      const note = (/** @type {RoutineRow} */ row) => row.name === found?.main ? "main" : row.name === found?.fault ? "faults" : "";
      return h("li", {}, h("b", {}, name), found?.disabled && h("small.warn", {}, " disabled"), found && buttons(name, found.routines, note));
    };
    const scheduled = new Set(list.tasks.flatMap((task) => task.programs));
    const others = list.programs.filter(({ name }) => !scheduled.has(name));
    fill(this.tree,
      list.tasks.map((task) => h("details", { open: true }, h("summary", {}, icon("machine"), task.name, h("small", {}, `${task.trigger}, priority ${task.priority}${task.inhibited ? ", inhibited" : ""}`)), h("ul", {}, task.programs.map(program)))),
      others.length > 0 && h("details", { open: true }, h("summary", {}, "Unscheduled"), h("ul", {}, others.map(({ name }) => program(name)))),
      list.add_ons.length > 0 && h("details", {}, h("summary", {}, "Add-on instructions"), h("ul", {}, list.add_ons.map((one) => h("li", {}, h("b", {}, one.name), buttons(one.name, one.routines, () => ""))))));
  }

  /** Lists the parts that do not run. @param {RoutineList} list */
  #fillParts({ passed_over: parts, passed_over_count: count }) {
    const row = (/** @type {PassedOver} */ part) => {
      const { routine, number } = part;
      const place = part.place && (routine !== null && number !== null
        ? h("button.bare", { type: "button", onclick: () => this.#goToNumber(routine, number) }, part.place)
        : h("b", {}, part.place));
      return h("li", {}, place, " ", part.text);
    };
    fill(this.parts, h("summary", {}, icon("warning"), h("strong", {}, `${count} ${count === 1 ? "part does" : "parts do"} not run as the file has ${count === 1 ? "it" : "them"}`)),
      h("ul", {}, parts.map(row), count > parts.length && h("li", {}, `and ${count - parts.length} more`)));
    this.parts.hidden = count === 0;
  }

  /** Shows a routine, at a place if one is given. @param {Routine | null} routine @param {number | null} [place] */
  open(routine, place = null) {
    const isOther = routine?.routine !== this.routine?.routine || this.rows.count === 0;
    this.routine = routine;
    for (const button of this.tree.querySelectorAll("button.routine")) button.setAttribute("aria-current", String(Number(/** @type {HTMLElement} */ (button).dataset.routine) === routine?.routine));
    text(this.heading, routine ? `${routine.owner} / ${routine.name}` : "No routine");
    this.instance.hidden = !routine?.instances.length;
    fill(this.instance, h("option", { value: "" }, "No instance"), (routine?.instances ?? []).map((name) => h("option", { value: name }, name)));
    if (routine?.instances.length) this.instance.value = routine.instances[0];
    this.#known.clear();
    this.#asked.clear();
    this.#rows.clear();
    this.#pictures.clear();
    this.#marked = null;
    this.rows.estimate = routine?.language === "ladder" ? RUNG : LINE;
    this.rows.reset(routine?.count ?? 0);
    if (place !== null) this.#mark(place);
    this.#look();
    return isOther;
  }

  /** Shows a rung or line of a routine by its number. @param {number} routine @param {number} place */
  goTo(routine, place) {
    const found = this.routines.find((one) => one.routine === routine) ?? null;
    if (found !== this.routine) this.open(found, place);
    else this.#mark(place);
  }

  async #showFault() {
    const fault = this.app.store.status?.controller?.fault;
    if (fault && fault.routine !== null) await this.#goToNumber(fault.routine, fault.line);
  }

  /** Shows a rung or line by the number that the file gives it. @param {number} routine @param {number} number */
  async #goToNumber(routine, number) {
    // Most files number rungs from 0 without gaps; the number decides where they do not.
    const near = Math.max(0, number - PAGE / 2);
    const page = await this.app.connection.request("rungs", { routine, from: near, count: PAGE });
    const at = (page.rungs.length ? page.rungs : page.lines).findIndex((row) => row.number === number);
    this.goTo(routine, at < 0 ? number : near + at);
  }

  /** @param {number | null} place */
  #mark(place) {
    this.#marked = place;
    for (const [row, element] of this.rows.mounted) element.classList.toggle("marked", row === place);
    if (place !== null) this.rows.reveal(place);
  }

  /** Asks for the rungs around a place. @param {number} place */
  async #ask(place) {
    const { routine } = this;
    const from = Math.floor(place / PAGE) * PAGE;
    if (!routine || this.#asked.has(from)) return;
    this.#asked.add(from);
    try {
      const page = await this.app.connection.request("rungs", { routine: routine.routine, from, count: PAGE });
      if (routine !== this.routine) return;
      for (const [k, row] of (page.rungs.length ? page.rungs : page.lines).entries()) this.#known.set(from + k, row);
      this.rows.known();
    } catch {
      // They are asked for again with the next connection or program.
      this.#asked.delete(from);
    }
  }

  /** @param {number} place */
  #draw(place) {
    const known = this.#known.get(place);
    if (!known) {
      this.#ask(place);
      return null;
    }
    const drawn = "elements" in known ? this.#rung(known) : this.#line(known);
    drawn.element.classList.toggle("marked", place === this.#marked);
    this.#pictures.set(place, drawn.update);
    drawn.update(this.#rows.get(place) ?? null);
    return drawn;
  }

  /** @param {Rung} rung */
  #rung(rung) {
    const width = Math.max(360, this.rows.element.clientWidth - 2);
    const picture = new RungPicture(rung, width, `Rung ${rung.number}`);
    // A comment is as high as its lines.
    const perLine = Math.max(20, Math.floor((width - 60) / 7));
    const linesOf = (/** @type {string} */ words) => words.split("\n").reduce((sum, line) => sum + Math.max(1, Math.ceil(line.length / perLine)), 0);
    const block = (/** @type {string} */ spec, /** @type {string} */ words) => {
      const height = words ? linesOf(words) * NOTE + 10 : 0;
      const drawn = words && h(spec, {}, words);
      // A rung may be wider than the view.
      if (drawn) Object.assign(drawn.style, { height: `${height}px`, maxWidth: `${width}px` });
      return { drawn, height };
    };
    const comment = block("div.rung-comment", rung.comment);
    const note = block("div.rung-comment.warn", this.#notes(rung.number).join("\n"));
    const element = h("div.rung", {}, comment.drawn, note.drawn, h("span.rung-number", {}, String(rung.number)), picture.element);
    return { element, height: picture.height + comment.height + note.height, update: (/** @type {MonitorRow | null} */ row) => picture.update(row) };
  }

  /** The words on the parts of a rung or line that do not run. @param {number} number */
  #notes(number) {
    const parts = (this.list?.passed_over ?? []).filter((part) => part.number === number && part.routine === this.routine?.routine);
    return parts.map(({ text: words }) => `Does not run: ${words}`);
  }

  /** @param {TextLine} line */
  #line(line) {
    const values = line.names.map(() => h("b"));
    const element = h("div.text-line", {}, h("span.rung-number", {}, String(line.number)), h("code", {}, line.text),
      this.#notes(line.number).map((note) => h("span.warn", {}, note)), h("span.line-values", {}, line.names.map((name, k) => h("span", { role: "button", tabindex: "0", "data-tag": name }, name, " ", values[k]))));
    const update = (/** @type {MonitorRow | null} */ row) => values.forEach((value, k) => {
      text(value, shown(row?.values[k]));
    });
    return { element, height: LINE, update };
  }

  /** Watches the visible rows only. */
  #look() {
    const { routine } = this;
    if (!this.app.connection.isOpen || !this.element.isConnected || !routine || !this.rows.count || !this.#version) return;
    for (const place of this.#rows.keys()) if (place < this.rows.from || place >= this.rows.from + this.rows.count) this.#rows.delete(place);
    for (const place of this.#pictures.keys()) if (!this.rows.mounted.has(place)) this.#pictures.delete(place);
    const fields = { routine: routine.routine, from: this.rows.from, count: Math.min(this.rows.count, MOST_LOOKED), version: this.#version, instance: this.instance.value || null };
    this.app.connection.request("look", fields).catch((error) => {
      if (this.app.connection.isOpen && this.routine === routine && this.app.store.status?.controller?.version === this.#version) this.app.toasts.bad("The routine cannot be looked at", error);
    });
  }

  /** @param {number} routine @param {MonitorRow[]} rows */
  #looked(routine, rows) {
    if (routine !== this.routine?.routine) return;
    for (const row of rows) {
      this.#rows.set(row.index, row);
      this.#pictures.get(row.index)?.(row);
    }
  }

  /** @param {Event} event */
  #pick(event) {
    const found = event.target instanceof Element ? event.target.closest("[data-tag]") : null;
    const tag = found?.getAttribute("data-tag");
    if (tag) this.panel.choose(tag, this.routine?.program ?? null);
  }
}
