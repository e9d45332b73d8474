#!/usr/bin/env python3
"""Where the time of a sample goes, by part: the thesis's scenes and a Cornell box, on both backends.

CPU backend: `perf` takes samples of the program, built with line tables. The part of a sample is that of the innermost
function, inlined or not, that belongs to one. Rays of cameras, bounces and shadows are intersected by the same functions.
Vulkan: the same scene with parts switched off, in milliseconds of a sample; the differences are what the parts cost.

Needs perf and binutils (Debian: linux-perf, binutils), for Vulkan an adapter. Prints two tables in Markdown.
"""

import argparse
import collections
import os
import pathlib
import re
import statistics
import subprocess
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
SCENES = {
    "a": "thesis/diffuse-sphere",
    "b": "thesis/metal-room-rough-50",
    "e": "thesis/emitting-spheres",
    "f": "thesis/grey-mandelbulb",
    "g": "thesis/three-spheres",
    "Cornell": "benchmarks/cornell-box",
}
# Estimators whose cost does not depend on a probe.
PLAIN = "--splitting 1 --path-reuse off --light-samples 1 --emitter-edges off".split()

# Part of a function by its file and name; the first rule that matches counts.
PARTS = [
    ("random numbers", r"sampling/sobol"),
    ("field", r"(entry|dispatch)\.rs .*distance|graph/distance|fractals/.* distance"),
    ("normals", r"(entry|dispatch)\.rs .*gradient|graph/(surface|leaf|tree_surface)|shading/surface_interaction"),
    ("intersection", r"(entry|dispatch)\.rs .*(ray|interval)|graph/(analytic|bvh)|graph\.rs|intersect/"),
    ("textures", r"textur"),
    ("lights", r"light_sampling|light_tree|scene/light|scene/sky|escaped_radiance"),
    ("shading", r"opaque_surfaces|/materials/|path\.rs .*shade|sampling/basis"),
    ("shadow rays", r"integrator/shadow"),
    ("camera rays", r"integrator/camera"),
    ("paths", r"integrator/"),
    ("film and file", r"backend/|output/|film|job/|miniz|deflate|exr"),
]
VARIANTS = {
    "first hits": ["--mode", "albedo"],
    "first surface": ["--bounces", "0"],
    "second": ["--bounces", "1"],
    "third and fourth": ["--bounces", "3"],
}


def build():
    """Program with line tables, without the window."""
    target = ROOT / "target/profile"
    environment = dict(os.environ, CARGO_TARGET_DIR=str(target), CARGO_PROFILE_RELEASE_STRIP="false")
    environment["CARGO_PROFILE_RELEASE_DEBUG"] = "line-tables-only"
    command = ["cargo", "build", "--release", "-p", "pathmarch", "--no-default-features"]
    subprocess.run(command, cwd=ROOT, env=environment, check=True)
    return target / "release/pathmarch"


def render(program, scene, picture, samples, options):
    """Command that renders a scene."""
    file = ROOT / f"scenes/{SCENES[scene]}.kdl"
    return [str(program), "render", str(file), "-o", str(picture), "--samples", str(samples), *options]


def output(command, **options):
    return subprocess.run(command, check=True, capture_output=True, text=True, **options).stdout


def frames_of(program, addresses):
    """Functions at each address of the program, innermost first, as "file function"."""
    lines = output(["addr2line", "-afiC", "-e", str(program)], input="\n".join(map(hex, addresses))).splitlines()
    frames, position = [], 0
    while position < len(lines):
        if lines[position].startswith("0x"):
            frames.append([])
            position += 1
        else:
            frames[-1].append(f"{lines[position + 1]} {lines[position]}")
            position += 2
    return frames


def part_of(frames):
    for frame in frames:
        file = re.sub(r":[\d?]+( \(discriminator \d+\))? ", " ", frame)
        for part, rule in PARTS:
            if re.search(rule, file):
                return part
    return "other"


def cpu_profile(program, scene, folder, samples):
    """Share of each part, percent."""
    data = folder / "perf.data"
    options = ["--backend", "cpu", "--size", "640x360", "--bounces", "3", *PLAIN]
    command = render(program, scene, folder / "picture.exr", samples, options)
    output(["perf", "record", "-q", "-F", "1999", "-o", str(data), "--", *command])
    maps = output(["perf", "script", "-i", str(data), "--show-mmap-events"])
    mapped = re.search(r"MMAP2.*?\[0x(\w+)\(0x\w+\) @ (\w+) .*r-xp " + re.escape(str(program)), maps)
    start, offset = int(mapped[1], 16), int(mapped[2], 16)
    segments = [line.split() for line in output(["readelf", "-lW", str(program)]).splitlines() if "LOAD" in line]
    code = next(words for words in segments if "E" in words[6:8])
    base = start - offset + int(code[1], 16) - int(code[2], 16)
    found, others = collections.Counter(), 0
    for line in output(["perf", "script", "-i", str(data), "-F", "ip,sym,symoff,dso"]).splitlines():
        if line.rstrip().endswith(f"({program})"):
            found[int(line.split()[0], 16) - base] += 1
        elif line.strip():
            others += 1
    parts = collections.Counter({"other": others})
    for frames, count in zip(frames_of(program, list(found)), found.values()):
        parts[part_of(frames)] += count
    total = sum(parts.values())
    return {part: 100.0 * count / total for part, count in parts.items()}


def milliseconds(program, scene, folder, options):
    """Milliseconds of a sample of 1280x720."""

    def seconds(samples):
        estimators = [] if "--mode" in options else PLAIN
        settings = ["--backend", "gpu", "--size", "1280x720", *options, *estimators]
        start = time.monotonic()
        output(render(program, scene, folder / "picture.exr", samples, settings))
        return time.monotonic() - start

    # Both numbers of samples are above the one from which kernels contain the numbers of the scene.
    few, many = 4, 36
    return (seconds(many) - seconds(few)) / (many - few) * 1000.0


def table(title, columns, rows):
    print(f"\n| {title} | " + " | ".join(columns) + " |\n|---|" + "---|" * len(columns))
    for name, values in rows:
        print(f"| {name} | " + " | ".join(values) + " |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", default=list(SCENES), help=f"of {', '.join(SCENES)}; all by default")
    parser.add_argument("--rounds", type=int, default=3, help="rounds on Vulkan; 0 leaves it out")
    arguments = parser.parse_args()
    if unknown := set(arguments.scenes) - set(SCENES):
        parser.error(f"no scene {', '.join(sorted(unknown))}; there are {', '.join(SCENES)}")
    program = build()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        profiles = [cpu_profile(program, scene, folder, 8 if scene == "f" else 32) for scene in arguments.scenes]
        parts = [part for part, _ in PARTS] + ["other"]
        rows = [(part, [f"{profile.get(part, 0.0):.0f}" for profile in profiles]) for part in parts]
        table("CPU, percent of the samples", arguments.scenes, rows)
        # Kernels of sphere-traced scenes are slow: their marches are all of it.
        scenes = [scene for scene in arguments.scenes if scene != "f"]
        times = {(scene, variant): [] for scene in scenes for variant in VARIANTS}
        for _ in range(arguments.rounds):
            for scene, variant in times:
                times[scene, variant].append(milliseconds(program, scene, folder, VARIANTS[variant]))
        if arguments.rounds:
            medians = {key: statistics.median(values) for key, values in times.items()}
            rows = [(variant, [f"{medians[scene, variant]:.0f}" for scene in scenes]) for variant in VARIANTS]
            table("Vulkan, ms up to this part", scenes, rows)


if __name__ == "__main__":
    main()
