// SPDX-License-Identifier: MIT

/** Reads little-endian numbers one after another (docs/capture.md). Throws where the bytes end. */
export class ByteReader {
  constructor(bytes) {
    this.bytes = bytes;
    this.view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
    this.at = 0;
  }
  u8() {
    return this.view.getUint8(this.at++);
  }
  u16() {
    this.at += 2;
    return this.view.getUint16(this.at - 2, true);
  }
  i16() {
    this.at += 2;
    return this.view.getInt16(this.at - 2, true);
  }
  u32() {
    this.at += 4;
    return this.view.getUint32(this.at - 4, true);
  }
  /** Exact below 2^53. */
  u64() {
    const low = this.u32();
    return low + this.u32() * 2 ** 32;
  }
  f32() {
    this.at += 4;
    return this.view.getFloat32(this.at - 4, true);
  }
  f64() {
    this.at += 8;
    return this.view.getFloat64(this.at - 8, true);
  }
  varint() {
    let value = 0;
    let unit = 1;
    for (let k = 0; k < 10; ++k) {
      if (this.at >= this.bytes.length) throw new RangeError("a number is cut short");
      const byte = this.bytes[this.at++];
      value += (byte & 127) * unit;
      if (byte < 128) return value;
      unit *= 128;
    }
    throw new RangeError("a number has more than 10 bytes");
  }
  zigzag() {
    const bytes = this.bytes;
    const byte = bytes[this.at];
    if (byte < 128) {
      // nearly all of them
      ++this.at;
      return byte & 1 ? -((byte + 1) >> 1) : byte >> 1;
    }
    const value = this.varint();
    return value % 2 === 0 ? value / 2 : -(value + 1) / 2;
  }
  floats(count) {
    return Float32Array.from({ length: count }, () => this.f32());
  }
  skip(count) {
    if (count > this.bytes.length - this.at) throw new RangeError("the block is cut short");
    const from = this.at;
    this.at += count;
    return this.bytes.subarray(from, this.at);
  }
}
