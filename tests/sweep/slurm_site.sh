#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# A Slurm of this machine alone for the tests, with daemons, keys, ports and files of its own: nothing of the system's
# Slurm or munge is touched, and no systemd is needed.
#   slurm_site.sh start FOLDER    writes FOLDER/slurm.conf and starts munged, slurmctld and slurmd; waits for the node
#   slurm_site.sh stop FOLDER     ends all three and what they started
#   slurm_site.sh run COMMAND...  runs a command with such a Slurm, ends it behind the command, and returns its exit code
# Exit code 77: Slurm or munge is not installed, this user is not root, or its daemons do not start on this machine.
set -euo pipefail

usage() {
  echo "slurm_site.sh start|stop FOLDER, or slurm_site.sh run COMMAND..." >&2
  exit 2
}

if (($# < 2)); then usage; fi
action="$1"
if [[ "$action" == run ]]; then folder="$(mktemp -d)"; else folder="$(realpath -- "$2")"; fi
export SLURM_CONF="$folder/slurm.conf"

stop() {
  local name pid i
  if [[ -f "$SLURM_CONF" ]]; then
    timeout 10 scancel --user=root 2>/dev/null || true
    for ((i = 0; i < 50; ++i)); do
      if [[ -z "$(timeout 5 squeue --noheader 2>/dev/null)" ]]; then break; fi
      sleep 0.1
    done
  fi
  # What they know is thrown away, so none is asked to save it.
  for name in slurmctld slurmd munged; do
    if [[ -f "$folder/$name.pid" ]]; then kill -KILL "$(<"$folder/$name.pid")" 2>/dev/null || true; fi
  done
  # Each step of a job has a daemon of its own, which works in the folder of the log; and tasks may outlive it.
  for pid in /proc/[0-9]*; do
    if [[ "$(cat -- "$pid/comm" 2>/dev/null)" == slurmstepd && "$(readlink -- "$pid/cwd")" == "$folder" ]] ||
      { grep -qz "^SLURM_CONF=$SLURM_CONF$" "$pid/environ" && grep -qz "^SLURM_JOB_ID=" "$pid/environ"; } 2>/dev/null; then
      kill -KILL "${pid#/proc/}" 2>/dev/null || true
    fi
  done
}

# The tests are of sweeps, not of what a machine lets Slurm do.
cannot() {
  echo "$1" >&2
  tail -n 20 -- "$folder/slurmctld.log" "$folder/slurmd.log" >&2 || true
  stop
  exit 77
}

start() {
  local program
  for program in munged slurmctld slurmd sbatch scontrol squeue; do
    command -v "$program" >/dev/null || { echo "$program is not installed (cmake/install_packages.sh sweep-test)" >&2; exit 77; }
  done
  ((EUID == 0)) || { echo "only root can start Slurm's daemons" >&2; exit 77; }
  local host cpus memory port
  host="$(hostname -s)"
  cpus="$(nproc)"
  memory="$(awk '/^MemTotal/ {print int($2 / 2048)}' /proc/meminfo)"
  # Below the ports that the system gives away, so that nobody has them by chance.
  port=$((12000 + $$ % 8000 * 2))
  mkdir -p -- "$folder/munge" "$folder/state" "$folder/spool"
  chmod 755 -- "$folder/munge"
  (umask 077 && head -c 128 /dev/urandom >"$folder/munge.key")
  munged --force --key-file="$folder/munge.key" --socket="$folder/munge/socket" --pid-file="$folder/munged.pid" \
    --log-file="$folder/munged.log" --seed-file="$folder/munge.seed" || cannot "munged does not start here:"
  cat >"$SLURM_CONF" <<CONF
ClusterName=poise_test
SlurmctldHost=$host(127.0.0.1)
SlurmUser=root
SlurmdUser=root
SlurmctldPort=$port
SlurmdPort=$((port + 1))
AuthType=auth/munge
AuthInfo=socket=$folder/munge/socket
CredType=cred/munge
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/slurmd.pid
SlurmctldLogFile=$folder/slurmctld.log
SlurmdLogFile=$folder/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerType=sched/backfill
SchedulerParameters=batch_sched_delay=0,sched_interval=1,sched_min_interval=1000,bf_interval=1
AccountingStorageType=accounting_storage/none
JobAcctGatherType=jobacct_gather/none
MaxArraySize=12
KillWait=1
MinJobAge=300
ReturnToService=2
NodeName=$host NodeAddr=127.0.0.1 CPUs=$cpus RealMemory=$memory State=UNKNOWN
PartitionName=test Nodes=$host Default=YES MaxTime=INFINITE State=UP
CONF
  slurmctld -c || cannot "slurmctld does not start here:"
  slurmd -c || cannot "slurmd does not start here:"
  local i
  for ((i = 0; i < 200; ++i)); do
    if [[ "$(timeout 5 sinfo --noheader --format=%T 2>/dev/null)" == idle ]]; then return 0; fi
    sleep 0.1
  done
  cannot "the node did not become idle here:"
}

run() {
  trap 'stop; rm -rf -- "$folder"' EXIT
  start
  "$@"
}

case "$action" in
  start) start ;;
  stop) stop ;;
  run) shift; run "$@" ;;
  *) usage ;;
esac
