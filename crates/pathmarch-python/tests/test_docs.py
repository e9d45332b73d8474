"""Examples in documentation, and type stubs."""

import doctest
import importlib
import pathlib
import subprocess
import sys

import pytest

import pathmarch

CRATE = pathlib.Path(__file__).parents[1]
DOCS = CRATE.parents[1] / "docs"
MODULES = ["pathmarch", "pathmarch.nodes", "pathmarch._types", "pathmarch._kdl", "pathmarch._scenes"]
NATIVE = ["render", "tonemap", "encode", "save", "load", "devices"]


@pytest.mark.parametrize("module", MODULES)
def test_examples_of_modules_are_true(module):
    result = doctest.testmod(importlib.import_module(module))
    assert result.attempted > 0 and result.failed == 0


def test_examples_of_the_native_part_are_true():
    finder, runner = doctest.DocTestFinder(), doctest.DocTestRunner()
    named = {"Scene": pathmarch.Scene, **{name: getattr(pathmarch, name) for name in NATIVE}}
    for name, value in named.items():
        assert value.__doc__, name
        for test in finder.find(value, name, module=False, globs={}):
            runner.run(test)
    assert runner.summarize(verbose=False).failed == 0 and runner.tries >= 15


@pytest.mark.parametrize("page", [DOCS / "python.md"])
def test_examples_of_pages_are_true(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = doctest.testfile(str(page), module_relative=False, encoding="utf-8")
    assert result.attempted > 10 and result.failed == 0


def test_the_readme_renders_a_picture(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = (CRATE / "README.md").read_text(encoding="utf-8")
    code = text.split("```python\n")[1].split("```")[0]
    assert "samples=64" in code
    exec(code.replace("size=(640, 360), samples=64", "size=(64, 36), samples=2"), {})
    assert pathmarch.load("bowl.png").shape == (36, 64, 3)


def test_public_methods_of_scenes_are_documented():
    public = [name for name in dir(pathmarch.Scene) if not name.startswith("_")]
    assert len(public) > 15 and all(getattr(pathmarch.Scene, name).__doc__ for name in public)


def test_stubs_are_those_of_the_registry():
    done = subprocess.run([sys.executable, CRATE / "make_stubs.py", "--check"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_stubs_are_those_of_the_package(tmp_path):
    done = subprocess.run(
        [sys.executable, "-m", "mypy.stubtest", "pathmarch"], capture_output=True, text=True, cwd=tmp_path
    )
    assert done.returncode == 0, done.stdout


def test_types_of_calls_are_checked(tmp_path):
    (tmp_path / "calls.py").write_text(
        "import pathmarch\n"
        "from pathmarch import nodes\n"
        "ball = nodes.sphere(0.5, material='clay', at=(0, 1, 0)) | nodes.box('2*t')\n"
        "picture = pathmarch.render('a.kdl', (2, 1)).mean()\n"
        "depth = pathmarch.render('a.kdl', layers=('depth',))['depth']\n"
        "nodes.sphere(radius=[1])\n"
        "nodes.mirror(ball, axis='w')\n"
    )
    done = subprocess.run([sys.executable, "-m", "mypy", "calls.py"], capture_output=True, text=True, cwd=tmp_path)
    lines = [line.split(": ")[0] for line in done.stdout.splitlines() if ": error: " in line]
    assert lines == ["calls.py:6", "calls.py:7"], done.stdout
