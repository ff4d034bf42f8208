// SPDX-License-Identifier: MIT
import uPlot from "uplot";

import { isUnfinished, kCount } from "../capture/frame_table.js";
import { axis, createChart } from "../charts/chart.js";
import { drawMark } from "../charts/marks.js";
import { kCauses, kStages } from "../data/frames.js";
import { byId } from "../elements.js";
import { number } from "../format.js";
import { css, kStageColor, levelColor } from "../palette.js";

const kFrames = 300;
const kTotal = 8; // of times_ms
const kMarkBand = 14;

/** The figures of the last frames, oldest first. */
export class Recent {
  constructor() {
    this.clear();
  }
  clear() {
    this.frames = [];
  }
  add(facts, deadline_ms) {
    // The scene was started again.
    if (this.frames.length > 0 && facts.frame < this.frames[this.frames.length - 1].frame) this.clear();
    // The same frame is sent again to those who come while the run is paused.
    if (!facts.measured || this.frames[this.frames.length - 1]?.frame === facts.frame) return;
    const { frame, times_ms, cause, counts } = facts;
    // Until a step ends that takes several frames, contacts are those of the one before.
    const waits = isUnfinished(counts[kCount.bodies], counts[kCount.asleep], counts[kCount.bodies_held]);
    const levels = (waits && this.frames[this.frames.length - 1]?.levels) || facts.levels;
    this.frames.push({ frame, times_ms, levels, cause, deadline_ms });
    if (this.frames.length > kFrames) this.frames.shift();
  }
  /** Of the last second: mean level of the contacts at levels of trees (NaN: none), and contacts a frame. */
  contacts() {
    let sum = 0;
    let atLevels = 0;
    let all = 0;
    const last = this.frames.slice(-60);
    for (const { levels } of last) {
      for (let level = 0; level < 7; ++level) {
        sum += level * levels[level];
        atLevels += levels[level];
      }
      all += levels.reduce((total, count) => total + count, 0);
    }
    return { level: sum / atLevels, count: all / Math.max(1, last.length) };
  }
}

/** The frames along x, from the left edge until there are enough of them. */
function frameScale(recent) {
  return {
    time: false,
    range: () => {
      const first = recent.frames[0]?.frame ?? 0;
      const last = recent.frames[recent.frames.length - 1]?.frame ?? 0;
      return [Math.max(first, last - kFrames + 1), Math.max(first + kFrames, last) + 1];
    },
  };
}

/**
 * Columns over the frames: their numbers, then what each reader reads. A last point closes the step of a frame that none
 * follows, at the end and where frames did not come.
 */
function columns(recent, readers) {
  const data = [[], ...readers.map(() => [])];
  const { frames } = recent;
  frames.forEach((frame, k) => {
    data[0].push(frame.frame);
    readers.forEach((read, column) => data[column + 1].push(read(frame)));
    const isLast = k + 1 === frames.length;
    if (!isLast && frames[k + 1].frame === frame.frame + 1) return;
    data[0].push(frame.frame + 1);
    readers.forEach((read, column) => data[column + 1].push(isLast ? read(frame) : null));
  });
  return data;
}

/** Readers of the sums of the first one, two, ... of these; that of all is the first, so that it is painted first. */
const sums = (readers) =>
  readers.map((_, k) => (frame) => readers.slice(0, k + 1).reduce((sum, read) => sum + read(frame), 0)).reverse();

const area = (color) => ({
  stroke: color,
  fill: color,
  width: 0,
  paths: uPlot.paths.stepped({ align: 1 }),
  points: { show: false },
});

const still = {
  follows: false,
  rowAt: () => -1,
  xOfRow: () => NaN,
  height: 124,
};
const frameAxis = (colors) => axis(colors, { size: 22, values: (u, ticks) => ticks.map((tick) => number(tick, 7)) });
const valueAxis = (colors) => axis(colors, { size: 52, values: (u, ticks) => ticks.map((tick) => number(tick, 4)) });

/** Late frames are marked above; returns where, in CSS pixels. */
function drawLate(u, recent, colors) {
  const { ctx } = u;
  const scale = devicePixelRatio;
  const y = u.bbox.top - (kMarkBand / 2) * scale;
  const marks = [];
  ctx.save();
  for (const { frame, cause } of recent.frames) {
    if (cause === 0) continue;
    const x = u.valToPos(frame + 0.5, "x", true);
    if (x < u.bbox.left || x > u.bbox.left + u.bbox.width) continue;
    drawMark(ctx, kCauses[cause - 1], x, y, 4.5 * scale, colors.panel);
    marks.push({ frame, cause: kCauses[cause - 1], x: x / scale, y: y / scale });
  }
  ctx.restore();
  return marks;
}

function timeChart(recent) {
  const drawn = { marks: [] };
  const stages = kStages.map((stage, k) => (frame) => frame.times_ms[k]);
  const readers = [(frame) => frame.times_ms[kTotal], ...sums(stages), (frame) => frame.deadline_ms];
  const data = () => columns(recent, readers);
  const top = () => {
    const { frames } = recent;
    const times = Float64Array.from(frames, (frame) => frame.times_ms[kTotal]).sort();
    const deadline = frames[frames.length - 1]?.deadline_ms ?? 1;
    // Single frames that took very long are cut off.
    const slow = times[Math.floor(0.95 * (times.length - 1))] ?? 0;
    return Math.max(1.3 * slow, 1.2 * Math.min(deadline, 8 * slow || deadline));
  };
  return {
    ...still,
    id: "frame-time",
    title: "Frame time, ms",
    note: "Dashed: the deadline. Marks: late frames.",
    legend: kStages.map((stage) => ({ label: stage, color: kStageColor[stage] })),
    drawn,
    data,
    plot: (colors) => ({
      data: data(),
      options: {
        cursor: { show: false },
        padding: [kMarkBand, 8, 0, 0],
        scales: { x: frameScale(recent), y: { range: () => [0, top()] } },
        axes: [frameAxis(colors), valueAxis(colors)],
        series: [
          {},
          area(colors.grid),
          ...kStages.map((stage) => area(kStageColor[stage])).reverse(),
          {
            stroke: colors.late,
            width: 2,
            dash: [6, 4],
            paths: uPlot.paths.stepped({ align: 1 }),
            points: { show: false },
          },
        ],
        hooks: { draw: [(u) => (drawn.marks = drawLate(u, recent, colors))] },
      },
    }),
  };
}

function levelChart(recent, levels, hasMeshes) {
  // As in the picture (replay/coloring.js).
  const steps = levels + (hasMeshes ? 1 : 0);
  const part = (label, level, step) => ({
    label,
    color: css(levelColor(step, steps)),
    read: (frame) => frame.levels[level],
  });
  const parts = Array.from({ length: levels }, (_, level) => part(`level ${level}`, level, level));
  if (hasMeshes) parts.push(part("polygons", 7, levels));
  const readers = sums(parts.map(({ read }) => read));
  const data = () => columns(recent, readers);
  return {
    ...still,
    id: "levels",
    title: "Contacts by level",
    note: "Dark: the root sphere; bright: the finest.",
    legend: parts.map(({ label, color }) => ({ label, color })),
    data,
    plot: (colors) => ({
      data: data(),
      options: {
        cursor: { show: false },
        scales: { x: frameScale(recent), y: { range: (u, min, max) => [0, Math.max(1, 1.05 * (max ?? 1))] } },
        axes: [frameAxis(colors), valueAxis(colors)],
        series: [{}, ...parts.map(({ color }) => area(color)).reverse()],
      },
    }),
  };
}

/** Charts that follow the run; `update` shows what `recent` has now. */
export function startCharts({ recent, shapes, store }) {
  const levels = Math.min(7, Math.max(1, ...shapes.map((shape) => shape.levels.length)));
  const hasMeshes = shapes.some((shape) => shape.corners.length > 0);
  const made = {};
  for (const description of [timeChart(recent), levelChart(recent, levels, hasMeshes)]) {
    const chart = createChart(description, store);
    byId("charts").append(chart.panel);
    made[description.id] = { ...chart, data: description.data, drawn: description.drawn };
  }
  return {
    ...made,
    update() {
      for (const { chart, data } of Object.values(made)) chart()?.setData(data());
    },
  };
}
