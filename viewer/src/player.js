// SPDX-License-Identifier: MIT
import { drawMark } from "./charts/marks.js";
import { pageColors } from "./charts/chart.js";
import { byId, element } from "./elements.js";

const kSpeeds = [0.0625, 0.125, 0.25, 0.5, 1, 2, 4, 8];
const kThumb = 16; // width of the handle of a range input in Chromium and Firefox

/** Where the handle of the scrubber stands, in CSS pixels from its left edge. */
export const scrubberX = (row, rows, width) => kThumb / 2 + ((width - kThumb) * row) / Math.max(1, rows - 1);

/** The clock while a row is shown: it runs on, but starts anew at the row where someone has moved there. */
export function clockAt(row, clock_s, time, dt_s) {
  // A capture may leave frames out: a row lasts until the next one, however late that is.
  const end_s = (time[row + 1] ?? time[row]) + 2 * dt_s;
  return clock_s >= time[row] && clock_s < end_s ? clock_s : time[row];
}

/** Playing, stepping and scrubbing through the frames. */
export function startPlayer({ store, frames, late, dt_s }) {
  const last = Math.max(0, frames.length - 1);
  const time = frames.column("time_s");
  const scrubber = byId("scrubber");
  const marks = byId("scrubber-marks");
  const speed = byId("speed");
  scrubber.max = String(last);
  let clock_s = 0;
  let before = 0;

  const goTo = (row) => store.set("row", Math.min(last, Math.max(0, row)));
  const step = (by) => {
    store.set("playing", false);
    goTo(store.get("row") + by);
  };
  const toggle = () => {
    if (!store.get("playing") && store.get("row") === last) goTo(0);
    store.set("playing", !store.get("playing"));
  };
  const toLate = (direction) => {
    const row = store.get("row");
    const after = late.filter((miss) => (direction > 0 ? miss.index > row : miss.index < row));
    if (after.length === 0) return;
    store.set("playing", false);
    goTo(direction > 0 ? after[0].index : after[after.length - 1].index);
  };
  const changeSpeed = (by) => {
    const at = Math.min(kSpeeds.length - 1, Math.max(0, kSpeeds.indexOf(store.get("speed")) + by));
    store.set("speed", kSpeeds[at]);
  };

  const turn = (now) => {
    if (!store.get("playing")) return;
    const row = store.get("row");
    clock_s = clockAt(row, clock_s, time, dt_s);
    clock_s += Math.min(0.25, (now - before) / 1000) * store.get("speed");
    before = now;
    let next = row;
    while (next < last && time[next + 1] <= clock_s) ++next;
    goTo(next);
    if (next === last) store.set("playing", false);
    else requestAnimationFrame(turn);
  };
  const drawMarks = () => {
    const width = marks.clientWidth;
    if (width === 0) return;
    marks.width = width * devicePixelRatio;
    marks.height = marks.clientHeight * devicePixelRatio;
    const context = marks.getContext("2d");
    const { panel } = pageColors();
    for (const miss of late) {
      const x = scrubberX(miss.index, frames.length, width);
      drawMark(context, miss.cause, x * devicePixelRatio, 7 * devicePixelRatio, 5 * devicePixelRatio, panel);
    }
  };

  store.on("row", (row) => {
    scrubber.value = String(row);
    showTime();
  });
  const showTime = () => {
    const row = store.get("row");
    const text = `${(time[row] ?? 0).toFixed(2)} s   frame ${frames.column("frame")[row] ?? 0}`;
    byId("time").textContent = text;
    scrubber.setAttribute("aria-valuetext", text);
  };
  store.on("playing", (playing) => {
    byId("play").classList.toggle("playing", playing);
    byId("play").setAttribute("aria-label", playing ? "Pause" : "Play");
    if (!playing) return;
    before = performance.now();
    clock_s = time[store.get("row")];
    requestAnimationFrame(turn);
  });
  store.on("speed", (value) => (speed.value = String(value)));
  store.on("theme", drawMarks);
  for (const value of kSpeeds)
    speed.append(element("option", { value: String(value) }, value < 1 ? `1/${1 / value} ×` : `${value} ×`));
  speed.value = "1";
  speed.addEventListener("change", () => store.set("speed", Number(speed.value)));
  scrubber.addEventListener("input", () => goTo(Number(scrubber.value)));
  byId("play").addEventListener("click", toggle);
  byId("back").addEventListener("click", () => step(-1));
  byId("forward").addEventListener("click", () => step(1));
  new ResizeObserver(drawMarks).observe(marks);
  showTime();
  return { step, toggle, toLate, changeSpeed, goTo, last };
}
