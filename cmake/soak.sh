#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Lets bodies come and go for an hour, and says whether memory, handles, forecasts and replays are as at the beginning
# (docs/reliability.md, "Long runs").
#   cmake/soak.sh [--preset NAME] [OPTIONS OF poise-soak]      --help lists them
set -euo pipefail

cd -- "$(dirname -- "${BASH_SOURCE[0]}")/.."
preset=release
if [[ "${1:-}" == --preset ]]; then
  preset="${2:?soak.sh: --preset needs a name}"
  shift 2
fi
cmake --preset "$preset" >/dev/null
cmake --build --preset "$preset" --target poise_soak -- --quiet
exec "build/$preset/bench/soak/poise-soak" "$@"
