"""The functions of `pathmarch.nodes`, from the registry of the scene language."""

from __future__ import annotations

import json
import keyword
from typing import Any, Dict, Iterator, List, Sequence, Tuple

from ._functions import Function, Parameter, nodes_of, properties_of
from ._kdl import Node, flat
from ._native import registry

REGISTRY = json.loads(registry())
"""Description of the language; see src/registry.rs."""
SETTINGS: Dict[str, List[Dict[str, Any]]] = REGISTRY["settings"]

MATERIAL = Parameter("material", "material", "material", "Material, or its name; that of the parent without it.")
NAME = Parameter("name", "name", "text", "Name, unlike those of the others.", required=True)
COLOURS = Parameter("colours", "colour", "list", "Colours of a ramp, evenly spaced.", default=())


def functions() -> List[Function]:
    """All functions, in the order of the reference."""
    kinds = (_shapes, _operators, _modifiers, _materials, _textures, _file_nodes, _skies, _declarations)
    return [function for kind in kinds for function in kind()]


def _python_name(word: str) -> str:
    name = word.replace("-", "_")
    return name + "_" if keyword.iskeyword(name) else name


def _parameter(entry: Dict[str, Any], **changes: Any) -> Parameter:
    """Parameter of an entry of the registry."""
    default = entry["default"]
    parameter = Parameter(
        name=_python_name(entry["name"]),
        word=entry["name"],
        kind=entry["kind"],
        doc=entry["doc"],
        default=_whole_if_equal(tuple(default) if isinstance(default, list) else default),
        unit=entry["unit"],
        range=entry["range"],
        limits=(entry["min"], entry["min_allowed"], entry["max"], entry["max_allowed"]),
        choices=("x", "y", "z") if entry["kind"] == "axis" else tuple(entry.get("choices", ())),
        textured=entry.get("textured", False),
        required=entry.get("required", False),
    )
    return parameter._replace(**changes)


def _whole_if_equal(value: Any) -> Any:
    """1 instead of 1.0, as the language writes it."""
    if isinstance(value, tuple):
        return tuple(_whole_if_equal(one) for one in value)
    return int(value) if isinstance(value, float) and value == int(value) else value


def _settings(table: str, place: str) -> Tuple[Parameter, ...]:
    """Parameters of a table of settings; those of a node with properties are named after both."""
    found: List[Parameter] = []
    for entry in SETTINGS[table]:
        if entry["kind"] != "properties":
            found.append(_parameter(entry, place=place))
            continue
        for inner in entry["settings"]:
            name = f"{entry['name']}_{inner['name']}"
            found.append(_parameter(inner, name=name, place=entry["name"]))
    return tuple(found)


PLACEMENT = tuple(parameter._replace(default=None) for parameter in _settings("placement", "node"))
NORMAL = tuple(parameter._replace(default=None) for parameter in _settings("normal", "node"))


def _solid(word: str, parameters: Sequence[Parameter]) -> Any:
    """Builder of a solid: arguments by position, properties, children, placement."""

    def build(positional: List[Any], children: Sequence[Node], given: Dict[str, Any]) -> Node:
        inside = [*children, *nodes_of(parameters, given)]
        return Node(word, positional, properties_of(parameters, given), inside, is_solid=True)

    return build


def _notes(entry: Dict[str, Any]) -> Tuple[str, ...]:
    exact = "Exact distance." if entry["exact"] else "Lower bound of the distance."
    notes = [f"{exact} Source: {entry['source']}."]
    if entry["size_params"] > 1:
        notes.append(f"A single number sets the first {entry['size_params']} parameters.")
    if entry["sheet"]:
        notes.append("No thickness; an emissive material emits only on the front side.")
    if entry["profile"]:
        notes.append("Use it in extrude or revolve.")
    return tuple(notes)


def _free(parameters: Sequence[Parameter], taken: Sequence[Parameter]) -> Tuple[Parameter, ...]:
    """Parameters with names that are not taken: the placement `scale_` of fractals with a parameter `scale`."""
    names = {parameter.name for parameter in taken}
    return tuple(one._replace(name=one.name + "_") if one.name in names else one for one in parameters)


def _shapes() -> Iterator[Function]:
    for entry in REGISTRY["shapes"]:
        parameters = tuple(_parameter(param) for param in entry["params"])
        common = _free((MATERIAL, *PLACEMENT, *(NORMAL if entry["facing"] else ())), parameters)
        name, doc = _python_name(entry["name"]), entry["doc"]
        if entry["outline"] == "points":
            yield Function(name, doc, _drawn(entry["name"], common), (POINTS,), "", common, _notes(entry))
        elif entry["outline"] == "curve":
            common = (*parameters, *common)
            yield Function(name, doc, _drawn(entry["name"], common), (SPLINE,), "", common, _notes(entry))
        elif entry["outline"] == "path":
            common = (*parameters, *common)
            yield Function(name, doc, _solid(entry["name"], common), (PATH,), "", common, _notes(entry))
        elif entry["outline"] == "text":
            common = (*parameters, FONT, *common)
            yield Function(name, doc, _solid(entry["name"], common), (WORDS,), "", common, _notes(entry))
        else:
            build = _solid(entry["name"], (*parameters, *common))
            yield Function(name, doc, build, parameters, "", common, _notes(entry))
    yield _mesh()


POINTS = Parameter("points", "point", "points", "Corners (x, y); at least three.", required=True)
SPLINE = Parameter("points", "point", "points", "Points (x, y) on the curve; at least three.", required=True)
PATH = Parameter("d", "path", "text", "A path in the notation of SVG.", required=True)
WORDS = Parameter("text", "text", "text", "Words of the text; a line break begins another line.", required=True)
FONT = Parameter(
    "font", "font", "text", "A .ttf or .otf file, relative to the scene file; the included font without it."
)
FILE = Parameter("file", "file", "text", "A file, relative to the scene file.", required=True)


def _drawn(name: str, common: Sequence[Parameter]) -> Any:
    def build(positional: List[Any], children: Sequence[Node], given: Dict[str, Any]) -> Node:
        points = positional[0] if positional else given.pop("points")
        corners = [Node("point", flat(point)) for point in points]
        return Node(name, (), properties_of(common, given), [*corners, *nodes_of(common, given)], is_solid=True)

    return build


def _by_name_first(word: str, first: str, parameters: Sequence[Parameter]) -> Any:
    """Builder of a node whose argument may be given by its name in Python, too."""

    def build(positional: List[Any], children: Sequence[Node], given: Dict[str, Any]) -> Node:
        arguments = positional or [given.pop(first)]
        inside = [*children, *nodes_of(parameters, given)]
        return Node(word, arguments, properties_of(parameters, given), inside)

    return build


def _mesh() -> Function:
    doc = "Triangles of a .glb, .gltf, .obj, .stl, .ply or .npy file, alone in their object; or a field of them."
    common = (*_settings("mesh", "property"), MATERIAL, *PLACEMENT)

    def build(positional: List[Any], children: Sequence[Node], given: Dict[str, Any]) -> Node:
        node = _by_name_first("mesh", "file", common)(positional, children, given)
        node.is_solid = True
        return node

    return Function("mesh", doc, build, (FILE,), "", common)


def _operators() -> Iterator[Function]:
    for entry in REGISTRY["operators"]:
        own = tuple(_parameter(param) for param in entry["params"])
        blend = _settings("blend", "property") if entry["blends"] else ()
        keywords = (*own, *blend, MATERIAL, *PLACEMENT)
        build = _solid(entry["name"], keywords)
        yield Function(_python_name(entry["name"]), entry["doc"], build, (), "children", keywords, _notes(entry))


def _modifiers() -> Iterator[Function]:
    for entry in REGISTRY["modifiers"]:
        keywords = (*(_parameter(param) for param in entry["params"]), MATERIAL, *PLACEMENT)
        build = _solid(entry["name"], keywords)
        yield Function(_python_name(entry["name"]), entry["doc"], build, (), "children", keywords, _notes(entry))


def _materials() -> Iterator[Function]:
    trap = Parameter("orbit_trap", "orbit-trap", "node", "Colours of fractals: a node of orbit_trap().")
    bump = Parameter("bump", "bump", "node", "Bump map: a texture with a height.")
    for entry in REGISTRY["materials"]:
        first, *others = (_parameter(param, place="node") for param in entry["params"])
        keywords = (*others, *((trap, bump) if entry["scatters"] else ()))
        notes = (f"Source: {entry['source']}.",) if entry["source"] else ()
        build = _material(entry["name"], first, keywords)
        yield Function(_python_name(entry["name"]), entry["doc"], build, (NAME, first), "", keywords, notes)


def _material(kind: str, first: Parameter, others: Sequence[Parameter]) -> Any:
    """Builder of a material: a node of its kind, beside those of the other parameters."""

    def build(positional: List[Any], children: Sequence[Node], given: Dict[str, Any]) -> Node:
        values = {**dict(zip((NAME.name, first.name), positional)), **given}
        name, value = values.pop("name"), values.pop(first.name, None)
        orbits = values.pop("orbit_trap", None)
        own = [] if value is None else nodes_of([first._replace(word=kind)], {first.name: value})
        inside = [*(own or [Node(kind)]), *nodes_of(others, values), *([orbits] if orbits else [])]
        return Node("material", (name,), children=inside)

    return build


def _textures() -> Iterator[Function]:
    mapped = (
        Parameter("from_", "from", "number", "Value of a number where the texture is 0."),
        Parameter("to", "to", "number", "Value of a number where the texture is 1."),
        Parameter("height", "height", "number", "Height of a bump where the texture is 1, metres."),
    )
    for entry in REGISTRY["textures"]:
        parameters = tuple(_parameter(param) for param in entry["params"])
        keywords = (*mapped, COLOURS, *PLACEMENT)
        build = _texture(entry["name"], (*parameters, *keywords))
        notes = (f"Source: {entry['source']}.",) if entry["source"] else ()
        yield Function(_python_name(entry["name"]), entry["doc"], build, parameters, "", keywords, notes)
    uv = Parameter("uv", "uv", "flag", "True for the texture coordinates of a mesh.")
    keywords = (*(_parameter(param) for param in REGISTRY["picture"]), uv, *mapped, COLOURS, *PLACEMENT)
    yield Function("picture", "A PNG or JPEG file as a texture.", _picture(keywords), (FILE,), "", keywords)
    yield _orbit_trap()


def _texture(word: str, parameters: Sequence[Parameter]) -> Any:
    """Builder of a computed texture, whose numbers are all properties."""

    def build(positional: List[Any], children: Sequence[Node], given: Dict[str, Any]) -> Node:
        given = {**dict(zip((parameter.name for parameter in parameters), positional)), **given}
        inside = [*_ramp(given), *nodes_of(parameters, given)]
        return Node(word, (), properties_of(parameters, given), inside)

    return build


def _ramp(given: Dict[str, Any]) -> List[Node]:
    """Nodes of the colours, which are taken out of the arguments."""
    return [Node("colour", flat(colour)) for colour in given.pop(COLOURS.name, ())]


def _picture(parameters: Sequence[Parameter]) -> Any:
    def build(positional: List[Any], children: Sequence[Node], given: Dict[str, Any]) -> Node:
        return _by_name_first("picture", "file", parameters)(positional, _ramp(given), given)

    return build


def _orbit_trap() -> Function:
    traps = tuple(REGISTRY["traps"])
    trap = Parameter("trap", "trap", "choice", "What the orbits come near to.", traps[0], choices=traps)
    numbers = [
        Parameter(_python_name(word), word, "number", doc, default)
        for word, doc, default in (
            ("x", "Centre of the trap, in the coordinates of the fractal.", 0),
            ("y", "The same.", 0),
            ("z", "The same.", 0),
            ("from", "Value of the trap at the first colour.", 0),
            ("to", "Value of the trap at the last colour.", 1),
        )
    ]
    keywords = (*numbers, COLOURS)

    def build(positional: List[Any], children: Sequence[Node], given: Dict[str, Any]) -> Node:
        name = positional[0] if positional else given.pop("trap", traps[0])
        ramp = _ramp(given)
        return Node("orbit-trap", (name,), properties_of(keywords, given), ramp)

    return Function("orbit_trap", "Colours of a fractal by its orbits, for a material.", build, (trap,), "", keywords)


def _file_nodes() -> Iterator[Function]:
    """Cameras, lights and render settings."""
    optional_name = NAME._replace(required=False, place="argument")
    docs = {
        "camera": "Camera; the first one of a scene is the default.",
        "render": "Size and quality of the picture.",
        "fog": "Medium between the objects, which scatters, absorbs and emits light.",
        "sun": "Light from far away.",
        "point": "Light from a point, the same in every direction.",
        "spot": "Light from a point, in a cone.",
    }
    for word, doc in docs.items():
        settings = _settings(word, "node")
        if word in ("point", "spot"):
            # Instead of it, a light may have candela or lumen.
            settings = tuple(
                one._replace(required=False, default=None) if one.name == "intensity" else one for one in settings
            )
        name = (optional_name,) if word == "camera" else ()
        yield Function(word, doc, _top(word, settings), (), "", (*settings, *name))


def _top(word: str, parameters: Sequence[Parameter]) -> Any:
    def build(positional: List[Any], children: Sequence[Node], given: Dict[str, Any]) -> Node:
        name = given.pop("name", None)
        arguments = [] if name is None else [name]
        return Node(word, arguments, properties_of(parameters, given), [*children, *nodes_of(parameters, given)])

    return build


def _skies() -> Iterator[Function]:
    radiance = Parameter("radiance", "radiance", "colour", "Radiance from every direction.", required=True)
    radiance = radiance._replace(unit="W/(m² sr)", range="0 or more", limits=(0.0, True, None, True))
    doc = "Sky of the same radiance in every direction."
    yield Function(
        "sky",
        doc,
        lambda positional, _, given: Node("sky", flat(positional[0] if positional else given["radiance"])),
        (radiance,),
    )
    gradient = _settings("gradient", "node")
    yield Function("sky_gradient", "Sky with a gradient.", _sky("gradient", gradient), (), "", gradient)
    day = (*_settings("day", "property"), *_settings("day_ground", "node"))
    yield Function("sky_day", "Computed sky of a clear day, with its sun.", _sky("day", day), (), "", day)
    picture = _settings("picture", "property")
    doc = "Sky of a .hdr or .exr file: radiance in every direction."
    yield Function("sky_picture", doc, _by_name_first("sky", "file", picture), (FILE,), "", picture)


def _sky(form: str, parameters: Sequence[Parameter]) -> Any:
    def build(positional: List[Any], children: Sequence[Node], given: Dict[str, Any]) -> Node:
        return Node("sky", (form,), properties_of(parameters, given), nodes_of(parameters, given))

    return build


def _declarations() -> Iterator[Function]:
    """Objects, and what scenes declare by name."""
    yield Function(
        "object",
        "Object: its shapes and their material.",
        _named("object", (MATERIAL,)),
        (NAME,),
        "children",
        (MATERIAL,),
    )
    yield Function(
        "include",
        "File from which a scene takes materials, shapes, objects and lights.",
        _by_name_first("include", "file", ()),
        (FILE,),
    )
    unit = Parameter("unit", "unit", "text", 'Unit: "m", "cm", "mm" or "in".', required=True)
    doc = "Unit of lengths for reports and exports."
    yield Function("unit", doc, _by_name_first("unit", "unit", ()), (unit,))
    yield _param()
    doc = "Shape made of others: nodes of param() for its parameters, then solids. use() places it."
    yield Function("shape", doc, _named("shape", ()), (NAME,), "children")
    yield _field()
    yield _use()


def _named(word: str, parameters: Sequence[Parameter]) -> Any:
    def build(positional: List[Any], children: Sequence[Node], given: Dict[str, Any]) -> Node:
        name = positional[0] if positional else given.pop("name")
        return Node(word, (name,), properties_of(parameters, given), children)

    return build


def _param() -> Function:
    value = Parameter("value", "value", "number", "Value: a number, or a formula as text.", required=True)
    keywords = (
        Parameter("min", "min", "number", "Smallest value."),
        Parameter("max", "max", "number", "Largest value."),
        Parameter("doc", "doc", "text", "One sentence for people."),
    )

    def build(positional: List[Any], children: Sequence[Node], given: Dict[str, Any]) -> Node:
        values = {**dict(zip(("name", "value"), positional)), **given}
        return Node("param", (values["name"], values["value"]), properties_of(keywords, values))

    return Function("param", "Number with a name, which formulas use.", build, (NAME, value), "", keywords)


def _field() -> Function:
    keywords = (
        Parameter(
            "bounds",
            "bounds",
            "numbers",
            'Edges of a box that contains it, metres; or "none".',
            required=True,
            place="node",
        ),
        Parameter("lipschitz", "lipschitz", "number", "Lipschitz constant: the largest slope.", 1, place="node"),
        Parameter("wgsl", "wgsl", "text", "Code in WGSL, with a function `distance(p: vec3f) -> f32`.", place="node"),
        Parameter("glsl", "glsl", "text", "Code in GLSL, in the manner of Shadertoy or Fragmentarium.", place="node"),
        Parameter("entry", "entry", "text", "Name of the distance function in GLSL.", place="glsl"),
        Parameter("doc", "doc", "text", "One sentence for people.", place="node"),
    )

    def build(positional: List[Any], children: Sequence[Node], given: Dict[str, Any]) -> Node:
        name = positional[0] if positional else given.pop("name")
        return Node("field", (name,), children=[*children, *nodes_of(keywords, given)])

    doc = "Distance function in WGSL or GLSL, which is then a shape: nodes of param() for its parameters. use() places it."
    return Function("field", doc, build, (NAME,), "children", keywords)


def _use() -> Function:
    arguments = Parameter("arguments", "arguments", "numbers", "Values of its parameters, in their order.", default=())
    values = Parameter("values", "values", "mapping", "Values of its parameters, by their names.")
    keywords = (values, MATERIAL, *PLACEMENT)

    def build(positional: List[Any], children: Sequence[Node], given: Dict[str, Any]) -> Node:
        both = {**dict(zip(("name", "arguments"), positional)), **given}
        properties = {**both.get("values", {}), **properties_of((MATERIAL,), both)}
        return Node(both["name"], flat(both.get("arguments", ())), properties, nodes_of(PLACEMENT, both), is_solid=True)

    doc = "A shape that the scene declares by shape() or field()."
    return Function("use", doc, build, (NAME, arguments), "", keywords)
