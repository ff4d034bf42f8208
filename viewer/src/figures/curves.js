// SPDX-License-Identifier: MIT
import { element } from "../elements.js";
import { number } from "../format.js";

// As `poise compare --svg` has them (style.css; Okabe and Ito 2008). A line also has a mark of its own.
const kColors = 9;
const kWidth = 620,
  kHeight = 330;
const kLeast = 58; // of the texts left of the axes
const kTop = 12;
const kBeside = 16; // from the axes to the names
const kBelow = 42; // with one row of texts
const kLabelGap = 15,
  kLetter = 7.2; // of the names
const kTickRow = 13,
  kHalfCharacter = 3.3; // of the texts at the axes

const svg = (name, attributes = {}, ...children) => {
  const made = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...children);
  return made;
};

/** Where a value is along an axis: 0 at its least value, 1 at its most. */
export const shareOf = ({ least, most, log }, value) =>
  log ? Math.log(value / least) / Math.log(most / least) : (value - least) / (most - least);

/** In how many rows the texts of ticks stand so that none lies over its neighbour; tick k is in row k % rows. */
export function tickRows(axis, width) {
  const places = axis.ticks.map(([at, text]) => ({ x: shareOf(axis, at) * width, half: (text.length + 1) * kHalfCharacter }));
  for (let rows = 1; rows < 4; ++rows) {
    if (places.every((place, i) => i < rows || place.x - places[i - rows].x >= place.half + places[i - rows].half)) return rows;
  }
  return 4;
}

/** Heights for labels near those wanted, at least a line apart, inside of the chart. Returned in the order given. */
export function apart(wanted, gap, least, most) {
  const order = wanted.map((_, k) => k).sort((a, b) => wanted[a] - wanted[b]);
  const at = [...wanted];
  order.forEach((k, i) => (at[k] = Math.max(at[k], i === 0 ? least : at[order[i - 1]] + gap)));
  for (let i = order.length - 1; i >= 0; --i) {
    const below = i === order.length - 1 ? most : at[order[i + 1]] - gap;
    at[order[i]] = Math.min(at[order[i]], below);
  }
  return at;
}

const markOf = (kind, x, y) => {
  const place = { class: `dot line-${kind % kColors}` };
  switch (kind % 4) {
    case 0:
      return svg("circle", { ...place, cx: x, cy: y, r: 3.6 });
    case 1:
      return svg("rect", { ...place, x: x - 3.2, y: y - 3.2, width: 6.4, height: 6.4 });
    case 2:
      return svg("path", { ...place, d: `M${x} ${y - 4.4}l4.4 7.6h-8.8z` });
    default:
      return svg("path", { ...place, d: `M${x} ${y - 4.8}l4.8 4.8l-4.8 4.8l-4.8-4.8z` });
  }
};

/** Lines with their intervals as bands, and their names at their ends. Left and right go through the values along x. */
export class Curves {
  constructor(chart) {
    this.chart = chart;
    const points = chart.lines.flatMap((line) => line.points);
    this.xs = [...new Set(points.map(([x]) => x))].sort((a, b) => a - b);
    this.left = Math.max(kLeast, 14 + 2 * kHalfCharacter * Math.max(0, ...chart.y.ticks.map(([, text]) => text.length)));
    const letters = Math.max(...[...chart.lines, ...chart.levels].map(({ label }) => label.length));
    this.right = kWidth - Math.min(0.5 * kWidth, Math.max(60, kBeside + kLetter * (letters + 1)));
    this.rows = tickRows(chart.x, this.right - this.left);
    this.floor = kHeight - kBelow - (this.rows - 1) * kTickRow;
    this.at = -1;
    this.note = element("p", { class: "read", "aria-live": "polite" });
    this.picture = this.draw();
    this.element = element(
      "article",
      { class: "panel chart", id: `chart-${chart.id}` },
      element("h2", {}, chart.title),
      element("p", { class: "note" }, chart.note ?? ""),
      this.picture,
      this.note,
    );
    this.listen();
  }
  x(value) {
    return this.left + shareOf(this.chart.x, value) * (this.right - this.left);
  }
  y(value) {
    return this.floor - shareOf(this.chart.y, value) * (this.floor - kTop);
  }

  draw() {
    const picture = svg("svg", {
      viewBox: `0 0 ${kWidth} ${kHeight}`,
      role: "img",
      tabindex: "0",
      "aria-label": `${this.chart.title}: ${this.chart.lines.map(({ label }) => label).join(", ")}. Left and right read values.`,
    });
    const { right } = this;
    for (const [at, text] of this.chart.y.ticks) {
      picture.append(
        svg("path", { class: "grid", d: `M${this.left} ${this.y(at)}H${right}` }),
        svg("text", { x: this.left - 6, y: this.y(at) + 4, "text-anchor": "end" }, text),
      );
    }
    const { floor } = this;
    this.chart.x.ticks.forEach(([at, text], k) =>
      picture.append(
        svg("text", { x: this.x(at), y: floor + 16 + (k % this.rows) * kTickRow, "text-anchor": "middle" }, text),
      ),
    );
    picture.append(
      svg("text", { x: (this.left + right) / 2, y: kHeight - 6, "text-anchor": "middle" }, this.chart.x_label),
    );
    this.cursor = svg("path", { class: "cursor", d: "" });
    picture.append(this.cursor);
    const { lines, levels } = this.chart;
    const ends = lines.map(({ points }) => points.findLast(([, y]) => y !== null));
    const heights = apart(
      [...ends.map((end) => (end ? this.y(end[1]) : floor)), ...levels.map(({ y }) => this.y(y))],
      kLabelGap,
      kTop + 6,
      floor,
    );
    levels.forEach((level, k) => picture.append(...this.levelOf(level, heights[lines.length + k])));
    // No band lies over a line.
    const parts = lines.flatMap((line, k) => this.lineOf(line, k, ends[k], heights[k]));
    const isBand = (part) => part.classList.contains("band");
    picture.append(...parts.filter(isBand), ...parts.filter((part) => !isBand(part)));
    return picture;
  }

  /** A dashed line across, in the colour of the line that it belongs to. */
  levelOf({ label, y, line }, labelAt) {
    const kind = line === null ? "level" : `line-${line % kColors}`;
    const { right } = this;
    return [
      svg("path", { class: `across ${kind}`, d: `M${this.left} ${this.y(y)}H${right}` }),
      svg("text", { class: `name ${kind}`, x: right + kBeside, y: labelAt + 4 }, label),
    ];
  }

  lineOf({ label, points, marks }, kind, last, labelAt) {
    const color = `line-${kind % kColors}`;
    const place = (x, y) => `${this.x(x).toFixed(1)},${this.y(y).toFixed(1)}`;
    const parts = [];
    const banded = points.filter(([, y, low, high]) => y !== null && low !== undefined && high !== undefined);
    if (banded.length > 1) {
      const edge = (which) => banded.map((point) => place(point[0], point[which]));
      parts.push(svg("polygon", { class: `band ${color}`, points: [...edge(3), ...edge(2).reverse()].join(" ") }));
    }
    if (marks !== "dots") {
      // A gap begins anew.
      let isGap = true;
      const path = points.map(([x, y]) => {
        const step = y === null ? "" : `${isGap ? "M" : "L"}${place(x, y)}`;
        isGap = y === null;
        return step;
      });
      parts.push(svg("path", { class: `curve ${color}`, d: path.join("") }));
    }
    if (marks !== "line")
      parts.push(...points.filter(([, y]) => y !== null).map(([x, y]) => markOf(kind, this.x(x), this.y(y))));
    if (last) {
      const end = this.x(last[0]);
      const beside = this.right + kBeside;
      // Of dots the last one is no end.
      if (marks !== "dots")
        parts.push(svg("path", { class: `lead ${color}`, d: `M${end + 5} ${this.y(last[1])}L${beside - 3} ${labelAt}` }));
      parts.push(
        svg("text", { class: `name ${color}`, x: beside, y: labelAt + 4 }, label),
      );
    }
    return parts;
  }

  /** Reads the values at one of the places along x; -1: none. */
  read(at) {
    this.at = at;
    if (at < 0) {
      this.cursor.setAttribute("d", "");
      this.note.replaceChildren();
      return;
    }
    const x = this.xs[at];
    this.cursor.setAttribute("d", `M${this.x(x)} ${kTop}V${this.floor}`);
    const values = this.chart.lines.flatMap(({ label, points }, kind) => {
      const point = points.find(([place]) => place === x);
      if (!point || point[1] === null) return [];
      const [, y, low, high] = point;
      const interval = low === undefined ? "" : ` (${number(low)} to ${number(high)})`;
      return [
        element(
          "span",
          {},
          element("span", { class: `swatch line-${kind % kColors}` }),
          `${label} ${number(y, 4)}${interval}`,
        ),
      ];
    });
    const named = this.chart.x.ticks.find(([at]) => at === x)?.[1] ?? number(x, 5);
    this.note.replaceChildren(element("b", {}, `${named}: `), ...values);
  }

  listen() {
    this.picture.addEventListener("keydown", (event) => {
      const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
      if (!step) {
        if (event.key === "Escape") this.read(-1);
        return;
      }
      event.preventDefault();
      this.read(Math.min(Math.max(this.at + step, 0), this.xs.length - 1));
    });
    this.picture.addEventListener("pointermove", (event) => {
      const box = this.picture.getBoundingClientRect();
      const wanted = ((event.clientX - box.left) / box.width) * kWidth;
      const away = this.xs.map((x) => Math.abs(this.x(x) - wanted));
      this.read(away.indexOf(Math.min(...away)));
    });
    this.picture.addEventListener("pointerleave", () => this.read(-1));
  }
}
