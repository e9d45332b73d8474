#!/bin/sh
# Renders a still on a Slurm cluster, in an array job and a merge that depends on it:
#
#     submit.sh SCENE SAMPLES PARTS OUTPUT [options of pathmarch render]
#
# Prints the number of the merge job. The files are on a file system that all nodes share. PATHMARCH names the program there;
# SBATCH_OPTIONS are further options for the array job, such as --gres=gpu:1.
set -eu
SCENE=$1 SAMPLES=$2 PARTS=$3 OUTPUT=$4
shift 4
OPTIONS=$*
FARM=$(cd "$(dirname "$0")/.." && pwd)
export SCENE SAMPLES PARTS OUTPUT OPTIONS FARM
mkdir -p "$OUTPUT.parts"
# shellcheck disable=SC2086
array=$(sbatch --parsable --array="0-$((PARTS - 1))" ${SBATCH_OPTIONS:-} "$FARM/slurm/render.sbatch")
sbatch --parsable --dependency="afterok:$array" "$FARM/slurm/merge.sbatch"
