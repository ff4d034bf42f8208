// SPDX-License-Identifier: MIT
import { kMostStill, kStates, priorityOfBand } from "../capture/frame_cursor.js";
import { kContactStates } from "../capture/pairs.js";
import { element } from "../elements.js";
import { number } from "../format.js";
import { css, kContactColor, kNoValueColor, kStateColor, kVisibilityColor, levelColor, rgbOf, viridis } from "../palette.js";
import { kVisibility } from "./visibility.js";

export const kColorings = {
  level: "level reached",
  priority: "priority",
  speed: "speed",
  state: "state",
  clock: "clock",
  visibility: "seen or hidden",
  seen: "error still seen",
  contact: "contact state",
  difference: "difference",
};

const kGrey = rgbOf(kNoValueColor);
const kStatic = rgbOf(kStateColor.static);
// Chosen: a tenth of a millimetre, which no one sees, to a metre.
const kLeastDifference_m = 1e-4,
  kMostDifference_m = 1;

// Chosen: a tenth of a minute of arc, which no one sees, to a degree.
const kMinute_rad = Math.PI / 180 / 60;
const kLeastSeen_rad = 0.1 * kMinute_rad,
  kMostSeen_rad = 60 * kMinute_rad;
const kAsleep = 3;

const share = (value, least, most) => Math.log(value / least) / Math.log(most / least);

/** Colours for the bodies of a run, with scales that stay the same over all frames. */
export class Coloring {
  /** @param {{levels: number, topSpeed: number, bands: number[]}} scales */
  constructor(scales) {
    this.scales = scales;
    this.stateColors = kStates.map((state) => rgbOf(kStateColor[state]));
    this.visibilityColors = kVisibilityColor.map(rgbOf);
    this.contactColors = kContactColor.map(rgbOf);
    this.bandColors = Array.from({ length: 256 }, (_, band) => (band === 0 ? kGrey : viridis(this.bandShare(band))));
    const steps = scales.levels + (scales.polygons ? 1 : 0);
    this.levelColors = Array.from({ length: 9 }, (_, level) =>
      level === 0 ? kGrey : levelColor(Math.min(level, steps) - 1, steps),
    );
  }
  bandShare(band) {
    const [least, most] = this.scales.bands;
    return most > least ? (band - least) / (most - least) : 0.5;
  }

  /**
   * Fills red, green and blue of each row of the frame. `facts`: `differenceOf` a row, `seenErrors`, `contactStates` and
   * `visibility` of all, each asked of its own mode alone.
   */
  fill(mode, cursor, colors, facts) {
    for (const row of cursor.rows) {
      const rgb = this.colorOf(mode, cursor, row, facts);
      for (let k = 0; k < 3; ++k) colors[3 * row + k] = 255 * rgb[k] + 0.5;
    }
  }

  colorOf(mode, cursor, row, { differenceOf, seenErrors, contactStates, visibility }) {
    if (cursor.state[row] === 0) return kStatic;
    switch (mode) {
      case "level":
        return this.levelColors[cursor.level[row]];
      case "priority":
        return this.bandColors[cursor.priority[row]];
      case "speed":
        return Number.isNaN(cursor.speed[row]) ? kGrey : viridis(Math.sqrt(cursor.speed[row] / this.scales.topSpeed));
      case "clock":
        if (cursor.state[row] === kAsleep) return this.stateColors[kAsleep];
        return cursor.still[row] === 0 ? kGrey : viridis(0.25 + 0.75 * share(cursor.still[row], 1, kMostStill));
      case "visibility":
        return this.visibilityColors[visibility[row]];
      case "seen": {
        const error_rad = seenErrors?.[row] ?? NaN;
        if (Number.isNaN(error_rad)) return kGrey;
        return viridis(error_rad <= kLeastSeen_rad ? 0 : share(error_rad, kLeastSeen_rad, kMostSeen_rad));
      }
      case "contact":
        return this.contactColors[contactStates?.[row] ?? 0];
      case "difference": {
        const difference_m = differenceOf(row);
        return Number.isNaN(difference_m)
          ? kGrey
          : viridis(
              difference_m <= kLeastDifference_m ? 0 : share(difference_m, kLeastDifference_m, kMostDifference_m),
            );
      }
      default:
        return this.stateColors[cursor.state[row]];
    }
  }

  /** The legend of a colouring, as elements. */
  legend(mode) {
    const swatch = (color, label) =>
      element("span", {}, element("span", { class: "swatch", style: `background:${color}` }), label);
    const none = (label) => swatch(kNoValueColor, label);
    const scale = (from, to, least = 0) => {
      const stops = Array.from({ length: 9 }, (_, k) => css(viridis(least + ((1 - least) * k) / 8))).join(", ");
      return [from, element("span", { class: "scale", style: `background:linear-gradient(90deg, ${stops})` }), to];
    };
    const { levels, polygons, topSpeed, bands } = this.scales;
    switch (mode) {
      case "level":
        return [
          ...Array.from({ length: levels }, (_, k) => swatch(css(this.levelColors[k + 1]), `level ${k}`)),
          ...(polygons ? [swatch(css(this.levelColors[8]), "polygons")] : []),
          none("touches nothing"),
        ];
      case "priority":
        return [
          ...scale(`${number(priorityOfBand(bands[0]), 2)}`, `${number(priorityOfBand(bands[1]), 2)} rad/m`),
          none("not ranked"),
        ];
      case "speed":
        return scale("0", `${number(topSpeed, 2)} m/s`);
      case "clock":
        return [
          none("at full rate"),
          swatch(kStateColor.asleep, "asleep"),
          ...scale("waits for 1 frame", `${kMostStill} or more`, 0.25),
        ];
      case "visibility":
        return kVisibility.map((name, k) => swatch(kVisibilityColor[k], name));
      case "seen":
        return [...scale("0.1′", "60′ of arc left to be seen, estimated"), none("not ranked")];
      case "contact":
        return kContactStates.map((name, k) => swatch(kContactColor[k], name));
      case "difference":
        return [...scale("0.1 mm", "1 m apart"), none("in one run only")];
      default:
        return kStates.map((state) => swatch(kStateColor[state], state));
    }
  }
}

/** Scales for a run, from some of its frames: deepest level, a speed that few exceed, bands of priority in use. */
export function scalesOf(file, cursor) {
  const looks = 8;
  const speeds = [];
  let deepest = 1;
  let polygons = false;
  let least = 255;
  let most = 0;
  for (const facts of file.frames) {
    facts.levels.forEach((count, level) => {
      if (count > 0 && level < 7) deepest = Math.max(deepest, level + 1);
      if (count > 0 && level === 7) polygons = true;
    });
  }
  const last = file.frames.length - 1;
  for (let look = 1; look <= looks; ++look) {
    cursor.seek(Math.round((last * look) / looks));
    for (const row of cursor.rows) {
      if (cursor.speed[row] > 0) speeds.push(cursor.speed[row]);
      const band = cursor.priority[row];
      if (band > 0) {
        least = Math.min(least, band);
        most = Math.max(most, band);
      }
      if (cursor.level[row] === 8) polygons = true;
      else deepest = Math.max(deepest, cursor.level[row]);
    }
  }
  const sorted = Float32Array.from(speeds).sort();
  const topSpeed = sorted.length > 0 ? Math.max(1e-3, sorted[Math.floor(0.98 * (sorted.length - 1))]) : 1;
  return { levels: deepest, polygons, topSpeed, bands: most > 0 ? [least, most] : [1, 1] };
}
