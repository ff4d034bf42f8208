// SPDX-License-Identifier: MIT
import { BufferAttribute, BufferGeometry, LineBasicMaterial, LineSegments, Vector3 } from "three";

import { isCoarse } from "../capture/pairs.js";

/** Lines whose places grow, each end with a colour. */
class Lines {
  constructor(scene, material) {
    this.lines = new LineSegments(new BufferGeometry(), material);
    this.lines.frustumCulled = false;
    this.lines.renderOrder = 3;
    scene.add(this.lines);
    this.capacity = 0;
    this.reserve(64);
  }
  reserve(ends) {
    if (ends <= this.capacity) return;
    this.capacity = Math.max(ends, 2 * this.capacity);
    this.lines.geometry.dispose();
    this.lines.geometry = new BufferGeometry();
    this.places = new BufferAttribute(new Float32Array(3 * this.capacity), 3);
    this.colors = new BufferAttribute(new Float32Array(3 * this.capacity), 3);
    this.lines.geometry.setAttribute("position", this.places);
    this.lines.geometry.setAttribute("color", this.colors);
  }
  begin(isShown) {
    this.count = 0;
    this.lines.visible = isShown;
  }
  end() {
    this.lines.visible = this.lines.visible && this.count > 0;
    this.lines.geometry.setDrawRange(0, this.count);
    this.places.needsUpdate = this.colors.needsUpdate = true;
  }
  /** Places x y z of both ends. */
  add(ax, ay, az, bx, by, bz, color) {
    if (this.count + 2 > this.places.count) throw new RangeError("lines were not reserved");
    this.places.setXYZ(this.count, ax, ay, az);
    this.places.setXYZ(this.count + 1, bx, by, bz);
    this.colors.setXYZ(this.count, ...color);
    this.colors.setXYZ(this.count + 1, ...color);
    this.count += 2;
  }
}

/** What the camera of the scene sees, for a camera that stands elsewhere. */
export class FrustumLayer {
  constructor(scene) {
    this.lines = new Lines(scene, new LineBasicMaterial({ vertexColors: true }));
    this.color = [0.84, 0.37, 0];
  }
  /** @param {any} facts the view of the frame, or null @param {number} away how far its far side is */
  update(facts, away, isShown) {
    this.lines.begin(isShown && facts !== null);
    if (isShown && facts) {
      const eye = new Vector3(...facts.position_m);
      const forward = new Vector3(...facts.forward).normalize();
      const up = new Vector3(...facts.up).normalize();
      const right = new Vector3().crossVectors(forward, up).normalize();
      const half = Math.tan(facts.vertical_fov_rad / 2) * away;
      const corners = [
        [-1, -1],
        [1, -1],
        [1, 1],
        [-1, 1],
      ].map(([x, y]) =>
        eye
          .clone()
          .addScaledVector(forward, away)
          .addScaledVector(right, x * half * facts.aspect)
          .addScaledVector(up, y * half),
      );
      corners.forEach((corner, k) => {
        const next = corners[(k + 1) % 4];
        this.lines.add(...eye.toArray(), ...corner.toArray(), this.color);
        this.lines.add(...corner.toArray(), ...next.toArray(), this.color);
      });
    }
    this.lines.end();
  }
}

/** Pairs that refinement left before their last level: a line from body to body in the colour of the level reached. */
export class CoarsePairsLayer {
  constructor(scene, file) {
    this.file = file;
    this.lines = new Lines(scene, new LineBasicMaterial({ vertexColors: true, depthTest: false, transparent: true, opacity: 0.7 }));
    this.count = 0;
  }
  /** `up` shows the way from a plane, which has no middle; `only`: the row of a body, or -1 for all. */
  update(cursor, pairs, levelColor, up, only, isShown) {
    this.lines.begin(isShown);
    this.count = 0;
    if (isShown) {
      this.lines.reserve(2 * pairs.count);
      for (let i = 0; i < pairs.count; ++i) {
        if (!isCoarse(pairs, i) || (only >= 0 && pairs.a[i] !== only && pairs.b[i] !== only)) continue;
        ++this.count;
        this.addPair(cursor, pairs.a[i], pairs.b[i], levelColor(pairs.level[i]), up);
      }
    }
    this.lines.end();
  }
  addPair(cursor, a, b, color, up) {
    const { bodies, shapes } = this.file;
    const isPlane = (row) => shapes[bodies.shape[row]].kind === "plane";
    if (isPlane(a)) [a, b] = [b, a];
    const from = cursor.position.subarray(3 * a, 3 * a + 3);
    const radius = shapes[bodies.shape[a]].radius_m;
    const to = isPlane(b)
      ? [from[0] - radius * up.x, from[1] - radius * up.y, from[2] - radius * up.z]
      : cursor.position.subarray(3 * b, 3 * b + 3);
    this.lines.add(...from, ...to, color);
  }
}
