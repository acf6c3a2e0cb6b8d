// The list of executions of instructions and changes of faults, put together from the events of the server.

import { Emitter } from "./emitter.js";

/** @import { EndCause, Event, FaultEvent, InstructionEvent, Refusal, RestEvent } from "../types/protocol.js" */

/**
 * An execution of an instruction, a change of the faults of an axis, or a rest of a planned contour on its way.
 * @typedef {object} Execution
 * @property {string | number} key
 * @property {string | null} tag Name of the motion control tag; of the axis for a fault, of the coordinate system for a rest.
 * @property {string} instruction
 * @property {string | null} object
 * @property {number} began Machine time, s.
 * @property {number} at Time of the day, ms since 1970.
 * @property {Event[]} steps Its events, at least one.
 * @property {Set<string>} bits Bits that are set.
 * @property {string | null} text Its line of Structured Text.
 * @property {string | null} viewer
 * @property {Refusal | null} error
 * @property {(EndCause & { at: number, time: number }) | null} ended
 * @property {{ axis: string | null, words: string[] }[]} remain Faults that came again after it reset them.
 * @property {FaultEvent} [fault]
 * @property {RestEvent} [rest]
 */

const MOST = 1000;

/**
 * The newest executions and faults.
 * @extends {Emitter<{ change: void }>}
 */
export class Executions extends Emitter {
  /** Newest last. @type {Execution[]} */
  list = [];
  /** @type {Map<string | number, Execution>} */
  #byKey = new Map();
  /** The ticket of the last instruction that cleared faults of an axis. @type {Map<string | null, number>} */
  #lastReset = new Map();

  /** The newest sequence number, to go on after a break. */
  newest = 0;

  /**
   * Takes events of the server; gives the executions that have just erred.
   * @param {Event[]} events
   * @returns {(Execution & { error: Refusal })[]}
   */
  take(events) {
    const erred = [];
    for (const event of events) {
      if (event.seq <= this.newest) continue;
      this.newest = event.seq;
      if ("fault" in event) {
        this.#fault(event);
        continue;
      }
      if ("rest" in event) {
        this.#rest(event);
        continue;
      }
      const execution = this.#execution(event);
      execution.steps.push(event);
      execution.text ??= event.text;
      execution.viewer ??= event.viewer;
      if (event.ended) execution.ended = { ...event.ended, at: event.at_ms, time: event.time_s };
      for (const bit of event.set ?? []) execution.bits.add(bit);
      for (const bit of event.clear ?? []) execution.bits.delete(bit);
      if (event.err) {
        const error = event.error ?? { text: `ERR ${event.err}`, err: event.err, exerr: event.exerr };
        erred.push(Object.assign(execution, { error }));
      }
    }
    if (events.length) this.emit("change", undefined);
    return erred;
  }

  /** Forgets everything. */
  clear() {
    this.list = [];
    this.#byKey.clear();
    this.newest = 0;
    this.emit("change", undefined);
  }

  /** @param {InstructionEvent & Event} event */
  #execution(event) {
    const known = this.#byKey.get(event.ticket);
    if (known) return known;
    return this.#add({ key: event.ticket, tag: event.tag, instruction: event.instruction, object: event.object, began: event.time_s, at: event.at_ms, steps: [], bits: new Set(), text: null, viewer: null, error: null, ended: null, remain: [] });
  }

  /** A change of the faults of an axis; marks the reset that has not helped. @param {{ fault: FaultEvent } & Event} event */
  #fault(event) {
    const { axis, set, again, clear, by } = event.fault;
    this.#add({ key: `fault ${event.seq}`, tag: axis, instruction: "Fault", object: "", began: event.time_s, at: event.at_ms, steps: [event], bits: new Set(), text: null, viewer: null, error: null, ended: null, remain: [], fault: event.fault });
    if (by?.by === "instruction" && clear.length) this.#lastReset.set(axis, by.ticket);
    const reset = set.length && again.length ? this.#byKey.get(this.#lastReset.get(axis) ?? -1) : null;
    reset?.remain.push({ axis, words: again });
  }

  /** A planned contour came to rest between moves that go on. @param {{ rest: RestEvent } & Event} event */
  #rest(event) {
    this.#add({ key: `rest ${event.seq}`, tag: event.rest.system, instruction: "Rest", object: "", began: event.time_s, at: event.at_ms, steps: [event], bits: new Set(), text: null, viewer: null, error: null, ended: null, remain: [], rest: event.rest });
  }

  /** @param {Execution} execution */
  #add(execution) {
    this.#byKey.set(execution.key, execution);
    this.list.push(execution);
    if (this.list.length > MOST) this.#byKey.delete(this.list.shift()?.key ?? "");
    return execution;
  }
}

/** The state of an execution: a kind for its colour, a word, and a sentence where there is more to say. @param {Execution} execution @returns {[string, string, string?]} */
export function standing(execution) {
  if (execution.fault) return faulted(execution.fault);
  if (execution.rest) return ["bad", execution.rest.slow === "program" ? "Program too slow" : "Planner too slow", `${execution.rest.text} (${execution.rest.count} since the start)`];
  if (execution.error || execution.bits.has("ER")) return ["bad", "Error"];
  if (execution.remain.length) {
    const faults = execution.remain.map(({ axis, words }) => `${axis} ${words.join(", ")}`).join("; ");
    return ["bad", "Still faulted", `The cause of the fault is still there: ${faults}`];
  }
  if (execution.bits.has("AC")) return ["busy", "Active"];
  if (execution.bits.has("PC")) return ["good", "Complete"];
  if (execution.bits.has("IP")) return ["busy", "In process"];
  if (execution.ended) {
    const { by, text } = execution.ended;
    const why = text[0].toUpperCase() + text.slice(1);
    if (by === "fault") return ["bad", "Stopped by a fault", why];
    return ["calm", text.startsWith("superseded") ? "Superseded" : "Stopped", why];
  }
  if (execution.bits.has("DN")) return ["good", "Done"];
  if (execution.bits.has("EN")) return ["calm", "Enabled"];
  return ["calm", "Ended"];
}

/** @param {FaultEvent} fault @returns {[string, string, string?]} */
function faulted({ set, again, clear, by }) {
  if (set.length) return ["bad", again.length ? "Faulted again" : "Faulted", `${set.join(", ")}${again.length ? ": the cause is still there" : ""}`];
  return ["calm", "Cleared", `${clear.join(", ")}${by?.by === "instruction" ? ` by ${by.instruction}` : ""}`];
}
