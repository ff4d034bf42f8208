// SPDX-License-Identifier: MIT
// What a page draws where the processor draws.
import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { join } from "node:path";
import { test } from "node:test";

import { chromiumPath, launch, openPage } from "./browser.mjs";
import { withFolder, writePage } from "./page.mjs";
import { noCommand, poise } from "./sample.mjs";

const skip = chromiumPath ? noCommand : "no Chromium is installed";

test("a page without a graphics processor draws the 1,000 bodies that look largest in full", { skip }, () =>
  withFolder(async (folder) => {
    const file = join(folder, "many.capture");
    const words = ["run", "jacks", "--bodies", "1500", "--frames", "1", "--clock", "work", "--budget-work", "10"];
    await poise(...words, "--quiet", "--capture", file);
    const address = await writePage(folder, { captures: [await readFile(file)] });
    const browser = await launch();
    const { page, errors } = await openPage(browser, address);
    await page.waitForFunction(() => window.poise?.replay?.pictures > 0);
    const drawn = await page.evaluate(() => {
      const { replay } = window.poise;
      replay.choose("camera", "all");
      replay.choose("show", "shapes");
      replay.drawNow();
      const { inFull, hidden, balls, dots } = replay.views[0].bodies;
      return { inFull, hidden, spheres: balls.count + dots.count };
    });
    assert.ok(drawn.inFull > 990 && drawn.inFull <= 1000, JSON.stringify(drawn)); // a few of them may be hidden
    assert.ok(drawn.spheres > 5 * drawn.inFull, "all of their balls");
    assert.deepEqual(errors, []);
    await browser.close();
  }),
);
