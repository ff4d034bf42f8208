#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Tries the packages of build/packages (cmake/package.sh) as docs/install.md says, in a bare Debian 12: installs them by apt with all
# that they depend on, uses them as a user who is not root, purges them, and looks for what is left. Needs root, the network
# and debootstrap. FOLDER must not exist, or be a bare Debian that an earlier call made.
#
#   cmake/try_packages.sh FOLDER
set -euo pipefail
root="$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")/.." && pwd)"
folder="$(realpath -m -- "${1:?try_packages.sh FOLDER}")"

# Mounts are seen by this process and its children alone, and end with them.
if [[ -z "${POISE_IN_MOUNTS:-}" ]]; then POISE_IN_MOUNTS=1 exec unshare --mount -- "$0" "$@"; fi
fail() {
  echo "try_packages.sh: FAILED: $*" >&2
  exit 1
}
debs=("$root"/build/packages/*.deb)
[[ -e ${debs[0]} ]] || fail "no packages in build/packages; cmake/package.sh makes them"

"$root/cmake/bare_debian.sh" "$folder"
mount --bind /proc "$folder/proc"
mount --bind /dev "$folder/dev"
inside() { env -i PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin HOME=/root DEBIAN_FRONTEND=noninteractive chroot "$folder" "$@"; }
# as_user LINE: by a user with a home of its own, in that.
as_user() { inside su tester -c "cd && $1"; }
# Files of the system: neither those of people nor those that Debian itself writes when packages come and go.
files() { (cd -- "$folder" && find . -xdev -type f -o -xdev -type l) | grep -Ev '^\./(var|tmp|root|srv|proc|dev|debs|etc/ld\.so\.cache)' | sort; }

has_page() { [[ $(as_user "man $1 | head -n 1") == *Poise* ]] || fail "man $1"; }
install() { inside apt-get -q install -y --no-install-recommends "$@"; }
# Removes the packages and what they brought, and fails where a file of theirs is left.
purge_all() {
  inside apt-get -q purge -y "${names[@]}"
  inside apt-get -q autoremove -y --purge
  files >"$folder/tmp/after"
  local left
  left=$(comm -13 "$folder/tmp/before" "$folder/tmp/after")
  [[ -z $left ]] || fail "left behind: $left"
}

inside apt-get -q update
inside id tester >/dev/null 2>&1 || inside useradd --create-home --home-dir /srv/tester --shell /bin/bash tester
rm -rf -- "$folder/debs"
mkdir -- "$folder/debs"
cp -- "${debs[@]}" "$folder/debs/"
names=()
declare -A deb_of
for deb in "${debs[@]}"; do
  names+=("$(dpkg-deb -f "$deb" Package)")
  deb_of[${names[-1]}]=/debs/$(basename -- "$deb")
done

# The programs and the module, in a Debian that has nothing but what they bring.
files >"$folder/tmp/before"
bare=$(inside dpkg-query -f '.\n' -W | wc -l)
install "${deb_of[poise]}"
as_user 'poise --version && poise run jacks --bodies 100 --frames 60 --quiet --json run.json'
as_user 'printf %s "{\"schema\": \"poise.sweep/1\", \"scenes\": [\"gas\"], \"settings\": {\"frames\": 20, \"clock\": \"work\"},
  \"axes\": {\"bodies\": [20, 40]}}" >spec.json && poise sweep spec.json'
as_user 'poise import /usr/share/poise/scenes/robots/table.xml -o table.json && poise check table.json'
as_user 'poise tree /usr/share/poise/scenes/robots/arm.urdf --depth 1 --quiet -o spheres.urdf'
install "${deb_of[poise-study]}"
as_user 'poise study order --help >/dev/null'
install "${deb_of[python3-poise]}"
as_user 'python3 -c "import poise; poise.World().step(); print(poise.read_run(\"run.json\")[\"schema\"], poise.SceneRun(\"jacks\", bodies=20).run(5)[-1].total_ms > 0)"'
install "${deb_of[libpoise-dev]}"
purge_all

# What is for people at a terminal, and for programs that are built against it.
install man-db bash-completion g++ cmake make pkg-config
files >"$folder/tmp/before"
install "${deb_of[@]}"
has_page poise
while read -r name; do has_page "poise-$name"; done < <(
  as_user 'poise --help' | sed -n '/^Subcommands:/,/^$/p' | sed -En 's/^  ([a-z][a-z-]*) .*/\1/p')
# bash-completion finds the package's file by the name of the command.
as_user 'bash -c ". /usr/share/bash-completion/bash_completion && _completion_loader poise
  COMP_WORDS=(poise run av) COMP_CWORD=2 && _poise && echo \${COMPREPLY[*]}"' | grep -qw avalanche || fail "completion"
rm -rf -- "$folder"/srv/tester/hello
cp -r -- "$root/examples/hello" "$folder/srv/tester/hello"
inside chown -R tester: /srv/tester/hello
as_user 'cmake -S hello -B hello/build >/dev/null && cmake --build hello/build >/dev/null && hello/build/hello'
as_user 'c++ -std=c++20 hello/hello.cpp -o by-pkg-config $(pkg-config --cflags --libs poise) && ./by-pkg-config >/dev/null'
purge_all
echo "try_packages.sh: ${names[*]}: installed, used and purged in a Debian $(<"$folder/etc/debian_version") of $bare packages"
