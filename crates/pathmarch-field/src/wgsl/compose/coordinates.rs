//! The WGSL of [`Field::coordinates`], as far as modifiers go, and of [`Field::orbit`].

use super::parameters::{arguments, component, local, rows};
use super::{Composed, Composer, Program};
use crate::graph::{Field, Modified, Tree, Turn};
use crate::shapes::TRAPS;
use std::collections::BTreeSet;
use std::fmt::Write;

const COORDINATES: &str = "\
/// A point in coordinates of its own, and the gradient of each of these over the world.
struct Coordinates {
    p: vec3f,
    x: vec3f,
    y: vec3f,
    z: vec3f,
}

/// The point `p` of these gradients over the coordinates of another.
fn coordinates_inside(outer: Coordinates, p: vec3f, x: vec3f, y: vec3f, z: vec3f) -> Coordinates {
    let back = mat3x3f(outer.x, outer.y, outer.z);
    return Coordinates(p, back * x, back * y, back * z);
}
";

impl Program {
    /// WGSL text, to stand behind [`code`](Self::code), of the struct `Coordinates` (`p`, and the gradients `x`, `y`, `z` of its
    /// coordinates over the world), of `coordinates_inside(outer: Coordinates, p, x, y, z)`, which applies the chain rule, and
    /// of `modifier_coordinates(holder: u32, p: vec3f) -> Coordinates`: where a point of the world is in the space of the
    /// modifier of this number, which is [`Field::holder`].
    pub fn coordinates(field: &Field) -> String {
        let Composed { composer, .. } = Composed::new(field);
        let (mut functions, mut cases) = (String::new(), String::new());
        for tree in field.single_objects() {
            composer.coordinates(tree, "world", &mut functions, &mut cases);
        }
        format!(
            "{COORDINATES}\n{functions}/// Where `p` is in the space of what the modifier of this number holds; 0 is the \
             world.\nfn modifier_coordinates(holder: u32, p: vec3f) -> Coordinates {{\n    let world = Coordinates(p, vec3f(1.0, \
             0.0, 0.0), vec3f(0.0, 1.0, 0.0), vec3f(0.0, 0.0, 1.0));\n{cases}    return world;\n}}\n\n"
        )
    }

    /// WGSL text, to stand behind [`code`](Self::code), of `has_orbit(leaf: u32) -> bool` and `orbit(leaf: u32, p: vec3f) ->
    /// array<f32, 5>`: [`Field::orbit`] of a point in the leaf's coordinates.
    pub fn orbits(field: &Field) -> String {
        let Composed { composer, .. } = Composed::new(field);
        let mut functions = BTreeSet::new();
        let (mut has, mut cases) = (String::new(), String::new());
        for (index, leaf) in field.leaves().iter().enumerate().filter(|(_, leaf)| leaf.shape.has_orbit()) {
            functions.insert(leaf.shape.wgsl_orbit());
            let (_, next) = local(&leaf.pose, composer.starts[index], "p");
            let values = arguments(next, leaf.params.len());
            let name = leaf.shape.wgsl_name();
            write!(has, " || leaf == {index}u").expect("writing to a string");
            writeln!(cases, "    if leaf == {index}u {{\n        return {name}_orbit(p{values});\n    }}")
                .expect("writing to a string");
        }
        let functions: String = functions.iter().map(|function| format!("{function}\n")).collect();
        format!(
            "{functions}/// Whether the leaf is a fractal.\nfn has_orbit(leaf: u32) -> bool {{\n    return false{has};\n}}\n\n\
             /// What the orbit of a point comes near to.\nfn orbit(leaf: u32, p: vec3f) -> array<f32, {TRAPS}> {{\n{cases}    \
             return array<f32, {TRAPS}>();\n}}\n\n"
        )
    }
}

impl Composer<'_> {
    /// Adds the modifiers of a tree; `outer` says where a point is in the space that it stands in.
    fn coordinates(&self, tree: &Tree, outer: &str, functions: &mut String, cases: &mut String) {
        match tree {
            Tree::Leaf(_) => {}
            Tree::Operator { children, .. } => {
                children.iter().for_each(|child| self.coordinates(child, outer, functions, cases));
            }
            Tree::Modifier(modified) => {
                *functions += &self.coordinates_in(modified);
                let here = format!("inside_{}_coordinates({outer})", modified.index);
                writeln!(cases, "    if holder == {}u {{\n        return {here};\n    }}", modified.index + 1)
                    .expect("writing to a string");
                self.coordinates(&modified.inside, &here, functions, cases);
            }
        }
    }

    fn coordinates_in(&self, modified: &Modified) -> String {
        let Modified { modifier, index, pose, .. } = modified;
        let name = modifier.wgsl_name();
        let start = self.modifier_starts[*index as usize];
        let (point, first) = local(pose, start, "world");
        let numbers = arguments(first, modified.coefficients.len());
        let chosen = self.chosen(modified, &numbers);
        let gradient = |axis: &str| {
            let pulled = format!("{name}_pull(p, chosen, {axis}{numbers})");
            match pose.turn {
                Turn::None => pulled,
                Turn::Scaled => format!("{pulled} / {}", component(start, 3)),
                Turn::Turned => format!("{} * {pulled}", rows(start + 1)),
            }
        };
        let [x, y, z] = ["vec3f(1.0, 0.0, 0.0)", "vec3f(0.0, 1.0, 0.0)", "vec3f(0.0, 0.0, 1.0)"].map(gradient);
        format!(
            "/// Where a point is in the space of what modifier {index}, `{name}`, holds.\nfn inside_{index}_coordinates(outer: \
             Coordinates) -> Coordinates {{\n    let world = outer.p;\n    let p = {point};\n{chosen}    return \
             coordinates_inside(outer, {name}_point(p, chosen{numbers}), {x}, {y}, {z});\n}}\n\n"
        )
    }
}
