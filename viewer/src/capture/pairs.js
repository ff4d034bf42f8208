// SPDX-License-Identifier: MIT
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

/** The pairs of a frame, as columns; `a` and `b` are rows. */
export function readPairs(bytes, at) {
  const reader = new ByteReader(bytes);
  reader.at = at;
  const count = reader.varint();
  const a = new Uint32Array(count),
    b = new Uint32Array(count);
  for (let i = 0, row = 0; i < count; ++i) a[i] = row += reader.zigzag();
  for (let i = 0; i < count; ++i) b[i] = a[i] + reader.zigzag();
  const column = () => reader.skip(count);
  return { count, a, b, state: column(), level: column(), deepest: column(), seen: column(), error: column() };
}

export const kNoPairs = { count: 0, a: [], b: [], state: [], level: [], deepest: [], seen: [], error: [] };

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
