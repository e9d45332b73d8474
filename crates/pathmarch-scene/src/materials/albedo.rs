//! Directional albedo of GGX surfaces, as a table, for energy-conserving layers and for the light that is lost between
//! facets.
//!
//! With Schlick's Fresnel factor the directional albedo is linear in both of its ends, E(F0, F90) = F0 a + F90 b, so two
//! numbers for each cosine and roughness are exact for every colour (Karis 2013, "Real Shading in Unreal Engine 4", stores
//! the same split). Computed once, when first asked for, in about ten milliseconds.

use super::microfacet::{MIN_ALPHA, fifth_power, reflect, unshadowed, visible_normal};
use glam::Vec3;
use pathmarch_field::number::Real;
use std::sync::OnceLock;

/// Rows of the table, over roughness 0 to 1.
pub const ROUGHNESSES: usize = 32;
/// Columns of the table, over the square root of the cosine, 0 to 1.
pub const COSINES: usize = 32;
/// Along each edge of the grid of sampled normals.
const SAMPLES: usize = 20;

/// The table of (a, b): row by row of rising roughness, in each the columns of rising cosine.
pub fn table() -> &'static [[f32; 2]] {
    static TABLE: OnceLock<Vec<[f32; 2]>> = OnceLock::new();
    TABLE.get_or_init(|| {
        let cell = |index: usize| {
            let root = (index % COSINES) as f32 / (COSINES - 1) as f32;
            let roughness = (index / COSINES) as f32 / (ROUGHNESSES - 1) as f32;
            let (cosine, alpha) = ((root * root).max(1e-4), (roughness * roughness).max(MIN_ALPHA));
            let grazing = |cosine: f32| fifth_power(1.0 - cosine);
            [integrate(cosine, alpha, |c| 1.0 - grazing(c)), integrate(cosine, alpha, grazing)]
        };
        (0..ROUGHNESSES * COSINES).map(cell).collect()
    })
}

/// Directional albedo at a cosine, for a Fresnel factor as a function of the cosine to the facets.
pub(super) fn integrate(cosine: f32, alpha: f32, factor: impl Fn(f32) -> f32) -> f32 {
    let wo = Vec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine);
    let facet = |k: usize| {
        let at = |k: usize| (k as f32 + 0.5) / SAMPLES as f32;
        let h: Vec3 = visible_normal(wo, alpha, [at(k % SAMPLES), at(k / SAMPLES)]).into();
        let wi = reflect(wo, h);
        if wi.z <= 0.0 {
            return 0.0;
        }
        unshadowed(wo, wi, alpha) * factor(wo.dot(h))
    };
    (0..SAMPLES * SAMPLES).map(facet).sum::<f32>() / (SAMPLES * SAMPLES) as f32
}

/// The table with four numbers for each column but the last: (a, b) of the column and of the next one.
fn pairs() -> &'static [f32] {
    static PAIRS: OnceLock<Vec<f32>> = OnceLock::new();
    PAIRS.get_or_init(|| {
        let of_row =
            |row: &[[f32; 2]]| row.windows(2).flat_map(|pair| pair.as_flattened().to_vec()).collect::<Vec<_>>();
        table().chunks(COSINES).flat_map(of_row).collect()
    })
}

/// (a, b) for a cosine and a roughness, both 0 to 1, between the table's points.
#[inline(always)]
pub(super) fn lookup<N: Real>(cosine: N, roughness: N) -> [N; 2] {
    let (table, zero, one) = (pairs(), N::zero(), N::one());
    // Cell of a table of so many points that a share of it is in, and its place there.
    let place = |share: N, points: usize| {
        let place = share.clamp(zero, one) * N::constant((points - 1) as f32);
        let cell = place.floor().min(N::constant((points - 2) as f32));
        (cell, place - cell)
    };
    let (column, s) = place(cosine.max(zero).sqrt(), COSINES);
    let (row, t) = place(roughness, ROUGHNESSES);
    let in_row = |row: N| {
        let [a, b, next_a, next_b] = N::vector(table, row * N::constant((COSINES - 1) as f32) + column);
        [a * (one - s) + next_a * s, b * (one - s) + next_b * s]
    };
    let (lower, upper) = (in_row(row), in_row(row + one));
    std::array::from_fn(|k| lower[k] * (one - t) + upper[k] * t)
}

/// The mean of a function of the cosine over the hemisphere, each direction weighed by its own cosine.
pub(super) fn hemisphere_mean(of: impl Fn(f32) -> f32) -> f32 {
    const STEPS: usize = 128;
    let step = |k: usize| {
        let cosine = (k as f32 + 0.5) / STEPS as f32;
        2.0 * cosine * of(cosine) / STEPS as f32
    };
    (0..STEPS).map(step).sum()
}
