"""Scenes made of Python objects: every word of the registry has a function, and its text is read as it is meant."""

import inspect

import numpy
import pytest

import pathmarch
from pathmarch import nodes
from pathmarch._language import REGISTRY, functions

CAMERA = nodes.camera(position=(0, 1, 9), target=(0, 0, 0))


def scene_of(*top):
    return nodes.scene(CAMERA, nodes.sky(1), *top)


def entries(*tables):
    return [pytest.param(entry, id=entry["name"]) for table in tables for entry in REGISTRY[table]]


def python_name(word):
    return word.replace("-", "_")


def value_of(param):
    """A value that a parameter may have and that differs from its default."""
    if param["kind"] == "axis":
        return "z"
    default = param["default"]
    if param["kind"] == "flag":
        return not default
    for value in (default + 1, default * 0.9 + 0.05, default * 0.5):
        low, high = param["min"], param["max"]
        if (low is None or value > low) and (high is None or value < high):
            return int(value) if param["kind"] == "whole" else value
    raise AssertionError(param)


@pytest.mark.parametrize("entry", entries("shapes"))
def test_every_shape_is_read_as_it_is_written(entry):
    function = getattr(nodes, python_name(entry["name"]))
    points = [[(0, 0), (1, 0), (0, 1)]]
    required = {"points": points, "curve": points, "text": ["ab"], "path": ["M 0 0 H 1 V 1 Z"]}.get(entry["outline"], [])
    solids = [function(*required)]
    for param in entry["params"]:
        if entry["name"] not in ("rounded-box", "rectangle"):
            solids.append(function(*required, **{python_name(param["name"]): value_of(param)}))
    for solid in solids:
        inside = nodes.extrude(solid) if entry["profile"] else solid
        assert scene_of(nodes.object("solid", inside)).objects == ("solid",), str(solid)
    assert len({str(solid) for solid in solids}) == len(solids)


@pytest.mark.parametrize("entry", entries("operators", "modifiers"))
def test_every_operator_and_modifier_is_read_as_it_is_written(entry):
    function = getattr(nodes, python_name(entry["name"]))
    children = [nodes.sphere(1), nodes.box(1)]
    for param in entry["params"]:
        solid = function(*children, at=(0, 1, 0), **{python_name(param["name"]): value_of(param)})
        assert scene_of(nodes.object("solid", solid)).objects == ("solid",), str(solid)
    if entry.get("blends"):
        for profile in REGISTRY["profiles"]:
            blended = function(children, smooth=0.1, profile=profile["name"])
            assert scene_of(nodes.object("solid", blended)).objects == ("solid",)


@pytest.mark.parametrize("entry", entries("materials"))
def test_every_material_is_read_as_it_is_written(entry):
    function = getattr(nodes, python_name(entry["name"]))
    plain = [function("m"), function("m", (0.1, 0.2, 0.3)), function("m", "#c8691e")]
    for param in entry["params"][1:]:
        plain.append(function("m", **{python_name(param["name"]): value_of(param)}))
        if param["textured"]:
            plain.append(function("m", **{python_name(param["name"]): nodes.checker(0.1)}))
    for material in plain:
        scene = scene_of(nodes.object("ball", nodes.sphere(1), material=material))
        assert scene.materials == ("m",), str(material)


@pytest.mark.parametrize("entry", entries("textures"))
def test_every_texture_is_read_as_it_is_written(entry):
    function = getattr(nodes, python_name(entry["name"]))
    for param in entry["params"]:
        texture = function(
            **{python_name(param["name"]): value_of(param)},
            colours=[0.1, (0.2, 0.3, 0.4)],
            at=(1, 0, 0),
            rotate=(0, 9, 0),
        )
        material = nodes.diffuse("m", texture, bump=function(height=0.001))
        assert scene_of(nodes.object("ball", nodes.sphere(1), material=material)).materials == ("m",), str(material)


def test_functions_are_those_of_the_registry():
    words = {
        entry["name"]
        for table in ("shapes", "operators", "modifiers", "materials", "textures")
        for entry in REGISTRY[table]
    }
    assert {python_name(word) for word in words} <= set(nodes.__all__)
    names = [function.name for function in functions()]
    assert len(names) == len(set(names)) > 60
    assert all(inspect.getdoc(getattr(nodes, name)) for name in names)


def test_help_has_the_documentation_of_the_registry():
    doc, signature = inspect.getdoc(nodes.sphere), inspect.signature(nodes.sphere)
    assert str(signature) == "(radius=1, *, material=None, at=None, rotate=None, scale=None)"
    sphere = next(entry for entry in REGISTRY["shapes"] if entry["name"] == "sphere")
    assert doc.startswith(sphere["doc"]) and sphere["params"][0]["doc"] in doc and sphere["source"] in doc
    assert "radius : number, above 0, m, default 1" in doc
    assert '"soft" | "round" | "chamfer" | "stairs"' in inspect.getdoc(nodes.union)


@pytest.mark.parametrize(
    "make, error, message",
    [
        (lambda: nodes.sphere(-1), ValueError, r"sphere\(\): radius must be above 0, not -1"),
        (lambda: nodes.sphere(radius=(1, 2)), TypeError, r"expected a number or a formula, not \(1, 2\)"),
        (lambda: nodes.diffuse("m", (1, 1)), ValueError, "expected a colour: .*, not 2 values"),
        (lambda: nodes.sphere(None, None), TypeError, "too many positional arguments"),
        (lambda: nodes.sphere(radiu=1), TypeError, "did you mean radius?"),
        (lambda: nodes.sphere([1]), TypeError, r"expected a number or a formula, not \[1\]"),
        (lambda: nodes.sphere(object()), TypeError, "expected a number or a formula"),
        (lambda: nodes.sphere(float("nan")), ValueError, "radius must be above 0, not nan"),
        (lambda: nodes.box(1, at=(1, 2)), ValueError, "at: expected three numbers or formulas, not 2 values"),
        (lambda: nodes.box(1, at=(1, 2, float("inf"))), ValueError, "not finite"),
        (lambda: nodes.mirror(nodes.box(1), axis="w"), ValueError, "axis must be one of x, y, z, not 'w'"),
        (lambda: nodes.menger(2.5), ValueError, "iterations must be a whole number"),
        (lambda: nodes.union(3), TypeError, r"union\(\): expected nodes such as sphere\(1\), not 3"),
        (lambda: nodes.union(nodes.box(1), profile="odd"), ValueError, "profile must be one of soft, round"),
        (lambda: nodes.diffuse("m", 1.5), ValueError, "from 0 to 1, not 1.5"),
        (lambda: nodes.glass("m", ior=nodes.checker()), TypeError, "ior cannot be a node"),
        (lambda: nodes.diffuse("m", bump=0.1), TypeError, "bump must be a node"),
        (lambda: nodes.sphere(1, material=3), TypeError, "material must be a material or its name, not 3"),
        (lambda: nodes.polygon(3), TypeError, "points must be a list of points, not 3"),
        (lambda: nodes.marble(colours=0.5), TypeError, "colours must be a list of colours, not 0.5"),
        (lambda: nodes.sky_day(sun="no"), TypeError, "sun must be True or False, not 'no'"),
        (lambda: nodes.use("bolt", values=[1]), TypeError, "values must be a dictionary"),
        (lambda: nodes.camera(position=(0, 0, 0)), TypeError, "missing a required"),
        (lambda: nodes.scene_text("pathmarch 1"), TypeError, "expected nodes"),
    ],
)
def test_arguments_that_the_language_would_refuse_are_refused(make, error, message):
    with pytest.raises(error, match=message):
        str(make())


@pytest.mark.parametrize(
    "node, text",
    [
        (nodes.sphere(), "sphere"),
        (nodes.sphere(2.0), "sphere 2"),
        (nodes.sphere(radius=0.1), "sphere radius=0.1"),
        (nodes.sphere(numpy.float32(0.1)), "sphere 0.1"),
        (nodes.sphere(numpy.float64(1e-7)), "sphere 1e-07"),
        (nodes.sphere("1 + 0.2*sin(t)"), 'sphere "1 + 0.2*sin(t)"'),
        (nodes.box(1, numpy.int64(2), 3, at=numpy.array([0, 1, 0.5])), "box 1 2 3 { at 0 1 0.5 }"),
        (nodes.rounded_box(2, radius=0.2), "rounded-box 2 radius=0.2"),
        (nodes.mandelbox(-1.5, scale_=2), "mandelbox -1.5 { scale 2 }"),
        (nodes.mirror(nodes.box(1), axis="z"), 'mirror axis="z" { box 1 }'),
        (nodes.polygon([(0, 0), (1, 0), (0, 1)]), "polygon { point 0 0; point 1 0; point 0 1 }"),
        (nodes.text('say "hi"\n\\', size=2), 'text "say \\"hi\\"\\n\\\\" size=2'),
        (nodes.mesh("cow.obj", as_="field", resolution=64), 'mesh "cow.obj" as="field" resolution=64'),
        (nodes.disc(1, normal=(1, 0, 0)), "disc 1 { normal 1 0 0 }"),
        (nodes.metal("steel", (0.5, 0.5, 0.5), roughness=0.1), 'material "steel" { metal 0.5 0.5 0.5; roughness 0.1 }'),
        (nodes.emit("lamp"), 'material "lamp" { emit }'),
        (nodes.diffuse("m", nodes.picture("a.png", size=2)), 'material "m" { diffuse { picture "a.png" size=2 } }'),
        (nodes.picture("a.png", uv=True), 'picture "a.png" uv=#true'),
        (nodes.sky((1, 2, 3)), "sky 1 2 3"),
        (nodes.sky_day(elevation=20, sun=False), 'sky "day" elevation=20 sun=#false'),
        (nodes.sky_picture("a.hdr", strength=2), 'sky "a.hdr" strength=2'),
        (
            nodes.camera(position=(0, 0, 1), target=(0, 0, 0), lens_radius=0.1, lens_focus=2, name="a"),
            'camera "a" { position 0 0 1; target 0 0 0; lens radius=0.1 focus=2 }',
        ),
        (nodes.param("a", 1, min=0, doc="Of b."), 'param "a" 1 min=0 doc="Of b."'),
        (nodes.use("bolt", 0.5, material="brass", at=(1, 0, 0)), 'bolt 0.5 material="brass" { at 1 0 0 }'),
        (nodes.use("bolt", values={"head": 0.1}), "bolt head=0.1"),
        (nodes.orbit_trap("line", from_=0.5, colours=[1, 0]), 'orbit-trap "line" from=0.5 { colour 1; colour 0 }'),
    ],
)
def test_nodes_print_the_language(node, text):
    assert str(node) == text


def test_long_nodes_have_a_line_for_each_node_in_them():
    node = nodes.union(*[nodes.sphere(0.1, at=(index, 0, 0)) for index in range(20)])
    lines = str(node).split("\n")
    assert len(lines) == 22 and lines[1] == "    sphere 0.1 { at 0 0 0 }"
    bounds = scene_of(nodes.object("row", node)).bounds
    assert numpy.allclose(bounds, [[-0.1, -0.1, -0.1], [19.1, 0.1, 0.1]])


def test_materials_that_are_used_are_part_of_the_scene():
    clay, gold = nodes.diffuse("clay", 0.5), nodes.metal("gold")
    scene = scene_of(nodes.object("a", nodes.sphere(1, material=clay), nodes.box(1, material=gold), material=clay))
    assert scene.materials == ("clay", "gold")
    assert scene_of(clay, nodes.object("a", nodes.sphere(1), material=clay)).materials == ("clay",)
    with pytest.raises(ValueError, match='two materials are called "clay"'):
        scene_of(clay, nodes.object("a", nodes.sphere(1, material=nodes.diffuse("clay", 0.2))))


def test_declared_shapes_and_fields_are_used_by_name():
    bolt = nodes.shape("bolt", nodes.param("length", 0.5), nodes.cylinder(0.1, "length"), nodes.hexprism(0.2, 0.1))
    code = "fn distance(p: vec3f) -> f32 {\n    return length(p) - radius;\n}\n"
    blob = nodes.field("blob", nodes.param("radius", 0.5), bounds=(2, 2, 2), lipschitz=1, wgsl=code)
    scene = scene_of(
        bolt,
        blob,
        nodes.object("both", nodes.use("bolt", 0.7), nodes.use("blob", values={"radius": 0.25}, at=(2, 0, 0))),
    )
    assert scene.distance([[2, 0, 0]]).tolist() == [-0.25]
    assert "\n    fn distance(p: vec3f) -> f32 {\n" in scene.text, scene.text
    tricky = 'float map(vec3 p) { // a \\ and a "b" """\n\n    return length(p) - 0.5;\n}'
    glsl = nodes.field("ball", bounds=(2, 2, 2), glsl=tricky, entry="map", doc="Ball.")
    assert scene_of(glsl, nodes.object("ball", nodes.use("ball"))).distance([[1, 0, 0]]).tolist() == [0.5]


def test_a_scene_of_nodes_is_the_scene_of_its_text():
    top = [
        nodes.render(size=(64, 36), samples=8),
        nodes.sun(direction=(0, 1, 0), irradiance=1),
        nodes.object("a", nodes.torus()),
    ]
    scene = scene_of(*top)
    again = pathmarch.Scene(scene.text)
    assert again.text == scene.text == nodes.scene_text(CAMERA, nodes.sky(1), *top)
    assert scene.render(samples=1, backend="cpu").tobytes() == again.render(samples=1, backend="cpu").tobytes()
    assert scene.render(samples=1).shape == (36, 64, 3)


def test_the_example_of_ten_lines_can_be_written_in_python(scenes):
    clay, cream, slate = (
        nodes.diffuse("clay", (0.7, 0.22, 0.08)),
        nodes.diffuse("cream", (0.8, 0.7, 0.5)),
        nodes.diffuse("slate", (0.12, 0.2, 0.3)),
    )
    block = nodes.subtract(
        nodes.box(1.6, 1.3, 1.6, material=clay),
        nodes.sphere(0.85, material=cream, at=(0.5, 0.45, 0.5)),
        smooth=0.12,
        at=(0, 0.65, 0),
    )
    scene = nodes.scene(
        nodes.camera(name="main", position=(3.1, 2.6, 4.5), target=(0.05, 0.5, 0), fov=27),
        nodes.sky((0.22, 0.3, 0.45)),
        nodes.sun(direction=(0.9, 0.8, 0.1), irradiance=(2.4, 2, 1.5), angle=2),
        clay,
        cream,
        slate,
        nodes.object("block", block),
        nodes.object("ball", nodes.sphere(0.3, at=(0.5, 0.55, 0.5)), material=slate),
        nodes.object("floor", nodes.plane(), material=slate),
    )
    options = {"size": (48, 27), "samples": 2, "backend": "cpu"}
    assert scene.render(**options).tobytes() == pathmarch.render(scenes / "ten-lines.kdl", **options).tobytes()
