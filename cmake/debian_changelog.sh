#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Writes the changelog that a Debian package must have: one entry, which names what has the rest.
#
#   cmake/debian_changelog.sh VERSION MAINTAINER FILE.gz
#
# Its date is that of the commit, so that the same commit gives the same file.
set -euo pipefail
version=$1 maintainer=$2 file=$3
here="$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")" && pwd)"
when=$(git -C "$here" log -1 --format=%cD 2>/dev/null) || when=$(date -R -r "$here/../CHANGELOG.md")
mkdir -p -- "$(dirname -- "$file")"
printf 'poise (%s) unstable; urgency=medium\n\n  * CHANGELOG.md in the sources tells what changed.\n\n -- %s  %s\n' \
  "$version" "$maintainer" "$when" | gzip -9 -n >"$file"
