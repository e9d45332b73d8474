//! The WGSL of distances: to what is marched, to all, and to objects that count.

use super::parameters::component;
use super::{Composer, profile};
use crate::graph::{Tree, Turn};
use std::fmt::Write;

impl Composer<'_> {
    pub(super) fn distance(&self) -> String {
        let marched: Vec<&Tree> = self.field.sphere_traced_objects().collect();
        let shape_grids: Vec<usize> = (0..self.field.shape_grids().len()).collect();
        let doc = "Distance from `p` to the nearest surface that must be marched, from outside or inside, metres.";
        self.unsigned_distance("sphere_traced_distance(p: vec3f)", doc, &marched, &shape_grids, None)
    }

    /// A function of this signature; where it is of a set of objects that count, the leaf `own` of closed form does not,
    /// and distances to shape_grids are about what they are.
    pub(super) fn unsigned_distance(
        &self,
        signature: &str,
        doc: &str,
        objects: &[&Tree],
        shape_grids: &[usize],
        set: Option<usize>,
    ) -> String {
        let mut text = format!("/// {doc}\nfn {signature} -> f32 {{\n    var nearest = 1e30;\n");
        let mut counter = 0;
        for object in objects {
            let value = self.tree_distance(object, &mut text, &mut counter);
            match self.field.direct(object).filter(|_| set.is_some()) {
                Some(leaf) => {
                    writeln!(text, "    nearest = select(min(nearest, abs({value})), nearest, own == {leaf}u);")
                }
                None => writeln!(text, "    nearest = min(nearest, abs({value}));"),
            }
            .expect("writing to a string");
        }
        for shape_grid in shape_grids {
            writeln!(text, "    nearest = min(nearest, abs(shape_grid_{shape_grid}_distance(p, {})));", set.is_some())
                .expect("writing to a string");
        }
        if let Some(set) = set.filter(|_| !self.field.bvh().nodes.is_empty()) {
            writeln!(text, "    nearest = bvh_distance(p, nearest, {}u, own);", 1 << set).expect("writing to a string");
        }
        text + "    return nearest;\n}\n"
    }

    pub(super) fn estimated_distance(&self) -> String {
        let mut text = String::from(
            "/// Signed distance from `p` to the nearest surface, metres.\n\
             fn estimated_distance(p: vec3f) -> f32 {\n    var nearest = 1e30;\n",
        );
        let mut counter = 0;
        for object in self.field.single_objects() {
            let value = self.tree_distance(object, &mut text, &mut counter);
            writeln!(text, "    nearest = min(nearest, {value});").expect("writing to a string");
        }
        for shape_grid in 0..self.field.shape_grids().len() {
            writeln!(text, "    nearest = min(nearest, shape_grid_{shape_grid}_distance(p, true));")
                .expect("writing to a string");
        }
        text + "    return nearest;\n}\n"
    }

    pub(super) fn tree_distance(&self, tree: &Tree, text: &mut String, counter: &mut u32) -> String {
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
            Tree::Modifier(modified) => format!("modified_{}_distance(p)", modified.index),
            Tree::Operator { operator, smooth, children, first_choice } => {
                let mut result = self.tree_distance(&children[0], text, counter);
                let width = self.width(*first_choice, *smooth);
                for child in &children[1..] {
                    let other = self.tree_distance(child, text, counter);
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
