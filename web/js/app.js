// The data and commands that the views share: the connection, the machine as the page knows it, and the commands of several views.

import { Connection } from "./connection.js";
import { Emitter } from "./emitter.js";
import { Executions } from "./executions.js";
import { History } from "./history.js";
import { Jogger } from "./jog.js";
import { Samples } from "./samples.js";
import { Session } from "./session.js";
import { TimeCursor } from "./time_cursor.js";
import { Toasts } from "./toasts.js";

/** @import { Execution } from "./executions.js" */
/** @import { Store } from "./store.js" */
/** @import { Refusal as RefusalMessage, Simulated } from "../types/protocol.js" */

/** Longest time from an event to the answer of its request, ms. */
const ANSWER_MS = 400;
/** A refusal and an event within this time are the same error. */
const REFUSED_MS = 5000;

/**
 * A view of the page. The shell shows one at a time.
 * @typedef {object} View
 * @property {string} title
 * @property {HTMLElement} element
 * @property {boolean} [hasTime] Whether the view shows the chosen moment.
 * @property {boolean} [isHere] False: the machine has no data for the view, and the list does not name it.
 * @property {() => void} [show] Called when the view comes into the page.
 * @property {() => void} [hide] Called when the view leaves the page.
 * @property {() => void} [update] Called with each new status while the view is shown.
 */

/**
 * The page without its views.
 * @extends {Emitter<{ preview: void }>}
 */
export class App extends Emitter {
  toasts = new Toasts(this);
  executions = new Executions();
  /** @type {Simulated | null} */
  preview = null;

  /** @param {Store} store A store that has the description of the machine. */
  constructor(store) {
    super();
    this.store = store;
    this.samples = new Samples(store.machine);
    this.timeCursor = new TimeCursor(this.samples);
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    this.connection = new Connection(`${scheme}://${location.host}/ws`);
    this.session = new Session(this);
    this.history = new History(this);
    this.jogger = new Jogger(this);
  }

  /** Shows a preview in every picture, or none. @param {Simulated | null} preview */
  setPreview(preview) {
    if (preview === this.preview) return;
    this.preview = preview;
    this.emit("preview", undefined);
  }

  /**
   * Shows the error of an instruction, unless the view that executed it shows it: its answer may come after the event.
   * @param {Execution & { error: RefusalMessage }} execution
   */
  erred(execution) {
    const show = () => this.toasts.bad([execution.instruction, execution.tag, execution.object && `on ${execution.object}`].filter(Boolean).join(" "), execution.error);
    if (execution.viewer && execution.viewer !== this.store.viewer) show();
    else setTimeout(() => this.connection.hasRefused(execution.error.text, REFUSED_MS) || show(), ANSWER_MS);
  }

  /** Stops all motion of the machine. */
  async stop() {
    this.jogger.endAll();
    try {
      await this.connection.request("stop", { object: null });
      this.toasts.good("Stop sent to every axis and coordinate system");
    } catch (error) {
      this.toasts.bad("STOP did not reach the machine", error);
    }
  }

  /** Lets motion begin again after STOP. */
  async releaseStop() {
    try {
      await this.connection.request("release_stop", {});
    } catch (error) {
      this.toasts.bad("STOP was not released", error);
    }
  }

  /**
   * Executes an instruction on an object: the server makes the line and executes it.
   * @param {string} mnemonic
   * @param {string} object
   * @param {Record<string, unknown>} [operands] Values by members.
   */
  async instruct(mnemonic, object, operands = {}) {
    const form = this.store.instruction(mnemonic)?.operands ?? [];
    const member = (/** @type {string} */ wanted) => form.find(({ kind }) => kind === wanted)?.member ?? wanted;
    try {
      const { text } = await this.connection.request("line", {
        instruction: mnemonic, operands: { [member("target")]: object, [member("control")]: `Hmi_${mnemonic}_${object}`, ...operands },
      });
      await this.connection.request("execute", { text });
    } catch (error) {
      this.toasts.bad(`${mnemonic} on ${object} was refused`, error);
    }
  }
}
