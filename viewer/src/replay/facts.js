// SPDX-License-Identifier: MIT
import { kStates, priorityOfBand } from "../capture/frame_cursor.js";
import { isCoarse, pairsOfBody, pairText, whyText } from "../capture/pairs.js";
import { byId, element } from "../elements.js";
import { counted, number } from "../format.js";

const levelText = (level) => (level === 0 ? "touches nothing" : level === 8 ? "polygons" : `level ${level - 1}`);

/** What the capture tells of a body in this frame, as pairs of name and text. */
export function factsOf(file, cursor, row) {
  const { bodies } = file;
  const shape = file.shapes[bodies.shape[row]];
  const place = Array.from(cursor.position.subarray(3 * row, 3 * row + 3), (value) => number(value, 4)).join(", ");
  const state = kStates[cursor.state[row]];
  const facts = [
    ["shape", shape.name],
    ["material", file.head.materials?.[bodies.material[row]]?.name ?? "–"],
    ["state", cursor.still[row] > 1 ? `${state}, for ${cursor.still[row]} frames or more` : state],
    ["level", levelText(cursor.level[row])],
    ["priority", cursor.priority[row] === 0 ? "not ranked" : `${number(priorityOfBand(cursor.priority[row]))} rad/m`],
    ["speed", Number.isNaN(cursor.speed[row]) ? "not known in this frame" : `${number(cursor.speed[row])} m/s`],
    ["position", `${place} m`],
  ];
  if (bodies.motion[row] === 2) facts.push(["mass", `${number(bodies.mass_kg[row])} kg`]);
  if (file.head.contacts) {
    const touching = cursor.contacts
      .filter(({ a, b }) => a === row || b === row)
      .map(({ a, b }) => bodies.number[a === row ? b : a]);
    facts.push([
      "touches",
      touching.length === 0
        ? "nothing"
        : `bodies ${touching.slice(0, 12).join(", ")}${touching.length > 12 ? ", …" : ""}`,
    ]);
  }
  return facts;
}

const kMostPairs = 8;

/** The pairs of a body in this frame, a line each; null where the capture lists none. */
function pairLines(file, pairs, row) {
  if (!file.hasPairs) return null;
  const found = pairsOfBody(pairs, row);
  const lines = found.slice(0, kMostPairs).map((i) => {
    const other = pairs.a[i] === row ? pairs.b[i] : pairs.a[i];
    const name = file.bodies.name[other] || `body ${file.bodies.number[other]}`;
    const why = whyText(pairs, i, file.head.policy);
    return element(
      "li",
      { class: isCoarse(pairs, i) ? "left" : false },
      element("b", {}, name),
      ` ${pairText(pairs, i)}`,
      element("span", { class: "why" }, why && `: ${why}`),
    );
  });
  if (found.length > kMostPairs) lines.push(element("li", {}, `… and ${found.length - kMostPairs} more`));
  const left = found.filter((i) => isCoarse(pairs, i)).length;
  const title = found.length === 0 ? "No pair near enough" : `${counted(found.length, "pair")}, ${left} left coarse`;
  return [element("h4", {}, title), element("ul", { class: "pairs" }, ...lines)];
}

/** The panel of a body: what stays while frames change, so that its button can be pressed meanwhile. */
function openPanel(panel, title, close) {
  const button = element("button", { type: "button", "aria-label": "Close the facts" }, "×");
  button.addEventListener("click", close);
  panel.replaceChildren(element("h3", {}, title), button, element("div", { class: "now-known" }));
  panel.dataset.title = title;
}

/** Shows them; `chosen` is `{file, cursor, row, pairs}`, or null to close. `pairs` may be missing where the file has none. */
export function showFacts(chosen, close) {
  const panel = byId("facts");
  panel.hidden = chosen === null;
  if (chosen === null) return;
  const { file, cursor, row, pairs } = chosen;
  const isThere = row >= 0 && cursor.has(row);
  const name = row >= 0 ? file.bodies.name[row] : "";
  const title = `Body ${chosen.number ?? file.bodies.number[row]}${name ? ` (${name})` : ""}`;
  if (panel.dataset.title !== title) openPanel(panel, title, close);
  const facts = isThere ? factsOf(file, cursor, row) : [["state", "not there in this frame"]];
  panel.lastElementChild.replaceChildren(
    element("dl", {}, ...facts.flatMap(([label, text]) => [element("dt", {}, label), element("dd", {}, text)])),
    ...((isThere && pairLines(file, pairs, row)) || []),
  );
}
