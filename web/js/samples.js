// The last ten minutes and more of every signal, one value a tick, with the least and the greatest of every 16 and 256.
// Positions in position units, rates per s, s² and s³. A tick that did not arrive is NaN. Drawing is elsewhere.
// The past before the page came may have one row for a few ticks only: then the extrema and every first value are exact,
// and the values between two of these are interpolated.

import { found } from "./dom.js";

/** @import { Machine, SystemConfiguration } from "../types/protocol.js" */

/**
 * A frame: its first tick, how many rows, ticks of a row, signals, and the numbers of each row.
 * @typedef {object} Frame
 * @property {number} start
 * @property {number} count
 * @property {number} every
 * @property {number} columns
 * @property {(row: number, column: number, which: number) => number} value
 */

const MAGIC = 0x31435241; // "ARC1", little-endian
const HISTORY = 0x32435241; // "ARC2"
const HEAD = 24;
const SECONDS = 660;
const BUCKETS = [16, 256];

/**
 * The stored signals of each axis, and the order of derivation of their units.
 * @type {{ kind: "position" | "velocity" | "acceleration" | "jerk" | "error", title: string, order: number }[]}
 */
export const KINDS = [
  { kind: "position", title: "Position", order: 0 },
  { kind: "velocity", title: "Velocity", order: 1 },
  { kind: "acceleration", title: "Acceleration", order: 2 },
  { kind: "jerk", title: "Jerk", order: 3 },
  { kind: "error", title: "Following error", order: 0 },
];

/** One signal: a value for each tick, and its extrema. */
export class Series {
  /** @param {Samples} owner @param {(tick: number) => number} value */
  constructor(owner, value) {
    const { capacity } = owner;
    this.owner = owner;
    this.value = value;
    this.levels = BUCKETS.map((size) => ({
      size,
      least: new Float32Array(capacity / size).fill(NaN),
      greatest: new Float32Array(capacity / size).fill(NaN),
    }));
  }

  /** Forgets the extrema. */
  clear() {
    for (const { least, greatest } of this.levels) {
      least.fill(NaN);
      greatest.fill(NaN);
    }
  }

  /**
   * Enters the least and greatest value of the ticks `from` to before `to` into the extrema, beside the present ones.
   * @param {number} from
   * @param {number} to
   * @param {number} low
   * @param {number} high
   */
  cover(from, to, low, high) {
    if (Number.isNaN(low) || Number.isNaN(high)) return;
    for (const { size, least, greatest } of this.levels) {
      for (let bucket = Math.floor(from / size); bucket * size < to; bucket++) {
        const place = bucket % least.length;
        if (!(low >= least[place])) least[place] = low;
        if (!(high <= greatest[place])) greatest[place] = high;
      }
    }
  }

  /** The value at a tick; NaN where there is none. @param {number} tick */
  at(tick) {
    return tick >= this.owner.first && tick < this.owner.end ? this.value(tick) : NaN;
  }

  /** Enters a value into the extrema; `begins` says that nothing older may remain. @param {number} tick @param {number} value @param {boolean} begins */
  note(tick, value, begins) {
    for (const { size, least, greatest } of this.levels) {
      const place = Math.floor(tick / size) % least.length;
      if (begins || tick % size === 0) {
        least[place] = value;
        greatest[place] = value;
      } else if (Number.isNaN(least[place]) || value < least[place]) {
        least[place] = value;
        if (Number.isNaN(greatest[place])) greatest[place] = value;
      } else if (value > greatest[place]) {
        greatest[place] = value;
      }
    }
  }

  /**
   * Least and greatest of the ticks `from` to before `to` into `out`, from whole buckets of 1, 16 or 256 ticks.
   * @param {number} from
   * @param {number} to
   * @param {number} bucket
   * @param {number[]} out
   */
  extrema(from, to, bucket, out) {
    let least = NaN;
    let greatest = NaN;
    const level = bucket === BUCKETS[1] ? this.levels[1] : bucket === BUCKETS[0] ? this.levels[0] : null;
    const first = Math.max(from, this.owner.first);
    const end = Math.min(to, this.owner.end);
    if (!level) {
      for (let tick = first; tick < end; tick++) {
        const value = this.value(tick);
        if (!(value >= least)) least = Number.isNaN(value) ? least : value;
        if (!(value <= greatest)) greatest = Number.isNaN(value) ? greatest : value;
      }
    } else {
      const { size } = level;
      const length = level.least.length;
      for (let bucket = Math.floor(first / size); bucket * size < end; bucket++) {
        const low = level.least[bucket % length];
        const high = level.greatest[bucket % length];
        if (!(low >= least)) least = Number.isNaN(low) ? least : low;
        if (!(high <= greatest)) greatest = Number.isNaN(high) ? greatest : high;
      }
    }
    out[0] = least;
    out[1] = greatest;
    return out;
  }
}

/** All signals of the machine. */
export class Samples {
  /** First stored tick. */
  first = 0;
  /** The tick behind the newest. */
  end = 0;
  /** The ranges with one row for a few ticks. @type {{ from: number, to: number, every: number }[]} */
  coarse = [];

  /** `machine` is the answer of `/api/machine`. @param {Machine} machine */
  constructor(machine) {
    this.period = machine.period_s;
    const wanted = Math.ceil(SECONDS / this.period);
    this.capacity = Math.ceil(wanted / BUCKETS[1]) * BUCKETS[1];
    this.axes = machine.axes.map((axis) => this.#axis(axis.name));
    this.systems = machine.coordinate_systems.map((system) => this.#system(system));
    this.tools = this.systems.flatMap((system) => system.tool ?? []);
    this.columns = this.axes.length * 4 + this.systems.length + this.tools.length;
  }

  /** The signals of an axis by the kinds of `KINDS`, and `actual`. @param {string} name */
  axis(name) {
    return found(this.axes.find((axis) => axis.name === name), name);
  }

  /** The path speed of a coordinate system, and of a robot's `tool`: where it is in the frame of the base; `null` of others. @param {string} name */
  system(name) {
    return found(this.systems.find((system) => system.name === name), name);
  }

  /** Seconds since tick 0. @param {number} tick */
  time(tick) {
    return tick * this.period;
  }

  /** Takes a frame; gives its first tick, or `null` if it was none of this machine. @param {ArrayBuffer} buffer */
  add(buffer) {
    const frame = read(buffer, MAGIC);
    if (!frame || frame.columns !== this.columns) return null;
    const { start, count, value } = frame;
    this.#skipTo(start, count);
    for (let row = 0; row < count; row++) {
      if (start + row >= this.end) this.#put(start + row, (column) => value(row, column, 0));
    }
    return start;
  }

  /** Whether a frame is one of the past. @param {ArrayBuffer} buffer */
  static isHistory(buffer) {
    return buffer.byteLength >= HEAD && new DataView(buffer).getUint32(0, true) === HISTORY;
  }

  /** Takes a frame of the past before the tick `before`, from which on all samples are known. @param {ArrayBuffer} buffer @param {number} before */
  fill(buffer, before) {
    const frame = read(buffer, HISTORY, this.columns);
    if (!frame || before > this.end) return;
    const { start, count, every, columns } = frame;
    // The oldest buckets are about to be overwritten.
    const oldest = Math.max(start, this.end - this.capacity + BUCKETS[1]);
    const until = Math.min(before, start + count * every);
    if (oldest >= until) return;
    this.first = Math.min(this.first, oldest);
    for (let tick = until; tick < before; tick++) this.#write(tick, () => NaN);
    if (columns === this.columns) {
      for (let tick = oldest; tick < until; tick++) this.#write(tick, (column) => frame.value(tick - start, column, 0));
      this.#each((series) => {
        for (let tick = oldest; tick <= until && tick < this.end; tick++) series.cover(tick, tick + 1, series.value(tick), series.value(tick));
      });
      return;
    }
    this.#lines(frame, oldest, until);
    for (let row = 0; row < count; row++) {
      const from = Math.max(oldest, start + row * every);
      const to = Math.min(until, start + (row + 1) * every);
      if (from < to) this.#extrema(frame, row, from, to);
    }
    const last = this.coarse[0];
    if (last?.from === until && last.every === every) last.from = oldest;
    else this.coarse.unshift({ from: oldest, to: until, every });
  }

  /** Ticks from one known value to the next at a tick: 1 where every tick is known. @param {number} tick */
  step(tick) {
    return this.coarse.find(({ from, to }) => tick >= from && tick < to)?.every ?? 1;
  }

  /** Straight lines between the first values of rows of a few ticks. @param {Frame} frame @param {number} from @param {number} to */
  #lines({ start, count, every, value }, from, to) {
    for (let tick = from; tick < to; tick++) {
      const row = Math.floor((tick - start) / every);
      const share = (tick - start - row * every) / every;
      this.#write(tick, (column) => {
        const here = value(row, column, 0);
        if (row + 1 >= count) return here;
        const line = here + share * (value(row + 1, column, 0) - here);
        // A rotary axis that goes through its unwind does not pass through the values between.
        return Math.min(Math.max(line, value(row, column, 1)), value(row, column, 2));
      });
    }
  }

  /** The extrema of a row of a few ticks. @param {Frame} frame @param {number} row @param {number} from @param {number} to */
  #extrema({ value }, row, from, to) {
    const enter = (/** @type {Series} */ series, /** @type {number} */ column) => series.cover(from, to, value(row, column, 1), value(row, column, 2));
    this.axes.forEach((axis, k) => {
      for (const [column, series] of [axis.position, axis.velocity, axis.acceleration, axis.actual].entries()) enter(series, 4 * k + column);
      for (const [column, series] of [axis.jerk, axis.error].entries()) enter(series, this.columns + 2 * k + column);
    });
    for (const [k, { speed }] of this.systems.entries()) enter(speed, 4 * this.axes.length + k);
    for (const [k, series] of this.tools.entries()) enter(series, 4 * this.axes.length + this.systems.length + k);
  }

  /** @param {(series: Series) => void} take */
  #each(take) {
    for (const axis of this.axes) axis.all.forEach(take);
    for (const system of this.systems) take(system.speed);
    this.tools.forEach(take);
  }

  /** Fills the gap before a tick; a server that began again, or a long gap, removes all samples. @param {number} start @param {number} count */
  #skipTo(start, count) {
    const restarted = start + count < this.end;
    if (this.end === 0 || restarted || start - this.end >= this.capacity) {
      this.first = start;
      this.end = start;
      this.coarse = [];
      this.#each((series) => series.clear());
    }
    while (this.end < start) this.#put(this.end, () => NaN);
  }

  /** @param {number} tick @param {(column: number) => number} column */
  #put(tick, column) {
    const begins = tick === this.first;
    this.end = tick + 1;
    // The oldest bucket is being overwritten, so the stored ticks begin behind it.
    this.first = Math.max(this.first, this.end - this.capacity + BUCKETS[1]);
    while (this.coarse[0]?.to <= this.first) this.coarse.shift();
    this.#write(tick, column);
    this.#each((series) => series.note(tick, series.value(tick), begins));
  }

  /** Enters the values of a tick. @param {number} tick @param {(column: number) => number} column */
  #write(tick, column) {
    const place = tick % this.capacity;
    this.axes.forEach((axis, k) => {
      const command = column(4 * k);
      axis.position.stored[place] = command;
      axis.velocity.stored[place] = column(4 * k + 1);
      axis.acceleration.stored[place] = column(4 * k + 2);
      axis.error.stored[place] = command - column(4 * k + 3);
    });
    for (const [k, { speed }] of this.systems.entries()) speed.stored[place] = column(4 * this.axes.length + k);
    for (const [k, series] of this.tools.entries()) series.stored[place] = column(4 * this.axes.length + this.systems.length + k);
  }

  /** @param {Float32ArrayConstructor | Float64ArrayConstructor} kind */
  #kept(kind) {
    const stored = new kind(this.capacity);
    return Object.assign(new Series(this, (tick) => stored[tick % this.capacity]), { stored });
  }

  /** @param {(tick: number) => number} value */
  #derived(value) {
    return new Series(this, value);
  }

  /** @param {string} name */
  #axis(name) {
    const position = this.#kept(Float64Array);
    const velocity = this.#kept(Float32Array);
    const acceleration = this.#kept(Float32Array);
    const error = this.#kept(Float32Array);
    const actual = this.#derived((tick) => position.value(tick) - error.value(tick));
    const jerk = this.#derived((tick) =>
      tick > this.first ? (acceleration.value(tick) - acceleration.value(tick - 1)) / this.period : NaN);
    const all = [position, velocity, acceleration, error, actual, jerk];
    return { name, position, velocity, acceleration, error, actual, jerk, all };
  }

  /** @param {SystemConfiguration} system */
  #system({ name, robot }) {
    const tool = robot ? [0, 1, 2].map(() => this.#kept(Float32Array)) : null;
    return { name, speed: this.#kept(Float32Array), tool };
  }
}

/**
 * A frame: its first tick, how many rows, ticks of a row, signals, and `value(row, column, which)`. One that has more than
 * `known` signals has three numbers of each: the first value, the least and the greatest. `null` if it is none.
 * @param {ArrayBuffer} buffer
 * @param {number} magic
 * @param {number} known
 * @returns {Frame | null}
 */
function read(buffer, magic, known = Infinity) {
  const view = new DataView(buffer);
  if (buffer.byteLength < HEAD || view.getUint32(0, true) !== magic) return null;
  const count = view.getUint32(4, true);
  const columns = view.getUint32(8, true);
  const every = view.getUint32(12, true) || 1;
  const each = columns > known ? 3 : 1;
  if (buffer.byteLength < HEAD + columns * (8 + 4 * each * count)) return null;
  const bases = new Float64Array(buffer, HEAD, columns);
  const rows = new Float32Array(buffer, HEAD + 8 * columns, columns * each * count);
  const value = (/** @type {number} */ row, /** @type {number} */ column, /** @type {number} */ which) => bases[column] + rows[(row * columns + column) * each + which];
  return { start: Number(view.getBigUint64(16, true)), count, every, columns, value };
}
