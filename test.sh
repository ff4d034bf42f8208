#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Installs what is missing, builds everything in build/release, and runs all tests.
# The tests of the report's page are skipped where node, npm or chromium cannot be had.
# Arguments are passed on to ctest, e.g. ./test.sh -R Forecast
set -euo pipefail
{ : <&0; } 2>/dev/null || exec </dev/null

root="$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")" && pwd)"
"$root/cmake/install_packages.sh" build study tune test python
POISE_TESTS=ON "$root/cmake/build_release.sh" all
"$root/cmake/get_viewer.sh" viewer viewer-test || true
cd -- "$root"
progress=()
if [[ -t 1 ]]; then progress=(--progress); fi
exec ctest --preset release --parallel "$(nproc)" "${progress[@]}" "$@"
