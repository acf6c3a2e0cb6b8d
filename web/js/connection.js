// The WebSocket: requests with answers, pushes, binary samples, and the immediate detection of a lost server.
// It reconnects by itself. It stores no data: the store has the state that the page has shown.

import { Emitter } from "./emitter.js";

/** @import { Push, Refusal as RefusalMessage, Requests } from "../types/protocol.js" */

const SILENCE_MS = 1500;
const ANSWER_MS = 10_000;
/** Simulations wait for each other. @type {Partial<Record<keyof Requests, number>>} */
const PATIENT = { preview: 120_000, dry_run: 120_000 };
const FIRST_PAUSE_MS = 250;
const LONGEST_PAUSE_MS = 2000;
/** The code of the close of a socket whose session has ended. */
const SESSION_ENDED = 4401;
/** The most different refusals that the connection remembers. */
const MOST_REFUSALS = 32;

/** A refusal of the server, with `err`, `exerr`, `cause`, `remedy`, `line`, `column` as far as it has them. */
export class Refusal extends Error {
  /** @param {RefusalMessage} error */
  constructor(error) {
    super(error.text);
    this.text = error.text;
    this.err = error.err;
    this.exerr = error.exerr;
    this.cause = error.cause;
    this.concerns = error.concerns;
    this.remedy = error.remedy;
    this.line = error.line;
    this.column = error.column;
    this.member = error.member;
    this.control = error.control;
    this.holder = error.holder;
  }
}

/** The known parts of a failure: a refusal as the server sent it, or the message of another error. @param {unknown} error @returns {RefusalMessage} */
export function refusalOf(error) {
  if (error instanceof Refusal) return error;
  if (error instanceof Error) return { text: error.message };
  const isMessage = error !== null && typeof error === "object" && "text" in error;
  return isMessage ? /** @type {RefusalMessage} */ (error) : { text: String(error) };
}

/**
 * Events: `push` with the message, `samples` with a binary frame, `ended` with the reason for which the session of the page has ended.
 * @extends {Emitter<{ open: void, lost: void, push: Push, samples: ArrayBuffer, ended: string }>}
 */
export class Connection extends Emitter {
  /** @type {WebSocket | null} */
  #socket = null;
  /** @type {Map<number, { resolve: (answer: any) => void, reject: (refusal: Refusal) => void, timer: number }>} */
  #requests = new Map();
  #next = 1;
  #pause = FIRST_PAUSE_MS;
  #heard = 0;
  #opened = false;
  /** When the server refused a request, by the text of its refusal. @type {Map<string, number>} */
  #refused = new Map();

  /** @param {string} url */
  constructor(url) {
    super();
    this.url = url;
    this.lostAt = 0;
    setInterval(() => this.#watch(), SILENCE_MS / 3);
  }

  /** Whether requests can be sent. */
  get isOpen() {
    return this.#opened;
  }

  /** Begins to connect; after that the connection reconnects by itself. */
  start() {
    const socket = new WebSocket(this.url);
    socket.binaryType = "arraybuffer";
    this.#socket = socket;
    this.#heard = performance.now();
    socket.onopen = () => {
      this.#pause = FIRST_PAUSE_MS;
      this.#opened = true;
      this.emit("open", undefined);
    };
    socket.onmessage = ({ data }) => {
      if (socket === this.#socket) this.#take(data);
    };
    socket.onclose = ({ code, reason }) => {
      if (socket !== this.#socket) return;
      if (code === SESSION_ENDED) {
        this.emit("ended", reason);
        this.#atOnce();
      } else {
        this.#lost();
      }
    };
  }

  /** The socket, unless it is not open yet or the server is closing it. */
  #usable() {
    const socket = this.#socket;
    return this.#opened && socket?.readyState === WebSocket.OPEN ? socket : null;
  }

  /**
   * Sends a request and gives its answer; rejects with a `Refusal`.
   * @template {keyof Requests} R
   * @param {R} what
   * @param {{} extends Requests[R]["fields"] ? [fields?: Requests[R]["fields"]] : [fields: Requests[R]["fields"]]} fields
   * @returns {Promise<Requests[R]["answer"]>}
   */
  request(what, ...[fields]) {
    const socket = this.#usable();
    if (!socket) return Promise.reject(new Refusal({ text: "no connection to the server" }));
    const id = this.#next++;
    return new Promise((resolve, reject) => {
      const most = PATIENT[what] ?? ANSWER_MS;
      const timer = setTimeout(() => this.#finish(id, { error: { text: `no answer to ${what} within ${most / 1000} s` } }), most);
      this.#requests.set(id, { resolve, reject, timer });
      socket.send(JSON.stringify({ id, do: what, ...fields }));
    });
  }

  /** Whether a request was refused with this text within the last `time` ms. @param {string} text @param {number} time */
  hasRefused(text, time) {
    return performance.now() - (this.#refused.get(text) ?? -Infinity) < time;
  }

  /**
   * Sends a request whose answer does not matter.
   * @template {keyof Requests} R
   * @param {R} what
   * @param {Requests[R]["fields"]} fields
   */
  tell(what, fields) {
    this.#usable()?.send(JSON.stringify({ id: this.#next++, do: what, ...fields }));
  }

  /** @param {string | ArrayBuffer} data */
  #take(data) {
    this.#heard = performance.now();
    if (typeof data !== "string") {
      this.emit("samples", data);
      return;
    }
    const message = JSON.parse(data);
    if (message.push) this.emit("push", message);
    else this.#finish(message.id, message);
  }

  /** @param {number} id @param {{ ok?: unknown, error?: RefusalMessage }} answer */
  #finish(id, answer) {
    const request = this.#requests.get(id);
    if (!request) return;
    this.#requests.delete(id);
    clearTimeout(request.timer);
    if (!answer.error) {
      request.resolve(answer.ok ?? {});
      return;
    }
    this.#refused.set(answer.error.text, performance.now());
    const [oldest] = this.#refused.keys();
    if (this.#refused.size > MOST_REFUSALS) this.#refused.delete(oldest);
    request.reject(new Refusal(answer.error));
  }

  /** Connects anew at once, with the cookies that the browser has now. */
  renew() {
    const old = this.#socket;
    this.#atOnce();
    old?.close();
  }

  /** Connects again without a pause. */
  #atOnce() {
    this.#pause = 0;
    this.#lost();
    this.#pause = FIRST_PAUSE_MS;
  }

  /** A server that says nothing is gone, whatever the operating system thinks of its socket. */
  #watch() {
    if (!this.#socket || performance.now() - this.#heard < SILENCE_MS) return;
    const silent = this.#socket;
    this.#lost();
    silent.close();
  }

  #lost() {
    this.#socket = null;
    if (this.#opened || !this.lostAt) this.lostAt = performance.now();
    this.#opened = false;
    for (const id of [...this.#requests.keys()]) this.#finish(id, { error: { text: "the connection was lost" } });
    this.emit("lost", undefined);
    setTimeout(() => this.start(), this.#pause);
    this.#pause = Math.min(this.#pause * 2, LONGEST_PAUSE_MS);
  }
}
