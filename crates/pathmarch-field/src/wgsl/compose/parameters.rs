//! Where the numbers of a field stand among its parameters, and the WGSL that reads them there.

use super::Composer;
use crate::blend::Blend;
use crate::graph::{Pose, Turn};

impl Composer<'_> {
    pub(super) fn place(&mut self, pose: &Pose, numbers: &[f32]) {
        if pose.moved || pose.turn != Turn::None {
            self.parameters.push([pose.at[0], pose.at[1], pose.at[2], pose.scale]);
        }
        if pose.turn == Turn::Turned {
            self.parameters.extend(pose.local_from_world().map(|[x, y, z]| [x, y, z, 0.0]));
        }
        for chunk in numbers.chunks(4) {
            self.parameters.push(std::array::from_fn(|k| chunk.get(k).copied().unwrap_or(0.0)));
        }
    }

    /// Puts the tables of shapes behind all other numbers, whose places do not depend on how long they are.
    pub(super) fn tables(&mut self) {
        let leaves = self.field.leaves().iter().enumerate().filter(|(_, leaf)| leaf.shape.reads_table());
        for (index, leaf) in leaves {
            let (_, place) = local(&leaf.pose, self.starts[index], "p");
            self.parameters[place][0] = self.parameters.len() as f32;
            let vectors = leaf.params.chunks_exact(4).map(|v| [v[0], v[1], v[2], v[3]]);
            self.parameters.extend(vectors);
        }
    }

    /// The numbers of a blend, as further arguments of a call.
    pub(super) fn width(&self, first_choice: u32, smooth: Option<Blend>) -> String {
        let Some(blend) = smooth else { return String::new() };
        let place = self.widths.iter().find(|(choice, _)| *choice == first_choice);
        place.map_or(String::new(), |(_, vector)| arguments(*vector, if blend.profile.has_steps() { 2 } else { 1 }))
    }

    /// The point `p` in local coordinates of a leaf, and the call's arguments after it.
    pub(super) fn arguments(&self, index: u32, p: &str) -> (String, String) {
        let leaf = &self.field.leaves()[index as usize];
        let (point, next) = local(&leaf.pose, self.starts[index as usize], p);
        (point, arguments(next, if leaf.shape.reads_table() { 1 } else { leaf.params.len() }))
    }
}

pub(super) fn component(vector: usize, k: usize) -> String {
    format!("field_parameters[{vector}].{}", ["x", "y", "z", "w"][k])
}

/// The matrix whose columns are the rows stored from this vector on.
pub(super) fn rows(start: usize) -> String {
    let row = |k: usize| format!("field_parameters[{}].xyz", start + k);
    format!("mat3x3f({}, {}, {})", row(0), row(1), row(2))
}

/// The point `p` in local coordinates whose numbers start here, and what stands behind those.
pub(super) fn local(pose: &Pose, start: usize, p: &str) -> (String, usize) {
    let mut next = start;
    let mut point = p.to_owned();
    if pose.moved || pose.turn != Turn::None {
        if pose.moved {
            point = format!("{p} - field_parameters[{next}].xyz");
        }
        next += 1;
    }
    match pose.turn {
        Turn::None => {}
        Turn::Scaled => point = format!("({point}) / field_parameters[{}].w", next - 1),
        Turn::Turned => {
            point = format!("({point}) * {}", rows(next));
            next += 3;
        }
    }
    (point, next)
}

/// Numbers from this vector on, as further arguments of a call.
pub(super) fn arguments(start: usize, count: usize) -> String {
    (0..count).map(|k| format!(", {}", component(start + k / 4, k % 4))).collect()
}
