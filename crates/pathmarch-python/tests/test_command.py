"""The program that the wheel contains."""

import pathmarch


def test_the_program_is_of_the_version_of_the_package(program):
    done = program("--version")
    assert (done.returncode, done.stdout.strip()) == (0, f"pathmarch {pathmarch.__version__}")


def test_the_program_renders_an_example(program, tmp_path):
    options = ["--size", "32x18", "--samples", "2", "--backend", "cpu"]
    done = program("render", "ten-lines", "-o", tmp_path / "a.png", *options)
    assert done.returncode == 0, done.stderr
    assert pathmarch.load(tmp_path / "a.png").shape == (18, 32, 3)
