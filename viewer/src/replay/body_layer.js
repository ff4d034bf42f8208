// SPDX-License-Identifier: MIT
import {
  BufferAttribute,
  BufferGeometry,
  DynamicDrawUsage,
  Frustum,
  InstancedBufferAttribute,
  InstancedBufferGeometry,
  Matrix4,
  Mesh,
  Points,
} from "three";

import { CrowdedCells } from "./crowded_cells.js";
import { ballMaterial, dotMaterial, meshMaterial } from "./shaders.js";

/** What a machine draws in full; other bodies are one sphere each. Spheres below `dot_px` are discs. Chosen. */
export const kSoftware = { bodies: 1_000, spheres: 50_000, triangles: 300_000, dot_px: 28, hides: true };
export const kHardware = { bodies: 20_000, spheres: 400_000, triangles: 8_000_000, dot_px: 1, hides: false };

/** Things of one kind with attributes that grow: instances of a geometry, or points. */
class Instances {
  constructor(scene, geometry, material, sizes) {
    this.geometry = geometry;
    this.isPoints = !geometry.isInstancedBufferGeometry;
    this.sizes = sizes;
    this.count = 0;
    this.capacity = 0;
    this.mesh = this.isPoints ? new Points(geometry, material) : new Mesh(geometry, material);
    this.mesh.frustumCulled = false;
    scene.add(this.mesh);
    this.reserve(64);
  }
  reserve(count) {
    if (count <= this.capacity) return;
    this.capacity = Math.max(count, 2 * this.capacity);
    for (const [name, size] of Object.entries(this.sizes)) {
      const isColor = name === "tint";
      const array = isColor ? new Uint8Array(4 * this.capacity) : new Float32Array(size * this.capacity);
      if (this[name]) array.set(this[name].array);
      this[name] = new (this.isPoints ? BufferAttribute : InstancedBufferAttribute)(array, size, isColor);
      this[name].setUsage(DynamicDrawUsage);
      this.geometry.setAttribute(name, this[name]);
    }
    // Instance attributes of another length need a new vertex array.
    this.geometry.dispose();
  }
  begin() {
    this.count = 0;
  }
  tintAt(k, colors, row) {
    const { array } = this.tint;
    array[4 * k] = colors[3 * row];
    array[4 * k + 1] = colors[3 * row + 1];
    array[4 * k + 2] = colors[3 * row + 2];
    array[4 * k + 3] = 255;
  }
  end() {
    if (this.isPoints) this.geometry.setDrawRange(0, this.count);
    else this.geometry.instanceCount = this.count;
    this.mesh.visible = this.count > 0;
    for (const name of Object.keys(this.sizes)) {
      this[name].clearUpdateRanges();
      this[name].addUpdateRange(0, this[name].itemSize * this.count);
      this[name].needsUpdate = this.count > 0;
    }
  }
}

function squareGeometry() {
  const geometry = new InstancedBufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(Float32Array.of(-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0), 3));
  geometry.setIndex([0, 1, 2, 0, 2, 3]);
  return geometry;
}

function meshGeometry(shape) {
  const geometry = new InstancedBufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(shape.positions, 3));
  geometry.setIndex(new BufferAttribute(shape.corners, 1));
  return geometry;
}

/** A ball of about the size that the shape has to the eye, for bodies that are not drawn in full. */
function plainRadius(shape) {
  const finest = shape.levels[shape.levels.length - 1];
  if (finest.length === 4) return finest[3];
  let area = 0;
  for (let at = 3; at < finest.length; at += 4) area += finest[at] * finest[at];
  return Math.min(Math.sqrt(area), 0.8 * shape.radius_m);
}

/** Rows of a frame that are in the picture, those that look largest first; bodies of one size thus from front to back. */
class VisibleRows {
  constructor(rows) {
    this.rows = new Uint32Array(rows);
    this.size = new Float32Array(rows); // square of distance / radius, in the same order
    this.keys = new Uint32Array(this.size.buffer);
    this.order = new Uint32Array(rows);
    this.starts = new Uint32Array(2 ** 16 + 1);
    this.count = 0;
  }
  find(cursor, camera, radiusOf) {
    const { planes } = new Frustum().setFromProjectionMatrix(
      new Matrix4().multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse),
    );
    const eye = camera.position;
    this.count = 0;
    for (const row of cursor.rows) {
      const radius = radiusOf(row);
      if (radius === 0) continue;
      const px = cursor.position[3 * row],
        py = cursor.position[3 * row + 1],
        pz = cursor.position[3 * row + 2];
      let isInside = true;
      for (let k = 0; k < 6 && isInside; ++k) {
        const { normal, constant } = planes[k];
        isInside = normal.x * px + normal.y * py + normal.z * pz + constant >= -radius;
      }
      if (!isInside) continue;
      const x = px - eye.x,
        y = py - eye.y,
        z = pz - eye.z;
      this.rows[this.count] = row;
      this.size[this.count++] = (x * x + y * y + z * z) / (radius * radius);
    }
    this.sort();
  }
  /** By counting: the bits of positive floats have the order of the floats, and the upper half is fine enough. */
  sort() {
    const { starts, keys, rows, order } = this;
    starts.fill(0);
    for (let i = 0; i < this.count; ++i) ++starts[(keys[i] >>> 16) + 1];
    for (let k = 1; k < starts.length; ++k) starts[k] += starts[k - 1];
    for (let i = 0; i < this.count; ++i) order[starts[keys[i] >>> 16]++] = rows[i];
  }
}

/** Draws the bodies of one capture: as meshes, or as spheres of a level of their trees. */
export class BodyLayer {
  constructor(file, scene, light, limits) {
    this.file = file;
    this.limits = limits;
    const material = meshMaterial(light);
    this.dotMaterial = dotMaterial(light);
    this.balls = new Instances(scene, squareGeometry(), ballMaterial(light), { ball: 4, tint: 4 });
    this.dots = new Instances(scene, new BufferGeometry(), this.dotMaterial, { position: 4, tint: 4 });
    // Behind all that writes depths of its own, which then hides them before their pixels are found.
    this.dots.mesh.renderOrder = 1;
    this.meshes = file.shapes.map((shape) =>
      shape.corners.length > 0
        ? new Instances(scene, meshGeometry(shape), material, { place: 3, turn: 4, tint: 4 })
        : null,
    );
    this.plain = file.shapes.map((shape) => (shape.kind === "plane" ? 0 : plainRadius(shape)));
    this.visible = new VisibleRows(file.bodies.number.length);
    this.cells = new CrowdedCells();
    this.inFull = 0;
    this.hidden = 0;
  }

  /** Room for a table of so many bodies. */
  reserve(rows) {
    if (rows > this.visible.rows.length) this.visible = new VisibleRows(2 * rows);
  }

  /** The spheres to draw of a body, as an array of x y z r; null: its mesh. */
  spheresOf(shape, show, level) {
    const finest = shape.levels[shape.levels.length - 1];
    const hasMesh = shape.corners.length > 0;
    if (show === "shapes") return hasMesh ? null : finest;
    if (show === "reached" && level === 8) return hasMesh ? null : finest;
    return shape.levels[show === "reached" ? Math.max(0, level - 1) : show] ?? finest;
  }

  /**
   * @param {"shapes" | "reached" | number} show meshes, the spheres of the level that each body reached, or those of one level
   * @param {Uint8Array} colors red, green and blue of each row
   * @param {number} width of the picture in pixels @param {number} height likewise
   */
  update(cursor, camera, show, colors, width, height) {
    const { limits, visible } = this;
    this.eye = camera.position;
    this.dotMaterial.uniforms.height.value = height;
    // The square of radius / distance below which a sphere is a disc.
    this.dotRatio = (limits.dot_px / (0.5 * height * camera.projectionMatrix.elements[5])) ** 2;
    visible.find(cursor, camera, (row) => {
      const shape = this.file.shapes[this.file.bodies.shape[row]];
      return shape.kind === "plane" ? 0 : shape.radius_m;
    });
    let spheres = 0;
    let triangles = 0;
    this.inFull = 0;
    this.hidden = 0;
    this.cells.begin(camera, width, height);
    for (const drawn of [this.balls, this.dots, ...this.meshes]) drawn?.begin();
    for (let i = 0; i < visible.count; ++i) {
      const row = visible.order[i];
      const number = this.file.bodies.shape[row];
      const shape = this.file.shapes[number];
      const at = 3 * row;
      const x = cursor.position[at],
        y = cursor.position[at + 1],
        z = cursor.position[at + 2];
      if (limits.hides && this.cells.hides(x, y, z, this.plain[number])) {
        ++this.hidden;
        continue;
      }
      const list = this.spheresOf(shape, show, cursor.level[row]);
      const isLarge = i < limits.bodies;
      if (list === null && isLarge && triangles + shape.triangles <= limits.triangles) {
        triangles += shape.triangles;
        ++this.inFull;
        this.addMesh(this.meshes[number], cursor, row, colors);
      } else if (list !== null && (list.length === 4 || (isLarge && spheres + list.length / 4 <= limits.spheres))) {
        spheres += list.length / 4;
        ++this.inFull;
        this.addBalls(list, cursor, row, colors);
      } else {
        this.addBall(x, y, z, this.plain[number], row, colors);
      }
    }
    for (const drawn of [this.balls, this.dots, ...this.meshes]) drawn?.end();
  }

  addMesh(drawn, cursor, row, colors) {
    const k = drawn.count++;
    drawn.reserve(drawn.count);
    for (let axis = 0; axis < 3; ++axis) drawn.place.array[3 * k + axis] = cursor.position[3 * row + axis];
    for (let part = 0; part < 4; ++part) drawn.turn.array[4 * k + part] = cursor.orientation[4 * row + part];
    drawn.tintAt(k, colors, row);
  }

  addBall(x, y, z, radius, row, colors) {
    const dx = x - this.eye.x,
      dy = y - this.eye.y,
      dz = z - this.eye.z;
    const isDot = radius * radius < this.dotRatio * (dx * dx + dy * dy + dz * dz);
    const drawn = isDot ? this.dots : this.balls;
    const k = drawn.count++;
    drawn.reserve(drawn.count);
    const { array } = isDot ? drawn.position : drawn.ball;
    array[4 * k] = x;
    array[4 * k + 1] = y;
    array[4 * k + 2] = z;
    array[4 * k + 3] = radius;
    drawn.tintAt(k, colors, row);
  }

  addBalls(list, cursor, row, colors) {
    const px = cursor.position[3 * row],
      py = cursor.position[3 * row + 1],
      pz = cursor.position[3 * row + 2];
    const qx = cursor.orientation[4 * row],
      qy = cursor.orientation[4 * row + 1];
    const qz = cursor.orientation[4 * row + 2],
      qw = cursor.orientation[4 * row + 3];
    for (let at = 0; at < list.length; at += 4) {
      const x = list[at],
        y = list[at + 1],
        z = list[at + 2];
      const tx = 2 * (qy * z - qz * y),
        ty = 2 * (qz * x - qx * z),
        tz = 2 * (qx * y - qy * x);
      this.addBall(
        px + x + qw * tx + qy * tz - qz * ty,
        py + y + qw * ty + qz * tx - qx * tz,
        pz + z + qw * tz + qx * ty - qy * tx,
        list[at + 3],
        row,
        colors,
      );
    }
  }
}
