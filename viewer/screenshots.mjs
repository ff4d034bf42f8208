// SPDX-License-Identifier: MIT
// The pictures of the docs: `node viewer/screenshots.mjs` runs scenes with the built command (POISE_COMMAND names another)
// and writes docs/images/report-*.png and live.png (which alone with the word `live`).
import { mkdir } from "node:fs/promises";
import { join } from "node:path";

import { liveScreenshot } from "./live_screenshot.mjs";
import { launch, openPage } from "./test/browser.mjs";
import { viewerFolder, withFolder } from "./test/page.mjs";
import { command, noCommand, poise } from "./test/sample.mjs";

const images = join(viewerFolder, "../docs/images");
if (noCommand) {
  console.error(`screenshots: ${noCommand}`);
  process.exit(2);
}

/** Opens a page, does something with it, and writes what is seen once the replay shows it. */
async function picture(browser, file, theme, name, act) {
  const { page, errors, close } = await openPage(browser, `file://${file}`, { theme });
  await page.waitForFunction(() => window.poise?.replay?.pictures > 0);
  await page.evaluate(act);
  await page.evaluate(() => window.poise.replay.drawNow());
  await page.waitForTimeout(300);
  await page.screenshot({ path: join(images, name) });
  if (errors.length > 0) throw new Error(`${name}: ${errors.join("; ")}`);
  await close();
}

await mkdir(images, { recursive: true });
console.log(`with ${command}`);
const browser = await launch();
await liveScreenshot(browser, command, images);
if (process.argv[2] === "live") {
  await browser.close();
  process.exit();
}
await withFolder(async (folder) => {
  const run = [
    "run",
    "jacks",
    "--bodies",
    "300",
    "--frames",
    "200",
    "--deadline",
    "6",
    "--reference",
    "every=20",
    "--quiet",
  ];
  await poise(...run, "--report", join(folder, "jacks"), "--capture-contacts", "--capture-pairs");
  const page = join(folder, "jacks", "report.html");
  await picture(browser, page, "light", "report-light.png", () => {
    window.poise.player.goTo(125);
    window.poise.replay.drawNow();
    window.poise.replay.choose("camera", "all");
  });
  await picture(browser, page, "dark", "report-dark.png", () => {
    const { player, replay } = window.poise;
    player.goTo(150);
    replay.drawNow();
    replay.choose("camera", "all");
    replay.choose("color", "priority");
    replay.choose("show", "reached");
    replay.drawNow();
    replay.pickAt(0.45 * replay.canvas.clientWidth, 0.55 * replay.canvas.clientHeight);
  });
  const jacks = ["run", "jacks", "--bodies", "300", "--frames", "150", "--clock", "work", "--quiet"];
  await poise(...jacks, "--capture", join(folder, "full.capture"));
  await poise(...jacks, "--budget-work", "1000", "--capture", join(folder, "coarse.capture"));
  await poise("view", join(folder, "full.capture"), join(folder, "coarse.capture"), "--out", join(folder, "both.html"));
  await picture(browser, join(folder, "both.html"), "light", "report-compare.png", () => {
    window.poise.player.goTo(120);
    window.poise.replay.drawNow();
    window.poise.replay.choose("camera", "all");
  });
});
await browser.close();
