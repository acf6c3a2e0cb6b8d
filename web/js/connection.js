// The WebSocket: requests with answers, pushes, binary samples; and knowing at once that the server is gone.
// It reconnects by itself. It keeps nothing: what a page has shown before is for the store to say.

const SILENCE_MS = 1500;
const ANSWER_MS = 10_000;
/** Simulations wait for each other. */
const PATIENT = { preview: 120_000, dry_run: 120_000 };
const FIRST_PAUSE_MS = 250;
const LONGEST_PAUSE_MS = 2000;
/** So many different refusals are remembered. */
const MOST_REFUSALS = 32;

/** A refusal of the server, with `err`, `exerr`, `cause`, `remedy`, `line`, `column` as far as it has them. */
export class Refusal extends Error {
  constructor(error) {
    super(error.text ?? "refused");
    Object.assign(this, error);
  }
}

/**
 * Events: `open`, `lost`, `push` (detail: the message), `samples` (detail: an ArrayBuffer).
 */
export class Connection extends EventTarget {
  #socket = null;
  #requests = new Map();
  #next = 1;
  #pause = FIRST_PAUSE_MS;
  #heard = 0;
  #opened = false;
  /** When the server refused a request, by the text of its refusal. */
  #refused = new Map();

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

  /** Begins to connect; after that the connection looks after itself. */
  start() {
    const socket = new WebSocket(this.url);
    socket.binaryType = "arraybuffer";
    this.#socket = socket;
    this.#heard = performance.now();
    socket.onopen = () => {
      this.#pause = FIRST_PAUSE_MS;
      this.#opened = true;
      this.#tell("open");
    };
    socket.onmessage = ({ data }) => {
      if (socket === this.#socket) this.#take(data);
    };
    socket.onclose = () => {
      if (socket === this.#socket) this.#lost();
    };
  }

  /** Sends a request and gives its answer; rejects with a `Refusal`. */
  request(what, fields = {}) {
    if (!this.#opened) return Promise.reject(new Refusal({ text: "no connection to the server" }));
    const id = this.#next++;
    return new Promise((resolve, reject) => {
      const most = PATIENT[what] ?? ANSWER_MS;
      const timer = setTimeout(() => this.#finish(id, { error: { text: `no answer to ${what} within ${most / 1000} s` } }), most);
      this.#requests.set(id, { resolve, reject, timer });
      this.#socket.send(JSON.stringify({ id, do: what, ...fields }));
    });
  }

  /** Whether a request was refused with this text within the last `time` ms. */
  hasRefused(text, time) {
    return performance.now() - (this.#refused.get(text) ?? -Infinity) < time;
  }

  /** Sends a request whose answer does not matter, such as the keep-alive of a jog. */
  tell(what, fields = {}) {
    if (this.#opened) this.#socket.send(JSON.stringify({ id: this.#next++, do: what, ...fields }));
  }

  #take(data) {
    this.#heard = performance.now();
    if (typeof data !== "string") {
      this.#tell("samples", data);
      return;
    }
    const message = JSON.parse(data);
    if (message.push) this.#tell("push", message);
    else this.#finish(message.id, message);
  }

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
    if (this.#refused.size > MOST_REFUSALS) this.#refused.delete(this.#refused.keys().next().value);
    request.reject(new Refusal(answer.error));
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
    this.#tell("lost");
    setTimeout(() => this.start(), this.#pause);
    this.#pause = Math.min(this.#pause * 2, LONGEST_PAUSE_MS);
  }

  #tell(type, detail = null) {
    this.dispatchEvent(new CustomEvent(type, { detail }));
  }
}
