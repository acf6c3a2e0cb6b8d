// The view of the whole machine: axes, coordinate systems, the group, the health of the tick.

import { chips, fill, h, icon, property, state, text } from "./dom.js";
import { duration, fixed, rate } from "./format.js";

/** @import { AxisConfiguration, AxisStatus, SystemConfiguration, SystemStatus } from "../types/protocol.js" */

/** Bits of an axis's status words and the motion of the axis while one is set, the most specific first. */
const DOING = [["HomingStatus", "Homing"], ["JogStatus", "Jogging"], ["PositionCamStatus", "Following a cam"], ["TimeCamStatus", "Following a cam"],
  ["GearingStatus", "Geared"], ["MoveStatus", "Moving (MAM)"], ["CoordinatedMotionStatus", "Coordinated move"], ["ControlledByTransformStatus", "Moved by a transform"], ["StoppingStatus", "Stopping"]];

export class Machine {
  title = "Machine";

  /** @param {import("./app.js").App} app */
  constructor(app) {
    this.app = app;
    const { machine } = app.store;
    this.axes = machine.axes.map((axis) => this.row(axis));
    this.systems = machine.coordinate_systems.map((system) => this.card(system));
    this.health = Object.fromEntries(["state", "tick", "p50", "p99", "max", "missed"].map((name) => [name, h("dd")]));
    this.groupBits = statusBits();
    this.faults = h("ul.faults", { "aria-label": "Faults and what to do", hidden: true });
    const head = ["Axis", "Command", "Actual", "Error", "Velocity", "State", "Moved by", "Homed", "Servo", "Faults"];
    this.element = h("section.view.machine", { "aria-label": this.title },
      h("div.panel.axes", {}, h("h2", {}, "Axes"),
        h("div.scroll-x", { tabindex: "0", role: "region", "aria-label": "Axes" }, h("table.axis-table", {},
          h("thead", {}, h("tr", {}, head.map((name) => h("th", { scope: "col" }, name)))),
          h("tbody", {}, this.axes.map(({ row }) => row)))), this.faults),
      h("div.systems", {}, this.systems.map(({ element }) => element)),
      h("div.panel.group", {}, h("h2", {}, `Group ${machine.group}`),
        h("dl.health", {}, h("dt", {}, "State"), this.health.state, h("dt", {}, "Tick"), this.health.tick,
          h("dt", {}, "Tick lateness: median"), this.health.p50, h("dt", {}, "99 %"), this.health.p99,
          h("dt", {}, "maximum"), this.health.max, h("dt", {}, "Missed ticks"), this.health.missed),
        this.groupBits.element));
  }

  /** @param {AxisConfiguration} axis */
  row(axis) {
    const place = this.app.store.series(axis.name);
    const cell = (/** @type {string} */ label, kind = "td") => h(kind, { "data-label": label });
    const cells = {
      command: cell("Command", "td.number"), actual: cell("Actual", "td.number.strong"), error: cell("Error", "td.number"),
      velocity: cell("Velocity", "td.number"), state: cell("State"), mover: cell("Moved by"), homed: cell("Homed"), servo: cell("Servo"), faults: cell("Faults"),
    };
    const bar = h("span.bar");
    const velocity = h("span");
    cells.velocity.append(velocity, bar);
    const row = h("tr", {}, h("th", { scope: "row" }, h("span.swatch", { "data-series": place }), axis.name, h("small", {}, ` ${axis.units} · ${axis.type}`)), Object.values(cells));
    return { axis, row, ...cells, bar, velocity };
  }

  /** @param {SystemConfiguration} system */
  card(system) {
    const part = {
      active: h("p.active-move"), progress: h("progress", { max: 1, value: 0, "aria-label": "Progress of the active move" }),
      pending: h("p.pending-moves"), speed: h("output.big"), speedBar: h("span.bar"), override: h("dd"), position: h("dd.number"),
      driver: h("dd"), mover: h("dd"), bits: statusBits(),
    };
    const units = this.app.store.axis(system.axes[0])?.units ?? "";
    const axes = system.axes.map((name) => h("span.axis-name", { "data-series": this.app.store.series(name) }, name));
    const element = h("article.panel.system", { "aria-label": system.name },
      h("header", {}, h("h2", {}, system.name), h("span.axis-names", {}, axes), h("span.spring"), h("span.path-speed", {}, part.speed, " ", h("abbr", {}, rate(units, 1)))),
      part.speedBar, part.active, part.progress, part.pending,
      h("dl.facts", {}, h("dt", {}, "Position"), part.position, h("dt", {}, "Override"), part.override, h("dt", {}, "Control"), part.driver, h("dt", {}, "Moved by"), part.mover), part.bits.element);
    return { system, element, ...part };
  }

  update() {
    const { store } = this.app;
    const { status } = store;
    if (!status) return;
    for (const row of this.axes) this.#updateAxis(row, store.axisStatus(row.axis.name));
    for (const part of this.systems) this.#updateSystem(part, store.systemStatus(part.system.name));
    const faults = status.axes.flatMap(({ name, faults: words }) => words.map((word) => `${name} ${word}`));
    this.faults.hidden = !faults.length;
    if (this.told !== faults.join()) {
      this.told = faults.join();
      fill(this.faults, faults.map((fault) => {
        const [name, word] = fault.split(" ");
        return h("li", {}, h("b", {}, `${name} `), store.faultText(word));
      }));
    }
    const { realtime, group } = status;
    const micro = (/** @type {number} */ value) => (Number.isFinite(value) ? `${Math.round(value)} µs` : "–");
    text(this.health.state, group.bits.includes("GroupSynced") ? "Synchronized" : "–");
    text(this.health.tick, `${status.tick} · ${duration(status.time_s)}`);
    text(this.health.p50, micro(realtime?.p50_us));
    text(this.health.p99, micro(realtime?.p99_us));
    text(this.health.max, micro(realtime?.max_us));
    text(this.health.missed, String(realtime?.missed ?? "–"));
    state(this.health.missed, "kind", realtime?.missed ? "warn" : "calm");
    this.groupBits.show(group?.bits ?? []);
  }

  /** @param {ReturnType<Machine["row"]>} row @param {AxisStatus | undefined} status */
  #updateAxis(row, status) {
    if (!status) return;
    const { axis } = row;
    text(row.command, fixed(status.command));
    text(row.actual, fixed(status.actual));
    text(row.error, fixed(status.error, 4));
    text(row.velocity, fixed(status.velocity, 2));
    property(row.bar, "--share", share(status.velocity, axis.max_speed));
    text(row.state, standing(status));
    const title = `CIP axis state: ${status.state}`;
    if (row.state.title !== title) row.state.title = title;
    state(row.state, "kind", status.faults.length ? "bad" : status.moving ? "busy" : "calm");
    text(row.mover, status.moved_by ?? "–");
    text(row.homed, status.homed ? "Homed" : "Not homed");
    state(row.homed, "kind", status.homed ? "calm" : "warn");
    text(row.servo, status.servo_on ? "On" : "Off");
    state(row.servo, "kind", status.servo_on ? "good" : "warn");
    chips(row.faults, status.faults, "chip.bad", "–");
  }

  /** @param {ReturnType<Machine["card"]>} part @param {SystemStatus | undefined} status */
  #updateSystem(part, status) {
    if (!status) return;
    const { store } = this.app;
    text(part.speed, fixed(status.speed, 1));
    property(part.speedBar, "--share", share(status.speed, part.system.max_speed));
    const { active } = status;
    text(part.active, active ? `${active.instruction} ${active.tag || "unnamed"}` : "No active move");
    state(part.active, "kind", active ? "busy" : "calm");
    part.progress.hidden = !active;
    if (active) {
      part.progress.value = active.progress ?? 0;
      const rest = [`${Math.round(100 * (active.progress ?? 0))} %`];
      if (Number.isFinite(active.remaining)) rest.push(`${fixed(active.remaining, 1)} to go`);
      if (active.eta_s !== null) rest.push(duration(active.eta_s));
      text(part.active, `${active.instruction} ${active.tag || "unnamed"} · ${rest.join(" · ")}`);
    }
    const waiting = status.pending.map(({ tag, instruction }) => `${instruction} ${tag || "unnamed"}`);
    text(part.pending, waiting.length ? `Pending: ${waiting.slice(0, 4).join(", ")}${waiting.length > 4 ? ` and ${waiting.length - 4} more` : ""}` : "Nothing pending");
    text(part.override, `${fixed(status.override, 0)} %${status.held ? ", held" : ""}`);
    state(part.override, "kind", status.held ? "warn" : "calm");
    const position = status.position.map((value) => fixed(value, 3));
    if (part.position.children.length !== position.length) fill(part.position, position.map(() => [h("span"), " "]));
    for (const [k, value] of position.entries()) text(part.position.children[k], value);
    const driver = store.driver(part.system.name);
    text(part.driver, driver === null ? "no page" : driver === store.viewer ? "you" : driver);
    state(part.driver, "kind", driver === store.viewer && driver !== null ? "mine" : "calm");
    text(part.mover, status.moved_by ?? "–");
    part.bits.show(status.bits);
  }
}

/** The state of an axis in words; an axis whose drive runs may stand still. @param {AxisStatus} status */
function standing({ state, moving, bits }) {
  if (state !== "Running") return state;
  const doing = DOING.find(([bit]) => bits?.includes(bit))?.[1];
  return doing ?? (moving ? "Moving" : "At rest");
}

/** The status bits that are set: how many, and on demand their names. */
function statusBits() {
  const [count, list] = [h("span"), h("div.chips")];
  const element = h("details.bits", {}, h("summary", {}, icon("right"), count), list);
  return {
    element,
    show: (/** @type {string[]} */ bits) => {
      text(count, `${bits.length || "No"} status ${bits.length === 1 ? "bit" : "bits"} set`);
      chips(list, bits);
    },
  };
}

/** @param {number} value @param {number} most */
function share(value, most) {
  const part = most > 0 ? Math.abs(value) / most : 0;
  return Math.min(1, Number.isFinite(part) ? part : 0).toFixed(3);
}
