#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Makes the pictures of README and docs again, each by one command, and fails where a picture has no command. Charts come
# in two: NAME.png is light and NAME-dark.png dark, and one command makes both.
#
#   docs/make_pictures.sh --list            the pictures, how long each takes, and its command
#   docs/make_pictures.sh --check           compares this list with docs/images and with what the pages show, and looks for the tables
#   docs/make_pictures.sh                   makes the short ones
#   docs/make_pictures.sh levels.png ...    makes these, however long they take
#
# POISE names the command (default: build/release/src/app/poise). A study measures for long, and nothing else should run: the
# pictures of some are therefore drawn from the tables that the pages show of it (docs/table_figures.py).
set -euo pipefail
cd -- "$(dirname -- "${BASH_SOURCE[0]}")/.."
export POISE=${POISE:-build/release/src/app/poise} IMAGES=docs/images

# name | short or long | command; OUT is the file, DARK the same on a dark ground
list() {
  cat <<'END'
accuracy.png | long | $POISE study accuracy --picture OUT --picture-dark DARK
avalanche.png | short | $POISE run avalanche --frames 110 --clock work --picture-size 640x360 --picture OUT --quiet
billiards.png | short | $POISE run billiards --frames 110 --clock work --picture-size 640x360 --picture OUT --quiet
compliance.png | short | from_table compliance OUT DARK
constant-time.png | short | from_table constant-time OUT DARK
film.webp | short | docs/make_film.py $POISE OUT
gallery.png | short | $POISE run gallery --frames 110 --clock work --picture-size 640x360 --picture OUT --quiet
error-time.png | long | $POISE study error-time --picture OUT --picture-dark DARK
gaze.png | long | $POISE study gaze --picture OUT --picture-dark DARK
jacks.png | short | $POISE run jacks --frames 230 --clock work --budget-work 200 --picture OUT --quiet
levels.png | short | from_table levels OUT DARK
live.png | long | POISE_COMMAND=$POISE node viewer/screenshots.mjs live
maze.png | short | $POISE run maze --frames 90 --clock work --picture-size 640x360 --picture OUT --quiet
overload.png | short | from_table overload OUT DARK
population.png | short | from_table population OUT DARK
report-compare.png | long | POISE_COMMAND=$POISE node viewer/screenshots.mjs
report-dark.png | long | POISE_COMMAND=$POISE node viewer/screenshots.mjs
report-light.png | long | POISE_COMMAND=$POISE node viewer/screenshots.mjs
rooms.svg | short | cmake --build build/release --target architecture_picture
street.png | short | $POISE run street --frames 90 --clock work --picture-size 640x360 --picture OUT --quiet
strips.png | short | $POISE study strips --picture OUT --picture-dark DARK --quiet
tree-forearm.png | short | $POISE tree /usr/share/doc/simbody/examples/src/TaskSpaceControl-UR10/geometry/Forearm.obj --picture OUT --picture-dark DARK --quiet
tree-l.png | short | $POISE tree scenes/meshes/l.obj --picture OUT --picture-dark DARK --quiet
END
}

# With the dark ones.
names() { list | sed -n 'h; s/ |.*//p; g; s/^\([^ ]*\)\.png |.*DARK.*/\1-dark.png/p' | sort; }

# Draws the figures of a study from its table in the docs: study, file, dark file.
from_table() {
  local figures
  figures=$(mktemp --suffix .json)
  docs/table_figures.py "$1" >"$figures"
  $POISE study draw "$figures" --picture "$2" --picture-dark "$3"
  rm "$figures"
}

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
    for name in $(grep -oE '(\]\(|src="|srcset=")[^)"]*images/[^)"]*' "$page" | sed 's/.*images\///'); do
      [[ -e $IMAGES/$name ]] && continue
      echo "$page: shows images/$name, which is not there"
      failed=1
    done
  done
  for name in $(ls "$IMAGES"); do
    grep -qE "images/${name//./\\.}[)\"]" README.md docs/*.md scenes/README.md && continue
    echo "$IMAGES/$name: no page shows it"
    failed=1
  done
  for name in $(list | sed -n 's/.*from_table \([^ ]*\) .*/\1/p'); do
    docs/table_figures.py "$name" >/dev/null 2>&1 && continue
    echo "docs/table_figures.py: finds no table of the study $name"
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
  command=${command//DARK/$IMAGES/${name%.png}-dark.png}
  eval "${command//OUT/$IMAGES/$name}"
}

case ${1:-} in
  --list) list ;;
  --check) check ;;
  -*)
    sed -n '3,13s/^# \{0,1\}//p' "${BASH_SOURCE[0]}" >&2
    exit 2
    ;;
  "") for name in $(list | sed -n 's/ | short | .*//p'); do make "$name"; done ;;
  *) for name in "$@"; do make "$name"; done ;;
esac
