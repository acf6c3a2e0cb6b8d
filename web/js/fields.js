// One field of an instruction's form: its element, and the conversion of its text to an operand. All facts about an
// operand come from `/api/instructions`; this module knows no instruction.

import { h, options } from "./dom.js";
import { exact } from "./format.js";

/** @import { App } from "./app.js" */
/** @import { Attributes } from "../types/dom.js" */
/** @import { OperandForm, RangeForm } from "../types/protocol.js" */

/** Values of the words that are chosen, by member. @typedef {Record<string, number>} Words */

/**
 * The input of a field. `read` returns the operand's value, or throws the text of the error.
 * @typedef {object} Input
 * @property {HTMLInputElement | HTMLSelectElement} input
 * @property {() => string | number | number[]} read
 * @property {(value: unknown) => void} write
 */

/**
 * A field of a form: an operand with its input.
 * @typedef {Input & {
 *   id: string, operand: OperandForm, label: HTMLElement, note: HTMLElement, suffix: HTMLElement, row: HTMLElement, mate: Field | null, hosted: boolean,
 * }} Field
 */

/** Whether all of an operand's conditions hold for the values `{member: number}`. @param {Pick<OperandForm, "shown_when">} operand @param {Words} values */
export function isShown(operand, values) {
  return (operand.shown_when ?? []).every(({ member, in: allowed }) => allowed.includes(values[member ?? ""]));
}

/** Text of a range: `more than 0`, `0 to 100`. @param {RangeForm | null | undefined} range @param {Words} values */
export function rangeText(range, values = {}) {
  if (!range) return "";
  const most = highest(range, values);
  const least = range.min_exclusive ? `more than ${range.min}` : `${range.min} or more`;
  if (most === null) return range.min === null || range.min === undefined ? "" : least;
  if (range.min === null || range.min === undefined) return `at most ${most}`;
  return range.min_exclusive ? `${least}, at most ${most}` : `${range.min} to ${most}`;
}

/** @param {RangeForm} range @param {Words} values @returns {number | null} */
function highest(range, values) {
  const { max_when: rule } = range;
  if (rule?.in.includes(values[rule.member ?? ""])) return rule.max;
  return range.max ?? null;
}

/**
 * The error of a number in a range; `null` without one.
 * @param {Pick<OperandForm, "kind" | "range">} operand
 * @param {number} value
 * @param {Words} values
 * @returns {string | null}
 */
export function fault(operand, value, values) {
  if (!Number.isFinite(value)) return "a number is expected";
  if (operand.kind === "integer" && !Number.isInteger(value)) return "a whole number is expected";
  const { range } = operand;
  if (!range) return null;
  const most = highest(range, values);
  const low = range.min ?? -Infinity;
  const wrong = value < low || (range.min_exclusive && value <= low) || (most !== null && value > most);
  return wrong ? `${rangeText(range, values)} is expected` : null;
}

/** A typed number; a comma is taken for a point, a real minus for a hyphen. @param {string} text */
export function number(text) {
  const plain = text.trim().replace(",", ".").replace("\u2212", "-");
  return plain === "" ? NaN : Number(plain);
}

/** Numbers with commas or blanks between them, with or without brackets. @param {string} text */
export function numbers(text) {
  const plain = text.replace(/[[\]]/g, " ").trim();
  return plain === "" ? [] : plain.split(/[\s,;]+/).map(number);
}

/**
 * The field of an operand. Its `mate` is the field that stands in the same row, with `hosted` set.
 * @param {OperandForm} operand
 * @param {App} app
 * @param {() => Words} values
 * @param {() => void} changed
 * @returns {Field}
 */
export function field(operand, app, values, changed) {
  const id = `operand-${operand.member}-${Math.random().toString(36).slice(2, 8)}`;
  const common = { id, "data-member": operand.member, "aria-describedby": `${id}-note`, oninput: changed, onchange: changed };
  const make = INPUTS[operand.kind] ?? plainText;
  const note = h("small.field-note", { id: `${id}-note` });
  const label = h("label", { for: id, title: operand.help }, operand.name);
  const row = h("div.field", { "data-row": operand.member });
  return { id, operand, label, note, suffix: h("span.suffix"), row, mate: null, hosted: false, ...make(operand, app, values, common) };
}

/** Makes the input of an operand by its kind. @type {Partial<Record<import("../types/protocol.js").OperandKind, typeof scalar>>} */
const INPUTS = { word: words, target: names, reference: names, number: scalar, integer: scalar };

/** @param {OperandForm} operand @param {App} _app @param {() => Words} _values @param {Attributes} common @returns {Input} */
function words(operand, _app, _values, common) {
  const input = h("select", common);
  options(input, (operand.words ?? []).map(({ value, title, text }) => [value, title ?? text]), operand.default);
  return { input, read: () => Number(input.value), write: (value) => (input.value = String(value)) };
}

/** @param {OperandForm} operand @param {App} app @param {() => Words} _values @param {Attributes} common @returns {Input} */
function names(operand, app, _values, common) {
  const { machine } = app.store;
  /** @type {Partial<Record<string, { name: string }[]>>} */
  const lists = { CoordinateSystem: machine.coordinate_systems, Axis: machine.axes };
  const list = lists[operand.object ?? ""]?.map(({ name }) => name) ?? [machine.group];
  const input = h("select", common);
  options(input, list);
  return { input, read: () => input.value, write: (value) => (input.value = String(value)) };
}

/** @param {OperandForm} operand @param {App} _app @param {() => Words} values @param {Attributes} common @returns {Input} */
function scalar(operand, _app, values, common) {
  const input = h("input", { ...common, type: "text", inputmode: "decimal", autocomplete: "off", spellcheck: "false", value: exact(Number(operand.default)) });
  const read = () => {
    const value = number(input.value);
    const wrong = fault(operand, value, values());
    if (wrong) throw wrong;
    return value;
  };
  return { input, read, write: (value) => (input.value = exact(Number(value))) };
}

/**
 * Tags by name, and arrays as lists of numbers or the name of a tag.
 * @param {OperandForm} operand
 * @param {App} _app
 * @param {() => Words} _values
 * @param {Attributes} common
 * @returns {Input}
 */
function plainText(operand, _app, _values, common) {
  const array = operand.kind === "array" || operand.kind === "array_or_none";
  const optional = ["array_or_none", "written_array", "structure_or_none"].includes(operand.kind);
  const tag = optional ? `${operand.type ?? "a tag"}, or empty` : operand.type ?? "a tag";
  const hint = array ? "0, 0, 0 or a tag" : tag;
  const input = h("input", { ...common, type: "text", autocomplete: "off", autocapitalize: "off", spellcheck: "false", placeholder: hint });
  const read = () => {
    const typed = input.value.trim();
    if (typed === "") {
      if (optional) return 0;
      if (operand.kind === "array") return [];
      throw "a tag is expected";
    }
    if (!array || /^[A-Za-z_]/.test(typed)) return typed;
    const list = numbers(typed);
    if (!list.every(Number.isFinite)) throw "numbers with commas between them are expected";
    return list;
  };
  return { input, read, write: (value) => (input.value = Array.isArray(value) ? value.map(exact).join(", ") : String(value || "")) };
}
