// SPDX-License-Identifier: MIT
import { PerspectiveCamera, Vector3 } from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";

/** The camera of the picture: that of the scene, or one that is turned by hand. */
export class Cameras {
  /** @param {() => void} changed called when the hand moves the camera @param {() => void} taken called when it begins to */
  constructor(canvas, bounds, up, { changed, taken }) {
    this.bounds = bounds;
    this.camera = new PerspectiveCamera(50, 1, 0.01, 1000);
    this.camera.up.copy(up);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.addEventListener("change", () => this.isFree && changed());
    this.isFree = true;
    this.fromScene = null;
    const take = () => {
      if (!this.isFree) taken();
    };
    // Before the controls see it, so that they turn from where the camera of the scene stood.
    canvas.parentElement.addEventListener("pointerdown", (event) => event.target === canvas && take(), {
      capture: true,
    });
    canvas.parentElement.addEventListener("wheel", (event) => event.target === canvas && take(), { capture: true });
    this.lookAtAll();
  }

  /** Stands where a ball around the bodies is seen. */
  lookAtAll({ center, radius } = this.bounds) {
    const up = this.camera.up;
    const aside = new Vector3(0.62, -0.9, 0.55);
    if (Math.abs(up.z) < 0.9) aside.set(0.8, 0.5, 0.9);
    this.camera.position.copy(center).addScaledVector(aside.normalize(), 2.4 * radius);
    this.camera.fov = 50;
    this.controls.target.copy(center);
    this.controls.update();
  }

  /** `facts`: the view of a frame, or null. */
  setFree(isFree, facts) {
    if (isFree === this.isFree) return;
    this.isFree = isFree;
    this.controls.enabled = isFree;
    if (!isFree || !facts) return;
    // Goes on from the camera of the scene, about the point in its middle that is as far as the bodies.
    const eye = new Vector3(...facts.position_m);
    const forward = new Vector3(...facts.forward);
    const away = Math.max(0.3 * this.bounds.radius, this.bounds.center.clone().sub(eye).dot(forward));
    this.camera.position.copy(eye);
    this.controls.target.copy(eye).addScaledVector(forward, away);
    this.controls.update();
  }

  /** Ready for a picture of this shape. */
  prepare(facts, aspect) {
    const { camera, bounds } = this;
    camera.aspect = aspect;
    if (!this.isFree && facts) {
      camera.position.set(...facts.position_m);
      const up = camera.up.clone();
      camera.up.set(...facts.up);
      camera.lookAt(new Vector3(...facts.position_m).add(new Vector3(...facts.forward)));
      camera.up.copy(up);
      // All that the scene's camera sees is in the picture, whatever its shape.
      const half = Math.tan(facts.vertical_fov_rad / 2) * Math.max(1, facts.aspect / aspect);
      camera.fov = (2 * Math.atan(half) * 180) / Math.PI;
    }
    const away = camera.position.distanceTo(bounds.center);
    camera.near = Math.max(1e-3 * bounds.radius, 0.05 * (away - 3 * bounds.radius), 1e-4);
    camera.far = away + 6 * bounds.radius;
    camera.updateProjectionMatrix();
    camera.updateMatrixWorld();
  }
}
