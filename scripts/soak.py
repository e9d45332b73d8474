#!/usr/bin/env python3
"""Moves and edits a scene in the window for hours, and checks that memory stays flat and no handle is leaked.

    scripts/soak.py [--hours 2] [--warm-up MINUTES] [--interval SECONDS] [PROGRAM] [-- OPTIONS OF view]

Drags, keys and changes of the scene file, numbers and structure, in the window and from outside, follow each other. Each minute a line is
printed: resident memory, open handles, threads, processor time, and how many different pictures the display has shown. The median
of the last quarter must lie within 5 % of that of the quarter after the warm-up, and so must the number of handles.
Needs Xvfb and xdotool.
"""

import argparse
import os
import pathlib
import random
import shutil
import statistics
import sys
import tempfile
import time

from screen import Screen

ROOT = pathlib.Path(__file__).resolve().parent.parent
SHAPES = ["sphere 0.6", "box 0.5 0.5 0.5", "torus 0.5 0.2", "cylinder 0.4 0.8", "cone 0.5 0.9", "octahedron 0.7"]


def scene(rng):
    """Scene with random numbers, and one of a few structures."""
    shape, count = rng.choice(SHAPES), rng.randrange(1, 4)
    balls = "".join(f"    sphere {rng.uniform(0.1, 0.4):.3f} {{ at {rng.uniform(-1, 1):.3f} {rng.uniform(0.3, 1):.3f} 0 }}\n" for _ in range(count))
    return f"""pathmarch 1
camera {{ position 0 1 4; target 0 0.6 0 }}
render {{ size 320 180; samples 8; bounces 3 }}
sky {rng.uniform(0.3, 1):.3f}
material "white" {{ diffuse {rng.uniform(0.1, 0.9):.3f} }}
material "gold" {{ metal "gold" roughness={rng.uniform(0.05, 0.5):.3f} }}
object "floor" material="white" {{ plane }}
object "thing" material="{rng.choice(["white", "gold"])}" {{
  union smooth={rng.uniform(0, 0.3):.3f} {{
    {shape} {{ at 0 {rng.uniform(0.5, 1):.3f} 0 }}
{balls}  }}
}}
"""


def proc(pid):
    """Resident memory in MB, number of handles and threads, and processor seconds."""
    status = pathlib.Path(f"/proc/{pid}/status").read_text()
    fields = dict(line.split(":", 1) for line in status.splitlines())
    times = pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    seconds = (int(times[11]) + int(times[12])) / os.sysconf("SC_CLK_TCK")
    handles = len(os.listdir(f"/proc/{pid}/fd"))
    return int(fields["VmRSS"].split()[0]) / 1024, handles, int(fields["Threads"]), seconds


class Soak:
    def __init__(self, options, directory):
        self.rng = random.Random(options.seed)
        self.file = directory / "scene.kdl"
        self.file.write_text(scene(self.rng))
        self.screen = Screen(directory)
        self.log = open(directory / "log", "w")
        command = ["nice", "-n", "10", str(options.program.resolve()), "view", str(self.file), *options.view]
        # `exec` keeps the process id: nice replaces itself by the program.
        self.program = self.screen.start(*command, log=self.log)
        self.actions = 0

    def point(self):
        width, height = map(int, self.screen.size)
        # In the picture, between the panels.
        return int(width * self.rng.uniform(0.4, 0.6)), int(height * self.rng.uniform(0.3, 0.5))

    def act(self):
        """One random action."""
        rng, screen = self.rng, self.screen
        self.actions += 1
        kind = rng.randrange(10)
        if kind < 3:
            screen.drag(self.point(), self.point(), button=rng.choice([1, 1, 2, 3]))
        elif kind == 3:
            screen.click(*self.point(), button=rng.choice([4, 5]))
        elif kind == 4:
            screen.key(rng.choice(["Home", "f", "c", "w", "s", "a", "d"]))
        elif kind == 5:
            # An edit in the window: a shape is put on the ground, doubled, or neither; undone and redone; and saved.
            screen.click(*self.point())
            screen.key(rng.choice(["g", "1", "2", "3"]))
            screen.key("ctrl+z", "ctrl+y", "ctrl+s", "Escape")
        elif kind == 6:
            screen.key("F4")
            screen.key("F4")
        elif kind == 7:
            width, height = map(int, screen.size)
            size = (width - rng.randrange(100), height - rng.randrange(60))
            screen.xdotool("windowsize", screen.window, *map(str, size))
        else:
            text = scene(rng)
            if rng.randrange(8) == 0:
                text = text.replace("sky", "skyy")
            self.file.with_suffix(".new").write_text(text)
            os.replace(self.file.with_suffix(".new"), self.file)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program", nargs="?", default=ROOT / "target/release/pathmarch", type=pathlib.Path)
    parser.add_argument("--hours", type=float, default=2)
    parser.add_argument("--warm-up", type=float, default=15, help="minutes that are not judged")
    parser.add_argument("--interval", type=float, default=3, help="seconds between actions")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--view", default=[], type=str.split, help="options of view")
    options = parser.parse_args()
    directory = pathlib.Path(tempfile.mkdtemp())
    soak = Soak(options, directory)
    started, pictures, lines = time.monotonic(), set(), []
    try:
        while time.monotonic() - started < options.hours * 3600:
            minute = time.monotonic() + 60
            while time.monotonic() < minute:
                soak.act()
                time.sleep(options.interval)
                pictures.add(soak.screen.picture())
                if soak.program.poll() is not None:
                    sys.exit(f"the window ended with {soak.program.returncode}:\n{(directory / 'log').read_text()}")
            lines.append(proc(soak.program.pid))
            memory, handles, threads, seconds = lines[-1]
            print(
                f"{len(lines):4d} min  {memory:6.1f} MB  {handles:3d} handles  {threads:2d} threads  {seconds:5.0f} s of processor  "
                f"{soak.actions} actions  {len(pictures)} pictures  {soak.screen.title()}",
                flush=True,
            )
    finally:
        soak.screen.stop()
    judged = lines[int(options.warm_up) :]
    quarter = max(1, len(judged) // 4)
    for name, column in (("memory, MB", 0), ("handles", 1)):
        first, last = (statistics.median(line[column] for line in part) for part in (judged[:quarter], judged[-quarter:]))
        print(f"{name}: {first:.1f}, then {last:.1f}: {100 * (last / first - 1):+.1f} %")
        if last > first * 1.05:
            sys.exit(f"{name} grows")
    errors = (directory / "log").read_text()
    if errors:
        print(errors)
    shutil.rmtree(directory)


if __name__ == "__main__":
    main()
