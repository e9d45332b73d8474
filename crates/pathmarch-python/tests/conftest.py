"""What all tests need: the example scenes, and the program of the wheel."""

import pathlib
import shutil
import subprocess
import sysconfig

import pytest

SCENES = pathlib.Path(__file__).parents[3] / "scenes"


@pytest.fixture(scope="session")
def scenes():
    """Folder of the example scenes."""
    return SCENES


@pytest.fixture(scope="session")
def program():
    """Runs the program `pathmarch` that was installed with the package."""
    path = shutil.which("pathmarch", path=sysconfig.get_path("scripts"))
    assert path, "the wheel has no program"

    def run(*arguments):
        return subprocess.run([path, *map(str, arguments)], capture_output=True, text=True, timeout=600)

    return run


@pytest.fixture
def ball():
    """Text of a scene of one ball, with a parameter."""
    return """pathmarch 1
param radius 1 min=0.1 max=2 doc="Of the ball, metres."
camera "main" { position 0 1 4; target 0 0 0 }
camera "top" { position 0 6 0.01; target 0 0 0 }
sky 1 0.5 0.25
material "clay" { diffuse 0.7 0.22 0.08 }  // kept
object "ball" material="clay" { sphere radius }
"""
