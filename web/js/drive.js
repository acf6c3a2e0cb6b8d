// The view for driving: control, servo, home, jog, override, moves. A stray click moves no axis: the user takes control
// first, a jog lasts as long as its button is held, and every other motion has a button of its own that names the motion.

import { ControlBar } from "./control.js";
import { fill, h, icon, segmented, state, text } from "./dom.js";
import { InstructionForm } from "./form.js";
import { fixed, rate, short } from "./format.js";
import { PathCanvas } from "./path_canvas.js";
import { PreviewFacts } from "./preview.js";

/**
 * The row of an axis.
 * @typedef {object} Row
 * @property {string} axis
 * @property {HTMLElement} element
 * @property {HTMLElement} actual
 * @property {HTMLElement} note
 * @property {HTMLButtonElement} servo
 * @property {HTMLButtonElement} home
 * @property {HTMLButtonElement} reset
 * @property {HTMLButtonElement} less
 * @property {HTMLButtonElement} more
 */

/** Kinds of objects as the catalogue calls them. @typedef {"CoordinateSystem" | "Axis" | "MotionGroup"} Kind */

/** Lengths of a step; 0 jogs as long as the button is held. @type {[number, string][]} */
const STEPS = [[0, "Continuous"], [0.1, "0.1"], [1, "1"], [10, "10"], [100, "100"]];
/** Keys that jog the first three axes, backwards and forwards. */
const KEYS = [["ArrowLeft", "ArrowRight"], ["ArrowDown", "ArrowUp"], ["PageDown", "PageUp"]];
/** The forms of an object: a quick one for its usual moves, and that of any instruction. @type {Record<Kind, [string, string][]>} */
const FORMS = {
  CoordinateSystem: [["MCLM", "Move"], ["MCCM", "Arc"], ["any", "Any instruction"]],
  Axis: [["MAM", "Move"], ["any", "Any instruction"]],
  MotionGroup: [["any", "Any instruction"]],
};
/** The instruction that "Any instruction" begins with. */
const FIRST = { CoordinateSystem: "MCLM", Axis: "MAM", MotionGroup: "MGS" };
/** @type {Record<Kind, string>} */
const KINDS = { CoordinateSystem: "Coordinate systems", Axis: "Axes", MotionGroup: "Motion group" };
/** The members that the quick forms show at once; all others are one click away. @type {Partial<Record<string, string[]>>} */
const QUICK = {
  MCLM: ["MoveType", "Speed", "TerminationType"],
  MCCM: ["MoveType", "CircleType", "Direction", "Speed", "TerminationType"],
  MAM: ["MoveType", "Position", "Speed"],
};
const MOST_OVERRIDE = 200;

export class Drive {
  title = "Drive";
  #step = 0;
  /** The axes that are jogged by keys, by the key. @type {Map<string, string>} */
  #heldKeys = new Map();
  /** The rows of the axes of the object. @type {Row[]} */
  parts = [];
  /** @type {string[]} */
  axes = [];
  /** The object. */
  name = "";
  /** @type {InstructionForm | null} */
  form = null;
  /** The kind of the object. @type {Kind | null} */
  objectKind = null;
  /** The form that is shown: a mnemonic, or `any`; empty before the first one. */
  chosen = "";

  /** @param {import("./app.js").App} app */
  constructor(app) {
    this.app = app;
    const { machine } = app.store;
    this.control = new ControlBar(app);
    this.object = h("select", { "aria-label": "What to drive", onchange: () => {
      this.#select(this.object.value);
    } });
    fill(this.object,
      h("optgroup", { label: "Coordinate systems" }, machine.coordinate_systems.map(({ name }) => h("option", { value: name }, name))),
      h("optgroup", { label: "Axes" }, machine.axes.map(({ name }) => h("option", { value: name }, name))),
      h("optgroup", { label: "Motion group" }, h("option", { value: machine.group }, machine.group)));
    this.rows = h("div.jog-rows");
    this.speed = h("input", { type: "range", min: "0.1", max: "100", step: "0.1", value: "5", "aria-label": "Jog speed in percent of the maximum", oninput: () => this.#showSpeed() });
    this.speedText = h("output");
    this.keys = h("input", { type: "checkbox", onchange: () => this.#releaseKeys() });
    const steps = segmented("Length of a jog", STEPS, 0, (step) => (this.#step = Number(step)));
    this.keyHelp = h("small");
    const host = h("div.path-canvas.small");
    this.canvas = new PathCanvas(host, app, "Preview of the path");
    this.facts = new PreviewFacts(app);
    this.forms = h("div.form-host");
    this.kindHost = h("span");
    this.mnemonic = h("select", { "aria-label": "Instruction", hidden: true, onchange: () => this.#form("any") });
    this.overrideText = h("output", {}, "100 %");
    this.override = h("input", { type: "range", min: "0", max: String(MOST_OVERRIDE), step: "1", value: "100", "aria-label": "Override of the path speed in percent",
      oninput: () => {
        text(this.overrideText, `${this.override.value} %`);
      }, onchange: () => {
        this.#setOverride(Number(this.override.value));
      } });
    this.hold = h("button", { type: "button", onclick: () => this.#feed(this.held ? "resume" : "hold") });
    this.hundred = h("button", { type: "button", onclick: () => this.#setOverride(100) }, "Override 100 %");
    this.stopText = h("span", {}, "Stop");
    this.stop = h("button.danger", { type: "button", onclick: () => this.#stop() }, icon("stop"), this.stopText);
    this.feed = h("label.slider", {}, h("span", {}, "Override"), this.override, this.overrideText);
    this.motion = h("div.panel", {}, h("h2", {}, "Motion"), this.feed, h("div.buttons", {}, this.hold, this.hundred, this.stop));
    this.element = h("section.view.drive", { "aria-label": this.title },
      h("div.drive-left", {},
        h("div.panel", {}, h("div.row", {}, this.object, this.control.element)),
        h("div.panel", {}, h("h2", {}, "Jog"), steps.element,
          h("label.slider", {}, h("span", {}, "Speed"), this.speed, this.speedText), this.rows,
          h("label.check", {}, this.keys, "Jog by keys"), this.keyHelp),
        this.motion),
      h("div.panel.form-panel", {}, h("div.row", {}, this.kindHost, this.mnemonic), this.forms),
      h("div.panel.preview-panel", {}, h("h2", {}, "Preview"), host, this.facts.element));
    app.on("preview", () => {
      this.canvas.setPreview(app.preview);
      this.facts.show(app.preview);
    });
    // A form begins with the actual positions, so it begins again when they are known.
    app.store.on("status", () => this.#form(this.chosen), { once: true });
    addEventListener("keydown", (event) => this.#key(event));
    addEventListener("keyup", (event) => this.#keyUp(event));
    app.jogger.on("change", () => this.update());
    this.#select(machine.coordinate_systems[0]?.name ?? machine.axes[0]?.name ?? machine.group);
  }

  show() {
    this.shown = true;
    this.canvas.stage.start(() => true);
  }

  hide() {
    this.shown = false;
    this.app.jogger.endAll();
    this.#heldKeys.clear();
    this.canvas.stage.stop();
  }

  /** @param {string} name */
  #select(name) {
    this.app.jogger.endAll();
    this.object.value = name;
    this.name = name;
    this.system = this.app.store.system(name);
    this.control.show([name]);
    this.axes = this.app.store.axesOf(name);
    fill(this.rows, this.axes.map((axis) => this.#row(axis)));
    const help = this.axes.slice(0, 3).map((axis, k) => `${axis} ${["← →", "↓ ↑", "Page ↓ ↑"][k]}`);
    text(this.keyHelp, `Hold a key to jog: ${help.join(", ")}. Esc stops.`);
    if (this.system) this.canvas.show(name);
    text(this.stopText, `Stop ${name}`);
    this.#showSpeed();
    this.#forms();
    this.update();
  }

  /** Offers the forms that fit the object; of any instruction those for it come first. */
  #forms() {
    const { store } = this.app;
    /** @type {Kind} */
    const kind = this.system ? "CoordinateSystem" : store.axis(this.name) ? "Axis" : "MotionGroup";
    if (kind !== this.objectKind) {
      this.objectKind = kind;
      const forms = FORMS[kind];
      if (!forms.some(([form]) => form === this.chosen)) [[this.chosen]] = forms;
      const { element } = segmented("Form", forms, this.chosen, (form) => this.#form(form));
      fill(this.kindHost, element);
      const kinds = /** @type {Kind[]} */ (Object.keys(KINDS));
      const order = [kind, ...kinds.filter((other) => other !== kind)];
      fill(this.mnemonic, order.map((group) => h("optgroup", { label: KINDS[group] },
        store.catalogue.instructions.filter(({ object }) => object === group).map(({ mnemonic, title }) => h("option", { value: mnemonic }, `${mnemonic}  ${title}`)))));
      this.mnemonic.value = FIRST[kind];
    }
    this.#form(this.chosen);
  }

  /** @param {string} axis */
  #row(axis) {
    const { jogger, store } = this.app;
    const button = (/** @type {number} */ sign, /** @type {string} */ title) => {
      const made = h("button.jog", { type: "button", "aria-label": `Jog ${axis} ${title}`, onclick: () => this.#step && this.#stepAxis(axis, sign) }, sign < 0 ? "−" : "+");
      jogger.attach(made, axis, () => (this.#step ? 0 : sign * this.#speedOf(axis)));
      return made;
    };
    const actual = h("output");
    const servo = h("button", { type: "button", onclick: () => this.app.instruct(store.axisStatus(axis)?.servo_on ? "MSF" : "MSO", axis) });
    const home = h("button", { type: "button", "aria-label": `Home ${axis}`, onclick: () => this.app.instruct("MAH", axis) }, icon("home"), "Home");
    const reset = h("button", { type: "button", "aria-label": `Reset ${axis}`, title: "Clears faults and shutdown (MASR)", onclick: () => this.app.instruct("MASR", axis) }, icon("reset"), "Reset");
    const [less, more] = [button(-1, "backwards"), button(1, "forwards")];
    const note = h("small.bad");
    const element = h("div.jog-row", { "aria-label": `Axis ${axis}`, role: "group" },
      h("span.jog-name", { "data-series": store.series(axis) }, axis), actual, h("abbr", {}, store.configuredAxis(axis).units),
      h("span.jog-buttons", {}, less, more), h("span.jog-actions", {}, servo, home, reset), note);
    this.parts = [...this.parts.filter((other) => this.axes.includes(other.axis) && other.axis !== axis), { axis, element, actual, note, servo, home, reset, less, more }];
    return element;
  }

  /** @param {string} axis */
  #speedOf(axis) {
    return (this.app.store.configuredAxis(axis).max_speed * Number(this.speed.value)) / 100;
  }

  #showSpeed() {
    const axis = this.app.store.axis(this.axes[0]);
    // A machine without axes has nothing to jog.
    if (!axis) return;
    text(this.speedText, `${short(this.#speedOf(axis.name))} ${rate(axis.units, 1)}`);
  }

  /** A step is a move by a length, with the speed of the slider. @param {string} axis @param {number} sign */
  #stepAxis(axis, sign) {
    this.app.instruct("MAM", axis, { MoveType: 1, Position: sign * this.#step, Speed: Number(this.speed.value), SpeedUnits: 1 });
  }

  /** @param {string} kind A mnemonic, or `any`. */
  #form(kind) {
    this.chosen = kind;
    if (!this.app.store.status) return;
    this.mnemonic.hidden = kind !== "any";
    const { store } = this.app;
    const instruction = store.instruction(kind === "any" ? this.mnemonic.value : kind);
    if (!instruction) return;
    const own = instruction.object === this.objectKind ? this.name
      : instruction.object === "CoordinateSystem" ? store.machine.coordinate_systems[0]?.name
      : instruction.object === "Axis" ? this.axes[0] : store.machine.group;
    this.form = new InstructionForm(this.app, instruction, {
      object: own, first: kind === "any" ? null : QUICK[kind], values: kind === "MAM" ? { Position: store.standsAt(own) } : {},
      onobject: (name) => store.system(name) && this.canvas.show(name),
    });
    this.app.setPreview(null);
    fill(this.forms, this.form.element);
  }

  /** @param {number} percent */
  async #setOverride(percent) {
    try {
      await this.app.connection.request("override", { coordinate_system: this.name, percent });
    } catch (error) {
      this.app.toasts.bad(`The override of ${this.name} was not set`, error);
    }
  }

  /** @param {"hold" | "resume"} what */
  async #feed(what) {
    try {
      await this.app.connection.request(what, { coordinate_system: this.name });
    } catch (error) {
      this.app.toasts.bad(`The feed ${what} of ${this.name} was refused`, error);
    }
  }

  async #stop() {
    try {
      await this.app.connection.request("stop", { object: this.name });
    } catch (error) {
      this.app.toasts.bad(`${this.name} could not be stopped`, error);
    }
  }

  /** Keys jog only while they are switched on, this view is shown, and no text field has the focus. @param {KeyboardEvent} event */
  #key(event) {
    if (!this.shown || !this.keys.checked || event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.target instanceof Element && event.target.closest("input:not([type=checkbox]), select, textarea, canvas, .jog")) return;
    const k = KEYS.findIndex((pair) => pair.includes(event.key));
    if (k < 0 || k >= this.axes.length) return;
    event.preventDefault();
    const axis = this.axes[k];
    if (event.repeat || !this.control.mine || this.#heldKeys.has(event.key)) return;
    const sign = KEYS[k].indexOf(event.key) ? 1 : -1;
    if (this.#step) {
      this.#stepAxis(axis, sign);
      return;
    }
    this.#heldKeys.set(event.key, axis);
    this.app.jogger.begin(axis, sign * this.#speedOf(axis));
  }

  /** @param {KeyboardEvent} event */
  #keyUp(event) {
    const axis = this.#heldKeys.get(event.key);
    if (axis === undefined) return;
    this.#heldKeys.delete(event.key);
    this.app.jogger.end(axis);
  }

  #releaseKeys() {
    this.#heldKeys.clear();
    this.app.jogger.endAll();
    this.keys.blur();
  }

  update() {
    const { store, jogger, connection } = this.app;
    this.control.update();
    const mine = this.control.mine && connection.isOpen;
    for (const part of this.parts) {
      const status = store.axisStatus(part.axis);
      if (!status) continue;
      text(part.actual, fixed(status.actual));
      const servo = status.servo_on ? "Servo off" : "Servo on";
      text(part.servo, servo);
      if (part.servo.getAttribute("aria-label") !== `${servo} ${part.axis}`) part.servo.setAttribute("aria-label", `${servo} ${part.axis}`);
      state(part.servo, "on", String(status.servo_on));
      text(part.note, status.faults.map((word) => store.faultText(word)).join(" "));
      state(part.element, "held", String(jogger.holds(part.axis)));
      for (const button of [part.less, part.more]) button.disabled = !mine || !status.servo_on;
      for (const button of [part.servo, part.home, part.reset]) button.disabled = !mine;
    }
    const system = this.system && store.systemStatus(this.system.name);
    // An override and a hold are of a coordinate system, a stop is of everything.
    for (const part of [this.feed, this.hold, this.hundred]) part.hidden = !system;
    this.stop.disabled = !connection.isOpen;
    if (system) {
      this.held = system.held;
      text(this.hold, system.held ? "Resume" : "Feed hold");
      state(this.hold, "on", String(system.held));
      // Every viewer may hold, as it may stop; going on needs control.
      this.override.disabled = !mine;
      this.hundred.disabled = !mine || system.held;
      this.hold.disabled = !connection.isOpen || (system.held && !mine);
      if (document.activeElement !== this.override) {
        this.override.value = String(system.override);
        text(this.overrideText, `${Math.round(system.override)} %`);
      }
    }
    this.#follow();
    this.form?.update();
  }

  /** Until the user chooses a position, the form of a single axis has the present one. */
  #follow() {
    if (this.chosen !== "MAM" || !this.form) return;
    const status = this.app.store.axisStatus(this.form.object);
    const { MoveType: incremental } = this.form.words();
    if (status && !status.moving) this.form.follow("Position", incremental ? 0 : this.app.store.standsAt(this.form.object));
  }
}
