"""Type stubs of pathmarch.nodes, from the registry of the scene language.

python make_stubs.py            writes python/pathmarch/nodes.pyi
python make_stubs.py --check    fails if that file differs
"""

import pathlib
import sys
from typing import Iterator, Tuple

from pathmarch._functions import Function, Parameter
from pathmarch._language import functions

STUBS = pathlib.Path(__file__).parent / "python" / "pathmarch" / "nodes.pyi"
HEAD = '''# Written by make_stubs.py from the registry of the scene language.
from typing import Literal, Mapping, Optional, Sequence, Union

from ._kdl import Node as Node
from ._scenes import scene as scene, scene_text as scene_text

_Number = Union[float, str]
"""A number, or a formula as text."""
_Vector = Sequence[_Number]
_Colour = Union[_Number, Sequence[_Number]]
"""One number, three, or a text such as "#c8691e"."""
_Material = Union[Node, str]
'''
TYPES = {
    "number": "_Number",
    "whole": "Union[int, str]",
    "colour": "_Colour",
    "triple": "_Vector",
    "direction": "_Vector",
    "size": "Sequence[Union[int, str]]",
    "numbers": "Union[_Number, _Vector]",
    "flag": "bool",
    "text": "str",
    "material": "_Material",
    "node": "Node",
    "points": "Sequence[_Vector]",
    "list": "Sequence[_Colour]",
    "mapping": "Mapping[str, _Number]",
}


def type_of(parameter: Parameter) -> str:
    """Type of a parameter's values."""
    if parameter.choices:
        return f"Literal[{', '.join(repr(choice) for choice in parameter.choices)}]".replace("'", '"')
    name = TYPES[parameter.kind]
    return f"Union[{name}, Node]" if parameter.textured else name


def in_stub(parameter: Parameter) -> str:
    """A parameter with its type and its default."""
    if parameter.required:
        return f"{parameter.name}: {type_of(parameter)}"
    default = repr(parameter.default).replace("'", '"')
    kind = f"Optional[{type_of(parameter)}]" if parameter.default is None else type_of(parameter)
    return f"{parameter.name}: {kind} = {default}"


def signature(function: Function) -> Iterator[str]:
    """Parameters of a function, one a line."""
    yield from map(in_stub, function.positional)
    if function.children:
        yield f"*{function.children}: Union[Node, Sequence[Node]]"
    elif function.keywords:
        yield "*"
    yield from map(in_stub, function.keywords)


def stub(function: Function) -> str:
    """A function, with its first sentence."""
    lines = "".join(f"    {line},\n" for line in signature(function))
    return f'def {function.name}(\n{lines}) -> Node:\n    """{function.doc}"""\n'


def stubs() -> Tuple[pathlib.Path, str]:
    """The file, and what it should contain."""
    names = ["Node", "scene", "scene_text", *(function.name for function in functions())]
    exported = "".join(f'    "{name}",\n' for name in names)
    return STUBS, "\n".join([HEAD, f"__all__ = [\n{exported}]\n", *map(stub, functions())])


if __name__ == "__main__":
    path, text = stubs()
    if "--check" not in sys.argv:
        path.write_text(text, encoding="utf-8")
    elif path.read_text(encoding="utf-8") != text:
        sys.exit(f"{path} differs from the registry; run make_stubs.py")
