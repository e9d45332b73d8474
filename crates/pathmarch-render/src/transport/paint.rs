//! The colour of a fractal by its orbit ([`OrbitTrap`](pathmarch_scene::materials::OrbitTrap)): found once for each surface that a path meets.

use crate::frame::Prepared;
use glam::Vec3;
use pathmarch_field::number::Vec3 as FieldVec3;
use pathmarch_scene::materials::Material;

/// The colour that takes the place of the material's on this leaf at `p`, if any does.
pub(crate) fn painted(prepared: &Prepared, leaf: usize, p: Vec3) -> Option<Vec3> {
    let trap = prepared.traps.get(prepared.leaves[leaf].material as usize)?.as_ref()?;
    let orbit = prepared.field.orbit(leaf, FieldVec3::new(p.x, p.y, p.z))?;
    Some(Vec3::from(trap.colour(&orbit)))
}

/// Words of the table that the kernel reads, to stand at `start`: for each material where its trap is, or 0; then the traps.
pub(crate) fn words(materials: &[Material], start: usize) -> Vec<u32> {
    let mut words = vec![0; materials.len()];
    for (index, material) in materials.iter().enumerate() {
        let Some(trap) = &material.orbit_trap else { continue };
        words[index] = (start + words.len()) as u32;
        let [from, to] = trap.range.map(f32::to_bits);
        words.extend([trap.trap as u32, from, to, trap.colours.len() as u32 - 1]);
        words.extend(trap.colours.iter().flatten().map(|channel| channel.to_bits()));
    }
    words
}
