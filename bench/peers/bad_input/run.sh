#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Prints what Poise and other engines do with bad input, as the table of docs/reliability.md ("What others do").
#   bench/peers/bad_input/run.sh [--preset NAME]
# Downloads Jolt, MuJoCo and PhysX from npm (76 MB, into this folder), in the versions of package-lock.json. Needs node 18.
set -euo pipefail

here="$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")" && pwd)"
cd -- "$here/../../.."
preset=release
if (($# == 2)) && [[ "$1" == --preset ]]; then
  preset="$2"
elif (($# > 0)); then
  echo "run.sh: $1 is no option: --preset" >&2
  exit 2
fi
(cd -- "$here" && npm ci --ignore-scripts --no-audit --no-fund --silent)
cmake --preset "$preset" >/dev/null
cmake --build --preset "$preset" --target poise_bad_input -- --quiet
exec node "$here/trials.mjs" "$PWD/build/$preset/bench/peers/bad-input"
