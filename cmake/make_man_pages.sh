#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Makes the pages of the manual from what the commands say of themselves, by help2man:
#
#   cmake/make_man_pages.sh FOLDER PROGRAM...
#
# writes FOLDER/NAME.1.gz for each program (poise, poise-study) and FOLDER/NAME-COMMAND.1.gz for each of its commands.
set -euo pipefail

folder=${1:?folder of the pages}
shift
command -v help2man >/dev/null || {
  echo "make_man_pages.sh: help2man is missing (package help2man)" >&2
  exit 1
}
mkdir -p -- "$folder"
scratch=$(mktemp -d)
trap 'rm -rf -- "$scratch"' EXIT

# page NAME SUMMARY PROGRAM ARGUMENT...: NAME.1.gz from `PROGRAM ARGUMENT... --help`.
page() {
  local name=$1 summary=$2
  shift 2
  printf '#!/bin/sh\nexec %s --help\n' "$(printf '%q ' "$@")" >"$scratch/$name"
  chmod +x -- "$scratch/$name"
  # CLI11 writes -h,--help, which help2man takes for one word.
  help2man --no-info --no-discard-stderr --name="$summary" --version-string="$name $version" --manual="Poise" \
    --source="Poise $version" "$scratch/$name" | sed -E 's/^\.TH [^ ]+/.TH '"${name^^}"'/; s/^\\fB\\-h\\fR,\\-\\-help/\\fB\\-h\\fR, \\fB\\-\\-help\\fR/' \
    >"$scratch/$name.1"
  if [[ -n ${see_also:-} ]]; then printf '.SH "SEE ALSO"\n%s\n' "$see_also" >>"$scratch/$name.1"; fi
  gzip -9 -n -c -- "$scratch/$name.1" >"$folder/$name.1.gz"
}

# The words that begin the rows of a list of --help, and the rest of the row.
rows() { sed -n '/^'"$1"':/,/^$/p' | sed -En 's/^  ([a-z][a-z-]*)  +(.*)/\1 \2/p'; }

for program in "$@"; do
  name=$(basename -- "$program")
  version=$("$program" --version | sed -E 's/^[a-z-]+ //; s/ .*//')
  help=$("$program" --help)
  mapfile -t commands < <(rows Subcommands <<<"$help")
  see_also=""
  for row in "${commands[@]}"; do see_also+="${see_also:+, }.BR $name-${row%% *} (1)"; done
  see_also=$(sed 's/, \.BR/ ,\n.BR/g' <<<"$see_also")
  first=$(head -n 1 <<<"$help")
  first=${first%.}
  page "$name" "${first#Poise }" "$program"
  see_also=".BR $name (1)"
  for row in "${commands[@]}"; do
    # `poise study` has the page of the program that it starts.
    if [[ $name-${row%% *} != poise-study ]]; then page "$name-${row%% *}" "${row#* }" "$program" "${row%% *}"; fi
  done
done
