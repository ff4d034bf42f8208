#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# What cmake/release.sh refuses, in a clone, and that sources without git know their commit: release_test.sh SOURCE FOLDER CMAKE.
set -euo pipefail
source=$1 folder=$2 cmake=$3
if ! git -C "$source" rev-parse HEAD >/dev/null 2>&1; then
  echo "skipped: the sources are no clone of git"
  exit 77
fi
fail() {
  echo "FAILED: $*" >&2
  exit 1
}
export GIT_AUTHOR_NAME=test GIT_AUTHOR_EMAIL=test@invalid GIT_COMMITTER_NAME=test GIT_COMMITTER_EMAIL=test@invalid
rm -rf -- "$folder"
git clone --quiet --no-tags --shared "$source" "$folder/clone"
cd -- "$folder/clone"
cp -- "$source/cmake/release.sh" "$source/cmake/commit.txt" "$source/cmake/write_build_info.cmake" cmake/
cp -- "$source/.gitattributes" .
sed -Ei 's/^## \[[0-9].*//' CHANGELOG.md
git add --all
git commit --quiet --allow-empty --message "without a section"

# says WORDS CODE ARGUMENT...: release.sh ends so.
says() {
  local words=$1 code=$2 said status=0
  shift 2
  said=$(cmake/release.sh "$@" 2>&1) || status=$?
  [[ $status -eq $code && $said == *"$words"* ]] || fail "release.sh $* ended with $status: $said"
}
version=$(sed -En 's/^project\(poise VERSION ([0-9.]+).*/\1/p' CMakeLists.txt)
says "release.sh [--check]" 2 --now
says "CHANGELOG.md has no section '## [$version] - " 1
printf '\n## [%s] - 2026-01-31\n' "$version" >>CHANGELOG.md
says "files differ from the commit" 1
git commit --quiet --all --message "a section"
says "v$version can be released" 0 --check
git tag "v$version"
says "v$version can be released" 0 --check
git tag --force "v$version" HEAD~ >/dev/null
says "v$version is commit $(git rev-parse HEAD~ | head -c 12)" 1
[[ ! -e build ]] || fail "what was refused has left build"

# With packages that take no time to make: what becomes of the tag, and what is in the folder.
printf '#!/bin/sh\nmkdir -p build/packages && echo "$(git describe --exact-match --tags)" >build/packages/poise.deb && [ ! -e ../fails ]\n' >cmake/package.sh
git commit --quiet --all --message "packages"
git tag --delete "v$version" >/dev/null
touch ../fails
says "Deleted tag 'v$version'" 1
[[ -z $(git tag) ]] || fail "a release that failed has left a tag"
rm -- ../fails
says "git push origin v$version" 0
(cd -- "build/v$version" && sha256sum --check --quiet SHA256SUMS) || fail "checksums"
[[ $(<"build/v$version/poise.deb") == "v$version" && $(wc -l <"build/v$version/SHA256SUMS") -eq 3 ]] || fail "$(ls -l "build/v$version")"
tar -xOf "build/v$version/poise-$version.tar.gz" "poise-$version/cmake/commit.txt" | grep -qx "$(git rev-parse HEAD)" || fail "sources"
says "git push origin v$version" 0

# The version stands in one place.
! git grep -nE "\"version\": *\"$version\"" -- '*package.json' || fail "the version stands twice"

mkdir -- ../archive
git archive HEAD | tar -x -C ../archive
"$cmake" -DGIT= -DSOURCE_DIR="$folder/archive" -DOUTPUT="$folder" -DVERSION="$version" -DCOMPILER=none -DBUILD_TYPE=none \
  -P "$folder/archive/cmake/write_build_info.cmake"
grep -q "POISE_BUILD_COMMIT \"$(git rev-parse HEAD | head -c 12)\"" "$folder/build_info.h" || fail "$(cat "$folder/build_info.h")"
"$cmake" -DGIT= -DSOURCE_DIR="$folder/clone" -DOUTPUT="$folder" -DVERSION="$version" -DCOMPILER=none -DBUILD_TYPE=none \
  -P cmake/write_build_info.cmake
grep -q 'POISE_BUILD_COMMIT "unknown"' "$folder/build_info.h" || fail "a commit that nobody knows: $(cat "$folder/build_info.h")"
