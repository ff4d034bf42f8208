// SPDX-License-Identifier: MIT
import { counted, milliseconds, number, percent, whole } from "./format.js";
import { kCauses } from "./data/frames.js";

/** With how much refinement a run on the work clock went; a capture does not know. */
function workText(run) {
  const budget = run.settings?.budget_work;
  if (budget === undefined) return "The work clock ran.";
  const refinement = budget === null ? "unlimited refinement" : `${whole(budget)} work units a frame`;
  return `The work clock ran, with ${refinement}.`;
}

function causesText(misses) {
  const parts = kCauses.filter((cause) => misses[cause] > 0).map((cause) => `${whole(misses[cause])} ${cause}`);
  return parts.length === 0 ? "" : `Causes: ${parts.join(", ")}.`;
}

/** Late frames, and apart from them the releases of a paced run that passed unused. */
function missedText(misses) {
  const skipped = misses.skipped_releases ?? 0;
  const frames = `${whole(misses.count - skipped)} of ${counted(misses.releases - skipped, "frame")}`;
  return skipped === 0 ? frames : `${frames} and ${counted(skipped, "skipped release")}`;
}

/**
 * Whether frames were on time: a mark (good, bad, none), a headline and a sentence.
 * @param {any} run document `poise.run`
 */
export function onTime(run) {
  const misses = run.misses;
  const p99 = run.frame_ms ? `99\u00a0% of frames took at most ${milliseconds(run.frame_ms.p99)}` : "";
  if (run.clock === "work" || !misses || misses.count === null) {
    return { mark: "none", title: "No deadline", text: p99 === "" ? workText(run) : `${workText(run)} ${p99}.` };
  }
  const limit = `a deadline of ${milliseconds(run.deadline_ms)}`;
  const slow = `${p99}; the slowest ${milliseconds(run.frame_ms?.max)}.`;
  if (misses.count === 0) {
    return {
      mark: "good",
      title: "On time",
      text: `All ${counted(misses.releases, "frame")} met ${limit}. ${slow}`,
    };
  }
  return {
    mark: "bad",
    title: `${percent(misses.rate)} late`,
    text: `${missedText(misses)} missed ${limit}. ` + `${causesText(misses)} ${slow}`,
  };
}

/** How true the run was, if a reference ran; else how deep contacts were refined. */
export function howTrue(run) {
  const levels = run.levels;
  const depth =
    typeof levels?.mean === "number"
      ? `Contacts were refined to level ${number(levels.mean)} on average.`
      : "No contacts at levels of a tree.";
  const reference = run.reference;
  if (!reference?.frames) {
    const how = "To compare frames with full refinement: --reference every=20.";
    return { mark: "none", title: "Error not measured", text: `${depth} ${how}` };
  }
  if (typeof reference.e_rel_p50 !== "number") {
    const why =
      reference.not_converged > 0 ? `${whole(reference.not_converged)} references did not converge` : "no contact";
    return {
      mark: "none",
      title: "Error not known",
      text: `${counted(reference.frames, "compared frame")}: ${why}. ${depth}`,
    };
  }
  const gap =
    typeof reference.gap_max_px_p50 === "number"
      ? ` Gaps at contacts reach ${number(reference.gap_max_px_p50, 2)} px.`
      : "";
  return {
    mark: "none",
    title: `Error ${percent(reference.e_rel_p50)}`,
    text:
      `Half of ${counted(reference.frames, "compared frame")} differ less than this from full refinement ` +
      `(${number(reference.e_mps_p50, 2)} m/s). ${percent(reference.missed_rate)} of contacts missed, ` +
      `${percent(reference.false_rate)} false.${gap} ${depth}`,
  };
}

/** The figures beside the headline: a label, a value, and what it means. */
export function tiles(run) {
  const list = [];
  const add = (label, value, title) => list.push({ label, value, title });
  if (run.frame_ms) {
    add("median", milliseconds(run.frame_ms.p50), "Half of the frames took at most this");
    add("99 %", milliseconds(run.frame_ms.p99), "99 % of the frames took at most this");
    add("slowest", milliseconds(run.frame_ms.max), "The slowest frame");
  }
  if (run.misses && run.misses.count !== null) {
    add("late", whole(run.misses.count), "Frames that ended after their deadline, and skipped releases");
    if (run.misses.longest_run > 1) add("in a row", whole(run.misses.longest_run), "Most late frames in a row");
  }
  if (typeof run.levels?.mean === "number")
    add("level", number(run.levels.mean), "Mean completed level of the contacts");
  if (run.clock !== "work" && run.tail?.frames > 0)
    add("reserve held", percent(run.tail.coverage, 3), "Frames whose end took no longer than was reserved for it");
  add("contacts", number(run.contacts_mean, 3), "Contact pairs a frame, on average");
  return list;
}

/** The line under the name of the scene. */
export function subtitle(run) {
  const dt = run.settings?.dt_s;
  return [
    `${whole(run.dynamic_bodies_max ?? run.dynamic_bodies)} moving bodies`,
    `${counted(run.frames, "frame")}${dt ? ` of ${milliseconds(1000 * dt)}` : ""}`,
    `${counted(run.threads, "thread")}`,
    `policy ${run.policy}`,
    run.stopped ? "stopped by Ctrl-C" : "",
  ]
    .filter((part) => part !== "")
    .join(" · ");
}
