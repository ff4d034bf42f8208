// SPDX-License-Identifier: MIT
// Figures that tests know: invented ones, and runs of the built command.
import { execFile } from "node:child_process";
import { existsSync } from "node:fs";
import { readFile } from "node:fs/promises";
import { join } from "node:path";
import { promisify } from "node:util";

import { kStages } from "../src/data/frames.js";
import { viewerFolder } from "./page.mjs";

/** The program to test; POISE_COMMAND names another. */
export const command = process.env.POISE_COMMAND ?? join(viewerFolder, "../build/release/src/app/poise");
export const noCommand = existsSync(command) ? false : `the command is not built: ${command}`;

/** Runs it; its output. */
export async function poise(...words) {
  const environment = { ...process.env, POISE_TREE_CACHE: "off", POISE_TIME_PRIORS: "off" };
  return (await promisify(execFile)(command, words, { env: environment, maxBuffer: 2 ** 26 })).stdout;
}

/** A small run on the work clock, which is the same on every machine: its document, its table and its capture. */
export async function smallRun(folder, ...more) {
  const file = (name) => join(folder, name);
  await poise(
    "run",
    "jacks",
    "--bodies",
    "60",
    "--frames",
    "90",
    "--clock",
    "work",
    "--budget-work",
    "300",
    "--quiet",
    "--json",
    file("run.json"),
    "--frames-csv",
    file("frames.csv"),
    "--capture",
    file("run.capture"),
    ...more,
  );
  return {
    run: JSON.parse(await readFile(file("run.json"), "utf8")),
    frames: await readFile(file("frames.csv"), "utf8"),
    captures: [await readFile(file("run.capture"))],
  };
}

/** A run whose budget leaves pairs coarse, as its capture alone, with what became of its pairs. */
export async function coarseRun(folder) {
  const file = join(folder, "coarse.capture");
  const words = ["run", "jacks", "--bodies", "150", "--frames", "120", "--clock", "work", "--budget-work", "100"];
  await poise(...words, "--quiet", "--capture", file, "--capture-pairs");
  return { captures: [await readFile(file)] };
}

/** A table of frames of 10 ms each, but for late ones: pairs of frame and cause, 20 ms each. The first may be warm-up. */
export function inventedFrames(count, late, warmUp = 0) {
  const names = [
    "frame",
    "time_s",
    "warm_up",
    "miss",
    "cause",
    "total_ms",
    ...kStages.map((stage) => `${stage}_ms`),
    "lateness_ms",
    "reserve_at_cut_ms",
    "tail_actual_ms",
    "level_0",
    "level_1",
    "level_2",
    "bodies_held",
    "bodies_paused",
    "asleep",
    "kinetic_j",
    "potential_j",
    "momentum_x_kgmps",
    "momentum_y_kgmps",
    "momentum_z_kgmps",
    "reference_e_rel",
    "reference_missed_contacts",
    "reference_contacts",
  ];
  const causes = new Map(late);
  const rows = Array.from({ length: count }, (_, frame) => {
    const isLate = causes.has(frame);
    const total = isLate ? 20 : 10;
    const compared = frame % 10 === 9;
    return [
      frame,
      (frame + 1) / 60,
      frame < warmUp ? 1 : 0,
      isLate ? 1 : 0,
      causes.get(frame) ?? "none",
      total,
      ...kStages.map(() => total / kStages.length),
      isLate ? 4 : 0,
      3,
      2,
      10,
      20,
      30,
      frame > 50 ? 5 : 0,
      0,
      0,
      100 - frame,
      200,
      10 - frame / 10,
      -2,
      frame / 20,
      compared ? 0.1 : "",
      compared ? 2 : "",
      compared ? 100 : "",
    ];
  });
  return [names, ...rows].map((row) => row.join(",")).join("\n") + "\n";
}

/** The document of a run that fits them. */
export function inventedRun(count, late) {
  const misses = { count: late.length, releases: count, rate: late.length / count, longest_run: 1 };
  for (const cause of ["infeasible", "machine", "overrun", "forecast", "release"])
    misses[cause] = late.filter((miss) => miss[1] === cause).length;
  return {
    schema: "poise.run/2",
    scene: "<b>heap</b>",
    clock: "wall",
    deadline_ms: 16,
    frames: count,
    dynamic_bodies: 60,
    threads: 2,
    policy: "perceptual",
    frame_ms: { p50: 10, p99: 20, max: 20 },
    misses,
    levels: { mean: 1.33 },
    contacts_mean: 60,
    tail: { frames: count, coverage: 0.99 },
    reference: {
      frames: count / 10,
      e_rel_p50: 0.1,
      e_mps_p50: 0.02,
      missed_rate: 0.02,
      false_rate: 0.01,
      gap_max_px_p50: 0.5,
    },
    settings: { dt_s: 1 / 60, paced: false },
    machine: { system: "Linux", processor: "a processor", cores: 2 },
    build: { version: "0.1.0" },
    warnings: [],
  };
}
