// SPDX-License-Identifier: MIT

const isRow = (line) => line.startsWith("|");
const isRule = (line) => /^\|(\s*:?-+:?\s*\|)+$/.test(line);
const cellsOf = (line) =>
  line
    .replace(/^\|\s?/, "")
    .replace(/\s?\|$/, "")
    .split(/\s?\|\s?/)
    .map((cell) => cell.trim());

/**
 * The parts of a text as tables for docs are written: `{table: {head, rows}}` and `{text}`, in their order. A table is
 * lines that begin with a bar, the second of them a rule; anything else is text, a part for each paragraph.
 */
export function partsOf(markdown) {
  const parts = [];
  const lines = markdown.split("\n").map((line) => line.trim());
  for (let at = 0; at < lines.length; ++at) {
    if (lines[at] === "") continue;
    let end = at;
    while (end < lines.length && lines[end] !== "" && isRow(lines[end]) === isRow(lines[at])) ++end;
    const block = lines.slice(at, end);
    if (isRow(block[0]) && block.length > 1 && isRule(block[1])) {
      parts.push({ table: { head: cellsOf(block[0]), rows: block.slice(2).map(cellsOf) } });
    } else {
      parts.push({ text: block.join(" ") });
    }
    at = end - 1;
  }
  return parts;
}

/** The number that a cell begins with; NaN where it begins with none. */
export function numberIn(cell) {
  const found = /^[^\w.+-]*([+-]?(?:\d[\d,]*\.?\d*|\.\d+)(?:e[+-]?\d+)?)/i.exec(cell);
  return found ? Number(found[1].replaceAll(",", "")) : NaN;
}

/** Whether most cells of a column are numbers, or nothing. */
export function isOfNumbers(cells) {
  const filled = cells.filter((cell) => cell !== "" && cell !== "-");
  return filled.length > 0 && filled.filter((cell) => !Number.isNaN(numberIn(cell))).length > filled.length / 2;
}

/** Rows in which an empty cell at the beginning stands for that of the row before, with what it stands for. */
export function filledRows(rows) {
  const filled = [];
  for (const row of rows) {
    const first = row.findIndex((cell) => cell !== "");
    const before = filled[filled.length - 1] ?? [];
    filled.push(row.map((cell, column) => (column < first ? (before[column] ?? "") : cell)));
  }
  return filled;
}

/** Rows by a column, `way` 1 upwards or -1 downwards; rows without a value are last in both. */
export function sortedBy(rows, column, way) {
  const cells = rows.map((row) => row[column] ?? "");
  const byNumber = isOfNumbers(cells);
  const isEmpty = (cell) => cell === "" || cell === "-" || (byNumber && Number.isNaN(numberIn(cell)));
  const compare = (a, b) => (byNumber ? numberIn(a) - numberIn(b) : a.localeCompare(b));
  return [...rows].sort((one, other) => {
    const [a, b] = [one[column] ?? "", other[column] ?? ""];
    if (isEmpty(a) || isEmpty(b)) return Number(isEmpty(a)) - Number(isEmpty(b));
    return way * compare(a, b);
  });
}
