#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Tests of the pages for reports and for live runs, in a browser without a window. Where what they need is missing it says so and exits with
# 77, which ctest counts as skipped. POISE_COMMAND names the program `poise` to test.
set -euo pipefail

viewer="$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")/../viewer" && pwd)"
skip() {
  echo "SKIPPED: $1"
  exit 77
}

command -v node >/dev/null || skip "node is missing (Debian: nodejs)"
[[ -d "$viewer/node_modules/playwright-core" ]] || skip "npm packages are missing: cmake/build_viewer.sh fetches them"
[[ -f "$viewer/build/report.html" && -f "$viewer/build/live.html" ]] || skip "a page is not built: cmake/build_viewer.sh builds it"
browser="${POISE_CHROMIUM:-$(command -v chromium || command -v chromium-browser || command -v google-chrome || true)}"
[[ -n "$browser" ]] || skip "chromium is missing"
export POISE_CHROMIUM="$browser"
cd -- "$viewer"
exec node --test test/*.test.mjs
