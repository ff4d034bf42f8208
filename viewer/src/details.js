// SPDX-License-Identifier: MIT
import { commandPanel, list, plain } from "./details_parts.js";
import { byId, element } from "./elements.js";
import { howTrue, onTime, subtitle, tiles } from "./headline.js";

/** Name of the scene, headline and figures. */
export function showSummary(run) {
  document.title = `${run.scene} · Poise`;
  byId("scene").textContent = run.scene;
  byId("subtitle").textContent = subtitle(run);
  const card = ({ mark, title, text }, id) =>
    element(
      "article",
      { class: `panel card ${mark}`, id },
      element("h2", {}, (mark === "good" ? "✓ " : mark === "bad" ? "✕ " : "") + title),
      element("p", {}, text),
    );
  const shown = tiles(run);
  const figures = element(
    "dl",
    // Two rows.
    { class: "panel tiles", id: "tiles", style: `--columns:${Math.ceil(shown.length / 2)}` },
    ...shown.map(({ label, value, title }) =>
      element("div", { title }, element("dt", {}, label), element("dd", {}, value)),
    ),
  );
  byId("summary").append(card(onTime(run), "on-time"), card(howTrue(run), "how-true"), figures);
}

/** Settings, machine, and the command. */
export function showDetails(run, page) {
  const details = byId("details");
  if (page.command) details.append(commandPanel(page.command));
  const general = ["scene_file", "policy", "contact", "clock", "deadline_ms", "threads", "bodies", "state_hash"];
  details.append(
    list("Settings", [
      ...general.filter((name) => name in run).map((name) => [name, run[name]]),
      ...plain(run.settings),
    ]),
  );
  const weights = plain(run.settings?.policy_weights);
  if (weights.length > 0) details.append(list("Weights of the policy", weights));
  details.append(list("Machine", [...plain(run.machine), ...plain(run.build)]));
  const degraded = plain(run.degraded);
  if (degraded.length > 0) details.append(list("What was left out for time", degraded));
  if (run.warnings?.length > 0) {
    details.append(
      element(
        "article",
        { class: "panel wide" },
        element("h2", {}, "Warnings"),
        ...run.warnings.map((text) => element("p", {}, text)),
      ),
    );
  }
}
