# Written by make_stubs.py from the registry of the scene language.
from typing import Literal, Mapping, Optional, Sequence, Union

from ._kdl import Node as Node
from ._scenes import scene as scene, scene_text as scene_text

_Number = Union[float, str]
"""A number, or a formula as text."""
_Vector = Sequence[_Number]
_Colour = Union[_Number, Sequence[_Number]]
"""One number, three, or a text such as "#c8691e"."""
_Material = Union[Node, str]

__all__ = [
    "Node",
    "scene",
    "scene_text",
    "sphere",
    "box",
    "rounded_box",
    "plane",
    "rect",
    "disc",
    "cylinder",
    "cone",
    "capsule",
    "ellipsoid",
    "torus",
    "link",
    "prism",
    "hexprism",
    "pyramid",
    "octahedron",
    "mandelbulb",
    "mandelbox",
    "julia",
    "menger",
    "sierpinski",
    "apollonian",
    "kleinian",
    "ifs",
    "circle",
    "rectangle",
    "star",
    "polygon",
    "curve",
    "path",
    "text",
    "mesh",
    "union",
    "subtract",
    "intersect",
    "morph",
    "repeat",
    "polar",
    "mirror",
    "twist",
    "bend",
    "elongate",
    "round",
    "shell",
    "displace",
    "extrude",
    "revolve",
    "diffuse",
    "metal",
    "glass",
    "principled",
    "emit",
    "medium",
    "fbm",
    "marble",
    "wood",
    "brick",
    "checker",
    "voronoi",
    "cells",
    "cracks",
    "picture",
    "orbit_trap",
    "camera",
    "render",
    "fog",
    "sun",
    "point",
    "spot",
    "sky",
    "sky_gradient",
    "sky_day",
    "sky_picture",
    "object",
    "include",
    "unit",
    "param",
    "shape",
    "field",
    "use",
]

def sphere(
    radius: _Number = 1,
    *,
    material: Optional[_Material] = None,
    at: Optional[_Vector] = None,
    rotate: Optional[_Vector] = None,
    scale: Optional[_Number] = None,
) -> Node:
    """Sphere centred at the origin."""

def box(
    x: _Number = 1,
    y: _Number = 1,
    z: _Number = 1,
    *,
    material: Optional[_Material] = None,
    at: Optional[_Vector] = None,
    rotate: Optional[_Vector] = None,
    scale: Optional[_Number] = None,
) -> Node:
    """Box centred at the origin, its edges along the axes."""

def rounded_box(
    x: _Number = 1,
    y: _Number = 1,
    z: _Number = 1,
    radius: _Number = 0.1,
    *,
    material: Optional[_Material] = None,
    at: Optional[_Vector] = None,
    rotate: Optional[_Vector] = None,
    scale: Optional[_Number] = None,
) -> Node:
    """Box with rounded edges and corners, centred at the origin, its edges along the axes."""

def plane(
    *,
    material: Optional[_Material] = None,
    at: Optional[_Vector] = None,
    rotate: Optional[_Vector] = None,
    scale: Optional[_Number] = None,
    normal: Optional[_Vector] = None,
) -> Node:
    """Endless plane through the origin, solid below; faces +y."""

def rect(
    x: _Number = 1,
    z: _Number = 1,
    *,
    material: Optional[_Material] = None,
    at: Optional[_Vector] = None,
    rotate: Optional[_Vector] = None,
    scale: Optional[_Number] = None,
    normal: Optional[_Vector] = None,
) -> Node:
    """Rectangular sheet without thickness in the plane y = 0; faces +y."""

def disc(
    radius: _Number = 1,
    *,
    material: Optional[_Material] = None,
    at: Optional[_Vector] = None,
    rotate: Optional[_Vector] = None,
    scale: Optional[_Number] = None,
    normal: Optional[_Vector] = None,
) -> Node:
    """Round sheet without thickness in the plane y = 0; faces +y."""

def cylinder(
    radius: _Number = 0.5,
    height: _Number = 1,
    *,
    material: Optional[_Material] = None,
    at: Optional[_Vector] = None,
    rotate: Optional[_Vector] = None,
    scale: Optional[_Number] = None,
) -> Node:
    """Capped cylinder about the y axis, centred at the origin."""

def cone(
    radius: _Number = 0.5,
    height: _Number = 1,
    *,
    material: Optional[_Material] = None,
    at: Optional[_Vector] = None,
    rotate: Optional[_Vector] = None,
    scale: Optional[_Number] = None,
) -> Node:
    """Cone about the y axis, its base at -height/2 and its apex at +height/2."""

def capsule(
    radius: _Number = 0.25,
    height: _Number = 1,
    *,
    material: Optional[_Material] = None,
    at: Optional[_Vector] = None,
    rotate: Optional[_Vector] = None,
    scale: Optional[_Number] = None,
) -> Node:
    """Cylinder about the y axis with half spheres for ends, centred at the origin."""

def ellipsoid(
    x: _Number = 1,
    y: _Number = 0.5,
    z: _Number = 0.75,
    *,
    material: Optional[_Material] = None,
    at: Optional[_Vector] = None,
    rotate: Optional[_Vector] = None,
    scale: Optional[_Number] = None,
) -> Node:
    """Ellipsoid centred at the origin, its axes along the coordinate axes."""

def torus(
    major: _Number = 1,
    minor: _Number = 0.25,
    *,
    material: Optional[_Material] = None,
    at: Optional[_Vector] = None,
    rotate: Optional[_Vector] = None,
    scale: Optional[_Number] = None,
) -> Node:
    """Ring about the y axis, centred at the origin."""

def link(
    length: _Number = 0.5,
    major: _Number = 0.3,
    minor: _Number = 0.1,
    *,
    material: Optional[_Material] = None,
    at: Optional[_Vector] = None,
    rotate: Optional[_Vector] = None,
    scale: Optional[_Number] = None,
) -> Node:
    """Chain link in the plane z = 0, long along y, centred at the origin."""

def prism(
    side: _Number = 1,
    depth: _Number = 1,
    *,
    material: Optional[_Material] = None,
    at: Optional[_Vector] = None,
    rotate: Optional[_Vector] = None,
    scale: Optional[_Number] = None,
) -> Node:
    """Equilateral triangle in xy, a corner up, its centroid at the origin, extruded along z."""

def hexprism(
    radius: _Number = 0.5,
    height: _Number = 1,
    *,
    material: Optional[_Material] = None,
    at: Optional[_Vector] = None,
    rotate: Optional[_Vector] = None,
    scale: Optional[_Number] = None,
) -> Node:
    """Regular hexagon in xz, two corners on the x axis, extruded along y; centred at the origin."""

def pyramid(
    base: _Number = 1,
    height: _Number = 1,
    *,
    material: Optional[_Material] = None,
    at: Optional[_Vector] = None,
    rotate: Optional[_Vector] = None,
    scale: Optional[_Number] = None,
) -> Node:
    """Pyramid on a square in the plane y = 0 centred at the origin, its apex on the y axis."""

def octahedron(
    radius: _Number = 1,
    *,
    material: Optional[_Material] = None,
    at: Optional[_Vector] = None,
    rotate: Optional[_Vector] = None,
    scale: Optional[_Number] = None,
) -> Node:
    """Regular octahedron centred at the origin, its corners on the axes."""

def mandelbulb(
    power: Union[int, str] = 8,
    iterations: Union[int, str] = 8,
    *,
    material: Optional[_Material] = None,
    at: Optional[_Vector] = None,
    rotate: Optional[_Vector] = None,
    scale: Optional[_Number] = None,
) -> Node:
    """Mandelbulb centred at the origin, its axis along y."""

def mandelbox(
    scale: _Number = -1.5,
    iterations: Union[int, str] = 12,
    fold: _Number = 1,
    min_radius: _Number = 0.5,
    fixed_radius: _Number = 1,
    *,
    material: Optional[_Material] = None,
    at: Optional[_Vector] = None,
    rotate: Optional[_Vector] = None,
    scale_: Optional[_Number] = None,
) -> Node:
    """Mandelbox centred at the origin."""

def julia(
    x: _Number = -0.2,
    y: _Number = 0.4,
    z: _Number = -0.4,
    w: _Number = -0.4,
    iterations: Union[int, str] = 10,
    *,
    material: Optional[_Material] = None,
    at: Optional[_Vector] = None,
    rotate: Optional[_Vector] = None,
    scale: Optional[_Number] = None,
) -> Node:
    """Slice of the quaternion Julia set of q² + c, the real axis along x."""

def menger(
    iterations: Union[int, str] = 4,
    *,
    material: Optional[_Material] = None,
    at: Optional[_Vector] = None,
    rotate: Optional[_Vector] = None,
    scale: Optional[_Number] = None,
) -> Node:
    """Menger's sponge in the cube of edge 2 centred at the origin."""

def sierpinski(
    iterations: Union[int, str] = 10,
    *,
    material: Optional[_Material] = None,
    at: Optional[_Vector] = None,
    rotate: Optional[_Vector] = None,
    scale: Optional[_Number] = None,
) -> Node:
    """Sierpinski's tetrahedron on alternate corners of the cube of edge 2 centred at the origin."""

def apollonian(
    iterations: Union[int, str] = 8,
    ratio: _Number = 1.2,
    *,
    material: Optional[_Material] = None,
    at: Optional[_Vector] = None,
    rotate: Optional[_Vector] = None,
    scale: Optional[_Number] = None,
) -> Node:
    """Sheets of an Apollonian packing in the cube of edge 2 centred at the origin."""

def kleinian(
    iterations: Union[int, str] = 8,
    x: _Number = 0.92,
    y: _Number = 0.91,
    z: _Number = 0.92,
    radius: _Number = 1,
    *,
    material: Optional[_Material] = None,
    at: Optional[_Vector] = None,
    rotate: Optional[_Vector] = None,
    scale: Optional[_Number] = None,
) -> Node:
    """Pseudo-Kleinian fractal in the cube of edge 4 centred at the origin."""

def ifs(
    scale: _Number = 2,
    iterations: Union[int, str] = 8,
    turn_x: _Number = 0,
    turn_y: _Number = 0,
    turn_z: _Number = 0,
    offset_x: _Number = 1,
    offset_y: _Number = 0,
    offset_z: _Number = 0,
    *,
    material: Optional[_Material] = None,
    at: Optional[_Vector] = None,
    rotate: Optional[_Vector] = None,
    scale_: Optional[_Number] = None,
) -> Node:
    """Kaleidoscopic iterated function system with the mirrors of a cube, centred at the origin."""

def circle(
    radius: _Number = 0.5,
    *,
    material: Optional[_Material] = None,
    at: Optional[_Vector] = None,
    rotate: Optional[_Vector] = None,
    scale: Optional[_Number] = None,
) -> Node:
    """Profile: a disc around the origin."""

def rectangle(
    x: _Number = 1,
    y: _Number = 1,
    radius: _Number = 0,
    *,
    material: Optional[_Material] = None,
    at: Optional[_Vector] = None,
    rotate: Optional[_Vector] = None,
    scale: Optional[_Number] = None,
) -> Node:
    """Profile: a rectangle around the origin."""

def star(
    points: Union[int, str] = 5,
    outer: _Number = 0.5,
    inner: _Number = 0.25,
    *,
    material: Optional[_Material] = None,
    at: Optional[_Vector] = None,
    rotate: Optional[_Vector] = None,
    scale: Optional[_Number] = None,
) -> Node:
    """Profile: a star around the origin, a point up."""

def polygon(
    points: Sequence[_Vector],
    *,
    material: Optional[_Material] = None,
    at: Optional[_Vector] = None,
    rotate: Optional[_Vector] = None,
    scale: Optional[_Number] = None,
) -> Node:
    """Profile: what the lines between points go around."""

def curve(
    points: Sequence[_Vector],
    *,
    width: _Number = 0,
    material: Optional[_Material] = None,
    at: Optional[_Vector] = None,
    rotate: Optional[_Vector] = None,
    scale: Optional[_Number] = None,
) -> Node:
    """Profile: a smooth curve through points, filled or drawn as a line."""

def path(
    d: str,
    *,
    width: _Number = 0,
    material: Optional[_Material] = None,
    at: Optional[_Vector] = None,
    rotate: Optional[_Vector] = None,
    scale: Optional[_Number] = None,
) -> Node:
    """Profile: a path in the notation of SVG, filled or drawn as a line; y points up."""

def text(
    text: str,
    *,
    size: _Number = 1,
    font: Optional[str] = None,
    material: Optional[_Material] = None,
    at: Optional[_Vector] = None,
    rotate: Optional[_Vector] = None,
    scale: Optional[_Number] = None,
) -> Node:
    """Profile: letters that stand on the x axis, centred at x = 0."""

def mesh(
    file: str,
    *,
    as_: Literal["triangles", "field", "lit-by-field"] = "triangles",
    resolution: Union[int, str] = 192,
    node: Union[int, str] = 0,
    material: Optional[_Material] = None,
    at: Optional[_Vector] = None,
    rotate: Optional[_Vector] = None,
    scale: Optional[_Number] = None,
) -> Node:
    """Triangles of a .glb, .gltf, .obj, .stl, .ply or .npy file, alone in their object; or a field of them."""

def union(
    *children: Union[Node, Sequence[Node]],
    smooth: _Number = 0,
    profile: Literal["soft", "round", "chamfer", "stairs"] = "soft",
    steps: Union[int, str] = 4,
    material: Optional[_Material] = None,
    at: Optional[_Vector] = None,
    rotate: Optional[_Vector] = None,
    scale: Optional[_Number] = None,
) -> Node:
    """Union of all children."""

def subtract(
    *children: Union[Node, Sequence[Node]],
    smooth: _Number = 0,
    profile: Literal["soft", "round", "chamfer", "stairs"] = "soft",
    steps: Union[int, str] = 4,
    material: Optional[_Material] = None,
    at: Optional[_Vector] = None,
    rotate: Optional[_Vector] = None,
    scale: Optional[_Number] = None,
) -> Node:
    """The first child without the others."""

def intersect(
    *children: Union[Node, Sequence[Node]],
    smooth: _Number = 0,
    profile: Literal["soft", "round", "chamfer", "stairs"] = "soft",
    steps: Union[int, str] = 4,
    material: Optional[_Material] = None,
    at: Optional[_Vector] = None,
    rotate: Optional[_Vector] = None,
    scale: Optional[_Number] = None,
) -> Node:
    """Intersection of all children."""

def morph(
    *children: Union[Node, Sequence[Node]],
    amount: _Number = 0.5,
    material: Optional[_Material] = None,
    at: Optional[_Vector] = None,
    rotate: Optional[_Vector] = None,
    scale: Optional[_Number] = None,
) -> Node:
    """A shape between two."""

def repeat(
    *children: Union[Node, Sequence[Node]],
    x: _Number = 2,
    y: _Number = 0,
    z: _Number = 2,
    count: Union[int, str] = 0,
    count_x: Union[int, str] = 0,
    count_y: Union[int, str] = 0,
    count_z: Union[int, str] = 0,
    material: Optional[_Material] = None,
    at: Optional[_Vector] = None,
    rotate: Optional[_Vector] = None,
    scale: Optional[_Number] = None,
) -> Node:
    """Copies of its child on a lattice around the origin, endless unless counted."""

def polar(
    *children: Union[Node, Sequence[Node]],
    count: Union[int, str] = 6,
    material: Optional[_Material] = None,
    at: Optional[_Vector] = None,
    rotate: Optional[_Vector] = None,
    scale: Optional[_Number] = None,
) -> Node:
    """Copies of its child, rotated about the y axis."""

def mirror(
    *children: Union[Node, Sequence[Node]],
    axis: Literal["x", "y", "z"] = "x",
    material: Optional[_Material] = None,
    at: Optional[_Vector] = None,
    rotate: Optional[_Vector] = None,
    scale: Optional[_Number] = None,
) -> Node:
    """Its child and the mirror image behind a plane through the origin."""

def twist(
    *children: Union[Node, Sequence[Node]],
    turns_per_metre: _Number = 0.25,
    material: Optional[_Material] = None,
    at: Optional[_Vector] = None,
    rotate: Optional[_Vector] = None,
    scale: Optional[_Number] = None,
) -> Node:
    """Twists its child about the y axis, in proportion to the height."""

def bend(
    *children: Union[Node, Sequence[Node]],
    turns_per_metre: _Number = 0.1,
    material: Optional[_Material] = None,
    at: Optional[_Vector] = None,
    rotate: Optional[_Vector] = None,
    scale: Optional[_Number] = None,
) -> Node:
    """Bends the x axis of its child upwards into a circle."""

def elongate(
    *children: Union[Node, Sequence[Node]],
    x: _Number = 0.5,
    y: _Number = 0,
    z: _Number = 0,
    material: Optional[_Material] = None,
    at: Optional[_Vector] = None,
    rotate: Optional[_Vector] = None,
    scale: Optional[_Number] = None,
) -> Node:
    """Cuts its child in the middle, moves the parts apart and joins them straight."""

def round(
    *children: Union[Node, Sequence[Node]],
    radius: _Number = 0.1,
    material: Optional[_Material] = None,
    at: Optional[_Vector] = None,
    rotate: Optional[_Vector] = None,
    scale: Optional[_Number] = None,
) -> Node:
    """Thickens its child on every side and rounds its edges."""

def shell(
    *children: Union[Node, Sequence[Node]],
    thickness: _Number = 0.05,
    material: Optional[_Material] = None,
    at: Optional[_Vector] = None,
    rotate: Optional[_Vector] = None,
    scale: Optional[_Number] = None,
) -> Node:
    """Wall along the surface of its child, hollow inside."""

def displace(
    *children: Union[Node, Sequence[Node]],
    amplitude: _Number = 0.05,
    frequency: _Number = 2,
    material: Optional[_Material] = None,
    at: Optional[_Vector] = None,
    rotate: Optional[_Vector] = None,
    scale: Optional[_Number] = None,
) -> Node:
    """Displaces the surface of its child in and out by a wave."""

def extrude(
    *children: Union[Node, Sequence[Node]],
    height: _Number = 1,
    material: Optional[_Material] = None,
    at: Optional[_Vector] = None,
    rotate: Optional[_Vector] = None,
    scale: Optional[_Number] = None,
) -> Node:
    """A profile drawn out along z, centred at z = 0; of a solid, its slice there."""

def revolve(
    *children: Union[Node, Sequence[Node]],
    offset: _Number = 0,
    material: Optional[_Material] = None,
    at: Optional[_Vector] = None,
    rotate: Optional[_Vector] = None,
    scale: Optional[_Number] = None,
) -> Node:
    """A profile turned about the y axis, as on a lathe; of a solid, its slice at z = 0."""

def diffuse(
    name: str,
    albedo: Union[_Colour, Node] = 0.8,
    *,
    emission: _Colour = 0,
    orbit_trap: Optional[Node] = None,
    bump: Optional[Node] = None,
) -> Node:
    """Matt surface that looks equally bright from everywhere."""

def metal(
    name: str,
    colour: Union[_Colour, Node] = 0.9,
    *,
    edge: Union[_Colour, Node] = 1,
    roughness: Union[_Number, Node] = 0.2,
    emission: _Colour = 0,
    multiscatter: Union[_Number, Node] = 0,
    orbit_trap: Optional[Node] = None,
    bump: Optional[Node] = None,
) -> Node:
    """Metal, from a mirror to a brushed block: reflects in its own colour."""

def glass(
    name: str,
    colour: Union[_Colour, Node] = 1,
    *,
    ior: _Number = 1.5,
    roughness: Union[_Number, Node] = 0,
    absorb: _Colour = 0,
    abbe: _Number = 0,
    scatter: _Colour = 0,
    anisotropy: _Number = 0,
    glow: _Colour = 0,
    multiscatter: Union[_Number, Node] = 0,
    priority: Union[int, str] = 0,
    thin: bool = False,
    orbit_trap: Optional[Node] = None,
    bump: Optional[Node] = None,
) -> Node:
    """Glass, water or ice, clear or frosted: reflects and refracts."""

def principled(
    name: str,
    colour: Union[_Colour, Node] = 0.8,
    *,
    metallic: Union[_Number, Node] = 0,
    roughness: Union[_Number, Node] = 0.4,
    ior: _Number = 1.5,
    coat: Union[_Number, Node] = 0,
    coat_roughness: Union[_Number, Node] = 0,
    transmission: Union[_Number, Node] = 0,
    absorb: _Colour = 0,
    emission: _Colour = 0,
    scatter: _Colour = 0,
    anisotropy: _Number = 0,
    glow: _Colour = 0,
    priority: Union[int, str] = 0,
    orbit_trap: Optional[Node] = None,
    bump: Optional[Node] = None,
) -> Node:
    """Most things: plastic, paint, coated wood, metal, frosted glass."""

def emit(
    name: str,
    radiance: _Colour = 1,
) -> Node:
    """Lamp: the same radiance in every outward direction; reflects nothing."""

def medium(
    name: str,
    scattering: _Colour = 1,
    *,
    absorb: _Colour = 0,
    anisotropy: _Number = 0,
    glow: _Colour = 0,
) -> Node:
    """Smoke, mist or a flame: scatters and absorbs inside, without a surface."""

def fbm(
    size: _Number = 0.2,
    octaves: Union[int, str] = 5,
    gain: _Number = 0.5,
    contrast: _Number = 1,
    seed: Union[int, str] = 0,
    *,
    from_: Optional[_Number] = None,
    to: Optional[_Number] = None,
    height: Optional[_Number] = None,
    colours: Sequence[_Colour] = (),
    at: Optional[_Vector] = None,
    rotate: Optional[_Vector] = None,
    scale: Optional[_Number] = None,
) -> Node:
    """Clouds: noise with ever finer detail."""

def marble(
    size: _Number = 0.3,
    turbulence: _Number = 1.2,
    sharpness: _Number = 4,
    octaves: Union[int, str] = 5,
    seed: Union[int, str] = 0,
    *,
    from_: Optional[_Number] = None,
    to: Optional[_Number] = None,
    height: Optional[_Number] = None,
    colours: Sequence[_Colour] = (),
    at: Optional[_Vector] = None,
    rotate: Optional[_Vector] = None,
    scale: Optional[_Number] = None,
) -> Node:
    """Veins across x: 1 in the middle of a vein, 0 far from it."""

def wood(
    size: _Number = 0.02,
    waviness: _Number = 0.6,
    fibres: _Number = 0.35,
    seed: Union[int, str] = 0,
    *,
    from_: Optional[_Number] = None,
    to: Optional[_Number] = None,
    height: Optional[_Number] = None,
    colours: Sequence[_Colour] = (),
    at: Optional[_Vector] = None,
    rotate: Optional[_Vector] = None,
    scale: Optional[_Number] = None,
) -> Node:
    """A trunk along y: rings, 1 where they are dark, and fibres."""

def brick(
    length: _Number = 0.25,
    course: _Number = 0.075,
    mortar: _Number = 0.012,
    shift: _Number = 0.5,
    variation: _Number = 0.4,
    seed: Union[int, str] = 0,
    *,
    from_: Optional[_Number] = None,
    to: Optional[_Number] = None,
    height: Optional[_Number] = None,
    colours: Sequence[_Colour] = (),
    at: Optional[_Vector] = None,
    rotate: Optional[_Vector] = None,
    scale: Optional[_Number] = None,
) -> Node:
    """Bricks in mortar: 0 is mortar, bricks are up to 1."""

def checker(
    size: _Number = 0.2,
    *,
    from_: Optional[_Number] = None,
    to: Optional[_Number] = None,
    height: Optional[_Number] = None,
    colours: Sequence[_Colour] = (),
    at: Optional[_Vector] = None,
    rotate: Optional[_Vector] = None,
    scale: Optional[_Number] = None,
) -> Node:
    """Cubes of 0 and 1 by turns."""

def voronoi(
    size: _Number = 0.2,
    jitter: _Number = 1,
    seed: Union[int, str] = 0,
    *,
    from_: Optional[_Number] = None,
    to: Optional[_Number] = None,
    height: Optional[_Number] = None,
    colours: Sequence[_Colour] = (),
    at: Optional[_Vector] = None,
    rotate: Optional[_Vector] = None,
    scale: Optional[_Number] = None,
) -> Node:
    """Cells: the distance to the nearest of scattered points, 0 at each."""

def cells(
    size: _Number = 0.2,
    jitter: _Number = 1,
    seed: Union[int, str] = 0,
    *,
    from_: Optional[_Number] = None,
    to: Optional[_Number] = None,
    height: Optional[_Number] = None,
    colours: Sequence[_Colour] = (),
    at: Optional[_Vector] = None,
    rotate: Optional[_Vector] = None,
    scale: Optional[_Number] = None,
) -> Node:
    """Cells around scattered points, each of one random value."""

def cracks(
    size: _Number = 0.2,
    width: _Number = 0.02,
    jitter: _Number = 1,
    seed: Union[int, str] = 0,
    *,
    from_: Optional[_Number] = None,
    to: Optional[_Number] = None,
    height: Optional[_Number] = None,
    colours: Sequence[_Colour] = (),
    at: Optional[_Vector] = None,
    rotate: Optional[_Vector] = None,
    scale: Optional[_Number] = None,
) -> Node:
    """Borders between cells: 0 in a crack, 1 on the cells."""

def picture(
    file: str,
    *,
    size: _Number = 1,
    uv: Optional[bool] = None,
    from_: Optional[_Number] = None,
    to: Optional[_Number] = None,
    height: Optional[_Number] = None,
    colours: Sequence[_Colour] = (),
    at: Optional[_Vector] = None,
    rotate: Optional[_Vector] = None,
    scale: Optional[_Number] = None,
) -> Node:
    """A PNG or JPEG file as a texture."""

def orbit_trap(
    trap: Literal["point", "line", "plane", "sphere", "farthest", "iterations"] = "point",
    *,
    x: _Number = 0,
    y: _Number = 0,
    z: _Number = 0,
    from_: _Number = 0,
    to: _Number = 1,
    colours: Sequence[_Colour] = (),
) -> Node:
    """Colours of a fractal by its orbits, for a material."""

def camera(
    *,
    position: _Vector,
    target: _Vector,
    up: _Vector = (0, 1, 0),
    fov: _Number = 40,
    lens_radius: _Number = 0,
    lens_focus: Optional[_Number] = None,
    exposure: _Number = 0,
    name: Optional[str] = None,
) -> Node:
    """Camera; the first one of a scene is the default."""

def render(
    *,
    size: Sequence[Union[int, str]] = (1280, 720),
    samples: Union[int, str] = 256,
    bounces: Union[int, str] = 4,
    tonemap: Literal["agx", "neutral", "srgb"] = "agx",
    sampler: Literal["sobol", "independent"] = "sobol",
    caustics: Literal["sampled", "traced", "fast"] = "sampled",
    estimator: Literal["mis", "light", "bsdf"] = "mis",
    clamp: Optional[_Number] = None,
    detail: _Number = 0.1,
    fps: _Number = 24,
    shutter: _Number = 0,
) -> Node:
    """Size and quality of the picture."""

def fog(
    *,
    scatter: _Colour = (0, 0, 0),
    absorb: _Colour = (0, 0, 0),
    anisotropy: _Number = 0,
    glow: _Colour = (0, 0, 0),
) -> Node:
    """Medium between the objects, which scatters, absorbs and emits light."""

def sun(
    *,
    direction: _Vector,
    irradiance: _Colour,
    angle: _Number = 0.53,
    penumbra: Optional[_Number] = None,
) -> Node:
    """Light from far away."""

def point(
    *,
    at: _Vector,
    intensity: Optional[_Colour] = None,
    candela: Optional[_Number] = None,
    lumen: Optional[_Number] = None,
    colour: _Colour = (1, 1, 1),
    penumbra: Optional[_Number] = None,
) -> Node:
    """Light from a point, the same in every direction."""

def spot(
    *,
    at: _Vector,
    target: _Vector,
    intensity: Optional[_Colour] = None,
    cone: _Number = 45,
    blend: _Number = 0.15,
    candela: Optional[_Number] = None,
    lumen: Optional[_Number] = None,
    colour: _Colour = (1, 1, 1),
    penumbra: Optional[_Number] = None,
) -> Node:
    """Light from a point, in a cone."""

def sky(
    radiance: _Colour,
) -> Node:
    """Sky of the same radiance in every direction."""

def sky_gradient(
    *,
    zenith: _Colour,
    horizon: _Colour,
    ground: Optional[_Colour] = None,
) -> Node:
    """Sky with a gradient."""

def sky_day(
    *,
    elevation: _Number = 40,
    azimuth: _Number = 135,
    haze: _Number = 1,
    strength: _Number = 1,
    sun: bool = True,
    ground: _Colour = (0.2, 0.2, 0.2),
) -> Node:
    """Computed sky of a clear day, with its sun."""

def sky_picture(
    file: str,
    *,
    strength: _Number = 1,
    rotate: _Number = 0,
) -> Node:
    """Sky of a .hdr or .exr file: radiance in every direction."""

def object(
    name: str,
    *children: Union[Node, Sequence[Node]],
    material: Optional[_Material] = None,
) -> Node:
    """Object: its shapes and their material."""

def include(
    file: str,
) -> Node:
    """File from which a scene takes materials, shapes, objects and lights."""

def unit(
    unit: str,
) -> Node:
    """Unit of lengths for reports and exports."""

def param(
    name: str,
    value: _Number,
    *,
    min: Optional[_Number] = None,
    max: Optional[_Number] = None,
    doc: Optional[str] = None,
) -> Node:
    """Number with a name, which formulas use."""

def shape(
    name: str,
    *children: Union[Node, Sequence[Node]],
) -> Node:
    """Shape made of others: nodes of param() for its parameters, then solids. use() places it."""

def field(
    name: str,
    *children: Union[Node, Sequence[Node]],
    bounds: Union[_Number, _Vector],
    lipschitz: _Number = 1,
    wgsl: Optional[str] = None,
    glsl: Optional[str] = None,
    entry: Optional[str] = None,
    doc: Optional[str] = None,
) -> Node:
    """Distance function in WGSL or GLSL, which is then a shape: nodes of param() for its parameters. use() places it."""

def use(
    name: str,
    arguments: Union[_Number, _Vector] = (),
    *,
    values: Optional[Mapping[str, _Number]] = None,
    material: Optional[_Material] = None,
    at: Optional[_Vector] = None,
    rotate: Optional[_Vector] = None,
    scale: Optional[_Number] = None,
) -> Node:
    """A shape that the scene declares by shape() or field()."""
