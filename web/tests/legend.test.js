// The rows of a legend.

import assert from "node:assert/strict";
import { test } from "node:test";
import { rows } from "../js/legend.js";

test("entries fill rows, and one that is too wide has a row of its own", () => {
  assert.deepEqual(rows([40, 40, 40, 200, 10], (wide) => wide, 100), [[40, 40], [40], [200], [10]]);
  assert.deepEqual(rows([], () => 1, 100), []);
});
