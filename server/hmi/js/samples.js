// The last ten minutes and more of every signal, one value a tick, with the least and the greatest of every 16 and 256.
// Positions in position units, rates per s, s² and s³. A tick that did not arrive is NaN. It knows nothing of drawing.

const MAGIC = 0x31435241; // "ARC1", little-endian
const HEAD = 24;
const SECONDS = 660;
const BUCKETS = [16, 256];

/** What is kept of each axis, and the unit's order of derivation. */
export const KINDS = [
  { kind: "position", title: "Position", order: 0 },
  { kind: "velocity", title: "Velocity", order: 1 },
  { kind: "acceleration", title: "Acceleration", order: 2 },
  { kind: "jerk", title: "Jerk", order: 3 },
  { kind: "error", title: "Following error", order: 0 },
];

/** One signal: a value for each tick, and its extrema. */
class Series {
  constructor(owner, capacity, value, stored) {
    this.owner = owner;
    this.value = value;
    this.stored = stored;
    this.levels = BUCKETS.map((size) => ({
      size,
      least: new Float32Array(capacity / size),
      greatest: new Float32Array(capacity / size),
    }));
  }

  /** The value at a tick; NaN where there is none. */
  at(tick) {
    return tick >= this.owner.first && tick < this.owner.end ? this.value(tick) : NaN;
  }

  /** Enters a value into the extrema; `begins` says that nothing older may remain. */
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

  /** Least and greatest of the ticks `from` to before `to` into `out`, from whole buckets of 1, 16 or 256 ticks. */
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
  /** First tick that is kept. */
  first = 0;
  /** The tick behind the newest. */
  end = 0;

  /** `machine` is the answer of `/api/machine`. */
  constructor(machine) {
    this.period = machine.period_s;
    const wanted = Math.ceil(SECONDS / this.period);
    this.capacity = Math.ceil(wanted / BUCKETS[1]) * BUCKETS[1];
    this.axes = machine.axes.map((axis) => this.#axis(axis.name));
    this.systems = machine.coordinate_systems.map((system) => this.#system(system.name));
    this.columns = this.axes.length * 4 + this.systems.length;
  }

  /** The signals of an axis by the kinds of `KINDS`, and `actual`. */
  axis(name) {
    return this.axes.find((axis) => axis.name === name);
  }

  /** The path speed of a coordinate system. */
  system(name) {
    return this.systems.find((system) => system.name === name);
  }

  /** Seconds since tick 0. */
  time(tick) {
    return tick * this.period;
  }

  /** Takes a frame; gives whether it was one of this machine. */
  add(buffer) {
    const view = new DataView(buffer);
    if (buffer.byteLength < HEAD || view.getUint32(0, true) !== MAGIC) return false;
    const count = view.getUint32(4, true);
    const columns = view.getUint32(8, true);
    const start = Number(view.getBigUint64(16, true));
    if (columns !== this.columns || buffer.byteLength < HEAD + columns * (8 + 4 * count)) return false;
    const bases = new Float64Array(buffer, HEAD, columns);
    const rows = new Float32Array(buffer, HEAD + 8 * columns, columns * count);
    this.#skipTo(start, count);
    for (let row = 0; row < count; row++) {
      if (start + row >= this.end) this.#put(start + row, (column) => bases[column] + rows[row * columns + column]);
    }
    return true;
  }

  /** Fills what is missing before a tick; a server that began again, or a long gap, empties everything. */
  #skipTo(start, count) {
    const restarted = start + count < this.end;
    if (this.end === 0 || restarted || start - this.end >= this.capacity) {
      this.first = start;
      this.end = start;
    }
    while (this.end < start) this.#put(this.end, () => NaN);
  }

  #put(tick, column) {
    const begins = tick === this.first;
    const place = tick % this.capacity;
    this.end = tick + 1;
    // The oldest bucket is being overwritten, so what is kept begins behind it.
    this.first = Math.max(this.first, this.end - this.capacity + BUCKETS[1]);
    this.axes.forEach((axis, k) => {
      const command = column(4 * k);
      const acceleration = column(4 * k + 2);
      const actual = column(4 * k + 3);
      axis.position.stored[place] = command;
      axis.velocity.stored[place] = column(4 * k + 1);
      axis.acceleration.stored[place] = acceleration;
      axis.error.stored[place] = command - actual;
      for (const series of axis.all) series.note(tick, series.value(tick), begins);
    });
    this.systems.forEach((system, k) => {
      const value = column(4 * this.axes.length + k);
      system.speed.stored[place] = value;
      system.speed.note(tick, value, begins);
    });
  }

  #kept(kind) {
    const stored = new kind(this.capacity);
    return new Series(this, this.capacity, (tick) => stored[tick % this.capacity], stored);
  }

  #derived(value) {
    return new Series(this, this.capacity, value, null);
  }

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

  #system(name) {
    return { name, speed: this.#kept(Float32Array) };
  }
}
