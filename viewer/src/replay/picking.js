// SPDX-License-Identifier: MIT
import { Quaternion, Ray, Vector3 } from "three";

const kClick_px = 4; // a pointer that moved farther has dragged. Chosen

/** Tells `picked` where a canvas is clicked, in CSS pixels; what turns the picture is no click. */
export function listenForClicks(canvas, picked) {
  let pressed = null;
  canvas.addEventListener("pointerdown", (event) => (pressed = event));
  canvas.addEventListener("pointerup", (event) => {
    const isClick = pressed && Math.hypot(event.clientX - pressed.clientX, event.clientY - pressed.clientY) < kClick_px;
    if (isClick && event.button === 0) picked(event.offsetX, event.offsetY);
    pressed = null;
  });
}

/** The ray into the picture of a camera; x and y from -1 to 1, rightwards and up. */
export function rayThrough(camera, x, y) {
  const toward = new Vector3(x, y, 0.5).unproject(camera);
  return new Ray(camera.position.clone(), toward.sub(camera.position).normalize());
}

/** The body that a ray meets first in what is drawn; `show` as BodyLayer takes it. Null for none. */
export function bodyAt(ray, { cursor, file, bodies }, show) {
  return firstBody(ray, cursor, file, (row) =>
    bodies.spheresOf(file.shapes[file.bodies.shape[row]], show, cursor.level[row]),
  );
}

/** Distance along the ray to a ball; Infinity if it passes by. */
function toBall(ray, x, y, z, radius) {
  const dx = x - ray.origin.x,
    dy = y - ray.origin.y,
    dz = z - ray.origin.z;
  const along = dx * ray.direction.x + dy * ray.direction.y + dz * ray.direction.z;
  const inside = radius * radius - (dx * dx + dy * dy + dz * dz - along * along);
  if (inside < 0) return Infinity;
  const at = along - Math.sqrt(inside);
  return at > 0 ? at : along + Math.sqrt(inside) > 0 ? 0 : Infinity;
}

function toTriangles(ray, shape) {
  const corner = [new Vector3(), new Vector3(), new Vector3()];
  const hit = new Vector3();
  let nearest = Infinity;
  for (let at = 0; at < shape.corners.length; at += 3) {
    for (let k = 0; k < 3; ++k) corner[k].fromArray(shape.positions, 3 * shape.corners[at + k]);
    if (ray.intersectTriangle(...corner, false, hit)) nearest = Math.min(nearest, ray.origin.distanceTo(hit));
  }
  return nearest;
}

function toSpheres(ray, list) {
  let nearest = Infinity;
  for (let at = 0; at < list.length; at += 4)
    nearest = Math.min(nearest, toBall(ray, list[at], list[at + 1], list[at + 2], list[at + 3]));
  return nearest;
}

/**
 * The body that a ray (in the world) meets first, as `{row, distance}`; null for none. `spheresOf` tells what is drawn of
 * a row: an array of x y z r in its frame, or null for its mesh.
 */
export function firstBody(ray, cursor, file, spheresOf) {
  const near = [];
  for (const row of cursor.rows) {
    const shape = file.shapes[file.bodies.shape[row]];
    if (shape.kind === "plane") continue;
    const at = 3 * row;
    const distance = toBall(ray, cursor.position[at], cursor.position[at + 1], cursor.position[at + 2], shape.radius_m);
    if (distance < Infinity) near.push({ row, distance });
  }
  near.sort((a, b) => a.distance - b.distance);
  let best = null;
  const turn = new Quaternion();
  for (const { row, distance } of near) {
    if (best && distance > best.distance) break;
    const shape = file.shapes[file.bodies.shape[row]];
    turn.fromArray(cursor.orientation, 4 * row).invert();
    const place = new Vector3().fromArray(cursor.position, 3 * row);
    const local = new Ray(
      ray.origin.clone().sub(place).applyQuaternion(turn),
      ray.direction.clone().applyQuaternion(turn),
    );
    const spheres = spheresOf(row);
    const exact = spheres === null ? toTriangles(local, shape) : toSpheres(local, spheres);
    if (exact < (best?.distance ?? Infinity)) best = { row, distance: exact };
  }
  return best;
}
