//! Refraction between nested dielectrics, see [`scene::nested_dielectrics`](crate::scene::nested_dielectrics).

use crate::scene::{Medium, TraceContext};
use pathmarch_scene::materials::{BsdfParameters, dispersion};

/// Parameters of the BSDF of a leaf with the index relative to what is around a path, its `medium`; `None` without refraction. If
/// the index depends on the wavelength, `disperse` chooses that of the path.
pub(super) fn parameters_at_surface(
    ctx: &TraceContext,
    medium: &Medium,
    leaf: usize,
    parameters: &BsdfParameters,
    wavelength: Option<f32>,
    disperse: impl FnOnce() -> f32,
) -> Option<BsdfParameters> {
    let with_index = with_index(ctx, leaf)?;
    let wavelength = if ctx.scene.disperses_at(medium, leaf) { Some(disperse()) } else { wavelength };
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
