// SPDX-License-Identifier: MIT
import uPlot from "uplot";

import { kCauses, kCauseText, kStages, lateFrames, levelColumns } from "../data/frames.js";
import { counted, milliseconds, number, whole } from "../format.js";
import { css, kCauseMark, kStageColor, kStateColor, levelColor } from "../palette.js";
import { axis, roomFor, roundValues } from "./chart.js";
import { drawMark, markElement } from "./marks.js";

const kMarkBand = 16; // height above the plot in which late frames are marked

/** What all charts over the frames share: the frame number along x, one step wide. */
function overFrames(frames) {
  const first = frames.length > 0 ? frames.column("frame")[0] : 0;
  const numbers = frames.column("frame");
  const range = [first, (frames.length > 0 ? numbers[frames.length - 1] : 0) + 1];
  return {
    follows: true,
    wholeRange: () => range,
    xOfRow: (row) => (numbers[row] ?? 0) + 0.5,
    rowAt(u, left) {
      const frame = Math.floor(u.posToVal(left, "x"));
      let low = 0;
      let high = frames.length - 1;
      while (low < high) {
        const middle = (low + high + 1) >> 1;
        if (numbers[middle] <= frame) low = middle;
        else high = middle - 1;
      }
      return high < 0 ? -1 : low;
    },
    // A last point closes the step of the last frame.
    x: [...numbers, range[1]],
    /** Values of single frames, which no line joins. */
    apart: (column) => [...column, NaN].map((value) => (Number.isNaN(value) ? null : value)),
    closed: (column) => [...column, column[column.length - 1]].map((value) => (Number.isNaN(value) ? null : value)),
    scale: {
      time: false,
      range: (u, min, max) => (min === null ? range : [Math.max(range[0], min), Math.min(range[1], max)]),
    },
  };
}

const stepped = () => uPlot.paths.stepped({ align: 1 });
const frameAxis = (colors) =>
  axis(colors, {
    label: "frame",
    labelSize: 16,
    labelFont: "11px system-ui, sans-serif",
    size: 24,
    values: (u, ticks) => ticks.map((tick) => (Number.isInteger(tick) ? whole(tick) : "")),
  });
const valueAxis = (colors, values = (u, ticks) => ticks.map((tick) => number(tick, 4))) =>
  axis(colors, { size: roomFor(46), values });

/** Stacks columns: the sum of all first, so that each later one is painted over it. */
function stackSeries(frames, frame, parts) {
  const sum = new Float64Array(frames.length);
  const data = [];
  const series = [];
  for (const part of parts) {
    part.column.forEach((value, row) => (sum[row] += Number.isNaN(value) ? 0 : value));
    data.unshift(frame.closed(sum));
    series.unshift({
      label: part.label,
      stroke: part.color,
      fill: part.color,
      width: 0,
      paths: stepped(),
      points: { show: false },
    });
  }
  return { data, series };
}

/** Frame times against the deadline, stages stacked, late frames marked by cause. */
export function frameTimeChart(frames, run) {
  const frame = overFrames(frames);
  const late = lateFrames(frames);
  const counts = late.filter((miss) => !miss.warmUp);
  const total = frames.column("total_ms");
  const stages = kStages.map((stage) => ({
    label: stage,
    color: kStageColor[stage],
    column: frames.column(`${stage}_ms`),
  }));
  const sorted = Float64Array.from(total.filter((value) => Number.isFinite(value))).sort();
  const p99 = sorted.length > 0 ? sorted[Math.ceil(0.99 * sorted.length) - 1] : 1;
  const deadline = run.clock === "work" ? null : run.deadline_ms;
  // One frame that took very long must not press all others flat: it is cut off, and its mark stands above it.
  const slowest = sorted[sorted.length - 1] ?? 1;
  // A deadline that is far above all frames is not shown: they would be flat.
  const shown = deadline !== null && deadline < 8 * slowest ? deadline : 0;
  const top = Math.max(1.12 * shown, Math.min(1.05 * slowest, 1.6 * p99));
  const warmUp = frames.column("warm_up");
  const above = total.filter((value, row) => value > top && !(warmUp[row] > 0)).length;
  const causes = kCauses.filter((cause) => late.some((miss) => miss.cause === cause));
  const drawn = { marks: [] };
  const description = {
    ...frame,
    id: "frame-time",
    title: "Frame time",
    height: 210,
    note:
      (deadline ? `${shown ? "Dashed: the" : "Far below the"} deadline of ${milliseconds(deadline)}. ` : "") +
      (counts.length > 0
        ? `${counted(counts.length, "late frame")} marked above. `
        : deadline
          ? "No frame was late. "
          : "") +
      (late.length > counts.length ? "Marks of the warm-up do not count. " : "") +
      (above > 0 ? `${counted(above, "frame")} beyond the top.` : ""),
    legend: [
      ...stages.map(({ label, color }) => ({ label, color, name: label })),
      { label: "total", color: "transparent", name: "total" },
      ...causes.map((cause) => ({
        label: `${cause} (${counts.filter((miss) => miss.cause === cause).length})`,
        mark: markElement(cause),
        title: kCauseText[cause],
      })),
    ],
    valuesAt: (row) =>
      Object.fromEntries([
        ...stages.map(({ label, column }) => [label, number(column[row], 2)]),
        ["total", milliseconds(total[row])],
      ]),
    drawn,
    plot(colors) {
      const { data, series } = stackSeries(frames, frame, stages);
      return {
        data: [frame.x, frame.closed(total), ...data],
        options: {
          padding: [kMarkBand + 4, 10, 0, 0],
          scales: { x: frame.scale, y: { range: () => [0, top] } },
          axes: [frameAxis(colors), valueAxis(colors, (u, ticks) => ticks.map((tick) => number(tick, 4)))],
          // What no stage counts is grey.
          series: [
            {},
            { stroke: colors.grid, fill: colors.grid, width: 0, paths: stepped(), points: { show: false } },
            ...series,
          ],
          hooks: {
            draw: [(u) => drawDeadline(u, deadline, colors), (u) => (drawn.marks = drawLate(u, frames, late, colors))],
          },
        },
      };
    },
  };
  return description;
}

function drawDeadline(u, deadline, colors) {
  if (!deadline) return;
  const y = u.valToPos(deadline, "y", true);
  if (y < u.bbox.top) return;
  const { ctx } = u;
  ctx.save();
  ctx.strokeStyle = colors.late;
  ctx.lineWidth = 2 * devicePixelRatio;
  ctx.setLineDash([6 * devicePixelRatio, 4 * devicePixelRatio]);
  ctx.beginPath();
  ctx.moveTo(u.bbox.left, y);
  ctx.lineTo(u.bbox.left + u.bbox.width, y);
  ctx.stroke();
  ctx.restore();
}

/** Returns where the marks are, in CSS pixels of the canvas. */
function drawLate(u, frames, late, colors) {
  const numbers = frames.column("frame");
  const { ctx } = u;
  const scale = devicePixelRatio;
  const y = u.bbox.top - (kMarkBand / 2 + 2) * scale;
  const marks = [];
  ctx.save();
  for (const miss of late) {
    const x = u.valToPos(numbers[miss.index] + 0.5, "x", true);
    if (x < u.bbox.left || x > u.bbox.left + u.bbox.width) continue;
    ctx.fillStyle = kCauseMark[miss.cause]?.color ?? colors.faint;
    ctx.fillRect(x - scale / 2, y, scale, u.bbox.top - y);
    drawMark(ctx, miss.cause, x, y, 5 * scale, colors.panel);
    marks.push({ row: miss.index, cause: miss.cause, x: x / scale, y: y / scale });
  }
  ctx.restore();
  return marks;
}

/** Contact pairs by the level at which they were solved. */
export function levelChart(frames) {
  const frame = overFrames(frames);
  const names = levelColumns(frames);
  const parts = names.map((name, k) => ({
    label: name === "polygons" ? "polygons" : name.replace("level_", "level "),
    color: css(levelColor(k, names.length)),
    column: frames.column(name),
  }));
  return {
    ...frame,
    id: "levels",
    title: "Levels of detail",
    height: 150,
    note: "Contact pairs by the level they reached: dark is the root sphere, bright the finest.",
    legend: parts.map(({ label, color }) => ({ label, color, name: label })),
    valuesAt: (row) => Object.fromEntries(parts.map(({ label, column }) => [label, whole(column[row])])),
    plot(colors) {
      const { data, series } = stackSeries(frames, frame, parts);
      return {
        data: [frame.x, ...data],
        options: {
          scales: { x: frame.scale, y: { range: (u, min, max) => [0, Math.max(1, 1.05 * max)] } },
          axes: [frameAxis(colors), valueAxis(colors)],
          series: [{}, ...series],
        },
      };
    },
  };
}

/** Lines over the frames. `lines`: label, color, column; dots: for values that few frames have. */
export function lineChart(frames, { id, title, note, lines, unit = "", log = false, fromZero = true, height = 150 }) {
  const frame = overFrames(frames);
  return {
    ...frame,
    id,
    title,
    note,
    height,
    legend: lines.map(({ label, color }) => ({ label, color, name: label })),
    valuesAt: (row) =>
      Object.fromEntries(
        lines.map(({ label, column }) => [label, Number.isNaN(column[row]) ? "" : `${number(column[row])}${unit}`]),
      ),
    plot(colors) {
      const smallest = Math.min(
        ...lines.map(({ column }) =>
          column.reduce((least, value) => (value > 0 && value < least ? value : least), Infinity),
        ),
      );
      const positive = (column) => column.map((value) => (log && !(value > 0) ? NaN : value));
      return {
        data: [
          frame.x,
          ...lines.map((line) => (line.dots ? frame.apart(line.column) : frame.closed(positive(line.column)))),
        ],
        options: {
          scales: {
            x: frame.scale,
            y: log
              ? { distr: 3, range: (u, min, max) => [Math.min(smallest, min ?? 1) / 1.3, 1.3 * (max ?? 10)] }
              : {
                  range: (u, min, max) =>
                    fromZero
                      ? [Math.min(0, min ?? 0), (max ?? 0) > 0 ? 1.08 * max : 1]
                      : uPlot.rangeNum(min ?? 0, max ?? 1, 0.08, true),
                },
          },
          axes: [
            frameAxis(colors),
            { ...valueAxis(colors), ...(log ? { splits: roundValues, filter: (u, ticks) => ticks } : {}) },
          ],
          series: [
            {},
            ...lines.map((line) => ({
              label: line.label,
              stroke: line.color,
              width: 1.5,
              dash: line.dash,
              spanGaps: false,
              paths: line.dots ? () => null : stepped(),
              points: line.dots ? { show: true, size: 7, fill: line.color, stroke: line.color } : { show: false },
            })),
          ],
        },
      };
    },
  };
}

/** Bodies that did not move as the clock says: asleep, in islands that waited, paused. */
export function restingChart(frames) {
  const held = frames.column("bodies_held");
  const paused = frames.column("bodies_paused");
  const waiting = held.map((value, row) => value - (Number.isNaN(paused[row]) ? 0 : paused[row]));
  const lines = [
    { label: "waiting", color: kStateColor.waiting, column: waiting },
    { label: "paused", color: kStateColor.paused, column: paused },
    { label: "asleep", color: kStateColor.asleep, column: frames.column("asleep") },
  ].filter(({ column }) => column.some((value) => value > 0));
  if (lines.length === 0) return null;
  return lineChart(frames, {
    id: "resting",
    title: "Bodies whose clock stood still",
    lines,
    note: "Waiting: the frame had no time for their islands. Paused: for several frames. Asleep: at rest.",
  });
}
