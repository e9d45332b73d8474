#!/usr/bin/env python3
"""Measures the time of the window's frames while the camera is dragged.

    scripts/window_frames.py [--drags 60] [--rounds 1] [--scene SCENE] [PROGRAM...]

Starts each program with --timings, drags the camera for a fifth of a second each time, quits, and prints the line with the
median and the longest frame. Several programs take turns, so that they are compared under the same load. Needs Xvfb and
xdotool.
"""

import argparse
import pathlib
import tempfile
import time

from screen import Screen

ROOT = pathlib.Path(__file__).resolve().parent.parent


def measure(program, scene, drags):
    """The line about frames that a program prints."""
    with tempfile.TemporaryDirectory() as directory:
        screen = Screen(directory, "1360x860")
        log = pathlib.Path(directory) / "log"
        try:
            with log.open("w") as file:
                running = screen.start(program, "view", str(scene), "--timings", log=file)
                time.sleep(2)
                for drag in range(drags):
                    left, right = (500, 420), (760, 470)
                    screen.drag(*((left, right) if drag % 2 else (right, left)))
                screen.key("ctrl+q")
                running.wait(timeout=60)
        finally:
            screen.stop()
        lines = [line for line in log.read_text().splitlines() if "frames of the window" in line]
        return lines[-1].strip() if lines else "no frames were reported"


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("programs", nargs="*", default=[str(ROOT / "target/release/pathmarch")])
    parser.add_argument("--drags", type=int, default=60)
    parser.add_argument("--scene", default=str(ROOT / "scenes/thesis/diffuse-sphere.kdl"))
    parser.add_argument("--rounds", type=int, default=1)
    options = parser.parse_args()
    for _ in range(options.rounds):
        for program in options.programs:
            print(f"{program}: {measure(program, options.scene, options.drags)}", flush=True)


if __name__ == "__main__":
    main()
