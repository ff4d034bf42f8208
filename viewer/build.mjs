// SPDX-License-Identifier: MIT
// Bundles each page into one file in build/: script and style inside, nothing fetched. In report.html and figures.html the
// command `poise` puts the data of a run in the place of the line `<!-- poise:data -->`; live.html is what `poise live` serves.
import { mkdir, readFile, rename, writeFile } from "node:fs/promises";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

import { build } from "esbuild";

const here = dirname(fileURLToPath(import.meta.url));
const options = {
  bundle: true,
  minify: true,
  write: false,
  charset: "utf8",
  legalComments: "eof", // the licences of what is bundled
  target: ["es2022"],
  logLevel: "warning",
  external: [],
};

async function bundled(entry, more = {}) {
  const result = await build({ ...options, entryPoints: [join(here, entry)], ...more });
  return result.outputFiles[0].text;
}

/** The pages, each from main.js, style.css and page.html of its folder. The last one is what cmake/build_viewer.sh looks at. */
const kPages = { live: "src/live", figures: "src/figures", report: "src" };

/** Of pages that open from disk: they fetch nothing. */
const head = await readFile(join(here, "src/head.html"), "utf8");

await mkdir(join(here, "build"), { recursive: true });
for (const [name, folder] of Object.entries(kPages)) {
  const script = (await bundled(`${folder}/main.js`, { format: "iife" })).replaceAll("</script", "<\\/script");
  const style = await bundled(`${folder}/style.css`, { loader: { ".css": "css" } });
  const page = await readFile(join(here, folder, "page.html"), "utf8");
  // Functions, so that a dollar sign in the code has no meaning.
  const whole = page
    .replace("<!-- poise:head -->\n", () => head)
    .replace("/* poise:style */", () => style)
    .replace("/* poise:script */", () => script);
  const part = join(here, "build", `.${name}.${process.pid}`);
  await writeFile(part, whole);
  await rename(part, join(here, "build", `${name}.html`));
}
