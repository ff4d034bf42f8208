// SPDX-License-Identifier: MIT
import { element } from "../elements.js";
import { filledRows, isOfNumbers, partsOf, sortedBy } from "./markdown.js";

/** Text in which `...` is code. */
export function withCode(text) {
  return text.split("`").map((piece, k) => (k % 2 === 1 ? element("code", {}, piece) : piece));
}

/** A table whose columns sort by their headings: upwards, downwards, as it was. */
function tableElement({ head, rows }) {
  const numbers = head.map((_, column) => isOfNumbers(rows.map((row) => row[column] ?? "")));
  const body = element("tbody");
  const fill = (shown) =>
    body.replaceChildren(
      ...shown.map((row) =>
        element(
          "tr",
          {},
          ...head.map((_, column) =>
            element(column === 0 ? "th" : "td", { class: numbers[column] ? "number" : false }, row[column] ?? ""),
          ),
        ),
      ),
    );
  let sorted = { column: -1, way: 0 };
  const headings = head.map((name, column) => {
    const button = element("button", { type: "button", title: "Sort by this column" }, name || " ");
    button.addEventListener("click", () => {
      const way = sorted.column !== column ? 1 : sorted.way === 1 ? -1 : 0;
      sorted = { column, way };
      headings.forEach((heading, k) =>
        heading.setAttribute("aria-sort", k !== column || way === 0 ? "none" : way > 0 ? "ascending" : "descending"),
      );
      fill(way === 0 ? rows : sortedBy(filledRows(rows), column, way));
    });
    return element(
      "th",
      { scope: "col", "aria-sort": "none", class: numbers[column] && column > 0 ? "number" : false },
      button,
    );
  });
  fill(rows);
  return element(
    "div",
    { class: "panel scroll", tabindex: "0", role: "region", "aria-label": `Table: ${head[0]}` },
    element("table", {}, element("thead", {}, element("tr", {}, ...headings)), body),
  );
}

/** The tables and texts of a study, in their order. */
export const tableElements = (markdown) =>
  partsOf(markdown).map(({ table, text }) => (table ? tableElement(table) : element("p", {}, ...withCode(text))));
