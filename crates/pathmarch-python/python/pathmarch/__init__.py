"""A path tracer for signed distance fields.

A scene is a text, or is made of Python functions that print one:

>>> import pathmarch
>>> from pathmarch import nodes
>>> clay = nodes.diffuse("clay", (0.7, 0.22, 0.08))
>>> scene = nodes.scene(
...     nodes.camera(position=(0, 1.5, 5), target=(0, 1, 0)),
...     nodes.sky(1),
...     nodes.object("ball", nodes.sphere(0.5, material=clay, at=(0, 1, 0))),
... )
>>> picture = scene.render(size=(64, 36), samples=4)
>>> picture.shape
(36, 64, 3)
>>> print(scene.text)
pathmarch 1
camera { position 0 1.5 5; target 0 1 0 }
sky 1
material "clay" { diffuse 0.7 0.22 0.08 }
object "ball" { sphere 0.5 material="clay" { at 0 1 0 } }
<BLANKLINE>

`pathmarch.render` makes a picture of a text or a file, `pathmarch.save` writes it, and `pathmarch.encode` makes the
bytes of a PNG, to show in a notebook. docs/scene-language.md is the reference of the scene language;
`help(pathmarch.nodes.sphere)` describes a shape.
"""

import os as _os

# Mesa prints errors without a desktop session, which only chooses among GPUs.
if "XDG_RUNTIME_DIR" not in _os.environ:
    _os.environ.setdefault("NODEVICE_SELECT", "1")

from . import _builds

_builds.load()

from . import nodes  # noqa: E402
from ._native import Scene, __version__, devices, encode, load, render, save, tonemap  # noqa: E402
from ._types import Cancelled, Diagnostic, Parameter, RenderError, SceneError, SceneWarning  # noqa: E402

__all__ = [
    "Cancelled",
    "Diagnostic",
    "Parameter",
    "RenderError",
    "Scene",
    "SceneError",
    "SceneWarning",
    "__version__",
    "devices",
    "encode",
    "load",
    "nodes",
    "render",
    "save",
    "tonemap",
]
