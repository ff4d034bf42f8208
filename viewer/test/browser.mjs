// SPDX-License-Identifier: MIT
import { existsSync } from "node:fs";

import { chromium } from "playwright-core";

/** The browser of the system; POISE_CHROMIUM names another. */
// Of one wait, in ms. Chosen: a busy machine without a graphics card needed more than 30 s for one; a test that passes waits for no longer than it must.
export const mostWait = 150_000;

export const chromiumPath = [
  process.env.POISE_CHROMIUM,
  "/usr/bin/chromium",
  "/usr/bin/chromium-browser",
  "/usr/bin/google-chrome",
].find((path) => path && existsSync(path));

/** Starts it without a window, drawing 3D by the processor. */
export const launch = () =>
  chromium.launch({
    executablePath: chromiumPath,
    args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--hide-scrollbars"],
  });

/** A page of 1280 x 720 that notes every error of its console in `errors`. */
export async function openPage(browser, address, { theme = "light", width = 1280, height = 720 } = {}) {
  const context = await browser.newContext({ viewport: { width, height }, colorScheme: theme });
  const page = await context.newPage();
  page.setDefaultTimeout(mostWait);
  const errors = [];
  page.on("console", (message) => {
    if (message.type() === "error" || message.type() === "warning") errors.push(message.text());
  });
  page.on("pageerror", (error) => errors.push(String(error)));
  page.on("request", (request) => {
    if (!/^(file|data|blob):/.test(request.url())) errors.push(`fetched ${request.url()}`);
  });
  await page.goto(address);
  return { page, errors, close: () => context.close() };
}
