#!/usr/bin/env python3
"""Kills the program at random moments, and checks that nothing is torn and nothing lost.

    scripts/kill.py [--count N] [--seed N] [PROGRAM]        default: 1000 kills, target/release/pathmarch

Renders a still, frames, a merge and an export again and again, and ends each with SIGKILL after a random part of its time. After each kill,
every file under a final name must be whole. A still goes on with --resume until it is complete; it must then be the picture of one
render, and a run must not start before the last checkpoint of the one before.
"""

import argparse
import json
import pathlib
import random
import shutil
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
SCENE = """pathmarch 1
camera { position 0 1 4; target 0 1 0 }
render { size 96 72; samples 48; bounces 3 }
sky 0.8
material "white" { diffuse 0.7 }
object "floor" material="white" { plane }
object "ball" { sphere 0.7 { at "0.1 * t" 0.7 0 } }
"""


class Work:
    """Runs the program in a directory."""

    def __init__(self, program, directory):
        self.program, self.directory = program, directory
        (directory / "room.kdl").write_text(SCENE)
        (directory / "solid.kdl").write_text(SCENE.replace('object "floor" material="white" { plane }\n', ""))
        self.kills = 0

    def command(self, *arguments):
        return [self.program, *arguments]

    def run(self, *arguments):
        """Runs it to its end."""
        environment = {"PATHMARCH_CHECKPOINT_SECONDS": "0.02", "PATH": "/usr/bin:/bin", "HOME": str(self.directory)}
        done = subprocess.run(self.command(*arguments), cwd=self.directory, capture_output=True, env=environment)
        if done.returncode != 0:
            sys.exit(f"{arguments}: {done.returncode}: {done.stderr.decode()}")
        return done.stderr.decode() + done.stdout.decode()

    def killed(self, longest, *arguments):
        """Kills it after a random time; true if it was still running."""
        environment = {"PATHMARCH_CHECKPOINT_SECONDS": "0.02", "PATH": "/usr/bin:/bin", "HOME": str(self.directory)}
        child = subprocess.Popen(
            self.command(*arguments), cwd=self.directory, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=environment
        )
        try:
            child.wait(random.uniform(0, longest))
            return False
        except subprocess.TimeoutExpired:
            child.kill()
            child.wait()
            self.kills += 1
            return True

    def seconds(self, *arguments):
        started = time.monotonic()
        self.run(*arguments)
        return time.monotonic() - started

    def samples(self, checkpoint):
        """Samples of a checkpoint, 0 if there is none; it must not be torn."""
        for name in (checkpoint, checkpoint + ".previous"):
            path = self.directory / name
            if path.exists():
                text = path.read_bytes()
                header = json.loads(text[12 : 12 + int.from_bytes(text[8:12], "little")])
                assert text[-8:] == b"PMFILM.E", f"{name} is torn"
                samples = 0
                for region in header["regions"]:
                    samples += sum(end - start for start, end in region["blocks"])
                    samples += sum(count for _, count in region["layers"])
                return samples
        return 0

    def check(self):
        """Checks all files under final names."""
        for path in self.directory.iterdir():
            if path.name.startswith("."):
                continue
            if path.suffix in (".png", ".exr"):
                self.run("compare", path.name, path.name)
            elif path.suffix == ".film":
                self.run("merge", path.name, "-o", ".check.film")
            elif path.suffix == ".stl":
                size = path.stat().st_size
                triangles = int.from_bytes(path.read_bytes()[80:84], "little")
                assert size == 84 + 50 * triangles, f"{path} is torn"


def still(work, seconds, denoise=(), whole="whole.exr"):
    """A still that is killed until it is complete."""
    arguments = ("render", "room.kdl", "--backend", "cpu", "-o", "a.exr", "--resume", *denoise)
    (work.directory / "a.exr").unlink(missing_ok=True)
    before = 0
    for attempt in range(12):
        if not work.killed(seconds * 0.8, *arguments):
            break
        work.check()
        now = work.samples("a.exr.checkpoint")
        assert now >= before or (work.directory / "a.exr").exists(), f"{now} samples after {before}"
        before = now
    else:
        work.run(*arguments)
    work.run("compare", "a.exr", whole, "--max-relmse", "0")
    assert not (work.directory / "a.exr.checkpoint").exists()


def denoised(work, seconds):
    still(work, seconds, ("--denoise",), "denoised.exr")


def frames(work, seconds):
    arguments = ("render", "room.kdl", "--backend", "cpu", "--samples", "4", "--frames", "1-6", "-o", "f-#.png", "--skip-existing")
    for number in range(1, 7):
        (work.directory / f"f-{number}.png").unlink(missing_ok=True)
    while work.killed(seconds * 0.7, *arguments):
        work.check()
    for number in range(1, 7):
        work.run("compare", f"f-{number}.png", f"whole-{number}.png", "--max-relmse", "0")


def merge(work, seconds):
    (work.directory / "m.film").unlink(missing_ok=True)
    for _ in range(6):
        work.killed(seconds, "merge", "1.film", "2.film", "-o", "m.film")
        work.check()


def export(work, seconds):
    for _ in range(4):
        work.killed(seconds, "export", "solid.kdl", "-o", "a.stl", "--resolution", "96")
        work.check()


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program", nargs="?", default=ROOT / "target/release/pathmarch", type=pathlib.Path)
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    random.seed(options.seed)
    directory = pathlib.Path(tempfile.mkdtemp())
    work = Work(str(options.program.resolve()), directory)
    cpu = ("--backend", "cpu")
    still_seconds = work.seconds("render", "room.kdl", *cpu, "-o", "whole.exr")
    denoised_seconds = work.seconds("render", "room.kdl", *cpu, "--denoise", "-o", "denoised.exr")
    frame_seconds = work.seconds("render", "room.kdl", *cpu, "--samples", "4", "--frames", "1-6", "-o", "whole-#.png")
    work.run("render", "room.kdl", *cpu, "--samples", "0..19", "-o", "1.film")
    work.run("render", "room.kdl", *cpu, "--samples", "19..48", "-o", "2.film")
    merge_seconds = work.seconds("merge", "1.film", "2.film", "-o", "m.film")
    export_seconds = work.seconds("export", "solid.kdl", "-o", "a.stl", "--resolution", "96")
    kinds = [(still, still_seconds), (denoised, denoised_seconds), (frames, frame_seconds), (merge, merge_seconds), (export, export_seconds)]
    started, counts = time.monotonic(), dict.fromkeys((kind.__name__ for kind, _ in kinds), 0)
    while work.kills < options.count:
        kind, seconds = kinds[random.randrange(len(kinds))]
        before = work.kills
        kind(work, seconds)
        counts[kind.__name__] += work.kills - before
        if work.kills // 50 > before // 50:
            print(f"{work.kills} kills in {time.monotonic() - started:.0f} s: {counts}", flush=True)
    work.run("render", "room.kdl", *cpu, "-o", "a.exr")
    left = [path.name for path in directory.iterdir() if path.name.endswith(".part") and path.name.startswith(".a.exr.")]
    assert not left, f"the next run of an output removes what was left of it: {left}"
    print(f"{work.kills} kills in {time.monotonic() - started:.0f} s: {counts}; no torn file, every still complete")
    shutil.rmtree(directory)


if __name__ == "__main__":
    main()
