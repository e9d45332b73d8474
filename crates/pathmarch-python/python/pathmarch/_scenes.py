"""Scenes made of nodes."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, Iterable, Iterator, List, Optional, Union

from ._kdl import Node, flat

if TYPE_CHECKING:
    from . import Scene

VERSION = Node("pathmarch", (1,))
"""First node of a scene: the version of the language."""


def scene_text(*nodes: Union[Node, Iterable[Node]]) -> str:
    """Text of a scene of these nodes, and of the materials that they use.

    >>> from pathmarch import nodes
    >>> print(nodes.scene_text(nodes.sky(1)), end="")
    pathmarch 1
    sky 1
    """
    given = [node for item in nodes for node in flat(item)]
    for node in given:
        if not isinstance(node, Node):
            raise TypeError(f"scene_text(): expected nodes such as camera(...), not {node!r}")
    top = [VERSION, *_with_materials(given)]
    return "".join(f"{node}\n" for node in top)


def scene(
    *nodes: Union[Node, Iterable[Node]],
    time: float = 0.0,
    folder: Optional[Union[str, "os.PathLike[str]"]] = None,
    allow_files: bool = False,
) -> Scene:
    """Scene of these nodes, and of the materials that they use; `scene(...).text` is its text.

    Files that it names are relative to `folder`. Mistakes raise `pathmarch.SceneError`.

    >>> from pathmarch import nodes
    >>> view = nodes.camera(position=(0, 1, 4), target=(0, 0, 0))
    >>> nodes.scene(view, nodes.sky(1), nodes.object("ball", nodes.sphere(1))).objects
    ('ball',)
    """
    from . import Scene

    return Scene(scene_text(*nodes), time=time, folder=folder, allow_files=allow_files)


def _with_materials(nodes: List[Node]) -> List[Node]:
    """The nodes, with materials that they use but do not contain before the first that is no material of its own."""
    contained = {node for node in nodes if node.name == "material"}
    used = [material for node in nodes for material in _materials(node)]
    missing = list(dict.fromkeys(material for material in used if material not in contained))
    _check_names([*contained, *missing])
    first = next((index for index, node in enumerate(nodes) if node.name in ("object", "shape")), len(nodes))
    return nodes[:first] + missing + nodes[first:]


def _check_names(materials: Iterable[Node]) -> None:
    texts: dict[Any, str] = {}
    for material in materials:
        name = material.arguments[0]
        if texts.setdefault(name, str(material)) != str(material):
            raise ValueError(f'two materials are called "{name}"; give one of them another name')


def _materials(node: Node) -> Iterator[Node]:
    """Materials that a node or those in its braces use as objects."""
    material = node.properties.get("material")
    if isinstance(material, Node):
        yield material
    for child in node.children:
        yield from _materials(child)
