// A rung as a picture: contacts, coils and boxes between two rails, wires that show the power flow of the last scan, values of the
// operands. The layout needs no browser; drawing makes SVG once, and later changes only the differences.

/** @import { MonitorRow, Rung, RungElement } from "../types/protocol.js" */

const SVG = "http://www.w3.org/2000/svg";
/** Width of a character of the font of operands, and of that of titles. */
const LETTER = 7.25;
const GAP = 14;
const RAIL = 46;
const LINE = 17;
const LEG_GAP = 10;
/** From the wire of a contact up to its name, and down to its end. */
const UP = 26;
const DOWN = 16;
const CONTACT = 34;
/** The least room of a value in a box, and the most that one takes, characters. */
const VALUE = 9;
const MOST_VALUE = 18;
/** Significant digits of a number. */
const DIGITS = 7;

/** Instructions that are drawn as a contact or a coil, and the sign between its lines. @type {Record<string, [kind: "contact" | "coil", sign: string]>} */
const SIGNS = { XIC: ["contact", ""], XIO: ["contact", "/"], OTE: ["coil", ""], OTL: ["coil", "L"], OTU: ["coil", "U"] };

/**
 * An element with its place: `x` and `y` of the wire at its left end.
 * @typedef {object} Placed
 * @property {RungElement} element
 * @property {number} x
 * @property {number} y
 * @property {number} width
 * @property {number} before Place of the condition in front of it.
 * @property {number} value Place of its first operand among the values of the rung.
 * @property {Leg[]} legs
 */

/**
 * A leg of a branch, or the rung itself.
 * @typedef {object} Leg
 * @property {Placed[]} items
 * @property {number} y Of its wire.
 * @property {number} from
 * @property {number} to
 * @property {number} before
 * @property {number} after Place of the condition at its end.
 */

/** @typedef {{ width: number, up: number, down: number }} Size */

/** @param {RungElement} element */
function signOf(element) {
  return element.operands?.length === 1 ? SIGNS[(element.name ?? "").toUpperCase()] : undefined;
}

/** @param {RungElement} element @returns {Size} */
function sizeOf(element) {
  if (element.legs?.length) {
    const sizes = element.legs.map(seriesSize);
    const width = Math.max(...sizes.map((size) => size.width)) + 2 * GAP;
    const below = sizes.slice(1).reduce((sum, size) => sum + size.up + size.down + LEG_GAP, 0);
    return { width, up: sizes[0].up, down: sizes[0].down + below };
  }
  if (signOf(element)) return { width: Math.max(CONTACT + 2 * GAP, (element.operands?.[0].text.length ?? 0) * LETTER + GAP), up: UP, down: DOWN };
  const rows = element.operands ?? [];
  return { width: boxWidth(element) + 2 * GAP, up: LINE + 4, down: rows.length * LINE + 8 };
}

/** @param {RungElement} element */
function boxWidth(element) {
  const rows = element.operands ?? [];
  const names = Math.max(0, ...rows.map(({ name }) => name.length));
  const texts = Math.max(0, ...rows.map(({ text }) => text.length));
  return Math.max((element.name ?? "").length + (element.title ? element.title.length + 3 : 0), rows.length ? names + texts + VALUE + 4 : 0) * LETTER + 16;
}

/** @param {RungElement[]} elements @returns {Size} */
function seriesSize(elements) {
  const sizes = elements.map(sizeOf);
  const most = (/** @type {"up" | "down"} */ key, /** @type {number} */ least) => Math.max(least, ...sizes.map((size) => size[key]));
  return { width: sizes.reduce((sum, size) => sum + size.width, 0), up: most("up", 12), down: most("down", 12) };
}

/**
 * Places the elements of a rung. The last one stands at the right rail, if the rung is shorter than `width`.
 * @param {Rung} rung @param {number} width
 * @returns {{ leg: Leg, width: number, height: number }}
 */
export function layout(rung, width) {
  const size = seriesSize(rung.elements);
  const inner = Math.max(size.width, width - 2 * RAIL);
  const counter = { value: 0 };
  const leg = place(rung.elements, { x: RAIL, y: size.up + 6, to: RAIL + inner, before: 0, counter, isRung: true });
  return { leg, width: inner + 2 * RAIL, height: size.up + size.down + 12 };
}

/**
 * @param {RungElement[]} elements
 * @param {{ x: number, y: number, to: number, before: number, counter: { value: number }, isRung: boolean }} at
 * @returns {Leg}
 */
function place(elements, { x, y, to, before, counter, isRung }) {
  /** @type {Placed[]} */
  const items = [];
  let left = x;
  let condition = before;
  elements.forEach((element, k) => {
    const size = sizeOf(element);
    if (isRung && k === elements.length - 1) left = Math.max(left, to - size.width);
    /** @type {Placed} */
    const placed = { element, x: left, y, width: size.width, before: condition, value: counter.value, legs: [] };
    counter.value += element.legs?.length ? 0 : element.operands?.length ?? 0;
    let below = y;
    (element.legs ?? []).forEach((leg, number) => {
      const legSize = seriesSize(leg);
      if (number > 0) below += legSize.up;
      placed.legs.push(place(leg, { x: left + GAP, y: below, to: left + size.width - GAP, before: condition, counter, isRung: false }));
      below += legSize.down + LEG_GAP;
    });
    items.push(placed);
    left += size.width;
    condition = element.condition;
  });
  return { items, y, from: x, to, before, after: condition };
}

/** @param {string} name @param {Record<string, string | number>} attributes @param {...(Node | string)} children */
function s(name, attributes, ...children) {
  const element = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, String(value));
  element.append(...children);
  return element;
}

/** A value as it stands at an operand, in `room` characters: a fraction with fewer digits, a text cut off. @param {unknown} value @param {number} room */
export function shown(value, room = MOST_VALUE) {
  if (value === null || value === undefined) return "";
  if (typeof value === "boolean") return value ? "1" : "0";
  let text = String(value);
  if (typeof value === "number" && !Number.isInteger(value)) {
    text = String(Number(value.toPrecision(DIGITS)));
    for (let digits = DIGITS - 1; digits > 0 && text.length > room; digits -= 1) text = String(Number(value.toPrecision(digits)));
  }
  return text.length > room ? `${text.slice(0, room - 1)}…` : text;
}

/** The picture of a rung. */
export class RungPicture {
  /** The elements that show the condition at a place. @type {[element: Element, place: number][]} */
  #wires = [];
  /** The elements that show a value: a text with so much room, or the sign of a bit. @type {[element: Element, value: number, kind: number | "closed" | "open"][]} */
  #values = [];
  #power = "?";

  /** @param {Rung} rung @param {number} width @param {string} label */
  constructor(rung, width, label) {
    const placed = layout(rung, width);
    this.height = placed.height;
    this.element = s("svg", { class: "rung-picture", width: placed.width, height: placed.height, role: "group", "aria-label": label });
    const { leg } = placed;
    const end = placed.width - RAIL;
    this.element.append(s("path", { class: "rail", d: `M${RAIL} 0V${placed.height}M${end} 0V${placed.height}` }));
    this.#leg(leg, end);
  }

  /** @param {string} d @param {number} place */
  #wire(d, place) {
    const wire = s("path", { class: "wire", d });
    this.#wires.push([wire, place]);
    this.element.append(wire);
  }

  /** @param {Leg} leg @param {number} end Where its wire ends. */
  #leg(leg, end) {
    let x = leg.from;
    for (const item of leg.items) {
      if (item.x > x) this.#wire(`M${x} ${leg.y}H${item.x}`, item.before);
      this.#item(item);
      x = item.x + item.width;
    }
    if (end > x) this.#wire(`M${x} ${leg.y}H${end}`, leg.after);
  }

  /** @param {Placed} item */
  #item(item) {
    const { element, x, y, width } = item;
    if (item.legs.length) {
      const [left, right] = [x + GAP, x + width - GAP];
      this.#wire(`M${x} ${y}H${left}`, item.before);
      for (const leg of item.legs) this.#leg(leg, right);
      const bottom = item.legs.at(-1)?.y ?? y;
      this.#wire(`M${left} ${y}V${bottom}`, item.before);
      this.#wire(`M${right} ${y}V${bottom}`, element.condition);
      this.#wire(`M${right} ${y}H${x + width}`, element.condition);
    } else if (signOf(element)) {
      this.#sign(item);
    } else {
      this.#box(item);
    }
  }

  /** @param {string} text @param {Record<string, string | number>} at @param {string} name */
  #operand(text, at, name) {
    const isTag = /[a-z_]/i.test(text) && text !== "?";
    const element = s("text", { class: isTag ? "operand tag-name" : "operand", ...at }, text);
    if (isTag) {
      element.setAttribute("data-tag", text);
      element.setAttribute("role", "button");
      element.setAttribute("tabindex", "0");
      element.append(s("title", {}, name ? `${name}: ${text}` : text));
    }
    this.element.append(element);
  }

  /** A contact or a coil. @param {Placed} item */
  #sign({ element, x, y, width, before, value }) {
    const [kind, sign] = signOf(element) ?? ["contact", ""];
    const middle = x + width / 2;
    const [left, right] = [middle - CONTACT / 2 + 8, middle + CONTACT / 2 - 8];
    const name = (element.name ?? "").toUpperCase();
    const symbol = s("g", { class: `symbol ${kind}` },
      s("rect", { class: "state", x: left - 4, y: y - 11, width: right - left + 8, height: 22, rx: 3 }),
      s("path", { class: "mark", d: kind === "contact" ? `M${left} ${y - 10}V${y + 10}M${right} ${y - 10}V${y + 10}` : `M${left + 2} ${y - 10}Q${left - 8} ${y} ${left + 2} ${y + 10}M${right - 2} ${y - 10}Q${right + 8} ${y} ${right - 2} ${y + 10}` }));
    if (sign === "/") symbol.append(s("path", { class: "mark", d: `M${left + 1} ${y + 8}L${right - 1} ${y - 8}` }));
    else if (sign) symbol.append(s("text", { class: "sign", x: middle, y: y + 4, "text-anchor": "middle" }, sign));
    symbol.append(s("title", {}, `${name}: ${element.title ?? ""}`));
    this.element.append(symbol);
    this.#wire(`M${x} ${y}H${kind === "coil" ? left - 3 : left}`, before);
    this.#wire(`M${kind === "coil" ? right + 3 : right} ${y}H${x + width}`, element.condition);
    this.#values.push([symbol, value, name === "XIO" ? "open" : "closed"]);
    this.#operand(element.operands?.[0].text ?? "", { x: middle, y: y - 15, "text-anchor": "middle" }, "");
  }

  /** @param {Placed} item */
  #box({ element, x, y, width, before, value }) {
    const rows = element.operands ?? [];
    const [left, right, top] = [x + GAP, x + width - GAP, y - LINE];
    this.#wire(`M${x} ${y}H${left}`, before);
    this.#wire(`M${right} ${y}H${x + width}`, element.condition);
    const box = s("rect", { class: "box", x: left, y: top, width: right - left, height: rows.length * LINE + LINE + 8, rx: 3 });
    this.#wires.push([box, element.condition]);
    this.element.append(box, s("text", { class: "box-name", x: left + 8, y: top + 14 }, element.name ?? "", s("tspan", { class: "box-title", dx: 8 }, element.title === element.name ? "" : element.title ?? "")));
    const names = Math.max(0, ...rows.map(({ name }) => name.length));
    const columns = Math.floor((right - left - 16) / LETTER);
    rows.forEach((row, k) => {
      const room = Math.min(columns - names - row.text.length - 2, MOST_VALUE);
      const base = y + LINE * k + 15;
      this.element.append(s("text", { class: "operand-name", x: left + 8, y: base }, row.name));
      this.#operand(row.text, { x: left + 8 + (names + 1) * LETTER, y: base }, row.name);
      const text = s("text", { class: "operand-value", x: right - 8, y: base, "text-anchor": "end" });
      this.#values.push([text, value + k, room]);
      this.element.append(text);
    });
  }

  /** Shows the newest state; `null`: it is not known. @param {MonitorRow | null} row */
  update(row) {
    const power = row?.power ?? "";
    if (power !== this.#power) {
      this.#power = power;
      this.element.setAttribute("data-scanned", String(power !== ""));
      for (const [wire, place] of this.#wires) set(wire, "data-on", power[place] === "1" ? "true" : "false");
    }
    for (const [element, place, kind] of this.#values) {
      const value = row?.values[place];
      if (typeof kind === "number") {
        const text = shown(value, kind);
        if (element.textContent !== text) element.textContent = text;
      } else {
        const known = value !== null && value !== undefined;
        set(element, "data-on", known && Boolean(value) === (kind === "closed") ? "true" : "false");
      }
    }
  }
}

/** @param {Element} element @param {string} name @param {string} value */
function set(element, name, value) {
  if (element.getAttribute(name) !== value) element.setAttribute(name, value);
}
