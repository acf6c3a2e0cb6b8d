// Events put together to the lives of instructions: one entry for each execution, with the bits as they came.

const MOST = 1000;

/** The newest executions. Events: `change`. */
export class Lives extends EventTarget {
  /** Newest last. */
  list = [];
  #byKey = new Map();

  /** The newest sequence number, to go on after a break. */
  newest = 0;

  /** Takes events of the server; gives the executions that have just erred. */
  take(events) {
    const erred = [];
    for (const event of events) {
      if (event.seq !== undefined && event.seq <= this.newest) continue;
      this.newest = Math.max(this.newest, event.seq ?? 0);
      const life = this.#life(event);
      life.steps.push(event);
      life.text ??= event.text;
      life.viewer ??= event.viewer;
      for (const bit of event.set ?? []) life.bits.add(bit);
      for (const bit of event.clear ?? []) life.bits.delete(bit);
      if (event.err) {
        life.error = event.error ?? { text: `ERR ${event.err}`, err: event.err, exerr: event.exerr };
        erred.push(life);
      }
    }
    if (events.length) this.dispatchEvent(new Event("change"));
    return erred;
  }

  /** Forgets everything. */
  clear() {
    this.list = [];
    this.#byKey.clear();
    this.newest = 0;
    this.dispatchEvent(new Event("change"));
  }

  #life(event) {
    const key = event.ticket ?? `${event.tag} ${event.seq}`;
    const known = this.#byKey.get(key);
    if (known) return known;
    const life = { key, tag: event.tag, instruction: event.instruction, object: event.object, began: event.time_s, steps: [], bits: new Set(), text: null, viewer: null, error: null };
    this.#byKey.set(key, life);
    this.list.push(life);
    if (this.list.length > MOST) this.#byKey.delete(this.list.shift().key);
    return life;
  }
}

/** In a word: how a life stands. */
export function standing(life) {
  if (life.error || life.bits.has("ER")) return ["bad", "Error"];
  if (life.bits.has("AC")) return ["busy", "Active"];
  if (life.bits.has("PC")) return ["good", "Complete"];
  if (life.bits.has("IP")) return ["busy", "In process"];
  if (life.bits.has("DN")) return ["good", "Done"];
  if (life.bits.has("EN")) return ["calm", "Enabled"];
  return ["calm", "Ended"];
}
