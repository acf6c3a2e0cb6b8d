// The points that a pen leaves out.

import assert from "node:assert/strict";
import { test } from "node:test";
import { Pen, TOLERANCE } from "../js/pen.js";

/** The lines that a pen draws for these. @param {[number, number][][]} given */
function drawn(given) {
  /** @type {[number, number][][]} */
  const lines = [];
  const pen = new Pen({ moveTo: (x, y) => lines.push([[x, y]]), lineTo: (x, y) => lines.at(-1)?.push([x, y]) });
  for (const line of given) {
    for (const [x, y] of line) pen.to(x, y);
    pen.lift();
  }
  return lines;
}

/** @param {number} count @param {(x: number) => number} y @returns {[number, number][]} */
const curve = (count, y) => Array.from({ length: count }, (_, k) => [0.4 * k, y(0.4 * k)]);

test("a straight line is two points", () => {
  assert.deepEqual(drawn([curve(1000, (x) => 3 + 0.7 * x)]), [[[0, 3], [0.4 * 999, 3 + 0.7 * 0.4 * 999]]]);
});

test("ends and gaps are kept", () => {
  assert.deepEqual(drawn([[[0, 1]], [[1, 1], [2, 9]], []]), [[[0, 1]], [[1, 1], [2, 9]]]);
});

test("a peak is kept", () => {
  const [line] = drawn([curve(1000, (x) => (x === 200 ? 50 : 0))]);
  assert.deepEqual(line.filter(([, y]) => y === 50), [[200, 50]]);
});

test("two points at one place are both drawn", () => {
  assert.deepEqual(drawn([[[0, 0], [1, 0], [1, 5], [2, 5]]]), [[[0, 0], [1, 0], [1, 5], [2, 5]]]);
});

for (const [name, y] of /** @type {[string, (x: number) => number][]} */ ([
  ["a slow wave", (x) => 100 * Math.sin(0.01 * x)],
  ["a fast wave", (x) => 100 * Math.sin(3 * x)],
  ["noise", (x) => (x * 7919.3) % 1],
  ["steps", (x) => 10 * Math.floor(x / 40)],
])) {
  test(`no point of ${name} is far from its line`, () => {
    const points = curve(2500, y);
    const [line] = drawn([points]);
    let k = 0;
    for (const [x, wanted] of points) {
      while (line[k + 1][0] < x) k += 1;
      const [[x0, y0], [x1, y1]] = [line[k], line[k + 1]];
      const off = Math.abs(y0 + ((y1 - y0) * (x - x0)) / (x1 - x0) - wanted);
      assert.ok(off <= TOLERANCE + 1e-9, `${off} at ${x}`);
    }
    if (name === "a slow wave") assert.ok(line.length < points.length / 10, `${line.length} points`);
  });
}
