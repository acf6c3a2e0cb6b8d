// The form of any instruction, generated from the server's catalogue; the line of Structured Text that it stands for;
// a preview before anything moves; and the button that runs it.

import { refusalOf } from "./connection.js";
import { calm, fill, found, h, icon, state, text } from "./dom.js";
import { field, isShown, rangeText } from "./fields.js";
import { rate } from "./format.js";
import { NOISE, TargetTable } from "./target.js";
import { explanation } from "./toasts.js";

/** @import { Field } from "./fields.js" */
/** @import { OperandForm } from "../types/protocol.js" */

const LINE_MS = 120;
const PREVIEW_MS = 350;
const TAGS = 8;
/** The most requests of one press, since an edit of the form repeats the request. */
const TRIES = 8;
/** Stops need no control. */
export const STOPS = new Set(["MCS", "MAS", "MGS"]);
let lastTag = 0;

/** A form for one instruction. `first` lists members that are always seen; without it all of them are. */
export class InstructionForm {
  /** The travel limit that the preview of a line leaves. @type {{ line: string | null, text: string } | null} */
  beyond = null;
  /** The line that a person wants to execute although it leaves the travel limits. @type {string | null} */
  sure = null;
  /** The checked line, or `null`. @type {string | null} */
  line = null;
  /** Position units of its first axis. */
  units = "";
  /** The object whose axes the table shows. */
  shownObject = "";

  /**
   * @param {import("./app.js").App} app
   * @param {import("../types/protocol.js").InstructionForm} instruction
   * @param {object} choice
   * @param {string} choice.object
   * @param {string[] | null} [choice.first]
   * @param {((object: string) => void) | null} [choice.onobject]
   * @param {Record<string, unknown>} [choice.values]
   */
  constructor(app, instruction, { object, first = null, onobject = null, values = {} }) {
    this.app = app;
    this.instruction = instruction;
    this.onobject = onobject;
    /** @type {Map<string, Field>} */
    this.fields = new Map();
    /** Members of the operands that a person has edited. @type {Set<string>} */
    this.touched = new Set();
    this.asked = 0;
    /** The number of edits, and the edit whose line, or whose error, is known. */
    this.edits = 0;
    this.answered = 0;
    this.isPressed = false;
    const { target_position: rule } = instruction;
    this.table = rule && new TargetTable(app, instruction, () => this.words(), () => this.#edit());
    if (this.table) this.table.onfollow = () => this.#changed();
    for (const operand of instruction.operands) {
      if (rule && (operand.member === rule.targets || operand.member === rule.vias)) continue;
      this.fields.set(operand.member, field(operand, app, () => this.words(), () => this.#edit(operand.member)));
    }
    this.target = instruction.operands[0];
    this.control = instruction.operands.find(({ kind }) => kind === "control");
    for (const [member, value] of Object.entries(values)) this.fields.get(member)?.write(value);
    this.#field(this.target.member).write(object);
    if (this.control) this.#field(this.control.member).write(nextTag());
    this.code = h("code");
    this.copy = h("button", { type: "button", onclick: () => this.#copy() }, icon("copy"), "Copy");
    this.problem = h("div.problem", { role: "alert", hidden: true });
    this.runText = h("span", {}, "Run");
    this.run = h("button.primary.run", { type: "button", onclick: () => this.#run() }, icon("run"), this.runText);
    this.why = h("small.why", { role: "status" });
    this.auto = h("input", { type: "checkbox", checked: true, onchange: () => this.#edit() });
    this.element = h("div.form", { "aria-label": `${instruction.mnemonic}, ${instruction.title}` },
      h("p.form-title", {}, h("b", {}, instruction.mnemonic), ` ${instruction.title}`),
      this.#layout(first),
      h("div.line", { "aria-label": "Structured Text" }, this.code, this.copy),
      this.problem,
      h("div.buttons.run-row", {}, this.run,
        h("button", { type: "button", onclick: () => this.#preview() }, icon("eye"), "Preview"),
        h("label.check", {}, this.auto, "Preview as I type"), this.why));
    this.later = calm(LINE_MS, () => this.#askLine());
    this.laterPreview = calm(PREVIEW_MS, () => this.auto.checked && this.edited && this.#preview(true));
    this.#object();
    this.#changed();
  }

  /** The name of the axis, coordinate system or group that it acts on. */
  get object() {
    return this.#field(this.target.member).input.value;
  }

  /** @param {string} member */
  #field(member) {
    return found(this.fields.get(member), member);
  }

  /** Acts on another object from now on. @param {string} object */
  setObject(object) {
    if (this.object === object) return;
    this.#field(this.target.member).write(object);
    this.#object();
    this.#changed();
  }

  /** Writes a value that no person has chosen: it follows the machine. @param {string} member @param {number} value */
  follow(member, value) {
    const { input, read, write } = this.#field(member);
    if (this.touched.has(member) || input === document.activeElement || Math.abs(Number(read()) - value) <= NOISE) return;
    write(value);
    this.#changed();
  }

  /** The numbers of the words that are chosen. */
  words() {
    /** @type {Record<string, number>} */
    const values = {};
    for (const [member, { operand, input }] of this.fields) if (operand.kind === "word") values[member] = Number(input.value);
    return values;
  }

  /** @param {string[] | null} first */
  #layout(first) {
    const rows = [];
    for (const item of this.fields.values()) {
      const { unit } = item.operand;
      // A number and the word that says its unit stand together; the word has no row of its own.
      const mate = unit && "member" in unit ? this.fields.get(unit.member ?? "") : null;
      if (!mate || mate.hosted) continue;
      mate.hosted = true;
      item.mate = mate;
    }
    for (const [member, item] of this.fields) {
      if (item.hosted) continue;
      const inputs = item.mate ? h("div.pair", {}, item.input, item.mate.input) : h("div.pair", {}, item.input, item.suffix);
      item.mate?.input.setAttribute("aria-label", item.mate.operand.name);
      fill(item.row, item.label, inputs, item.note);
      if (item.mate) item.mate.row = item.row;
      rows.push({ member, row: item.row });
    }
    const seen = (/** @type {string} */ member) => !first || first.includes(member);
    /** @type {HTMLElement[]} */
    const parts = [h("div.fields", {}, rows.filter(({ member }) => seen(member)).map(({ row }) => row))];
    if (this.table) parts.splice(1, 0, this.table.element);
    const more = rows.filter(({ member }) => !seen(member));
    if (more.length) parts.push(h("details.more", {}, h("summary", {}, "All operands"), h("div.fields", {}, more.map(({ row }) => row))));
    return parts;
  }

  #object() {
    const { store } = this.app;
    const { object } = this;
    const axes = store.axesOf(object);
    this.table?.show(axes);
    this.units = store.axis(axes[0])?.units ?? "";
    this.onobject?.(object);
  }

  /** A form shows a preview by itself only after an edit, and not after it has run. @param {string} member */
  #edit(member = "") {
    this.edited = true;
    this.touched.add(member);
    this.#changed();
  }

  #changed() {
    if (this.shownObject !== this.object) {
      this.shownObject = this.object;
      this.#object();
    }
    const words = this.words();
    this.table?.arrange();
    for (const item of this.fields.values()) if (!item.hosted) this.#annotate(item, words);
    this.edits += 1;
    this.later();
  }

  /** @param {Field} item @param {Record<string, number>} words */
  #annotate(item, words) {
    const { operand } = item;
    item.row.hidden = !isShown(operand, words);
    text(item.suffix, this.#unit(operand));
    text(item.note, [operand.help, rangeText(operand.range, words)].filter(Boolean).join(" · "));
  }

  /** @param {OperandForm} operand */
  #unit(operand) {
    const { unit } = operand;
    if (!unit) return "";
    if ("member" in unit) {
      const mate = this.fields.get(unit.member ?? "");
      return mate?.input instanceof HTMLSelectElement ? mate.input.selectedOptions[0]?.textContent ?? "" : "";
    }
    return unit.text === "position" ? rate(this.units, 0) : unit.text;
  }

  /** The operands by member. With an error, it marks the wrong fields and returns `null`. */
  #read() {
    /** @type {Record<string, unknown>} */
    const operands = {};
    const wrong = [];
    const words = this.words();
    for (const [member, item] of this.fields) {
      /** @type {string | null} */
      let problem = null;
      try {
        if (isShown(item.operand, words)) operands[member] = item.read();
      } catch (thrown) {
        if (typeof thrown !== "string") throw thrown;
        problem = thrown;
        wrong.push(`${item.operand.name}: ${thrown}`);
      }
      item.input.toggleAttribute("aria-invalid", problem !== null);
    }
    try {
      Object.assign(operands, this.table?.read());
    } catch (thrown) {
      if (typeof thrown !== "string") throw thrown;
      wrong.push(thrown);
    }
    if (!wrong.length) return operands;
    this.#say({ text: wrong.join("; ") });
    return null;
  }

  /** @param {unknown} error */
  #say(error) {
    this.problem.hidden = !error;
    fill(this.problem, error ? explanation(error) : "");
  }

  async #askLine() {
    const turn = ++this.asked;
    const edit = this.edits;
    const operands = this.#read();
    /** @type {string | null} */
    let line = null;
    /** @type {unknown} */
    let problem = null;
    if (operands) {
      try {
        const answer = await this.app.connection.request("line", { instruction: this.instruction.mnemonic, operands });
        line = answer.text;
      } catch (error) {
        problem = error;
      }
      if (turn !== this.asked) return;
      if (problem) this.#mark(problem);
      this.#say(problem);
    }
    this.answered = edit;
    this.line = line;
    if (line) {
      text(this.code, line);
      this.laterPreview();
    }
    this.update();
  }

  /** The line with the newest edit, which may not have been asked for yet; `null`: there is none, and the form says why. */
  async #newestLine() {
    for (let tries = 0; this.answered !== this.edits && tries < TRIES; tries += 1) await this.#askLine();
    return this.answered === this.edits ? this.line : null;
  }

  /** Marks the operand that an error names: by member, or by EXERR of "Parameter Out Of Range". @param {unknown} error */
  #mark(error) {
    const { err, exerr, member: named } = refusalOf(error);
    const counted = err === 13 && typeof exerr === "number" ? this.instruction.operands[exerr]?.member : null;
    const member = named ?? counted ?? "";
    this.fields.get(member)?.input.setAttribute("aria-invalid", "");
    this.fields.get(member)?.row.closest("details")?.setAttribute("open", "");
  }

  /** @param {boolean} quiet */
  async #preview(quiet = false) {
    const line = quiet ? this.line : await this.#newestLine();
    if (!line || !this.moves) return;
    const turn = this.asked;
    try {
      const preview = await this.app.connection.request("preview", { text: line });
      if (turn !== this.asked) return;
      this.app.setPreview(preview);
      this.beyond = preview.travel && { line, text: preview.travel.text };
      this.#say(null);
    } catch (error) {
      if (turn !== this.asked) return;
      this.app.setPreview(null);
      this.#mark(error);
      if (!quiet || refusalOf(error).err) this.#say(error);
    }
  }

  /** Whether the instruction has a preview: it makes a motion of its own. */
  get moves() {
    return this.instruction.operands.some(({ member }) => member === "Position" || member === "Path");
  }

  /** A press right behind an edit waits for the line with the edit. */
  async #run() {
    if (this.run.disabled || this.isPressed) return;
    this.isPressed = true;
    const line = await this.#newestLine();
    this.isPressed = false;
    if (!line || this.run.disabled) return;
    if (this.beyond?.line === line && this.sure !== line) {
      // As in Logix such a move is accepted, and the axis stops beyond its limit: a person decides, with a second press.
      this.sure = line;
      this.update();
      return;
    }
    this.sure = null;
    try {
      this.edited = false;
      await this.app.connection.request("execute", { text: line });
      this.app.setPreview(null);
      this.#say(null);
      this.app.toasts.good(`${this.instruction.mnemonic} accepted`);
      if (this.control) {
        const { input, write } = this.#field(this.control.member);
        write(nextTag(input.value.trim()));
      }
      this.#changed();
    } catch (error) {
      this.#mark(error);
      this.#say(error);
    }
  }

  async #copy() {
    try {
      await navigator.clipboard.writeText(this.line ?? "");
      this.app.toasts.good("Copied");
    } catch {
      getSelection()?.selectAllChildren(this.code);
    }
  }

  /** Updates the rights and the positions. */
  update() {
    this.table?.update();
    const { store, connection } = this.app;
    const { object } = this;
    const stops = STOPS.has(this.instruction.mnemonic);
    const reason = !connection.isOpen ? "No connection." : !store.may("operator") && !stops ? `As ${store.session.role} you may look and stop.` : !store.drives(object) && !stops ? `Take control of ${object} first.` : !this.line ? "The form is not complete." : "";
    this.run.disabled = reason !== "";
    const asks = this.line !== null && this.sure === this.line;
    text(this.runText, asks ? "Run anyway" : "Run");
    text(this.why, reason || (asks ? `The move leaves the travel limits: ${this.beyond?.text}. Press "Run anyway" to execute it.` : ""));
    state(this.element, "ready", String(reason === ""));
  }
}

/** The next of a few motion control tags; a name that a user has typed stays. @param {string} present */
function nextTag(present = "") {
  if (present !== "" && !/^Hmi[1-8]$/.test(present)) return present;
  lastTag = (lastTag % TAGS) + 1;
  return `Hmi${lastTag}`;
}
