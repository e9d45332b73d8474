#!/bin/sh
# Renders one part of the samples of a still, for any engine that runs commands:
#
#     part.sh SCENE SAMPLES PARTS INDEX OUTPUT.film [options of pathmarch render]
#
# PARTS is a number of parts, or a list of their ends such as 0,5,17,64. INDEX counts from 0. A part that is run again goes on from the checkpoint that an interrupted run has left, and gives the same film.
# If the checkpoint is of another machine's backend, the part begins anew. PATHMARCH names the program.
set -eu
scene=$1 samples=$2 parts=$3 index=$4 output=$5
shift 5
program=${PATHMARCH:-pathmarch}

# Films are smallest if parts start at multiples of 16 samples.
cut_at() {
    unit=1
    [ $((samples / parts)) -lt 16 ] || unit=16
    if [ "$1" -ge "$parts" ]; then echo "$samples"; else echo $((samples * $1 / parts / unit * unit)); fi
}
case $parts in
*,*) range=$(echo "$parts" | cut -d, -f$((index + 1)))..$(echo "$parts" | cut -d, -f$((index + 2)))/$samples ;;
*) range="$(cut_at "$index")..$(cut_at $((index + 1)))/$samples" ;;
esac

# A scheduler stops a task with SIGTERM; the program writes its checkpoint and ends.
trap 'kill -TERM "$child" 2>/dev/null || true' TERM INT
render() {
    "$program" render "$scene" --samples "$range" -o "$output" "$@" &
    child=$!
    code=0
    wait "$child" || code=$?
    # A signal ends the first wait, not the program.
    while kill -0 "$child" 2>/dev/null; do
        code=0
        wait "$child" || code=$?
    done
    return "$code"
}
code=0
render --resume "$@" || code=$?
if [ "$code" = 2 ]; then
    code=0
    render "$@" || code=$?
fi
exit "$code"
