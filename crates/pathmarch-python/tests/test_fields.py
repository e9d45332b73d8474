"""Distances and gradients at many points."""

import numpy
import pytest

import pathmarch
from pathmarch import nodes

CAMERA = nodes.camera(position=(0, 1, 9), target=(0, 0, 0))


def scene_of(*solids):
    return nodes.scene(CAMERA, nodes.sky(1), nodes.object("solid", *solids))


def points(count, seed=1):
    return numpy.random.default_rng(seed).uniform(-2, 2, (count, 3))


def test_distances_are_those_of_the_formula():
    p = points(1003)
    expected = numpy.linalg.norm(p, axis=1) - 0.75
    assert numpy.allclose(scene_of(nodes.sphere(0.75)).distance(p), expected, atol=1e-6)
    edges = numpy.abs(p) - [0.5, 1, 0.25]
    box = numpy.linalg.norm(edges.clip(0), axis=1) + edges.max(axis=1).clip(max=0)
    assert numpy.allclose(scene_of(nodes.box(1, 2, 0.5)).distance(p), box, atol=1e-6)


def test_a_combination_has_the_distance_of_its_parts():
    p = points(500)
    a, b = (scene_of(solid).distance(p) for solid in (nodes.sphere(1), nodes.box(1.5)))
    assert numpy.array_equal(scene_of(nodes.sphere(1) | nodes.box(1.5)).distance(p), numpy.minimum(a, b))
    assert numpy.array_equal(scene_of(nodes.sphere(1) & nodes.box(1.5)).distance(p), numpy.maximum(a, b))
    assert numpy.array_equal(scene_of(nodes.sphere(1) - nodes.box(1.5)).distance(p), numpy.maximum(a, -b))


def test_gradients_are_slopes_of_the_distance():
    scene = scene_of(nodes.union(nodes.torus(1, 0.3), nodes.sphere(0.5, at=(0.4, 0.2, 0)), smooth=0.2))
    p = points(400)
    gradients = scene.gradient(p)
    step = 1e-2
    for axis in range(3):
        offset = numpy.eye(3)[axis] * step
        slope = (scene.distance(p + offset).astype(float) - scene.distance(p - offset)) / (2 * step)
        near = numpy.abs(slope - gradients[:, axis]) < 0.02
        assert near.mean() > 0.97, f"axis {axis}: {near.mean()}"


def test_gradients_of_the_registry_have_at_most_the_length_one():
    p = points(200)
    for solid in (nodes.sphere(), nodes.octahedron(), nodes.link(), nodes.menger(), nodes.hexprism()):
        length = numpy.linalg.norm(scene_of(solid).gradient(p), axis=1)
        assert length.max() < 1 + 1e-4 and length.mean() > 0.9, str(solid)


@pytest.mark.parametrize("dtype", [numpy.float32, numpy.float64, numpy.int64])
def test_all_types_of_numbers_are_points(dtype):
    scene = scene_of(nodes.sphere(1))
    p = numpy.array([[3, 0, 0], [0, 0, 2]], dtype=dtype)
    assert scene.distance(p).tolist() == [2.0, 1.0] and scene.distance(p).dtype == numpy.float32
    assert scene.distance(p.tolist()).tolist() == [2.0, 1.0]


def test_points_may_have_any_number_of_axes():
    scene = scene_of(nodes.sphere(1))
    grid = numpy.stack(numpy.meshgrid(*[numpy.linspace(-2, 2, 5)] * 3, indexing="ij"), axis=-1)
    assert scene.distance(grid).shape == (5, 5, 5) and scene.gradient(grid).shape == (5, 5, 5, 3)
    assert scene.distance(grid)[2, 2, 2] == -1.0
    assert numpy.array_equal(scene.distance(grid.transpose(2, 1, 0, 3)), scene.distance(grid).transpose(2, 1, 0))
    assert scene.distance([0, 0, 3]).shape == () and scene.distance(numpy.zeros((0, 3))).shape == (0,)


def test_many_points_are_evaluated_as_few_are():
    scene = scene_of(nodes.mandelbulb())
    p = points(250_001)
    distances = scene.distance(p)
    assert distances.shape == (250_001,) and numpy.isfinite(distances).all()
    chosen = numpy.arange(0, 250_001, 997)
    assert numpy.array_equal(scene.distance(p[chosen]), distances[chosen])


def test_an_empty_scene_is_infinitely_far():
    with pytest.warns(pathmarch.SceneWarning):
        empty = nodes.scene(CAMERA, nodes.sky(1))
    assert numpy.isinf(empty.distance([[0, 0, 0]])).all()


@pytest.mark.parametrize("wrong", [numpy.zeros((3, 2)), 1.0, [[1, 2, 3], [4, 5, 6, 7]], "abc"])
def test_what_are_no_points_is_refused(wrong):
    with pytest.raises((ValueError, TypeError)):
        scene_of(nodes.sphere(1)).distance(wrong)
