// SPDX-License-Identifier: MIT
import { CaptureFile } from "./capture/capture_file.js";
import { runOfCapture, tableOfCapture } from "./capture/frame_table.js";
import { showCharts } from "./charts/all_charts.js";
import { readEmbedded } from "./data/embedded.js";
import { lateFrames, parseFrames } from "./data/frames.js";
import { showDetails, showSummary } from "./details.js";
import { byId } from "./elements.js";
import { startKeyboard } from "./keyboard.js";
import { startPlayer } from "./player.js";
import { startReplay } from "./replay/replay.js";
import { createStore } from "./store.js";
import { startTheme } from "./theme.js";

function showProblem(text) {
  const place = byId("problem");
  place.hidden = false;
  place.textContent = place.textContent === "" ? text : `${place.textContent} ${text}`;
}

/** The captures of the page; what is wrong with one is told on the page. */
function openCaptures(parts) {
  const files = [];
  for (const bytes of parts) {
    try {
      const file = new CaptureFile(bytes);
      if (file.warning !== "")
        showProblem(`The capture is not whole: ${file.warning}. The replay shows what could be read.`);
      if (file.frames.length > 0) files.push(file);
    } catch (failure) {
      showProblem(`The capture cannot be read: ${failure.message}.`);
    }
  }
  return files;
}

function start() {
  const store = createStore({ row: 0, zoom: "", theme: "light", playing: false, speed: 1 });
  const toggleTheme = startTheme(store);
  const embedded = readEmbedded();
  const files = openCaptures(embedded.captures);
  let frames = parseFrames(embedded.frames);
  let run = embedded.run;
  if (frames.length === 0 && files.length > 0) frames = tableOfCapture(files[0]);
  if (!run && files.length > 0) run = runOfCapture(files[0], frames);
  if (!run) {
    showProblem("This page holds no run. poise run SCENE --report FOLDER makes one.");
    return;
  }
  const page = embedded.page;
  if (!page.command && files.length > 0) page.command = (files[0].head.command ?? []).join(" ");
  const late = lateFrames(frames);
  showSummary(run);
  const charts = showCharts(frames, run, store);
  showDetails(run, page);
  const player = startPlayer({ store, frames, late, dt_s: run.settings?.dt_s ?? 1 / 60 });
  const replay = files.length > 0 ? startReplay({ store, frames, late, files, names: page.captures ?? [] }) : null;
  byId("replay").hidden = replay === null;
  document.querySelector(".columns").classList.toggle("alone", replay === null);
  startKeyboard({ store, player, replay, toggleTheme, wholeZoom: charts["frame-time"] ?? charts.levels });
  replay?.resize();
  // For tests, and for those who want to look at the figures in the console.
  window.poise = { run, frames, late, store, charts, player, replay, files };
}

start();
