//! Layout of a field's parameters, and the WGSL that reads them.

use super::Composer;
use crate::blend::Blend;
use crate::graph::{Pose, Turn};

impl Composer<'_> {
    /// Packs a pose, as far as it was written, and the coefficients behind it.
    pub(super) fn pack(&mut self, pose: &Pose, coefficients: &[f32]) {
        if pose.moved || pose.turn != Turn::None {
            self.parameters.push([pose.at[0], pose.at[1], pose.at[2], pose.scale]);
        }
        if pose.turn == Turn::Turned {
            self.parameters.extend(pose.local_from_world().map(|[x, y, z]| [x, y, z, 0.0]));
        }
        for chunk in coefficients.chunks(4) {
            self.parameters.push(std::array::from_fn(|k| chunk.get(k).copied().unwrap_or(0.0)));
        }
    }

    /// Appends the tables of shapes behind all other parameters, whose indices do not depend on the length of tables.
    pub(super) fn append_tables(&mut self) {
        let leaves = self.field.leaves().iter().enumerate().filter(|(_, leaf)| leaf.shape.reads_table());
        for (index, leaf) in leaves {
            let (_, index_of_table) = local(&leaf.pose, self.starts[index], "p");
            self.parameters[index_of_table][0] = self.parameters.len() as f32;
            let vectors = leaf.params.chunks_exact(4).map(|v| [v[0], v[1], v[2], v[3]]);
            self.parameters.extend(vectors);
        }
    }

    /// Parameters of a blend as further arguments of a call.
    pub(super) fn width(&self, first_choice: u32, smooth: Option<Blend>) -> String {
        let Some(blend) = smooth else { return String::new() };
        let found = self.widths.iter().find(|(choice, _)| *choice == first_choice);
        found.map_or(String::new(), |(_, vector)| arguments(*vector, if blend.profile.has_steps() { 2 } else { 1 }))
    }

    /// Signed axes of a pose that the kernel contains.
    pub(super) fn constant_axes(&self, pose: &Pose) -> Option<[(usize, f32); 3]> {
        (self.has_constant_numbers && pose.turn == Turn::Turned).then(|| pose.signed_axes()).flatten()
    }

    /// Point `p` in local coordinates of a leaf, and the call's arguments after it.
    pub(super) fn arguments(&self, index: u32, p: &str) -> (String, String) {
        let leaf = &self.field.leaves()[index as usize];
        let start = self.starts[index as usize];
        let (mut point, next) = local(&leaf.pose, start, p);
        if let Some(axes) = self.constant_axes(&leaf.pose) {
            let offset = if leaf.pose.moved { format!("({p} - field_vector({start}).xyz)") } else { p.to_owned() };
            point = format!("{} / {}", swizzled(&offset, axes), component(start, 3));
        }
        (point, arguments(next, if leaf.shape.reads_table() { 1 } else { leaf.params.len() }))
    }
}

/// Component `k` of a parameter vector.
pub(super) fn component(vector: usize, k: usize) -> String {
    format!("field_vector({vector}).{}", ["x", "y", "z", "w"][k])
}

/// Vector of the components of `v` along these axes.
pub(super) fn swizzled(v: &str, axes: [(usize, f32); 3]) -> String {
    let [x, y, z] =
        axes.map(|(axis, sign)| format!("{}{v}.{}", if sign < 0.0 { "-" } else { "" }, ["x", "y", "z"][axis]));
    format!("vec3f({x}, {y}, {z})")
}

/// Axes and signs back from the local axes to those of the world.
pub(super) fn inverse(axes: [(usize, f32); 3]) -> [(usize, f32); 3] {
    let mut result = [(0, 1.0); 3];
    for (local, (axis, sign)) in axes.into_iter().enumerate() {
        result[axis] = (local, sign);
    }
    result
}

/// Matrix whose columns are the rows stored from this vector on.
pub(super) fn rows(start: usize) -> String {
    let row = |k: usize| format!("field_vector({}).xyz", start + k);
    format!("mat3x3f({}, {}, {})", row(0), row(1), row(2))
}

/// Point `p` in the local coordinates whose pose is packed from `start` on, and the index behind that pose.
pub(super) fn local(pose: &Pose, start: usize, p: &str) -> (String, usize) {
    let mut next = start;
    let mut point = p.to_owned();
    if pose.moved || pose.turn != Turn::None {
        if pose.moved {
            point = format!("{p} - field_vector({next}).xyz");
        }
        next += 1;
    }
    match pose.turn {
        Turn::None => {}
        Turn::Scaled => point = format!("({point}) / field_vector({}).w", next - 1),
        Turn::Turned => {
            point = format!("({point}) * {}", rows(next));
            next += 3;
        }
    }
    (point, next)
}

/// Parameters from this vector on as further arguments of a call.
pub(super) fn arguments(start: usize, count: usize) -> String {
    (0..count).map(|k| format!(", {}", component(start + k / 4, k % 4))).collect()
}
