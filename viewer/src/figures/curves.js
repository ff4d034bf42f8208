// SPDX-License-Identifier: MIT
import { element } from "../elements.js";
import { number } from "../format.js";

// As `poise compare --svg` has them (Okabe and Ito 2008); the seventh is the colour of the text. A line also has a mark of
// its own.
const kColors = 8;
const kWidth = 620,
  kHeight = 330;
const kEdge = { left: 58, right: 128, top: 12, bottom: 42 };
const kLabelGap = 15;

const svg = (name, attributes = {}, ...children) => {
  const made = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...children);
  return made;
};

/** Round steps of which about five make up the range. */
export function ticksUpTo(most) {
  const rough = most / 6;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((factor) => factor * power).find((size) => size >= 0.999 * rough);
  const count = Math.floor(most / step + 1e-9);
  return Array.from({ length: count + 1 }, (_, k) => Number((k * step).toPrecision(12)));
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
    const values = points.flatMap(([, y, low, high]) => [y, low ?? y, high ?? y]);
    this.leastX = Math.min(0, ...this.xs);
    this.mostX = Math.max(this.xs[this.xs.length - 1] ?? 1, this.leastX + 1e-9);
    const most = Math.max(...values, 0);
    this.leastY = Math.min(...values, 0);
    this.mostY = most > 0 ? 1.06 * most : 1;
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
    return kEdge.left + ((value - this.leastX) / (this.mostX - this.leastX)) * (kWidth - kEdge.left - kEdge.right);
  }
  y(value) {
    const share = (value - this.leastY) / (this.mostY - this.leastY);
    return kHeight - kEdge.bottom - share * (kHeight - kEdge.top - kEdge.bottom);
  }

  draw() {
    const picture = svg("svg", {
      viewBox: `0 0 ${kWidth} ${kHeight}`,
      role: "img",
      tabindex: "0",
      "aria-label": `${this.chart.title}: ${this.chart.lines.map(({ label }) => label).join(", ")}. Left and right read values.`,
    });
    const right = kWidth - kEdge.right;
    for (const tick of ticksUpTo(this.mostY)) {
      picture.append(
        svg("path", { class: "grid", d: `M${kEdge.left} ${this.y(tick)}H${right}` }),
        svg("text", { x: kEdge.left - 6, y: this.y(tick) + 4, "text-anchor": "end" }, number(tick, 4)),
      );
    }
    const floor = kHeight - kEdge.bottom;
    for (const tick of ticksUpTo(this.mostX))
      picture.append(svg("text", { x: this.x(tick), y: floor + 16, "text-anchor": "middle" }, number(tick, 4)));
    picture.append(
      svg("text", { x: (kEdge.left + right) / 2, y: kHeight - 6, "text-anchor": "middle" }, this.chart.x_label),
    );
    this.cursor = svg("path", { class: "cursor", d: "" });
    picture.append(this.cursor);
    const ends = this.chart.lines.map(({ points }) => this.y(points[points.length - 1]?.[1] ?? 0));
    const heights = apart(ends, kLabelGap, kEdge.top + 6, floor);
    this.chart.lines.forEach((line, k) => picture.append(...this.lineOf(line, k, heights[k])));
    return picture;
  }

  lineOf({ label, points }, kind, labelAt) {
    const places = points.map(([x, y]) => `${this.x(x).toFixed(1)},${this.y(y).toFixed(1)}`);
    const parts = [];
    const banded = points.filter(([, , low, high]) => low !== undefined && high !== undefined);
    if (banded.length > 1) {
      const edge = (which) => banded.map((point) => `${this.x(point[0]).toFixed(1)},${this.y(point[which]).toFixed(1)}`);
      parts.push(
        svg("polygon", { class: `band line-${kind % kColors}`, points: [...edge(3), ...edge(2).reverse()].join(" ") }),
      );
    }
    parts.push(svg("polyline", { class: `curve line-${kind % kColors}`, points: places.join(" ") }));
    parts.push(...points.map(([x, y]) => markOf(kind, this.x(x), this.y(y))));
    const last = points[points.length - 1];
    if (last) {
      const end = this.x(last[0]);
      const beside = kWidth - kEdge.right + 16;
      parts.push(
        svg("path", { class: `lead line-${kind % kColors}`, d: `M${end + 5} ${this.y(last[1])}L${beside - 3} ${labelAt}` }),
        svg("text", { class: `name line-${kind % kColors}`, x: beside, y: labelAt + 4 }, label),
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
    this.cursor.setAttribute("d", `M${this.x(x)} ${kEdge.top}V${kHeight - kEdge.bottom}`);
    const values = this.chart.lines.flatMap(({ label, points }, kind) => {
      const point = points.find(([place]) => place === x);
      if (!point) return [];
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
    this.note.replaceChildren(element("b", {}, `${number(x, 5)}: `), ...values);
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
