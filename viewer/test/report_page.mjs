// SPDX-License-Identifier: MIT
// Pages of reports in a real browser, opened from disk. The browser runs as long as the tests that import this.
import assert from "node:assert/strict";
import { after, before } from "node:test";

import { chromiumPath, launch, openPage } from "./browser.mjs";
import { withFolder, writePage } from "./page.mjs";
import { inventedFrames, inventedRun, noCommand } from "./sample.mjs";

export const skip = chromiumPath ? noCommand : "no Chromium is installed";
export const kLate = [
  [7, "machine"],
  [30, "overrun"],
  [59, "infeasible"],
];
export const invented = (more = {}) => ({
  run: inventedRun(60, kLate),
  frames: inventedFrames(60, kLate),
  page: { command: "poise run heap --deadline 16" },
  ...more,
});

let browser = null;
before(async () => {
  if (!skip) browser = await launch();
});
after(() => browser?.close());

/** Opens a page of these parts for a test, and fails it if the console showed anything. */
export async function withPage(parts, use, options) {
  await withFolder(async (folder) => {
    const address = await writePage(folder, typeof parts === "function" ? await parts(folder) : parts);
    const { page, errors, close } = await openPage(browser, address, options);
    await page.waitForFunction(
      () => document.getElementById("scene").textContent !== "Poise" || !document.getElementById("problem").hidden,
    );
    // Charts are made when their size is known.
    await page.waitForFunction(
      () => !window.poise || Object.values(window.poise.charts).every((chart) => chart.chart()),
    );
    await use(page, errors);
    assert.deepEqual(errors, []);
    await close();
  });
}
