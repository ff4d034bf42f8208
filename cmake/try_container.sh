#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Goes through cmake/Containerfile without a container engine: a bare Debian 12 of Debian's own packages (mmdebstrap) in
# FOLDER, the committed sources copied into it, each RUN by chroot, and then the command with a run and a sweep. Needs root,
# the network, mmdebstrap and git; six minutes of processor time. FOLDER must not exist, or be a bare Debian that an earlier call
# made.
#
#   cmake/try_container.sh FOLDER
set -euo pipefail
root="$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")/.." && pwd)"
folder="$(realpath -m -- "${1:?try_container.sh FOLDER}")"
recipe="$root/cmake/Containerfile"

# Mounts are seen by this process and its children alone, and end with them.
if [[ -z "${POISE_IN_MOUNTS:-}" ]]; then
  POISE_IN_MOUNTS=1 exec unshare --mount -- "$0" "$@"
fi
[[ "$(sed -n 's/^FROM //p' "$recipe")" == debian:12 ]] || { echo "try_container.sh: $recipe is not FROM debian:12" >&2; exit 2; }
target="$(sed -n 's/^COPY \. //p' "$recipe")"
if [[ ! -x "$folder/bin/bash" ]]; then mmdebstrap --variant=minbase bookworm "$folder"; fi
mkdir -p -- "$(dirname -- "$folder$target")"
git clone --quiet "file://$root" "$folder$target"
mount --bind /proc "$folder/proc"
mount --bind /dev "$folder/dev"
cp -L /etc/resolv.conf "$folder/etc/resolv.conf"

inside() { env -i PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin HOME=/root chroot "$folder" /bin/sh -c "$1"; }
while IFS= read -r step; do
  echo "try_container.sh: $step" >&2
  inside "$step" </dev/null
done < <(sed -n 's/^RUN //p' "$recipe")

command="$(sed -En 's/^ENTRYPOINT \["(.*)"\]$/\1/p' "$recipe")"
inside "$command --version"
inside "$command run two-body --frames 60 --quiet"
cat >"$folder/opt/spec.json" <<'SPEC'
{"schema": "poise.sweep/1", "scenes": ["gas"], "settings": {"frames": 20, "clock": "work", "threads": 1}, "axes": {"bodies": [20, 40]}}
SPEC
inside "$command sweep /opt/spec.json --out /opt/results"
