//! WGSL of surfaces: distance, gradient, and the leaf whose material shows.

use super::parameters::{component, inverse, rows, swizzled};
use super::{Composer, analytic, profile};
use crate::graph::{Tree, Turn};
use std::fmt::Write;

impl Composer<'_> {
    /// Prints [`Field::surface_at_hit`](crate::Field::surface_at_hit).
    pub(super) fn surface(&self) -> String {
        let mut text = String::from(
            "/// Surface at the hit `p` of a ray, of an analytic leaf or of the sphere-traced objects: signed distance, gradient,\n\
             /// and the leaf whose material shows.\n\
             fn surface(p: vec3f, hit_id: u32, triangle: u32, seed: u32) -> Surface {\n    var nearest = vec4f(0.0, 0.0, 0.0, 1e30);\n    var leaf = 0u;\n",
        );
        let mut counter = 0;
        let objects: Vec<&Tree> = self.field.sphere_traced_objects().collect();
        if !objects.is_empty() || self.field.separate_shape_grid().is_some() {
            text += &skipped_if("hit_id != SPHERE_TRACED");
        }
        for object in &objects {
            let (value, leaf) = self.tree_surface(object, &mut text, &mut counter);
            writeln!(
                text,
                "    if abs({value}.w) < abs(nearest.w) {{\n        nearest = {value};\n        leaf = {leaf};\n    }}"
            )
            .expect("writing to a string");
        }
        if self.field.separate_shape_grid().is_some() {
            let shape_grid = self.field.shape_grids().len() - 1;
            writeln!(
                text,
                "    let shape_grid{shape_grid} = shape_grid_{shape_grid}_surface(p, seed);\n    if abs(shape_grid{shape_grid}.distance) < abs(nearest.w) \
                 {{\n        nearest = vec4f(shape_grid{shape_grid}.gradient, shape_grid{shape_grid}.distance);\n        leaf = \
                 shape_grid{shape_grid}.leaf;\n    }}"
            )
            .expect("writing to a string");
        }
        if !objects.is_empty() || self.field.separate_shape_grid().is_some() {
            text += END_SKIPPED;
        }
        for index in self.field.analytic_objects().flat_map(analytic::leaves) {
            let mut inner = String::new();
            let (value, leaf) = self.leaf_surface(index, "hit_gradient", &mut inner, &mut counter);
            let sign = if self.field.leaves()[index as usize].subtracted { "-" } else { "" };
            text += &skipped_if(&format!("hit_id != {leaf}"));
            text += &inner;
            writeln!(text, "    nearest = {sign}{value};\n    leaf = {leaf};").expect("writing to a string");
            text += END_SKIPPED;
        }
        if !self.field.bvh().nodes.is_empty() {
            text += &skipped_if("hit_id < BVH || hit_id == SPHERE_TRACED");
            text += "    let record = hit_id - BVH;\n    nearest = record_gradient(record, p);\n    leaf = \
                     u32(field_vector(record + 3u).w);\n";
            text += END_SKIPPED;
        }
        if self.field.has_triangles() {
            text += &skipped_if("hit_id < MESH || hit_id >= 2u * MESH");
            text += "    let triangle_surface = mesh_surface(p, hit_id - MESH, triangle);\n    nearest = \
                     vec4f(triangle_surface.gradient, triangle_surface.distance);\n    leaf = triangle_surface.leaf;\n";
            text += END_SKIPPED;
        }
        text + "    return Surface(nearest.xyz, nearest.w, leaf, triangle);\n}\n"
    }

    /// Prints the statements of a leaf's surface by a gradient function of its shape to `text`; returns expressions as
    /// [`tree_surface`](Self::tree_surface).
    fn leaf_surface(&self, index: u32, function: &str, text: &mut String, counter: &mut u32) -> (String, String) {
        let leaf = &self.field.leaves()[index as usize];
        let (point, values) = self.arguments(index, "p");
        let call = format!("{}_{function}({point}{values})", leaf.shape.wgsl_name());
        let name = fresh("g", counter);
        let start = self.starts[index as usize];
        match leaf.pose.turn {
            Turn::None => writeln!(text, "    let {name} = {call};"),
            Turn::Scaled => {
                writeln!(text, "    let {name} = {call} * vec4f(1.0, 1.0, 1.0, {});", component(start, 3))
            }
            Turn::Turned => {
                let local = fresh("l", counter);
                let scale = component(start, 3);
                let surface = match self.constant_axes(&leaf.pose) {
                    Some(axes) => format!("vec4f({}, {local}.w * {scale})", swizzled(&local, inverse(axes))),
                    None => format!("vec4f({} * {local}.xyz, {local}.w) * {scale}", rows(start + 1)),
                };
                writeln!(text, "    let {local} = {call};\n    let {name} = {surface};")
            }
        }
        .expect("writing to a string");
        (name, format!("{index}u"))
    }

    /// Prints the statements of a tree's surface to `text`; returns the expressions of gradient and distance, and of the leaf.
    pub(super) fn tree_surface(&self, tree: &Tree, text: &mut String, counter: &mut u32) -> (String, String) {
        match tree {
            Tree::Leaf(index) => self.leaf_surface(*index, "gradient", text, counter),
            Tree::Modifier(modified) => {
                let (name, surface) = (fresh("g", counter), fresh("s", counter));
                writeln!(
                    text,
                    "    let {surface} = modified_{}_surface(p, seed);\n    let {name} = vec4f({surface}.gradient, {surface}.distance);",
                    modified.index
                )
                .expect("writing to a string");
                (name, format!("{surface}.leaf"))
            }
            Tree::Operator { shape_grid: Some(index), .. } => {
                let (name, surface) = (fresh("g", counter), fresh("s", counter));
                writeln!(
                    text,
                    "    let {surface} = shape_grid_{index}_surface(p, seed);\n    let {name} = vec4f({surface}.gradient, \
                     {surface}.distance);"
                )
                .expect("writing to a string");
                (name, format!("{surface}.leaf"))
            }
            Tree::Operator { operator, smooth, children, first_choice, .. } => {
                let (mut result, mut leaf) = self.tree_surface(&children[0], text, counter);
                let width = self.width(*first_choice, *smooth);
                let function = operator.wgsl_name(profile(*smooth));
                for (k, child) in children[1..].iter().enumerate() {
                    let (other, other_leaf) = self.tree_surface(child, text, counter);
                    let name = format!("g{counter}");
                    let chosen = format!("leaf{counter}");
                    *counter += 1;
                    let threshold = match smooth {
                        Some(_) => format!("choice(seed, {}u)", first_choice + k as u32),
                        None => "0.5".to_owned(),
                    };
                    writeln!(
                        text,
                        "    let {name} = {function}_gradient({result}, {other}{width});\n    let {chosen} = select({leaf}, \
                         {other_leaf}, {threshold} < {function}_weight({result}.w, {other}.w{width}));"
                    )
                    .expect("writing to a string");
                    (result, leaf) = (name, chosen);
                }
                (result, leaf)
            }
        }
    }
}

/// Name that no other statement of the function has.
fn fresh(prefix: &str, counter: &mut u32) -> String {
    *counter += 1;
    format!("{prefix}{}", *counter - 1)
}

/// Opening of a block that all invocations skip if none needs it, as a loop with one pass: software Vulkan runs both sides of
/// an `if`.
fn skipped_if(not: &str) -> String {
    format!("    loop {{\n        if {not} {{\n            break;\n        }}\n")
}

/// End of the block of [`skipped_if`].
const END_SKIPPED: &str = "        break;\n    }\n";
