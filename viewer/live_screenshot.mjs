// SPDX-License-Identifier: MIT
import { spawn } from "node:child_process";
import { join } from "node:path";

/** Writes live.png: jacks that more are poured onto, looked at from near, with the mouse on them, coloured by priority. */
export async function liveScreenshot(browser, command, images) {
  const run = spawn(command, ["live", "jacks", "--bodies", "200", "--deadline", "8", "--threads", "1", "--quiet"]);
  const ended = new Promise((resolve) => run.on("exit", resolve));
  try {
    const address = await new Promise((resolve) => run.stdout.once("data", (text) => resolve(String(text).trim())));
    const context = await browser.newContext({ viewport: { width: 1280, height: 720 }, colorScheme: "light" });
    const page = await context.newPage();
    await page.goto(address);
    await page.waitForFunction(() => window.poise?.stage?.pictures > 0 && window.poise.status.frame > 150);
    await page.keyboard.press("a");
    await page.keyboard.press("c");
    const box = await page.locator("#view").boundingBox();
    await page.mouse.move(box.x + 0.55 * box.width, box.y + 0.55 * box.height);
    await page.evaluate(() => window.poise.send({ do: "pour", count: 40 }));
    await page.waitForFunction(() => window.poise.status.bodies === 240 && window.poise.recent.frames.length === 300);
    await page.screenshot({ path: join(images, "live.png") });
    await context.close();
  } finally {
    run.kill("SIGINT");
    await ended;
  }
}
