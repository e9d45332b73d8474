//! Names of nodes and properties that are not settings of a table.

use crate::settings;
use pathmarch_field::registry;

/// Node that includes a file.
pub(crate) const INCLUDE: &str = "include";
/// Node that declares a parameter.
pub(crate) const PARAM: &str = "param";
/// Node that declares a custom SDF in WGSL.
pub(crate) const FIELD: &str = "field";
/// Node that declares a shape made of others.
pub(crate) const SHAPE: &str = "shape";
/// Node of the medium between the objects.
pub(crate) const FOG: &str = "fog";
/// Node of the unit of length.
pub(crate) const UNIT: &str = "unit";
/// Property that names a material.
pub(crate) const MATERIAL: &str = "material";
/// Nodes at the top of a file.
pub(crate) const TOP: &[&str] = &[
    "pathmarch",
    INCLUDE,
    UNIT,
    PARAM,
    "camera",
    "render",
    "sky",
    FOG,
    "sun",
    "point",
    "spot",
    "material",
    FIELD,
    SHAPE,
    "object",
];

/// Nodes in every shape and operator.
pub(crate) const PLACEMENT: &[&str] =
    &[settings::PLACEMENT[0].name, settings::PLACEMENT[1].name, settings::PLACEMENT[2].name];
/// Node in shapes that may face a direction.
pub(crate) const NORMAL: &str = settings::NORMAL.name;
/// Node in polygons and curves.
pub(crate) const POINT: &str = "point";
/// Property of a curve's point.
pub(crate) const CORNER: &str = "corner";
/// Shape of a mesh file.
pub(crate) const MESH: &str = "mesh";
/// Property of texts that names a font.
pub(crate) const FONT: &str = "font";
/// Names of the axes, in the order of the values of [`Unit::Axis`](pathmarch_field::Unit::Axis).
pub(crate) const AXES: [&str; 3] = ["x", "y", "z"];

/// Node of a material that perturbs its normals.
pub(crate) const BUMP: &str = "bump";
/// Node of a material that projects a picture onto it.
pub(crate) const DECAL: &str = "decal";
/// Node of a colour ramp.
pub(crate) const COLOUR: &str = "colour";
/// Property of a ramp's colour: its value.
pub(crate) const COLOUR_POSITION: &str = "at";
/// Node of a material that colours fractals by their orbits.
pub(crate) const ORBIT_TRAP: &str = "orbit-trap";
/// Properties of an orbit trap and their defaults: its centre, and its values at the first and the last colour.
pub(crate) const TRAP_NUMBERS: [(&str, f32); 5] = [("x", 0.0), ("y", 0.0), ("z", 0.0), ("from", 0.0), ("to", 1.0)];

/// Names of all shapes and operators: those of the registry, and meshes.
pub(crate) fn solids<'a>() -> impl Iterator<Item = &'a str> {
    registry::solids().map(|solid| &*solid.info().name).chain([MESH])
}
