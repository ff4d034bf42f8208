// SPDX-License-Identifier: MIT
// Panels that the pages of a run and of figures share.
import { element } from "./elements.js";
import { number } from "./format.js";

function valueText(value) {
  if (value === null || value === undefined || (Array.isArray(value) && value.length === 0)) return "–";
  if (typeof value === "boolean") return value ? "yes" : "no";
  if (typeof value === "number") return number(value, 5);
  return Array.isArray(value) ? value.map(valueText).join(", ") : String(value);
}

/** A panel of names and values. */
export function list(title, entries) {
  return element(
    "article",
    { class: entries.length > 20 ? "panel long" : "panel" },
    element("h2", {}, title),
    element(
      "dl",
      {},
      ...entries.flatMap(([name, value]) => [element("dt", {}, name), element("dd", {}, valueText(value))]),
    ),
  );
}

/** Members of an object that are no objects themselves, without those that say nothing. */
export const plain = (object) =>
  Object.entries(object ?? {}).filter(
    ([, value]) => value !== null && (typeof value !== "object" || Array.isArray(value)),
  );

/** The command, with a button that copies it. */
export function commandPanel(command) {
  const text = element("pre", {}, element("code", {}, command));
  const button = element("button", { type: "button" }, "Copy");
  button.addEventListener("click", async () => {
    try {
      await navigator.clipboard.writeText(command);
      button.textContent = "Copied";
    } catch {
      getSelection()?.selectAllChildren(text);
      button.textContent = "Selected";
    }
  });
  return element(
    "article",
    { class: "panel wide", id: "command" },
    element("div", { class: "row" }, element("h2", {}, "The command that made this"), button),
    text,
  );
}
