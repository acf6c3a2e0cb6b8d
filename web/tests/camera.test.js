// The projection of path pictures.

import assert from "node:assert/strict";
import { test } from "node:test";
import { Camera, LOOKS } from "../js/camera.js";

function camera(look) {
  const made = new Camera();
  Object.assign(made, { width: 400, tall: 300 });
  made.look(LOOKS[look]);
  return made;
}

function near(actual, expected, why) {
  for (const [k, value] of actual.entries()) assert.ok(Math.abs(value - expected[k]) < 1e-9, `${why}: ${actual} is not ${expected}`);
}

test("the fixed looks show their plane", () => {
  for (const [look, plane] of [["top", "top"], ["front", "front"], ["side", "side"], ["space", null]]) assert.equal(camera(look).plane, plane, look);
  near(camera("top").projection()(10, 20, 30), [210, 130], "from above, y goes up");
  near(camera("front").projection()(10, 20, 30), [210, 120], "from the front, z goes up");
});

test("zoom keeps the point under the pointer", () => {
  for (const look of Object.keys(LOOKS)) {
    const made = camera(look);
    made.centre = [5, 6, 7];
    const [x, y] = made.projection()(12, 3, 9);
    made.zoom(3, x, y);
    near(made.projection()(12, 3, 9), [x, y], look);
  }
});

test("a box that is fitted is inside of the picture", () => {
  for (const look of Object.keys(LOOKS)) {
    const made = camera(look);
    made.fit([[-100, 0, 0], [300, 50, 80]]);
    for (const corner of [[-100, 0, 0], [300, 50, 80], [300, 0, 0], [-100, 50, 80]]) {
      const [x, y] = made.projection()(...corner);
      assert.ok(x >= 0 && x <= 400 && y >= 0 && y <= 300, `${look}: ${x}, ${y}`);
    }
  }
});
