// Elements in one call, and writing to them only when something has changed.
// Not a framework: there is no state here, and nothing is drawn again by itself.

/**
 * An element. `spec` is a tag with classes (`"button.primary"`); attributes that begin with `on` are listeners,
 * `true` is an attribute without value, `null`, `false` and `undefined` leave it out.
 */
export function h(spec, attributes = {}, ...children) {
  const [tag, ...classes] = spec.split(".");
  const element = document.createElement(tag || "div");
  if (classes.length) element.className = classes.join(" ");
  for (const [name, value] of Object.entries(attributes)) set(element, name, value);
  append(element, children);
  return element;
}

function set(element, name, value) {
  if (value === null || value === undefined || value === false) return;
  if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
  else if (name === "value") element.value = value;
  else element.setAttribute(name, value === true ? "" : String(value));
}

/** Appends strings, nodes and lists of them; `null` and `false` are left out. */
export function append(parent, children) {
  for (const child of children.flat(Infinity)) {
    if (child === null || child === undefined || child === false) continue;
    parent.append(child);
  }
}

/** Gives an element these children instead of the ones it has. */
export function fill(parent, ...children) {
  parent.replaceChildren();
  append(parent, children);
}

/** A picture of the sprite; it is decoration, the text beside it says what it means. */
export function icon(name) {
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  svg.setAttribute("class", "icon");
  svg.setAttribute("aria-hidden", "true");
  const use = document.createElementNS("http://www.w3.org/2000/svg", "use");
  use.setAttribute("href", `#i-${name}`);
  svg.append(use);
  return svg;
}

/** Writes a text only when it differs: an unchanged node costs no layout. */
export function text(element, value) {
  if (element.textContent !== value) element.textContent = value;
}

/** Sets a class by a condition. */
export function toggle(element, name, on) {
  if (element.classList.contains(name) !== Boolean(on)) element.classList.toggle(name, Boolean(on));
}

/** A `data-…` attribute, which the style sheets look at. */
export function state(element, name, value) {
  if (element.dataset[name] !== value) element.dataset[name] = value;
}

/** A custom property of the style sheets, such as the share of a bar. */
export function property(element, name, value) {
  if (element.style.getPropertyValue(name) !== value) element.style.setProperty(name, value);
}

/** A set of chips that is drawn again only when their names have changed. */
export function chips(element, names, kind = "chip", none = "") {
  const key = names.join("\n");
  if (element.dataset.key === key) return;
  element.dataset.key = key;
  fill(element, names.length ? names.map((name) => h(`span.${kind}`, {}, name)) : none);
}

/** One choice of several as buttons that are beside each other; gives the element and a way to set the choice. */
export function segmented(label, choices, chosen, onchange) {
  const buttons = choices.map(([value, title, hint]) =>
    h("button", { type: "button", title: hint, "data-value": value, onclick: () => choose(value, true) }, title));
  const element = h("div.segmented", { role: "group", "aria-label": label }, buttons);
  function choose(value, told) {
    for (const button of buttons) button.setAttribute("aria-pressed", String(button.dataset.value === String(value)));
    if (told) onchange(value);
  }
  choose(chosen, false);
  return { element, choose: (value) => choose(value, false) };
}

/** Fills a `select` with names and keeps the choice if it is still there. */
export function options(select, choices, chosen = select.value) {
  fill(select, choices.map((choice) => {
    const [value, title] = Array.isArray(choice) ? choice : [choice, choice];
    return h("option", { value }, title);
  }));
  select.value = String(chosen);
  if (select.selectedIndex < 0 && select.options.length) select.selectedIndex = 0;
}

/** Calls `action` when no further call has come for `delay` milliseconds. */
export function calm(delay, action) {
  let timer = 0;
  return (...values) => {
    clearTimeout(timer);
    timer = setTimeout(() => action(...values), delay);
  };
}

/** A value that is there; its absence is a mistake of the page. @template T @param {T | undefined | null} value @param {string} name @returns {T} */
export function found(value, name) {
  if (value === undefined || value === null) throw new Error(`there is no ${name}`);
  return value;
}
