// SPDX-License-Identifier: MIT
import { kCauseMark } from "../palette.js";

/** Adds the outline of the mark of a cause to a path of a canvas; `size` is half of its width. */
export function traceMark(context, cause, x, y, size) {
  context.beginPath();
  switch (kCauseMark[cause]?.shape) {
    case "triangle":
      context.moveTo(x - size, y - size);
      context.lineTo(x + size, y - size);
      context.lineTo(x, y + size);
      break;
    case "diamond":
      context.moveTo(x, y - size);
      context.lineTo(x + size, y);
      context.lineTo(x, y + size);
      context.lineTo(x - size, y);
      break;
    case "circle":
      context.arc(x, y, size, 0, 2 * Math.PI);
      break;
    case "cross": {
      const arm = size / 3;
      context.rect(x - arm, y - size, 2 * arm, 2 * size);
      context.rect(x - size, y - arm, 2 * size, 2 * arm);
      break;
    }
    default:
      context.rect(x - 0.85 * size, y - 0.85 * size, 1.7 * size, 1.7 * size);
  }
  context.closePath();
}

/** Draws it, with an edge that sets it off from what is behind. */
export function drawMark(context, cause, x, y, size, edge) {
  traceMark(context, cause, x, y, size);
  context.fillStyle = kCauseMark[cause]?.color ?? "#7a7a7a";
  context.fill();
  context.strokeStyle = edge;
  context.lineWidth = 1;
  // A dashed line may have been drawn before.
  context.setLineDash([]);
  context.stroke();
}

/** The mark as a small canvas element, for legends. */
export function markElement(cause) {
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = 24;
  canvas.className = "mark";
  drawMark(canvas.getContext("2d"), cause, 12, 12, 9, "transparent");
  return canvas;
}
