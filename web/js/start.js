// Builds the page: its data, its views, and the STOP that works in all of them.

import { App } from "./app.js";
import { Controller } from "./controller.js";
import { h } from "./dom.js";
import { Drive } from "./drive.js";
import { Events } from "./events.js";
import { sprite } from "./icons.js";
import { Machine } from "./machine.js";
import { Path } from "./path.js";
import { Program } from "./program.js";
import { Shell } from "./shell.js";
import { Store } from "./store.js";
import { Tags } from "./tags.js";
import * as theme from "./theme.js";
import { Trends } from "./trends.js";

const RETRY_MS = 1000;

async function begin() {
  theme.apply();
  const app = new App(await loaded());
  const events = new Events(app);
  const shell = new Shell(app, [
    ["machine", "machine", new Machine(app)], ["path", "path", new Path(app)], ["trends", "trends", new Trends(app)], ["drive", "drive", new Drive(app)],
    ["program", "program", new Program(app)], ["controller", "ladder", new Controller(app)], ["tags", "tags", new Tags(app)], ["events", "events", events],
  ]);
  document.body.replaceChildren(sprite(), shell.element);
  shell.connected(false);
  const { connection, store, executions } = app;
  connection.on("open", () => {
    shell.connected(true);
    greet(app);
  });
  connection.on("lost", () => shell.connected(false));
  connection.on("push", (message) => store.take(message));
  connection.on("samples", (frame) => {
    app.history.take(frame);
    app.timeCursor.keep();
  });
  store.on("status", () => {
    shell.update();
    app.toasts.update();
  });
  store.on("events", (news) => {
    for (const execution of executions.take(news)) {
      app.erred(execution);
      events.reveal(execution);
    }
  });
  addEventListener("keydown", (event) => {
    if (event.key !== "Escape") return;
    event.preventDefault();
    if (!event.repeat) app.stop();
  }, { capture: true });
  connection.start();
}

/** Asks for the history after each connection; another machine needs another page. @param {App} app */
async function greet(app) {
  const { connection, executions, store } = app;
  try {
    const answer = await fetch("/api/machine", { cache: "no-store" }).then((response) => response.json());
    if (JSON.stringify(answer) !== JSON.stringify(store.machine)) {
      location.reload();
      return;
    }
    app.history.begin();
    await connection.request("trace", { on: true });
    const { events } = await connection.request("events");
    // Whatever was pushed meanwhile is among them.
    executions.clear();
    executions.take(events);
  } catch (error) {
    app.toasts.bad("The history could not be read", error);
  }
}

/** Reads the description of the machine, as often as it takes until a server answers. */
async function loaded() {
  for (;;) {
    try {
      return await Store.load();
    } catch (error) {
      const why = error instanceof Error ? error.message : String(error);
      document.body.replaceChildren(h("p.starting", { role: "alert" }, `No server answers here yet (${why}). Trying again…`));
      await new Promise((resolve) => setTimeout(resolve, RETRY_MS));
    }
  }
}

begin().catch((error) => {
  // Without this a mistake of the page would be an empty page.
  console.error(error);
  document.body.replaceChildren(h("p.starting", { role: "alert" }, `The page could not start: ${error instanceof Error ? error.message : error}`));
});
