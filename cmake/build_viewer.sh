#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Builds the pages, viewer/build/report.html and figures.html for reports and live.html for live runs, if something changed since they were
# built. Needs node 18 or later and npm, which fetches what they are made of (viewer/package-lock.json) the first time. Nothing else needs
# any of that. Says
# on stderr what it does, and fails with a reason where it cannot.
set -euo pipefail

viewer="$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")/../viewer" && pwd)"
page="$viewer/build/report.html" # the last that is written
least_node=18

fail() {
  echo "poise: the page for reports cannot be built: $1" >&2
  exit 1
}

cd -- "$viewer"
if [[ -f "$page" && -f "$viewer/build/figures.html" && -f "$viewer/build/live.html" && -z "$(find src package-lock.json build.mjs -newer "$page" -print -quit)" ]]; then exit 0; fi
command -v node >/dev/null || fail "node is missing (Debian: nodejs)"
command -v npm >/dev/null || fail "npm is missing"
version="$(node -p 'process.versions.node.split(".")[0]')"
((version >= least_node)) || fail "node $version is too old, $least_node or later is needed"

log="$(mktemp)"
trap 'rm -f -- "$log"' EXIT
if [[ ! -f node_modules/.package-lock.json || package-lock.json -nt node_modules/.package-lock.json ]]; then
  echo "poise: fetching what the page for reports is made of (npm ci)" >&2
  npm ci --ignore-scripts --no-audit --no-fund --loglevel=error </dev/null >"$log" 2>&1 || {
    cat -- "$log" >&2
    fail "npm ci failed; see above"
  }
  touch node_modules/.package-lock.json
fi
echo "poise: building the page for reports" >&2
node build.mjs </dev/null >"$log" 2>&1 || {
  cat -- "$log" >&2
  fail "see above"
}
