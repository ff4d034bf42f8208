// SPDX-License-Identifier: MIT
import { kCauses, kCauseText } from "../data/frames.js";
import { byId, element } from "../elements.js";
import { counted, milliseconds, number, percent, whole } from "../format.js";

/** Whether the last frames were on time. */
export function onTime(status) {
  const late = kCauses.reduce((sum, cause) => sum + (status.late[cause] ?? 0), 0);
  const frames = status.recent_frames;
  if (frames === 0)
    return { mark: "none", title: "No frame yet", text: `The deadline is ${milliseconds(status.deadline_ms)}.` };
  if (late === 0)
    return {
      mark: "good",
      title: "✓ On time",
      text: `None of the last ${counted(frames, "frame")} was late: all met their deadline.`,
    };
  const cause = kCauses.reduce((most, name) => ((status.late[name] ?? 0) > (status.late[most] ?? 0) ? name : most));
  return {
    mark: "bad",
    title: `✕ ${percent(late / frames)} late`,
    text: `${whole(late)} of the last ${counted(frames, "frame")} were late, mostly: ${kCauseText[cause]}.`,
  };
}

/** Time and number of the frame that is shown. The run itself may be further. */
export const clockText = (facts) => (facts ? `${facts.time_s.toFixed(2)} s   frame ${facts.frame}` : "");

/** How deep contacts are refined, of `finest` levels beside the root sphere. */
export function levelReached(recent, finest) {
  const { level, count } = recent.contacts();
  if (!Number.isFinite(level)) return { mark: "none", title: "Level –", text: "Nothing touches." };
  return {
    mark: "none",
    title: `Level ${number(level)} of ${finest}`,
    text:
      `on average of ${counted(Math.round(count), "contact")} a frame in the last second. ` +
      "0 is one sphere for a body.",
  };
}

/** How many bodies there are, and how fast they go. */
export function bodiesThere(status) {
  const coming = status.bodies_asked - status.bodies;
  const isSlow = status.speed > 0 && status.speed < 0.97;
  const steps = status.frames_a_step >= 1.05 ? `: a step takes ${number(status.frames_a_step)} frames` : "";
  const running = isSlow ? `Slower than real time, ${percent(status.speed)}${steps}.` : "In real time.";
  const pace = status.paused ? "Paused." : running;
  return {
    mark: "none",
    title: status.bodies === 1 ? "1 body" : `${whole(status.bodies)} bodies`,
    text: (coming > 0 ? `${whole(coming)} more to come. ` : coming < 0 ? `${whole(-coming)} to leave. ` : "") + pace,
  };
}

/** Frames that did not come, in words. */
export function missed(status) {
  const parts = [];
  if (status.dropped > 0) parts.push(`${counted(status.dropped, "frame")} left out here: this page was too slow`);
  if (status.left_out > 0) parts.push(`${counted(status.left_out, "frame")} not sent to any page`);
  if (status.browsers > 1) parts.push(`${whole(status.browsers)} pages show this run`);
  return parts.join(" · ");
}

/** @param {number} finest the deepest level of the trees */
export function showHeadline(status, recent, finest) {
  const cards = [
    ["on-time", onTime(status)],
    ["level", levelReached(recent, finest)],
    ["bodies", bodiesThere(status)],
  ];
  for (const [id, { mark, title, text }] of cards) {
    const card = byId(id);
    card.className = `panel card ${mark}`;
    // What is selected stays selected.
    if (card.textContent !== title + text) card.replaceChildren(element("h2", {}, title), element("p", {}, text));
  }
  byId("missed").textContent = missed(status);
}
