// SPDX-License-Identifier: MIT
import { kCauses, kStages } from "../data/frames.js";

/** Where counts stand in the facts of a frame. */
export const kCount = {
  bodies: 0,
  candidate_pairs: 1,
  coarse_pairs: 2,
  contact_pairs: 3,
  pairs_left: 4,
  asleep: 7,
  bodies_held: 8,
  bodies_paused: 9,
};

/** Does the step of a frame go on in the next one? Then all its bodies wait, and contacts are those of the step before. */
export const isUnfinished = (bodies, asleep, held) => held > 0 && held + asleep >= bodies;

/**
 * The table of frames that a capture holds, with the columns of `--frames-csv` as far as it knows them. Row k is that of
 * the k-th frame after the start; `frame` counts as in `--frames-csv`.
 */
export function tableOfCapture(file) {
  const later = file.frames.filter((facts) => facts.frame > 0);
  const rows = later.length > 0 ? later : file.frames;
  const columns = new Map();
  const add = (name, read) => columns.set(name, Float64Array.from(rows, read));
  const measured = (read) => (facts) => (facts.measured ? read(facts) : NaN);
  add("frame", (facts) => Math.max(0, facts.frame - 1));
  add("time_s", (facts) => facts.time_s);
  add("warm_up", (facts) => (facts.warm_up ? 1 : 0));
  kStages.forEach((stage, k) =>
    add(
      `${stage}_ms`,
      measured((facts) => facts.times_ms[k]),
    ),
  );
  add(
    "total_ms",
    measured((facts) => facts.times_ms[8]),
  );
  add(
    "budget_ms",
    measured((facts) => facts.budget_ms),
  );
  if (file.head.deadline_ms !== null)
    add(
      "reserve_at_cut_ms",
      measured((facts) => facts.reserve_ms),
    );
  add(
    "lateness_ms",
    measured((facts) => facts.lateness_ms),
  );
  add("miss", (facts) => (facts.cause > 0 ? 1 : 0));
  for (const [name, k] of Object.entries(kCount))
    add(
      name,
      measured((facts) => facts.counts[k]),
    );
  for (let level = 0; level < 7; ++level)
    add(
      `level_${level}`,
      measured((facts) => facts.levels[level]),
    );
  add(
    "polygons",
    measured((facts) => facts.levels[7]),
  );
  add("kinetic_j", (facts) => facts.kinetic_j);
  add("potential_j", (facts) => facts.potential_j);
  // Captures of earlier versions have none.
  ["x", "y", "z"].forEach((axis, k) => add(`momentum_${axis}_kgmps`, (facts) => facts.momentum_kgmps?.[k] ?? NaN));
  columns.set(
    "cause",
    rows.map((facts) => (facts.cause > 0 ? kCauses[facts.cause - 1] : "none")),
  );
  const missing = new Float64Array(rows.length).fill(NaN);
  return { length: rows.length, has: (name) => columns.has(name), column: (name) => columns.get(name) ?? missing };
}

/** The value that at least this share of the sorted ones do not exceed. */
const percentile = (sorted, share) => sorted[Math.max(0, Math.ceil(share * sorted.length) - 1)];

/** A document with the members of `poise.run` that a capture knows. */
export function runOfCapture(file, frames) {
  const { head } = file;
  const total = frames.column("total_ms");
  const measured = [...total.keys()].filter((k) => Number.isFinite(total[k]) && !frames.column("warm_up")[k]);
  const sorted = Float64Array.from(measured, (k) => total[k]).sort();
  const late = measured.filter((k) => frames.column("miss")[k] === 1);
  const [bodies, asleep, held] = ["bodies", "asleep", "bodies_held"].map((name) => frames.column(name));
  const ended = measured.filter((k) => !isUnfinished(bodies[k], asleep[k], held[k]));
  let levelSum = 0;
  let levelCount = 0;
  for (let level = 0; level < 7; ++level) {
    const counts = frames.column(`level_${level}`);
    for (const k of ended) {
      if (!(counts[k] > 0)) continue;
      levelSum += level * counts[k];
      levelCount += counts[k];
    }
  }
  const contacts = ended.map((k) => frames.column("contact_pairs")[k]);
  const misses = {
    count: late.length,
    releases: measured.length,
    rate: late.length / Math.max(1, measured.length),
    longest_run: 0,
  };
  for (const cause of kCauses) misses[cause] = late.filter((k) => frames.column("cause")[k] === cause).length;
  return {
    schema: head.schema,
    scene: head.scene,
    clock: head.deadline_ms === null ? "work" : "wall",
    deadline_ms: head.deadline_ms,
    frames: measured.length,
    threads: head.threads,
    policy: head.policy,
    contact: head.contact,
    dynamic_bodies_max:
      file.frames.reduce((most, facts) => Math.max(most, facts.counts[0]), 0) ||
      file.bodies.motion.filter((motion) => motion === 2).length,
    frame_ms:
      sorted.length > 0
        ? { p50: percentile(sorted, 0.5), p99: percentile(sorted, 0.99), max: sorted[sorted.length - 1] }
        : null,
    misses: head.deadline_ms === null ? { count: null } : misses,
    levels: { mean: levelCount > 0 ? levelSum / levelCount : null },
    contacts_mean: contacts.length > 0 ? contacts.reduce((sum, count) => sum + count, 0) / contacts.length : NaN,
    stopped: file.index?.stopped ?? false,
    settings: { dt_s: head.dt_s, paced: head.paced, gravity_mps2: head.gravity_mps2, frames_asked: head.frames_asked },
    machine: head.machine,
    build: head.build,
  };
}
