// One field of an instruction's form: what it looks like and how its text becomes an operand. All facts about an
// operand come from `/api/instructions`; nothing about any instruction is known here.

import { h, options } from "./dom.js";
import { exact } from "./format.js";

/** Whether all of an operand's conditions hold for the values `{member: number}`. */
export function isShown(operand, values) {
  return (operand.shown_when ?? []).every(({ member, in: allowed }) => allowed.includes(values[member]));
}

/** Text of a range: `more than 0`, `0 to 100`. */
export function rangeText(range, values = {}) {
  if (!range) return "";
  const most = highest(range, values);
  const least = range.min_exclusive ? `more than ${range.min}` : `${range.min} or more`;
  if (most === null) return range.min === null || range.min === undefined ? "" : least;
  if (range.min === null || range.min === undefined) return `at most ${most}`;
  return range.min_exclusive ? `${least}, at most ${most}` : `${range.min} to ${most}`;
}

function highest(range, values) {
  const { max_when: rule } = range;
  if (rule?.in.includes(values[rule.member])) return rule.max;
  return range.max ?? null;
}

/** What is wrong with a number in a range; `null` if nothing is. */
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

/** A typed number; a comma is taken for a point, a real minus for a hyphen. */
export function number(text) {
  const plain = text.trim().replace(",", ".").replace("\u2212", "-");
  return plain === "" ? NaN : Number(plain);
}

/** Numbers with commas or blanks between them, with or without brackets. */
export function numbers(text) {
  const plain = text.replace(/[[\]]/g, " ").trim();
  return plain === "" ? [] : plain.split(/[\s,;]+/).map(number);
}

/**
 * A field: `{element, read(), write(value)}`. `read` gives the operand's value, or throws a text that says what is wrong.
 */
export function field(operand, app, values, changed) {
  const id = `operand-${operand.member}-${Math.random().toString(36).slice(2, 8)}`;
  const common = { id, "data-member": operand.member, "aria-describedby": `${id}-note`, oninput: changed, onchange: changed };
  const make = { word: words, target: names, reference: names, number: scalar, integer: scalar }[operand.kind] ?? plainText;
  const made = make(operand, app, values, common);
  const note = h("small.field-note", { id: `${id}-note` });
  const label = h("label", { for: id, title: operand.help }, operand.name);
  return { id, operand, label, note, ...made };
}

function words(operand, _app, _values, common) {
  const input = h("select", common);
  options(input, operand.words.map(({ value, title, text }) => [value, title ?? text]), operand.default);
  return { input, read: () => Number(input.value), write: (value) => (input.value = String(value)) };
}

function names(operand, app, _values, common) {
  const { machine } = app.store;
  const lists = { CoordinateSystem: machine.coordinate_systems, Axis: machine.axes };
  const list = lists[operand.object]?.map(({ name }) => name) ?? [machine.group];
  const input = h("select", common);
  options(input, list);
  return { input, read: () => input.value, write: (value) => (input.value = value) };
}

function scalar(operand, _app, values, common) {
  const input = h("input", { ...common, type: "text", inputmode: "decimal", autocomplete: "off", spellcheck: "false", value: exact(operand.default ?? 0) });
  const read = () => {
    const value = number(input.value);
    const wrong = fault(operand, value, values());
    if (wrong) throw wrong;
    return value;
  };
  return { input, read, write: (value) => (input.value = exact(value)) };
}

/** Tags by name, and arrays as lists of numbers or the name of a tag. */
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
  return { input, read, write: (value) => (input.value = Array.isArray(value) ? value.map(exact).join(", ") : value || "") };
}
