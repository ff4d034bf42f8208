#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Builds the targets that are named in build/release, configuring first where that has not been done, and prints only
# what somebody who waits wants to see. POISE_TESTS=ON in the environment configures tests and benchmarks too.
set -euo pipefail

root="$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")/.." && pwd)"
build="$root/build/release"

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

cd -- "$root"
tests="${POISE_TESTS:-OFF}"
configured="$(sed -n 's/^POISE_TESTS:BOOL=//p' "$build/CMakeCache.txt" 2>/dev/null || true)"
if [[ ! -f "$build/build.ninja" || ("$tests" == ON && "$configured" != ON) ]]; then
  echo "poise: building in build/release; the first time takes a few minutes" >&2
  cmake --preset release "-DPOISE_TESTS=$tests" "-DPOISE_BENCHMARKS=$tests" >"$log" 2>&1 </dev/null ||
    say_and_fail "could not be configured; see above"
fi
if [[ ! -t 2 ]]; then
  cmake --build "$build" --target "$@" -- --quiet >"$log" 2>&1 </dev/null || say_and_fail "could not be built; see above"
else
  # On a terminal ninja shows its progress in one line, and nothing stays of it when there was nothing to do.
  NINJA_STATUS="building poise [%f/%t] " cmake --build "$build" --target "$@" >&2 </dev/null || exit 1
fi
