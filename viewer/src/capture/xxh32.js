// SPDX-License-Identifier: MIT

const kPrime1 = 0x9e3779b1,
  kPrime2 = 0x85ebca77,
  kPrime3 = 0xc2b2ae3d,
  kPrime4 = 0x27d4eb2f,
  kPrime5 = 0x165667b1;
const rotated = (value, bits) => (value << bits) | (value >>> (32 - bits));

/** XXH32 with seed 0 of a part of `bytes` (Collet, xxHash specification 0.1.1), as an unsigned number. */
export function xxh32(bytes, from, size) {
  const view = new DataView(bytes.buffer, bytes.byteOffset + from, size);
  const round = (sum, at) => Math.imul(rotated((sum + Math.imul(view.getUint32(at, true), kPrime2)) | 0, 13), kPrime1);
  let at = 0;
  let hash = kPrime5;
  if (size >= 16) {
    let a = (kPrime1 + kPrime2) | 0,
      b = kPrime2,
      c = 0,
      d = -kPrime1 | 0;
    for (; at + 16 <= size; at += 16) {
      a = round(a, at);
      b = round(b, at + 4);
      c = round(c, at + 8);
      d = round(d, at + 12);
    }
    hash = rotated(a, 1) + rotated(b, 7) + rotated(c, 12) + rotated(d, 18);
  }
  hash = (hash + size) | 0;
  for (; at + 4 <= size; at += 4)
    hash = Math.imul(rotated((hash + Math.imul(view.getUint32(at, true), kPrime3)) | 0, 17), kPrime4);
  for (; at < size; ++at) hash = Math.imul(rotated((hash + Math.imul(view.getUint8(at), kPrime5)) | 0, 11), kPrime1);
  hash = Math.imul(hash ^ (hash >>> 15), kPrime2);
  hash = Math.imul(hash ^ (hash >>> 13), kPrime3);
  return (hash ^ (hash >>> 16)) >>> 0;
}
