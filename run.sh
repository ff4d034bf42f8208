#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Installs what is missing, builds what has changed, and runs the command `poise` with the arguments given. Without
# arguments: the scene `pile` at 60 Hz, with its figures in out/pile/. All but the command's own output goes to stderr.
# `./run.sh study NAME` builds the program of the studies too, which nothing else needs.
set -euo pipefail
{ : <&0; } 2>/dev/null || exec </dev/null

root="$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")" && pwd)"
steps=(build)
targets=(poise_command)
if [[ "${1:-}" == study ]]; then
  export POISE_STUDIES=ON
  steps+=(study)
  targets+=(poise_study)
fi
"$root/cmake/install_packages.sh" "${steps[@]}"
"$root/cmake/build_release.sh" "${targets[@]}"

poise="$root/build/release/src/app/poise"
if (($# > 0)); then exec "$poise" "$@"; fi

results="$root/out/pile"
mkdir -p -- "$results"
status=0
"$poise" run pile --deadline 16 --paced --json "$results/report.json" --frames-csv "$results/frames.csv" || status=$?
if ((status == 0 || status == 130)); then
  echo
  echo "The figures of this run:  $results/report.json"
  echo "A row for every frame:    $results/frames.csv"
  echo "More: ./run.sh --help, ./run.sh scenes"
fi
exit "$status"
