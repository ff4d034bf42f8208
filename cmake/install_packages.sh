#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Installs the Debian packages of the steps that are named (build, viewer, study, tune, test, python, python-more,
# viewer-test, package, sweep-test, ci), as far as they are missing. Asks nothing; when all are there it touches neither the
# network nor the system. Says what it does on stderr.
set -euo pipefail

list="$(dirname -- "${BASH_SOURCE[0]}")/debian-packages.txt"
if ! command -v dpkg-query >/dev/null; then
  echo "poise: this is not a Debian system; the packages it needs are listed in cmake/debian-packages.txt" >&2
  exit 0
fi

wanted=()
while read -r step package; do
  for asked in "$@"; do
    if [[ "$step" == "$asked" ]]; then wanted+=("$package"); fi
  done
done < <(grep -v '^#' -- "$list")

# dpkg-query complains about packages that it has never heard of, and those are missing too.
installed="$(dpkg-query -W -f='${db:Status-Abbrev} ${Package}\n' "${wanted[@]}" 2>/dev/null | sed -n 's/^.i  *//p' || true)"
missing=()
for package in "${wanted[@]}"; do
  if ! grep -qxF -- "$package" <<<"$installed"; then missing+=("$package"); fi
done
if ((${#missing[@]} == 0)); then exit 0; fi

as_root=()
if ((EUID != 0)); then
  if ! command -v sudo >/dev/null; then
    echo "poise: packages are missing and this user is neither root nor has sudo. As root: apt-get install ${missing[*]}" >&2
    exit 1
  fi
  as_root=(sudo)
  # Without a terminal a question for a password could not be answered.
  if [[ ! -t 2 ]]; then as_root+=(-n); fi
fi

apt=("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -q -o DPkg::Lock::Timeout=300)
echo "poise: installing ${missing[*]}" >&2
if ! { "${apt[@]}" update && "${apt[@]}" install -y --no-install-recommends "${missing[@]}"; } </dev/null >&2; then
  echo "poise: could not install these Debian packages: ${missing[*]}" >&2
  exit 1
fi
