"""Functions that write scenes: one for each shape, operator, modifier, material and texture of the scene language.

Each makes a node of the language, whose text is `str(node)`; `scene` makes a `pathmarch.Scene` of nodes. Numbers may be
formulas as texts, such as "0.5 + 0.1*sin(t)". Names are those of the language, with `_` for `-`.

>>> from pathmarch import nodes
>>> print(nodes.twist(nodes.rounded_box(1, 2, 1, radius=0.1), turns_per_metre=0.2, at=(0, 1, 0)))
twist turns-per-metre=0.2 { rounded-box 1 2 1 radius=0.1; at 0 1 0 }
"""

from ._functions import made as _made
from ._kdl import Node
from ._language import functions as _functions
from ._scenes import scene, scene_text

_ALL = {function.name: function for function in _functions()}
"""Descriptions of the functions, by their names."""

globals().update({name: _made(function, __name__) for name, function in _ALL.items()})

__all__ = ["Node", "scene", "scene_text", *_ALL]
