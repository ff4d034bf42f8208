// SPDX-License-Identifier: MIT
// Late frames in the page of a report.
import assert from "node:assert/strict";
import { test } from "node:test";

import { invented, kLate, skip, withPage } from "./report_page.mjs";
import { inventedFrames } from "./sample.mjs";

test("late frames are marked above their bars, in the colour of their cause", { skip }, () =>
  withPage(invented(), async (page) => {
    const found = await page.evaluate(() => {
      const { charts } = window.poise;
      const u = charts["frame-time"].chart();
      const { width, height } = u.ctx.canvas;
      const { data } = u.ctx.getImageData(0, 0, width, height);
      const pixelAt = (x, y) => [...data.subarray(4 * (y * width + x), 4 * (y * width + x) + 4)];
      return charts["frame-time"].drawn.marks.map(({ row, cause, x, y }) => ({
        row,
        cause,
        pixel: pixelAt(Math.round(x * devicePixelRatio), Math.round(y * devicePixelRatio)),
        expected: u.valToPos(row + 0.5, "x", true) / devicePixelRatio,
        x,
      }));
    });
    assert.deepEqual(
      found.map(({ row, cause }) => [row, cause]),
      kLate,
    );
    const colors = {
      machine: [0x7a, 0x7a, 0x7a, 255],
      overrun: [0xcc, 0x79, 0xa7, 255],
      infeasible: [0xd5, 0x5e, 0x00, 255],
    };
    for (const mark of found) {
      assert.deepEqual(mark.pixel, colors[mark.cause], mark.cause);
      assert.ok(Math.abs(mark.x - mark.expected) < 0.5);
    }
  }),
);

test("late frames of the warm-up are marked, and counted nowhere", { skip }, () =>
  withPage(invented({ frames: inventedFrames(60, [...kLate, [8, "machine"]], 8) }), async (page) => {
    assert.deepEqual(
      await page.evaluate(() => window.poise.charts["frame-time"].drawn.marks.map(({ row }) => row)),
      [7, 8, 30, 59],
    );
    const words = await page.textContent("#chart-frame-time");
    assert.match(words, /3 late frames marked above\. Marks of the warm-up do not count\./);
    for (const entry of ["machine (1)", "overrun (1)", "infeasible (1)"]) assert.ok(words.includes(entry), words);
  }),
);

test("without late frames but those of the warm-up no frame was late", { skip }, () =>
  withPage(invented({ frames: inventedFrames(60, [[7, "machine"]], 8) }), async (page) => {
    const words = await page.textContent("#chart-frame-time");
    assert.match(words, /No frame was late\. Marks of the warm-up do not count\./);
    assert.ok(words.includes("machine (0)"), words);
  }),
);
