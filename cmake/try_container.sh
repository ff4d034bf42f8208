#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Builds the image of cmake/Containerfile by Debian's buildah and uses it: a run, and a sweep whose folder is outside of it. The
# base image `debian:12` is a bare Debian that is made here from Debian's packages, so no registry of images is asked. Needs root,
# the network, buildah, debootstrap and git; some minutes of processor time and 4 GB. All that it makes is in FOLDER, and the
# image is left there as FOLDER/poise.tar.
#
#   cmake/try_container.sh FOLDER
set -euo pipefail
root="$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")/.." && pwd)"
folder="$(realpath -m -- "${1:?try_container.sh FOLDER}")"

mkdir -p -- "$folder/results"
engine() { buildah --root "$folder/images" --runroot "$folder/run" "$@"; }
inside() { engine run --isolation chroot --volume "$folder/results:/results" "$container" -- "$@"; }

if ! engine inspect --type image debian:12 >/dev/null 2>&1; then
  "$root/cmake/bare_debian.sh" "$folder/debian"
  container=$(engine from scratch)
  tar -C "$folder/debian" -cf "$folder/debian.tar" .
  engine add --quiet "$container" "$folder/debian.tar" / >/dev/null
  engine commit --quiet --rm "$container" debian:12 >/dev/null
fi
rm -rf -- "$folder/sources"
git clone --quiet "file://$root" "$folder/sources"
report=()
if [[ -f "$root/viewer/build/figures.html" ]]; then
  cp -r -- "$root/viewer/build" "$folder/sources/viewer/build"
  report=(--report /results/report)
fi
engine build --isolation chroot --pull-never --file "$folder/sources/cmake/Containerfile" --tag poise "$folder/sources"

container=$(engine from --pull-never localhost/poise)
trap 'engine rm "$container" >/dev/null' EXIT
inside poise --version
inside poise run two-body --frames 60 --quiet
cat >"$folder/results/spec.json" <<'SPEC'
{"schema": "poise.sweep/1", "scenes": ["gas"], "settings": {"frames": 20, "clock": "work", "threads": 1}, "axes": {"bodies": [20, 40]}}
SPEC
inside poise sweep /results/spec.json --out /results/sweep "${report[@]}"
engine push --quiet localhost/poise "oci-archive:$folder/poise.tar"
ls -l "$folder/poise.tar" "$folder"/results/*
