// The view of a program: edit, dry run, run, step, pause, stop. One program runs at a time, for all viewers.

import { refusalOf } from "./connection.js";
import { ControlBar } from "./control.js";
import { calm, fill, h, icon, segmented, state, text } from "./dom.js";
import { Editor } from "./editor.js";
import { save } from "./export.js";
import { PathCanvas } from "./path_canvas.js";
import { PreviewFacts } from "./preview.js";
import { keep } from "./keep.js";
import { STOPS } from "./form.js";
import { explanation } from "./toasts.js";

/** @import { Store } from "./store.js" */
/** @import { Machine, ProgramStatus } from "../types/protocol.js" */

const KEY = "arcline.program";
const CHECK_MS = 250;
/** @type {Record<ProgramStatus["state"], string>} */
const COLOURS = { idle: "calm", running: "busy", paused: "warn", ended: "good", failed: "bad" };
/** @type {Record<ProgramStatus["state"], string>} */
const WORDS = { idle: "No program is running", running: "Running", paused: "Paused", ended: "Ended", failed: "Failed" };

/** The status before the first push of the server. @type {ProgramStatus} */
const IDLE = { state: "idle", line: null, viewer: null, error: null, run: -1 };

export class Program {
  title = "Program";
  /** The number of the newest program that was shown. @type {number | undefined} */
  run;
  /** Objects whose control the program needs. @type {string[]} */
  needed = [];
  /** Whether a program runs or is paused. */
  active = false;
  /** Whether the program is paused. */
  paused = false;
  /** Whether the error of a run or a dry run is shown. */
  failed = false;
  /** The text whose lines were counted last. */
  counted = { source: "", lines: 1 };

  /** @param {import("./app.js").App} app */
  constructor(app) {
    this.app = app;
    const { store } = app;
    this.editor = new Editor({
      label: "Program in Structured Text", mnemonics: store.catalogue.instructions.map(({ mnemonic }) => mnemonic),
      onchange: (source) => this.#changed(source),
    });
    this.status = h("span.pill", { role: "status" });
    this.progress = /** @type {HTMLProgressElement} */ (h("progress", { "aria-label": "Progress of the program by lines", hidden: true }));
    const button = (/** @type {string} */ title, /** @type {string} */ picture, /** @type {() => void} */ action, kind = "") => h(kind ? `button.${kind}` : "button", { type: "button", onclick: action }, icon(picture), title);
    this.dry = button("Dry run", "eye", () => this.#dryRun());
    this.runButton = button("Run", "run", () => this.#run(), "primary");
    this.step = button("Step", "step", () => this.#step());
    this.pause = button("Pause", "pause", () => this.#ask(this.paused ? "continue" : "pause"));
    this.end = button("Stop", "stop", () => this.#ask("end"), "danger");
    this.why = h("small.why", { role: "status" });
    this.file = h("input", { type: "file", accept: ".st,text/plain", hidden: true, onchange: () => this.#open() });
    this.facts = new PreviewFacts(app);
    this.events = h("ol.dry-events");
    this.problem = h("div.problem", { role: "alert", hidden: true });
    const host = h("div.path-canvas.small");
    this.canvas = new PathCanvas(host, app, "Path of the program");
    const systems = store.machine.coordinate_systems.map(({ name }) => /** @type {[string, string]} */ ([name, name]));
    this.control = new ControlBar(app);
    this.system = segmented("Coordinate system", systems.slice(0, 6), systems[0]?.[0], (name) => this.#showSystem(name));
    this.element = h("section.view.program", { "aria-label": this.title },
      h("div.toolbar", {}, this.dry, this.runButton, this.step, this.pause, this.end, this.why, h("span.spring"), this.progress, this.status,
        button("Open", "open", () => this.file.click()), button("Save", "save", () => this.#save()), this.file),
      h("div.program-body", {}, this.editor.element,
        h("div.program-side", {}, this.control.element, this.problem,
          h("div.panel", {}, h("div.row", {}, h("h2", {}, "Dry run"), h("span.spring"), this.system.element), host, this.facts.element, this.events))));
    this.check = calm(CHECK_MS, (/** @type {string} */ source) => this.#check(source));
    store.on("program", () => this.#program());
    this.editor.text = keep.get(KEY) ?? example(store.machine);
    if (systems.length) this.#showSystem(systems[0][0]);
    this.#program();
    app.connection.on("open", () => this.check(this.editor.text));
  }

  show() {
    this.canvas.stage.start(() => true);
    this.check(this.editor.text);
  }

  hide() {
    this.canvas.stage.stop();
  }

  /** @param {string} name */
  #showSystem(name) {
    this.canvas.show(name);
    this.#showNeeded();
  }

  /** Control is needed of all that the program moves; of the system that is shown if it moves nothing. */
  #showNeeded() {
    this.needed = moved(this.editor.text, this.app.store);
    const shown = this.needed.length ? this.needed : [this.canvas.system?.name ?? this.app.store.machine.group];
    this.control.show(shown);
    this.update();
  }

  /** @param {string} source */
  #changed(source) {
    keep.set(KEY, source);
    this.failed = false;
    this.#say(null);
    this.#showNeeded();
    this.canvas.setPreview(null);
    this.facts.show(null);
    fill(this.events);
    this.check(source);
  }

  /** @param {string} source */
  async #check(source) {
    if (!this.app.connection.isOpen) return;
    try {
      const { errors } = await this.app.connection.request("check", { text: source });
      // The mark at the line of a program that failed stays until the text or the program changes.
      if (source === this.editor.text && !this.failed) this.editor.setErrors(errors);
    } catch (error) {
      this.#say(error);
    }
  }

  async #dryRun() {
    this.#say(null);
    this.dry.disabled = true;
    try {
      const answer = await this.app.connection.request("dry_run", { text: this.editor.text });
      const first = answer.paths?.[0]?.coordinate_system;
      if (first && !answer.paths.some((path) => path.coordinate_system === this.canvas.system?.name)) {
        this.system.choose(first);
        this.#showSystem(first);
      }
      this.canvas.setPreview(answer);
      this.facts.show(answer);
      const wrong = (answer.events ?? []).filter(({ err }) => err);
      fill(this.events, wrong.map((event) => h("li.bad", {}, `${event.instruction} ${event.tag}: `, event.error ? event.error.text : `ERR ${event.err}`)));
    } catch (error) {
      this.#fault(error);
    } finally {
      this.dry.disabled = false;
    }
  }

  /** @param {"step" | "pause" | "continue" | "end"} what */
  #ask(what) {
    return this.#attempt(() => this.app.connection.request(what));
  }

  /** Runs the program; with `step` it pauses in front of the first statement. */
  #run(step = false) {
    return this.#attempt(() => this.app.connection.request("run", { text: this.editor.text, step }));
  }

  /** Makes a request, and shows its refusal. @param {() => Promise<unknown>} request */
  async #attempt(request) {
    this.#say(null);
    try {
      await request();
    } catch (error) {
      this.#fault(error);
    }
  }

  /** Steps a program; the first step begins one. */
  async #step() {
    if (!this.active) await this.#run(true);
    else await this.#ask("step");
  }

  /** @param {unknown} error */
  #fault(error) {
    this.failed = true;
    const { line, column, text } = refusalOf(error);
    if (line) this.editor.setErrors([{ line, column, text }]);
    this.#say(error);
  }

  /** @param {unknown} error */
  #say(error) {
    const refusal = error ? refusalOf(error) : null;
    this.refusedFor = refusal?.control ?? null;
    this.problem.hidden = !refusal;
    fill(this.problem, refusal && [refusal.line ? h("strong", {}, `Line ${refusal.line}`) : "", explanation(refusal)]);
  }

  #program() {
    const program = this.app.store.program ?? IDLE;
    // The error of an earlier run is over when another one begins.
    if (program.run !== this.run || (program.state !== "failed" && this.failed)) this.#forget();
    this.run = program.run;
    this.active = program.state === "running" || program.state === "paused";
    this.paused = program.state === "paused";
    const who = this.active && program.viewer && program.viewer !== this.app.store.viewer ? ` for ${program.viewer}` : "";
    const lines = this.active ? this.#linesOf(program.text ?? this.editor.text) : 1;
    text(this.status, `${WORDS[program.state] ?? program.state}${this.active && program.line ? `, line ${program.line} of ${lines}` : ""}${who}`);
    this.progress.hidden = !this.active;
    this.progress.max = lines;
    this.progress.value = program.line ?? 0;
    state(this.status, "kind", COLOURS[program.state]);
    if (this.active && program.text !== undefined && program.text !== null && program.text !== this.editor.text) {
      this.editor.text = program.text;
      this.check(program.text);
      this.#showNeeded();
    }
    this.editor.area.readOnly = this.active;
    this.editor.setLine(this.active ? program.line ?? null : null);
    fill(this.pause, icon(this.paused ? "run" : "pause"), this.paused ? "Continue" : "Pause");
    if (program.state === "failed" && program.error) this.#fault(program.error);
    this.update();
  }

  /** The number of lines of a program; counted once for each text, as pushes of a run come often. @param {string} source */
  #linesOf(source) {
    if (source !== this.counted.source) this.counted = { source, lines: source.trimEnd().split("\n").length };
    return this.counted.lines;
  }

  /** Removes the error of an earlier run and the mark at its line. */
  #forget() {
    this.failed = false;
    this.#say(null);
    this.editor.setErrors([]);
    this.check(this.editor.text);
  }

  update() {
    this.control.update();
    const { store, connection } = this.app;
    const missing = (this.needed ?? []).filter((name) => !store.drives(name));
    const mayRun = store.may("engineer");
    const may = connection.isOpen && mayRun && !missing.length;
    this.runButton.disabled = this.active || !may;
    this.step.disabled = this.active ? !this.paused || !mayRun : !may;
    this.pause.disabled = !this.active || (this.paused && !may);
    this.end.disabled = !this.active;
    text(this.why, this.active || may ? "" : !connection.isOpen ? "No connection." : !mayRun ? `As ${store.session.role} you may not run programs.` : `Take control of ${missing.join(", ")} first.`);
    // Control answers the refusal that asked for it.
    if (this.refusedFor && store.drives(this.refusedFor)) this.#forget();
  }

  async #open() {
    const [file] = this.file.files ?? [];
    if (!file) return;
    this.editor.text = await file.text();
    this.file.value = "";
    this.#changed(this.editor.text);
  }

  #save() {
    save(new Blob([this.editor.text], { type: "text/plain" }), "program.st");
  }
}

/** The objects that the calls of a program move: their first operand, and every coordinate system that they name. @param {string} source @param {Store} store */
function moved(source, store) {
  /** @type {Set<string>} */
  const names = new Set();
  const { axes, coordinate_systems: systems, group } = store.machine;
  const known = new Map([...axes, ...systems, { name: group }].map(({ name }) => [name.toLowerCase(), name]));
  const calls = source.replace(/\/\/[^\n]*|\(\*[\s\S]*?(\*\)|$)/g, " ").matchAll(/([A-Za-z_]\w*)\s*\((?=([^;]*))/g);
  for (const [, mnemonic, operands] of calls) {
    if (!store.instruction(mnemonic.toUpperCase()) || STOPS.has(mnemonic.toUpperCase())) continue;
    operands.split(/[(),[\]]/).forEach((operand, k) => {
      const name = known.get(operand.trim().toLowerCase());
      if (name && (k === 0 || store.system(name))) names.add(name);
    });
  }
  return [...names];
}

/** A program to begin with, for the first coordinate system of two axes or more. @param {Machine} machine */
function example(machine) {
  const system = machine.coordinate_systems.find(({ axes }) => axes.length > 1) ?? machine.coordinate_systems[0];
  if (!system) return "";
  const at = (/** @type {number[]} */ ...values) => `[${system.axes.map((_, k) => values[k] ?? 0).join(", ")}]`;
  const move = (/** @type {string} */ tag, /** @type {string} */ place) => `MCLM(${system.name}, ${tag}, Absolute, ${place}, 50, %ofMaximum, 100, %ofMaximum, 100, %ofMaximum,\n     S-curve, 100, 100, %ofTime, CommandTolerance);`;
  return `// A square with rounded corners. Dry run shows it before anything moves.\n${move("Hmi1", at(100, 0))}\n${move("Hmi2", at(100, 100))}\n${move("Hmi3", at(0, 100))}\n${move("Hmi4", at(0, 0))}\nWAIT(Hmi4.PC);\n`;
}
