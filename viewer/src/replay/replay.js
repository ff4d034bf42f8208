// SPDX-License-Identifier: MIT
import { Color, Ray, Scene, Vector2, Vector3 } from "three";

import { FrameCursor } from "../capture/frame_cursor.js";
import { findContactStates, findSeenErrors, kNoPairs } from "../capture/pairs.js";
import { kCauseText } from "../data/frames.js";
import { byId, element, fillSelect } from "../elements.js";
import { milliseconds } from "../format.js";
import { BodyLayer, kHardware, kSoftware } from "./body_layer.js";
import { Cameras } from "./cameras.js";
import { Coloring, kColorings, scalesOf } from "./coloring.js";
import { showFacts } from "./facts.js";
import { CoarsePairsLayer, FrustumLayer } from "./overlays.js";
import { bodyAt, listenForClicks, rayThrough } from "./picking.js";
import { aimLight, makeRenderer, placeBodyRing, placeRing, showChoices, showOf, upOf } from "./picture.js";
import { makeLight } from "./shaders.js";
import { Visibility } from "./visibility.js";
import { boundsNow, boundsOf, ContactLayer, PlaneLayer } from "./stage_geometry.js";

/** One capture in the picture: its frame, its bodies and what stands around them. */
class View {
  constructor(file, light, limits, bounds) {
    this.file = file;
    this.cursor = new FrameCursor(file);
    this.scene = new Scene();
    this.colors = new Uint8Array(3 * file.bodies.number.length);
    this.bodies = new BodyLayer(file, this.scene, light, limits);
    this.planes = new PlaneLayer(file, this.cursor, this.scene, bounds);
    const sizes = file.shapes
      .filter((shape) => shape.kind !== "plane")
      .map((shape) => shape.radius_m)
      .sort((a, b) => a - b);
    this.contacts = new ContactLayer(this.scene, 0.5 * (sizes[sizes.length >> 1] ?? 1));
    this.frustum = new FrustumLayer(this.scene);
    this.coarse = new CoarsePairsLayer(this.scene, file);
    this.visibility = new Visibility(this.colors.length / 3, (row) => this.bodies.plain[file.bodies.shape[row]]);
    this.seenErrors = new Float32Array(file.hasPairs ? file.bodies.number.length : 0);
    this.contactStates = new Uint8Array(this.seenErrors.length);
    this.rowOfNumber = new Map(file.bodies.number.map((number, row) => [number, row]));
  }
  /** What is known of the pairs of the shown frame. */
  get pairs() {
    return this.file.pairsOf(this.cursor.facts?.frame);
  }
}

export class Replay {
  constructor({ store, frames, late, files, names }) {
    Object.assign(this, { store, frames, files, names });
    this.canvas = byId("view");
    this.lateAt = new Map(late.map((miss) => [miss.index, miss]));
    Object.assign(this, makeRenderer(this.canvas));
    this.renderer.autoClear = false;
    this.light = makeLight();
    const looking = new FrameCursor(files[0]);
    this.bounds = boundsOf(files[0], looking);
    this.coloring = new Coloring(scalesOf(files[0], looking));
    this.views = files.map((file) => new View(file, this.light, this.software ? kSoftware : kHardware, this.bounds));
    this.cameras = new Cameras(this.canvas, this.bounds, upOf(files[0].head.gravity_mps2), {
      changed: () => this.draw(),
      taken: () => this.choose("camera", "free"),
    });
    this.chosen = null;
    this.pictures = 0;
    this.drawing_ms = 0;
    this.fillControls();
    this.listen();
    this.setTheme();
  }

  fillControls() {
    fillSelect(byId("show"), showChoices(this.files.flatMap((file) => file.shapes)), "shapes");
    const colors = { ...kColorings };
    if (this.files.length < 2) delete colors.difference;
    const hasPairs = this.files.some((file) => file.hasPairs);
    if (!hasPairs) {
      delete colors.seen;
      delete colors.contact;
    }
    const hasCamera = this.files[0].frames.some((facts) => facts.camera);
    if (!this.files.every((file) => file.frames.every((facts) => facts.camera))) delete colors.visibility;
    fillSelect(byId("color"), colors, this.files.length < 2 ? "level" : "difference");
    fillSelect(
      byId("camera"),
      { ...(hasCamera ? { scene: "of the scene" } : {}), free: "free", all: "all in view" },
      hasCamera ? "scene" : "free",
    );
    byId("show-contacts").disabled = !this.files.some((file) => file.head.contacts);
    byId("show-contacts").parentElement.title = byId("show-contacts").disabled
      ? "This capture lists no contact points (--capture-contacts)"
      : "";
    byId("show-gaze").disabled = byId("show-frustum").disabled = !hasCamera;
    byId("show-coarse").disabled = !hasPairs;
    byId("show-coarse").parentElement.title = hasPairs
      ? "Lines between bodies whose pair did not reach its last level, in the colour of the level (L)"
      : "This capture lists no pairs (--capture-pairs)";
    byId("views").replaceChildren(
      ...(this.files.length < 2
        ? []
        : this.files.map((file, k) => element("div", {}, this.names[k] ?? file.head.scene))),
    );
    this.cameras.setFree(!hasCamera, null);
  }

  listen() {
    for (const id of ["show", "color", "camera", "show-contacts", "show-gaze", "show-frustum", "show-coarse"])
      byId(id).addEventListener("change", () => this.changed(id));
    this.store.on("row", () => this.draw());
    this.store.on("theme", () => this.setTheme());
    new ResizeObserver(() => this.resize()).observe(byId("stage"));
    listenForClicks(this.canvas, (x, y) => this.pickAt(x, y));
    this.showLegend();
  }

  changed(id) {
    if (id === "camera") this.changeCamera(byId("camera").value);
    if (id === "color") this.showLegend();
    this.draw();
  }
  /** From the scene's camera to the free one and back. */
  switchCamera() {
    const isScene = byId("camera").value === "scene";
    if (isScene || byId("camera").options[0].value === "scene") this.choose("camera", isScene ? "free" : "scene");
  }
  changeCamera(value) {
    this.cameras.setFree(value !== "scene", this.camera());
    if (value !== "all") return;
    this.cameras.lookAtAll(boundsNow(this.views[0]));
    byId("camera").value = "free";
  }
  choose(id, value) {
    byId(id).value = value;
    this.changed(id);
  }
  /** The next choice of a list, around its end. */
  next(id) {
    const select = byId(id);
    this.choose(id, select.options[(select.selectedIndex + 1) % select.options.length].value);
  }
  toggle(id) {
    const box = byId(id);
    if (box.disabled) return;
    box.checked = !box.checked;
    this.changed(id);
  }
  closeFacts() {
    this.chosen = null;
    this.draw();
  }
  showLegend() {
    byId("colors").replaceChildren(...this.coloring.legend(byId("color").value));
  }
  setTheme() {
    const isDark = this.store.get("theme") === "dark";
    const style = getComputedStyle(document.documentElement);
    this.renderer.setClearColor(new Color(style.getPropertyValue("--stage").trim()));
    for (const view of this.views) view.planes.setTheme(isDark);
    this.draw();
  }
  resize() {
    const stage = byId("stage");
    if (stage.clientWidth === 0) return;
    this.renderer.setSize(stage.clientWidth, stage.clientHeight, false);
    this.drawNow();
  }

  /** The view of the shown frame; null without a camera. */
  camera() {
    return this.views[0].cursor.facts?.camera ?? null;
  }
  show() {
    return showOf(byId("show").value);
  }

  /** Draws with the next picture of the screen. */
  draw() {
    if (this.isWaiting) return;
    this.isWaiting = true;
    requestAnimationFrame(() => {
      if (this.isWaiting) this.drawNow();
    });
  }

  drawNow() {
    const began = performance.now();
    this.isWaiting = false;
    const size = this.renderer.getSize(new Vector2());
    if (size.x < 2) return;
    const row = this.store.get("row");
    this.seek(row);
    const width = size.x / this.views.length;
    const ratio = this.renderer.getPixelRatio();
    this.cameras.prepare(this.camera(), width / size.y);
    const { camera } = this.cameras;
    aimLight(this.light, upOf(this.files[0].head.gravity_mps2), camera);
    this.renderer.setScissorTest(true);
    const mode = byId("color").value;
    this.views.forEach((view, k) => {
      view.cursor.countStill(mode === "clock");
      if (mode === "seen" && view.file.hasPairs) findSeenErrors(view.pairs, view.seenErrors);
      if (mode === "contact" && view.file.hasPairs) findContactStates(view.pairs, view.contactStates);
      if (mode === "visibility") view.visibility.find(view.cursor, view.cursor.facts.camera);
      this.coloring.fill(mode, view.cursor, view.colors, {
        differenceOf: (body) => this.difference_m(view, body),
        seenErrors: view.seenErrors,
        contactStates: view.contactStates,
        visibility: view.visibility.of,
      });
      view.bodies.update(view.cursor, camera, this.show(), view.colors, width * ratio, size.y * ratio);
      view.contacts.update(this.contactsOf(view), byId("show-contacts").checked);
      this.updateOverlays(view);
      this.renderer.setViewport(k * width, 0, width, size.y);
      this.renderer.setScissor(k * width, 0, width, size.y);
      this.renderer.clear();
      this.renderer.render(view.scene, camera);
    });
    this.placeGaze(width, size.y);
    this.placeChosen(width, size.y);
    this.showBadge(row);
    this.showChosen();
    this.drawing_ms = performance.now() - began;
    this.shownRow = row;
    ++this.pictures;
  }

  showChosen() {
    const { view, row } = this.chosen ?? {};
    const body = view ? { row, cursor: view.cursor, file: view.file, pairs: view.pairs } : null;
    showFacts(body, () => this.closeFacts());
  }

  /** What the camera of the scene sees, and the pairs that were left coarse. */
  updateOverlays(view) {
    const facts = this.camera();
    const away = facts ? this.bounds.center.distanceTo(new Vector3(...facts.position_m)) : 1;
    view.frustum.update(facts, away, this.cameras.isFree && byId("show-frustum").checked);
    const isShown = byId("show-coarse").checked && view.file.hasPairs;
    const only = this.chosen?.view === view ? this.chosen.row : -1;
    const up = upOf(view.file.head.gravity_mps2);
    view.coarse.update(
      view.cursor,
      isShown ? view.pairs : kNoPairs,
      (level) => this.coloring.levelColors[level + 1],
      up,
      only,
      isShown,
    );
  }

  /** All captures to the time of a row. */
  seek(row) {
    const steps = this.frames.column("frame")[row] + 1;
    const time_s = this.frames.column("time_s")[row];
    this.views.forEach((view, k) => {
      const wanted = k === 0 ? steps : Math.round(time_s / view.file.head.dt_s);
      view.cursor.seek(view.file.indexAt(wanted));
    });
  }

  /** How far the same body is away in the other capture; NaN where it is not there. */
  difference_m(view, row) {
    const other = this.views.find((candidate) => candidate !== view);
    const there = other?.rowOfNumber.get(view.file.bodies.number[row]);
    if (there === undefined || !other.cursor.has(there)) return NaN;
    const a = view.cursor.position,
      b = other.cursor.position;
    return Math.hypot(a[3 * row] - b[3 * there], a[3 * row + 1] - b[3 * there + 1], a[3 * row + 2] - b[3 * there + 2]);
  }

  /** Those of the chosen body, or all. */
  contactsOf(view) {
    const { contacts } = view.cursor;
    if (this.chosen?.view !== view) return contacts;
    return contacts.filter(({ a, b }) => a === this.chosen.row || b === this.chosen.row);
  }

  /** Puts a ring around the chosen body. */
  placeChosen(width, height) {
    const ring = byId("chosen");
    const { view, row } = this.chosen ?? {};
    ring.hidden = !view || !view.cursor.has(row);
    if (ring.hidden) return;
    const left = this.views.indexOf(view) * width;
    placeBodyRing(ring, { ...view, row }, this.cameras.camera, width, height, left);
  }

  /** The ray into the picture at a point of the canvas, and the view that it is in. */
  rayAt(x, y) {
    const { clientWidth, clientHeight } = this.canvas;
    const width = clientWidth / this.views.length;
    const number = Math.min(this.views.length - 1, Math.floor(x / width));
    const ray = rayThrough(this.cameras.camera, 2 * ((x - number * width) / width) - 1, 1 - (2 * y) / clientHeight);
    return { view: this.views[number], ray };
  }
  pickAt(x, y) {
    const { view, ray } = this.rayAt(x, y);
    this.pick(view, ray);
  }
  /** The body that the gaze meets; without a gaze the one in the middle of the picture. */
  pickAtGaze() {
    const facts = this.camera();
    const isGaze = facts && !byId("gaze").hidden;
    const ray = isGaze
      ? new Ray(new Vector3(...facts.position_m), new Vector3(...facts.gaze).normalize())
      : rayThrough(this.cameras.camera, 0, 0);
    this.pick(this.views[0], ray);
  }
  pick(view, ray) {
    const hit = bodyAt(ray, view, this.show());
    this.chosen = hit ? { view, row: hit.row } : null;
    this.draw();
  }

  /** Puts the ring where the gaze meets the first body, or as far as the bodies are. */
  placeGaze(width, height) {
    const ring = byId("gaze");
    const facts = this.camera();
    ring.hidden = !facts || !byId("show-gaze").checked;
    if (ring.hidden) return;
    const eye = new Vector3(...facts.position_m);
    const direction = new Vector3(...facts.gaze).normalize();
    // Spheres of the coarsest level are near enough for a ring, and quick.
    const hit = bodyAt(new Ray(eye, direction), this.views[0], 0);
    const away = hit?.distance ?? Math.max(0.1, this.bounds.center.clone().sub(eye).dot(direction));
    placeRing(ring, eye.addScaledVector(direction, away), this.cameras.camera, width, height);
  }

  showBadge(row) {
    const miss = this.lateAt.get(row);
    const badge = byId("late-badge");
    badge.hidden = !miss;
    if (!miss) return;
    badge.textContent = `late by ${milliseconds(miss.late_ms)}: ${miss.cause}`;
    badge.title = kCauseText[miss.cause] ?? "";
  }
}

/** The replay of the captures; null where the browser draws no 3D. */
export function startReplay(settings) {
  try {
    return new Replay(settings);
  } catch (failure) {
    const place = byId("problem");
    place.hidden = false;
    place.textContent = `No replay: ${failure.message}`;
    return null;
  }
}
