// SPDX-License-Identifier: MIT
import { milliseconds, number, whole } from "../format.js";
import { axis, roundValues } from "./chart.js";

const kBinsOfTen = 24; // bins for each factor of ten

/** Rows with a time, in ascending order of it. */
function rowsByTime(frames) {
  const total = frames.column("total_ms");
  const warmUp = frames.column("warm_up");
  return [...total.keys()].filter((row) => total[row] > 0 && !(warmUp[row] > 0)).sort((a, b) => total[a] - total[b]);
}

/** Position in the ordered rows of the one whose time is nearest. */
function nearest(rows, total, time) {
  let low = 0;
  let high = rows.length - 1;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (total[rows[middle]] < time) low = middle + 1;
    else high = middle;
  }
  if (low > 0 && Math.abs(total[rows[low - 1]] - time) < Math.abs(total[rows[low]] - time)) --low;
  return low;
}

const timeTicks = (u, ticks) => ticks.map((tick) => number(tick));

function drawDeadlineAt(u, deadline, colors, upright) {
  if (!deadline) return;
  const at = u.valToPos(deadline, upright ? "x" : "y", true);
  const { ctx, bbox } = u;
  const inside = upright
    ? at >= bbox.left && at <= bbox.left + bbox.width
    : at >= bbox.top && at <= bbox.top + bbox.height;
  if (!inside) return;
  ctx.save();
  ctx.strokeStyle = colors.late;
  ctx.lineWidth = 1.5 * devicePixelRatio;
  ctx.setLineDash([5 * devicePixelRatio, 4 * devicePixelRatio]);
  ctx.beginPath();
  ctx.moveTo(upright ? at : bbox.left, upright ? bbox.top : at);
  ctx.lineTo(upright ? at : bbox.left + bbox.width, upright ? bbox.top + bbox.height : at);
  ctx.stroke();
  ctx.restore();
}

/** How many frames took how long, with a log scale of time. Null without times. */
export function histogramChart(frames, run) {
  const rows = rowsByTime(frames);
  if (rows.length === 0) return null;
  const total = frames.column("total_ms");
  const deadline = run.clock === "work" ? null : run.deadline_ms;
  const binOf = (time) => Math.floor(kBinsOfTen * Math.log10(time));
  const edge = (bin) => 10 ** (bin / kBinsOfTen);
  const first = binOf(total[rows[0]]) - 1;
  const last = Math.max(binOf(total[rows[rows.length - 1]]), deadline ? binOf(deadline) : -Infinity) + 1;
  const counts = new Array(last - first + 1).fill(0);
  for (const row of rows) ++counts[binOf(total[row]) - first];
  return {
    id: "histogram",
    title: "How often",
    note: "Frames by time, log scale.",
    height: 150,
    xOfRow: (row) => total[row],
    rowAt: (u, left) => rows[nearest(rows, total, u.posToVal(left, "x"))],
    plot: (colors) => ({
      data: [counts.map((_, k) => edge(first + k)), counts],
      options: {
        scales: {
          x: {
            time: false,
            distr: 3,
            range: (u, min, max) => (min === null ? [edge(first), edge(last + 1)] : [min, max]),
          },
          y: { range: (u, min, max) => [0, 1.08 * Math.max(1, max)] },
        },
        axes: [
          axis(colors, {
            size: 24,
            label: "ms",
            labelSize: 14,
            labelFont: "11px system-ui, sans-serif",
            splits: roundValues,
            filter: (u, ticks) => ticks,
            values: timeTicks,
          }),
          axis(colors, {
            size: 40,
            values: (u, ticks) => ticks.map((tick) => (Number.isInteger(tick) ? whole(tick) : "")),
          }),
        ],
        series: [{}, { stroke: colors.ink, width: 0, points: { show: false }, paths: () => null }],
        hooks: {
          draw: [
            (u) => drawBars(u, counts, (k) => edge(first + k), colors, deadline),
            (u) => drawDeadlineAt(u, deadline, colors, true),
          ],
        },
      },
    }),
  };
}

function drawBars(u, counts, edge, colors, deadline) {
  const { ctx, bbox } = u;
  ctx.save();
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  const floor = u.valToPos(0, "y", true);
  counts.forEach((count, k) => {
    if (count === 0) return;
    const left = u.valToPos(edge(k), "x", true);
    const right = u.valToPos(edge(k + 1), "x", true);
    const top = u.valToPos(count, "y", true);
    ctx.fillStyle = deadline && edge(k) >= deadline ? colors.late : colors.ink;
    ctx.fillRect(left, top, Math.max(1, right - left - devicePixelRatio), floor - top);
  });
  ctx.restore();
}

/** The time that so many frames in a hundred do not exceed; the slow end is stretched. Null without times. */
export function percentileChart(frames, run) {
  const rows = rowsByTime(frames);
  if (rows.length === 0) return null;
  const total = frames.column("total_ms");
  const deadline = run.clock === "work" ? null : run.deadline_ms;
  const count = rows.length;
  const rank = new Map(rows.map((row, k) => [row, k]));
  const xOf = (k) => count / (count - k); // 10: nine of ten frames are faster
  const most = Math.max(10, count);
  return {
    id: "percentiles",
    title: "Percentiles",
    note: "Frame time in ms, log scale.",
    height: 150,
    xOfRow: (row) => (rank.has(row) ? xOf(rank.get(row)) : NaN),
    rowAt: (u, left) => rows[Math.min(count - 1, Math.max(0, Math.round(count - count / u.posToVal(left, "x"))))],
    plot: (colors) => ({
      data: [rows.map((_, k) => xOf(k)), rows.map((row) => total[row])],
      options: {
        scales: {
          x: { time: false, distr: 3, range: (u, min, max) => (min === null ? [1, most] : [min, max]) },
          y: { distr: 3, range: (u, min, max) => [0.8 * (min ?? 1), 1.25 * Math.max(max ?? 1, deadline ?? 0)] },
        },
        axes: [
          axis(colors, {
            size: 24,
            label: "% of frames",
            labelSize: 14,
            labelFont: "11px system-ui, sans-serif",
            splits: () => [1, 2, 10, 100, 1000, 1e4, 1e5].filter((x) => x <= most),
            filter: (u, ticks) => ticks,
            values: (u, ticks) =>
              ticks.map(
                (x) =>
                  ({ 1: "0", 2: "50", 10: "90", 100: "99", 1000: "99.9", 10000: "99.99", 100000: "99.999" })[
                    Math.round(x)
                  ] ?? "",
              ),
          }),
          axis(colors, { size: 46, splits: roundValues, filter: (u, ticks) => ticks, values: timeTicks }),
        ],
        series: [{}, { stroke: colors.ink, width: 2, points: { show: false } }],
        hooks: { draw: [(u) => drawDeadlineAt(u, deadline, colors, false)] },
      },
    }),
    legend: [],
    valuesAt: (row) => ({ time: milliseconds(total[row]) }),
  };
}
