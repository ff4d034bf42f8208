// SPDX-License-Identifier: MIT
// Colours that people with impaired colour vision tell apart: Okabe and Ito (2008) for kinds, viridis (Smith and van der
// Walt 2015) for amounts.

export const kStageColor = {
  predict: "#56b4e9",
  broad_phase: "#0072b2",
  coarse: "#cc79a7",
  refine: "#009e73",
  manifolds: "#f0e442",
  solve: "#e69f00",
  integrate: "#8c8c8c",
  publish: "#c4c4c4",
};

/** A shape beside the colour, so that a cause is known without seeing colours. */
export const kCauseMark = {
  infeasible: { color: "#d55e00", shape: "triangle" },
  machine: { color: "#7a7a7a", shape: "square" },
  overrun: { color: "#cc79a7", shape: "diamond" },
  forecast: { color: "#0072b2", shape: "circle" },
  release: { color: "#e69f00", shape: "cross" },
};

export const kStateColor = {
  moving: "#56b4e9",
  asleep: "#7a7a7a",
  waiting: "#e69f00",
  paused: "#cc79a7",
  static: "#b8bdc4",
  kinematic: "#009e73",
};

/** Seen, hidden, outside the picture. */
export const kVisibilityColor = ["#56b4e9", "#d55e00", "#7a7a7a"];

/** No pair near, points of an earlier frame, refined in this frame, left coarse. */
export const kContactColor = ["#9aa3ad", "#56b4e9", "#009e73", "#d55e00"];

/** Bodies whose level, priority or speed is not known or has no meaning. */
export const kNoValueColor = "#9aa3ad";

const kViridis = [
  [68, 1, 84],
  [72, 36, 117],
  [65, 68, 135],
  [53, 95, 141],
  [42, 120, 142],
  [33, 145, 140],
  [34, 168, 132],
  [68, 191, 112],
  [122, 209, 81],
  [189, 223, 38],
  [253, 231, 37],
];

/** Red, green and blue from 0 to 1 of an amount from 0 to 1. */
export function viridis(amount) {
  const at = Math.min(Math.max(amount, 0), 1) * (kViridis.length - 1);
  const low = Math.min(Math.floor(at), kViridis.length - 2);
  return kViridis[low].map((value, k) => (value + (at - low) * (kViridis[low + 1][k] - value)) / 255);
}

export const css = (rgb) => `rgb(${rgb.map((value) => Math.round(255 * value)).join(" ")})`;

/** Red, green and blue from 0 to 1 of `#rrggbb`. */
export const rgbOf = (hex) => [1, 3, 5].map((k) => parseInt(hex.slice(k, k + 2), 16) / 255);

/** Colour of a level, the root sphere darkest, the deepest of `levels` brightest. Skips the darkest tenth of the scale. */
export const levelColor = (level, levels) => viridis(levels <= 1 ? 0.5 : 0.12 + (0.88 * level) / (levels - 1));
