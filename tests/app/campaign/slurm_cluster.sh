#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# A Slurm of one node on this machine, in a folder: munged, slurmctld and slurmd on ports that are free.
#   slurm_cluster.sh start DIR     then SLURM_CONF=DIR/slurm.conf sbatch ...
#   slurm_cluster.sh stop DIR
set -euo pipefail
verb=$1 dir=$2

stop() {
  for name in slurmd slurmctld munged; do
    [[ -s $dir/$name.pid ]] || continue
    pid=$(cat "$dir/$name.pid")
    kill "$pid" 2>/dev/null || true
    for _ in $(seq 100); do
      kill -0 "$pid" 2>/dev/null || break
      sleep 0.1
    done
  done
}

if [[ $verb == stop ]]; then
  stop
  exit 0
fi

mkdir -p "$dir"/{state,spool}
chmod 755 "$dir"
read -r ctld_port d_port < <(python3 - <<'PORTS'
import socket
sockets = [socket.socket() for _ in range(2)]
for s in sockets: s.bind(("127.0.0.1", 0))
print(*(s.getsockname()[1] for s in sockets))
PORTS
)
dd if=/dev/urandom of="$dir/munge.key" bs=128 count=1 status=none
chmod 400 "$dir/munge.key"
munged --key-file="$dir/munge.key" --socket="$dir/munge.socket" --pid-file="$dir/munged.pid" \
  --log-file="$dir/munged.log" --seed-file="$dir/munge.seed" --num-threads=1 --force
host=$(hostname -s)
cat >"$dir/slurm.conf" <<CONF
ClusterName=kestrel
SlurmctldHost=$host(127.0.0.1)
SlurmUser=$(id -un)
SlurmdUser=$(id -un)
AuthType=auth/munge
AuthInfo=socket=$dir/munge.socket
CredType=cred/munge
SlurmctldPort=$ctld_port
SlurmdPort=$d_port
SlurmctldPidFile=$dir/slurmctld.pid
SlurmdPidFile=$dir/slurmd.pid
SlurmctldLogFile=$dir/slurmctld.log
SlurmdLogFile=$dir/slurmd.log
StateSaveLocation=$dir/state
SlurmdSpoolDir=$dir/spool
ProctrackType=proctrack/pgid
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerParameters=sched_interval=1
ReturnToService=2
MpiDefault=none
NodeName=$host NodeAddr=127.0.0.1 CPUs=$(nproc) State=UNKNOWN
PartitionName=all Nodes=$host Default=YES MaxTime=INFINITE State=UP
CONF
echo "CgroupPlugin=cgroup/v1" >"$dir/cgroup.conf"  # which does nothing unless a plugin asks for it
export SLURM_CONF=$dir/slurm.conf
slurmctld -f "$dir/slurm.conf" || { stop; exit 1; }
slurmd -f "$dir/slurm.conf" || { stop; exit 1; }
for _ in $(seq 150); do
  [[ $(sinfo --noheader --format=%T 2>/dev/null) == idle ]] && exit 0
  sleep 0.2
done
sinfo >&2 || true
tail -n 20 "$dir"/slurm*.log >&2 || true
stop
exit 1
