// What the page knows of the machine: its description, the newest status, who drives what.
// A push holds only what has changed of the heavy parts; the store puts it together.

import { seriesOf } from "./theme.js";

/** Events: `status` (15 times a second), `control`, `program`, `values`, `events`, `hello`. */
export class Store extends EventTarget {
  /** The answer of `/api/machine`. */
  machine = null;
  /** The answer of `/api/instructions`. */
  catalogue = null;
  /** The newest status, with every part. */
  status = null;
  /** This viewer's name, as it stands in `status.drivers`. */
  viewer = null;
  /** The newest `program` push. */
  program = null;

  /** Reads the description of the machine; the page cannot do anything without it. */
  async load() {
    const [machine, catalogue] = await Promise.all(["/api/machine", "/api/instructions"].map(json));
    this.machine = machine;
    this.catalogue = catalogue;
    this.status = null;
  }

  /** Takes a push of the server. */
  take(message) {
    if (message.push === "status") {
      this.status = merged(this.status, message);
    } else if (message.push === "hello") {
      this.viewer = message.viewer;
    } else if (message.push === "program") {
      this.program = { ...this.program, ...message };
    } else if (message.push === "control" && this.status) {
      this.status.drivers = message.drivers ?? this.status.drivers;
    }
    const type = message.push === "event" ? "events" : message.push;
    this.dispatchEvent(new CustomEvent(type, { detail: message }));
  }

  /** The configuration of an axis. */
  axis(name) {
    return this.machine.axes.find((axis) => axis.name === name);
  }

  /** The configuration of a coordinate system. */
  system(name) {
    return this.machine.coordinate_systems.find((system) => system.name === name);
  }

  /** The status of an axis, `undefined` before the first push. */
  axisStatus(name) {
    return this.status?.axes?.find((axis) => axis.name === name);
  }

  /** Where an axis is, without the noise of its drive. */
  standsAt(name) {
    return Math.round((this.axisStatus(name)?.actual ?? 0) * 1e6) / 1e6;
  }

  /** The status of a coordinate system. */
  systemStatus(name) {
    return this.status?.coordinate_systems?.find((system) => system.name === name);
  }

  /** The place of an axis in the configuration, which is also that of its colour. */
  place(name) {
    return this.machine.axes.findIndex((axis) => axis.name === name);
  }

  /** The colour of an axis, as `data-series` of the style sheet. */
  series(name) {
    return seriesOf(this.place(name));
  }

  /** The instruction of a mnemonic. */
  instruction(mnemonic) {
    return this.catalogue.instructions.find((instruction) => instruction.mnemonic === mnemonic);
  }

  /** What has happened when an axis has a fault, and what to do. */
  faultText(word) {
    const meaning = this.catalogue.faults.find((fault) => fault.word === word)?.meaning ?? "";
    // Beyond a travel limit the servo stays on, and the way back is the remedy.
    const remedy = word.startsWith("soft_travel") ? "Press Reset, then jog the axis back inside its travel limits." : "Remove the cause, press Reset, then Servo on.";
    return `${word}: ${meaning} ${remedy}`;
  }

  /** The names of the axes of an axis, a coordinate system or the group. */
  axesOf(object) {
    if (object === this.machine.group) return this.machine.axes.map(({ name }) => name);
    return this.system(object)?.axes ?? (this.axis(object) ? [object] : []);
  }

  /** Which viewer controls an object: another one that has one of its axes, this one if it has them all, or `null`. */
  driver(object) {
    const owners = this.axesOf(object).map((axis) => this.status?.drivers?.[axis] ?? null);
    const other = owners.find((owner) => owner !== null && owner !== this.viewer);
    if (other) return other;
    return owners.length && owners.every((owner) => owner === this.viewer) ? this.viewer : null;
  }

  /** Whether this page has control of an object: of all of its axes. */
  drives(object) {
    return this.viewer !== null && this.driver(object) === this.viewer;
  }

  /** What this page has taken that has axes in common with an object, or at all. */
  taken(object = this.machine.group) {
    const axes = new Set(this.axesOf(object));
    const own = Object.entries(this.status?.drivers ?? {}).filter(([, viewer]) => viewer === this.viewer).map(([name]) => name);
    return own.filter((name) => this.axesOf(name).some((axis) => axes.has(axis)));
  }
}

function merged(old, fresh) {
  if (!old) return fresh;
  const list = (name) => {
    if (!fresh[name]) return old[name];
    return fresh[name].map((item, k) => ({ ...old[name]?.[k], ...item }));
  };
  return { ...old, ...fresh, axes: list("axes"), coordinate_systems: list("coordinate_systems") };
}

async function json(address) {
  const answer = await fetch(address, { cache: "no-store" });
  if (!answer.ok) throw new Error(`${address}: ${answer.status} ${answer.statusText}`);
  return answer.json();
}
