// Frames of samples, the history behind them, and the extrema of every zoom.

import assert from "node:assert/strict";
import { test } from "node:test";
import { csv } from "../js/export.js";
import { Samples } from "../js/samples.js";

const MACHINE = { period_s: 0.001, axes: [{ name: "X" }], coordinate_systems: [{ name: "CS1", axes: ["X"], robot: false }] };
const SIGNALS = 5;

/** A frame as the server writes it: `rows` of numbers, relative to those of the first one. */
function frame(magic, first, every, rows, each = 1) {
  const signals = rows[0].length / each;
  const buffer = new ArrayBuffer(24 + 8 * signals + 4 * rows.length * rows[0].length);
  const view = new DataView(buffer);
  for (const [k, letter] of [...magic].entries()) view.setUint8(k, letter.charCodeAt(0));
  for (const [k, word] of [rows.length, signals, every].entries()) view.setUint32(4 + 4 * k, word, true);
  view.setBigUint64(16, BigInt(first), true);
  const bases = Array.from({ length: signals }, (_, k) => rows[0][k * each]);
  for (const [k, base] of bases.entries()) view.setFloat64(24 + 8 * k, base, true);
  for (const [k, value] of rows.flat().entries()) {
    view.setFloat32(24 + 8 * signals + 4 * k, value - bases[Math.floor((k % rows[0].length) / each)], true);
  }
  return buffer;
}

/** Position, velocity, acceleration, actual position and path speed of a tick. */
const row = (tick) => [tick, 2 * tick, 0, tick - 1, 5];

test("a frame is read to the last bit", () => {
  const samples = new Samples(MACHINE);
  assert.equal(samples.add(frame("ARC1", 100, 0, [row(100), row(101), row(102)])), 100);
  const { position, velocity, error, actual } = samples.axis("X");
  assert.deepEqual([position.at(101), velocity.at(102), error.at(100), actual.at(102)], [101, 204, 1, 101]);
  assert.equal(samples.system("CS1").speed.at(102), 5);
  assert.deepEqual([samples.first, samples.end], [100, 103]);
  assert.ok(Number.isNaN(position.at(103)));
});

test("what is no frame of this machine is refused", () => {
  const samples = new Samples(MACHINE);
  assert.equal(samples.add(new ArrayBuffer(8)), null);
  assert.equal(samples.add(frame("ARC1", 0, 0, [[1, 2, 3]])), null);
  assert.throws(() => samples.axis("Nobody"), /there is no Nobody/);
});

test("ticks that did not arrive are no numbers, and a server that began again empties everything", () => {
  const samples = new Samples(MACHINE);
  samples.add(frame("ARC1", 10, 0, [row(10)]));
  samples.add(frame("ARC1", 12, 0, [row(12)]));
  assert.ok(Number.isNaN(samples.axis("X").position.at(11)));
  samples.add(frame("ARC1", 0, 0, [row(0)]));
  assert.deepEqual([samples.first, samples.end], [0, 1]);
});

test("extrema have every peak at every zoom", () => {
  const samples = new Samples(MACHINE);
  const rows = Array.from({ length: 600 }, (_, tick) => (tick === 333 ? [9999, 0, 0, 0, 0] : row(0)));
  samples.add(frame("ARC1", 0, 0, rows));
  for (const [from, to, bucket] of [[333, 334, 1], [320, 336, 16], [256, 512, 256]]) {
    assert.deepEqual(samples.axis("X").position.extrema(from, to, bucket, [0, 0])[1], 9999, `by ${bucket}`);
  }
});

test("the history goes in front, by groups with their extrema", () => {
  const samples = new Samples(MACHINE);
  samples.add(frame("ARC1", 64, 0, [row(64), row(65)]));
  const three = (first, least, greatest) => [first, least, greatest];
  const groups = [0, 32].map((tick) => [...three(tick, -7, 70), ...Array.from({ length: SIGNALS + 2 - 1 }, () => three(0, 0, 0)).flat()]);
  const history = frame("ARC2", 0, 32, groups, 3);
  assert.ok(Samples.isHistory(history));
  samples.fill(history, 64);
  assert.deepEqual([samples.first, samples.step(0), samples.step(64)], [0, 32, 1]);
  assert.deepEqual(samples.axis("X").position.extrema(0, 32, 16, [0, 0]), [-7, 70]);
  assert.equal(samples.axis("X").position.at(16), 16, "a straight line between the first values of groups");
});

test("a CSV has the ticks that are known", async () => {
  const samples = new Samples(MACHINE);
  samples.add(frame("ARC1", 10, 0, [row(10)]));
  samples.add(frame("ARC1", 12, 0, [row(12)]));
  const text = await csv(samples, [{ name: "X", series: samples.axis("X").position }], 0, 100).text();
  assert.equal(text, "tick,time_s,X\n10,0.01,10\n11,0.011,\n12,0.012,12\n");
});
