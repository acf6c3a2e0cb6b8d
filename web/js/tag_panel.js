// The panel of one tag beside the rungs: its value, where it is used, and the force of an input.

import { refusalOf } from "./connection.js";
import { fill, h, text } from "./dom.js";
import { plain } from "./format.js";

/** @import { ControllerStatus, UseList } from "../types/protocol.js" */

const INPUT = /:I\d*(?=[.[]|$)/i;

/** The panel. */
export class TagPanel {
  /** The full name of the tag. @type {string | null} */
  tag = null;
  #forces = "";

  /** @param {import("./app.js").App} app @param {{ routines: { routine: number, owner: string, name: string }[], goTo: (routine: number, place: number) => void }} view */
  constructor(app, view) {
    this.app = app;
    this.view = view;
    /** @type {HTMLInputElement} */
    this.input = h("input", { type: "search", placeholder: "Tag, for example Count or Program:Main.Go", "aria-label": "Tag whose uses are shown", autocomplete: "off", spellcheck: "false",
      onkeydown: (event) => event.key === "Enter" && this.choose(this.input.value.trim(), null) });
    this.value = h("output.tag-value");
    this.name = h("b.tag-full-name");
    this.force = h("div.force-row.row", { hidden: true });
    this.note = h("p.empty", {}, "Choose a tag in a rung, or type its name: its value and its uses are shown here.");
    this.uses = h("ul.uses");
    this.element = h("div.panel.tag-panel", {}, h("h2", {}, "Cross-reference"), h("div.row", {}, this.input, h("button", { type: "button", onclick: () => this.choose(this.input.value.trim(), null) }, "Find")),
      h("div.row", {}, this.name, h("span.spring"), this.value), this.force, this.note, this.uses);
    app.store.on("values", (values) => this.tag && this.tag in values && this.#show(values[this.tag]));
  }

  /** Shows a tag that is named in the scope of a program, or of the controller. @param {string} name @param {string | null} program */
  async choose(name, program) {
    if (!name) return;
    try {
      const list = await this.app.connection.request("uses", { tag: name, program });
      this.tag = list.tag;
      this.input.value = list.tag;
      text(this.name, list.tag);
      this.#list(list);
      this.#forces = "";
      const status = this.app.store.status?.controller;
      if (status) this.update(status);
      text(this.value, "");
      const { values } = await this.app.connection.request("watch", { names: [list.tag] });
      this.#show(values[list.tag]);
    } catch (error) {
      fill(this.uses);
      this.note.hidden = false;
      text(this.note, refusalOf(error).text);
    }
  }

  /** @param {UseList} list */
  #list({ uses, more }) {
    this.note.hidden = uses.length > 0;
    text(this.note, "No routine of a program uses this tag.");
    fill(this.uses, uses.map((use) => {
      const routine = this.view.routines.find((one) => one.routine === use.routine);
      return h("li", {}, h("button.bare", { type: "button", onclick: () => this.view.goTo(use.routine, use.index) },
        h("span", {}, `${routine?.owner ?? ""} / ${routine?.name ?? ""}, ${use.line}`), h("small", {}, `${use.instruction || "statement"} ${use.operand}`), use.writes && h("span.chip.set", {}, "writes")));
    }), more && h("li", {}, h("small", {}, "There are more.")));
  }

  /** @param {unknown} value */
  #show(value) {
    text(this.value, value === undefined || (value !== null && typeof value === "object") ? "" : plain(value));
  }

  /** @param {ControllerStatus} status */
  update({ forces }) {
    const { tag } = this;
    const forced = forces.find((one) => one.tag.toLowerCase() === tag?.toLowerCase());
    const may = this.app.store.may("engineer");
    const key = JSON.stringify([tag, forced, may]);
    if (this.#forces === key) return;
    this.#forces = key;
    this.force.hidden = !tag || !INPUT.test(tag);
    if (!tag || this.force.hidden) return;
    const number = h("input", { type: "text", "aria-label": `Forced value of ${tag}`, placeholder: "Value", size: "6", disabled: !may });
    const button = (/** @type {string} */ title, /** @type {() => unknown} */ value) => h("button", { type: "button", disabled: !may, title: may ? "" : "An engineer may force inputs", onclick: () => this.#force(tag, value()) }, title);
    const given = () => number.value.trim() === "" ? undefined : Number(number.value);
    fill(this.force, forced && h("span.pill", { "data-kind": "warn" }, `Forced to ${plain(forced.value)}`), button("Force 0", () => 0), button("Force 1", () => 1), number, button("Force", given), forced && button("Remove force", () => null));
  }

  /** @param {string} tag @param {unknown} value */
  async #force(tag, value) {
    try {
      if (value === undefined || Number.isNaN(value)) throw new Error("type a number first");
      await this.app.connection.request("force", { tag, value });
    } catch (error) {
      this.app.toasts.bad(`${tag} was not forced`, error);
    }
  }
}
