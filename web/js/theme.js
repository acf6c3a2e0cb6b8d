// Light, dark, or the system's setting; and the colours of the style sheet for a canvas.

import { keep } from "./keep.js";

/**
 * The colours of the style sheets for a canvas.
 * @typedef {Record<"text" | "muted" | "faint" | "line" | "grid" | "panel" | "canvas" | "accent" | "ok" | "warn" | "bad" | "preview" | "trail" | "path" | "pending" | "font", string>
 *   & { series: string[], systems: string[] }} Palette
 */

const KEY = "arcline.theme";
/** Colours of axes and of coordinate systems in the style sheet. */
export const SERIES = 12;
export const SYSTEMS = 4;
/** @typedef {"auto" | "light" | "dark"} Choice */
/** @type {Choice[]} */
const ORDER = ["auto", "light", "dark"];
const system = matchMedia("(prefers-color-scheme: dark)");
/** @type {Set<() => void>} */
const listeners = new Set();
/** @type {Palette | null} */
let colours = null;

/** The choice that the browser keeps. */
export function choice() {
  const kept = keep.get(KEY);
  return ORDER.find((known) => known === kept) ?? "auto";
}

/** The next choice in the order auto, light, dark. */
export function next() {
  keep.set(KEY, ORDER[(ORDER.indexOf(choice()) + 1) % ORDER.length]);
  apply();
}

/** Puts the choice into effect; call once at the start. */
export function apply() {
  const chosen = choice();
  const dark = chosen === "dark" || (chosen === "auto" && system.matches);
  document.documentElement.dataset.theme = dark ? "dark" : "light";
  colours = null;
  for (const listener of listeners) listener();
}

/** Calls `listener` after every change. @param {() => void} listener */
export function onchange(listener) {
  listeners.add(listener);
}

/** The colours for a canvas, read once for each change. @returns {Palette} */
export function palette() {
  if (colours) return colours;
  const style = getComputedStyle(document.documentElement);
  const read = (/** @type {string} */ name) => style.getPropertyValue(name).trim();
  const fresh = {
    text: read("--text"), muted: read("--muted"), faint: read("--faint"), line: read("--line"), grid: read("--grid"),
    panel: read("--panel"), canvas: read("--canvas"), accent: read("--accent"), ok: read("--ok"), warn: read("--warn"),
    bad: read("--bad"), preview: read("--preview"), trail: read("--trail"), path: read("--path"), pending: read("--pending"),
    series: Array.from({ length: SERIES }, (_, k) => read(`--series-${k}`)),
    systems: Array.from({ length: SYSTEMS }, (_, k) => read(`--system-${k}`)), font: read("--font"),
  };
  colours = fresh;
  return fresh;
}

/** The place of an axis's colour among those of the style sheet (`data-series`). */
export const seriesOf = (/** @type {number} */ place) => place % SERIES;

/** The colour of an axis, the same in every view. @param {number} place */
export function axisColour(place) {
  return palette().series[seriesOf(place)];
}

/** The colour of a coordinate system: no axis has it. @param {number} place */
export function systemColour(place) {
  return palette().systems[place % SYSTEMS];
}

/** The dashes of a line in a trend: without them for the first use of a colour, longer ones for each further use. @param {number} place @param {number} colours */
export function dashes(place, colours) {
  const round = Math.floor(place / colours);
  return round ? [3 * round, 3] : [];
}

system.addEventListener("change", apply);
