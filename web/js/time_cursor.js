// The time that Path and Trends show: the present, or a tick of the last minutes.

import { Emitter } from "./emitter.js";

/** @import { Samples } from "./samples.js" */

/** @extends {Emitter<{ change: void }>} */
export class TimeCursor extends Emitter {
  /** @type {number | null} */
  #tick = null;

  /** @param {Samples} samples */
  constructor(samples) {
    super();
    this.samples = samples;
  }

  /** The tick that is shown, `null` for the newest. */
  get tick() {
    return this.#tick;
  }

  /** The displayed tick as a number; the newest if none is chosen. */
  get shown() {
    return this.#tick ?? Math.max(this.samples.end - 1, 0);
  }

  /** Shows one of the stored ticks. @param {number} tick */
  scrub(tick) {
    const { first, end } = this.samples;
    this.#set(Math.round(Math.min(Math.max(tick, first), Math.max(end - 1, first))));
  }

  /** Stays where it is. */
  pause() {
    if (this.#tick === null) this.scrub(this.samples.end - 1);
  }

  /** Stays within the stored ticks: the oldest is forgotten, and a server that began again has another history. */
  keep() {
    const { first, end } = this.samples;
    if (this.#tick === null) return;
    if (this.#tick >= end) this.live();
    else if (this.#tick < first) this.scrub(first);
  }

  /** Shows the newest again. */
  live() {
    this.#set(null);
  }

  /** @param {number | null} tick */
  #set(tick) {
    if (tick === this.#tick) return;
    this.#tick = tick;
    this.emit("change", undefined);
  }
}
