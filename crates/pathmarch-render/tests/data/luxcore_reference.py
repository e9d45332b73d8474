#!/usr/bin/env python3
"""Makes the reference `seen_caustics` with LuxCore's bidirectional path tracing: the light that a ball and a block of glass
focus, seen directly, through a pane, through the block and in a mirror. Mitsuba's `ptracer` shows none of the latter.

    pip install pyluxcore==2.11.2 OpenEXR numpy
    python3 luxcore_reference.py --seconds 1000              # writes seen_caustics.exr and seen_caustics.kdl
    python3 luxcore_reference.py --seconds 5 --out /tmp      # a noisy one

Conventions: `BIDIRCPU` without Russian roulette before the twentieth event, box pixel filter, no tone mapping, linear
Rec. 709, half-float EXR. The ball is a mesh of 82,000 triangles with smooth normals. A pixel of LuxCore is one row lower
than ours; its window is moved by that. `BIDIRVMCPU` was tried and is 5 % too dark in front of the pane, where `PATHCPU`,
`BIDIRCPU`, and ours with `caustics "sampled"` and `"traced"` agree.
"""

import argparse
import math
import os
import time

import numpy as np
import OpenEXR  # before LuxCore, whose allocator breaks it
import pyluxcore

SIZE = (96, 72)
HERE = os.path.dirname(os.path.abspath(__file__))

KDL = """pathmarch 1
// The light that a ball and a block of glass focus, seen directly, through a pane, through the block and in a mirror.
// Written by luxcore_reference.py, which renders the picture beside this file.
camera "main" { position 0.2 1.5 3.2; target 0 0.25 0; fov 36 }
render { size 96 72; bounces 12; caustics "traced" }
material "lamp" { emit 40 38 34 }
material "floor" { diffuse 0.6 0.55 0.5 }
material "clear" { glass 1; ior 1.5; roughness 0 }
material "mirror" { metal 0.9; edge 0.9; roughness 0 }
object "lamp" material="lamp" { rect 0.4 0.4 { rotate 180 0 0; at -0.4 2.6 0.2 } }
object "floor" material="floor" { rect 20 20 }
object "ball" material="clear" { sphere 0.3 { at -0.5 0.7 0 } }
object "block" material="clear" { box 0.6 0.4 0.3 { rotate 0 25 0; at 0.55 0.3 0.3 } }
object "pane" material="clear" { box 0.7 0.6 0.04 { rotate 0 10 0; at -0.4 0.4 0.9 } }
object "mirror" material="mirror" { box 1.6 0.9 0.04 { rotate 0 -8 0; at 0 0.5 -0.9 } }
"""


def turned(degrees, axis):
    """Rotation about x (0) or y (1)."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    matrix, (i, j) = np.eye(3), [(1, 2), (2, 0)][axis]
    matrix[i, i] = matrix[j, j] = c
    matrix[i, j], matrix[j, i] = -s, s
    return matrix


def rect(width, depth, turn, at):
    corners = np.array([[-width, 0, -depth], [-width, 0, depth], [width, 0, depth], [width, 0, -depth]]) / 2
    return corners @ turn.T + at, [(0, 1, 2), (0, 2, 3)], None


def box(size, turn, at):
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * np.array(size) / 2
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return corners @ turn.T + at, [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))], None


def ball(radius, at, subdivisions=6):
    """Icosahedron, subdivided."""
    g = (1 + 5**0.5) / 2
    points = [(-1, g, 0), (1, g, 0), (-1, -g, 0), (1, -g, 0), (0, -1, g), (0, 1, g)]
    points += [(0, -1, -g), (0, 1, -g), (g, 0, -1), (g, 0, 1), (-g, 0, -1), (-g, 0, 1)]
    faces = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2), (10, 7, 6)]
    faces += [(7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5), (2, 4, 11), (6, 2, 10)]
    faces += [(8, 6, 7), (9, 8, 1)]
    points = [np.array(p) / np.linalg.norm(p) for p in points]
    for _ in range(subdivisions):
        middles, finer = {}, []

        def middle(a, b):
            key = (min(a, b), max(a, b))
            if key not in middles:
                p = points[a] + points[b]
                middles[key] = len(points)
                points.append(p / np.linalg.norm(p))
            return middles[key]

        for a, b, c in faces:
            x, y, z = middle(a, b), middle(b, c), middle(c, a)
            finer += [(a, x, z), (b, y, x), (c, z, y), (x, y, z)]
        faces = finer
    normals = np.array(points)
    return normals * radius + at, faces, normals


def scene():
    made, properties = pyluxcore.Scene(), pyluxcore.Properties()

    def set_all(prefix, values):
        for key, value in values.items():
            properties.Set(pyluxcore.Property(f"{prefix}.{key}", value))

    set_all("scene.materials.lamp", {"type": "matte", "kd": [0, 0, 0], "emission": [40, 38, 34]})
    set_all("scene.materials.floor", {"type": "matte", "kd": [0.6, 0.55, 0.5]})
    set_all("scene.materials.clear", {"type": "glass", "kr": [1, 1, 1], "kt": [1, 1, 1], "interiorior": 1.5})
    set_all("scene.materials.mirror", {"type": "mirror", "kr": [0.9, 0.9, 0.9]})
    shapes = {
        "lamp": ("lamp", rect(0.4, 0.4, turned(180, 0), [-0.4, 2.6, 0.2])),
        "floor": ("floor", rect(20, 20, np.eye(3), [0, 0, 0])),
        "ball": ("clear", ball(0.3, [-0.5, 0.7, 0])),
        "block": ("clear", box([0.6, 0.4, 0.3], turned(25, 1), [0.55, 0.3, 0.3])),
        "pane": ("clear", box([0.7, 0.6, 0.04], turned(10, 1), [-0.4, 0.4, 0.9])),
        "mirror": ("mirror", box([1.6, 0.9, 0.04], turned(-8, 1), [0, 0.5, -0.9])),
    }
    tuples = lambda rows, kind: [tuple(kind(value) for value in row) for row in rows]
    for name, (material, (points, faces, normals)) in shapes.items():
        smooth = None if normals is None else tuples(normals, float)
        made.DefineMesh(name, tuples(points, float), tuples(faces, int), smooth, None, None, None)
        set_all(f"scene.objects.{name}", {"shape": name, "material": material})
    aspect, shift = SIZE[0] / SIZE[1], -2 / SIZE[1]
    set_all("scene.camera", {"type": "perspective", "lookat.orig": [0.2, 1.5, 3.2], "lookat.target": [0, 0.25, 0]})
    set_all("scene.camera", {"up": [0, 1, 0], "fieldofview": 36.0, "autofocus.enable": 0, "lensradius": 0.0})
    set_all("scene.camera", {"screenwindow": [-aspect, aspect, -1 + shift, 1 + shift]})
    made.Parse(properties)
    return made


def render(engine, seconds, seed):
    properties = pyluxcore.Properties()
    for key, value in {
        "renderengine.type": engine,
        "renderengine.seed": seed,
        "sampler.type": "RANDOM" if engine == "BIDIRVMCPU" else "SOBOL",
        "film.width": SIZE[0],
        "film.height": SIZE[1],
        "film.filter.type": "NONE",
        "film.imagepipelines.0.0.type": "NOP",
        "film.outputs.0.type": "RGB_IMAGEPIPELINE",
        "film.outputs.0.filename": "unused.exr",
        "film.outputs.0.index": 0,
        "path.maxdepth": 20,
        "light.maxdepth": 20,
        "path.pathdepth.total": 20,
        "path.pathdepth.diffuse": 20,
        "path.pathdepth.glossy": 20,
        "path.pathdepth.specular": 20,
    }.items():
        properties.Set(pyluxcore.Property(key, value))
    session = pyluxcore.RenderSession(pyluxcore.RenderConfig(properties, scene()))
    session.Start()
    began = time.time()
    while time.time() - began < seconds:
        time.sleep(0.1)
        session.UpdateStats()
    took = time.time() - began
    pixels = np.zeros(SIZE[0] * SIZE[1] * 3, dtype=np.float32)
    session.GetFilm().GetOutputFloat(pyluxcore.FilmOutputType.RGB_IMAGEPIPELINE, pixels, 0)
    return pixels.reshape(SIZE[1], SIZE[0], 3)[::-1], took


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--seconds", type=float, default=1000)
    parser.add_argument("--engine", default="BIDIRCPU")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", default=HERE)
    arguments = parser.parse_args()
    pyluxcore.Init()
    picture, took = render(arguments.engine, arguments.seconds, arguments.seed)
    name = os.path.join(arguments.out, "seen_caustics")
    with open(name + ".kdl", "w") as file:
        file.write(KDL)
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    OpenEXR.File(header, {"RGB": np.ascontiguousarray(picture.astype(np.float16))}).write(name + ".exr")
    print(f"{took:.1f} s, mean {picture.mean(axis=(0, 1))}", flush=True)
    os._exit(0)  # LuxCore's destructors crash
