// SPDX-License-Identifier: MIT
import { byId } from "../elements.js";
import { counted, milliseconds } from "../format.js";
import { createStore } from "../store.js";
import { startTheme } from "../theme.js";
import { Recent, startCharts } from "./charts.js";
import { connect } from "./connection.js";
import { startControls } from "./controls.js";
import { clockText, showHeadline } from "./headline.js";
import { startKeys } from "./keys.js";
import { LiveCapture } from "./live_capture.js";
import { LiveStage } from "./stage.js";

const kShown_ms = 100; // between two updates of charts and words
const kProblem_ms = 8000;

const store = createStore({ row: 0, zoom: "", theme: "light" });
const toggleTheme = startTheme(store);
const capture = new LiveCapture();
const recent = new Recent();
const live = { capture, recent, store, status: null, stage: null, charts: null, frames: 0, errors: [] };
let controls = null;
let problemTimer = 0;
let shownAt = 0;

/** Tells of a problem; `forGood`: until the connection is back. */
function showProblem(text, forGood = false) {
  const place = byId("problem");
  place.hidden = text === "";
  place.textContent = text;
  clearTimeout(problemTimer);
  if (!forGood && text !== "") problemTimer = setTimeout(() => showProblem(""), kProblem_ms);
}

function showWords() {
  if (!live.status) return;
  showHeadline(live.status, recent, Math.max(0, ...capture.shapes.map((shape) => shape.levels.length - 1)));
  controls.show(live.status);
  byId("clock").textContent = clockText(capture.frames[0]);
}

/** With the first frame there is something to draw. */
function begin() {
  const { head } = capture;
  document.title = `${head.scene} · Poise live`;
  byId("scene").textContent = head.scene;
  byId("subtitle").textContent = [
    "live",
    `steps of ${milliseconds(1000 * head.dt_s)}`,
    counted(head.threads, "thread"),
    `contact model ${head.contact}`,
  ].join(" · ");
  live.charts = startCharts({ recent, shapes: capture.shapes, store });
  try {
    live.stage = new LiveStage({ store, capture, look: (view) => connection.send({ do: "view", ...view }) });
  } catch (failure) {
    live.stage = { advance() {}, failed: true };
    showProblem(`No picture: ${failure.message}`, true);
  }
}

const connection = connect({
  opened: () => showProblem(""),
  closed(reason) {
    const why = reason ? `The run ended the connection: ${reason}.` : "No connection to the run.";
    showProblem(`${why} Trying again…`, true);
  },
  told(message) {
    if (message.error) {
      live.errors.push(message.error);
      showProblem(`Refused: ${message.error}`);
    }
    if (!message.status) return;
    live.status = message.status;
    controls ??= startControls({ status: live.status, send });
    showWords();
  },
  bytes(bytes) {
    if (!capture.take(bytes)) return;
    connection.send({ do: "shown", number: capture.number });
    ++live.frames;
    recent.add(capture.frames[0], live.status?.deadline_ms ?? NaN);
    if (live.stage) live.stage.advance();
    else begin();
    const now = performance.now();
    if (now - shownAt < kShown_ms) return;
    shownAt = now;
    live.charts.update();
    showWords();
  },
});
const send = (message) => connection.send(message);
const pour = () => send({ do: "pour", count: Math.max(10, Math.round(0.1 * (live.status?.bodies ?? 0))) });
const pause = () => send({ do: "pause", on: !live.status?.paused });
const step = () => send({ do: "step", count: 1 });
const again = () => send({ do: "again" });

byId("pour").addEventListener("click", pour);
byId("pause").addEventListener("click", pause);
byId("step").addEventListener("click", step);
byId("again").addEventListener("click", again);
startKeys({ pour, pause, step, again, toggleTheme, stage: () => live.stage });
// For tests, and for those who want to look at the figures in the console.
window.poise = Object.assign(live, { connection, send });
