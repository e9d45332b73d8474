//! WGSL of distances: to sphere-traced objects, to all objects, and to chosen ones.

use super::parameters::component;
use super::{Composer, profile};
use crate::graph::{Tree, Turn};
use std::fmt::Write;

impl Composer<'_> {
    /// Prints [`Field::sphere_traced_distance`](crate::Field::sphere_traced_distance) under this name.
    pub(super) fn sphere_traced_distance(&self, name: &str) -> String {
        let objects: Vec<&Tree> = self.field.sphere_traced_objects().collect();
        let shape_grid = self.field.separate_shape_grid().map(|_| self.field.shape_grids().len() - 1);
        let doc = "Unsigned distance from `p` to the nearest surface of the sphere-traced objects, metres.";
        self.unsigned_distance(&format!("{name}(p: vec3f)"), doc, &objects, shape_grid, None)
    }

    /// Prints the distance to some objects under this signature. For one of the sets of
    /// [`Program::distances_to`](super::Program::distances_to), it leaves out `ignored_leaf`, and estimates distances to shape
    /// grids.
    pub(super) fn unsigned_distance(
        &self,
        signature: &str,
        doc: &str,
        objects: &[&Tree],
        shape_grid: Option<usize>,
        set: Option<usize>,
    ) -> String {
        let mut text = format!("/// {doc}\nfn {signature} -> f32 {{\n    var nearest = 1e30;\n");
        let mut counter = 0;
        let is_estimate = if set.is_some() { "true" } else { "false" };
        for object in objects {
            let value = self.tree_distance(object, &mut text, &mut counter, is_estimate);
            if set.is_none() && self.field.is_lit_by_field(object) {
                writeln!(text, "    if !is_camera_ray {{\n        nearest = min(nearest, abs({value}));\n    }}")
                    .expect("writing to a string");
                continue;
            }
            match self.field.convex_object(object).filter(|_| set.is_some()) {
                Some(leaf) => {
                    writeln!(
                        text,
                        "    nearest = select(min(nearest, abs({value})), nearest, ignored_leaf == {leaf}u);"
                    )
                }
                None => writeln!(text, "    nearest = min(nearest, abs({value}));"),
            }
            .expect("writing to a string");
        }
        if let Some(shape_grid) = shape_grid {
            writeln!(text, "    nearest = min(nearest, abs(shape_grid_{shape_grid}_distance(p, {})));", set.is_some())
                .expect("writing to a string");
        }
        if let Some(set) = set.filter(|_| !self.field.bvh().nodes.is_empty()) {
            writeln!(text, "    nearest = bvh_distance(p, nearest, {}u, ignored_leaf);", 1 << set)
                .expect("writing to a string");
        }
        text + "    return nearest;\n}\n"
    }

    /// Prints [`Field::estimated_distance`](crate::Field::estimated_distance).
    pub(super) fn estimated_distance(&self) -> String {
        let mut text = String::from(
            "/// Signed distance from `p` to the nearest surface, metres.\n\
             fn estimated_distance(p: vec3f) -> f32 {\n    var nearest = 1e30;\n",
        );
        let mut counter = 0;
        for object in self.field.single_objects() {
            let value = self.tree_distance(object, &mut text, &mut counter, "true");
            writeln!(text, "    nearest = min(nearest, {value});").expect("writing to a string");
        }
        if self.field.separate_shape_grid().is_some() {
            let shape_grid = self.field.shape_grids().len() - 1;
            writeln!(text, "    nearest = min(nearest, shape_grid_{shape_grid}_distance(p, true));")
                .expect("writing to a string");
        }
        text + "    return nearest;\n}\n"
    }

    /// Prints the statements of a tree's distance to `text`; returns the expression of its value. The expression `is_estimate` is
    /// true to estimate distances to shape grids.
    pub(super) fn tree_distance(&self, tree: &Tree, text: &mut String, counter: &mut u32, is_estimate: &str) -> String {
        match tree {
            Tree::Leaf(index) => {
                let leaf = &self.field.leaves()[*index as usize];
                let (point, values) = self.arguments(*index, "p");
                let call = format!("{}_distance({point}{values})", leaf.shape.wgsl_name());
                if leaf.pose.turn == Turn::None {
                    call
                } else {
                    format!("{call} * {}", component(self.starts[*index as usize], 3))
                }
            }
            Tree::Modifier(modified) => {
                let estimate = format!(", {is_estimate}");
                format!("modified_{}_distance(p{})", modified.index, modified.with_estimate(&estimate, ""))
            }
            Tree::Operator { shape_grid: Some(index), .. } => format!("shape_grid_{index}_distance(p, {is_estimate})"),
            Tree::Operator { operator, smooth, children, first_choice, .. } => {
                let mut result = self.tree_distance(&children[0], text, counter, is_estimate);
                let width = self.width(*first_choice, *smooth);
                for child in &children[1..] {
                    let other = self.tree_distance(child, text, counter, is_estimate);
                    let name = format!("d{counter}");
                    *counter += 1;
                    let function = operator.wgsl_name(profile(*smooth));
                    writeln!(text, "    let {name} = {function}_distance({result}, {other}{width});")
                        .expect("writing to a string");
                    result = name;
                }
                result
            }
        }
    }
}
