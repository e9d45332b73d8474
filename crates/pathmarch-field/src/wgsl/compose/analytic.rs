//! WGSL of analytic hits; `graph/analytic.rs` explains them.

use super::Composer;
use super::parameters::{component, rows, swizzled};
use crate::graph::{Tree, Turn};
use crate::operators::Boolean;
use std::collections::BTreeSet;
use std::fmt::Write;

impl Composer<'_> {
    /// Collects the ray functions of an analytic object.
    pub(super) fn rays(&self, object: &Tree, functions: &mut BTreeSet<(u32, String)>) {
        for leaf in leaves(object) {
            let shape = &self.field.leaves()[leaf as usize].shape;
            let is_single = self.field.direct(object).is_some();
            functions.insert((0, if is_single { shape.wgsl_ray() } else { shape.wgsl_interval() }));
            functions.insert((0, shape.wgsl_hit_gradient()));
        }
    }

    /// Prints [`Field::analytic_hit`](crate::Field::analytic_hit).
    pub(super) fn analytic_hit(&self) -> String {
        let mut text = String::from(
            "/// First hit of a ray with the analytic objects.\n\
             fn analytic_hit(origin: vec3f, direction: vec3f) -> AnalyticHit {\n    var nearest = 1e30;\n    var hit_id = SPHERE_TRACED;\n    \
             var t: f32;\n",
        );
        for object in self.field.analytic_objects() {
            match self.field.direct(object) {
                Some(leaf) => {
                    let ray = self.along_ray(leaf, "ray");
                    writeln!(
                        text,
                        "    t = {ray};\n    hit_id = select(hit_id, {leaf}u, t < nearest);\n    nearest = min(nearest, t);"
                    )
                    .expect("writing to a string");
                }
                None => self.combined_hit(object, &mut text),
            }
        }
        let mut hit = "AnalyticHit(nearest, hit_id, NO_TRIANGLE)".to_owned();
        for (is_used, function) in
            [(!self.field.bvh().nodes.is_empty(), "bvh_hit"), (self.field.has_triangles(), "mesh_hit")]
        {
            hit = if is_used { format!("{function}(origin, direction, {hit})") } else { hit };
        }
        text + &format!("    return {hit};\n}}\n")
    }

    /// Prints the first hit with a combination, if it is nearer.
    fn combined_hit(&self, object: &Tree, text: &mut String) {
        let leaves = leaves(object);
        for leaf in &leaves {
            writeln!(text, "    let s{leaf} = {};", self.along_ray(*leaf, "interval")).expect("writing to a string");
        }
        for (leaf, end) in leaves.iter().flat_map(|leaf| ["x", "y"].map(|end| (leaf, end))) {
            let t = format!("s{leaf}.{end}");
            let [before, behind] = [false, true].map(|behind| contains(object, &t, behind));
            writeln!(
                text,
                "    t = select(1e30, {t}, (0.0 < {t}) & (s{leaf}.x < s{leaf}.y) & ({before} != {behind}));\n    hit_id = select(hit_id, {leaf}u, t < nearest);\n    \
                 nearest = min(nearest, t);"
            )
            .expect("writing to a string");
        }
    }

    /// Call of a ray function of a leaf's shape, in world metres.
    fn along_ray(&self, leaf: u32, function: &str) -> String {
        let (point, values) = self.arguments(leaf, "origin");
        let start = self.starts[leaf as usize];
        let leaf = &self.field.leaves()[leaf as usize];
        let (direction, factor) = match leaf.pose.turn {
            Turn::None => ("direction".to_owned(), String::new()),
            Turn::Scaled => ("direction".to_owned(), format!(" * {}", component(start, 3))),
            Turn::Turned => {
                let scale = component(start, 3);
                let direction = match self.constant_axes(&leaf.pose) {
                    Some(axes) => swizzled("direction", axes),
                    // The stored rows are divided by the scale.
                    None => format!("direction * {} * {scale}", rows(start + 1)),
                };
                (direction, format!(" * {scale}"))
            }
        };
        format!("{}_{function}({point}, {direction}{values}){factor}", leaf.shape.wgsl_name())
    }
}

/// Leaves of a combination.
pub(super) fn leaves(tree: &Tree) -> Vec<u32> {
    match tree {
        Tree::Leaf(index) => vec![*index],
        Tree::Operator { children, .. } => children.iter().flat_map(leaves).collect(),
        Tree::Modifier(_) => vec![],
    }
}

/// Expression, in brackets, for whether an object contains the points just before or just behind `t`.
fn contains(tree: &Tree, t: &str, behind: bool) -> String {
    match tree {
        Tree::Leaf(index) if behind => format!("((s{index}.x <= {t}) & ({t} < s{index}.y))"),
        Tree::Leaf(index) => format!("((s{index}.x < {t}) & ({t} <= s{index}.y))"),
        Tree::Operator { operator, children, .. } => {
            let parts: Vec<String> = children.iter().map(|child| contains(child, t, behind)).collect();
            let sign = match operator.boolean() {
                Some(Boolean::Intersection) => " & ",
                Some(Boolean::Difference) => " & !",
                _ => " | ",
            };
            format!("({})", parts.join(sign))
        }
        Tree::Modifier(_) => "false".to_owned(),
    }
}
