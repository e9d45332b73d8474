"""Pictures: equal to those of the command line, with layers, and refused with clear errors."""

import numpy
import OpenEXR
import pytest

import pathmarch

SIZE = (48, 27)


def command_line(program, scene, output, *options):
    """Renders with the program on the CPU, and returns the picture of the file."""
    done = program("render", scene, "-o", output, "--backend", "cpu", "--size", "48x27", *options)
    assert done.returncode == 0, done.stderr
    return pathmarch.load(output)


@pytest.mark.parametrize(
    "name",
    ["ten-lines", "material-grid", "textures", "glass-still-life", "day", "seams", "gyroid", "fractals/mandelbulb"],
)
def test_pictures_equal_those_of_the_command_line_bit_by_bit(name, scenes, program, tmp_path):
    scene = scenes / f"{name}.kdl"
    expected = command_line(program, scene, tmp_path / "a.exr", "--samples", 5, "--seed", 3)
    picture = pathmarch.render(scene, SIZE, 5, seed=3, backend="cpu")
    assert picture.tobytes() == expected.tobytes()


def test_animations_equal_those_of_the_command_line(scenes, program, tmp_path):
    scene = scenes / "gears.kdl"
    options = ["--samples", 6, "--time", 0.7, "--shutter", 0.8, "--fps", 12]
    expected = command_line(program, scene, tmp_path / "a.exr", *options)
    picture = pathmarch.render(scene, SIZE, 6, time=0.7, shutter=0.8, fps=12, backend="cpu")
    assert picture.tobytes() == expected.tobytes()
    still = pathmarch.render(scene, SIZE, 6, time=0.7, backend="cpu")
    assert still.tobytes() != expected.tobytes(), "motion blur has no effect"


def test_denoised_pictures_equal_those_of_the_command_line(scenes, program, tmp_path):
    scene = scenes / "ten-lines.kdl"
    expected = command_line(program, scene, tmp_path / "a.exr", "--samples", 8, "--denoise")
    both = pathmarch.render(scene, SIZE, 8, denoise="regression", layers="albedo", backend="cpu")
    assert both["picture"].tobytes() == expected.tobytes()
    assert numpy.allclose(both["noisy"], pathmarch.render(scene, SIZE, 8, backend="cpu"), rtol=1e-5)


def test_modes_and_settings_equal_those_of_the_command_line(scenes, program, tmp_path):
    scene = scenes / "ten-lines.kdl"
    expected = command_line(program, scene, tmp_path / "a.exr", "--mode", "preview")
    assert pathmarch.render(scene, SIZE, mode="preview", backend="cpu").tobytes() == expected.tobytes()
    expected = command_line(program, scene, tmp_path / "b.exr", "--samples", 4, "--bounces", 1, "--clamp", 2)
    picture = pathmarch.render(scene, SIZE, 4, bounces=1, clamp=2, backend="cpu")
    assert picture.tobytes() == expected.tobytes()


def test_layers_equal_those_of_the_command_line(scenes, program, tmp_path):
    scene = scenes / "ten-lines.kdl"
    command_line(program, scene, tmp_path / "a.exr", "--samples", 2, "--aov")
    channels = OpenEXR.File(str(tmp_path / "a.exr"), separate_channels=True).channels()
    layers = pathmarch.render(scene, SIZE, 2, layers="all", backend="cpu")
    parts = {"albedo": "RGB", "normal": "XYZ", "position": "XYZ", "depth": "Z"}
    for name, array in layers.items():
        if name == "picture":
            continue
        expected = [channels[f"{name}.{part}"].pixels for part in parts.get(name, "X")]
        assert numpy.array_equal(array.reshape(*array.shape[:2], -1), numpy.stack(expected, axis=-1)), name
    assert len(layers) == 8


def test_the_picture_has_the_size_and_the_type_of_the_arguments(ball):
    picture = pathmarch.render(ball, size=(20, 10), samples=1, backend="cpu")
    assert (picture.shape, picture.dtype) == ((10, 20, 3), numpy.float32)
    for size in ([20, 10], numpy.array([20, 10])):
        assert pathmarch.render(ball, size, numpy.int32(1), backend="cpu").tobytes() == picture.tobytes()
    assert picture.flags.writeable and picture.flags.c_contiguous
    assert numpy.allclose(picture[0, 0], [1, 0.5, 0.25]), "the sky"


def test_layers_have_the_values_of_the_scene(ball):
    layers = pathmarch.render(ball, (21, 11), 1, layers=("depth", "objectId", "materialId", "normal", "sampleCount"))
    assert set(layers) == {"picture", "depth", "objectId", "materialId", "normal", "sampleCount"}
    assert layers["objectId"].dtype == numpy.uint32 and layers["objectId"][5, 10] == 1 and layers["objectId"][0, 0] == 0
    assert abs(layers["depth"][5, 10] - (17**0.5 - 1)) < 1e-3 and numpy.isinf(layers["depth"][0, 0])
    assert layers["normal"].shape == (11, 21, 3) and layers["sampleCount"].max() == 1


def test_cameras_parameters_and_seeds_change_the_picture(ball):
    first = pathmarch.render(ball, SIZE, 2, backend="cpu")
    assert first.tobytes() == pathmarch.render(ball, SIZE, 2, seed=0, camera="main", backend="cpu").tobytes()
    for change in [{"seed": 1}, {"camera": "top"}, {"params": {"radius": 0.5}}, {"samples": 3}]:
        other = pathmarch.render(ball, **{"size": SIZE, "samples": 2, "backend": "cpu", **change})
        assert other.tobytes() != first.tobytes(), change


def test_paths_may_be_texts_or_paths(scenes, tmp_path, monkeypatch):
    monkeypatch.chdir(scenes)
    a = pathmarch.render("ten-lines.kdl", SIZE, 1, backend="cpu")
    b = pathmarch.render(scenes / "ten-lines.kdl", SIZE, 1, backend="cpu")
    text = (scenes / "ten-lines.kdl").read_text()
    c = pathmarch.render(text, SIZE, 1, backend="cpu")
    assert a.tobytes() == b.tobytes() == c.tobytes()


def test_files_of_a_text_are_in_its_folder(scenes, tmp_path):
    text = (scenes / "environment.kdl").read_text()
    assert pathmarch.render(text, SIZE, 1, folder=scenes).shape == (27, 48, 3)
    with pytest.raises(pathmarch.SceneError):
        pathmarch.render(text, SIZE, 1, folder=tmp_path)
    outside = text.replace('"environment.exr"', f'"{scenes / "environment.exr"}"')
    assert outside != text
    with pytest.raises(pathmarch.SceneError, match="outside"):
        pathmarch.render(outside, SIZE, 1, folder=tmp_path)
    assert pathmarch.render(outside, SIZE, 1, folder=tmp_path, allow_files=True).shape == (27, 48, 3)


@pytest.mark.parametrize(
    "options, error, message",
    [
        ({"size": (0, 10)}, ValueError, "size: width: must be a whole number from 1 to 16384, not 0"),
        ({"size": (10, 10**30)}, ValueError, "size: height: must be a whole number from 1 to 16384"),
        ({"size": 10}, TypeError, r"size: expected two whole numbers of pixels, \(width, height\), not 10"),
        ({"size": "640x360"}, TypeError, "size: expected two whole numbers of pixels"),
        ({"size": (10, 1.5)}, TypeError, "size: height: expected a whole number, not 1.5"),
        ({"samples": 0}, ValueError, "samples: must be a whole number from 1 to 1000000, not 0"),
        ({"samples": -1}, ValueError, "samples: must be a whole number from 1"),
        ({"samples": "many"}, TypeError, "samples: expected a whole number, not 'many'"),
        ({"seed": 2**32}, ValueError, "seed: must be a whole number from 0 to 4294967295, not 4294967296"),
        ({"backend": "cuda"}, ValueError, 'backend: there is no "cuda"; .*expected one of "auto", "cpu", "gpu"'),
        ({"backend": "cpi"}, ValueError, 'did you mean "cpu"?'),
        ({"camera": "tip"}, ValueError, 'camera: there is no "tip"; did you mean "top"?'),
        ({"mode": "norml"}, ValueError, 'did you mean "normal"?'),
        ({"layers": "albedo,normal"}, ValueError, "layers: there is no"),
        ({"layers": ["depht"]}, ValueError, 'did you mean "depth"?'),
        ({"denoise": "magic"}, ValueError, 'denoise: there is no "magic"'),
        ({"denoise": "regression", "mode": "normal"}, ValueError, "only pictures of mode"),
        ({"time": -1}, ValueError, "time: must be a number of seconds from 0"),
        ({"time": float("nan")}, ValueError, "time: must be a number of seconds from 0"),
        ({"params": {"radius": 3}}, ValueError, "from 0.1 to 2"),
        ({"params": {"radios": 1}}, ValueError, 'params: there is no "radios"; did you mean "radius"?'),
        ({"params": {"radius": None}}, TypeError, "params: radius must be a number or a formula"),
        ({"params": {"radius": float("inf")}}, ValueError, "radius"),
        ({"bounces": 1001}, ValueError, "bounces: must be a whole number from 0 to 1000, not 1001"),
        ({"bounce": 6}, TypeError, "unexpected keyword argument 'bounce'; did you mean \"bounces\"?"),
        ({"detail": 0}, ValueError, "detail: must be from 0.001 to 10, not 0"),
        ({"sampler": "halton"}, ValueError, 'sampler: there is no "halton"'),
        ({"clamp": "high"}, TypeError, "clamp: expected a number, not 'high'"),
        ({"adapter": "no such adapter", "backend": "gpu"}, pathmarch.RenderError, "adapter"),
    ],
)
def test_values_that_a_picture_cannot_have_are_refused(options, error, message, ball):
    with pytest.raises(error, match=message):
        pathmarch.render(ball, **{"size": (8, 8), "samples": 1, **options})


def test_what_is_no_scene_is_refused():
    with pytest.raises(TypeError, match="expected the text of a scene or the path of a file, not int"):
        pathmarch.render(3)
    with pytest.raises(pathmarch.SceneError, match="there is no such file"):
        pathmarch.render("missing.kdl")


def test_pictures_are_saved_and_loaded(tmp_path):
    picture = numpy.random.default_rng(1).random((5, 7, 3), dtype=numpy.float32) * 4
    pathmarch.save(tmp_path / "a.exr", picture)
    assert pathmarch.load(tmp_path / "a.exr").tobytes() == picture.tobytes()
    pathmarch.save(tmp_path / "a.png", picture, curve="srgb", exposure=-2)
    codes = pathmarch.tonemap(picture, "srgb", -2)
    assert (codes.shape, codes.dtype) == ((5, 7, 3), numpy.uint8)
    again = pathmarch.tonemap(pathmarch.load(tmp_path / "a.png"), "srgb")
    assert numpy.array_equal(codes, again)
    assert pathmarch.encode(picture)[:4] == b"\x89PNG" and pathmarch.encode(picture, "jpg")[:2] == b"\xff\xd8"


def test_pictures_that_no_file_can_have_are_refused(tmp_path):
    picture = numpy.zeros((2, 2, 3))
    with pytest.raises(ValueError, match="height x width x 3"):
        pathmarch.save(tmp_path / "a.png", numpy.zeros((2, 2)))
    with pytest.raises(ValueError, match="extension"):
        pathmarch.save(tmp_path / "a.tif", picture)
    with pytest.raises(OSError, match="does not exist"):
        pathmarch.save(tmp_path / "missing" / "a.png", picture)
    with pytest.raises(ValueError, match="curve: there is no"):
        pathmarch.tonemap(picture, "film")
    with pytest.raises(ValueError, match="exposure: must be a number from -100 to 100"):
        pathmarch.tonemap(picture, exposure=1000)
    with pytest.raises(OSError, match="cannot be read"):
        pathmarch.load(tmp_path / "b.exr")


def test_a_gpu_renders_or_says_why_not(ball):
    cpu = pathmarch.render(ball, SIZE, 4, backend="cpu")
    if not pathmarch.devices():
        with pytest.raises(pathmarch.RenderError, match="adapter"):
            pathmarch.render(ball, SIZE, 4, backend="gpu")
        return
    gpu = pathmarch.render(ball, SIZE, 4, backend="gpu")
    assert numpy.allclose(gpu.mean(), cpu.mean(), rtol=0.02)


def test_the_backend_is_logged(ball, caplog):
    with caplog.at_level("INFO", logger="pathmarch"):
        pathmarch.render(ball, (16, 9), 2, backend="cpu")
    assert "16x9, 2 samples, on CPU (" in caplog.text


def test_odd_texts_warn(ball):
    with pytest.warns(pathmarch.SceneWarning, match="light"):
        pathmarch.render(ball.replace("sky 1 0.5 0.25", ""), (8, 8), 1)


def test_a_scene_has_its_folder_already(ball, tmp_path):
    with pytest.raises(TypeError, match="give them to Scene"):
        pathmarch.render(pathmarch.Scene(ball), folder=tmp_path)
