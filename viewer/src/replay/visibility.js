// SPDX-License-Identifier: MIT
import { Vector3 } from "three";

/** What the camera of the scene has of a body. */
export const kSeen = 0,
  kHidden = 1,
  kOutside = 2;
export const kVisibility = ["seen", "hidden behind others", "outside the picture"];

// Cells of the picture. Chosen: a body of 20,000 still fills one.
const kColumns = 256,
  kRows = 144;

/** Finds which bodies the camera of the scene sees, by one ball for each body in a picture of few cells. */
export class Visibility {
  /** @param {number} rows of the table of bodies @param {(row: number) => number} radiusOf 0 for what hides nothing */
  constructor(rows, radiusOf) {
    this.radiusOf = radiusOf;
    this.of = new Uint8Array(rows);
    this.depth = new Float32Array(kColumns * kRows);
    this.front = new Int32Array(kColumns * kRows);
    this.place = new Float32Array(4 * rows); // column, line, radius in cells, distance of the nearest point
  }

  /** Fills `of`, kSeen, kHidden or kOutside of each row of the frame. `camera` is the view of the frame. */
  find(cursor, camera) {
    this.depth.fill(Infinity);
    this.front.fill(-1);
    const forward = new Vector3(...camera.forward).normalize();
    const right = forward
      .clone()
      .cross(new Vector3(...camera.up))
      .normalize();
    const up = right.clone().cross(forward);
    const eye = new Vector3(...camera.position_m);
    const perLine = kRows / (2 * Math.tan(camera.vertical_fov_rad / 2));
    const perColumn = kColumns / (2 * Math.tan(camera.vertical_fov_rad / 2) * camera.aspect);
    const away = new Vector3();
    for (const row of cursor.rows) {
      const radius = this.radiusOf(row);
      away.fromArray(cursor.position, 3 * row).sub(eye);
      const deep = away.dot(forward);
      this.of[row] = kOutside;
      if (radius === 0 || deep <= radius) continue;
      const column = 0.5 * kColumns + (away.dot(right) / deep) * perColumn;
      const line = 0.5 * kRows - (away.dot(up) / deep) * perLine;
      const wide = (radius / deep) * perColumn,
        high = (radius / deep) * perLine;
      if (column < -wide || column > kColumns + wide || line < -high || line > kRows + high) continue;
      this.of[row] = kHidden;
      this.place.set([column, line, wide, high], 4 * row);
      this.cover(row, deep - radius);
    }
    for (const row of this.front) if (row >= 0) this.of[row] = kSeen;
  }

  /** The cells whose middle is in the picture of the ball, and at least the one that its own middle is in. */
  cover(row, depth) {
    const [column, line, wide, high] = this.place.subarray(4 * row, 4 * row + 4);
    const put = (x, y) => {
      if (x < 0 || x >= kColumns || y < 0 || y >= kRows) return;
      const cell = y * kColumns + x;
      if (depth >= this.depth[cell]) return;
      this.depth[cell] = depth;
      this.front[cell] = row;
    };
    put(Math.min(Math.max(Math.floor(column), 0), kColumns - 1), Math.min(Math.max(Math.floor(line), 0), kRows - 1));
    for (let y = Math.max(0, Math.ceil(line - high - 0.5)); y <= Math.min(kRows - 1, line + high - 0.5); ++y) {
      const part = (y + 0.5 - line) / high;
      const half = wide * Math.sqrt(Math.max(0, 1 - part * part));
      for (let x = Math.max(0, Math.ceil(column - half - 0.5)); x <= column + half - 0.5; ++x) put(x, y);
    }
  }
}
