#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Builds the targets that are named in build/release, configuring first where that has not been done, and shows how far it
# is: in one line on a terminal, elsewhere in a line every few seconds. In the environment, each ON or OFF (the default):
# POISE_TESTS (tests, benchmarks, examples and studies too, and the Python module where pybind11 and Python's headers are
# installed), POISE_STUDIES, POISE_WERROR.
set -euo pipefail

root="$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")/.." && pwd)"
build="$root/build/release"
seconds_between_lines=5

# A build folder that was made elsewhere (the checkout was moved or copied) is of no use here.
if [[ -f "$build/CMakeCache.txt" ]] && ! grep -qxF "CMAKE_HOME_DIRECTORY:INTERNAL=$root" "$build/CMakeCache.txt"; then
  rm -rf -- "$build"
fi

log="$(mktemp)"
trap 'rm -f -- "$log"' EXIT
say_and_fail() {
  cat -- "$log" >&2
  echo "poise: $1" >&2
  exit 1
}

# configured OPTION: what the build folder has of it; OFF where there is none.
configured() {
  local value
  value="$(sed -n "s/^$1:BOOL=//p" "$build/CMakeCache.txt" 2>/dev/null || true)"
  echo "${value:-OFF}"
}

cd -- "$root"
tests="${POISE_TESTS:-OFF}"
studies="${POISE_STUDIES:-$tests}"
werror="${POISE_WERROR:-OFF}"
python=OFF
if [[ "$tests" == ON && -f /usr/include/pybind11/pybind11.h ]] && /usr/bin/python3 -c \
  'import os, sys, sysconfig; sys.exit(not os.path.exists(sysconfig.get_path("include") + "/Python.h"))' 2>/dev/null; then
  python=ON
fi
# What was asked for once stays, so that a later run of the command does not take it away again.
again=()
for option in "POISE_TESTS=$tests" "POISE_BENCHMARKS=$tests" "POISE_EXAMPLES=$tests" "POISE_STUDIES=$studies" "POISE_WERROR=$werror" \
  "POISE_PYTHON=$python"; do
  if [[ ! -f "$build/build.ninja" ]]; then
    again+=("-D$option")
  elif [[ "${option#*=}" == ON && "$(configured "${option%%=*}")" != ON ]]; then
    again+=("-D$option")
  fi
done
if ((${#again[@]} > 0)); then
  echo "poise: building in build/release; the first time takes a few minutes" >&2
  cmake --preset release "${again[@]}" >"$log" 2>&1 </dev/null || say_and_fail "could not be configured; see above"
fi

export NINJA_STATUS="poise: building, %p (%f of %t) "
if [[ -t 2 ]]; then
  # On a terminal ninja shows its progress in one line, and nothing stays of it when there was nothing to do.
  cmake --build "$build" --target "$@" >&2 </dev/null || exit 1
  exit 0
fi
next=$((SECONDS + seconds_between_lines))
cmake --build "$build" --target "$@" 2>&1 </dev/null | while IFS= read -r line; do
  printf '%s\n' "$line" >>"$log"
  if ((SECONDS >= next)) && [[ "$line" == "poise: building, "* ]]; then
    echo "${line%%)*})" >&2
    next=$((SECONDS + seconds_between_lines))
  fi
done || say_and_fail "could not be built; see above"
