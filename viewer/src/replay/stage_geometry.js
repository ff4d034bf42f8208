// SPDX-License-Identifier: MIT
import {
  BufferAttribute,
  BufferGeometry,
  Color,
  LineBasicMaterial,
  LineSegments,
  Mesh,
  Quaternion,
  Vector3,
  Vector4,
} from "three";

import { planeMaterial } from "./shaders.js";

/** A box that grows around the bodies of a frame; `onlyMoving`: without those that are fixed. Planes have no size. */
function extend(low, high, file, cursor, onlyMoving) {
  const place = new Vector3();
  for (const row of cursor.rows) {
    if (file.shapes[file.bodies.shape[row]].kind === "plane" || (onlyMoving && file.bodies.motion[row] !== 2)) continue;
    place.fromArray(cursor.position, 3 * row);
    low.min(place);
    high.max(place);
  }
}

/** A ball around a box: middle and radius; that of nothing is about the origin. */
function ballAround(low, high, file) {
  if (low.x > high.x) return { center: new Vector3(), radius: 5 };
  const largest = Math.max(0, ...file.shapes.map((shape) => shape.radius_m));
  return {
    center: low.clone().add(high).multiplyScalar(0.5),
    radius: Math.max(0.5 * low.distanceTo(high), largest, 0.1),
  };
}

const emptyBox = () => [new Vector3(Infinity, Infinity, Infinity), new Vector3(-Infinity, -Infinity, -Infinity)];

/** A ball around what moves at the start, in the middle and at the end; around all bodies if none moves. */
export function boundsOf(file, cursor) {
  const [low, high] = emptyBox();
  const last = file.frames.length - 1;
  for (const onlyMoving of [true, false]) {
    for (const index of new Set([0, Math.floor(last / 2), last])) {
      cursor.seek(index);
      extend(low, high, file, cursor, onlyMoving);
    }
    if (low.x <= high.x) break;
  }
  return ballAround(low, high, file);
}

/** The same of the frame that a view shows. */
export function boundsNow({ file, cursor }) {
  const [low, high] = emptyBox();
  extend(low, high, file, cursor, true);
  if (low.x > high.x) extend(low, high, file, cursor, false);
  return ballAround(low, high, file);
}

/** A round distance between the lines of a grid: about a twentieth of what is seen. */
const roundSpacing = (size) => 10 ** Math.round(Math.log10(size / 10));

/** The planes of a scene, as faint grids seen from their front side. They do not move. */
export class PlaneLayer {
  constructor(file, cursor, scene, bounds) {
    this.materials = [];
    cursor.seek(0);
    for (const row of cursor.rows) {
      const shape = file.shapes[file.bodies.shape[row]];
      if (shape.kind === "plane") this.add(shape, cursor, row, scene, bounds);
    }
  }
  add(shape, cursor, row, scene, bounds) {
    const turn = new Quaternion().fromArray(cursor.orientation, 4 * row);
    const normal = new Vector3(...shape.normal).applyQuaternion(turn).normalize();
    const foot = new Vector3().fromArray(cursor.position, 3 * row).addScaledVector(normal, shape.offset_m);
    const isLevel = Math.abs(normal.z) > 0.9;
    const reach = (isLevel ? 2.5 : 1) * bounds.radius;
    const middle = bounds.center.clone();
    middle.addScaledVector(normal, foot.sub(bounds.center).dot(normal));
    const geometry = new BufferGeometry();
    geometry.setAttribute(
      "position",
      new BufferAttribute(
        Float32Array.of(-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0).map((value) => value * reach),
        3,
      ),
    );
    geometry.setAttribute(
      "uv",
      new BufferAttribute(
        Float32Array.of(-1, -1, 1, -1, 1, 1, -1, 1).map((value) => value * reach),
        2,
      ),
    );
    geometry.setIndex([0, 1, 2, 0, 2, 3]);
    const material = planeMaterial({
      fill: { value: new Vector4() },
      line: { value: new Vector4() },
      spacing: { value: roundSpacing(bounds.radius) },
      reach: { value: reach },
    });
    material.userData.isLevel = isLevel;
    const mesh = new Mesh(geometry, material);
    mesh.position.copy(middle);
    mesh.quaternion.setFromUnitVectors(new Vector3(0, 0, 1), normal);
    mesh.renderOrder = isLevel ? -1 : 1;
    scene.add(mesh);
    this.materials.push(material);
  }
  setTheme(isDark) {
    for (const { uniforms, userData } of this.materials) {
      const ink = isDark ? 1 : 0;
      uniforms.fill.value.set(ink, ink, ink, userData.isLevel ? 0.05 : 0.015);
      uniforms.line.value.set(ink, ink, ink, userData.isLevel ? 0.22 : 0.07);
    }
  }
}

/** Contact points with their normals. */
export class ContactLayer {
  constructor(scene, size) {
    this.size = size;
    this.material = new LineBasicMaterial({ color: new Color("#d55e00"), depthTest: false, transparent: true });
    this.lines = new LineSegments(new BufferGeometry(), this.material);
    this.lines.frustumCulled = false;
    this.lines.renderOrder = 2;
    scene.add(this.lines);
    this.points = 0;
  }
  /** A cross at each point, and a line along the normal. */
  update(contacts, isShown) {
    this.lines.visible = isShown && contacts.length > 0;
    if (!this.lines.visible) return;
    // Few are drawn to be seen, many so that they do not hide each other.
    const length = contacts.length > 50 ? 0.5 * this.size : this.size;
    const places = [];
    this.points = 0;
    const arm = 0.25 * length;
    for (const { points_m: points, normal } of contacts) {
      for (const [x, y, z] of points) {
        ++this.points;
        places.push(x - arm, y, z, x + arm, y, z, x, y - arm, z, x, y + arm, z);
        places.push(x, y, z, x + length * normal[0], y + length * normal[1], z + length * normal[2]);
      }
    }
    this.lines.geometry.dispose();
    this.lines.geometry = new BufferGeometry();
    this.lines.geometry.setAttribute("position", new BufferAttribute(Float32Array.from(places), 3));
  }
}
