// The table of the target position: an end point, the actual position and a via point or centre for each axis.
// The server's table (`target_position`) has the columns and buttons with their names.

import { fill, found, h, text } from "./dom.js";
import { exact, fixed } from "./format.js";
import { number } from "./fields.js";

/** A target follows the machine when it is further away than this, in position units: less is the noise of a drive. */
export const NOISE = 1e-3;

/** The table of an instruction for a coordinate system; `words()` gives the values of the move and circle type. */
export class TargetTable {
  #key = "";
  /** The typed targets by axis. @type {Map<string, string>} */
  #targets = new Map();
  /** Axes whose target a person has chosen; that of the others follows the machine. @type {Set<string>} */
  #chosen = new Set();
  /** The typed vias by axis. @type {Map<string, string>} */
  #vias = new Map();

  /** The cells of the actual positions by axis. @type {Map<string, HTMLElement>} */
  actuals = new Map();
  /** The inputs of the targets by axis. @type {Map<string, HTMLInputElement>} */
  inputs = new Map();
  /** @type {string[]} */
  axes = [];
  /** Called when targets have followed the machine. @type {(() => void) | null} */
  onfollow = null;

  /**
   * @param {import("./app.js").App} app
   * @param {import("../types/protocol.js").InstructionForm} instruction
   * @param {() => Record<string, number>} words
   * @param {() => void} changed
   */
  constructor(app, instruction, words, changed) {
    const rule = found(instruction.target_position, `target position dialog of ${instruction.mnemonic}`);
    this.app = app;
    this.rule = rule;
    this.words = words;
    this.changed = changed;
    this.via = instruction.operands.find(({ member }) => member === rule.vias);
    this.targetButton = h("button", { type: "button", onclick: () => this.#copy(this.#targets) }, "Set Targets = Actuals");
    this.viaButton = h("button", { type: "button", onclick: () => this.#copy(this.#vias) }, "Set Vias = Actuals");
    this.table = h("table.target-table");
    this.element = h("div.target", {}, this.table, h("div.buttons", {}, this.targetButton, rule.vias && this.viaButton));
  }

  /** Takes the axes of a coordinate system; a typed number stays with its axis. @param {string[]} axes */
  show(axes) {
    this.axes = axes;
    for (const axis of axes) {
      if (!this.#targets.has(axis)) this.#targets.set(axis, this.#actual(axis));
      if (!this.#vias.has(axis)) this.#vias.set(axis, "0");
    }
    this.#key = "";
    this.arrange();
  }

  /** The row of the server's table for the words that are chosen. */
  get row() {
    const words = this.words();
    return this.rule.rows.find((row) =>
      row.move_type === words[this.rule.move_type] && (row.circle_type === null || row.circle_type === words[this.rule.circle_type ?? ""]));
  }

  /** Names columns and buttons by the words that are chosen; draws the table again only when it must. */
  arrange() {
    const row = this.row;
    if (!row) return;
    this.targetButton.disabled = !row.targets_from_actuals;
    this.viaButton.disabled = !row.vias_from_actuals;
    const alone = this.via?.single_when;
    this.single = alone?.member ? alone.in.includes(this.words()[alone.member]) : false;
    const key = [row.target, row.via, ...this.axes].join("|");
    if (key === this.#key) return;
    this.#key = key;
    this.actuals = new Map();
    this.inputs = new Map();
    const columns = ["Axis Name", row.target, "Actual Position", row.via].filter((name) => name !== null);
    const head = columns.map((name) => h("th", { scope: "col" }, name));
    const rows = this.axes.map((axis, k) => {
      const actual = h("td.number");
      this.actuals.set(axis, actual);
      const target = this.#input(this.#targets, axis, `${row.target} ${axis}`, this.rule.targets);
      this.inputs.set(axis, target);
      return h("tr", {},
        h("th", { scope: "row" }, h("span.swatch", { "data-series": this.app.store.series(axis) }), axis),
        h("td", {}, target),
        actual,
        row.via && h("td", {}, this.single && k > 0 ? "" : this.#input(this.#vias, axis, this.single ? row.via : `${row.via} ${axis}`, this.rule.vias)));
    });
    fill(this.table, h("thead", {}, h("tr", {}, head)), h("tbody", {}, rows));
    this.update();
  }

  /** @param {Map<string, string>} values @param {string} axis @param {string | null} label @param {string | null} member */
  #input(values, axis, label, member) {
    const input = h("input", {
      type: "text", inputmode: "decimal", autocomplete: "off", "aria-label": label, "data-member": member, "data-axis": axis,
      value: values.get(axis),
      oninput: () => {
        values.set(axis, input.value);
        if (values === this.#targets) this.#chosen.add(axis);
        input.toggleAttribute("aria-invalid", !Number.isFinite(number(input.value)));
        this.changed();
      },
    });
    return input;
  }

  /** @param {string} axis */
  #actual(axis) {
    return exact(this.app.store.standsAt(axis));
  }

  /** Writes the actual positions. While an axis is at rest, a target that no person has chosen is where it stands. */
  update() {
    let moved = false;
    for (const [axis, cell] of this.actuals) {
      const status = this.app.store.axisStatus(axis);
      text(cell, fixed(status?.actual ?? NaN));
      const input = this.inputs.get(axis);
      if (!input || !status || status.moving || this.#chosen.has(axis) || input === document.activeElement) continue;
      const target = this.row?.targets_from_actuals ? this.#actual(axis) : "0";
      if (Math.abs(number(target) - number(this.#targets.get(axis) ?? "")) <= NOISE) continue;
      this.#targets.set(axis, target);
      input.value = target;
      moved = true;
    }
    if (moved) this.onfollow?.();
  }

  /** @param {Map<string, string>} values */
  #copy(values) {
    for (const axis of this.axes) {
      values.set(axis, this.#actual(axis));
      if (values === this.#targets) this.#chosen.add(axis);
    }
    this.#key = "";
    this.arrange();
    this.changed();
  }

  /** The operands of the table; throws the text of an error. */
  read() {
    const list = (/** @type {Map<string, string>} */ values, /** @type {string[]} */ axes) => axes.map((axis) => {
      const value = number(values.get(axis) ?? "");
      if (!Number.isFinite(value)) throw `${axis}: a number is expected`;
      return value;
    });
    const operands = { [this.rule.targets]: list(this.#targets, this.axes) };
    if (this.rule.vias && this.row?.via) operands[this.rule.vias] = list(this.#vias, this.single ? this.axes.slice(0, 1) : this.axes);
    return operands;
  }

  /** Shows numbers that were chosen elsewhere. @param {number[]} targets */
  write(targets) {
    this.axes.forEach((axis, k) => {
      if (!Number.isFinite(targets[k])) return;
      this.#targets.set(axis, exact(targets[k]));
      this.#chosen.add(axis);
    });
    this.#key = "";
    this.arrange();
  }
}
