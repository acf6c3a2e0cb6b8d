// A list of which the page has the visible rows only. Rows have different heights, and an unknown height is an estimate. The row
// at the top does not move when heights above it become known.

import { h } from "./dom.js";

/** Rows beyond the visible ones that are drawn too. */
const BEYOND = 1;

/** @typedef {{ element: HTMLElement, height: number }} Drawn */

/** The first row whose end is below a place; `tops` has one entry more than there are rows. @param {number[]} tops @param {number} y */
export function rowAt(tops, y) {
  let [low, high] = [0, Math.max(0, tops.length - 2)];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (tops[middle + 1] <= y) low = middle + 1;
    else high = middle;
  }
  return low;
}

/** The list. */
export class Rows {
  /** @type {(number | null)[]} */
  #heights = [];
  /** Place of the top of each row, then of the end. */
  #tops = [0];
  /** @type {Map<number, HTMLElement>} */
  #mounted = new Map();
  #frame = 0;

  /**
   * @param {object} options
   * @param {number} options.estimate Height of a row that is not known.
   * @param {(row: number) => Drawn | null} options.draw A row; `null`: it is not known yet.
   * @param {(from: number, count: number) => void} options.onview Called with the visible rows when they have changed.
   */
  constructor({ estimate, draw, onview }) {
    this.estimate = estimate;
    this.draw = draw;
    this.onview = onview;
    this.from = 0;
    this.count = 0;
    this.inner = h("div.rows-inner");
    this.element = h("div.rows", { tabindex: "0", onscroll: () => this.#later() }, this.inner);
    new ResizeObserver(() => this.#later()).observe(this.element);
  }

  /** Shows another list from its beginning. @param {number} count */
  reset(count) {
    this.#heights = new Array(count).fill(null);
    this.#mounted.clear();
    this.inner.replaceChildren();
    this.element.scrollTop = 0;
    this.count = 0;
    this.#measure();
    this.#view();
  }

  /** Rows have become known: draws those that are visible. */
  known() {
    this.#view();
  }

  /** Draws all rows anew. */
  redraw() {
    this.#mounted.clear();
    this.inner.replaceChildren();
    this.#heights.fill(null);
    this.#measure();
    this.#view();
  }

  /** The rows that are drawn. */
  get mounted() {
    return this.#mounted;
  }

  /** Scrolls a row into the upper part of the view. @param {number} row */
  reveal(row) {
    const top = this.#tops[Math.min(row, this.#tops.length - 1)] ?? 0;
    this.element.scrollTop = Math.max(0, top - this.element.clientHeight / 4);
    this.#view();
  }

  #measure() {
    let top = 0;
    this.#tops = [0];
    for (const height of this.#heights) {
      top += height ?? this.estimate;
      this.#tops.push(top);
    }
    this.inner.style.height = `${top}px`;
  }

  #later() {
    if (this.#frame) return;
    this.#frame = requestAnimationFrame(() => {
      this.#frame = 0;
      this.#view();
    });
  }

  #view() {
    const { element } = this;
    if (!element.clientHeight || !this.#heights.length) return;
    // A newly measured height moves the visible rows: measure again until they stay.
    for (let round = 0; round < 4; round += 1) {
      const first = rowAt(this.#tops, element.scrollTop);
      const inside = element.scrollTop - this.#tops[first];
      const last = rowAt(this.#tops, element.scrollTop + element.clientHeight);
      const [from, to] = [Math.max(0, first - BEYOND), Math.min(this.#heights.length - 1, last + BEYOND)];
      const changed = this.#mount(from, to);
      if (changed) {
        this.#measure();
        element.scrollTop = this.#tops[first] + inside;
      }
      for (const [row, drawn] of this.#mounted) {
        const top = `${this.#tops[row]}px`;
        if (drawn.style.top !== top) drawn.style.top = top;
      }
      if (from !== this.from || to - from + 1 !== this.count) {
        [this.from, this.count] = [from, to - from + 1];
        this.onview(from, this.count);
      }
      if (!changed) return;
    }
  }

  /** Draws the rows of a range and takes away the others; whether a height has changed. @param {number} from @param {number} to */
  #mount(from, to) {
    let changed = false;
    for (const [row, element] of this.#mounted) {
      if (row >= from && row <= to) continue;
      element.remove();
      this.#mounted.delete(row);
    }
    for (let row = from; row <= to; row += 1) {
      if (this.#mounted.has(row)) continue;
      const drawn = this.draw(row);
      if (!drawn) continue;
      this.#mounted.set(row, drawn.element);
      this.inner.append(drawn.element);
      if (this.#heights[row] !== drawn.height) {
        this.#heights[row] = drawn.height;
        changed = true;
      }
    }
    return changed;
  }
}
