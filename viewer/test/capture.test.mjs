// SPDX-License-Identifier: MIT
// The decoder of the page against what the command wrote of the same run by other means.
import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { join } from "node:path";
import { test } from "node:test";

import { CaptureFile } from "../src/capture/capture_file.js";
import { FrameCursor } from "../src/capture/frame_cursor.js";
import { findContactStates, findSeenErrors, isLeft, pairFramesOf, pairText, readPairs, whyText } from "../src/capture/pairs.js";
import { runOfCapture, tableOfCapture } from "../src/capture/frame_table.js";
import { parseFrames } from "../src/data/frames.js";
import { withFolder } from "./page.mjs";
import { coarseRun, noCommand, poise, smallRun } from "./sample.mjs";

/** Rows of `--states` as frame -> body -> numbers of the row from x on. */
function statesOf(text) {
  const frames = new Map();
  for (const line of text.trim().split("\n").slice(1)) {
    const [frame, , body, ...numbers] = line.split(",").map(Number);
    if (!frames.has(frame)) frames.set(frame, new Map());
    frames.get(frame).set(body, numbers);
  }
  return frames;
}

function agrees(cursor, states) {
  const { head, bodies } = cursor.file;
  const expected = states.get(cursor.facts.frame);
  assert.equal(cursor.rows.length, expected.size, `bodies of frame ${cursor.facts.frame}`);
  for (const row of cursor.rows) {
    const numbers = expected.get(bodies.number[row]);
    for (let axis = 0; axis < 3; ++axis) {
      const error = Math.abs(cursor.position[3 * row + axis] - numbers[axis]);
      assert.ok(
        error <= 0.5 * head.position_step_m + 1e-6 * Math.abs(numbers[axis]),
        `frame ${cursor.facts.frame}, row ${row}: off by ${error} m`,
      );
    }
    const [w, x, y, z] = numbers.slice(3, 7);
    const turn = cursor.orientation.subarray(4 * row, 4 * row + 4);
    const cosine = Math.min(1, Math.abs(turn[0] * x + turn[1] * y + turn[2] * z + turn[3] * w));
    // A float holds a cosine near 1 to 1e-7, which is an angle of 5e-4.
    assert.ok(
      2 * Math.acos(cosine) <= head.orientation_error_rad + 1.5e-3,
      `frame ${cursor.facts.frame}, row ${row}: turned`,
    );
  }
}

test("poses of a capture are those of --states, in order and at random", { skip: noCommand }, () =>
  withFolder(async (folder) => {
    const { captures } = await smallRun(folder, "--states", join(folder, "states.csv"));
    const states = statesOf(await readFile(join(folder, "states.csv"), "utf8"));
    const file = new CaptureFile(captures[0]);
    assert.equal(file.warning, "");
    assert.equal(file.frames.length, 91);
    const cursor = new FrameCursor(file);
    for (const index of [0, 1, 2, 3, 60, 61, 62, 90, 5, 59, 60, 0, 90]) {
      cursor.seek(index);
      agrees(cursor, states);
    }
  }),
);

test("bodies that come and go are there when they are", { skip: noCommand }, () =>
  withFolder(async (folder) => {
    const file = (name) => join(folder, name);
    await poise(
      "run",
      "pour",
      "--bodies",
      "200",
      "--frames",
      "130",
      "--clock",
      "work",
      "--budget-work",
      "100",
      "--quiet",
      "--capture",
      file("pour.capture"),
      "--states",
      file("states.csv"),
    );
    const cursor = new FrameCursor(new CaptureFile(await readFile(file("pour.capture"))));
    const states = statesOf(await readFile(file("states.csv"), "utf8"));
    for (const index of [0, 40, 41, 129, 130, 10]) {
      cursor.seek(index);
      agrees(cursor, states);
    }
  }),
);

test("speeds are the way from the frame before, wherever one comes from", { skip: noCommand }, () =>
  withFolder(async (folder) => {
    const { captures } = await smallRun(folder);
    const file = new CaptureFile(captures[0]);
    const straight = new FrameCursor(file);
    for (let index = 0; index <= 61; ++index) straight.seek(index);
    const jumped = new FrameCursor(file);
    jumped.seek(61);
    assert.deepEqual(jumped.speed, straight.speed);
    const moving = [...jumped.rows].filter((row) => file.bodies.motion[row] === 2);
    assert.ok(moving.every((row) => jumped.speed[row] >= 0) && moving.some((row) => jumped.speed[row] > 0.5));
    straight.seek(0);
    assert.ok(
      [...straight.rows].every((row) => Number.isNaN(straight.speed[row])),
      "nothing is before the start",
    );
  }),
);

test("the document of a capture has the means of the run's own, without its warm-up", { skip: noCommand }, () =>
  withFolder(async (folder) => {
    const { run, captures } = await smallRun(folder, "--warmup", "40");
    const file = new CaptureFile(captures[0]);
    const made = runOfCapture(file, tableOfCapture(file));
    assert.equal(made.frames, run.frames);
    assert.ok(Math.abs(made.contacts_mean - run.contacts_mean) < 1e-6, `${made.contacts_mean}, ${run.contacts_mean}`);
    assert.ok(Math.abs(made.levels.mean - run.levels.mean) < 1e-6, `${made.levels.mean}, ${run.levels.mean}`);
  }),
);

test("frames in which a step goes on count for no mean, and there may be very many frames", () => {
  const frameAt = (k) => ({
    frame: k,
    time_s: k / 60,
    measured: k > 0,
    warm_up: false,
    times_ms: new Array(9).fill(1),
    budget_ms: 2,
    lateness_ms: 0,
    cause: 0,
    // Each second frame ends a step, with 30 contacts at level 2; in the others all bodies wait.
    counts: [10, 0, 0, k % 2 === 0 ? 30 : 0, 0, 0, 0, 0, k % 2 === 0 ? 0 : 10, 0],
    levels: [0, 0, k % 2 === 0 ? 30 : 0, 0, 0, 0, 0, 0],
    kinetic_j: 0,
    potential_j: 0,
  });
  const file = {
    head: { deadline_ms: null },
    frames: Array.from({ length: 200001 }, (_, k) => frameAt(k)),
    bodies: { motion: [2] },
  };
  const made = runOfCapture(file, tableOfCapture(file));
  assert.equal(made.dynamic_bodies_max, 10);
  assert.equal(made.contacts_mean, 30);
  assert.equal(made.levels.mean, 2);
});

test("the table of a capture has the figures of --frames-csv", { skip: noCommand }, () =>
  withFolder(async (folder) => {
    const { captures, frames } = await smallRun(folder);
    const table = tableOfCapture(new CaptureFile(captures[0]));
    const expected = parseFrames(frames);
    assert.equal(table.length, expected.length);
    for (const name of [
      "frame",
      "bodies",
      "contact_pairs",
      "level_0",
      "level_1",
      "level_2",
      "pairs_left",
      "kinetic_j",
      "miss",
    ])
      assert.deepEqual([...table.column(name)], [...expected.column(name)], name);
    // Momentum is rounded to seven digits.
    for (const axis of ["x", "y", "z"]) {
      const name = `momentum_${axis}_kgmps`;
      assert.deepEqual([...table.column(name)], [...expected.column(name)].map(Math.fround), name);
    }
    assert.ok(table.column("momentum_z_kgmps").some((value) => value < -1), "bodies fall");
    for (let row = 0; row < table.length; ++row)
      assert.ok(Math.abs(table.column("total_ms")[row] - expected.column("total_ms")[row]) < 2e-4);
  }),
);

test("contact points lie between the bodies that they join", { skip: noCommand }, () =>
  withFolder(async (folder) => {
    const { captures } = await smallRun(folder, "--capture-contacts");
    const file = new CaptureFile(captures[0]);
    const cursor = new FrameCursor(file);
    cursor.seek(90);
    assert.ok(cursor.contacts.length > 4);
    for (const { a, b, normal, points_m: points } of cursor.contacts) {
      assert.ok(Math.abs(Math.hypot(...normal) - 1) < 1e-3);
      for (const row of [a, b]) {
        const shape = file.shapes[file.bodies.shape[row]];
        if (shape.kind === "plane") continue;
        const away = Math.hypot(...points[0].map((value, axis) => value - cursor.position[3 * row + axis]));
        assert.ok(away < 1.3 * shape.radius_m, `a point is ${away} m from body ${row}`);
      }
    }
  }),
);

test("pairs of a capture are those that its frames count, and reach the levels of its bodies", { skip: noCommand }, () =>
  withFolder(async (folder) => {
    const { captures } = await coarseRun(folder);
    const file = new CaptureFile(captures[0]);
    assert.equal(file.hasPairs, true);
    const cursor = new FrameCursor(file);
    let seen = 0;
    for (const index of [100, 101, 120, 12, 119]) {
      cursor.seek(index);
      const pairs = file.pairsOf(cursor.facts.frame);
      const left = Array.from({ length: pairs.count }, (_, i) => i).filter((i) => isLeft(pairs, i));
      assert.equal(left.length, cursor.facts.counts[4], `pairs left in frame ${index}`);
      const deepest = new Uint8Array(cursor.level.length);
      for (let i = 0; i < pairs.count; ++i) {
        assert.ok(cursor.has(pairs.a[i]) && cursor.has(pairs.b[i]));
        for (const row of [pairs.a[i], pairs.b[i]]) deepest[row] = Math.max(deepest[row], pairs.level[i] + 1);
        assert.match(pairText(pairs, i), /^(left out|root spheres|reused|refined|exact|apart)/);
      }
      for (const row of cursor.rows) assert.equal(deepest[row], cursor.level[row], `body ${row} of frame ${index}`);
      seen += pairs.count;
    }
    assert.ok(seen > 100);
    const plain = new CaptureFile((await smallRun(folder)).captures[0]);
    assert.equal(plain.hasPairs, false);
    assert.equal(plain.pairsOf(60).count, 0);
  }),
);

test("the story of a pair is the same in the capture of a run, in that of its record, and in what --explain says", { skip: noCommand }, () =>
  withFolder(async (folder) => {
    const inFolder = (name) => join(folder, name);
    const [record, run, replay, explained] = ["r.poise", "run.capture", "replay.capture", "r.json"].map(inFolder);
    const words = ["run", "jacks", "--bodies", "150", "--frames", "100", "--clock", "work", "--budget-work", "100"];
    await poise(...words, "--quiet", "--record", record, "--capture", run, "--capture-pairs");
    await poise("replay", record, "--capture", replay, "--capture-pairs", "--frames", "..90");
    await poise("replay", record, "--explain", "89", "--json", explained);
    const { explain } = JSON.parse(await readFile(explained, "utf8"));
    const keys = ["known_apart", "known_points", "mandatory", "found_apart", "deepest"];
    keys.push("reused", "cut_off", "front_full", "unseen", "unserved");
    const [seen, again] = await Promise.all(
      [run, replay].map(async (file) => new CaptureFile(await readFile(file)).pairsOf(90)),
    );
    assert.equal(seen.count, explain.active_pairs + explain.pairs_apart);
    const counts = Object.fromEntries(keys.map((key) => [key, 0]));
    for (const outcome of seen.outcome) ++counts[keys[outcome - 1]];
    assert.deepEqual(counts, explain.pairs);
    assert.ok(counts.unserved > 0 && counts.found_apart > 0);
    assert.deepEqual(again.outcome, seen.outcome);
    assert.deepEqual(again.turn, seen.turn);
    assert.ok(again.seen.some((band) => band > 0), "a replay finds what a viewer sees of each pair again");
    for (let i = 0; i < seen.count; ++i) assert.notEqual(whyText(seen, i, "perceptual"), "");
  }),
);

test("pairs say why they were left: by rank among those that waited, and beside the last one served", () => {
  const pairs = { count: 7, outcome: [10, 10, 10, 5, 4, 10, 9], turn: [40, 52, 44, 60, 52, 0, 30] };
  const why = (i, policy = "perceptual") => whyText(pairs, i, policy);
  assert.equal(why(0), "the budget was used up before its turn (after 2 of 3 that waited, its score 0.13 of the lowest that was served)");
  assert.equal(why(1), "the budget was used up before its turn (first of 3 that waited)");
  assert.equal(why(0, "fifo"), "the budget was used up before its turn (after 2 of 3 that waited)");
  assert.equal(why(3), "its last level");
  assert.equal(why(4), "refinement ended there");
  assert.equal(why(5), "the budget was used up before it was ranked");
  assert.match(why(6), /below the threshold/);
  assert.equal(whyText({ outcome: [0], turn: [0] }, 0), "", "a capture of an earlier version does not tell");
  assert.equal(whyText({ outcome: [99], turn: [0] }, 0), "", "nor does a number of a later one");
});

test("pairs of earlier versions, which do not say why, are read", () => {
  const frame = (columns) => {
    const bytes = [41, 0, 0, 0, 0, 0, 0, 0, 1, 2, 2, ...columns]; // one pair, of rows 1 and 2
    return [bytes.length, 0, 0, 0, ...bytes];
  };
  const chunk = Uint8Array.from([2, 0, 0, 0, ...frame([18, 1, 3, 90, 80]), ...frame([18, 1, 3, 90, 80, 10, 200])]);
  const [before, now] = pairFramesOf(chunk).map(({ at }) => readPairs(chunk, at));
  assert.deepEqual([before.a[0], before.b[0], before.error[0], before.outcome[0], before.turn[0]], [1, 2, 80, 0, 0]);
  assert.deepEqual([now.a[0], now.b[0], now.error[0], now.outcome[0], now.turn[0]], [1, 2, 80, 10, 200]);
});

test("what remains to be seen of a pair is what is seen of its expected error", () => {
  const pairs = { count: 3, a: [0, 0, 2], b: [1, 2, 3], state: [2, 5, 0], seen: [128, 140, 0], error: [120, 120, 120] };
  const worst = new Float32Array(4);
  findSeenErrors(pairs, worst);
  assert.deepEqual([...worst], [0.25, 0.25, 0, NaN], "2^0 rad/m times 2^-2 m; none of a pair that is apart");
});

test("the contact state of a body is the coarsest that one of its pairs has", () => {
  // Reused; refined; left at level 0 of 2; apart. Bit 4 of the state says that levels are left.
  const pairs = {
    count: 4,
    a: [0, 1, 3, 5],
    b: [1, 2, 4, 6],
    state: [1, 2, 16, 5],
    level: [1, 2, 0, 0],
    deepest: [2, 2, 2, 2],
  };
  const states = new Uint8Array(7);
  findContactStates(pairs, states);
  assert.deepEqual([...states], [1, 2, 2, 3, 3, 0, 0]);
});

test("frames in which a clock stands still are counted however one comes to a frame", { skip: noCommand }, () =>
  withFolder(async (folder) => {
    const words = ["run", "pile", "--bodies", "400", "--frames", "130", "--deadline", "0.3", "--quiet"];
    await poise(...words, "--capture", join(folder, "late.capture"));
    const file = new CaptureFile(await readFile(join(folder, "late.capture")));
    const [straight, jumping] = [new FrameCursor(file), new FrameCursor(file)];
    straight.countStill(true);
    jumping.countStill(true);
    for (let index = 0; index <= 130; ++index) {
      straight.seek(index);
      if (![35, 36, 61, 62, 95, 120, 130].includes(index)) continue;
      jumping.seek(index === 95 ? 3 : index);
      jumping.seek(index);
      for (const row of straight.rows) assert.equal(jumping.still[row], straight.still[row], `body ${row} of ${index}`);
    }
  }),
);

test("of a capture that is cut or damaged the whole frames are read", { skip: noCommand }, () =>
  withFolder(async (folder) => {
    const {
      captures: [bytes],
    } = await smallRun(folder);
    const cut = new CaptureFile(bytes.subarray(0, Math.floor(0.9 * bytes.length)));
    assert.equal(cut.warning, "the file ends early");
    assert.ok(cut.frames.length > 0 && cut.frames.length < 91);
    const at = new CaptureFile(bytes).blocks[1].chunk.at;
    const damaged = Buffer.from(bytes);
    damaged[at + 20] ^= 1;
    const read = new CaptureFile(damaged);
    assert.match(read.warning, new RegExp(`the chunk at byte ${at} is damaged`));
    assert.equal(read.frames.length, read.blocks[0].count);
    assert.throws(() => new CaptureFile(Buffer.from("poise.record/6\n and more")), /no capture of this version/);
    assert.throws(() => new CaptureFile(bytes.subarray(0, 40)), /ends early/);
  }),
);
