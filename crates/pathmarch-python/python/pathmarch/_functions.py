"""Functions that make nodes, from descriptions of their parameters."""

from __future__ import annotations

import difflib
import inspect
import textwrap
from collections.abc import Iterable
from typing import Any, Callable, Dict, List, NamedTuple, Optional, Sequence, Tuple

from ._kdl import Node, flat

NUMBERS = ("number", "whole", "colour", "triple", "direction", "size", "numbers")
"""Kinds whose values are numbers, or formulas."""
LENGTHS = {"number": (1,), "whole": (1,), "colour": (1, 3), "triple": (3,), "direction": (3,), "size": (2,)}
"""Number of values of each kind."""
EXPECTED = {
    "number": "a number or a formula",
    "whole": "a whole number or a formula",
    "colour": 'a colour: one number, three, or a text such as "#c8691e"',
    "triple": "three numbers or formulas",
    "direction": "three numbers or formulas",
    "size": "a width and a height",
    "numbers": "numbers or formulas",
}
OTHER_TYPES = {
    "text": (str, "a text"),
    "material": (str, "a material or its name"),
    "flag": (bool, "True or False"),
    "points": (Iterable, "a list of points"),
    "list": (Iterable, "a list of colours"),
    "mapping": (dict, "a dictionary"),
}
"""Types of values that are no numbers, and their names."""


class Parameter(NamedTuple):
    """A parameter of a function, and its place in the node."""

    name: str
    """Name in Python."""
    word: str
    """Word of the scene language."""
    kind: str
    doc: str = ""
    default: Any = None
    unit: str = ""
    range: str = ""
    limits: Tuple[Optional[float], bool, Optional[float], bool] = (None, True, None, True)
    """Smallest number and whether it is allowed itself, and the same for the largest."""
    choices: Tuple[str, ...] = ()
    textured: bool = False
    required: bool = False
    place: str = "property"
    """"property", "node", or the word of the node whose property it is."""


class Function(NamedTuple):
    """A function that makes a node."""

    name: str
    doc: str
    build: Callable[..., Node]
    """Receives the arguments by position, the children, and those by name."""
    positional: Tuple[Parameter, ...] = ()
    children: str = ""
    """Name of the arguments that are nodes; empty if it takes none."""
    keywords: Tuple[Parameter, ...] = ()
    notes: Tuple[str, ...] = ()

    def parameters(self) -> Tuple[Parameter, ...]:
        """All parameters but the children."""
        return self.positional + self.keywords

    def signature(self) -> inspect.Signature:
        """Signature in Python, with the defaults of the scene language."""
        by_position = inspect.Parameter.POSITIONAL_OR_KEYWORD
        kinds = [(parameter, by_position) for parameter in self.positional]
        all_parameters = [_inspected(parameter, kind) for parameter, kind in kinds]
        if self.children:
            all_parameters.append(inspect.Parameter(self.children, inspect.Parameter.VAR_POSITIONAL))
        all_parameters += [_inspected(parameter, inspect.Parameter.KEYWORD_ONLY) for parameter in self.keywords]
        return inspect.Signature(all_parameters)


def _inspected(parameter: Parameter, kind: Any) -> inspect.Parameter:
    default = inspect.Parameter.empty if parameter.required else parameter.default
    return inspect.Parameter(parameter.name, kind, default=default)


def made(function: Function, module: str) -> Callable[..., Node]:
    """The function as Python calls it."""
    signature = function.signature()
    by_name = {parameter.name: parameter for parameter in function.parameters()}

    def call(*arguments: Any, **keywords: Any) -> Node:
        bound = _bound(function, signature, arguments, keywords)
        children = _children(function, bound.pop(function.children, ())) if function.children else ()
        for name, value in bound.items():
            if value is not None:
                check(function.name, by_name[name], value)
        positional = [bound.pop(parameter.name) for parameter in function.positional[: len(arguments)]]
        given = {name: value for name, value in bound.items() if value is not None}
        return function.build(positional, children, given)

    call.__name__ = call.__qualname__ = function.name
    call.__module__ = module
    call.__doc__ = documentation(function)
    call.__signature__ = signature  # type: ignore[attr-defined]
    return call


def _bound(function: Function, signature: inspect.Signature, arguments: Any, keywords: Any) -> Dict[str, Any]:
    try:
        return dict(signature.bind(*arguments, **keywords).arguments)
    except TypeError as error:
        names = [parameter.name for parameter in function.parameters()]
        near = [near for name in keywords if name not in names for near in difflib.get_close_matches(name, names, 1)]
        hint = f"; did you mean {near[0]}?" if near else ""
        raise TypeError(f"{function.name}(): {error}{hint}") from None


def _children(function: Function, children: Iterable[Any]) -> List[Node]:
    nodes = [node for child in children for node in flat(child)]
    for node in nodes:
        if not isinstance(node, Node):
            raise TypeError(f"{function.name}(): expected nodes such as sphere(1), not {node!r}")
    return nodes


def check(function: str, parameter: Parameter, value: Any) -> None:
    """Raises TypeError or ValueError for what the language would refuse."""
    where = f"{function}(): {parameter.name}"
    if isinstance(value, Node):
        if parameter.kind not in ("material", "node") and not parameter.textured:
            raise TypeError(f"{where} cannot be a node")
    elif parameter.kind in NUMBERS:
        single = parameter.kind in ("number", "whole")
        _check_numbers(where, parameter, (value,) if single else flat(value))
    elif parameter.kind in ("choice", "axis"):
        if value not in parameter.choices:
            raise ValueError(f"{where} must be one of {', '.join(parameter.choices)}, not {value!r}")
    elif parameter.kind == "node":
        raise TypeError(f"{where} must be a node, not {value!r}")
    elif not isinstance(value, OTHER_TYPES[parameter.kind][0]):
        raise TypeError(f"{where} must be {OTHER_TYPES[parameter.kind][1]}, not {value!r}")


def _check_numbers(where: str, parameter: Parameter, values: Tuple[Any, ...]) -> None:
    lengths = LENGTHS.get(parameter.kind, (len(values),))
    if len(values) not in lengths:
        raise ValueError(f"{where}: expected {EXPECTED[parameter.kind]}, not {len(values)} values")
    for value in values:
        if isinstance(value, str):
            continue  # A formula, or a colour: the scene checks it.
        try:
            number = float(value)
        except (TypeError, ValueError):
            raise TypeError(f"{where}: expected {EXPECTED[parameter.kind]}, not {value!r}") from None
        if not _accepts(parameter, number):
            raise ValueError(f"{where} must be {parameter.range}, not {value!r}")


def _accepts(parameter: Parameter, number: float) -> bool:
    least, least_allowed, most, most_allowed = parameter.limits
    above = least is None or number > least or (least_allowed and number == least)
    below = most is None or number < most or (most_allowed and number == most)
    return above and below and (parameter.kind != "whole" or number == int(number))


def documentation(function: Function) -> str:
    """Help text: the sentence of the registry, the parameters with their defaults and ranges, and notes."""
    lines = [function.doc, ""]
    if function.parameters():
        lines += ["Parameters", "----------"]
    for parameter in function.parameters():
        lines += [f"{parameter.name} : {_kind_in_words(parameter)}"]
        lines += textwrap.wrap(parameter.doc, 100, initial_indent="    ", subsequent_indent="    ")
    if function.notes:
        lines += ["", *function.notes]
    return "\n".join(lines).rstrip() + "\n"


def _kind_in_words(parameter: Parameter) -> str:
    words = [parameter.kind if parameter.kind != "numbers" else "number"]
    if parameter.textured:
        words[0] += " or texture"
    if parameter.choices:
        words[0] = " | ".join(f'"{choice}"' for choice in parameter.choices)
    elif parameter.range and parameter.kind in NUMBERS and parameter.kind not in ("triple", "direction"):
        words.append(parameter.range)
    if parameter.unit:
        words.append(parameter.unit)
    if not parameter.required and parameter.default is not None:
        words.append(f"default {parameter.default!r}")
    return ", ".join(words)


def properties_of(parameters: Sequence[Parameter], given: Dict[str, Any]) -> Dict[str, Any]:
    """Properties of a node, for those of the parameters that are given."""
    chosen = (parameter for parameter in parameters if parameter.place == "property" and parameter.name in given)
    return {parameter.word: given[parameter.name] for parameter in chosen}


def nodes_of(parameters: Sequence[Parameter], given: Dict[str, Any]) -> List[Node]:
    """Nodes in the braces of a node, for those of the parameters that are given."""
    nodes: Dict[str, Node] = {}
    for parameter in parameters:
        if parameter.name in given and parameter.place != "property":
            word = parameter.word if parameter.place == "node" else parameter.place
            nodes[word] = _with_value(nodes.get(word, Node(word)), parameter, given[parameter.name])
    return list(nodes.values())


def _with_value(node: Node, parameter: Parameter, value: Any) -> Node:
    """A node with the value of a parameter: a property, a node in its braces, or its arguments."""
    if parameter.place != "node":
        return Node(node.name, node.arguments, {**node.properties, parameter.word: value})
    if isinstance(value, Node):
        return Node(node.name, children=(value,))
    return Node(node.name, flat(value), node.properties)
