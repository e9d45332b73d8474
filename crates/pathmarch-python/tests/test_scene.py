"""Scenes: their text, their parameters, their mistakes, and meshes of them."""

import copy
import pickle

import numpy
import pytest

import pathmarch


def test_a_scene_lists_its_parameters(ball):
    scene = pathmarch.Scene(ball)
    assert scene.parameters == (pathmarch.Parameter("radius", 1.0, (0.1, 2.0), "Of the ball, metres.", False),)
    assert scene.text == ball and scene.cameras == ("main", "top")
    assert scene.objects == ("ball",) and scene.materials == ("clay",)
    assert scene.bounds.tolist() == [[-1, -1, -1], [1, 1, 1]]
    assert repr(scene) == '<pathmarch.Scene "scene.kdl": 1 object>'


def test_other_values_change_only_numbers_of_the_text(ball):
    scene = pathmarch.Scene(ball)
    larger = scene.with_params(radius=1.5)
    assert larger.text == ball.replace("radius 1 ", "radius 1.5 ").replace('"radius" 1 ', '"radius" 1.5 ')
    assert larger.parameters[0].value == 1.5 and scene.parameters[0].value == 1.0
    formula = scene.with_params(radius="1 + 0.5*sin(t)")
    assert formula.parameters[0].animated and formula.animated and not scene.animated
    assert formula.with_params(radius=2).parameters[0].value == 2.0
    assert scene.with_params(radius=0.1).parameters[0].value == 0.1
    assert scene.with_params().text == ball


@pytest.mark.parametrize(
    "values, message", [({"radius": 2.5}, "from 0.1 to 2"), ({"radius": "1 +"}, "formula"), ({"size": 1}, "no")]
)
def test_values_that_a_parameter_cannot_have_are_refused(values, message, ball):
    with pytest.raises(ValueError, match=message):
        pathmarch.Scene(ball).with_params(**values)


def test_parameters_of_included_files_are_changed_there(ball, tmp_path):
    (tmp_path / "ball.kdl").write_text(ball)
    text = 'pathmarch 1\ninclude "ball.kdl"\ncamera { position 0 1 4; target 0 0 0 }\n'
    scene = pathmarch.Scene(text, folder=tmp_path)
    assert scene.parameters[0].name == "radius"
    with pytest.raises(ValueError, match="included file"):
        scene.with_params(radius=1)


def test_mistakes_have_lines_columns_and_help():
    text = "pathmarch 1\ncamera { position 0 1 4; target 0 0 0 }\nobject ball { shpere 1; box -1 }\n"
    with pytest.raises(pathmarch.SceneError) as caught:
        pathmarch.Scene(text)
    error = caught.value
    assert error.positions == [(3, 15), (3, 29)]
    first = error.diagnostics[0]
    assert (first.message, first.help) == ("There is no `shpere` in an object.", "Did you mean `sphere`?")
    assert (first.length, first.code, first.file) == (6, "pathmarch::unknown_node", "scene.kdl")
    assert "shpere 1; box -1" in str(error) and "Did you mean `sphere`?" in str(error), str(error)
    assert "\x1b" not in str(error) and isinstance(error, ValueError)
    assert pickle.loads(pickle.dumps(error)).positions == error.positions


def test_columns_are_in_characters():
    text = 'pathmarch 1\ncamera { position 0 1 4; target 0 0 0 }\nobject "Grüße" { shpere }\n'
    with pytest.raises(pathmarch.SceneError) as caught:
        pathmarch.Scene(text)
    assert caught.value.positions == [(3, 18)]


def test_files_that_cannot_be_read_are_scene_errors(tmp_path):
    for path, message in [(tmp_path / "missing.kdl", "no such file"), (tmp_path, "directory")]:
        with pytest.raises(pathmarch.SceneError, match=message) as caught:
            pathmarch.Scene(path)
        assert caught.value.diagnostics == ()
    (tmp_path / "latin.kdl").write_bytes(b"pathmarch 1\n// \xe9\n")
    with pytest.raises(pathmarch.SceneError, match="UTF-8"):
        pathmarch.Scene(tmp_path / "latin.kdl")


def test_odd_scenes_warn(ball):
    with pytest.warns(pathmarch.SceneWarning, match="light"):
        scene = pathmarch.Scene(ball.replace("sky 1 0.5 0.25", ""))
    assert len(scene.warnings) == 1 and scene.warnings[0].line > 0


def test_scenes_are_copied_as_texts(ball):
    scene = pathmarch.Scene(ball.replace("sphere radius", 'sphere "radius*(1 + t)"'), time=0.5)
    for other in (pickle.loads(pickle.dumps(scene)), copy.deepcopy(scene)):
        assert other.text == scene.text and other.time == 0.5
        assert other.distance([3, 0, 0]) == scene.distance([3, 0, 0]) == 1.5


def test_a_scene_has_a_time(ball):
    scene = pathmarch.Scene(ball.replace("sphere radius", 'sphere "radius*(1 + t)"'))
    assert scene.distance([3, 0, 0]) == 2.0 and scene.at(1).distance([3, 0, 0]) == 1.0
    assert scene.at(1).time == 1.0 and scene.at(1).with_params(radius=0.5).distance([3, 0, 0]) == 2.0
    with pytest.raises(ValueError, match="time"):
        scene.at(-1)


def test_every_example_is_a_scene(scenes):
    files = sorted(path for path in scenes.rglob("*.kdl") if "benchmarks" not in path.parts)
    assert len(files) > 30
    for path in files:
        assert pathmarch.Scene(path, allow_files=True).objects, path


def test_meshes_are_closed_and_of_the_right_size(ball):
    mesh = pathmarch.Scene(ball).mesh(48)
    positions, triangles = mesh["positions"], mesh["triangles"]
    assert positions.dtype == numpy.float32 and triangles.dtype == numpy.uint32
    assert triangles.max() + 1 == len(positions) == len(mesh["normals"]) == len(mesh["colours"])
    a, b, c = (positions[triangles[:, corner]].astype(float) for corner in range(3))
    volume = numpy.einsum("ij,ij->i", a, numpy.cross(b, c)).sum() / 6
    assert abs(volume - 4 / 3 * numpy.pi) < 0.05
    assert numpy.allclose(numpy.linalg.norm(positions, axis=1), 1, atol=1e-3)
    assert numpy.allclose(mesh["colours"][0], [0.7, 0.22, 0.08])


@pytest.mark.parametrize("suffix", [".stl", ".ply", ".obj", ".glb", ".3mf", ".usda", ".usdz"])
def test_mesh_files_equal_those_of_the_command_line(suffix, scenes, program, tmp_path):
    scene = scenes / "ten-lines.kdl"
    options = ["--object", "block", "--object", "ball", "--resolution", 24]
    done = program("export", scene, "-o", tmp_path / f"a{suffix}", *options)
    assert done.returncode == 0, done.stderr
    count = pathmarch.Scene(scene).export(tmp_path / f"b{suffix}", 24, objects=["block", "ball"])
    assert count > 100
    assert (tmp_path / f"a{suffix}").read_bytes() == (tmp_path / f"b{suffix}").read_bytes()


@pytest.mark.parametrize(
    "options, message",
    [
        ({"resolution": 0}, "resolution: must be a whole number from 1 to 100000"),
        ({"cell": -1.0}, "cell: must be a length above 0"),
        ({"objects": ["bal"]}, 'did you mean "ball"'),
        ({"bounds": ((1, 1, 1), (0, 0, 0))}, "bounds: expected the lower corner"),
        ({"unit": "foot"}, 'unit: there is no "foot"'),
        ({"path": "a.max"}, "extension"),
        ({"path": "a.glb", "unit": "mm"}, "files are in m;"),
    ],
)
def test_meshes_that_cannot_be_made_are_refused(options, message, ball, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ValueError, match=message):
        pathmarch.Scene(ball).export(**{"path": "a.stl", "resolution": 8, **options})
    assert not list(tmp_path.iterdir())


def test_endless_solids_need_bounds(ball):
    scene = pathmarch.Scene(ball + 'object "floor" { plane { at 0 -1 0 } }\n')
    with pytest.raises(ValueError, match="is infinite"):
        scene.mesh(8)
    count = len(scene.mesh(8, bounds=((-2, -2, -2), (2, 2, 2)))["triangles"])
    assert len(scene.mesh(8, bounds=numpy.array([[-2.0] * 3, [2.0] * 3]))["triangles"]) == count > 10


def test_scenes_cannot_be_changed(ball):
    with pytest.raises(AttributeError):
        pathmarch.Scene(ball).text = "pathmarch 1"
