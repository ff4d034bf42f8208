// SPDX-License-Identifier: MIT
// The words above the charts, of invented runs.
import assert from "node:assert/strict";
import { test } from "node:test";

import { onTime } from "../src/headline.js";
import { clockText, onTime as onTimeNow } from "../src/live/headline.js";

test("the refinement of a run on the work clock is told as far as it is known", () => {
  const textOf = (settings) => onTime({ clock: "work", misses: { count: null }, frame_ms: { p99: 2 }, settings }).text;
  assert.match(textOf({ budget_work: null }), /^The work clock ran, with unlimited refinement\. 99/);
  assert.match(textOf({ budget_work: 300 }), /^The work clock ran, with 300 work units a frame\. 99/);
  assert.match(textOf({}), /^The work clock ran\. 99/, "a capture does not know");
  assert.match(textOf(undefined), /^The work clock ran\. 99/);
  assert.equal(onTime({ clock: "work", misses: { count: null } }).text, "The work clock ran.");
});

test("frames of a live run met the deadline that they had, whatever it is now", () => {
  const status = { late: {}, recent_frames: 300, deadline_ms: 1 };
  assert.equal(onTimeNow(status).text, "None of the last 300 frames was late: all met their deadline.");
});

test("time and number of a live run are those of one frame, the one that is shown", () => {
  assert.equal(clockText({ time_s: 2, frame: 120 }), "2.00 s   frame 120");
  assert.equal(clockText(undefined), "", "none has come");
});
