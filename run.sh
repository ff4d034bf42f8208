#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Installs what is missing, builds what has changed, and runs the command `poise` with the arguments given. Without
# arguments: the scene `pile` at 60 Hz, with its report and its figures in out/pile/. All but the command's own output goes
# to stderr. The page of the report needs node and npm; where they cannot be had it is left out.
# `./run.sh study NAME` builds the program of the studies too, which nothing else needs; `./run.sh tune` installs Optuna.
set -euo pipefail
{ : <&0; } 2>/dev/null || exec </dev/null

root="$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")" && pwd)"
steps=(build)
targets=(poise_command)
if [[ "${1:-}" == study ]]; then
  export POISE_STUDIES=ON
  steps+=(study)
  targets+=(poise_study)
elif [[ "${1:-}" == tune ]]; then
  steps+=(tune)
fi
"$root/cmake/install_packages.sh" "${steps[@]}"
"$root/cmake/build_release.sh" "${targets[@]}"
"$root/cmake/get_viewer.sh" viewer || true

poise="$root/build/release/src/app/poise"
if (($# > 0)); then exec "$poise" "$@"; fi

results="$root/out/pile"
page="$root/viewer/build/report.html"
mkdir -p -- "$results"
report=()
if [[ -f "$page" ]]; then report=(--report "$results"); fi
status=0
"$poise" run pile --deadline 16 --paced --json "$results/report.json" --frames-csv "$results/frames.csv" "${report[@]}" || status=$?
if ((status == 0 || status == 130 || status == 143)); then
  echo
  if [[ -f "$page" ]]; then
    echo "The report, for a browser: $results/report.html"
  else
    echo "The report was left out: its page is not built (see above; cmake/build_viewer.sh builds it)"
  fi
  echo "The figures of this run:   $results/report.json"
  echo "A row for every frame:     $results/frames.csv"
  echo "More: ./run.sh --help, ./run.sh scenes"
fi
exit "$status"
