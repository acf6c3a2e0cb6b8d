// Elements in one call, and writing to them only when something has changed.
// Not a framework: there is no state here, and nothing is drawn again by itself.

/** @import { Attributes, Child, ElementOf } from "../types/dom.js" */

/**
 * An element. `spec` is a tag with classes (`"button.primary"`); attributes that begin with `on` are listeners,
 * `true` is an attribute without value, `null`, `false` and `undefined` leave it out.
 * @template {string} Spec
 * @param {Spec} spec
 * @param {Attributes} [attributes]
 * @param {...Child} children
 * @returns {ElementOf<Spec>}
 */
export function h(spec, attributes = {}, ...children) {
  const [tag, ...classes] = spec.split(".");
  const element = document.createElement(tag || "div");
  if (classes.length) element.className = classes.join(" ");
  for (const [name, value] of Object.entries(attributes)) set(element, name, value);
  append(element, children);
  return /** @type {ElementOf<Spec>} */ (element);
}

/** @param {HTMLElement} element @param {string} name @param {unknown} value */
function set(element, name, value) {
  if (value === null || value === undefined || value === false) return;
  if (name.startsWith("on")) element.addEventListener(name.slice(2), /** @type {EventListener} */ (value));
  else if (name === "value") /** @type {HTMLInputElement} */ (element).value = String(value);
  else element.setAttribute(name, value === true ? "" : String(value));
}

/** Appends strings, nodes and lists of them; `null` and `false` are left out. @param {Element} parent @param {Child[]} children */
export function append(parent, children) {
  for (const child of children) {
    if (Array.isArray(child)) append(parent, child);
    else if (child !== null && child !== undefined && child !== false) parent.append(child);
  }
}

/** Gives an element these children instead of the ones it has. @param {Element} parent @param {...Child} children */
export function fill(parent, ...children) {
  parent.replaceChildren();
  append(parent, children);
}

/** A picture of the sprite. It is decoration; the text beside it has the meaning. @param {string} name */
export function icon(name) {
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  svg.setAttribute("class", "icon");
  svg.setAttribute("aria-hidden", "true");
  const use = document.createElementNS("http://www.w3.org/2000/svg", "use");
  use.setAttribute("href", `#i-${name}`);
  svg.append(use);
  return svg;
}

/** Writes a text only when it differs: an unchanged node costs no layout. @param {Node} element @param {string} value */
export function text(element, value) {
  if (element.textContent !== value) element.textContent = value;
}

/** Sets a class by a condition. @param {Element} element @param {string} name @param {boolean} on */
export function toggle(element, name, on) {
  if (element.classList.contains(name) !== Boolean(on)) element.classList.toggle(name, Boolean(on));
}

/** Sets a `data-…` attribute, which the style sheets select by. @param {HTMLElement} element @param {string} name @param {string} value */
export function state(element, name, value) {
  if (element.dataset[name] !== value) element.dataset[name] = value;
}

/** A custom property of the style sheets, such as the share of a bar. @param {HTMLElement} element @param {string} name @param {string} value */
export function property(element, name, value) {
  if (element.style.getPropertyValue(name) !== value) element.style.setProperty(name, value);
}

/**
 * A set of chips that is drawn again only when their names have changed.
 * @param {HTMLElement} element
 * @param {string[]} names
 * @param {string} kind
 * @param {string} none
 */
export function chips(element, names, kind = "chip", none = "") {
  const key = names.join("\n");
  if (element.dataset.key === key) return;
  element.dataset.key = key;
  fill(element, names.length ? names.map((name) => h(`span.${kind}`, {}, name)) : none);
}

/**
 * One choice of several as buttons that are beside each other; gives the element and a function that sets the choice.
 * @template {string | number} Value
 * @param {string} label
 * @param {[value: Value, title: string, hint?: string][]} choices
 * @param {Value | undefined} chosen
 * @param {(value: Value) => void} onchange Called when a person has made a choice.
 */
export function segmented(label, choices, chosen, onchange) {
  const buttons = choices.map(([value, title, hint]) =>
    h("button", { type: "button", title: hint, "data-value": value, onclick: () => {
      choose(value);
      onchange(value);
    } }, title));
  const element = h("div.segmented", { role: "group", "aria-label": label }, buttons);
  /** @param {Value | undefined} value */
  function choose(value) {
    for (const button of buttons) button.setAttribute("aria-pressed", String(button.dataset.value === String(value)));
  }
  choose(chosen);
  return { element, choose };
}

/**
 * Fills a `select` with names and keeps the choice if it is still there.
 * @param {HTMLSelectElement} select
 * @param {(string | [value: string | number, title: string])[]} choices
 * @param {unknown} [chosen]
 */
export function options(select, choices, chosen = select.value) {
  fill(select, choices.map((choice) => {
    const [value, title] = Array.isArray(choice) ? choice : [choice, choice];
    return h("option", { value }, title);
  }));
  select.value = String(chosen);
  if (select.selectedIndex < 0 && select.options.length) select.selectedIndex = 0;
}

/**
 * Calls `action` when no further call has come for `delay` milliseconds.
 * @template {unknown[]} Values
 * @param {number} delay
 * @param {(...values: Values) => void} action
 * @returns {(...values: Values) => void}
 */
export function calm(delay, action) {
  let timer = 0;
  return (...values) => {
    clearTimeout(timer);
    timer = setTimeout(() => action(...values), delay);
  };
}

/**
 * Makes a function that returns true when it last returned true at least `ms` milliseconds ago, and at its first call. Views use it for numbers
 * that change faster than people read: each new text makes the browser lay out and paint the page.
 * @param {number} ms
 * @returns {() => boolean}
 */
export function seldom(ms) {
  let at = -Infinity;
  return () => {
    const now = performance.now();
    if (now - at < ms) return false;
    at = now;
    return true;
  };
}

/** A value that is there; its absence is a mistake of the page. @template T @param {T | undefined | null} value @param {string} name @returns {T} */
export function found(value, name) {
  if (value === undefined || value === null) throw new Error(`there is no ${name}`);
  return value;
}
