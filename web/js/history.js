// The samples from before the page came, asked for piece by piece, newest first, and put beside the samples. A piece is asked for
// when the one before has come, so that a slow network carries the present too.

import { Samples } from "./samples.js";

/** Asks for the past after each connection. */
export class History {
  #turn = 0;
  /** The end of the samples from before the connection, until its first frame has come. @type {number | null} */
  #known = null;
  #before = 0;

  /** @param {import("./app.js").App} app */
  constructor(app) {
    this.app = app;
  }

  /** A connection is there: its frames are about to come. */
  begin() {
    this.#turn += 1;
    this.#known = this.app.samples.end;
  }

  /** Takes a binary message. @param {ArrayBuffer} buffer */
  take(buffer) {
    const { samples } = this.app;
    if (Samples.isHistory(buffer)) {
      samples.fill(buffer, this.#before);
      return;
    }
    const start = samples.add(buffer);
    if (start === null || this.#known === null) return;
    const known = samples.first < start ? this.#known : 0;
    this.#known = null;
    this.#load(start, known);
  }

  /** Fills the ticks from `known` to before `before`, as far as the server has them. @param {number} before @param {number} known */
  async #load(before, known) {
    const { connection, samples } = this.app;
    const turn = this.#turn;
    this.#before = before;
    try {
      while (this.#before > Math.max(known, samples.end - samples.capacity)) {
        const { rows, first } = await connection.request("history", { before: this.#before });
        if (turn !== this.#turn || !rows) return;
        this.#before = first;
      }
    } catch {
      // The connection is lost: the next one asks again.
    }
  }
}
