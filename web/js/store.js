// The page's data of the machine: its description, the newest status, the viewers that have control.
// A push has large parts only when they have changed; the store adds the earlier ones.

import { found } from "./dom.js";
import { Emitter } from "./emitter.js";
import { seriesOf } from "./theme.js";

/** The roles, the least first. */
const ROLES = ["viewer", "operator", "engineer", "administrator"];

/** @import { AxisConfiguration, Catalogue, Event, MonitorRow, Machine, ProgramStatus, Push, Status } from "../types/protocol.js" */

/**
 * Events: `status` up to 16 times a second, `program`, `values` of watched tags, `events`, `look` of the controller's program.
 * @extends {Emitter<{ status: void, session: void, program: void, values: Record<string, unknown>, events: Event[], look: { routine: number, rows: MonitorRow[] } }>}
 */
export class Store extends Emitter {
  /** The newest status, with every part. @type {Status | null} */
  status = null;
  /** This viewer's name, as in `status.drivers`. @type {string | null} */
  viewer = null;
  /** The newest `session` push, with this viewer's role. @type {Omit<Extract<Push, { push: "session" }>, "push">} */
  session = { role: "engineer", user: null, locked: false, can_log_in: false };
  /** The newest `program` push. @type {ProgramStatus | null} */
  program = null;

  /** @param {Machine} machine @param {Catalogue} catalogue */
  constructor(machine, catalogue) {
    super();
    /** The answer of `/api/machine`. */
    this.machine = machine;
    /** The answer of `/api/instructions`. */
    this.catalogue = catalogue;
  }

  /** Reads the description of the machine; the page cannot do anything without it. */
  static async load() {
    const [machine, catalogue] = await Promise.all(["/api/machine", "/api/instructions"].map(json));
    return new Store(machine, catalogue);
  }

  /** Takes a push of the server. @param {Push} message */
  take(message) {
    switch (message.push) {
      case "status":
        this.status = merged(this.status, message);
        this.emit("status", undefined);
        break;
      case "hello":
        this.viewer = message.viewer;
        break;
      case "session":
        this.session = message;
        this.emit("session", undefined);
        break;
      case "program":
        this.program = { ...this.program, ...message };
        this.emit("program", undefined);
        break;
      case "values":
        this.emit("values", message.values);
        break;
      case "look":
        this.emit("look", message);
        break;
      case "event":
        this.emit("events", message.events);
        break;
      default:
        unknown(message);
    }
  }

  /** Whether this viewer's role is this one or a greater one. @param {"operator" | "engineer"} role */
  may(role) {
    return ROLES.indexOf(this.session.role) >= ROLES.indexOf(role);
  }

  /** The configuration of an existing axis. @param {string} name */
  configuredAxis(name) {
    return found(this.axis(name), name);
  }

  /** The configuration of a coordinate system that there is. @param {string} name */
  configuredSystem(name) {
    return found(this.system(name), name);
  }

  /** The configuration of an axis, if the name is one. @param {string} name */
  axis(name) {
    return this.machine.axes.find((axis) => axis.name === name);
  }

  /** The configuration of a coordinate system, if the name is one. @param {string} name */
  system(name) {
    return this.machine.coordinate_systems.find((system) => system.name === name);
  }

  /** The units of the position of a robot's tool: those of the linear axes, where they agree, since its links have the same. */
  toolUnits() {
    const linear = new Set(this.machine.axes.filter(({ rotary, units }) => !rotary && !/^deg/i.test(units)).map(({ units }) => units));
    const [units] = linear;
    return linear.size === 1 ? units : "units";
  }

  /** The status of an axis, `undefined` before the first push. @param {string} name */
  axisStatus(name) {
    return this.status?.axes?.find((axis) => axis.name === name);
  }

  /** The position of an axis, without the noise of its drive. @param {string} name */
  standsAt(name) {
    return Math.round((this.axisStatus(name)?.actual ?? 0) * 1e6) / 1e6;
  }

  /** The status of a coordinate system. @param {string} name */
  systemStatus(name) {
    return this.status?.coordinate_systems?.find((system) => system.name === name);
  }

  /** The place of an axis in the configuration, which is also that of its colour. @param {string} name */
  place(name) {
    return this.machine.axes.findIndex((axis) => axis.name === name);
  }

  /** The colour of an axis, as `data-series` of the style sheet. @param {string} name */
  series(name) {
    return seriesOf(this.place(name));
  }

  /** The instruction of a mnemonic. @param {string} mnemonic */
  instruction(mnemonic) {
    return this.catalogue.instructions.find((instruction) => instruction.mnemonic === mnemonic);
  }

  /** The meaning and the remedy of an axis's fault. @param {string} word */
  faultText(word) {
    const meaning = this.catalogue.faults.find((fault) => fault.word === word)?.meaning ?? "";
    // Beyond a travel limit the servo stays on, and the way back is the remedy.
    const remedy = word.startsWith("soft_travel") ? "Press Reset, then jog the axis back inside its travel limits." : "Remove the cause, press Reset, then Servo on.";
    return `${word}: ${meaning} ${remedy}`;
  }

  /** The names of the axes of an axis, a coordinate system or the group. @param {string} object @returns {string[]} */
  axesOf(object) {
    if (object === this.machine.group) return this.machine.axes.map(({ name }) => name);
    return this.system(object)?.axes ?? (this.axis(object) ? [object] : []);
  }

  /** Which viewer controls an object: another one that has one of its axes, this one if it has them all, or `null`. @param {string} object */
  driver(object) {
    const owners = this.axesOf(object).map((axis) => this.status?.drivers?.[axis] ?? null);
    const other = owners.find((owner) => owner !== null && owner !== this.viewer);
    if (other) return other;
    return owners.length && owners.every((owner) => owner === this.viewer) ? this.viewer : null;
  }

  /** Whether this page has control of an object: of all of its axes. @param {string} object */
  drives(object) {
    return this.viewer !== null && this.driver(object) === this.viewer;
  }

  /** The objects under this page's control that have axes in common with an object, or all of them. @param {string} object */
  taken(object = this.machine.group) {
    const axes = new Set(this.axesOf(object));
    const own = Object.entries(this.status?.drivers ?? {}).filter(([, viewer]) => viewer === this.viewer).map(([name]) => name);
    return own.filter((name) => this.axesOf(name).some((axis) => axes.has(axis)));
  }
}

/** A status with the paths of the status before where it has none. @param {Status | null} old @param {Status} fresh @returns {Status} */
function merged(old, fresh) {
  const systems = fresh.coordinate_systems.map((system, k) => ({ ...old?.coordinate_systems[k], ...system }));
  return { ...fresh, coordinate_systems: systems };
}

/** Ignores an unknown push of a newer server; the type checker ensures that the page knows every push of its own server. @param {never} _ */
function unknown(_) {}

/** @param {string} address */
async function json(address) {
  const answer = await fetch(address, { cache: "no-store" });
  if (!answer.ok) throw new Error(`${address}: ${answer.status} ${answer.statusText}`);
  return answer.json();
}
