// SPDX-License-Identifier: MIT

/** Columns of words; every other column holds numbers. */
const kWords = new Set(["status", "cause"]);

/**
 * The rows of `--frames-csv` as columns. An empty cell is NaN.
 * @param {string} text
 * @returns {{length: number, has: (name: string) => boolean, column: (name: string) => any}}
 */
export function parseFrames(text) {
  const lines = text.trim().split("\n");
  const names = lines[0] === "" ? [] : lines[0].split(",");
  const length = Math.max(0, lines.length - 1);
  const columns = new Map(names.map((name) => [name, kWords.has(name) ? new Array(length) : new Float64Array(length)]));
  const inOrder = [...columns.values()];
  for (let row = 0; row < length; ++row) {
    const cells = lines[row + 1].split(",");
    for (let k = 0; k < inOrder.length; ++k) {
      const cell = cells[k] ?? "";
      inOrder[k][row] = Array.isArray(inOrder[k]) ? cell : cell === "" ? NaN : Number(cell);
    }
  }
  const missing = new Float64Array(length).fill(NaN);
  return { length, has: (name) => columns.has(name), column: (name) => columns.get(name) ?? missing };
}

export const kStages = ["predict", "broad_phase", "coarse", "refine", "manifolds", "solve", "integrate", "publish"];

/** In the order of docs/run-report.md. */
export const kCauses = ["infeasible", "machine", "overrun", "forecast", "release"];

/** What each cause means, for people. */
export const kCauseText = {
  infeasible: "what every frame must do took longer than the deadline",
  machine: "the system kept the processor, or woke the run late",
  overrun: "one piece of refinement took longer than a piece may",
  forecast: "the end of the frame took longer than was reserved for it",
  release: "the frame began too late, behind one that was itself in time",
};

/**
 * The late frames: their positions in the table, and why. Those of the warm-up are marked, but no figure counts them.
 * @returns {{index: number, cause: string, late_ms: number, warmUp: boolean}[]}
 */
export function lateFrames(frames) {
  const miss = frames.column("miss");
  const cause = frames.column("cause");
  const late = frames.column("lateness_ms");
  const warmUp = frames.column("warm_up");
  const found = [];
  for (let index = 0; index < frames.length; ++index) {
    if (miss[index] === 1) found.push({ index, cause: cause[index], late_ms: late[index], warmUp: warmUp[index] > 0 });
  }
  return found;
}

/** Names of the columns of contact pairs by level that hold anything, the coarsest first. */
export function levelColumns(frames) {
  const names = [];
  for (let level = 0; frames.has(`level_${level}`); ++level) names.push(`level_${level}`);
  if (frames.has("polygons")) names.push("polygons");
  let last = names.length;
  while (last > 0 && !frames.column(names[last - 1]).some((count) => count > 0)) --last;
  const used = names.slice(0, last);
  return used.filter((name, k) => name !== "polygons" || k === 0 || frames.column(name).some((count) => count > 0));
}

/** Sum of the columns, row by row. */
export function sumOf(frames, names) {
  const sum = new Float64Array(frames.length);
  for (const name of names) frames.column(name).forEach((value, row) => (sum[row] += value));
  return sum;
}
