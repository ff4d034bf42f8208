// SPDX-License-Identifier: MIT
// Pages for tests and pictures, put together as the command `poise` does it.
import { mkdtemp, readFile, rm, writeFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

export const viewerFolder = join(dirname(fileURLToPath(import.meta.url)), "..");

const script = (id, type, text) => `<script type="${type}" id="${id}">${text.replaceAll("<", "\\u003c")}</script>\n`;

/** The page of these parts: `run` and `page` are objects, `frames` text, `captures` bytes. */
export async function pageOf({ run, frames, page, captures = [] }) {
  const template = await readFile(join(viewerFolder, "build", "report.html"), "utf8");
  let data = "";
  if (page) data += script("poise-page", "application/json", JSON.stringify(page));
  if (run) data += script("poise-run", "application/json", JSON.stringify(run));
  if (frames) data += script("poise-frames", "text/csv", frames);
  captures.forEach((bytes, k) => {
    data += script(
      k === 0 ? "poise-capture" : "poise-capture-b",
      "application/octet-stream",
      Buffer.from(bytes).toString("base64"),
    );
  });
  return template.replace("<!-- poise:data -->", () => data);
}

/** A folder that is gone when `use` has ended. */
export async function withFolder(use) {
  const folder = await mkdtemp(join(tmpdir(), "poise-viewer-"));
  try {
    return await use(folder);
  } finally {
    await rm(folder, { recursive: true, force: true });
  }
}

/** Writes the page into a file and returns its address. */
export async function writePage(folder, parts, name = "report.html") {
  const path = join(folder, name);
  await writeFile(path, await pageOf(parts));
  return `file://${path}`;
}
