#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Makes a bare Debian 12 in FOLDER by debootstrap: its essential packages and apt, nothing else. It gets this machine's
# names of hosts and settings of apt, so that the network is reached as from here. Needs root and the network. A FOLDER that
# an earlier call made is kept.
#
#   cmake/bare_debian.sh FOLDER [MIRROR]
set -euo pipefail
folder="${1:?bare_debian.sh FOLDER [MIRROR]}"
if [[ ! -x "$folder/bin/bash" ]]; then
  command -v debootstrap >/dev/null || { echo "bare_debian.sh: debootstrap is missing (package debootstrap)" >&2; exit 1; }
  debootstrap --variant=minbase bookworm "$folder" ${2:+"$2"} >&2
fi
for file in /etc/resolv.conf /etc/hosts; do
  if [[ -e "$file" ]]; then cp -L -- "$file" "$folder$file"; fi
done
cp -Ln -- /etc/apt/apt.conf.d/* "$folder/etc/apt/apt.conf.d/" 2>/dev/null || true
