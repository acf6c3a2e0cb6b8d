// Ranges and typed numbers of the forms.

import assert from "node:assert/strict";
import { test } from "node:test";
import { fault, isShown, number, numbers, rangeText } from "../js/fields.js";

const JERK = { min: 0, min_exclusive: true, max: null, max_when: { member: "JerkUnits", in: [2, 6], max: 100 } };

test("ranges in words", () => {
  assert.equal(rangeText({ min: 0, max: null }), "0 or more");
  assert.equal(rangeText({ min: 0, min_exclusive: true, max: null }), "more than 0");
  assert.equal(rangeText({ min: 0, max: 100 }), "0 to 100");
  assert.equal(rangeText(JERK, { JerkUnits: 2 }), "more than 0, at most 100");
  assert.equal(rangeText(JERK, { JerkUnits: 0 }), "more than 0");
  assert.equal(rangeText(null), "");
});

test("a number outside of its range", () => {
  const operand = { kind: "number", range: JERK };
  assert.equal(fault(operand, 100, { JerkUnits: 2 }), null);
  assert.equal(fault(operand, 101, { JerkUnits: 2 }), "more than 0, at most 100 is expected");
  assert.equal(fault(operand, 101, { JerkUnits: 0 }), null);
  assert.equal(fault(operand, 0, {}), "more than 0 is expected");
  assert.equal(fault(operand, NaN, {}), "a number is expected");
  assert.equal(fault({ kind: "integer" }, 1.5, {}), "a whole number is expected");
});

test("numbers as people type them", () => {
  assert.equal(number(" 12,5 "), 12.5);
  assert.equal(number("−3"), -3);
  assert.ok(Number.isNaN(number("")));
  assert.ok(Number.isNaN(number("12 mm")));
  assert.deepEqual(numbers("[1, 2.5 -3]"), [1, 2.5, -3]);
  assert.deepEqual(numbers(" "), []);
});

test("an operand is shown under all of its conditions", () => {
  const operand = { shown_when: [{ member: "A", in: [1, 2] }, { member: "B", in: [0] }] };
  assert.ok(isShown(operand, { A: 2, B: 0 }));
  assert.ok(!isShown(operand, { A: 2, B: 1 }));
  assert.ok(isShown({ shown_when: null }, {}));
});
