#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Makes the pictures of README and docs again, each by one command, and fails where a picture has no command.
#
#   docs/make_pictures.sh --list            the pictures, how long each takes, and its command
#   docs/make_pictures.sh --check           compares this list with docs/images and with what the pages show
#   docs/make_pictures.sh                   makes the short ones
#   docs/make_pictures.sh levels.png ...    makes these, however long they take
#
# POISE names the command (default: build/release/src/app/poise). Times stand in the pictures of studies: let nothing else run.
set -euo pipefail
cd -- "$(dirname -- "${BASH_SOURCE[0]}")/.."
export POISE=${POISE:-build/release/src/app/poise} IMAGES=docs/images

# name | short or long | command; OUT is the file
list() {
  cat <<'END'
accuracy.png | long | $POISE study accuracy --picture OUT
avalanche.png | short | $POISE run avalanche --frames 110 --clock work --picture-size 640x360 --picture OUT --quiet
billiards.png | short | $POISE run billiards --frames 110 --clock work --picture-size 640x360 --picture OUT --quiet
compliance.png | long | $POISE study compliance --picture OUT
constant-time.png | long | $POISE study constant-time --picture OUT
film.webp | short | docs/make_film.py $POISE OUT
gallery.png | short | $POISE run gallery --frames 110 --clock work --picture-size 640x360 --picture OUT --quiet
error-time.png | long | $POISE study error-time --picture OUT
gaze.png | long | $POISE study gaze --picture OUT
jacks.png | short | $POISE run jacks --frames 230 --clock work --budget-work 200 --picture OUT --quiet
levels.png | long | $POISE study levels --picture OUT
live.png | long | POISE_COMMAND=$POISE node viewer/screenshots.mjs live
maze.png | short | $POISE run maze --frames 90 --clock work --picture-size 640x360 --picture OUT --quiet
overload.png | long | $POISE study overload --picture OUT
population.png | long | $POISE study population --picture OUT
report-compare.png | long | POISE_COMMAND=$POISE node viewer/screenshots.mjs
report-dark.png | long | POISE_COMMAND=$POISE node viewer/screenshots.mjs
report-light.png | long | POISE_COMMAND=$POISE node viewer/screenshots.mjs
rooms.svg | short | cmake --build build/release --target architecture_picture
street.png | short | $POISE run street --frames 90 --clock work --picture-size 640x360 --picture OUT --quiet
strips.png | short | $POISE study strips --picture OUT --quiet
tree-forearm.png | short | $POISE tree /usr/share/doc/simbody/examples/src/TaskSpaceControl-UR10/geometry/Forearm.obj --picture OUT --quiet
tree-l.png | short | $POISE tree scenes/meshes/l.obj --picture OUT --quiet
END
}

names() { list | sed 's/ |.*//' | sort; }

check() {
  local failed=0 name page
  for name in $(comm -13 <(names) <(ls "$IMAGES" | sort)); do
    echo "$IMAGES/$name: no command in docs/make_pictures.sh makes it"
    failed=1
  done
  for name in $(comm -23 <(names) <(ls "$IMAGES" | sort)); do
    echo "docs/make_pictures.sh: $name is not in $IMAGES"
    failed=1
  done
  for page in README.md docs/*.md scenes/README.md; do
    for name in $(grep -oE '\]\([^)]*images/[^)]*\)' "$page" | sed 's/.*images\///; s/)$//'); do
      [[ -e $IMAGES/$name ]] && continue
      echo "$page: shows images/$name, which is not there"
      failed=1
    done
  done
  for name in $(ls "$IMAGES"); do
    grep -qF "images/$name)" README.md docs/*.md scenes/README.md && continue
    echo "$IMAGES/$name: no page shows it"
    failed=1
  done
  return $failed
}

make() {
  local name=$1 command
  command=$(list | sed -n "s/^${name//./\\.} | [a-z]* | //p")
  if [[ -z $command ]]; then
    echo "docs/make_pictures.sh: $name is none of $(names | paste -sd ' ')" >&2
    exit 2
  fi
  echo "$name"
  eval "${command//OUT/$IMAGES/$name}"
}

case ${1:-} in
  --list) list ;;
  --check) check ;;
  -*)
    sed -n '3,11s/^# \{0,1\}//p' "${BASH_SOURCE[0]}" >&2
    exit 2
    ;;
  "") for name in $(list | sed -n 's/ | short | .*//p'); do make "$name"; done ;;
  *) for name in "$@"; do make "$name"; done ;;
esac
