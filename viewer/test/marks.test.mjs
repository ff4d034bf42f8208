// SPDX-License-Identifier: MIT
import assert from "node:assert/strict";
import { test } from "node:test";

import { drawMark } from "../src/charts/marks.js";

test("the edge of a mark is whole, whatever was drawn before it", () => {
  let dash = [6, 4]; // of the deadline
  const edges = [];
  const ignore = () => {};
  const context = { beginPath: ignore, rect: ignore, moveTo: ignore, lineTo: ignore, arc: ignore, closePath: ignore };
  Object.assign(context, {
    fill: ignore,
    setLineDash: (next) => (dash = next),
    stroke: () => edges.push(dash),
  });
  for (const cause of ["infeasible", "machine", "overrun", "forecast", "release"])
    drawMark(context, cause, 9, 9, 5, "#ffffff");
  assert.deepEqual(edges, [[], [], [], [], []]);
});
