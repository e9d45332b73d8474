//! WGSL of modifiers: distance and surface of each, and of its child.

use super::Composer;
use super::parameters::{arguments, component, local, rows};
use crate::graph::{Modified, Tree, Turn};
use std::collections::BTreeSet;

impl Composer<'_> {
    /// Collects the functions of the modifiers of a tree: `modified_N_distance` and `modified_N_surface`, and those of its child,
    /// `inside_N_distance` and `inside_N_surface`.
    pub(super) fn modifiers(&self, tree: &Tree, functions: &mut BTreeSet<(u32, String)>) {
        match tree {
            Tree::Leaf(_) => {}
            Tree::Operator { shape_grid: Some(index), .. } => {
                let code = &self.field.shape_grids()[*index as usize].code;
                code.iter().for_each(|tree| self.modifiers(tree, functions));
            }
            Tree::Operator { children, .. } => children.iter().for_each(|child| self.modifiers(child, functions)),
            Tree::Modifier(modified) => {
                self.modifiers(&modified.inside, functions);
                functions.insert((2, self.modified(modified)));
            }
        }
    }

    fn modified(&self, modified: &Modified) -> String {
        let Modified { modifier, index, copies, pose, inside, .. } = modified;
        let name = modifier.wgsl_name();
        let start = self.modifier_starts[index];
        let (point, first) = local(pose, start, "world");
        let numbers = arguments(first, modified.coefficients.len());
        let mut counter = 0;
        let mut distance = format!(
            "/// Signed distance to the child of modifier {index}, `{name}`.\nfn inside_{index}_distance({}) -> f32 {{\n",
            modified.with_estimate("p: vec3f, estimate: bool", "p: vec3f")
        );
        let value = self.tree_distance(inside, &mut distance, &mut counter, "estimate");
        distance += &format!("    return {value};\n}}\n");
        let mut counter = 0;
        let mut surface = format!(
            "/// Surface of the child of modifier {index}, `{name}`.\nfn inside_{index}_surface(p: vec3f, seed: u32) -> Surface {{\n"
        );
        let (gradient, leaf) = self.tree_surface(inside, &mut surface, &mut counter);
        surface += &format!("    return Surface({gradient}.xyz, {gradient}.w, {leaf}, NO_TRIANGLE);\n}}\n");
        let scale = match pose.turn {
            Turn::None => String::new(),
            _ => format!(" * {}", component(start, 3)),
        };
        let (looked, found) = match copies {
            1 => {
                let estimate = modified.with_estimate(", estimate", "");
                (String::new(), format!("inside_{index}_distance({name}_point(p, 0.0{numbers}){estimate})"))
            }
            _ => {
                let then = "nearest = min(nearest, distance);";
                (self.nearest(modified, &numbers, "estimate", then), "nearest".to_owned())
            }
        };
        let estimated_distance = format!(
            "/// Signed distance to modifier {index}, `{name}`.\nfn modified_{index}_distance({}) -> f32 {{\n    let p = \
             {point};\n{looked}    return {name}_distance(p, {found}{numbers}){scale};\n}}\n",
            modified.with_estimate("world: vec3f, estimate: bool", "world: vec3f")
        );
        let looked = self.nearest_copy(modified, &numbers);
        let back = match pose.turn {
            Turn::None => "local".to_owned(),
            Turn::Scaled => format!("vec4f(local.xyz, local.w * {})", component(start, 3)),
            Turn::Turned => format!("vec4f({} * local.xyz, local.w) * {}", rows(start + 1), component(start, 3)),
        };
        let surface_of_modifier = format!(
            "/// Surface of modifier {index}, `{name}`.\nfn modified_{index}_surface(world: vec3f, seed: u32) -> Surface {{\n    \
             let p = {point};\n{looked}    let inside = inside_{index}_surface({name}_point(p, copy{numbers}), seed);\n    \
             let pulled = {name}_pull(p, copy, inside.gradient{numbers});\n    \
             let local = {name}_gradient(p, vec4f(pulled, inside.distance){numbers});\n    let result = {back};\n    \
             return Surface(result.xyz, result.w, inside.leaf, NO_TRIANGLE);\n}}\n"
        );
        [distance, surface, estimated_distance, surface_of_modifier].join("\n")
    }

    /// Prints a loop over the domain copies of a modifier, with the statement `then` over `distance` of each and `nearest` so far.
    fn nearest(&self, modified: &Modified, numbers: &str, is_estimate: &str, then: &str) -> String {
        let Modified { modifier, index, copies, .. } = modified;
        format!(
            "    var nearest = 1e30;\n    for (var k = 0u; k < {copies}u; k++) {{\n        let distance = \
             inside_{index}_distance({}_point(p, f32(k){numbers}){});\n        {then}\n    }}\n",
            modifier.wgsl_name(),
            modified.with_estimate(&format!(", {is_estimate}"), "")
        )
    }

    /// Prints `copy`, the index of the domain copy that is nearest to the point `p`.
    pub(super) fn nearest_copy(&self, modified: &Modified, numbers: &str) -> String {
        let then = "copy = select(copy, f32(k), distance < nearest);\n        nearest = min(nearest, distance);";
        match modified.copies {
            1 => "    let copy = 0.0;\n".to_owned(),
            _ => "    var copy = 0.0;\n".to_owned() + &self.nearest(modified, numbers, "true", then),
        }
    }
}

impl Modified {
    /// Chooses between two texts: the first if a shape grid is inside, so that its functions take whether to estimate distances.
    pub(super) fn with_estimate<'t>(&self, yes: &'t str, no: &'t str) -> &'t str {
        if has_shape_grid(&self.inside) { yes } else { no }
    }
}

/// Reports whether a tree reads a shape grid.
fn has_shape_grid(tree: &Tree) -> bool {
    match tree {
        Tree::Leaf(_) => false,
        Tree::Operator { shape_grid: Some(_), .. } => true,
        Tree::Operator { children, .. } => children.iter().any(has_shape_grid),
        Tree::Modifier(modified) => has_shape_grid(&modified.inside),
    }
}
