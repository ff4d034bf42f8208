// SPDX-License-Identifier: MIT
import { Color, Scene, Vector2, Vector3 } from "three";

import { kCauses } from "../data/frames.js";
import { byId, fillSelect } from "../elements.js";
import { milliseconds } from "../format.js";
import { BodyLayer, kHardware, kSoftware } from "../replay/body_layer.js";
import { Cameras } from "../replay/cameras.js";
import { Coloring, kColorings } from "../replay/coloring.js";
import { showFacts } from "../replay/facts.js";
import { bodyAt, listenForClicks, rayThrough } from "../replay/picking.js";
import { aimLight, makeRenderer, placeBodyRing, placeRing, showChoices, showOf, upOf } from "../replay/picture.js";
import { makeLight } from "../replay/shaders.js";
import { boundsNow, PlaneLayer } from "../replay/stage_geometry.js";
import { LiveCursor } from "./live_capture.js";

const kFacts_ms = 100; // between two updates of a body's facts, so that they can be read

/** Scales of colours before anything was seen but the shapes. */
const firstScales = (shapes) => ({
  levels: Math.max(1, ...shapes.map((shape) => shape.levels.length)),
  polygons: shapes.some((shape) => shape.corners.length > 0),
  topSpeed: 1,
  bands: [255, 0],
});

/** Draws what a live run has told last, and says from where it is looked at. */
export class LiveStage {
  /** `look` is told where the viewer is and looks. */
  constructor({ store, capture, look }) {
    Object.assign(this, { store, capture, look });
    this.canvas = byId("view");
    Object.assign(this, makeRenderer(this.canvas));
    this.light = makeLight();
    this.scene = new Scene();
    this.cursor = new LiveCursor(capture);
    this.cursor.advance();
    this.colors = new Uint8Array(0);
    this.scales = firstScales(capture.shapes);
    this.bounds = boundsNow({ file: capture, cursor: this.cursor });
    this.bodies = new BodyLayer(capture, this.scene, this.light, this.software ? kSoftware : kHardware);
    this.planes = new PlaneLayer(capture, this.cursor, this.scene, this.bounds);
    this.up = upOf(capture.head.gravity_mps2);
    this.cameras = new Cameras(this.canvas, this.bounds, this.up, {
      changed: () => this.draw(),
      taken: () => this.choose("camera", "free"),
    });
    this.pointer = null;
    this.chosen = null; // `{number, row}`; the row is -1 where the body is not in the table
    this.pictures = 0;
    this.fillControls();
    this.listen();
    this.setTheme();
    this.resize();
  }

  get camera() {
    return this.cursor.facts?.camera ?? null;
  }

  fillControls() {
    fillSelect(byId("show"), showChoices(this.capture.shapes), "shapes");
    // What can be told of a body from one frame.
    const colorings = Object.fromEntries(["level", "priority", "speed", "state", "clock"].map((mode) => [mode, kColorings[mode]]));
    fillSelect(byId("color"), colorings, "level");
    const cameras = { ...(this.camera ? { scene: "of the scene" } : {}), free: "mine", all: "all in view" };
    fillSelect(byId("camera"), cameras, this.camera ? "scene" : "free");
    this.cameras.setFree(!this.camera, null);
    if (!this.camera) this.tell("camera", "gaze");
  }

  listen() {
    for (const id of ["show", "color", "camera", "show-gaze"])
      byId(id).addEventListener("change", () => this.changed(id));
    this.store.on("theme", () => this.setTheme());
    new ResizeObserver(() => this.resize()).observe(byId("stage"));
    const at = (event) => {
      this.pointer = [event.offsetX, event.offsetY];
      this.tell("gaze");
    };
    listenForClicks(this.canvas, (x, y) => this.pickAt(x, y));
    this.canvas.addEventListener("pointermove", at);
    this.canvas.addEventListener("pointerdown", at);
    this.canvas.addEventListener("pointerleave", () => {
      this.pointer = null;
      this.tell("gaze");
    });
  }

  changed(id) {
    if (id === "camera") this.changeCamera(byId("camera").value);
    if (id === "color") this.showLegend();
    this.draw();
  }
  changeCamera(value) {
    this.cameras.setFree(value !== "scene", this.camera);
    if (value === "all") {
      this.cameras.lookAtAll(boundsNow({ file: this.capture, cursor: this.cursor }));
      byId("camera").value = "free";
    }
    this.tell("camera", "gaze");
  }
  choose(id, value) {
    byId(id).value = value;
    this.changed(id);
  }
  next(id) {
    const select = byId(id);
    this.choose(id, select.options[(select.selectedIndex + 1) % select.options.length].value);
  }
  switchCamera() {
    if (byId("camera").options[0].value === "scene")
      this.choose("camera", byId("camera").value === "scene" ? "free" : "scene");
  }
  toggle(id) {
    byId(id).checked = !byId(id).checked;
    this.changed(id);
  }
  setTheme() {
    const style = getComputedStyle(document.documentElement);
    this.renderer.setClearColor(new Color(style.getPropertyValue("--stage").trim()));
    this.planes.setTheme(this.store.get("theme") === "dark");
    this.draw();
  }
  resize() {
    const { clientWidth, clientHeight } = byId("stage");
    if (clientWidth === 0) return;
    this.renderer.setSize(clientWidth, clientHeight, false);
    if (this.cameras.isFree) this.tell("camera");
    this.draw();
  }

  /** The capture has taken a frame. */
  advance() {
    const isRenumbered = this.capture.isRenumbered;
    this.cursor.advance();
    if (isRenumbered && this.chosen) this.chosen.row = this.capture.bodies.number.indexOf(this.chosen.number);
    this.widen();
    this.draw();
  }
  /** Scales of colours, and how far the camera sees, grow with what was seen. */
  widen() {
    const { cursor, scales } = this;
    const old = JSON.stringify(scales);
    let fastest = 0;
    for (const row of cursor.rows) {
      if (cursor.speed[row] > fastest) fastest = cursor.speed[row];
      const band = cursor.priority[row];
      if (band > 0) scales.bands = [Math.min(scales.bands[0], band), Math.max(scales.bands[1], band)];
      if (cursor.level[row] === 8) scales.polygons = true;
      else scales.levels = Math.max(scales.levels, cursor.level[row]);
    }
    if (fastest > scales.topSpeed) scales.topSpeed = 1.2 * fastest;
    if (this.coloring && JSON.stringify(scales) === old) return;
    this.coloring = new Coloring(scales.bands[0] <= scales.bands[1] ? scales : { ...scales, bands: [1, 1] });
    this.showLegend();
    const now = boundsNow({ file: this.capture, cursor });
    if (now.radius > this.cameras.bounds.radius) this.cameras.bounds = now;
  }
  showLegend() {
    if (this.coloring) byId("colors").replaceChildren(...this.coloring.legend(byId("color").value));
  }

  draw() {
    if (this.isWaiting) return;
    this.isWaiting = true;
    requestAnimationFrame(() => {
      if (this.isWaiting) this.drawNow();
    });
  }
  drawNow() {
    this.isWaiting = false;
    const size = this.renderer.getSize(new Vector2());
    if (size.x < 2) return;
    const { capture, cursor } = this;
    if (!this.coloring) this.widen();
    const rows = capture.bodies.number.length;
    if (this.colors.length < 3 * rows) this.colors = new Uint8Array(6 * rows);
    this.bodies.reserve(rows);
    this.cameras.prepare(this.camera, size.x / size.y);
    const { camera } = this.cameras;
    aimLight(this.light, this.up, camera);
    this.coloring.fill(byId("color").value, cursor, this.colors, {});
    const ratio = this.renderer.getPixelRatio();
    this.bodies.update(cursor, camera, showOf(byId("show").value), this.colors, size.x * ratio, size.y * ratio);
    this.renderer.render(this.scene, camera);
    this.tellIfMoved();
    this.placeGaze(size.x, size.y);
    this.showChosen(size.x, size.y);
    this.showBadge();
    ++this.pictures;
  }

  /** Tells the run with the next picture: the camera, the gaze, or both. */
  tell(...what) {
    this.untold = new Set([...(this.untold ?? []), ...what]);
    this.draw();
  }
  tellIfMoved() {
    const { camera } = this.cameras;
    const place = this.cameras.isFree ? [...camera.matrixWorld.elements, camera.fov, camera.aspect].join() : "scene";
    if (this.toldPlace !== undefined && place !== this.toldPlace) this.tell("camera", "gaze");
    this.toldPlace = place;
    if (!this.untold || this.untold.size === 0) return;
    const view = {};
    if (this.untold.has("camera")) view.camera = this.cameras.isFree ? this.cameraNow() : null;
    if (this.untold.has("gaze")) view.gaze = this.pointer ? this.gazeNow() : null;
    this.untold.clear();
    this.look(view);
  }
  cameraNow() {
    const { camera } = this.cameras;
    return {
      position_m: camera.position.toArray(),
      forward: camera.getWorldDirection(new Vector3()).toArray(),
      up: new Vector3(0, 1, 0).applyQuaternion(camera.quaternion).toArray(),
      vertical_fov_rad: (camera.fov * Math.PI) / 180,
      aspect: camera.aspect,
    };
  }
  /** The direction under the pointer. */
  gazeNow() {
    return this.rayAt(...this.pointer).direction.toArray();
  }

  /** The ring where the run's gaze is, as it says itself. */
  placeGaze(width, height) {
    const ring = byId("gaze");
    const view = this.camera;
    ring.hidden = !view || !byId("show-gaze").checked;
    if (ring.hidden) return;
    const eye = new Vector3(...view.position_m);
    const gaze = new Vector3(...view.gaze);
    const away = Math.max(0.1, this.bounds.center.clone().sub(eye).dot(gaze));
    placeRing(ring, eye.addScaledVector(gaze, away), this.cameras.camera, width, height);
  }

  /** The ray into the picture at a point of the canvas. */
  rayAt(x, y) {
    const { clientWidth, clientHeight } = this.canvas;
    return rayThrough(this.cameras.camera, (2 * x) / clientWidth - 1, 1 - (2 * y) / clientHeight);
  }
  /** Chooses the body at a point of the canvas, or none. */
  pickAt(x, y) {
    const hit = bodyAt(this.rayAt(x, y), { ...this, file: this.capture }, showOf(byId("show").value));
    this.chosen = hit ? { number: this.capture.bodies.number[hit.row], row: hit.row } : null;
    this.draw();
  }
  /** That under the pointer; without one that in the middle of the picture. */
  pickAtGaze() {
    this.pickAt(...(this.pointer ?? [0.5 * this.canvas.clientWidth, 0.5 * this.canvas.clientHeight]));
  }
  closeFacts() {
    this.chosen = null;
    this.draw();
  }
  /** The ring around the chosen body, and what the frames tell of it. */
  showChosen(width, height) {
    const { capture: file, cursor, chosen } = this;
    const ring = byId("chosen");
    ring.hidden = !chosen || chosen.row < 0 || !cursor.has(chosen.row);
    if (!ring.hidden) placeBodyRing(ring, { cursor, file, row: chosen.row }, this.cameras.camera, width, height);
    if (this.factsTimer && chosen?.number === this.toldNumber) return;
    this.tellFacts();
  }
  /** Now, and once more when they have been there long enough to be read and a frame has come meanwhile. */
  tellFacts() {
    const { capture: file, cursor, chosen } = this;
    clearTimeout(this.factsTimer);
    this.factsTimer = 0;
    showFacts(chosen && { file, cursor, ...chosen }, () => this.closeFacts());
    this.toldNumber = chosen?.number;
    if (!chosen) return;
    const { frame } = cursor.facts;
    this.factsTimer = setTimeout(() => {
      this.factsTimer = 0;
      if (cursor.facts.frame !== frame) this.tellFacts();
    }, kFacts_ms);
  }

  showBadge() {
    const { facts } = this.cursor;
    const badge = byId("late-badge");
    badge.hidden = facts.cause === 0;
    if (!badge.hidden) badge.textContent = `late by ${milliseconds(facts.lateness_ms)}: ${kCauses[facts.cause - 1]}`;
  }
}
