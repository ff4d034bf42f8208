// SPDX-License-Identifier: MIT
// What a page costs: `node viewer/measure.mjs PAGE.html` opens it in a Chromium that draws without a graphics processor and
// prints its size, how long it takes until the first picture, and for each way to show bodies the time of a picture and the
// time that all its processors worked for it, which other programs do not lengthen.
import { readdirSync, readFileSync } from "node:fs";
import { stat } from "node:fs/promises";
import { resolve } from "node:path";

import { chromiumPath, launch, openPage } from "./test/browser.mjs";

const kPictures = 40;

/** Milliseconds that this process and those that it started have worked (Linux: in hundredths of a second). */
function worked_ms() {
  const parents = new Map();
  const ticks = new Map();
  for (const name of readdirSync("/proc").filter((entry) => /^\d+$/.test(entry))) {
    try {
      const text = readFileSync(`/proc/${name}/stat`, "utf8");
      const fields = text.slice(text.lastIndexOf(")") + 2).split(" ");
      parents.set(Number(name), Number(fields[1]));
      ticks.set(Number(name), Number(fields[11]) + Number(fields[12]));
    } catch {
      // It has ended meanwhile.
    }
  }
  const isOurs = (id) => id === process.pid || (parents.has(id) && parents.get(id) > 1 && isOurs(parents.get(id)));
  return 10 * [...ticks].filter(([id]) => isOurs(id)).reduce((sum, [, count]) => sum + count, 0);
}

/** Goes from frame to frame; each time lasts until the picture is complete. */
async function timesOf(page, show) {
  return page.evaluate(
    async ([choice, count]) => {
      const { replay, store, frames } = window.poise;
      replay.choose("show", choice);
      const gl = replay.renderer.getContext();
      const pixel = new Uint8Array(4);
      const times = [];
      for (let k = 0; k < count; ++k) {
        await new Promise(requestAnimationFrame);
        const began = performance.now();
        store.set("row", (Math.floor(frames.length / 3) + k) % frames.length);
        replay.drawNow();
        gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel); // waits for the picture
        times.push(performance.now() - began);
      }
      return times.sort((a, b) => a - b);
    },
    [show, kPictures],
  );
}

const [file] = process.argv.slice(2);
if (!file || !chromiumPath) {
  console.error(file ? "measure: no Chromium is installed" : "usage: node viewer/measure.mjs PAGE.html");
  process.exit(2);
}
const browser = await launch();
const began = performance.now();
const { page, errors } = await openPage(browser, `file://${resolve(file)}`);
await page.waitForFunction(() => window.poise?.replay?.pictures > 0, undefined, { timeout: 120_000 });
const first = performance.now() - began;
const bodies = await page.evaluate(() => window.poise.replay.views[0].cursor.rows.length);
console.log(`${file}: ${((await stat(file)).size / 1e6).toFixed(1)} MB, ${bodies} bodies`);
console.log(`first picture after ${(first / 1000).toFixed(1)} s`);
for (const show of ["shapes", "reached", "0"]) {
  const before = worked_ms();
  const times = await timesOf(page, show);
  const work = (worked_ms() - before) / kPictures;
  const [p50, p90] = [0.5, 0.9].map((share) => times[Math.ceil(share * kPictures) - 1].toFixed(0));
  console.log(`${show.padEnd(8)} p50 ${p50} ms, p90 ${p90} ms a picture; ${work.toFixed(0)} ms of work`);
}
for (const error of errors) console.log(`console: ${error}`);
await browser.close();
