#!/usr/bin/env python3
"""Simulates one frame on many machines: start-up, stragglers, preemption and the merge. Prints the table of docs/farm.md.

    scripts/simulate_farm.py [--seed 0]

The work of a frame is cut into tasks of equal size, several for each machine, which take them from one queue. A machine starts late, has a
speed of its own, and is preempted at random; the task goes on from its last checkpoint on the next machine that is free, or from its
start without one. Then the films are merged in stages.
"""

import argparse
import heapq
import math
import random

# Measured, see docs/farm.md: bytes of a film per pixel, and the program from its start to its first sample.
FILM_BYTES = 13
START_UP = 1.2
PIXELS = 1920 * 1080
# Assumed: bytes a second of the storage, shared by all; films that one merge reads; start of a job by the scheduler, seconds.
NETWORK = 1e9
GROUP = 32
SCHEDULER = 10.0


def merge_seconds(films):
    """Time of the merge tree: each stage reads all of its films through the network, several merges at a time."""
    seconds, left = 0.0, films
    while left > 1:
        merges = math.ceil(left / GROUP)
        # A merge reads at most a tenth of what the network carries.
        rate = min(NETWORK / merges, NETWORK / 10)
        seconds += min(left, GROUP) * PIXELS * FILM_BYTES / rate + START_UP
        left = merges
    return seconds


def simulate(rng, hours, machines, parts, stragglers, preempted, checkpoints):
    """Seconds until the frame is there, and machine seconds that were lost to preemption."""
    work = hours * 3600 / parts
    speed = [rng.lognormvariate(0, 0.1) / (3 if rng.random() < stragglers else 1) for _ in range(machines)]
    free = [(SCHEDULER * rng.random() * 2 + START_UP, machine) for machine in range(machines)]
    heapq.heapify(free)
    # Tasks as the work that is left; a preempted one becomes free again at a time.
    tasks, later, done, lost = [work] * parts, [], 0.0, 0.0
    while tasks or later:
        now, machine = heapq.heappop(free)
        if not tasks or (later and later[0][0] <= now):
            when, left = heapq.heappop(later)
            now = max(now, when)
        else:
            left = tasks.pop()
        takes = left / speed[machine]
        fails = rng.expovariate(preempted / 3600) if preempted else math.inf
        if fails < takes:
            kept = fails // 60 * 60 if checkpoints else 0
            lost += fails - kept
            heapq.heappush(later, (now + fails, left - kept * speed[machine]))
            # The machine comes back after five minutes.
            heapq.heappush(free, (now + fails + 300, machine))
        else:
            done = max(done, now + takes)
            heapq.heappush(free, (now + takes + START_UP, machine))
    return done + merge_seconds(parts), lost


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--runs", type=int, default=20)
    options = parser.parse_args()
    rng = random.Random(options.seed)
    print("| Work, machine hours | Machines | Parts | Stragglers | Preemptions an hour | Checkpoints | Time, s | Efficiency | Lost, machine s |")
    print("|---|---|---|---|---|---|---|---|---|")
    rows = [
        *((100, machines, machines * 4, 0.0, 0.0, True) for machines in (1, 10, 100, 1000)),
        (100, 1000, 1000, 0.05, 0.0, True),
        (100, 1000, 4000, 0.05, 0.0, True),
        (100, 1000, 16000, 0.05, 0.0, True),
        (100, 1000, 4000, 0.05, 0.5, True),
        (100, 1000, 4000, 0.05, 0.5, False),
        (1000, 1000, 4000, 0.05, 0.5, True),
        (1000, 1000, 4000, 0.05, 0.5, False),
        (1, 10, 40, 0.05, 0.5, True),
        (1, 100, 400, 0.05, 0.5, True),
        (1, 1000, 1000, 0.05, 0.5, True),
    ]
    for hours, machines, parts, stragglers, preempted, checkpoints in rows:
        runs = sorted(simulate(rng, hours, machines, parts, stragglers, preempted, checkpoints) for _ in range(options.runs))
        seconds, lost = runs[len(runs) // 2]
        efficiency = hours * 3600 / (seconds * machines)
        print(
            f"| {hours} | {machines} | {parts} | {stragglers:.0%} | {preempted:g} | {'yes' if checkpoints else 'no'} | {seconds:.0f} | "
            f"{efficiency:.0%} | {lost:.0f} |"
        )


if __name__ == "__main__":
    main()
