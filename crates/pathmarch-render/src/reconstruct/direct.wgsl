// import: reconstruct/pass
// Direct light of the film, and the variance of what is not reflected by facets. Twin of mod.rs.

/// Irradiance of the direct light of a pixel of the film.
fn direct_irradiance(position: vec2u, pixel: u32, guide: Guide) -> vec3f {
    let direct = max(film_mean(position, pixel) - guide.reflected - guide.indirect, vec3f(0.0));
    return min(direct / divisor(guide), vec3f(MAX_IRRADIANCE));
}

/// Variance of the luminance of samples without the light of facets, if `direct` is the mean of the direct light.
fn variance_without_facets(guide: Guide, direct: f32) -> f32 {
    let all = divisor(guide);
    let mean = direct + luminance((guide.indirect + guide.reflected) / all);
    let variance = max(guide.square - mean * mean, 0.0);
    if guide.alpha == 0.0 {
        return variance;
    }
    let of_facets = reflection_divisor(guide);
    let unit = luminance(of_facets / all);
    let mean_of_facets = luminance(guide.reflected / of_facets);
    let variance_of_facets = max(guide.reflected_square - mean_of_facets * mean_of_facets, 0.0) * unit * unit;
    return max(variance - variance_of_facets, LEAST_BASE_VARIANCE * variance);
}

/// Mean square of the luminance of the direct light of samples, whose mean is `direct`.
fn direct_square(guide: Guide, direct: f32) -> f32 {
    return direct * direct + variance_without_facets(guide, direct);
}
