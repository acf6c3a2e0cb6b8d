// Puts the page together: what it knows, what it shows, and the stop that works everywhere.

import { Connection } from "./connection.js";
import { h } from "./dom.js";
import { Drive } from "./drive.js";
import { Events } from "./events.js";
import { sprite } from "./icons.js";
import { Jogger } from "./jog.js";
import { Lives } from "./lives.js";
import { Machine } from "./machine.js";
import { Moment } from "./moment.js";
import { Past } from "./past.js";
import { Path } from "./path.js";
import { Program } from "./program.js";
import { Samples } from "./samples.js";
import { Shell } from "./shell.js";
import { Store } from "./store.js";
import { Tags } from "./tags.js";
import * as theme from "./theme.js";
import { Toasts } from "./toasts.js";
import { Trends } from "./trends.js";

const RETRY_MS = 1000;
/** The answer to a request comes at most so long after its event. */
const ANSWER_MS = 400;
/** A refusal and an event within this time are the same error. */
const REFUSED_MS = 5000;

/** What every view is given. Events: `preview`. */
class App extends EventTarget {
  toasts = new Toasts(this);
  store = new Store();
  lives = new Lives();
  preview = null;

  constructor() {
    super();
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    this.connection = new Connection(`${scheme}://${location.host}/ws`);
    this.jogger = new Jogger(this);
  }

  /** Shows a preview in every picture, or none. */
  setPreview(preview) {
    if (preview === this.preview) return;
    this.preview = preview;
    this.dispatchEvent(new Event("preview"));
  }

  /** Shows the error of an instruction, unless the view that executed it shows it: its answer may come after the event. */
  erred(life) {
    const show = () => this.toasts.bad([life.instruction, life.tag, life.object && `on ${life.object}`].filter(Boolean).join(" "), life.error);
    if (life.viewer && life.viewer !== this.store.viewer) show();
    else setTimeout(() => this.connection.hasRefused(life.error.text, REFUSED_MS) || show(), ANSWER_MS);
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

  /** Executes an instruction on an object: the server makes the line, the line is what runs. */
  async instruct(mnemonic, object, operands = {}) {
    const instruction = this.store.instruction(mnemonic);
    const [target] = instruction.operands;
    const control = instruction.operands.find(({ kind }) => kind === "control");
    try {
      const { text } = await this.connection.request("line", {
        instruction: mnemonic, operands: { [target.member]: object, [control.member]: `Hmi_${mnemonic}_${object}`, ...operands },
      });
      await this.connection.request("execute", { text });
    } catch (error) {
      this.toasts.bad(`${mnemonic} on ${object} was refused`, error);
    }
  }
}

async function begin() {
  theme.apply();
  const app = new App();
  await loaded(app);
  app.samples = new Samples(app.store.machine);
  app.moment = new Moment(app.samples);
  app.past = new Past(app);
  const events = new Events(app);
  const shell = new Shell(app, [
    ["machine", "machine", new Machine(app)], ["path", "path", new Path(app)], ["trends", "trends", new Trends(app)], ["drive", "drive", new Drive(app)],
    ["program", "program", new Program(app)], ["tags", "tags", new Tags(app)], ["events", "events", events],
  ]);
  document.body.replaceChildren(sprite(), shell.element);
  shell.connected(false);
  const { connection, store, lives } = app;
  connection.addEventListener("open", () => {
    shell.connected(true);
    greet(app);
  });
  connection.addEventListener("lost", () => shell.connected(false));
  connection.addEventListener("push", ({ detail }) => store.take(detail));
  connection.addEventListener("samples", ({ detail }) => {
    app.past.take(detail);
    app.moment.keep();
  });
  store.addEventListener("status", () => {
    shell.update();
    app.toasts.update();
  });
  store.addEventListener("events", ({ detail }) => {
    for (const life of lives.take(detail.events ?? [detail])) {
      app.erred(life);
      events.reveal(life);
    }
  });
  addEventListener("keydown", (event) => {
    if (event.key !== "Escape") return;
    event.preventDefault();
    if (!event.repeat) app.stop();
  }, { capture: true });
  connection.start();
}

/** What is asked for after each connection; a machine that is another one now needs another page. */
async function greet(app) {
  const { connection, lives, store } = app;
  try {
    const answer = await fetch("/api/machine", { cache: "no-store" }).then((response) => response.json());
    if (JSON.stringify(answer) !== JSON.stringify(store.machine)) {
      location.reload();
      return;
    }
    app.past.begin();
    await connection.request("trace", { on: true });
    const { events } = await connection.request("events");
    // Whatever was pushed meanwhile is among them.
    lives.clear();
    lives.take(events);
  } catch (error) {
    app.toasts.bad("The history could not be read", error);
  }
}

/** Waits for a server that is not there yet. */
async function loaded(app) {
  for (;;) {
    try {
      await app.store.load();
      return;
    } catch (error) {
      document.body.replaceChildren(h("p.starting", { role: "alert" }, `No server answers here yet (${error.message}). Trying again…`));
      await new Promise((resolve) => setTimeout(resolve, RETRY_MS));
    }
  }
}

begin();
