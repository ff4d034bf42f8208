// SPDX-License-Identifier: MIT

const kCell_px = 16;
/** Balls that cover a cell so many times leave e^-5 of it free, if they lie at random. Chosen. */
const kLayers = 5;

/**
 * Finds small bodies that are hidden by many others, so that a machine without a graphics processor need not draw them: the
 * picture is divided into cells, and a cell that is covered several times hides what lies farther.
 */
export class CrowdedCells {
  begin(camera, width, height) {
    this.width = width;
    this.height = height;
    this.columns = Math.ceil(width / kCell_px);
    this.rows = Math.ceil(height / kCell_px);
    const count = this.columns * this.rows;
    if (this.covered?.length !== count) {
      this.covered = new Float32Array(count);
      this.farthest = new Float32Array(count);
    }
    this.covered.fill(0);
    this.farthest.fill(0);
    this.matrix = camera.projectionMatrix.clone().multiply(camera.matrixWorldInverse).elements;
    this.focal_px = 0.5 * height * camera.projectionMatrix.elements[5];
  }

  /** Whether a ball is hidden; if not, it hides others from now on. Balls come from the largest in the picture down. */
  hides(x, y, z, radius) {
    const m = this.matrix;
    const away = m[3] * x + m[7] * y + m[11] * z + m[15];
    const radius_px = (radius * this.focal_px) / away;
    if (!(away > 0)) return false;
    const at_x = (0.5 + (0.5 * (m[0] * x + m[4] * y + m[8] * z + m[12])) / away) * this.width;
    const at_y = (0.5 - (0.5 * (m[1] * x + m[5] * y + m[9] * z + m[13])) / away) * this.height;
    // The square inside of a ball; a small one counts where its middle is.
    const reach = Math.max(0, 0.7 * radius_px - 0.5 * kCell_px);
    const first = this.column(at_x - reach),
      last = this.column(at_x + reach);
    const top = this.row(at_y - reach),
      bottom = this.row(at_y + reach);
    if (reach === 0) {
      const cell = top * this.columns + first;
      if (this.covered[cell] >= kLayers && away > this.farthest[cell]) return true;
    }
    const share = Math.min(1, (Math.PI * radius_px * radius_px) / (kCell_px * kCell_px));
    for (let row = top; row <= bottom; ++row) {
      for (let column = first; column <= last; ++column) {
        const cell = row * this.columns + column;
        this.covered[cell] += share;
        this.farthest[cell] = Math.max(this.farthest[cell], away);
      }
    }
    return false;
  }
  column(x) {
    return Math.min(this.columns - 1, Math.max(0, Math.floor(x / kCell_px)));
  }
  row(y) {
    return Math.min(this.rows - 1, Math.max(0, Math.floor(y / kCell_px)));
  }
}
