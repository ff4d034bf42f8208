// SPDX-License-Identifier: MIT
import assert from "node:assert/strict";
import { test } from "node:test";

import { ByteReader } from "../src/capture/byte_reader.js";
import { priorityOfBand } from "../src/capture/frame_cursor.js";
import { xxh32 } from "../src/capture/xxh32.js";
import { lateFrames, levelColumns, parseFrames } from "../src/data/frames.js";
import { number, percent } from "../src/format.js";
import { howTrue, onTime, tiles } from "../src/headline.js";
import { kCauseMark, levelColor, viridis } from "../src/palette.js";
import { createStore } from "../src/store.js";
import { inventedFrames, inventedRun } from "./sample.mjs";

const hashOf = (text) => xxh32(new TextEncoder().encode(text), 0, text.length).toString(16);

test("xxh32 has the values of its specification", () => {
  assert.equal(hashOf(""), "2cc5d05");
  assert.equal(hashOf("a"), "550d7456");
  assert.equal(hashOf("Nobody inspects the spammish repetition"), "e2293b2f");
});

test("numbers of a capture are read to their last bit", () => {
  const reader = new ByteReader(
    Uint8Array.of(0x80, 0x01, 0x03, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0x0f, 0x04, 0x81, 0x02),
  );
  assert.equal(reader.varint(), 128);
  assert.equal(reader.zigzag(), -2);
  assert.equal(reader.varint(), 2 ** 53 - 1);
  assert.equal(reader.zigzag(), 2);
  assert.equal(reader.zigzag(), -129);
  assert.throws(() => reader.varint(), /cut short/);
  assert.throws(() => new ByteReader(new Uint8Array(11).fill(0x80)).varint(), /more than 10 bytes/);
  assert.throws(() => reader.skip(1), /cut short/);
});

test("an empty cell of the table is no number, and no column is missing", () => {
  const frames = parseFrames("frame,cause,reference_e_rel\n0,none,\n1,machine,0.5\n");
  assert.equal(frames.length, 2);
  assert.ok(Number.isNaN(frames.column("reference_e_rel")[0]));
  assert.equal(frames.column("reference_e_rel")[1], 0.5);
  assert.deepEqual(frames.column("cause"), ["none", "machine"]);
  assert.ok(frames.column("unknown").every(Number.isNaN));
  assert.equal(parseFrames("").length, 0);
});

test("late frames are those that the table says, with their causes", () => {
  const late = lateFrames(
    parseFrames(
      inventedFrames(
        60,
        [
          [7, "machine"],
          [41, "overrun"],
        ],
        8,
      ),
    ),
  );
  assert.deepEqual(late, [
    { index: 7, cause: "machine", late_ms: 4, warmUp: true },
    { index: 41, cause: "overrun", late_ms: 4, warmUp: false },
  ]);
});

test("levels that no pair reached have no column", () => {
  assert.deepEqual(levelColumns(parseFrames("level_0,level_1,level_2,polygons\n5,0,0,0\n3,2,0,0\n")), [
    "level_0",
    "level_1",
  ]);
  assert.deepEqual(levelColumns(parseFrames("level_0,level_1,polygons\n5,0,4\n")), ["level_0", "level_1", "polygons"]);
});

test("the headline says whether frames were on time, and why not", () => {
  const good = onTime(inventedRun(60, []));
  assert.equal(good.mark, "good");
  assert.match(good.text, /All 60 frames met a deadline of 16 ms/);
  const bad = onTime(
    inventedRun(60, [
      [7, "machine"],
      [8, "machine"],
      [41, "overrun"],
    ]),
  );
  assert.equal(bad.mark, "bad");
  assert.equal(bad.title, "5 % late");
  assert.match(bad.text, /3 of 60 frames missed a deadline of 16 ms. Causes: 2 machine, 1 overrun./);
  const paced = inventedRun(60, [[7, "machine"]]);
  Object.assign(paced.misses, { count: 4, releases: 63, skipped_releases: 3, machine: 4 });
  assert.match(
    onTime(paced).text,
    /1 of 60 frames and 3 skipped releases missed a deadline of 16 ms. Causes: 4 machine./,
  );
  const work = onTime({
    ...inventedRun(60, []),
    clock: "work",
    misses: { count: null },
    settings: { budget_work: 300 },
  });
  assert.equal(work.title, "No deadline");
  assert.match(work.text, /300 work units a frame/);
});

test("the headline says how true the run was where that was measured, and else how to measure it", () => {
  const run = inventedRun(60, []);
  assert.equal(howTrue(run).title, "Error 10 %");
  assert.match(howTrue(run).text, /2 % of contacts missed, 1 % false/);
  assert.match(howTrue({ ...run, reference: { frames: 0 } }).text, /--reference every=20/);
  const unknown = howTrue({ ...run, reference: { frames: 6, e_rel_p50: null, not_converged: 6 } });
  assert.match(unknown.text, /6 compared frames: 6 references did not converge/);
  assert.deepEqual(
    tiles(run).map(({ label }) => label),
    ["median", "99 %", "slowest", "late", "level", "reserve held", "contacts"],
  );
});

test("numbers are short", () => {
  assert.equal(number(0.123456), "0.123");
  assert.equal(number(123456), "123,456");
  assert.equal(number(1e-7), "1.00e-7");
  assert.equal(number(null), "–");
  assert.equal(number(NaN), "–");
  assert.equal(percent(0.5), "50 %");
});

test("a deeper level is brighter, and every cause has a shape of its own", () => {
  const light = (rgb) => 0.21 * rgb[0] + 0.72 * rgb[1] + 0.07 * rgb[2];
  for (let levels = 2; levels <= 8; ++levels) {
    for (let level = 1; level < levels; ++level)
      assert.ok(light(levelColor(level, levels)) > light(levelColor(level - 1, levels)));
  }
  assert.deepEqual(viridis(-1), viridis(0));
  assert.equal(new Set(Object.values(kCauseMark).map(({ shape }) => shape)).size, 5);
});

test("bands of priority begin where the format says", () => {
  assert.equal(priorityOfBand(0), 0);
  assert.equal(priorityOfBand(128), 1);
  assert.equal(priorityOfBand(4), 2 ** -31);
});

test("a store tells of changes alone", () => {
  const store = createStore({ row: 0 });
  const seen = [];
  store.on("row", (row) => seen.push(row));
  store.set("row", 0);
  store.set("row", 3);
  store.set("row", 3);
  assert.deepEqual(seen, [3]);
});
