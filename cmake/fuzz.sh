#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Runs libFuzzer on each reader of what may come from strangers: its seeds (tests/fuzz/seeds) and mutations of them, under the address
# and undefined-behaviour sanitizers of Clang 14. Prints a table and fails if a reader broke a promise; then it says which one, and gives
# the bytes that broke it, which are kept too.
#   cmake/fuzz.sh [--seconds S] [--cases N] [--seed R] [--keep FOLDER] [--preset NAME] [READER...]
# S: seconds of mutations a reader (default 5). N: cases in all readers together, instead of seconds. R: the mutations begin with this
# number (default 0: another one each time). FOLDER: where new inputs and those that broke something go (default build/PRESET/found).
# NAME: fuzz, or asan, which has the same settings and may be built already.
set -euo pipefail

root="$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")/.." && pwd)"
cd -- "$root"
seconds=5 cases=0 seed=0 keep="" preset=fuzz chosen=()
while (($# > 0)); do
  case "$1" in
    --seconds) seconds="$2"; shift 2 ;;
    --cases) cases="$2"; shift 2 ;;
    --seed) seed="$2"; shift 2 ;;
    --keep) keep="$2"; shift 2 ;;
    --preset) preset="$2"; shift 2 ;;
    -*) echo "fuzz.sh: $1 is no option: --seconds, --cases, --seed, --keep or --preset" >&2; exit 2 ;;
    *) chosen+=("$1"); shift ;;
  esac
done

cmake --preset "$preset" >/dev/null
cmake --build --preset "$preset" --target poise_fuzz -- --quiet
keep="${keep:-build/$preset/found}"
program="$root/build/$preset/tests/fuzz/poise_fuzz"
mapfile -t known < <("$program" --list)
readers=("${chosen[@]:-${known[@]}}")
mkdir -p -- "$keep"

# What a case may take: seconds, and MB of memory beside what the sanitizers need for themselves.
export UBSAN_OPTIONS="print_stacktrace=1" ASAN_OPTIONS="detect_leaks=1:allocator_may_return_null=0"
each=0
if ((cases > 0)); then each=$(((cases + ${#readers[@]} - 1) / ${#readers[@]})); fi
one() {
  local reader="$1" limit
  mkdir -p -- "$keep/$reader"
  if (($2 > 0)); then limit="-runs=$2"; else limit="-max_total_time=$3"; fi
  # A corpus of its own, so that seeds are never changed.
  local status=0
  "$4" "--reader=$reader" "$limit" "-seed=$seed" -max_len=20000 -timeout=10 -rss_limit_mb=1024 -malloc_limit_mb=256 -print_final_stats=1 -verbosity=1 \
    "-artifact_prefix=$keep/$reader/broke-" "$keep/$reader" "tests/fuzz/seeds/$reader" >"$keep/$reader.log" 2>&1 || status=$?
  local runs memory rate
  runs="$(sed -n 's/^stat::number_of_executed_units: *//p' "$keep/$reader.log")"
  rate="$(sed -n 's/^stat::average_exec_per_sec: *//p' "$keep/$reader.log")"
  memory="$(sed -n 's/^stat::peak_rss_mb: *//p' "$keep/$reader.log")"
  printf '%-8s %10s %8s %8s  %s\n' "$reader" "${runs:--}" "${rate:--}" "${memory:--}" "$( ((status == 0)) && echo held || echo "BROKE: $keep/$reader.log")"
  # The log may be out of reach where this ran.
  if ((status != 0)); then
    grep -E '^(broken promise|==[0-9]+==ERROR)|runtime error:|^SUMMARY' "$keep/$reader.log" || tail -n 20 "$keep/$reader.log"
    find "$keep/$reader" -name 'broke-*' -printf '%f, base64: ' -exec base64 -w 0 {} \; -printf '\n'
  fi
  return "$status"
}
export -f one
export keep seed
printf '%-8s %10s %8s %8s\n' reader cases per_s peak_MB
printf '%s\n' "${readers[@]}" | xargs -P "$(nproc)" -I{} bash -c 'one "$@"' -- {} "$each" "$seconds" "$program"
