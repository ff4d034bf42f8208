// SPDX-License-Identifier: MIT
import uPlot from "uplot";

import { element } from "../elements.js";

/** The colours of the page as they are now. */
export function pageColors() {
  const style = getComputedStyle(document.documentElement);
  const read = (name) => style.getPropertyValue(name).trim();
  return {
    text: read("--text"),
    faint: read("--faint"),
    grid: read("--grid"),
    panel: read("--panel"),
    late: read("--late"),
    ink: read("--ink"),
  };
}

const kFont = "11px system-ui, sans-serif";

/** An axis in the colours of the page. */
export const axis = (colors, more = {}) => ({
  stroke: colors.faint,
  font: kFont,
  grid: { stroke: colors.grid, width: 1 },
  ticks: { stroke: colors.grid, width: 1, size: 4 },
  ...more,
});

/** The width of an axis beside a chart: enough for its longest text, and at least so many pixels. */
export const roomFor = (least) => (u, texts) =>
  Math.max(least, 14 + 6.4 * Math.max(0, ...(texts ?? []).map((text) => String(text ?? "").length)));

/** 1, 2 and 5 of each power of ten in a range, or the powers alone where it is wide. */
export function roundValues(u, axisNumber, least, most) {
  const factors = most / least > 300 ? [1] : [1, 2, 5];
  const values = [];
  for (let power = Math.floor(Math.log10(least)); power <= Math.ceil(Math.log10(most)); ++power)
    values.push(...factors.map((factor) => Number(`${factor}e${power}`)));
  return values.filter((value) => value >= least && value <= most);
}

/**
 * A chart in a panel of its own: heading, sentence, legend and plot. It is made anew when the theme or its width changes.
 * @param {{id: string, title: string, note?: string, legend?: {label: string, color?: string, mark?: Node, name?: string}[],
 *   height: number, plot: (colors: any) => {options: any, data: any[]}, rowAt: (u: any, left: number) => number,
 *   xOfRow: (row: number) => number, valuesAt?: (row: number) => Record<string, string>, follows?: boolean}} description
 *   rowAt: the row of the table under the pointer, -1 for none; follows: its x axis is that of the frames
 */
export function createChart(description, store) {
  const plot = element("div", {
    class: "plot",
    tabindex: "0",
    role: "img",
    "aria-label": `${description.title}. ${description.note ?? ""}`,
  });
  const values = new Map();
  const legend = element("ul", { class: "legend" });
  for (const item of description.legend ?? []) {
    const swatch = item.mark ?? element("span", { class: "swatch", style: `background:${item.color}` });
    const value = element("span", { class: "value" });
    if (item.name) values.set(item.name, value);
    legend.append(element("li", { title: item.title ?? "" }, swatch, item.label, value));
  }
  const note = element("p", { class: "note" }, description.note ?? "");
  const panel = element(
    "section",
    { class: "panel chart", id: `chart-${description.id}` },
    element("h2", {}, description.title),
    note,
    legend,
    plot,
  );
  const line = element("div", { class: "now" });
  let chart = null;
  let isZooming = false;

  const placeLine = () => {
    if (!chart) return;
    const x = description.xOfRow(store.get("row"));
    const left = chart.valToPos(x, "x");
    const inside = Number.isFinite(left) && left >= 0 && left <= chart.over.clientWidth;
    line.style.display = inside ? "block" : "none";
    if (inside) line.style.transform = `translateX(${left}px)`;
  };
  const showValues = () => {
    const shown = description.valuesAt?.(store.get("row")) ?? {};
    for (const [name, cell] of values) cell.textContent = shown[name] ?? "";
  };
  const follow = (u) => {
    const { left } = u.cursor;
    if (left === undefined || left < 0) return;
    const row = description.rowAt(u, left);
    if (row >= 0) store.set("row", row);
  };
  const zoomed = (u, scale) => {
    if (scale !== "x" || isZooming || !description.follows || !Number.isFinite(u.scales.x.min)) return;
    store.set("zoom", `${u.scales.x.min} ${u.scales.x.max}`);
  };
  const make = () => {
    chart?.destroy();
    const { options, data } = description.plot(pageColors());
    chart = new uPlot(
      {
        width: Math.max(160, plot.clientWidth),
        height: description.height,
        legend: { show: false },
        cursor: { y: false, x: false, points: { show: false }, drag: { x: true, y: false, setScale: true } },
        padding: [8, 10, 0, 0],
        ...options,
        hooks: {
          ...options.hooks,
          setCursor: [follow],
          setScale: [zoomed],
          draw: [...(options.hooks?.draw ?? []), placeLine],
        },
      },
      data,
      plot,
    );
    chart.over.append(line);
    if (description.follows && store.get("zoom")) applyZoom(store.get("zoom"));
  };
  const applyZoom = (text) => {
    if (!chart || !description.follows) return;
    const [min, max] = text.split(" ").map(Number);
    if (chart.scales.x.min === min && chart.scales.x.max === max) return;
    isZooming = true;
    chart.batch(() => chart.setScale("x", { min, max }));
    isZooming = false;
  };
  store.on("row", () => {
    placeLine();
    showValues();
  });
  store.on("zoom", applyZoom);
  store.on("theme", make);
  let width = 0;
  new ResizeObserver(() => {
    if (plot.clientWidth === width || plot.clientWidth === 0) return;
    width = plot.clientWidth;
    if (chart) chart.setSize({ width, height: description.height });
    else make();
  }).observe(plot);
  showValues();
  return {
    panel,
    chart: () => chart,
    zoom: description.follows ? (factor) => zoomBy(factor, description, chart, store) : null,
  };
}

/** Shows `factor` times as many frames, around the current one; Infinity shows all. */
function zoomBy(factor, description, chart, store) {
  if (!chart) return;
  const [first, last] = description.wholeRange();
  const { min, max } = chart.scales.x;
  const middle = description.xOfRow(store.get("row"));
  const reach = Math.max(2, (factor * (max - min)) / 2);
  store.set("zoom", `${Math.max(first, middle - reach)} ${Math.min(last, middle + reach)}`);
}
