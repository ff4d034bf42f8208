// SPDX-License-Identifier: MIT
import { decompress } from "fzstd";

import { ByteReader } from "./byte_reader.js";
import { kNoPairs, pairFramesOf, readPairs } from "./pairs.js";
import { xxh32 } from "./xxh32.js";

const kMagic = "poise.capture/1\n";
const kTrailerBytes = 16;
const kMostRaw = 2 ** 30;
// Of blocks that stay unpacked, so that a frame is not unpacked again each time that it is shown. Chosen.
const kKeptBytes = 2 ** 26;

const latin = (bytes) => String.fromCharCode(...bytes);
const json = (bytes) => JSON.parse(new TextDecoder().decode(bytes));

/** The chunk at `at`, or why there is none. */
function chunkAt(bytes, at) {
  if (at + 12 > bytes.length) return { error: "the file ends early" };
  const reader = new ByteReader(bytes);
  reader.at = at;
  const type = latin(reader.skip(4));
  const raw = reader.u32();
  const stored = reader.u32();
  if (reader.at + stored + 4 > bytes.length) return { error: "the file ends early" };
  if (raw > kMostRaw || raw > 2 ** 20 + 16 * stored) return { error: `the chunk at byte ${at} is too large` };
  const payload = reader.skip(stored);
  if (reader.u32() !== xxh32(bytes, at, 12 + stored)) return { error: `the chunk at byte ${at} is damaged` };
  return { type, raw, payload, at, next: reader.at };
}

function unpacked(chunk) {
  if (chunk.payload.length === chunk.raw) return chunk.payload;
  const bytes = decompress(chunk.payload, new Uint8Array(chunk.raw));
  if (bytes.length !== chunk.raw) throw new RangeError(`the chunk at byte ${chunk.at} has another size than it says`);
  return bytes;
}

export function readShape(bytes, head) {
  const reader = new ByteReader(bytes);
  const index = reader.u32();
  const vertices = reader.u32();
  const triangles = reader.u32();
  const positions = reader.floats(3 * vertices);
  const corners = Uint32Array.from({ length: 3 * triangles }, () => reader.u32());
  const levels = Array.from({ length: reader.u32() }, () => reader.floats(4 * reader.u32()));
  return { ...head.shapes[index], index, positions, corners, levels };
}

/** The fixed part of a frame: who looks from where, times, counts and energies. */
export function readFacts(reader) {
  const frame = reader.u64();
  const time_s = reader.f64();
  const left_out = reader.u32();
  const flags = reader.u8();
  const cause = reader.u8();
  reader.u16();
  const vector = (read) => [read(), read(), read()];
  const f32 = () => reader.f32();
  const camera = {
    position_m: vector(() => reader.f64()),
    forward: vector(f32),
    up: vector(f32),
    gaze: vector(f32),
    vertical_fov_rad: f32(),
    aspect: f32(),
    gaze_px: [f32(), f32()],
  };
  const ms = () => reader.u32() / 1e4;
  const times_ms = Array.from({ length: 10 }, ms);
  const facts = { budget_ms: ms(), reserve_ms: ms(), lateness_ms: ms() };
  const counts = Array.from({ length: 10 }, () => reader.u32());
  const levels = Array.from({ length: 8 }, () => reader.u32());
  const work = reader.u64();
  return {
    frame,
    time_s,
    left_out,
    cause,
    camera: flags & 4 ? camera : null,
    measured: (flags & 1) !== 0,
    warm_up: (flags & 2) !== 0,
    times_ms,
    ...facts,
    counts,
    levels,
    work,
    kinetic_j: reader.f64(),
    potential_j: reader.f64(),
  };
}

/** A capture (docs/capture.md): its head, shapes and table of bodies, and where each frame begins. */
export class CaptureFile {
  /** Throws where the bytes are no capture. What a damaged or cut file still holds is read; `warning` says so. */
  constructor(bytes) {
    if (latin(bytes.subarray(0, 16)) !== kMagic)
      throw new Error("this is no capture of this version (poise.capture/1)");
    this.warning = "";
    this.shapes = [];
    this.bodies = { number: [], shape: [], material: [], motion: [], mass_kg: [], name: [] };
    this.blocks = [];
    this.frames = [];
    this.unpackedBlocks = new Map(); // the oldest first
    this.keptBytes = 0;
    this.index = null;
    this.pairFrames = new Map(); // number of a frame -> its chunk and place in it
    this.unpackedPairs = null;
    const end = latin(bytes.subarray(-8)) === "capindex" ? bytes.length - kTrailerBytes : bytes.length;
    for (let at = kMagic.length; at < end;) {
      const chunk = chunkAt(bytes, at);
      if (chunk.error) {
        this.warning = chunk.error;
        break;
      }
      this.take(chunk);
      at = chunk.next;
    }
    if (!this.head) throw new Error(this.warning || "the capture has no head");
    if (!this.index && this.warning === "") this.warning = "the file ends early";
  }

  take(chunk) {
    if (chunk.type === "HEAD") this.head = json(unpacked(chunk));
    if (chunk.type === "SHAP") this.shapes.push(readShape(unpacked(chunk), this.head));
    if (chunk.type === "INDX") this.index = json(unpacked(chunk));
    if (chunk.type === "BODY") {
      const rows = json(unpacked(chunk));
      const names = rows.name ?? rows.number.map(() => "");
      for (const key of Object.keys(this.bodies)) this.bodies[key].push(...(key === "name" ? names : rows[key]));
    }
    if (chunk.type === "FRAM") this.takeBlock(chunk);
    if (chunk.type === "SUMS") this.takeSums(chunk);
    if (chunk.type === "PAIR") {
      for (const { frame, at } of pairFramesOf(unpacked(chunk))) this.pairFrames.set(frame, { chunk, at });
    }
  }

  takeBlock(chunk) {
    const bytes = unpacked(chunk);
    const reader = new ByteReader(bytes);
    const first = this.frames.length;
    const count = reader.u32();
    for (let k = 0; k < count; ++k) {
      const bytes = reader.u32();
      const next = reader.at + bytes;
      const facts = readFacts(reader);
      this.frames.push({ ...facts, block: this.blocks.length, at: reader.at });
      reader.at = next;
    }
    if (this.keptBytes + bytes.length <= kKeptBytes) this.keep(this.blocks.length, bytes);
    this.blocks.push({ chunk, first, count });
  }

  /** Momentum of the frames of the block before it. */
  takeSums(chunk) {
    const { first, count } = this.blocks[this.blocks.length - 1] ?? { count: 0 };
    const reader = new ByteReader(unpacked(chunk));
    if (reader.u32() !== count) throw new RangeError(`the chunk at byte ${chunk.at} is not that of its block`);
    const columns = [0, 1, 2].map(() => reader.floats(count));
    for (let k = 0; k < count; ++k) this.frames[first + k].momentum_kgmps = columns.map((column) => column[k]);
  }

  keep(number, bytes) {
    this.unpackedBlocks.set(number, bytes);
    this.keptBytes += bytes.length;
  }
  /** The bytes of a block; as many as have room are kept unpacked. */
  block(number) {
    let bytes = this.unpackedBlocks.get(number);
    if (bytes === undefined) {
      bytes = unpacked(this.blocks[number].chunk);
      this.keep(number, bytes);
      for (const [oldest, { length }] of this.unpackedBlocks) {
        if (this.keptBytes <= kKeptBytes || oldest === number) break;
        this.unpackedBlocks.delete(oldest);
        this.keptBytes -= length;
      }
    }
    return bytes;
  }

  /** Whether frames list their pairs (--capture-pairs). */
  get hasPairs() {
    return this.pairFrames.size > 0;
  }
  /** The pairs of a frame by its number; none where the file lists none. */
  pairsOf(frame) {
    const place = this.pairFrames.get(frame);
    if (!place) return kNoPairs;
    if (this.unpackedPairs?.chunk !== place.chunk)
      this.unpackedPairs = { chunk: place.chunk, bytes: unpacked(place.chunk) };
    if (this.unpackedPairs.at !== place.at)
      Object.assign(this.unpackedPairs, { at: place.at, pairs: readPairs(this.unpackedPairs.bytes, place.at) });
    return this.unpackedPairs.pairs;
  }

  /** The last frame in the file at or before this number of frames; 0 if all are later. */
  indexAt(steps) {
    let low = 0;
    let high = this.frames.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.frames[middle].frame <= steps) low = middle + 1;
      else high = middle;
    }
    return Math.max(0, low - 1);
  }
}
