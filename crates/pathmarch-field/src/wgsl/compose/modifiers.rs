//! Modifiers as WGSL: for each one the distance and the surface of what it holds, and those of itself.

use super::Composer;
use super::parameters::{arguments, component, local, rows};
use crate::graph::{Modified, Tree, Turn};
use std::collections::BTreeSet;

impl Composer<'_> {
    /// Collects the functions of the modifiers of a tree: `modified_N_distance` and `modified_N_surface`, and those of what
    /// each holds.
    pub(super) fn modifiers(&self, tree: &Tree, functions: &mut BTreeSet<(u32, String)>) {
        match tree {
            Tree::Leaf(_) => {}
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
        let start = self.modifier_starts[*index as usize];
        let (point, first) = local(pose, start, "world");
        let numbers = arguments(first, modified.coefficients.len());
        let mut counter = 0;
        let mut distance = format!(
            "/// Signed distance to what modifier {index}, `{name}`, holds.\nfn inside_{index}_distance(p: vec3f) -> f32 {{\n"
        );
        let value = self.tree_distance(inside, &mut distance, &mut counter);
        distance += &format!("    return {value};\n}}\n");
        let mut counter = 0;
        let mut surface = format!(
            "/// The surface of what modifier {index}, `{name}`, holds.\nfn inside_{index}_surface(p: vec3f, seed: u32) -> Surface {{\n"
        );
        let (gradient, leaf) = self.tree_surface(inside, &mut surface, &mut counter);
        surface += &format!("    return Surface({gradient}.xyz, {gradient}.w, {leaf});\n}}\n");
        let scale = match pose.turn {
            Turn::None => String::new(),
            _ => format!(" * {}", component(start, 3)),
        };
        let (looked, found) = match copies {
            1 => (String::new(), format!("inside_{index}_distance({name}_point(p, 0.0{numbers}))")),
            _ => (self.nearest(modified, &numbers, "nearest = min(nearest, distance);"), "nearest".to_owned()),
        };
        let estimated_distance = format!(
            "/// Signed distance to modifier {index}, `{name}`.\nfn modified_{index}_distance(world: vec3f) -> f32 {{\n    let p = \
             {point};\n{looked}    return {name}_distance(p, {found}{numbers}){scale};\n}}\n"
        );
        let looked = self.chosen(modified, &numbers);
        let back = match pose.turn {
            Turn::None => "local".to_owned(),
            Turn::Scaled => format!("vec4f(local.xyz, local.w * {})", component(start, 3)),
            Turn::Turned => format!("vec4f({} * local.xyz, local.w) * {}", rows(start + 1), component(start, 3)),
        };
        let whole_surface = format!(
            "/// The surface of modifier {index}, `{name}`.\nfn modified_{index}_surface(world: vec3f, seed: u32) -> Surface {{\n    \
             let p = {point};\n{looked}    let inside = inside_{index}_surface({name}_point(p, chosen{numbers}), seed);\n    \
             let pulled = {name}_pull(p, chosen, inside.gradient{numbers});\n    \
             let local = {name}_gradient(p, vec4f(pulled, inside.distance){numbers});\n    let result = {back};\n    \
             return Surface(result.xyz, result.w, inside.leaf);\n}}\n"
        );
        [distance, surface, estimated_distance, whole_surface].join("\n")
    }

    /// WGSL that does something with the `distance` of each place of what a modifier holds and with the `nearest` so far.
    fn nearest(&self, modified: &Modified, numbers: &str, then: &str) -> String {
        let Modified { modifier, index, copies, .. } = modified;
        format!(
            "    var nearest = 1e30;\n    for (var place = 0u; place < {copies}u; place++) {{\n        let distance = \
             inside_{index}_distance({}_point(p, f32(place){numbers}));\n        {then}\n    }}\n",
            modifier.wgsl_name()
        )
    }

    /// WGSL of `chosen`, the place where what a modifier holds is nearest to the point `p` of its space.
    pub(super) fn chosen(&self, modified: &Modified, numbers: &str) -> String {
        let then =
            "chosen = select(chosen, f32(place), distance < nearest);\n        nearest = min(nearest, distance);";
        match modified.copies {
            1 => "    let chosen = 0.0;\n".to_owned(),
            _ => "    var chosen = 0.0;\n".to_owned() + &self.nearest(modified, numbers, then),
        }
    }
}
