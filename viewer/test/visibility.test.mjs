// SPDX-License-Identifier: MIT
import assert from "node:assert/strict";
import { test } from "node:test";

import { kHidden, kOutside, kSeen, Visibility } from "../src/replay/visibility.js";

// The eye is in the origin and looks along x, z is up.
const kCamera = {
  position_m: [0, 0, 0],
  forward: [1, 0, 0],
  up: [0, 0, 1],
  vertical_fov_rad: Math.PI / 3,
  aspect: 16 / 9,
};

/** Of balls [x, y, z, radius]. */
function visibilityOf(balls, camera = kCamera) {
  const visibility = new Visibility(balls.length, (row) => balls[row][3]);
  const position = Float32Array.from(balls.flatMap(([x, y, z]) => [x, y, z]));
  visibility.find({ rows: balls.map((_, row) => row), position }, camera);
  return [...visibility.of];
}

test("a ball behind a larger one is hidden, whatever their order", () => {
  assert.deepEqual(visibilityOf([[4, 0, 0, 1], [8, 0.2, 0.1, 0.5]]), [kSeen, kHidden]);
  assert.deepEqual(visibilityOf([[8, 0.2, 0.1, 0.5], [4, 0, 0, 1]]), [kHidden, kSeen]);
});

test("one that stands out beside, or is nearer, is seen", () => {
  assert.deepEqual(visibilityOf([[4, 0, 0, 1], [8, 2.2, 0, 0.5]]), [kSeen, kSeen]);
  assert.deepEqual(visibilityOf([[4, 0, 0, 1], [2, 0, 0, 0.2]]), [kSeen, kSeen]);
});

test("what is behind the eye or beside the picture is outside", () => {
  assert.deepEqual(visibilityOf([[-4, 0, 0, 1], [4, 9, 0, 1], [4, 0, 5, 1]]), [kOutside, kOutside, kOutside]);
  assert.deepEqual(visibilityOf([[4, 4.3, 0, 1]]), [kSeen], "partly in the picture");
});

test("a body that fills no cell is seen where nothing is before it", () => {
  assert.deepEqual(visibilityOf([[1000, 3, 2, 0.01]]), [kSeen]);
});

test("the camera may look anywhere", () => {
  const down = { ...kCamera, position_m: [0, 0, 10], forward: [0, 0, -2], up: [0, 1, 0] };
  assert.deepEqual(visibilityOf([[0, 0, 5, 1], [0, 0, 1, 0.5], [0, 0, 12, 1]], down), [kSeen, kHidden, kOutside]);
});
