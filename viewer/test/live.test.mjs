// SPDX-License-Identifier: MIT
// The page of a live run in a real browser, with the command serving it.
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { after, before, test } from "node:test";

import { chromiumPath, launch, mostWait } from "./browser.mjs";
import { command, noCommand } from "./sample.mjs";

const skip = chromiumPath ? noCommand : "no Chromium is installed";

let browser = null;
before(async () => {
  if (!skip) browser = await launch();
});
after(() => browser?.close());

/** Starts `poise live`; the address of its page, and how it ends. */
function startLive(...words) {
  const environment = { ...process.env, POISE_TREE_CACHE: "off", POISE_TIME_PRIORS: "off" };
  const child = spawn(command, ["live", ...words, "--quiet"], { env: environment });
  let out = "";
  let error = "";
  child.stderr.on("data", (text) => (error += text));
  const ended = new Promise((resolve) => child.on("exit", (code) => resolve({ code, error })));
  const address = new Promise((resolve, reject) => {
    child.stdout.on("data", (text) => {
      out += text;
      if (out.endsWith("\n")) resolve(out.trim());
    });
    ended.then(() => reject(new Error(`poise live ended: ${error}`)));
  });
  // Once it has said where the page is, its end is no failure.
  address.catch(() => {});
  return {
    address,
    stop() {
      child.kill("SIGINT");
      return ended;
    },
  };
}

/** A page of the run, which notes what its console says. */
async function openLive(address, { theme = "light" } = {}) {
  const context = await browser.newContext({ viewport: { width: 1280, height: 720 }, colorScheme: theme });
  const page = await context.newPage();
  page.setDefaultTimeout(mostWait);
  const errors = [];
  page.on("console", (message) => {
    if (message.type() === "error" || message.type() === "warning") errors.push(message.text());
  });
  page.on("pageerror", (failure) => errors.push(String(failure)));
  page.on("request", (request) => {
    if (!request.url().startsWith(address) && !/^(data|blob):/.test(request.url()))
      errors.push(`fetched ${request.url()}`);
  });
  await page.goto(address);
  await shows(page);
  return { page, errors, close: () => context.close() };
}
const shows = (page) => page.waitForFunction(() => window.poise?.stage?.pictures > 0 && window.poise.status);

/** Does something with the page of a small run; fails if the console said anything. */
async function withLive(use, words = ["jacks", "--bodies", "40", "--threads", "1"], options) {
  const run = startLive(...words);
  try {
    const address = await run.address;
    const { page, errors, close } = await openLive(address, options);
    await use(page, address);
    assert.deepEqual(errors, []);
    await close();
  } finally {
    assert.deepEqual(await run.stop(), { code: 0, error: "" });
  }
}

/** Puts a slider there as a hand does. */
const slide = (page, id, value) =>
  page.evaluate(
    ([name, wanted]) => {
      const input = document.getElementById(name);
      input.value = String(wanted);
      input.dispatchEvent(new Event("input"));
    },
    [id, value],
  );
const status = (page) => page.evaluate(() => window.poise.status);
const statusIs = (page, test, argument) => page.waitForFunction(test, argument);

for (const theme of ["light", "dark"]) {
  test(`the page shows the run as it goes on (${theme})`, { skip }, () =>
    withLive(
      async (page) => {
        assert.equal(await page.evaluate(() => document.documentElement.dataset.theme), theme);
        assert.equal(await page.textContent("#scene"), "jacks");
        await page.waitForFunction(() => window.poise.recent.frames.length > 20);
        await page.waitForFunction(() => /On time|late/.test(document.querySelector("#on-time h2").textContent));
        assert.match(await page.textContent("#bodies h2"), /^40 bodies$/);
        assert.match(await page.textContent("#level h2"), /^Level /);
        for (const id of ["frame-time", "levels"]) {
          await page.waitForFunction((name) => {
            const canvas = document.querySelector(`#chart-${name} canvas:not(.mark)`);
            const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
            let count = 0;
            for (let at = 3; at < data.length; at += 4) count += data[at] > 200 ? 1 : 0;
            return count > 200;
          }, id);
        }
        // Bodies have a colour once they touch; how soon the page has got there depends on the machine.
        await page.waitForFunction(() => {
          const { stage } = window.poise;
          stage.drawNow();
          const gl = stage.renderer.getContext();
          const pixels = new Uint8Array(4 * gl.drawingBufferWidth * gl.drawingBufferHeight);
          gl.readPixels(0, 0, gl.drawingBufferWidth, gl.drawingBufferHeight, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
          let colored = 0;
          for (let at = 0; at < pixels.length; at += 4)
            if (Math.max(...pixels.subarray(at, at + 3)) - Math.min(...pixels.subarray(at, at + 3)) > 60) ++colored;
          return colored > 300;
        });
        assert.equal(await page.isVisible("#problem"), false);
      },
      undefined,
      { theme },
    ),
  );
}

test("the sliders change what the run does, as it says itself", { skip }, () =>
  withLive(async (page) => {
    const before = await status(page);
    await slide(page, "deadline", 250);
    await statusIs(page, (was) => window.poise.status.deadline_ms < 0.5 * was, before.deadline_ms);
    await page.waitForFunction(() => {
      const shown = parseFloat(document.getElementById("deadline-value").textContent);
      return Math.abs(shown - window.poise.status.deadline_ms) < 0.01;
    });
    await slide(page, "bodies-wanted", 300);
    await statusIs(page, () => window.poise.status.bodies_asked === 60);
    await statusIs(page, () => window.poise.status.bodies === 60);
    // The bodies themselves, with five planes of the tray.
    await page.waitForFunction(() => window.poise.stage.cursor.rows.length === 65);
    await slide(page, "bodies-wanted", 50);
    await page.waitForFunction(() => window.poise.stage.cursor.rows.length === 15);
    await slide(page, "alpha", 900);
    await statusIs(page, (was) => window.poise.status.alpha > 2 * was, before.alpha);
    await slide(page, "weight-closing", 500);
    await statusIs(page, () => window.poise.status.weights.closing.value === 2);
    await page.selectOption("#policy", "fifo");
    await statusIs(page, () => window.poise.status.policy === "fifo");
    await page.waitForFunction(() => !document.getElementById("weights-note").hidden);
  }),
);

test("a step that does not fit into its frame takes several, and the page says how many", { skip }, () =>
  withLive(
    async (page) => {
      await page.waitForFunction(() => window.poise.recent.contacts().count > 10);
      await page.evaluate(() => window.poise.send({ do: "deadline", ms: 0.01 }));
      await page.waitForFunction(() =>
        /Slower than real time, .*: a step takes [\d.]+ frames/.test(document.querySelector("#bodies p").textContent),
      );
      // Contacts are those of the last step until the next has ended, and jacks that lie on each other have some.
      await page.waitForFunction(() => {
        const last = window.poise.recent.frames.slice(-30);
        return last.length === 30 && last.every(({ levels, deadline_ms }) => deadline_ms < 0.02 && Math.max(...levels) > 0);
      });
      // What has to wait for the end of a step is done, and so is what was asked for after it.
      await page.evaluate(() => {
        window.poise.send({ do: "alpha", value: 0.05 });
        window.poise.send({ do: "pause", on: true });
      });
      await statusIs(page, () => window.poise.status.alpha === 0.05 && window.poise.status.paused);
    },
    ["jacks", "--bodies", "100", "--threads", "1"],
  ),
);

test("the mouse is the gaze of the run, and without it the camera's direction", { skip }, () =>
  withLive(async (page) => {
    const box = await page.locator("#view").boundingBox();
    await page.mouse.move(box.x + 0.2 * box.width, box.y + 0.4 * box.height);
    const angle = () => {
      const { gaze, forward } = window.poise.stage.camera;
      return Math.acos(Math.min(1, gaze[0] * forward[0] + gaze[1] * forward[1] + gaze[2] * forward[2]));
    };
    await page.evaluate(`window.angle = ${angle}`);
    await page.waitForFunction(() => window.angle() > 0.1);
    // The ring, which stands where the run says that the gaze is, is under the mouse.
    await page.waitForFunction(
      ([x, y]) => {
        const ring = document.getElementById("gaze");
        return Math.hypot(parseFloat(ring.style.left) - x, parseFloat(ring.style.top) - y) < 3;
      },
      [0.2 * box.width, 0.4 * box.height],
    );
    await page.mouse.move(box.x + 0.7 * box.width, box.y + 0.7 * box.height);
    await page.waitForFunction(
      (x) => Math.abs(parseFloat(document.getElementById("gaze").style.left) - x) < 3,
      0.7 * box.width,
    );
    await page.mouse.move(5, 5);
    // Out of the picture it is the scene's again, which looks ahead.
    await page.waitForFunction(() => window.angle() < 0.01);
  }),
);

test("turning the picture moves the camera of the run", { skip }, () =>
  withLive(async (page) => {
    const before = await page.evaluate(() => window.poise.stage.camera.position_m);
    const box = await page.locator("#view").boundingBox();
    await page.mouse.move(box.x + 200, box.y + 100);
    await page.mouse.down();
    await page.mouse.move(box.x + 320, box.y + 130, { steps: 4 });
    await page.mouse.up();
    assert.equal(await page.inputValue("#camera"), "free");
    await page.waitForFunction((was) => {
      const now = window.poise.stage.camera.position_m;
      const own = window.poise.stage.cameras.camera.position.toArray();
      const apart = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
      return apart(now, was) > 0.5 && apart(now, own) < 1e-3;
    }, before);
    await page.keyboard.press("v");
    await page.waitForFunction((was) => {
      const now = window.poise.stage.camera.position_m;
      return Math.hypot(now[0] - was[0], now[1] - was[1], now[2] - was[2]) < 1e-6;
    }, before);
  }),
);

test("keys pour, pause, step and start again", { skip }, () =>
  withLive(async (page) => {
    await page.keyboard.press("p");
    await statusIs(page, () => window.poise.status.bodies === 50);
    await page.keyboard.press("Space");
    await statusIs(page, () => window.poise.status.paused);
    await page.waitForFunction(() => document.getElementById("pause").textContent === "Go on");
    const { frame } = await status(page);
    await page.keyboard.press(".");
    // On a slow machine a step takes several frames, and the one that was going on at the pause goes on to its end.
    await statusIs(page, (was) => window.poise.status.frame > was && window.poise.status.paused, frame);
    await page.keyboard.press("r");
    await statusIs(page, () => window.poise.status.frame === 0 && window.poise.status.bodies === 40);
    await page.waitForFunction(() => window.poise.capture.frames[0].frame === 0);
    await page.click("#pause");
    await statusIs(page, () => !window.poise.status.paused && window.poise.status.frame > 5);
  }),
);

/** The dynamic body nearest to the eye of those well inside the picture: where it is seen, and its number. */
const nearestBody = (page) =>
  page.evaluate(() => {
    const { stage, capture } = window.poise;
    const { cursor, cameras } = stage;
    stage.drawNow();
    const eye = cameras.camera.position;
    const near = [...cursor.rows]
      .filter((row) => capture.bodies.motion[row] === 2)
      .map((row) => ({ row, place: eye.clone().fromArray(cursor.position, 3 * row) }))
      .map(({ row, place }) => ({ row, away: place.distanceTo(eye), seen: place.project(cameras.camera) }))
      .filter(({ seen }) => Math.abs(seen.x) < 0.7 && Math.abs(seen.y) < 0.7)
      .sort((a, b) => a.away - b.away)[0];
    const box = stage.canvas.getBoundingClientRect();
    return {
      number: capture.bodies.number[near.row],
      x: box.x + (0.5 + 0.5 * near.seen.x) * box.width,
      y: box.y + (0.5 - 0.5 * near.seen.y) * box.height,
    };
  });
const fact = (page, name) =>
  page.evaluate(
    (wanted) => [...document.querySelectorAll("#facts dt")].find((term) => term.textContent === wanted)?.nextSibling.textContent,
    name,
  );

test("a click on a body tells its facts, which follow the run; a button, Escape and B close and open them", { skip }, () =>
  withLive(async (page) => {
    const pause = async () => {
      await page.keyboard.press("Space");
      await statusIs(page, () => window.poise.status.paused);
      await page.waitForFunction(() => window.poise.capture.frames[0].frame === window.poise.status.frame);
    };
    await statusIs(page, () => window.poise.status.frame > 60);
    await pause();
    const { number, x, y } = await nearestBody(page);
    await page.mouse.click(x, y);
    await page.waitForSelector("#facts:not([hidden])");
    assert.equal(await page.textContent("#facts h3"), `Body ${number}`);
    assert.match(await fact(page, "shape"), /jack/);
    assert.match(await fact(page, "state"), /^(moving|waiting|paused|asleep)/);
    assert.match(await fact(page, "level"), /^(touches nothing|level \d|polygons)$/);
    assert.match(await fact(page, "mass"), / kg$/);
    assert.ok(await page.isVisible("#chosen"));
    await page.keyboard.press(".");
    await page.waitForFunction(() => /^[0-9.e-]+ m\/s$/.test(document.querySelector("#facts dl").children[11].textContent));
    const before = await fact(page, "position");
    await page.keyboard.press("Space");
    await page.waitForFunction((was) => !document.querySelector("#facts dl").textContent.includes(was), before);
    // While it goes on, the button can be pressed: it is not made anew with each frame.
    await page.click("#facts button");
    await page.waitForSelector("#facts", { state: "hidden" });
    await page.waitForSelector("#chosen", { state: "hidden" });
    await pause();
    const now = await nearestBody(page);
    await page.mouse.move(now.x, now.y);
    await page.keyboard.press("b");
    await page.waitForSelector("#facts:not([hidden])");
    assert.equal(await page.textContent("#facts h3"), `Body ${now.number}`);
    await page.keyboard.press("Escape");
    await page.waitForSelector("#facts", { state: "hidden" });
  }),
);

test("a chosen body that has left is said to be gone, and is found again when it is back", { skip }, () =>
  withLive(async (page) => {
    const number = await page.evaluate(() => {
      const { capture, stage } = window.poise;
      const row = capture.bodies.number.length - 1;
      stage.chosen = { number: capture.bodies.number[row], row };
      return stage.chosen.number;
    });
    const state = () => [...document.querySelectorAll("#facts dt")].find((term) => term.textContent === "state")?.nextSibling.textContent;
    await page.evaluate(`window.stateOfChosen = ${state}`);
    await page.waitForFunction(() => /^(moving|waiting|paused|asleep)/.test(window.stateOfChosen()));
    await slide(page, "bodies-wanted", 50);
    await page.waitForFunction(() => window.stateOfChosen() === "not there in this frame");
    assert.equal(await page.isVisible("#chosen"), false);
    await page.keyboard.press("r");
    await page.waitForFunction(() => /^(moving|waiting|paused|asleep)/.test(window.stateOfChosen()));
    assert.equal(await page.textContent("#facts h3"), `Body ${number}`);
  }),
);

test("what is wrong is refused and told, and changes nothing", { skip }, () =>
  withLive(async (page) => {
    await page.evaluate(() => window.poise.send({ do: "deadline", ms: -1 }));
    await page.waitForFunction(() => window.poise.errors.length === 1);
    assert.equal(await page.textContent("#problem"), "Refused: message: ms = -1, must be > 0");
    assert.equal((await status(page)).deadline_ms, 16);
  }),
);

test("the run survives a reload, a lost connection, and shows the same on two pages", { skip }, () =>
  withLive(async (page, address) => {
    await page.evaluate(() => window.poise.send({ do: "deadline", ms: 9 }));
    await statusIs(page, () => window.poise.status.deadline_ms === 9);
    const { frame } = await status(page);
    await page.reload();
    await shows(page);
    const after = await status(page);
    assert.equal(after.deadline_ms, 9);
    assert.ok(after.frame > frame, "it went on meanwhile");
    const frames = await page.evaluate(() => window.poise.frames);
    // It may be told and be over between two looks at the page.
    await page.evaluate(
      () =>
        new Promise((resolve) => {
          const problem = document.getElementById("problem");
          const told = new MutationObserver(() => {
            if (!/No connection/.test(problem.textContent)) return;
            told.disconnect();
            resolve();
          });
          told.observe(problem, { childList: true, characterData: true, subtree: true });
          window.poise.connection.close();
        }),
    );
    await page.waitForFunction(
      (was) => window.poise.frames > was + 20 && document.getElementById("problem").hidden,
      frames,
    );
    const second = await openLive(address);
    await statusIs(page, () => window.poise.status.browsers === 2);
    await second.page.evaluate(() => window.poise.send({ do: "deadline", ms: 7 }));
    await statusIs(page, () => window.poise.status.deadline_ms === 7);
    await second.page.evaluate(() => window.poise.send({ do: "pause", on: true }));
    for (const shown of [page, second.page]) await statusIs(shown, () => window.poise.status.paused);
    const number = () => window.poise.capture.frames[0].frame;
    const last = (await status(page)).frame;
    for (const shown of [page, second.page])
      await shown.waitForFunction((wanted) => window.poise.capture.frames[0].frame === wanted, last);
    assert.equal(await page.evaluate(number), await second.page.evaluate(number));
    const places = (shown) => shown.evaluate(() => [...window.poise.stage.cursor.position.subarray(15, 45)]);
    assert.deepEqual(await places(page), await places(second.page));
    assert.deepEqual(second.errors, []);
    await second.close();
  }),
);

test("late frames are marked, in words, in the chart and in the picture", { skip }, () =>
  withLive(async (page) => {
    await page.evaluate(() => window.poise.send({ do: "deadline", ms: 0.001 }));
    await statusIs(page, () => Object.values(window.poise.status.late).reduce((sum, frames) => sum + frames, 0) > 20);
    await page.waitForFunction(() => /late$/.test(document.querySelector("#on-time h2").textContent));
    assert.match(await page.getAttribute("#on-time", "class"), /bad/);
    await page.waitForFunction(() => window.poise.charts["frame-time"].drawn.marks.length > 0);
    await page.waitForFunction(() => /^late by .* ms: /.test(document.getElementById("late-badge").textContent));
  }),
);

test("nobody without the token gets the page", { skip }, () =>
  withLive(async (page, address) => {
    const answer = await page.request.get(new URL("/", address).href);
    assert.equal(answer.status(), 404);
  }),
);
