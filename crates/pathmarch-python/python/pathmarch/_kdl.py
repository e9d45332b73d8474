"""Nodes of the scene language, and their text."""

from __future__ import annotations

import math
from typing import Any, Dict, Iterable, List, Sequence, Tuple

INDENT = "    "
WIDTH = 100
"""Longest line of nodes in braces."""
CODE = ("wgsl", "glsl")
"""Nodes whose argument is code, which is written on lines of its own."""


class Node:
    """A node of the scene language: a word, its arguments and properties, and the nodes in its braces.

    `str(node)` is its text. Solids can be combined: `a | b` is their union, `a & b` their intersection, `a - b` the
    difference.

    >>> from pathmarch import nodes
    >>> str(nodes.box(2) - nodes.sphere(1.2))
    'subtract { box 2; sphere 1.2 }'
    """

    __slots__ = ("name", "arguments", "properties", "children", "is_solid")

    def __init__(
        self,
        name: str,
        arguments: Sequence[Any] = (),
        properties: Dict[str, Any] | None = None,
        children: Iterable["Node"] = (),
        is_solid: bool = False,
    ) -> None:
        self.name = name
        self.arguments = tuple(arguments)
        self.properties = dict(properties or {})
        self.children = tuple(children)
        self.is_solid = is_solid

    def __str__(self) -> str:
        return "\n".join(_lines(self))

    def __repr__(self) -> str:
        return f"<pathmarch.nodes.Node {_head(self)!r}>"

    def __eq__(self, other: object) -> bool:
        return str(self) == str(other) if isinstance(other, Node) else NotImplemented

    def __hash__(self) -> int:
        return hash(str(self))

    def __or__(self, other: "Node") -> "Node":
        return _combined("union", self, other)

    def __and__(self, other: "Node") -> "Node":
        return _combined("intersect", self, other)

    def __sub__(self, other: "Node") -> "Node":
        return _combined("subtract", self, other)


def _combined(operator: str, a: Node, b: Any) -> Node:
    if not (a.is_solid and isinstance(b, Node) and b.is_solid):
        return NotImplemented
    return Node(operator, children=(a, b), is_solid=True)


def _lines(node: Node) -> List[str]:
    """Lines of a node: one if it is short, else one for each of the nodes in its braces."""
    head = _head(node)
    if not node.children:
        return head.split("\n")
    inside = [_lines(child) for child in node.children]
    line = f"{head} {{ {'; '.join(lines[0] for lines in inside)} }}"
    if all(len(lines) == 1 for lines in inside) and len(line) <= WIDTH:
        return [line]
    return [head + " {"] + [INDENT + line for lines in inside for line in lines] + ["}"]


def _head(node: Node) -> str:
    properties = (f"{name}={value_text(value)}" for name, value in node.properties.items())
    arguments = map(code_text if node.name in CODE else value_text, node.arguments)
    return " ".join([node.name, *arguments, *properties])


def value_text(value: Any) -> str:
    """A value as the language writes it; of a material, its name."""
    if isinstance(value, Node):
        return string_text(value.arguments[0])
    if isinstance(value, str):
        return string_text(value)
    if isinstance(value, bool) or type(value).__name__ == "bool_":
        return "#true" if value else "#false"
    return number_text(value)


def number_text(value: Any) -> str:
    """A number, with as many digits as it needs."""
    if hasattr(value, "__index__"):
        return str(value.__index__())
    number = float(value)
    if not math.isfinite(number):
        raise ValueError(f"{number} is not finite; the scene language has only finite numbers")
    if type(value) is not float and type(value).__name__ == "float32":
        # The digits of a float32, not those of the double that is equal to it.
        return str(value)
    return repr(int(number)) if number == int(number) and abs(number) < 1e15 else repr(number)


_ESCAPES = {'"': '\\"', "\\": "\\\\", "\n": "\\n", "\r": "\\r", "\t": "\\t"}


def string_text(text: str) -> str:
    """A string in quotes."""
    return '"' + "".join(_ESCAPES.get(char, char) for char in text) + '"'


def code_text(code: str) -> str:
    """A string of several lines."""
    escaped = code.replace("\\", "\\\\").replace('"', '\\"')
    return f'"""\n{escaped}\n"""'


def flat(values: Any) -> Tuple[Any, ...]:
    """Arguments of a value: its items if it has some, else itself."""
    if isinstance(value := values, (str, Node)) or not hasattr(value, "__iter__"):
        return (values,)
    return tuple(values)
