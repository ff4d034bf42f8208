// SPDX-License-Identifier: MIT
// The page of a comparison or a study in a real browser, opened from disk.
import assert from "node:assert/strict";
import { readFile, writeFile } from "node:fs/promises";
import { join } from "node:path";
import { after, before, test } from "node:test";

import { apart, shareOf, tickRows } from "../src/figures/curves.js";
import { filledRows, numberIn, partsOf, sortedBy } from "../src/figures/markdown.js";
import { chromiumPath, launch, openPage } from "./browser.mjs";
import { viewerFolder, withFolder } from "./page.mjs";
import { noCommand, poise } from "./sample.mjs";

const skip = chromiumPath ? false : "no Chromium is installed";

const invented = {
  title: "<b>heap</b>: policies compared",
  subtitle: "40 bodies",
  headline: { mark: "good", title: "fifo leaves the least to be seen", text: "by `9 %`" },
  charts: [
    {
      id: "e-seen",
      title: "E_seen, m/s",
      note: "Lower is better.",
      x_label: "budget",
      x: { least: 0, most: 50, log: false, ticks: [[0, "0"], [50, "50"]] },
      y: { least: 0.1, most: 2, log: true, ticks: [[0.1, "0.1"], [1, "1"]] },
      levels: [{ label: "allowed", y: 0.3, line: null }],
      lines: [
        { label: "fifo", marks: "both", points: [[0, 1, 0.8, 1.2], [10, 0.5, 0.4, 0.6], [50, 0.25, 0.2, 0.3]] },
        { label: "size", marks: "both", points: [[0, 1, 0.8, 1.2], [10, 0.6, 0.5, 0.7], [50, 0.26, 0.2, 0.3]] },
        { label: "gaps", marks: "line", points: [[0, 1], [5, null], [10, 0.7], [50, 0.9]] },
        { label: "dots", marks: "dots", points: [[0, 0.5], [50, 1.5]] },
      ],
    },
  ],
  pictures: [
    {
      title: "a picture",
      type: "image/svg+xml",
      base64: Buffer.from('<svg xmlns="http://www.w3.org/2000/svg" width="40" height="20"/>').toString("base64"),
    },
    {
      title: "a picture of both themes",
      type: "image/svg+xml",
      base64: Buffer.from(
        '<svg xmlns="http://www.w3.org/2000/svg" width="40" height="20"><style>@media (prefers-color-scheme: dark) ' +
          '{ [fill="#ffffff"] { fill: #14191f } }</style><rect width="40" height="20" fill="#ffffff"/></svg>',
      ).toString("base64"),
    },
  ],
  tables: "| case | value |\n|---|---|\n| one | 10 |\n| two | 9 % |\n| three | - |\n\nA last line.\n",
  command: "poise compare heap --report out",
  settings: { seed: "1" },
  machine: { processor: "a processor", cores: 2 },
  build: { version: "0.1.0" },
};

let browser = null;
before(async () => {
  if (!skip) browser = await launch();
});
after(() => browser?.close());

async function withPage(data, use, options) {
  await withFolder(async (folder) => {
    const template = await readFile(join(viewerFolder, "build", "figures.html"), "utf8");
    const text = JSON.stringify(data).replaceAll("<", "\\u003c");
    const file = join(folder, "report.html");
    const element = `<script type="application/json" id="poise-figures">${text}</script>`;
    await writeFile(file, template.replace("<!-- poise:data -->", () => (data ? element : "")));
    const { page, errors, close } = await openPage(browser, `file://${file}`, options);
    await use(page);
    assert.deepEqual(errors, []);
    await close();
  });
}

for (const theme of ["light", "dark"]) {
  test(`the page of figures opens from disk and shows what came out (${theme})`, { skip }, () =>
    withPage(
      invented,
      async (page) => {
        assert.equal(await page.evaluate(() => document.documentElement.dataset.theme), theme);
        assert.equal(await page.textContent("#title"), "<b>heap</b>: policies compared", "a name is no markup");
        assert.equal(await page.textContent("#headline h2"), "✓ fifo leaves the least to be seen");
        assert.equal(await page.textContent("#headline code"), "9 %");
        assert.equal(await page.locator("#chart-e-seen .curve").count(), 3, "dots have no line");
        assert.equal(await page.locator("#chart-e-seen .dot").count(), 3 + 3 + 2, "a line has no dots");
        assert.match(await page.locator("#chart-e-seen .curve.line-2").getAttribute("d"), /^M[^ML]+M[^ML]+L[^ML]+$/, "a gap begins anew");
        // Half way up from 0.1 to 2 on a logarithmic axis is their geometric mean; 0.3 lies below.
        const levelAt = await page.locator("#chart-e-seen .across").getAttribute("d");
        assert.ok(Math.abs(Number(levelAt.match(/ ([\d.]+)H/)[1]) - (288 - (276 * Math.log(3)) / Math.log(20))) < 0.1, levelAt);
        assert.equal(await page.locator("#chart-e-seen .band").count(), 2);
        assert.equal(await page.locator("#chart-e-seen :is(.curve, .dot) ~ .band").count(), 0, "no band lies over a line");
        assert.deepEqual(await page.locator("#chart-e-seen .name").allTextContents(), ["allowed", "fifo", "size", "gaps", "dots"]);
        assert.ok(await page.evaluate(() => document.querySelector(".picture img").naturalWidth === 40));
        assert.match(await page.textContent("#tables"), /A last line\./);
        assert.match(await page.textContent("#details"), /poise compare heap --report out.*a processor/s);
        const colors = await page.evaluate(() =>
          [...document.querySelectorAll("#chart-e-seen .curve")].map((line) => getComputedStyle(line).stroke),
        );
        assert.notEqual(colors[0], colors[1]);
      },
      { theme },
    ),
  );
}

test("every part of the page of figures is reached by the keyboard", { skip }, () =>
  withPage(invented, async (page) => {
    await page.keyboard.press("t");
    assert.equal(await page.evaluate(() => document.documentElement.dataset.theme), "dark");
    await page.keyboard.press("Tab");
    await page.keyboard.press("Tab");
    assert.equal(await page.evaluate(() => document.activeElement.tagName), "svg");
    await page.keyboard.press("ArrowRight");
    await page.keyboard.press("ArrowRight");
    assert.equal(await page.textContent("#chart-e-seen .read"), "5: ");
    await page.keyboard.press("ArrowRight");
    assert.equal(await page.textContent("#chart-e-seen .read"), "10: fifo 0.5 (0.4 to 0.6)size 0.6 (0.5 to 0.7)gaps 0.7");
    await page.keyboard.press("Escape");
    assert.equal(await page.textContent("#chart-e-seen .read"), "");
    await page.keyboard.press("Tab"); // the table
    await page.keyboard.press("Tab");
    await page.keyboard.press("Tab");
    const column = () => page.locator("tbody tr th").allTextContents();
    await page.keyboard.press("Enter");
    assert.deepEqual(await column(), ["two", "one", "three"], "by numbers, what is none last");
    assert.equal(await page.getAttribute("thead th:nth-child(2)", "aria-sort"), "ascending");
    await page.keyboard.press("Enter");
    assert.deepEqual(await column(), ["one", "two", "three"]);
    await page.keyboard.press("Enter");
    assert.equal(await page.getAttribute("thead th:nth-child(2)", "aria-sort"), "none");
  }),
);

test("a page of figures without data says what makes one", { skip }, () =>
  withPage(null, async (page) => assert.match(await page.textContent("#problem"), /poise compare SCENE --report/)),
);

test("the page that the command writes shows its curves", { skip: skip || noCommand }, () =>
  withFolder(async (folder) => {
    const words = ["compare", "jacks", "--bodies", "30", "--frames", "2", "--every", "10", "--warmup", "30", "--quiet"];
    await poise(...words, "--policies", "perceptual,fifo,oracle", "--budgets", "0%,50%", "--report", folder);
    const { page, errors, close } = await openPage(browser, `file://${join(folder, "report.html")}`);
    assert.deepEqual(
      await page.locator(".chart").evaluateAll((charts) => charts.map(({ id }) => id)),
      ["chart-e-seen", "chart-e-rel", "chart-e", "chart-regret"],
    );
    assert.equal(await page.locator(".curve").count(), 3 + 3 + 3 + 2);
    assert.equal(await page.locator("tbody tr").count(), 6 + 3);
    assert.deepEqual(errors, []);
    await close();
  }),
);

test("tables of docs are read as their cells and texts", () => {
  assert.deepEqual(partsOf("Title:\n\n| a | b |\n|---:|---|\n| | 1 |\nand\nmore\n"), [
    { text: "Title:" },
    { table: { head: ["a", "b"], rows: [["", "1"]] } },
    { text: "and more" },
  ]);
  assert.deepEqual(["1,234.5 ms", "-3e-2 %", "x 1", "", "-"].map(numberIn), [1234.5, -0.03, NaN, NaN, NaN]);
  assert.deepEqual(filledRows([["a", "1"], ["", "2"], ["b", ""]]), [["a", "1"], ["a", "2"], ["b", ""]]);
  assert.deepEqual(sortedBy([["b"], [""], ["a"]], 0, -1), [["b"], ["a"], [""]]);
});

test("names of lines keep a line's distance inside of the chart", () => {
  assert.deepEqual(apart([50, 51, 10], 10, 0, 55), [45, 55, 10]);
  assert.equal(shareOf({ least: 1, most: 100, log: true }, 10), 0.5);
  assert.equal(shareOf({ least: -1, most: 3, log: false }, 1), 0.5);
  const named = (text) => ({ least: 0, most: 4, log: false, ticks: [0, 1, 2, 3, 4].map((at) => [at, text]) });
  assert.deepEqual(["ab", "a longer name", "a name that is longer than all"].map((text) => tickRows(named(text), 400)), [1, 1, 3]);
});

test("a picture with colours of its own for the dark has those of the page, whatever the system prefers", { skip }, async () => {
  for (const theme of ["light", "dark"]) {
    await withPage(
      invented,
      async (page) => {
        const shade = () =>
          page.evaluate(async () => {
            const image = document.querySelectorAll(".picture img")[1];
            await image.decode();
            const canvas = document.createElement("canvas");
            const pen = canvas.getContext("2d");
            pen.drawImage(image, 0, 0);
            const filter = getComputedStyle(image).filter;
            return [document.documentElement.dataset.theme, pen.getImageData(10, 10, 1, 1).data[0], filter];
          });
        const light = ["light", 255, "none"],
          dark = ["dark", 20, "none"];
        assert.deepEqual(await shade(), theme === "light" ? light : dark);
        await page.keyboard.press("t");
        assert.deepEqual(await shade(), theme === "light" ? dark : light);
      },
      { theme },
    );
  }
});
