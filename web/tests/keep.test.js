// What the browser keeps is checked when it is read: a bad value is no value, and never an empty page.

import assert from "node:assert/strict";
import { test } from "node:test";
import { keep } from "../js/keep.js";

function withStored(text, action) {
  globalThis.localStorage = { getItem: () => text, setItem: () => {} };
  try {
    return action();
  } finally {
    delete globalThis.localStorage;
  }
}

const BAD = ["", "{", "null", "5", '"text"', "[1, {}]", '{"axes": 5}', '{"axes": [1]}', "undefined"];

test("a bad list is none", () => {
  for (const text of BAD) assert.deepEqual(withStored(text, () => keep.list("key")) ?? [], [], text);
  assert.deepEqual(withStored('["X", 1, "Y"]', () => keep.list("key")), ["X", "Y"]);
  assert.equal(withStored(null, () => keep.list("key")), null);
});

test("bad lists are none", () => {
  for (const text of BAD) assert.deepEqual(withStored(text, () => keep.lists("key")).axes ?? [], [], text);
  assert.deepEqual(withStored('{"axes": ["X"], "kinds": null}', () => keep.lists("key")), { axes: ["X"] });
});

test("a browser that keeps nothing", () => {
  const refuse = () => {
    throw new Error("not allowed");
  };
  globalThis.localStorage = { getItem: refuse, setItem: refuse };
  assert.equal(keep.get("key"), null);
  keep.set("key", "value");
  delete globalThis.localStorage;
});
