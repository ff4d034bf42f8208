// SPDX-License-Identifier: MIT
// The page of `poise compare --report` and `poise study --report`: what came out, in pictures and tables.
import { commandPanel, list, plain } from "../details_parts.js";
import { byId, element } from "../elements.js";
import { createStore } from "../store.js";
import { startTheme } from "../theme.js";
import { Curves } from "./curves.js";
import { tableElements, withCode } from "./tables.js";

const kSign = { good: "✓ ", bad: "✕ " };

const kDarkRule = "@media (prefers-color-scheme: dark)";

/** Sources of a picture in both themes; of one that has its own dark colours, what the browser prefers is put aside. */
function sourcesOf({ type, base64 }) {
  const source = (text) => `data:${type};base64,${text}`;
  const svg = type === "image/svg+xml" ? atob(base64) : "";
  if (!svg.includes(kDarkRule)) return { light: source(base64), dark: source(base64), isPaper: true };
  const inTheme = (rule) => source(btoa(svg.replace(kDarkRule, rule)));
  return { light: inTheme("@media not all"), dark: inTheme("@media all"), isPaper: false };
}

/** A picture that was drawn before. What has the colours of paper alone is turned round in the dark (style.css). */
function pictureElement(picture, store) {
  const sources = sourcesOf(picture);
  const image = element("img", { alt: picture.title, class: sources.isPaper ? "paper" : false });
  const show = (theme) => (image.src = sources[theme]);
  show(store.get("theme"));
  store.on("theme", show);
  return element("figure", { class: "panel picture" }, image, element("figcaption", {}, picture.title));
}

function headlineElement({ mark, title, text }) {
  return element(
    "article",
    { class: `panel card ${mark}` },
    element("h2", {}, (kSign[mark] ?? "") + title),
    ...(text ? [element("p", {}, ...withCode(text))] : []),
  );
}

function start() {
  const store = createStore({ theme: "light" });
  const toggle = startTheme(store);
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.key.toLowerCase() === "t") toggle();
  });
  const embedded = byId("poise-figures");
  if (!embedded) {
    byId("problem").hidden = false;
    byId("problem").textContent = "This page holds no figures. poise compare SCENE --report FOLDER makes one.";
    return;
  }
  const data = JSON.parse(embedded.textContent);
  document.title = `${data.title} · Poise`;
  byId("title").textContent = data.title;
  byId("subtitle").textContent = data.subtitle;
  byId("headline").append(headlineElement(data.headline));
  const charts = data.charts.map((chart) => new Curves(chart));
  byId("figures").append(...charts.map((chart) => chart.element), ...data.pictures.map((picture) => pictureElement(picture, store)));
  byId("figures").classList.toggle("one", charts.length + data.pictures.length === 1);
  byId("tables").append(...tableElements(data.tables));
  const details = byId("details");
  if (data.command) details.append(commandPanel(data.command));
  if (plain(data.settings).length > 0) details.append(list("Settings", plain(data.settings)));
  details.append(list("Machine", plain(data.machine)), list("Build", plain(data.build)));
  // For tests.
  window.poise = { data, charts };
}

start();
