// Events put together to executions and faults.

import assert from "node:assert/strict";
import { test } from "node:test";
import { Executions, standing } from "../js/executions.js";

let seq = 0;

function event(ticket, set, clear = [], more = {}) {
  seq += 1;
  return { seq, tick: seq, time_s: seq / 1000, at_ms: seq, ticket, tag: "Move1", instruction: "MCLM", object: "CS1", text: null, viewer: null, set, clear, err: 0, exerr: 0, error: null, ended: null, ...more };
}

function fault(change) {
  seq += 1;
  return { seq, tick: seq, time_s: seq / 1000, at_ms: seq, fault: { axis: "X", set: [], again: [], clear: [], by: null, refused: null, ...change } };
}

function rest(slow, count) {
  seq += 1;
  return { seq, tick: seq, time_s: seq / 1000, at_ms: seq, rest: { system: "CS1", slow, count, text: "The queue was empty" } };
}

function states(...events) {
  const executions = new Executions();
  executions.take(events);
  return executions.list.map((execution) => standing(execution)[1]);
}

test("the state of an execution follows its bits", () => {
  const ended = { by: "fault", text: "stopped by overcurrent of X", axis: "X", faults: ["overcurrent"] };
  assert.deepEqual(states(event(1, ["EN", "DN", "IP"])), ["In process"]);
  assert.deepEqual(states(event(1, ["EN", "DN", "IP"]), event(1, ["AC"])), ["Active"]);
  assert.deepEqual(states(event(1, ["EN", "DN", "IP", "AC"]), event(1, ["PC"], ["IP", "AC"])), ["Complete"]);
  assert.deepEqual(states(event(1, ["EN", "DN", "IP"]), event(1, [], ["IP"], { ended })), ["Stopped by a fault"]);
  assert.deepEqual(states(event(1, ["EN", "ER"], [], { err: 13, exerr: 4 })), ["Error"]);
  assert.deepEqual(states(event(1, ["EN", "DN"]), event(2, ["EN"])), ["Done", "Enabled"]);
});

test("an error is given once, with the server's text where it has one", () => {
  const executions = new Executions();
  const wrong = event(1, ["EN", "ER"], [], { err: 13, exerr: 4, error: { text: "Parameter Out Of Range" } });
  assert.deepEqual(executions.take([wrong]).map(({ error }) => error.text), ["Parameter Out Of Range"]);
  assert.deepEqual(executions.take([wrong]), [], "an event that came twice is taken once");
  assert.equal(executions.take([event(2, ["ER"], [], { err: 7 })])[0].error.text, "ERR 7");
});

test("a reset that has not helped says so", () => {
  const reset = { by: "instruction", text: "MASR Reset", ticket: 9, instruction: "MASR" };
  assert.deepEqual(
    states(fault({ set: ["overcurrent"] }), event(9, ["EN", "DN"]), fault({ clear: ["overcurrent"], by: reset }), fault({ set: ["overcurrent"], again: ["overcurrent"] })),
    ["Faulted", "Still faulted", "Cleared", "Faulted again"],
  );
});

test("the list is bounded", () => {
  const executions = new Executions();
  executions.take(Array.from({ length: 1200 }, (_, k) => event(100 + k, ["EN"])));
  assert.equal(executions.list.length, 1000);
  assert.equal(executions.list[0].key, 300);
});

test("a rest on the way tells a slow program from a slow planner", () => {
  assert.deepEqual(states(rest("program", 1), rest("planner", 2)), ["Program too slow", "Planner too slow"]);
  const executions = new Executions();
  executions.take([rest("program", 3)]);
  assert.deepEqual(standing(executions.list[0]), ["bad", "Program too slow", "The queue was empty (3 since the start)"]);
});
