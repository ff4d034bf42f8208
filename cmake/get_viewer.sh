#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Builds the page for reports, installing before what is missing of the steps that are named (viewer, viewer-test). Asks for
# commands, not for packages: node may come from elsewhere than Debian. Fails with a reason on stderr where it cannot.
set -euo pipefail

here="$(dirname -- "${BASH_SOURCE[0]}")"
declare -A commands=([viewer]="node npm" [viewer-test]="chromium")
missing=()
for step in "$@"; do
  for name in ${commands[$step]}; do
    if ! command -v "$name" >/dev/null; then
      missing+=("$step")
      break
    fi
  done
done
if ((${#missing[@]} > 0)); then "$here/install_packages.sh" "${missing[@]}" || true; fi
exec "$here/build_viewer.sh"
