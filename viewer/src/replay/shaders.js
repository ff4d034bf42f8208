// SPDX-License-Identifier: MIT
import { DoubleSide, GLSL3, RawShaderMaterial, Vector3 } from "three";

const kLight = `
uniform vec3 key;   // direction to the light, in the frame of the camera
uniform vec3 above; // upwards, likewise
vec3 lit(vec3 color, vec3 normal) {
  float soft = 0.5 + 0.5 * dot(normal, above);
  return color * (0.48 + 0.22 * soft + 0.42 * max(0.0, dot(normal, key)));
}`;

/** Meshes: a place, a turn (quaternion x y z w) and a colour for each instance; facets have the normal of their triangle. */
const kMeshVertex = `
precision highp float;
uniform mat4 viewMatrix, projectionMatrix;
in vec3 position, place;
in vec4 turn, tint;
out vec3 point;
flat out vec3 color;
void main() {
  vec3 twice = 2.0 * cross(turn.xyz, position);
  vec3 turned = position + turn.w * twice + cross(turn.xyz, twice);
  vec4 seen = viewMatrix * vec4(turned + place, 1.0);
  point = seen.xyz;
  color = tint.rgb;
  gl_Position = projectionMatrix * seen;
}`;
const kMeshFragment = `
precision highp float;
${kLight}
in vec3 point;
flat in vec3 color;
out vec4 pixel;
void main() {
  vec3 normal = normalize(cross(dFdx(point), dFdy(point)));
  pixel = vec4(lit(color, normal), 1.0);
}`;

/** Spheres: a square that covers the ball as seen, and the ball itself found for each pixel. */
const kBallVertex = `
precision highp float;
uniform mat4 viewMatrix, projectionMatrix;
in vec3 position;
in vec4 ball, tint;
out vec3 ray;
flat out vec4 center;
flat out vec3 color;
void main() {
  vec3 middle = (viewMatrix * vec4(ball.xyz, 1.0)).xyz;
  float away = length(middle), radius = ball.w;
  center = vec4(middle, radius);
  color = tint.rgb;
  if (away <= 1.001 * radius) { // the camera is inside
    gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
    return;
  }
  vec3 toward = middle / away;
  vec3 side = normalize(cross(toward, abs(toward.y) < 0.9 ? vec3(0.0, 1.0, 0.0) : vec3(1.0, 0.0, 0.0)));
  float reach = radius * away / sqrt(away * away - radius * radius);
  ray = middle + reach * (position.x * side + position.y * cross(side, toward));
  gl_Position = projectionMatrix * vec4(ray, 1.0);
}`;
const kBallFragment = `
precision highp float;
uniform mat4 projectionMatrix;
${kLight}
in vec3 ray;
flat in vec4 center;
flat in vec3 color;
out vec4 pixel;
void main() {
  vec3 along = normalize(ray);
  float nearest = dot(along, center.xyz);
  vec3 beside = center.xyz - nearest * along;
  float inside = center.w * center.w - dot(beside, beside);
  if (inside < 0.0) discard;
  vec3 hit = (nearest - sqrt(inside)) * along;
  pixel = vec4(lit(color, (hit - center.xyz) / center.w), 1.0);
  vec2 depth = vec2(projectionMatrix[2][2] * hit.z + projectionMatrix[3][2], -hit.z);
  gl_FragDepth = 0.5 + 0.5 * depth.x / depth.y;
}`;

/** Spheres that are small in the picture: a disc with the shade of a ball, quick to draw without a graphics processor. */
const kDotVertex = `
precision highp float;
uniform mat4 viewMatrix, projectionMatrix;
uniform float height; // of the picture in pixels
in vec4 position;
in vec4 tint;
out vec3 color;
void main() {
  color = tint.rgb;
  gl_Position = projectionMatrix * (viewMatrix * vec4(position.xyz, 1.0));
  gl_PointSize = max(1.5, height * projectionMatrix[1][1] * position.w / gl_Position.w);
}`;
const kDotFragment = `
precision highp float;
${kLight}
in vec3 color;
out vec4 pixel;
void main() {
  vec2 at = vec2(2.0, -2.0) * (gl_PointCoord - 0.5);
  float outside = dot(at, at);
  if (outside > 1.0) discard;
  pixel = vec4(lit(color, vec3(at, sqrt(1.0 - outside))), 1.0);
}`;

/** Planes: a faint grid of lines a metre (or ten, ...) apart that fades with distance from the middle. */
const kPlaneVertex = `
precision highp float;
uniform mat4 modelViewMatrix, projectionMatrix;
in vec3 position;
in vec2 uv;
out vec2 at;
void main() {
  at = uv;
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
}`;
const kPlaneFragment = `
precision highp float;
uniform vec4 fill, line;
uniform float spacing, reach;
in vec2 at;
out vec4 pixel;
void main() {
  vec2 cell = at / spacing, width = fwidth(cell);
  vec2 near = abs(fract(cell - 0.5) - 0.5) / max(width, 1e-6);
  float strength = (1.0 - min(min(near.x, near.y), 1.0)) * clamp(0.6 - max(width.x, width.y), 0.0, 1.0);
  float fade = 1.0 - smoothstep(0.6, 1.0, length(at) / reach);
  vec4 color = mix(fill, line, strength);
  pixel = vec4(color.rgb, color.a * fade);
}`;

/** Light that all materials share, in the frame of the camera; set before each picture. */
export const makeLight = () => ({ key: { value: new Vector3(0, 0, 1) }, above: { value: new Vector3(0, 1, 0) } });

const raw = (vertexShader, fragmentShader, uniforms, more = {}) =>
  new RawShaderMaterial({ glslVersion: GLSL3, vertexShader, fragmentShader, uniforms, ...more });

export const meshMaterial = (light) => raw(kMeshVertex, kMeshFragment, { ...light }, { side: DoubleSide });
export const dotMaterial = (light) => raw(kDotVertex, kDotFragment, { ...light, height: { value: 1 } });
export const ballMaterial = (light) => raw(kBallVertex, kBallFragment, { ...light });
export const planeMaterial = (uniforms) =>
  raw(kPlaneVertex, kPlaneFragment, uniforms, { transparent: true, depthWrite: false });
