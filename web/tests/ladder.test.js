import assert from "node:assert/strict";
import { test } from "node:test";
import { layout, shown } from "../js/ladder.js";
import { rowAt } from "../js/rows.js";

const contact = (place, text) => ({ condition: place, name: "XIC", title: "Examine If Closed", operands: [{ name: "Data Bit", text }] });
const coil = (place, text) => ({ condition: place, name: "OTE", title: "Output Energize", operands: [{ name: "Data Bit", text }] });
const rung = (...elements) => ({ number: 0, comment: "", elements });

test("the last element stands at the right rail, and wires know the condition in front of them", () => {
  const { leg, width } = layout(rung(contact(1, "A"), coil(2, "B")), 800);
  const [first, last] = leg.items;
  assert.equal(width, 800);
  assert.equal(last.x + last.width, leg.to);
  assert.ok(first.x + first.width < last.x, "a wire is between them");
  assert.deepEqual([first.before, last.before, leg.after], [0, 1, 2]);
  assert.deepEqual([first.value, last.value], [0, 1]);
});

test("legs stand below each other and begin with the condition of their branch", () => {
  const branch = { condition: 4, legs: [[contact(2, "B")], [], [contact(3, "C")]] };
  const { leg, height } = layout(rung(contact(1, "A"), branch, coil(5, "D")), 600);
  const [, placed, last] = leg.items;
  assert.deepEqual(placed.legs.map(({ before, after }) => [before, after]), [[1, 2], [1, 1], [1, 3]]);
  const [top, middle, bottom] = placed.legs.map(({ y }) => y);
  assert.ok(top === leg.y && top < middle && middle < bottom && bottom < height);
  assert.equal(last.before, 4);
  assert.deepEqual([placed.legs[0].items[0].value, placed.legs[2].items[0].value, last.value], [1, 2, 3]);
});

test("a rung without elements is a wire; a long one is wider than the view", () => {
  assert.deepEqual(layout(rung(), 500).leg.items, []);
  const long = layout(rung(...Array.from({ length: 40 }, (_, k) => contact(k + 1, "A_long_name_of_a_tag"))), 500);
  assert.ok(long.width > 3000);
});

test("values are short", () => {
  /** @type {[unknown, string][]} */
  const cases = [[null, ""], [undefined, ""], [true, "1"], [false, "0"], [12, "12"], [1 / 3, "0.3333333"], ["EN TT", "EN TT"], ["a text that is far too long", "a text that is fa…"]];
  for (const [value, expected] of cases) assert.equal(shown(value), expected);
  // In the room of a narrow box.
  /** @type {[unknown, string][]} */
  const narrow = [[-1 / 3, "-0.333333"], [-1.2345678e-10, "-1.23e-10"], [-123456.789, "-123456.8"], [1.5, "1.5"], ["a long text", "a long t…"], [1234567890123, "12345678…"]];
  for (const [value, expected] of narrow) assert.equal(shown(value, 9), expected);
});

test("the row at a place", () => {
  const tops = [0, 10, 30, 60];
  for (const [y, row] of [[0, 0], [9, 0], [10, 1], [29, 1], [59, 2], [60, 2], [1000, 2]]) assert.equal(rowAt(tops, y), row, `at ${y}`);
  assert.equal(rowAt([0], 5), 0);
});
