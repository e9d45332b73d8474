"""Rays a second of Embree on one core, with the mesh and the kinds of rays of mesh.rs.

    pip install embreex numpy
    python3 embree.py [TRIANGLES]

Times are CPU seconds, so that other work on the machine does not count. embreex passes rays to Embree one by one.
"""

import sys
import time

import numpy
from embreex import rtcore_scene
from embreex.mesh_construction import TriangleMesh

RAYS = 1_000_000


def bumpy_torus(around, along, bump):
    """Corners of the triangles of `bumpy_torus` in tests/shapes.rs."""
    u, v = numpy.meshgrid(2 * numpy.pi * numpy.arange(around) / around, 2 * numpy.pi * numpy.arange(along) / along, indexing="ij")
    tube = 0.4 * (1 + bump * numpy.sin(7 * u) * numpy.sin(9 * v) + 0.3 * bump * numpy.sin(41 * u + 23 * v))
    ring = 1 + tube * numpy.cos(v)
    points = numpy.stack([ring * numpy.cos(u), tube * numpy.sin(v), ring * numpy.sin(u)], axis=-1).astype(numpy.float32)
    a, b = points, numpy.roll(points, -1, axis=1)
    c, d = numpy.roll(b, -1, axis=0), numpy.roll(points, -1, axis=0)
    return numpy.concatenate([numpy.stack(corners, axis=2).reshape(-1, 3, 3) for corners in ((a, b, c), (a, c, d))])


def camera_rays():
    side = int(RAYS**0.5)
    index = numpy.arange(RAYS)
    x, y = (index % side) / side - 0.5, (index // side) / side - 0.5
    directions = numpy.stack([x, y - 0.6, numpy.full(RAYS, -0.9)], axis=1)
    return numpy.tile(numpy.float32([0, 2, 3]), (RAYS, 1)), directions.astype(numpy.float32)


def random_rays():
    random = numpy.random.default_rng(1)
    origins = random.uniform(-1, 1, (RAYS, 3)) * [1.5, 0.5, 1.5]
    directions = random.normal(size=(RAYS, 3))
    directions /= numpy.linalg.norm(directions, axis=1, keepdims=True)
    return origins.astype(numpy.float32), directions.astype(numpy.float32)


def best_of_three(work):
    seconds = []
    for _ in range(3):
        start = time.process_time()
        work()
        seconds.append(time.process_time() - start)
    return min(seconds)


def main():
    side = round((float(sys.argv[1]) / 2 if len(sys.argv) > 1 else 500_000) ** 0.5)
    corners = numpy.ascontiguousarray(bumpy_torus(side, side, 0.15))
    scene = rtcore_scene.EmbreeScene()
    TriangleMesh(scene, corners)
    start = time.process_time()
    scene.run(numpy.zeros((1, 3), numpy.float32), numpy.ones((1, 3), numpy.float32))
    print(f"triangles {len(corners)}, build {time.process_time() - start:.2f} CPU s")
    for name, (origins, directions) in (("camera", camera_rays()), ("random", random_rays())):
        for kind, query in (("closest hit", "INTERSECT"), ("any hit", "OCCLUDED")):
            seconds = best_of_three(lambda: scene.run(origins, directions, query=query))
            print(f"{name} rays, {kind}: {RAYS / seconds / 1e6:.2f} M/s")


main()
