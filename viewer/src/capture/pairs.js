// SPDX-License-Identifier: MIT
import { number } from "../format.js";
import { ByteReader } from "./byte_reader.js";
import { priorityOfBand } from "./frame_cursor.js";

const kSource = 7,
  kWaits = 8,
  kLeft = 16,
  kPolygons = 7;
// As docs/capture.md numbers them.
const kCoarsest = 0,
  kCached = 1,
  kRefined = 2,
  kExact = 3;

/** Where each frame of a PAIR chunk begins: its number, and its place in the bytes. */
export function pairFramesOf(bytes) {
  const reader = new ByteReader(bytes);
  const frames = [];
  for (let left = reader.u32(); left > 0; --left) {
    const size = reader.u32();
    const next = reader.at + size;
    frames.push({ frame: reader.u64(), at: reader.at });
    reader.at = next;
  }
  return frames;
}

/** The pairs of a frame, as columns; `a` and `b` are rows. Captures of earlier versions do not say why: 0 everywhere. */
export function readPairs(bytes, at) {
  const reader = new ByteReader(bytes);
  reader.at = at - 12; // of the size, before the number of the frame
  const end = reader.u32() + at - 8;
  reader.at = at;
  const count = reader.varint();
  const a = new Uint32Array(count),
    b = new Uint32Array(count);
  for (let i = 0, row = 0; i < count; ++i) a[i] = row += reader.zigzag();
  for (let i = 0; i < count; ++i) b[i] = a[i] + reader.zigzag();
  const column = () => reader.skip(count);
  const pairs = { count, a, b, state: column(), level: column(), deepest: column(), seen: column(), error: column() };
  const later = () => (reader.at + count <= end ? column() : new Uint8Array(count));
  return Object.assign(pairs, { outcome: later(), turn: later() });
}

const kNames = ["a", "b", "state", "level", "deepest", "seen", "error", "outcome", "turn"];
export const kNoPairs = { count: 0, ...Object.fromEntries(kNames.map((name) => [name, []])) };

/** Whether refinement could have gone on. */
export const isLeft = (pairs, i) => (pairs.state[i] & kLeft) !== 0;

/** Whether it was left before its last level, and counts as near: what a frame without a deadline would have done better. */
export const isCoarse = (pairs, i) =>
  isLeft(pairs, i) && pairs.level[i] < pairs.deepest[i] && (pairs.state[i] & kSource) <= kExact;

/** What is estimated to remain to be seen of a pair, as an angle in rad weighted by how well it is seen; NaN: not ranked. */
export function seenError_rad(pairs, i) {
  if (pairs.seen[i] === 0) return NaN;
  if ((pairs.state[i] & kSource) > kExact) return 0; // it is separated
  return priorityOfBand(pairs.seen[i]) * priorityOfBand(pairs.error[i]); // bands of both begin alike
}

/** The largest of each body, into `worst` by row: NaN where no pair was ranked. */
export function findSeenErrors(pairs, worst) {
  worst.fill(NaN);
  for (let i = 0; i < pairs.count; ++i) {
    const error = seenError_rad(pairs, i);
    if (Number.isNaN(error)) continue;
    for (const row of [pairs.a[i], pairs.b[i]]) if (!(worst[row] >= error)) worst[row] = error;
  }
}

/** What the contacts of a body come from, by what findContactStates says. */
export const kContactStates = ["no pair near", "points of an earlier frame", "refined in this frame", "left coarse"];

/** Of each body's pairs that are not apart the largest of these, into `states` by row. */
export function findContactStates(pairs, states) {
  states.fill(0);
  for (let i = 0; i < pairs.count; ++i) {
    const source = pairs.state[i] & kSource;
    if (source > kExact) continue;
    const state = isCoarse(pairs, i) ? 3 : source === kCached ? 1 : 2;
    for (const row of [pairs.a[i], pairs.b[i]]) states[row] = Math.max(states[row], state);
  }
}

const levelName = (level) => (level === kPolygons ? "polygons" : `level ${level}`);

/** What became of a pair in this frame, in words. */
export function pairText(pairs, i) {
  const level = levelName(pairs.level[i]);
  const deepest = levelName(pairs.deepest[i]);
  const rest = pairs.level[i] < pairs.deepest[i] ? `, of ${deepest}` : isLeft(pairs, i) ? ", too old to be sure" : "";
  const source = pairs.state[i] & kSource;
  const texts = {
    [kCoarsest]: isLeft(pairs, i) ? `left out: root spheres${rest}` : "root spheres, which are all",
    [kCached]: `reused at ${level}${rest}`,
    [kRefined]: `refined to ${level}${rest}`,
    [kExact]: "exact, by backtracking",
  };
  const apart = source === kExact + 1 ? "apart, as found before" : `apart, found at ${level}`;
  return (texts[source] ?? apart) + (pairs.state[i] & kWaits ? "; waits" : "");
}

/** The pairs of a body, those that were left coarse first, then the best seen. */
export function pairsOfBody(pairs, row) {
  const found = [];
  for (let i = 0; i < pairs.count; ++i) if (pairs.a[i] === row || pairs.b[i] === row) found.push(i);
  return found.sort((i, j) => isCoarse(pairs, j) - isCoarse(pairs, i) || pairs.seen[j] - pairs.seen[i]);
}

// What became of a pair, as docs/capture.md numbers it.
const kFoundApart = 4,
  kDeepest = 5,
  kUnserved = 10;
const kWhy = [
  "", // not told
  "sure for this frame",
  "its contact points of an earlier frame still hold",
  "of a fast body: refined whole, whatever the budget",
  "refinement ended there",
  "its last level",
  "the frame had no time to look at it again",
  "its next level was begun, and cut off when the time was over",
  "there was no memory for its next level",
  "what remains of its error is below the threshold of what is seen",
];

// The turns of the pairs that waited in vain, ascending, and the lowest turn of those that came to their end.
function queueOf(pairs) {
  if (!pairs.queue) {
    const waiting = [];
    let served = Infinity;
    for (let i = 0; i < pairs.count; ++i) {
      const turn = pairs.turn[i];
      if (turn === 0) continue;
      if (pairs.outcome[i] === kUnserved) waiting.push(turn);
      const ended = pairs.outcome[i] === kFoundApart || pairs.outcome[i] === kDeepest;
      if (ended) served = Math.min(served, turn);
    }
    pairs.queue = { waiting: waiting.sort((x, y) => x - y), served };
  }
  return pairs.queue;
}

function unservedText(pairs, i, policy) {
  const turn = pairs.turn[i];
  if (turn === 0) return "the budget was used up before it was ranked";
  const { waiting, served } = queueOf(pairs);
  const before = waiting.filter((other) => other > turn).length;
  const place = before === 0 ? `first of ${waiting.length} that waited` : `after ${before} of ${waiting.length} that waited`;
  // Bands of this policy are quarters of an octave.
  const ratio = 2 ** ((turn - served) / 4);
  const score =
    policy === "perceptual" && ratio < 1 ? `, its score ${number(ratio, 2)} of the lowest that was served` : "";
  return `the budget was used up before its turn (${place}${score})`;
}

/** Why a pair has the level that it has, in words; empty where the capture does not tell. */
export const whyText = (pairs, i, policy) =>
  pairs.outcome[i] === kUnserved ? unservedText(pairs, i, policy) : (kWhy[pairs.outcome[i]] ?? "");
