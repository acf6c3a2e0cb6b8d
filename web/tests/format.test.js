// Numbers, times and units as the page shows them.

import assert from "node:assert/strict";
import { test } from "node:test";
import { clock, decimals, duration, exact, fixed, niceStep, plain, rate, short } from "../js/format.js";

/** Why, function, arguments, expected. */
const CASES = [
  ["a real minus sign", fixed, [-1.5, 2], "−1.50"],
  ["no minus in front of a rounded 0", fixed, [-0.0001, 3], "0.000"],
  ["no number", fixed, [NaN], "–"],
  ["about five digits", short, [123.456789], "123.46"],
  ["large", short, [-1.5e9], "−1.50e9"],
  ["small", short, [1.5e-7], "1.50e−7"],
  ["reads back to the same value", exact, [0.1 + 0.2], "0.3"],
  ["minutes", clock, [754.567], "12:34.567"],
  ["hours", clock, [3661, 0], "1:01:01"],
  ["rounds up to a whole minute", clock, [59.9996], "1:00.000"],
  ["before the start", clock, [-1.5, 1], "−0:01.5"],
  ["milliseconds", duration, [0.85], "850 ms"],
  ["a few microseconds", duration, [0.00123], "1.23 ms"],
  ["seconds", duration, [12.44], "12.4 s"],
  ["minutes", duration, [200], "3:20"],
  ["a position", rate, ["mm", 0], "mm"],
  ["a jerk", rate, ["mm", 3], "mm/s³"],
  ["a step of 1", niceStep, [0.7], 1],
  ["a step of 2", niceStep, [1.2], 2],
  ["a step of 5", niceStep, [30], 50],
  ["the step itself", niceStep, [0.2], 0.2],
  ["decimals of a step below 1", decimals, [0.05], 2],
  ["decimals of a step of 10", decimals, [10], 0],
  ["a structure", plain, [{ PRE: 1 }], '{"PRE":1}'],
  ["nothing", plain, [null], ""],
];

for (const [why, action, values, expected] of CASES) {
  test(`${action.name}: ${why}`, () => assert.equal(action(...values), expected));
}
