// SPDX-License-Identifier: MIT
import { ByteReader } from "./byte_reader.js";

const kStepOfBand = 4,
  kLowestExponent = -32;

/** The visible angle at which a band of priority begins, in rad/m; 0 for none. */
export const priorityOfBand = (band) => (band === 0 ? 0 : 2 ** (band / kStepOfBand + kLowestExponent));

export const kStates = ["static", "kinematic", "moving", "asleep", "waiting", "paused"];

const kWaiting = 4,
  kPaused = 5;
/** How far frames are counted in which the clock of a body stands still. Chosen: half a second of most scenes. */
export const kMostStill = 30;

function readRows(reader) {
  const count = reader.varint();
  const rows = new Uint32Array(count);
  let row = 0;
  for (let k = 0; k < count; ++k) rows[k] = row += reader.varint();
  return rows;
}

/** The rows of a frame: those before, without `removed`, with `added`. */
function rowsAfter(before, removed, added) {
  if (removed.length === 0 && added.length === 0) return before;
  if (before.length === 0) return added; // the first frame of a block, as often as blocks are short
  const gone = new Set(removed);
  const rows = [...before.filter((row) => !gone.has(row)), ...added];
  return Uint32Array.from(rows).sort();
}

/**
 * Bodies at one frame of a capture. `seek` moves it; going forwards decodes one frame a step. Arrays are indexed by the
 * row of the body; `rows` lists those that are there.
 */
export class FrameCursor {
  constructor(file) {
    const rows = file.bodies.number.length;
    this.file = file;
    this.index = -1;
    this.rows = new Uint32Array(0);
    this.q = new Float64Array(3 * rows);
    this.qStep = new Float64Array(3 * rows);
    this.k = new Int32Array(3 * rows);
    this.kStep = new Int32Array(3 * rows);
    this.largest = new Uint8Array(rows);
    this.position = new Float32Array(3 * rows);
    this.orientation = new Float32Array(4 * rows); // x y z w
    this.speed = new Float32Array(rows); // of the centre of mass since the frame before; NaN where that is not known
    this.state = new Uint8Array(rows);
    this.level = new Uint8Array(rows); // 0: none, else level + 1
    this.priority = new Uint8Array(rows);
    this.contacts = [];
    this.still = new Uint8Array(rows); // frames in a row that its clock has stood still, as far as they are counted
    this.history = 0; // frames that are decoded before one that is jumped to, so that they are counted
    this.isNew = new Uint8Array(rows);
    this.marked = new Uint32Array(rows);
    this.before = new Float64Array(3 * rows);
    this.wasThere = new Uint8Array(rows);
  }

  get facts() {
    return this.file.frames[this.index];
  }

  /** Whether this row is a body of the frame. */
  has(row) {
    let low = 0;
    let high = this.rows.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.rows[middle] < row) low = middle + 1;
      else high = middle;
    }
    return this.rows[low] === row;
  }

  /** Moves to the frame with this index in the file. */
  seek(index) {
    if (index === this.index || this.file.frames.length === 0) return;
    // The frame before is decoded too, for the speeds.
    const before = Math.max(0, index - 1);
    if (this.index !== before) {
      for (let k = this.startFor(before); k <= before; ++k) this.decode(k);
    }
    if (index !== before) {
      this.before.set(this.q);
      this.wasThere.fill(0);
      for (const row of this.rows) this.wasThere[row] = 1;
      const from_s = this.facts.time_s;
      this.decode(index);
      this.findSpeeds(this.facts.time_s - from_s);
    } else {
      this.speed.fill(NaN);
    }
    this.findPoses();
  }

  /** The first frame to decode for one that does not follow. */
  startFor(index) {
    const { blocks, frames } = this.file;
    let { first } = blocks[frames[index].block];
    const goesOn = this.index < index && (this.index >= first || index - this.index <= this.history);
    if (goesOn && this.index >= 0) return this.index + 1;
    while (first > 0 && index - first < this.history) ({ first } = blocks[frames[first - 1].block]);
    this.still.fill(0);
    return first;
  }

  /** Whether `still` counts up to kMostStill frames; else up to those that happened to be decoded. */
  countStill(isCounting) {
    const history = isCounting ? kMostStill : 0;
    if (history === this.history) return;
    this.history = history;
    if (!isCounting) return;
    const { index } = this;
    this.index = -1;
    this.seek(index);
  }

  decode(index) {
    const { block, at } = this.file.frames[index];
    const reader = new ByteReader(this.file.block(block));
    reader.at = at;
    this.index = index;
    const begins = index === this.file.blocks[block].first;
    const removed = readRows(reader);
    const added = readRows(reader);
    this.rows = rowsAfter(begins ? new Uint32Array(0) : this.rows, removed, added);
    if (begins) this.clearAll();
    else for (const row of added) this.clear(row);
    this.readPoses(reader);
    for (const row of added) this.rest(row);
    for (const column of [this.state, this.level, this.priority]) this.readColumn(reader, column);
    for (const row of this.rows) {
      const waits = this.state[row] === kWaiting || this.state[row] === kPaused;
      this.still[row] = waits ? Math.min(this.still[row] + 1, kMostStill) : 0;
    }
    this.contacts = this.file.head.contacts ? this.readContacts(reader) : [];
  }

  clearAll() {
    for (const column of [this.q, this.qStep, this.k, this.kStep]) column.fill(0);
    for (const column of [this.largest, this.state, this.level, this.priority]) column.fill(0);
  }
  clear(row) {
    this.rest(row);
    const at = 3 * row;
    this.q[at] = this.q[at + 1] = this.q[at + 2] = 0;
    this.k[at] = this.k[at + 1] = this.k[at + 2] = 0;
    this.largest[row] = this.state[row] = this.level[row] = this.priority[row] = 0;
  }
  /** Its pose does not change from here on. */
  rest(row) {
    const at = 3 * row;
    this.qStep[at] = this.qStep[at + 1] = this.qStep[at + 2] = 0;
    this.kStep[at] = this.kStep[at + 1] = this.kStep[at + 2] = 0;
  }

  /** The rows whose bit is set. What it returns holds until it is called again. */
  readMask(reader) {
    const mask = reader.skip(Math.ceil(this.rows.length / 8));
    const { rows, marked } = this;
    let count = 0;
    for (let i = 0; i < rows.length; ++i) if ((mask[i >> 3] >> (i & 7)) & 1) marked[count++] = rows[i];
    return marked.subarray(0, count);
  }

  readPoses(reader) {
    const moved = this.readMask(reader);
    const isMoved = this.isNew.fill(0);
    for (const row of moved) isMoved[row] = 1;
    for (const row of this.rows) if (!isMoved[row]) this.rest(row);
    const largest = reader.skip(moved.length); // as a difference to the one before
    for (let axis = 0; axis < 3; ++axis) {
      for (const row of moved) {
        const at = 3 * row + axis;
        this.qStep[at] += reader.zigzag();
        this.q[at] += this.qStep[at];
      }
    }
    for (let i = 0; i < moved.length; ++i) {
      if (largest[i] === 0) continue;
      const row = moved[i];
      for (let at = 3 * row; at < 3 * row + 3; ++at) this.k[at] = this.kStep[at] = 0;
      isMoved[row] = 2; // another largest component: its step is 0 afterwards
      this.largest[row] = (this.largest[row] + largest[i]) % 4;
    }
    for (let axis = 0; axis < 3; ++axis) {
      for (const row of moved) {
        const at = 3 * row + axis;
        const step = this.kStep[at] + reader.zigzag();
        this.k[at] += step;
        this.kStep[at] = isMoved[row] === 2 ? 0 : step;
      }
    }
  }

  readColumn(reader, column) {
    const changed = this.readMask(reader);
    const values = reader.skip(changed.length);
    for (let i = 0; i < changed.length; ++i) column[changed[i]] = values[i];
  }

  readContacts(reader) {
    const step_m = this.file.head.position_step_m;
    return Array.from({ length: reader.varint() }, () => {
      const pair = { a: reader.varint(), b: reader.varint(), level: reader.u8(), points_m: [], normal: [0, 0, 0] };
      const points = reader.u8();
      pair.normal = pair.normal.map(() => reader.i16() / 32767);
      for (let p = 0; p < points; ++p)
        pair.points_m.push([0, 1, 2].map((axis) => step_m * (this.q[3 * pair.a + axis] + reader.zigzag())));
      return pair;
    });
  }

  findSpeeds(dt_s) {
    const scale = this.file.head.position_step_m / dt_s;
    this.speed.fill(NaN);
    for (const row of this.rows) {
      if (!this.wasThere[row]) continue;
      const at = 3 * row;
      const x = this.q[at] - this.before[at];
      const y = this.q[at + 1] - this.before[at + 1];
      const z = this.q[at + 2] - this.before[at + 2];
      this.speed[row] = scale * Math.sqrt(x * x + y * y + z * z);
    }
  }

  findPoses() {
    const step_m = this.file.head.position_step_m;
    const steps = this.file.head.orientation_steps;
    for (const row of this.rows) {
      for (let at = 3 * row; at < 3 * row + 3; ++at) this.position[at] = step_m * this.q[at];
      const a = this.k[3 * row] / steps,
        b = this.k[3 * row + 1] / steps,
        c = this.k[3 * row + 2] / steps;
      const d = Math.sqrt(Math.max(0, 1 - a * a - b * b - c * c));
      const largest = this.largest[row];
      const w = largest === 0 ? d : a;
      const x = largest === 1 ? d : largest === 0 ? a : b;
      const y = largest === 2 ? d : largest < 2 ? b : c;
      const z = largest === 3 ? d : c;
      const scale = 1 / Math.sqrt(w * w + x * x + y * y + z * z);
      const at = 4 * row;
      this.orientation[at] = scale * x;
      this.orientation[at + 1] = scale * y;
      this.orientation[at + 2] = scale * z;
      this.orientation[at + 3] = scale * w;
    }
  }
}
