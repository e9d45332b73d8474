//! WGSL of [`Field::coordinates`] up to the innermost modifier, and of [`Field::orbit`].

use super::parameters::{arguments, component, local, rows};
use super::{Composed, Composer, Program};
use crate::graph::{Field, Modified, Tree, Turn};
use crate::shapes::TRAPS;
use std::collections::BTreeSet;
use std::fmt::Write;

const COORDINATES: &str = "\
/// Point in local coordinates, and the world-space gradient of each of them.
struct Coordinates {
    p: vec3f,
    x: vec3f,
    y: vec3f,
    z: vec3f,
}

/// Composes outer coordinates with a point `p` in inner ones, whose gradients are over the outer ones.
fn coordinates_inside(outer: Coordinates, p: vec3f, x: vec3f, y: vec3f, z: vec3f) -> Coordinates {
    let back = mat3x3f(outer.x, outer.y, outer.z);
    return Coordinates(p, back * x, back * y, back * z);
}
";

impl Program {
    /// WGSL text of local coordinates, to be appended to [`code`](Self::code): the struct `Coordinates` (`p`, and the world-space
    /// gradients `x`, `y`, `z` of its coordinates); `coordinates_inside(outer: Coordinates, p, x, y, z)`, which applies the
    /// chain rule; and `modifier_coordinates(modifier: u32, p: vec3f) -> Coordinates`, the coordinates of a world point in the
    /// space of this modifier's child, see [`Field::enclosing_modifier`].
    pub fn coordinates(field: &Field) -> String {
        let Composed { composer, .. } = Composed::new(field, false, false);
        let (mut functions, mut cases) = (String::new(), String::new());
        for tree in field.single_objects() {
            composer.coordinates(tree, "world", &mut functions, &mut cases);
        }
        format!(
            "{COORDINATES}\n{functions}/// Coordinates of `p` in the space of the child of modifier number `modifier`; 0 is the \
             world.\nfn modifier_coordinates(modifier: u32, p: vec3f) -> Coordinates {{\n    let world = Coordinates(p, vec3f(1.0, \
             0.0, 0.0), vec3f(0.0, 1.0, 0.0), vec3f(0.0, 0.0, 1.0));\n{cases}    return world;\n}}\n\n"
        )
    }

    /// WGSL text of `has_orbit(leaf: u32) -> bool` and `orbit(leaf: u32, p: vec3f, centre: vec3f) -> array<f32, 6>`, to be appended to
    /// [`code`](Self::code): [`Field::orbit`] of a point in local coordinates.
    pub fn orbits(field: &Field) -> String {
        let Composed { composer, .. } = Composed::new(field, false, false);
        let mut functions = BTreeSet::new();
        let (mut has, mut cases) = (String::new(), String::new());
        for (index, leaf) in field.leaves().iter().enumerate().filter(|(_, leaf)| leaf.shape.has_orbit()) {
            functions.insert(leaf.shape.wgsl_orbit());
            let (_, next) = local(&leaf.pose, composer.starts[index], "p");
            let values = arguments(next, leaf.params.len());
            let name = leaf.shape.wgsl_name();
            write!(has, " || leaf == {index}u").expect("writing to a string");
            writeln!(cases, "    if leaf == {index}u {{\n        return {name}_orbit(p, centre{values});\n    }}")
                .expect("writing to a string");
        }
        let functions: String = functions.iter().map(|function| format!("{function}\n")).collect();
        format!(
            "{functions}/// Reports whether the leaf is a fractal.\nfn has_orbit(leaf: u32) -> bool {{\n    return false{has};\n}}\n\n\
             /// Orbit traps of a point about a centre.\nfn orbit(leaf: u32, p: vec3f, centre: vec3f) -> array<f32, {TRAPS}> {{\n{cases}    \
             return array<f32, {TRAPS}>();\n}}\n\n"
        )
    }
}

impl Composer<'_> {
    /// Adds the modifiers of a tree; `outer` is the WGSL of the coordinates around it.
    fn coordinates(&self, tree: &Tree, outer: &str, functions: &mut String, cases: &mut String) {
        match tree {
            Tree::Leaf(_) => {}
            Tree::Operator { children, .. } => {
                children.iter().for_each(|child| self.coordinates(child, outer, functions, cases));
            }
            Tree::Modifier(modified) => {
                *functions += &self.coordinates_of(modified);
                let here = format!("inside_{}_coordinates({outer})", modified.index);
                writeln!(cases, "    if modifier == {}u {{\n        return {here};\n    }}", modified.index + 1)
                    .expect("writing to a string");
                self.coordinates(&modified.inside, &here, functions, cases);
            }
        }
    }

    fn coordinates_of(&self, modified: &Modified) -> String {
        let Modified { modifier, index, pose, .. } = modified;
        let name = modifier.wgsl_name();
        let start = self.modifier_starts[index];
        let (point, first) = local(pose, start, "world");
        let numbers = arguments(first, modified.coefficients.len());
        let copy = self.nearest_copy(modified, &numbers);
        let gradient = |axis: &str| {
            let pulled = format!("{name}_pull(p, copy, {axis}{numbers})");
            match pose.turn {
                Turn::None => pulled,
                Turn::Scaled => format!("{pulled} / {}", component(start, 3)),
                Turn::Turned => format!("{} * {pulled}", rows(start + 1)),
            }
        };
        let [x, y, z] = ["vec3f(1.0, 0.0, 0.0)", "vec3f(0.0, 1.0, 0.0)", "vec3f(0.0, 0.0, 1.0)"].map(gradient);
        format!(
            "/// Coordinates of a point in the space of the child of modifier {index}, `{name}`.\nfn inside_{index}_coordinates(outer: \
             Coordinates) -> Coordinates {{\n    let world = outer.p;\n    let p = {point};\n{copy}    return \
             coordinates_inside(outer, {name}_point(p, copy{numbers}), {x}, {y}, {z});\n}}\n\n"
        )
    }
}
