#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Makes the release of the version in CMakeLists.txt from the commit that is checked out: tags it v0.1.0, makes the Debian packages
# (cmake/package.sh), and puts them into build/v0.1.0 with the sources, the bill of materials and the checksums of all. Nothing
# leaves this machine: the last line says what to push.
#
# Refused are changed files, a CHANGELOG.md without a section of this version, and a version that is another commit's. Where it
# fails, it takes its tag away again; the same command on the same commit makes the same release again.
#
#   cmake/release.sh [--check]        --check: only says whether it could be made
set -euo pipefail
root="$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")/.." && pwd)"
cd -- "$root"
refuse() {
  echo "release.sh: $*" >&2
  exit 1
}
if (($# > 1)) || [[ "${1:---check}" != --check ]]; then
  echo "release.sh [--check]" >&2
  exit 2
fi

version=$(sed -En 's/^project\(poise VERSION ([0-9.]+).*/\1/p' CMakeLists.txt)
tag="v$version"
if [[ -n $(git status --porcelain) ]]; then refuse "files differ from the commit; see git status"; fi
grep -Eq "^## \[$version\] - [0-9]{4}-[0-9]{2}-[0-9]{2}$" CHANGELOG.md ||
  refuse "CHANGELOG.md has no section '## [$version] - $(date +%F)'; what is in [Unreleased] goes there"
tagged=$(git rev-parse --quiet --verify "refs/tags/$tag^{commit}" || true)
if [[ -n $tagged && $tagged != "$(git rev-parse HEAD)" ]]; then
  refuse "$tag is commit ${tagged:0:12}; a new release needs a new VERSION in CMakeLists.txt"
fi
if (($# == 1)); then
  echo "$tag can be released"
  exit 0
fi

folder="build/$tag"
rm -rf -- "$folder"
if [[ -z $tagged ]]; then
  git tag --annotate --message="Poise $version" "$tag"
  trap 'git tag --delete "$tag" >&2' EXIT
fi
cmake/package.sh
mkdir -p -- "$folder"
mv -- build/packages/*.deb "$folder/"
git archive --format=tar.gz --prefix="poise-$version/" --output="$folder/poise-$version.tar.gz" "$tag"
cmake/sbom.py >"$folder/poise-$version.cdx.json"
(cd -- "$folder" && sha256sum -- * >SHA256SUMS)
trap - EXIT
ls -l -- "$folder"
echo "$folder is the release; git push origin $tag publishes its commit"
