#!/usr/bin/env bash
# Runs the recipes of this directory on one machine: Slurm with a controller and two nodes, Open Job Description, and Dask.
# Cuts a still of 64 samples into seven uneven parts over the three engines, kills two tasks, and compares the merged picture with that of one
# render, bit by bit. Then runs each recipe as a whole. Needs the built program, Debian's slurm-wlm, and Python with venv.
#
#     farm/test.sh [PROGRAM]          default: target/release/pathmarch
set -euo pipefail
farm=$(cd "$(dirname "$0")" && pwd)
root=$(dirname "$farm")
PATHMARCH=$(realpath "${1:-$root/target/release/pathmarch}")
export PATHMARCH
work=$(mktemp -d)
started=()

finish() {
    code=$?
    for pid in "${started[@]}"; do kill "$pid" 2>/dev/null || true; done
    [ "$code" = 0 ] || { tail -n 20 "$work"/*.log "$work"/*.out 2>/dev/null || true; }
    wait 2>/dev/null || true
    rm -rf "$work"
    exit "$code"
}
trap finish EXIT

say() { printf '%4d s  %s\n' "$SECONDS" "$*"; }

if ! command -v slurmctld >/dev/null; then
    apt-get update -qq
    apt-get install -y -qq --no-install-recommends slurm-wlm
fi
venv=$root/target/farm-venv
if ! "$venv/bin/python" -c 'import distributed, openjd.cli' 2>/dev/null; then
    python3 -m venv "$venv"
    "$venv/bin/python" -m pip install --quiet openjd-cli==0.8.0 dask==2026.8.0 distributed==2026.8.0
fi

# Slurm: a controller and two nodes of one core each.
start_slurm() {
    host=$(hostname -s)
    cat >"$work/slurm.conf" <<CONF
ClusterName=test
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=16817
AuthType=auth/none
CredType=cred/none
SlurmUser=root
SlurmdUser=root
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool-%n
SlurmdPidFile=$work/slurmd-%n.pid
SlurmctldPidFile=$work/slurmctld.pid
SlurmdLogFile=$work/slurmd-%n.log
SlurmctldLogFile=$work/slurmctld.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
ReturnToService=2
MailProg=/bin/true
KillWait=10
SchedulerParameters=sched_interval=1,batch_sched_delay=0
NodeName=one NodeHostname=$host NodeAddr=127.0.0.1 Port=16818 CPUs=1 State=UNKNOWN
NodeName=two NodeHostname=$host NodeAddr=127.0.0.1 Port=16819 CPUs=1 State=UNKNOWN
PartitionName=all Nodes=one,two Default=YES MaxTime=INFINITE State=UP
CONF
    mkdir "$work/state"
    export SLURM_CONF=$work/slurm.conf
    slurmctld -D -i >/dev/null 2>&1 &
    started+=($!)
    for node in one two; do
        slurmd -D -N "$node" >/dev/null 2>&1 &
        started+=($!)
    done
    for _ in $(seq 60); do
        if sinfo -h -o %T 2>/dev/null | grep -q idle; then return; fi
        sleep 1
    done
    echo "the nodes of Slurm do not start" >&2
    exit 1
}

# Waits until a file is there.
wait_for() {
    for _ in $(seq 600); do
        if [ -e "$1" ]; then return; fi
        sleep 0.2
    done
    echo "$1 does not appear" >&2
    exit 1
}

cd "$work"
cp "$root/scenes/cornell.kdl" scene.kdl
samples=64
cuts=0,5,17,18,31,48,61,64
options=(--backend cpu --size 320x240)
"$PATHMARCH" render scene.kdl --samples $samples "${options[@]}" -o whole.exr 2>whole.log
say "one render: $(sed -n 's/.* in \(.*\)/\1/p' whole.log)"
start_slurm
say "Slurm has two nodes"

# A checkpoint every tenth of a second shows that a task is at work.
export PATHMARCH_CHECKPOINT_SECONDS=0.1
mkdir still.exr.parts
export FARM=$farm SCENE=scene.kdl SAMPLES=$samples PARTS=$cuts OUTPUT=still.exr OPTIONS="${options[*]}"
array=$(sbatch --parsable --array=0-2 -o slurm-%a.out "$farm/slurm/render.sbatch")
wait_for still.exr.parts/1.film.checkpoint
# Preempted: stopped and put back into the queue.
scontrol requeue "${array}_1"
say "Slurm: preempted task 1"
# Slurm would wait two minutes before it runs it again.
for _ in $(seq 30); do
    if scontrol update JobId="${array}_1" StartTime=now 2>/dev/null; then break; fi
    sleep 0.5
done
"$venv/bin/openjd" run "$farm/openjd/render.yaml" --step Render -p Scene="$work/scene.kdl" -p Output="$work/still.exr" \
    -p Farm="$farm" -p Program="$PATHMARCH" -p Samples=$samples -p Parts=$cuts -p PartRange=3-4 \
    -p Options="${options[*]}" >openjd.log 2>&1
say "Open Job Description: parts 3 and 4"
"$venv/bin/python" "$farm/dask/render.py" scene.kdl $samples $cuts still.exr --only 5-6 --options "${options[*]}" \
    >dask.log 2>&1 &
dask=$!
wait_for still.exr.parts/5.film.checkpoint
pkill_pid=$(pgrep -f "render scene.kdl .*still.exr.parts/5.film" | head -n 1)
kill -9 "$pkill_pid"
say "Dask: killed the program of task 5"
wait $dask
say "Dask: parts 5 and 6"
for part in 0 1 2; do wait_for still.exr.parts/$part.film; done
say "Slurm: parts 0 to 2, $(grep -c ' on CPU' slurm-1.out) runs of task 1"
"$PATHMARCH" merge still.exr.parts/*.film -o still.exr 2>merge.log
"$PATHMARCH" compare still.exr whole.exr --max-relmse 0
say "seven parts over three engines are the picture of one render"

# Each recipe as a whole.
unset PATHMARCH_CHECKPOINT_SECONDS
merge=$("$farm/slurm/submit.sh" scene.kdl $samples 4 slurm.exr "${options[@]}")
for _ in $(seq 300); do
    if [ -e slurm.exr ]; then break; fi
    sleep 1
done
"$PATHMARCH" compare slurm.exr whole.exr --max-relmse 0
say "Slurm: array job and merge $merge"
for step in Render Merge; do
    "$venv/bin/openjd" run "$farm/openjd/render.yaml" --step $step -p Scene="$work/scene.kdl" -p Output="$work/openjd.exr" \
        -p Farm="$farm" -p Program="$PATHMARCH" -p Samples=$samples -p Parts=4 -p PartRange=0-3 \
        -p Options="${options[*]}" >>openjd.log 2>&1
done
"$PATHMARCH" compare openjd.exr whole.exr --max-relmse 0
say "Open Job Description: both steps"
"$venv/bin/python" "$farm/dask/render.py" scene.kdl $samples 4 dask.exr --options "${options[*]}" >>dask.log 2>&1
"$PATHMARCH" compare dask.exr whole.exr --max-relmse 0
say "Dask: parts and merge"
