#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Makes the Debian packages poise, poise-study, libpoise-dev and python3-poise of this commit in build/packages, in one go: installs what
# is missing for that, builds, and looks for faults by lintian. Any error of lintian fails.
#
#   cmake/package.sh             version 0.1.0+gitDATE.COMMIT, or 0.1.0 if the commit has the tag v0.1.0
set -euo pipefail
root="$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")/.." && pwd)"
cd -- "$root"

cmake/install_packages.sh build study python package
cmake/get_viewer.sh viewer || echo "package.sh: without the pages of reports, which need node and npm" >&2
version=$(sed -En 's/^project\(poise VERSION ([0-9.]+).*/\1/p' CMakeLists.txt)
if [[ $(git describe --exact-match --tags --dirty 2>/dev/null) != "v$version" ]]; then
  version+="+git$(git log -1 --format=%cd --date=format:%Y%m%d).$(git rev-parse --short=10 HEAD)"
  git diff --quiet HEAD || version+=".changed"
fi
cmake --preset package "-DPOISE_PACKAGE_VERSION=$version" >/dev/null
cmake --build --preset package -- --quiet
rm -rf -- build/packages
(cd build/package && cpack -B "$root/build/packages" >/dev/null)
rm -rf -- build/packages/_CPack_Packages
if command -v lintian >/dev/null; then lintian --fail-on error --suppress-tags bad-distribution-in-changes-file build/packages/*.deb; fi
ls -l build/packages
