#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Makes the Debian packages of a build and tries them: deb_test.sh SOURCE BUILD FOLDER VERSION COMPILER. Where it runs as
# root it installs them by dpkg below FOLDER, uses them, purges them and looks for what is left; else it unpacks them.
set -euo pipefail
source=$1 build=$2 folder=$3 version=$4 compiler=$5

if ! command -v help2man >/dev/null || ! command -v dpkg-deb >/dev/null; then
  echo "skipped: needs help2man and dpkg (cmake/install_packages.sh package)"
  exit 77
fi
fail() {
  echo "FAILED: $*" >&2
  exit 1
}
rm -rf -- "$folder"
mkdir -p -- "$folder/debs" "$folder/root/var/lib/dpkg/"{info,updates}
(cd -- "$build" && cpack -B "$folder/debs") >"$folder/cpack.log" 2>&1 || fail "cpack: $(tail -n 20 "$folder/cpack.log")"
debs=("$folder/debs/"*.deb)
packages=(libpoise-dev poise-study poise)
if grep -q '^POISE_PYTHON:BOOL=ON' "$build/CMakeCache.txt"; then packages=(python3-poise "${packages[@]}"); fi
[[ ${#debs[@]} -eq ${#packages[@]} ]] || fail "${#debs[@]} packages instead of ${#packages[@]}"
for deb in "${debs[@]}"; do
  [[ $(dpkg-deb -f "$deb" Version) == "$version" ]] || fail "$deb is not of version $version"
done
[[ $(dpkg-deb -f "$folder"/debs/poise-study_*.deb Depends) == *"poise (= $version)"* ]] || fail "poise-study works without poise"
[[ $(dpkg-deb -f "$folder"/debs/poise_*.deb Depends) == *libtbb12* ]] || fail "poise needs no library"

root=$folder/root
as_root=0
if ((EUID == 0)); then as_root=1; fi
if ((as_root)); then
  touch -- "$root/var/lib/dpkg/status" "$root/var/lib/dpkg/available"
  # What they depend on is not below this root.
  dpkg --root="$root" --force-depends -i "${debs[@]}" >"$folder/dpkg.log" 2>&1 || fail "dpkg -i: $(cat "$folder/dpkg.log")"
else
  for deb in "${debs[@]}"; do dpkg-deb -x "$deb" "$root"; done
fi

poise=$root/usr/bin/poise
"$poise" scenes | grep -q '^jacks ' || fail "no scenes"
"$poise" run two-body --frames 20 --clock work --no-time-priors --quiet --json "$folder/run.json" || fail "poise run"
grep -q '"state_hash"' "$folder/run.json" || fail "no figures"
"$poise" study strips --help | grep -q Usage || fail "poise study"

# Each command has its page, and each page is one that man can show.
man=$root/usr/share/man/man1
while read -r name; do
  [[ -s $man/poise-$name.1.gz ]] || fail "poise $name has no page"
done < <("$poise" --help | sed -n '/^Subcommands:/,/^$/p' | sed -En 's/^  ([a-z][a-z-]*) .*/\1/p')
zcat "$man/poise-run.1.gz" | grep -q -- 'deadline' || fail "the page of poise run has no options"
for page in "$man"/*.gz; do
  zcat "$page" | head -n 5 | grep -q '^\.SH NAME' || fail "$page is no page"
done

# Completion says what --help says.
(
  PATH=$root/usr/bin:$PATH
  . "$root/usr/share/bash-completion/completions/poise"
  completes() {
    local wanted=$1
    shift
    COMP_WORDS=("$@") COMP_CWORD=$(($# - 1))
    _poise
    [[ " ${COMPREPLY[*]} " == *" $wanted "* ]] || fail "'$*' is not completed by $wanted but by '${COMPREPLY[*]}'"
  }
  completes replay poise re
  completes avalanche poise run av
  completes --deadline poise run jacks --dead
  completes fitted poise run jacks --contact ""
  completes levels poise study l
  completes --models poise study levels --m
  for policy in $(COMP_WORDS=(poise run jacks --policy "") COMP_CWORD=4 && _poise && echo "${COMPREPLY[*]}"); do
    [[ -e $policy || $("$poise" run --help | tr '\n' ' ') == *"$policy"* ]] || fail "no policy $policy"
  done
)

if [[ ${packages[0]} == python3-poise ]] && /usr/bin/python3 -c 'import numpy' 2>/dev/null; then
  modules=$(dirname -- "$(dirname -- "$(find "$root/usr" -path '*/poise/__init__.py')")")
  PYTHONPATH=$modules PYTHONDONTWRITEBYTECODE=1 /usr/bin/python3 -c 'import poise; poise.World().step()' || fail "the Python module"
fi

# A program by pkg-config, without CMake.
pc=$(dirname -- "$(find "$root/usr" -name poise.pc)")
read -ra flags < <(PKG_CONFIG_PATH=$pc pkg-config --cflags --libs poise-scene)
"$compiler" -std=c++20 "-DSCENES=\"$root/usr/share/poise/scenes\"" "$source/tests/package/scene/scene_alone.cpp" \
  -o "$folder/program" "${flags[@]}" || fail "a program by pkg-config"
"$folder/program" || fail "that program"

if command -v lintian >/dev/null; then
  lintian --allow-root --fail-on error "${debs[@]}" >"$folder/lintian.log" 2>&1 || fail "lintian: $(grep ^E: "$folder/lintian.log")"
fi

if ((as_root)); then
  dpkg --root="$root" --purge "${packages[@]}" >>"$folder/dpkg.log" 2>&1 || fail "dpkg --purge: $(cat "$folder/dpkg.log")"
  left=$(find "$root" -path "$root/var" -prune -o -type f -print)
  [[ -z $left ]] || fail "left behind: $left"
fi
echo "${#debs[@]} packages of $version installed, used and removed"
