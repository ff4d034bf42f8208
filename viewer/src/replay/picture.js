// SPDX-License-Identifier: MIT
// What the replay and the page of a live run share of their pictures.
import { Vector3, WebGLRenderer } from "three";

/** Whether pictures are made by the processor alone. */
function isSoftware() {
  const context = document.createElement("canvas").getContext("webgl2");
  if (!context) throw new Error("this browser draws no 3D (WebGL 2)");
  const info = context.getExtension("WEBGL_debug_renderer_info");
  const name = info ? context.getParameter(info.UNMASKED_RENDERER_WEBGL) : context.getParameter(context.RENDERER);
  context.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software|basic render/i.test(String(name));
}

/** What draws on a canvas, and whether it does without a graphics processor. */
export function makeRenderer(canvas) {
  const software = isSoftware();
  // Smooth edges cost more than all else where the processor draws.
  const renderer = new WebGLRenderer({
    canvas,
    alpha: false,
    antialias: !software,
    powerPreference: "high-performance",
  });
  renderer.setPixelRatio(software ? 1 : devicePixelRatio);
  return { renderer, software };
}

/** Against gravity; up along z without it. */
export function upOf(gravity) {
  const down = new Vector3(...(gravity ?? [0, 0, -1]));
  return down.lengthSq() > 0 ? down.normalize().negate() : new Vector3(0, 0, 1);
}

/** Lights the bodies from above and from beside the camera. */
export function aimLight(light, up, camera) {
  light.above.value.copy(up).transformDirection(camera.matrixWorldInverse);
  light.key.value.set(0.35, 0.75, 0.6).normalize();
}

/** What can be drawn of bodies of these shapes, as choices. */
export function showChoices(shapes) {
  const levels = Math.max(0, ...shapes.map((shape) => shape.levels.length));
  const show = { shapes: "shapes", reached: "spheres reached" };
  for (let level = 0; level < levels; ++level) show[level] = `spheres, level ${level}`;
  return show;
}

/** The choice as BodyLayer takes it: a word, or the number of a level. */
export const showOf = (value) => (value === "shapes" || value === "reached" ? value : Number(value));

/** Puts a ring around a body in a picture of this size, whose left edge is `left` pixels from that of the stage. */
export function placeBodyRing(ring, { cursor, file, row }, camera, width, height, left = 0) {
  const center = new Vector3().fromArray(cursor.position, 3 * row);
  const away = center.distanceTo(camera.position);
  const radius = file.shapes[file.bodies.shape[row]].radius_m;
  const size = (radius / away / Math.tan((camera.fov * Math.PI) / 360)) * height;
  const seen = center.project(camera);
  ring.hidden = seen.z > 1;
  ring.style.left = `${left + (0.5 + 0.5 * seen.x) * width}px`;
  ring.style.top = `${(0.5 - 0.5 * seen.y) * height}px`;
  ring.style.width = ring.style.height = `${Math.max(12, size)}px`;
}

/** Puts a ring where a point is seen in a picture of this size; hides it where it is not. */
export function placeRing(ring, point, camera, width, height) {
  const seen = point.project(camera);
  ring.hidden = seen.z > 1 || Math.abs(seen.x) > 1 || Math.abs(seen.y) > 1;
  ring.style.left = `${(0.5 + 0.5 * seen.x) * width}px`;
  ring.style.top = `${(0.5 - 0.5 * seen.y) * height}px`;
}
