#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Kills `poise run` at random moments and checks every file that it leaves (docs/reliability.md, "Faults"), then the other faults:
# full disks, a tree cache that is removed, a processor that is taken away.
#   cmake/faults.sh [--moments N] [--seed S] [--preset NAME]
# N: moments (default 300; ctest has 30). S: of the moments (default 1). NAME: release, or another preset.
set -euo pipefail

root="$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")/.." && pwd)"
cd -- "$root"
moments=300 seed=1 preset=release
while (($# > 0)); do
  case "$1" in
    --moments) moments="$2"; shift 2 ;;
    --seed) seed="$2"; shift 2 ;;
    --preset) preset="$2"; shift 2 ;;
    *) echo "faults.sh: $1 is no option: --moments, --seed or --preset" >&2; exit 2 ;;
  esac
done

cmake --preset "$preset" -DPOISE_TESTS=ON >/dev/null
cmake --build --preset "$preset" --target fault_tests -- --quiet
export POISE_FAULT_MOMENTS="$moments" POISE_FAULT_SEED="$seed" POISE_TREE_CACHE="$root/build/$preset/test_trees"
exec "build/$preset/tests/faults/fault_tests" --gtest_brief=1
