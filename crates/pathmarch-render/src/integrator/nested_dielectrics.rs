//! Refraction at surfaces: dispersion, and nested dielectrics, see [`scene::nested_dielectrics`](crate::scene::nested_dielectrics).

use super::path_state::disperse;
use crate::scene::material::DISPERSES;
use crate::scene::{Medium, TraceContext};
use glam::Vec3;
use pathmarch_scene::materials::{BsdfParameters, dispersion};

/// Parameters of the BSDF of a leaf with the index at the wavelength of a path and relative to the medium around it; `None` if
/// they are those of its material. If the index depends on the wavelength, the path has one from here on, see [`disperse`].
pub(super) fn refracting_parameters(
    ctx: &TraceContext,
    medium: &Medium,
    leaf: usize,
    parameters: &BsdfParameters,
    (wavelength, carried): (&mut Option<f32>, &mut Vec3),
    random: impl FnOnce() -> f32,
) -> Option<BsdfParameters> {
    if !ctx.config.nested_dielectrics {
        let material = ctx.scene.leaves[leaf].material as usize;
        let at_wavelength = ctx.scene.bsdfs[material]?.at_wavelength;
        let at_wavelength = at_wavelength.filter(|_| ctx.scene.materials[material].has(DISPERSES))?;
        return Some(at_wavelength(parameters, dispersion::index_offset(disperse(wavelength, carried, random))));
    }
    let with_index = with_index(ctx, leaf)?;
    if ctx.scene.disperses_at(medium, leaf) {
        disperse(wavelength, carried, random);
    }
    let offset = wavelength.map_or(0.0, dispersion::index_offset);
    Some(with_index(parameters, ctx.scene.index_at_surface(medium, leaf, offset)))
}

/// Parameters of the BSDF of clear glass for a ray that passes it straight.
pub(super) fn straight_parameters(
    ctx: &TraceContext,
    medium: &Medium,
    leaf: usize,
    parameters: &BsdfParameters,
) -> BsdfParameters {
    let index = ctx.scene.index_at_surface(medium, leaf, 0.0);
    with_index(ctx, leaf).map_or(*parameters, |with_index| with_index(parameters, index.max(1.0 / index)))
}

/// Function that replaces the index of the BSDF of a leaf.
fn with_index(ctx: &TraceContext, leaf: usize) -> Option<fn(&BsdfParameters, f32) -> BsdfParameters> {
    let bsdf = ctx.scene.bsdfs[ctx.scene.leaves[leaf].material as usize]?;
    bsdf.with_index.filter(|_| ctx.scene.refracts(leaf))
}
