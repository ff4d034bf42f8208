// SPDX-License-Identifier: MIT
// The page in a real browser, opened from disk.
import assert from "node:assert/strict";
import { test } from "node:test";

import { invented, kLate, skip, withPage } from "./report_page.mjs";
import { coarseRun, inventedFrames, smallRun } from "./sample.mjs";

/** A run with a replay whose table names late frames where we want them. */
const replayed = async (folder) => {
  const parts = await smallRun(folder, "--capture-contacts");
  return { ...parts, run: { ...parts.run, clock: "wall", deadline_ms: 16 }, frames: inventedFrames(90, kLate) };
};

/** Draws now, and counts pixels of the replay that are not its background. */
const drawnPixels = (page) =>
  page.evaluate(() => {
    const { replay } = window.poise;
    replay.drawNow();
    const gl = replay.renderer.getContext();
    const pixels = new Uint8Array(4 * gl.drawingBufferWidth * gl.drawingBufferHeight);
    gl.readPixels(0, 0, gl.drawingBufferWidth, gl.drawingBufferHeight, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
    const colored = [0, 0, 0];
    let sum = 0;
    for (let at = 0; at < pixels.length; at += 4) {
      const [r, g, b] = pixels.subarray(at, at + 3);
      if (Math.max(r, g, b) - Math.min(r, g, b) > 60) {
        colored[r > g && r > b ? 0 : g >= b ? 1 : 2] += 1;
      }
      sum = (31 * sum + r + 7 * g + 13 * b) >>> 0;
    }
    return { colored, sum, count: colored[0] + colored[1] + colored[2] };
  });

for (const theme of ["light", "dark"]) {
  test(`the page of a run opens from disk and shows its figures (${theme})`, { skip }, () =>
    withPage(
      invented(),
      async (page) => {
        assert.equal(await page.evaluate(() => document.documentElement.dataset.theme), theme);
        assert.equal(await page.textContent("#scene"), "<b>heap</b>", "a name is no markup");
        assert.equal(await page.textContent("#on-time h2"), "✕ 5 % late");
        assert.match(await page.textContent("#how-true"), /Error 10 %/);
        assert.match(await page.textContent("#command"), /poise run heap --deadline 16/);
        assert.match(await page.textContent("#details"), /a processor/);
        for (const id of [
          "frame-time",
          "histogram",
          "percentiles",
          "levels",
          "error",
          "reserve",
          "resting",
          "energy",
          "momentum",
        ]) {
          const ink = await page.evaluate((name) => {
            const canvas = document.querySelector(`#chart-${name} canvas:not(.mark)`);
            const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
            let count = 0;
            for (let at = 3; at < data.length; at += 4) count += data[at] > 200 ? 1 : 0;
            return count;
          }, id);
          assert.ok(ink > 200, `${id} has ${ink} pixels`);
        }
        assert.equal(await page.isVisible("#replay"), false);
      },
      { theme },
    ),
  );
}

test("pointing at any chart moves to the frame there", { skip }, () =>
  withPage(invented(), async (page) => {
    const pointAt = async (id, share) => {
      const box = await page.locator(`#chart-${id} .u-over`).boundingBox();
      await page.mouse.move(box.x + share * box.width, box.y + box.height / 2);
      return page.evaluate(() => window.poise.store.get("row"));
    };
    assert.equal(await pointAt("frame-time", 0.5 + 0.5 / 60), 30);
    assert.equal(await pointAt("frame-time", 0.01), 0);
    for (const id of ["levels", "energy", "momentum", "reserve", "error", "resting"]) {
      await page.locator(`#chart-${id}`).scrollIntoViewIfNeeded();
      assert.equal(await pointAt(id, 10.5 / 60), 10, id);
    }
    await page.locator("#chart-histogram").scrollIntoViewIfNeeded();
    assert.ok([7, 30, 59].includes(await pointAt("histogram", 0.99)), "the slow end of the histogram is a late frame");
    assert.ok([7, 30, 59].includes(await pointAt("percentiles", 0.99)), "so is that of the percentiles");
  }),
);

test("dragging zooms all charts of frames, a double click shows everything again", { skip }, () =>
  withPage(invented(), async (page) => {
    const ranges = () =>
      page.evaluate(() =>
        ["frame-time", "levels", "energy"].map((id) => {
          const { min, max } = window.poise.charts[id].chart().scales.x;
          return [Math.round(min), Math.round(max)];
        }),
      );
    const box = await page.locator("#chart-frame-time .u-over").boundingBox();
    await page.mouse.move(box.x + box.width / 4, box.y + 40);
    await page.mouse.down();
    await page.mouse.move(box.x + box.width / 2, box.y + 60, { steps: 4 });
    await page.mouse.up();
    assert.deepEqual(await ranges(), [
      [15, 30],
      [15, 30],
      [15, 30],
    ]);
    await page.mouse.dblclick(box.x + box.width / 2, box.y + 40);
    assert.deepEqual(await ranges(), [
      [0, 60],
      [0, 60],
      [0, 60],
    ]);
    await page.keyboard.press("+");
    const [[from, to]] = await ranges();
    assert.ok(to - from < 60);
    await page.keyboard.press("0");
    assert.deepEqual(await ranges(), [
      [0, 60],
      [0, 60],
      [0, 60],
    ]);
  }),
);

for (const theme of ["light", "dark"]) {
  test(`the replay draws, plays, steps and scrubs (${theme})`, { skip }, () =>
    withPage(
      replayed,
      async (page) => {
        const row = () => page.evaluate(() => window.poise.store.get("row"));
        const first = await drawnPixels(page);
        assert.ok(first.count + first.sum > 0);
        await page.evaluate(() => window.poise.replay.choose("color", "state"));
        const moving = await drawnPixels(page);
        assert.ok(moving.colored[2] > 300, `moving bodies are blue: ${moving.colored}`);
        await page.keyboard.press("ArrowRight");
        assert.equal(await row(), 1);
        await page.keyboard.press("Shift+ArrowRight");
        assert.equal(await row(), 11);
        await page.click("#back");
        assert.equal(await row(), 10);
        assert.notEqual((await drawnPixels(page)).sum, moving.sum, "bodies fall");
        await page.locator("#scrubber").fill("80");
        assert.equal(await row(), 80);
        await page.waitForFunction(() => window.poise.replay.shownRow === 80);
        assert.equal(
          await page.evaluate(() => window.poise.replay.views[0].cursor.facts.frame),
          81,
          "row 80 is the state after 81 steps",
        );
        await page.click("#play");
        await page.waitForFunction(() => window.poise.store.get("row") === 89 && !window.poise.store.get("playing"));
        await page.keyboard.press("Home");
        await page.keyboard.press("Space");
        await page.waitForFunction(() => window.poise.store.get("row") > 3);
        await page.keyboard.press("Space");
        const stopped = await row();
        await page.evaluate(() => new Promise(requestAnimationFrame));
        assert.equal(await row(), stopped);
      },
      { theme },
    ),
  );
}

test("the replay plays on where frames were left out", { skip }, () => {
  const rows = inventedFrames(60, kLate).trim().split("\n");
  // The 25 frames after the 20th. A turn of the player is at most 0.25 s, so none leaps over them.
  const frames = [...rows.slice(0, 21), ...rows.slice(46)].join("\n") + "\n";
  return withPage(invented({ frames }), async (page) => {
    await page.evaluate(() => {
      window.poise.player.goTo(17);
      window.poise.store.set("playing", true);
    });
    await page.waitForFunction(() => window.poise.store.get("row") === 34 && !window.poise.store.get("playing"));
  });
});

test("another colouring, other shapes and another camera change the picture", { skip }, () =>
  withPage(replayed, async (page) => {
    await page.evaluate(() => window.poise.player.goTo(70));
    const sums = new Set();
    for (const color of ["level", "priority", "speed", "state", "clock", "visibility"]) {
      await page.selectOption("#color", color);
      sums.add((await drawnPixels(page)).sum);
      assert.ok((await page.textContent("#colors")).length > 3, `${color} has a legend`);
    }
    await page.selectOption("#color", "state");
    const states = await page.locator("#colors > span").allTextContents();
    assert.deepEqual(states, ["static", "kinematic", "moving", "asleep", "waiting", "paused"]);
    // Without a deadline nothing is ranked: all are grey.
    assert.ok(sums.size >= 3, `${sums.size} pictures`);
    await page.selectOption("#show", "0");
    sums.add((await drawnPixels(page)).sum);
    await page.keyboard.press("a");
    assert.equal(await page.inputValue("#camera"), "free");
    for (const camera of ["scene", "free", "scene"]) {
      await page.keyboard.press("v");
      assert.equal(await page.inputValue("#camera"), camera);
    }
    await page.keyboard.press("a");
    sums.add((await drawnPixels(page)).sum);
    await page.check("#show-contacts");
    sums.add((await drawnPixels(page)).sum);
    assert.ok(sums.size >= 6, `${sums.size} pictures`);
  }),
);

test("a click on a body shows its facts in this frame; Escape closes them", { skip }, () =>
  withPage(replayed, async (page) => {
    await page.evaluate(() => window.poise.player.goTo(60));
    await page.waitForFunction(() => window.poise.replay.shownRow === 60);
    const place = await page.evaluate(() => {
      const { replay } = window.poise;
      const { cursor, file } = replay.views[0];
      const { camera } = replay.cameras;
      // The nearest of those well inside of the picture: nothing hides it.
      const [near] = [...cursor.rows]
        .filter((row) => file.bodies.motion[row] === 2)
        .map((row) => ({ row, seen: camera.position.clone().fromArray(cursor.position, 3 * row).project(camera) }))
        .filter(({ seen }) => Math.max(Math.abs(seen.x), Math.abs(seen.y)) < 0.8)
        .sort((a, b) => a.seen.z - b.seen.z);
      return {
        number: file.bodies.number[near.row],
        x: (0.5 + 0.5 * near.seen.x) * replay.canvas.clientWidth,
        y: (0.5 - 0.5 * near.seen.y) * replay.canvas.clientHeight,
      };
    });
    await page.click("#view", { position: { x: place.x, y: place.y } });
    await page.waitForSelector("#facts:not([hidden])");
    const facts = await page.textContent("#facts");
    assert.match(facts, new RegExp(`Body ${place.number}[^0-9]`));
    assert.match(facts, /jack/);
    assert.match(facts, /moving/);
    assert.match(facts, /m\/s/);
    assert.ok(await page.isVisible("#chosen"));
    await page.keyboard.press("Escape");
    await page.waitForSelector("#facts", { state: "hidden" });
    // Where the gaze rests, bodies fall past.
    const draw = (row) => page.evaluate((at) => (window.poise.player.goTo(at), window.poise.replay.drawNow()), row);
    for (let frame = 40; frame < 90 && (await page.isHidden("#facts")); ++frame) {
      await draw(frame);
      await page.keyboard.press("b");
      await draw(frame);
    }
    await page.waitForSelector("#facts:not([hidden])");
    assert.match(await page.textContent("#facts h3"), /^Body \d+/);
    // While frames change the button stays, and can be pressed.
    const isSame = await page.evaluate(() => {
      const button = document.querySelector("#facts button");
      const { player, replay } = window.poise;
      player.goTo(39);
      replay.drawNow();
      return button === document.querySelector("#facts button");
    });
    assert.ok(isSame);
    await page.click("#facts button");
    await page.waitForSelector("#facts", { state: "hidden" });
  }),
);

test("pairs that were left coarse are lines, and a body tells of its pairs", { skip }, () =>
  withPage(
    coarseRun,
    async (page) => {
      await page.evaluate(() => window.poise.player.goTo(110));
      const before = await drawnPixels(page);
      await page.keyboard.press("l");
      const withLines = await drawnPixels(page);
      assert.notEqual(withLines.sum, before.sum);
      const counts = await page.evaluate(() => {
        const { replay } = window.poise;
        const { coarse, pairs } = replay.views[0];
        const apart = (i) => (pairs.state[i] & 7) > 3;
        const left = [...pairs.state.keys()].filter((i) => pairs.state[i] & 16 && pairs.level[i] < pairs.deepest[i]);
        return [coarse.count, left.filter((i) => !apart(i)).length];
      });
      assert.equal(counts[0], counts[1]);
      assert.ok(counts[0] > 0);
      const shown = await page.evaluate(() => {
        const { replay } = window.poise;
        const { pairs } = replay.views[0];
        const i = pairs.state.findIndex((state, k) => (state & 23) === 16 && pairs.deepest[k] > 0);
        replay.chosen = { view: replay.views[0], row: pairs.a[i] };
        replay.drawNow();
        return document.querySelector("#facts").textContent;
      });
      assert.match(shown, /pairs?, \d+ left coarse/);
      assert.match(shown, /(left out: root spheres|refined to level \d|reused at level \d), of level \d/);
      assert.match(shown, /: the budget was used up before its turn \((first|after \d+) of \d+ that waited/);
      await page.keyboard.press("v");
      await drawnPixels(page);
      assert.equal(await page.evaluate(() => window.poise.replay.views[0].frustum.lines.lines.visible), false);
      await page.keyboard.press("f");
      await drawnPixels(page);
      assert.equal(await page.evaluate(() => window.poise.replay.views[0].frustum.lines.lines.visible), true);
    },
  ),
);

test("without pairs in the capture the page says how to get them", { skip }, () =>
  withPage(replayed, async (page) => {
    assert.equal(await page.isDisabled("#show-coarse"), true);
    assert.match(await page.evaluate(() => document.getElementById("show-coarse").parentElement.title), /--capture-pairs/);
    const colors = await page.evaluate(() => [...document.getElementById("color").options].map(({ value }) => value));
    assert.ok(colors.includes("clock") && !colors.includes("seen") && !colors.includes("contact"));
  }),
);

test("the scrubber marks late frames where they are, and N goes to the next", { skip }, () =>
  withPage(replayed, async (page) => {
    const colors = await page.evaluate((late) => {
      const canvas = document.getElementById("scrubber-marks");
      const context = canvas.getContext("2d");
      const scale = canvas.width / canvas.clientWidth;
      const { data } = context.getImageData(0, Math.round(7 * scale), canvas.width, 1);
      const at = (row) => 8 + ((canvas.clientWidth - 16) * row) / 89;
      const pixel = (row) => [...data.subarray(4 * Math.round(at(row) * scale), 4 * Math.round(at(row) * scale) + 4)];
      return { late: late.map(([row]) => pixel(row)), other: [0, 20, 45, 80].map((row) => pixel(row)[3]) };
    }, kLate);
    assert.deepEqual(colors.late, [
      [0x7a, 0x7a, 0x7a, 255],
      [0xcc, 0x79, 0xa7, 255],
      [0xd5, 0x5e, 0x00, 255],
    ]);
    assert.deepEqual(colors.other, [0, 0, 0, 0]);
    for (const [row, cause] of kLate) {
      await page.keyboard.press("n");
      assert.equal(await page.evaluate(() => window.poise.store.get("row")), row);
      await page.waitForFunction((text) => document.getElementById("late-badge").textContent.includes(text), cause);
    }
    await page.keyboard.press("p");
    assert.equal(await page.evaluate(() => window.poise.store.get("row")), 30);
  }),
);

test("the button changes the theme of everything", { skip }, () =>
  withPage(replayed, async (page) => {
    const before = await page.evaluate(() => getComputedStyle(document.body).backgroundColor);
    const picture = await drawnPixels(page);
    await page.click("#theme");
    assert.notEqual(await page.evaluate(() => getComputedStyle(document.body).backgroundColor), before);
    assert.notEqual((await drawnPixels(page)).sum, picture.sum);
  }),
);

test("every control has a name, and the help opens with a key", { skip }, () =>
  withPage(replayed, async (page) => {
    const unnamed = await page.evaluate(() =>
      [...document.querySelectorAll("button, select, input, canvas[tabindex], .plot")]
        .filter(
          (control) =>
            !(
              control.getAttribute("aria-label") ||
              control.textContent.trim() ||
              control.closest("label")?.textContent.trim()
            ),
        )
        .map((control) => control.id || control.className),
    );
    assert.deepEqual(unnamed, []);
    await page.keyboard.press("?");
    assert.ok(await page.isVisible("#help"));
    await page.keyboard.press("Escape");
    assert.equal(await page.isVisible("#help"), false);
  }),
);

test("a page of a capture alone has charts from the capture", { skip }, () =>
  withPage(
    async (folder) => {
      const { captures } = await smallRun(folder);
      return { captures };
    },
    async (page) => {
      assert.equal(await page.textContent("#scene"), "jacks");
      assert.match(await page.textContent("#on-time"), /No deadlineThe work clock ran\. 99/);
      assert.match(await page.textContent("#command"), /poise run jacks --bodies 60/);
      assert.ok(await page.isVisible("#chart-frame-time"));
      assert.ok(await page.isVisible("#chart-energy"));
      assert.ok(await page.isVisible("#chart-momentum"));
      const widths = await page.evaluate(() =>
        ["energy", "momentum"].map((id) => {
          const { _size: width, _values: texts } = window.poise.charts[id].chart().axes[1];
          return width - 6.4 * Math.max(...texts.map((text) => text.length));
        }),
      );
      assert.ok(Math.min(...widths) > 8, `${widths} px are left beside the longest text of an axis`);
      assert.ok(await page.isVisible("#replay"));
    },
  ),
);

test("a table without momentum, of an earlier version, leaves its chart out", { skip }, () => {
  const rows = inventedFrames(60, kLate)
    .trim()
    .split("\n")
    .map((line) => line.split(","));
  const keep = rows[0].map((name) => !name.startsWith("momentum_"));
  const frames = rows.map((row) => row.filter((_, k) => keep[k]).join(",")).join("\n") + "\n";
  return withPage(invented({ frames }), async (page) => {
    assert.equal(await page.locator("#chart-momentum").count(), 0);
    assert.ok(await page.isVisible("#chart-energy"));
  });
});

test("two captures stand side by side, coloured by how far they are apart", { skip }, () =>
  withPage(
    async (folder) => {
      const {
        captures: [a],
      } = await smallRun(folder);
      const {
        captures: [b],
      } = await smallRun(folder, "--policy", "random", "--seed", "5");
      return { captures: [a, b], page: { captures: ["a.capture", "b.capture"] } };
    },
    async (page) => {
      assert.deepEqual(await page.locator("#views div").allTextContents(), ["a.capture", "b.capture"]);
      assert.equal(await page.inputValue("#color"), "difference");
      await page.evaluate(() => window.poise.player.goTo(80));
      assert.ok((await drawnPixels(page)).count > 100, "bodies that are apart are not grey");
      assert.deepEqual(
        await page.evaluate(() => window.poise.replay.views.map(({ cursor }) => cursor.facts.frame)),
        [81, 81],
      );
    },
  ),
);

test("what is wrong with a capture is told, and the charts are there", { skip }, () =>
  withPage(invented({ captures: [Buffer.from("no capture at all")] }), async (page) => {
    assert.match(await page.textContent("#problem"), /The capture cannot be read: this is no capture of this version/);
    assert.ok(await page.isVisible("#chart-frame-time"));
  }),
);

test("a page without a run says how to make one", { skip }, () =>
  withPage({}, async (page) => {
    assert.match(await page.textContent("#problem"), /poise run SCENE --report FOLDER/);
  }),
);
