// Weights of multiple importance sampling. Twin of the weights in light_sampling.rs.

/// Power heuristic: weight of a sample of density `a` where another strategy has density `b`.
fn power_heuristic(a: f32, b: f32) -> f32 {
    let ratio = b / max(a, 1e-30);
    return 1.0 / (1.0 + ratio * ratio);
}

/// Weight of light that a ray hit, where light sampling has the other density.
fn hit_weight(scatter_pdf: f32, light_pdf: f32) -> f32 {
    if scatter_pdf <= 0.0 || DIRECT_LIGHTING == BSDF_SAMPLING {
        return 1.0;
    }
    return select(power_heuristic(scatter_pdf, light_pdf), 0.0, DIRECT_LIGHTING == LIGHT_SAMPLING);
}

/// Weight of a sampled light, where scattering has the other density.
fn sample_weight(light_pdf: f32, scatter_pdf: f32) -> f32 {
    if light_pdf <= 0.0 || DIRECT_LIGHTING == LIGHT_SAMPLING {
        return 1.0;
    }
    return select(power_heuristic(light_pdf, scatter_pdf), 0.0, DIRECT_LIGHTING == BSDF_SAMPLING);
}
