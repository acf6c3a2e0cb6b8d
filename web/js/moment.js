// The moment that the pictures show: now, or one of the last minutes. All views share it.

/** Events: `change`. */
export class Moment extends EventTarget {
  #tick = null;

  constructor(samples) {
    super();
    this.samples = samples;
  }

  /** The tick that is shown, `null` for the newest. */
  get tick() {
    return this.#tick;
  }

  /** The tick that is shown as a number, whichever it is. */
  get shown() {
    return this.#tick ?? Math.max(this.samples.end - 1, 0);
  }

  /** Shows a tick of those that are kept. */
  scrub(tick) {
    const { first, end } = this.samples;
    this.#set(Math.round(Math.min(Math.max(tick, first), Math.max(end - 1, first))));
  }

  /** Stays where it is. */
  pause() {
    if (this.#tick === null) this.scrub(this.samples.end - 1);
  }

  /** Stays among what is kept: the oldest is forgotten, and a server that began again has another past. */
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

  #set(tick) {
    if (tick === this.#tick) return;
    this.#tick = tick;
    this.dispatchEvent(new Event("change"));
  }
}
