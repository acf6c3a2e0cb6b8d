// Events put together to the lives of instructions, one entry for each execution with the bits as they came, and to the faults
// of axes, one entry for each change.

const MOST = 1000;

/** The newest executions and faults. Events: `change`. */
export class Lives extends EventTarget {
  /** Newest last. */
  list = [];
  #byKey = new Map();
  /** The ticket of the last instruction that cleared faults of an axis. */
  #lastReset = new Map();

  /** The newest sequence number, to go on after a break. */
  newest = 0;

  /** Takes events of the server; gives the executions that have just erred. */
  take(events) {
    const erred = [];
    for (const event of events) {
      if (event.seq !== undefined && event.seq <= this.newest) continue;
      this.newest = Math.max(this.newest, event.seq ?? 0);
      if (event.fault) {
        this.#fault(event);
        continue;
      }
      const life = this.#life(event);
      life.steps.push(event);
      life.text ??= event.text;
      life.viewer ??= event.viewer;
      if (event.ended) life.ended = { ...event.ended, at: event.at_ms, time: event.time_s };
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
    return this.#add({ key, tag: event.tag, instruction: event.instruction, object: event.object, began: event.time_s, at: event.at_ms, steps: [], bits: new Set(), text: null, viewer: null, error: null, ended: null, remain: [] });
  }

  /** A change of the faults of an axis; a reset that has not helped learns so. */
  #fault(event) {
    const { axis, set, again, clear, by } = event.fault;
    this.#add({ key: `fault ${event.seq}`, tag: axis, instruction: "Fault", object: "", began: event.time_s, at: event.at_ms, steps: [event], bits: new Set(), fault: event.fault });
    if (by?.ticket !== undefined && clear.length) this.#lastReset.set(axis, by.ticket);
    const reset = set.length && again.length ? this.#byKey.get(this.#lastReset.get(axis)) : null;
    if (reset) {
      reset.remain.push({ axis, words: again });
    }
  }

  #add(life) {
    this.#byKey.set(life.key, life);
    this.list.push(life);
    if (this.list.length > MOST) this.#byKey.delete(this.list.shift().key);
    return life;
  }
}

/** In a word: how a life stands, and why in a sentence where there is more to say. */
export function standing(life) {
  if (life.fault) return faulted(life.fault);
  if (life.error || life.bits.has("ER")) return ["bad", "Error"];
  if (life.remain.length) {
    const faults = life.remain.map(({ axis, words }) => `${axis} ${words.join(", ")}`).join("; ");
    return ["bad", "Still faulted", `The cause of the fault is still there: ${faults}`];
  }
  if (life.bits.has("AC")) return ["busy", "Active"];
  if (life.bits.has("PC")) return ["good", "Complete"];
  if (life.bits.has("IP")) return ["busy", "In process"];
  if (life.ended) {
    const { by, text } = life.ended;
    const why = text[0].toUpperCase() + text.slice(1);
    if (by === "fault") return ["bad", "Stopped by a fault", why];
    return ["calm", text.startsWith("superseded") ? "Superseded" : "Stopped", why];
  }
  if (life.bits.has("DN")) return ["good", "Done"];
  if (life.bits.has("EN")) return ["calm", "Enabled"];
  return ["calm", "Ended"];
}

function faulted({ set, again, clear, by }) {
  if (set.length) return ["bad", again.length ? "Faulted again" : "Faulted", `${set.join(", ")}${again.length ? ": the cause is still there" : ""}`];
  return ["calm", "Cleared", `${clear.join(", ")}${by?.instruction ? ` by ${by.instruction}` : ""}`];
}
