// SPDX-License-Identifier: MIT
import { ByteReader } from "../capture/byte_reader.js";
import { readFacts, readShape } from "../capture/capture_file.js";
import { FrameCursor } from "../capture/frame_cursor.js";

const emptyTable = () => ({ number: [], shape: [], material: [], motion: [], mass_kg: [], name: [] });

/**
 * What a live run has told of itself (docs/live.md): the head, shapes and table of bodies of a capture, and one frame,
 * the last. Has the members of CaptureFile that the replay uses.
 */
export class LiveCapture {
  constructor() {
    this.head = null;
    this.shapes = [];
    this.bodies = emptyTable();
    this.frames = [];
    this.blocks = [{ first: 0 }];
    this.bytes = null;
    this.number = 0; // of the frame, in the order of sending
    this.isRenumbered = true;
  }
  block() {
    return this.bytes;
  }

  /** Takes a message; true if it was a frame. */
  take(bytes) {
    const type = String.fromCharCode(...bytes.subarray(0, 4));
    const payload = bytes.subarray(4);
    const json = () => JSON.parse(new TextDecoder().decode(payload));
    if (type === "HEAD") {
      this.head = json();
      this.shapes = [];
    }
    if (type === "SHAP") this.shapes.push(readShape(payload, this.head));
    if (type === "BODY") this.takeRows(json());
    if (type !== "FRAM") return false;
    const reader = new ByteReader(bytes);
    reader.at = 4;
    const isKey = reader.u32() === 1;
    this.number = reader.u32();
    reader.u32(); // size
    this.frames = [{ ...readFacts(reader), block: 0, at: reader.at }];
    // A frame that needs those before it is not the first of its block.
    this.blocks[0].first = isKey ? 0 : -1;
    this.bytes = bytes;
    return true;
  }
  takeRows(rows) {
    if (rows.first === 0) {
      this.bodies = emptyTable();
      this.isRenumbered = true;
    }
    const names = rows.name ?? rows.number.map(() => "");
    for (const key of Object.keys(this.bodies)) {
      const column = this.bodies[key];
      for (const value of key === "name" ? names : rows[key]) column.push(value);
    }
  }
}

const kColumns = [
  ["q", Float64Array, 3],
  ["qStep", Float64Array, 3],
  ["k", Int32Array, 3],
  ["kStep", Int32Array, 3],
  ["largest", Uint8Array, 1],
  ["position", Float32Array, 3],
  ["orientation", Float32Array, 4],
  ["speed", Float32Array, 1],
  ["state", Uint8Array, 1],
  ["level", Uint8Array, 1],
  ["priority", Uint8Array, 1],
  ["still", Uint8Array, 1],
  ["isNew", Uint8Array, 1],
  ["marked", Uint32Array, 1],
  ["before", Float64Array, 3],
  ["wasThere", Uint8Array, 1],
];

/** The bodies of the last frame of a live run. */
export class LiveCursor extends FrameCursor {
  /** There is one frame only. */
  seek() {}

  reserve(rows) {
    if (rows <= this.state.length) return;
    for (const [name, Kind, size] of kColumns) {
      const grown = new Kind(size * 2 * rows);
      grown.set(this[name]);
      this[name] = grown;
    }
  }

  /** Decodes the frame that the capture has just taken. */
  advance() {
    const before_s = this.time_s ?? NaN;
    this.reserve(this.file.bodies.number.length);
    this.before.set(this.q);
    this.wasThere.fill(0);
    // After a renumbering the rows are those of other bodies.
    if (this.file.isRenumbered) this.still.fill(0);
    else for (const row of this.rows) this.wasThere[row] = 1;
    this.decode(0);
    const { time_s } = this.facts;
    if (time_s !== before_s) this.findSpeeds(time_s - before_s);
    this.time_s = time_s;
    this.file.isRenumbered = false;
    this.findPoses();
  }
}
