// SPDX-License-Identifier: MIT
import { byId } from "../elements.js";
import { createChart } from "./chart.js";
import { histogramChart, percentileChart } from "./distribution_charts.js";
import { frameTimeChart, levelChart, lineChart, restingChart } from "./frame_charts.js";

const has = (column) => column.some((value) => Number.isFinite(value));
const kBlue = "#0072b2",
  kSky = "#56b4e9",
  kOrange = "#e69f00",
  kGreen = "#009e73",
  kPurple = "#cc79a7";

function reserveChart(frames) {
  const reserve = frames.column("reserve_at_cut_ms");
  const actual = frames.column("tail_actual_ms");
  if (!has(reserve) || !has(actual)) return null;
  return lineChart(frames, {
    id: "reserve",
    title: "Reserve and what was needed",
    unit: " ms",
    log: true,
    note: "Time reserved for the work after refinement, and the time it took (log scale).",
    lines: [
      { label: "reserved", color: kSky, column: reserve },
      { label: "needed", color: kOrange, column: actual },
    ],
  });
}

function errorChart(frames) {
  const error = frames.column("reference_e_rel");
  if (!has(error)) return null;
  const missed = frames.column("reference_missed_contacts");
  const contacts = frames.column("reference_contacts");
  return lineChart(frames, {
    id: "error",
    title: "Difference from the reference",
    note: "Frames that were compared with full refinement: error of the change of velocity, relative; share of contacts missed.",
    lines: [
      { label: "relative error", color: kOrange, column: error, dots: true },
      {
        label: "contacts missed",
        color: kPurple,
        column: missed.map((value, row) => (contacts[row] > 0 ? value / contacts[row] : NaN)),
        dots: true,
      },
    ],
  });
}

function energyChart(frames) {
  const kinetic = frames.column("kinetic_j");
  const potential = frames.column("potential_j");
  if (!has(kinetic)) return null;
  return lineChart(frames, {
    id: "energy",
    title: "Energy",
    unit: " J",
    note: "Kinetic and potential; the sum falls where bodies collide.",
    fromZero: false,
    lines: [
      { label: "kinetic", color: kOrange, column: kinetic },
      { label: "potential", color: kBlue, column: potential },
      { label: "sum", color: kGreen, column: kinetic.map((value, row) => value + potential[row]), dash: [6, 3] },
    ],
  });
}

/** Left out for captures and tables of earlier versions, which have no momentum. */
function momentumChart(frames) {
  const lines = [
    { label: "x", color: kOrange, column: frames.column("momentum_x_kgmps") },
    { label: "y", color: kGreen, column: frames.column("momentum_y_kgmps") },
    { label: "z", color: kBlue, column: frames.column("momentum_z_kgmps") },
  ];
  if (!lines.every(({ column }) => has(column))) return null;
  return lineChart(frames, {
    id: "momentum",
    title: "Momentum",
    unit: " kg m/s",
    note: "Linear, of all moving bodies together. Gravity and what stands still change it, impacts between bodies do not.",
    fromZero: false,
    lines,
  });
}

/** All charts that the figures allow, in the order of the page. */
export function showCharts(frames, run, store) {
  const timed = has(frames.column("total_ms"));
  const descriptions = [
    timed ? frameTimeChart(frames, run) : null,
    timed ? histogramChart(frames, run) : null,
    timed ? percentileChart(frames, run) : null,
    has(frames.column("level_0")) ? levelChart(frames) : null,
    errorChart(frames),
    reserveChart(frames),
    restingChart(frames),
    energyChart(frames),
    momentumChart(frames),
  ].filter((description) => description !== null);
  const charts = {};
  for (const description of descriptions) {
    const made = createChart(description, store);
    byId("charts").append(made.panel);
    charts[description.id] = { ...made, drawn: description.drawn };
  }
  return charts;
}
