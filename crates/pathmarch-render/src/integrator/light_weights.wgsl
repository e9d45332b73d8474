// Weights of multiple importance sampling (MIS). Twin of the weights in light_sampling.rs.

/// Power heuristic: weight of a sample with pdf `a`, where another strategy has pdf `b`.
fn power_heuristic(a: f32, b: f32) -> f32 {
    let ratio = b / max(a, 1e-30);
    return 1.0 / (1.0 + ratio * ratio);
}

/// MIS weight of BSDF sampling: a ray with pdf `scatter_pdf` hit a light that light sampling chooses with `light_pdf`.
fn hit_weight(scatter_pdf: f32, light_pdf: f32) -> f32 {
    if scatter_pdf <= 0.0 || DIRECT_LIGHTING == BSDF_SAMPLING {
        return 1.0;
    }
    return select(power_heuristic(scatter_pdf, light_pdf), 0.0, DIRECT_LIGHTING == LIGHT_SAMPLING);
}

/// MIS weight of light sampling with pdf `light_pdf`, where BSDF sampling has `scatter_pdf`.
fn sample_weight(light_pdf: f32, scatter_pdf: f32) -> f32 {
    if light_pdf <= 0.0 || DIRECT_LIGHTING == LIGHT_SAMPLING {
        return 1.0;
    }
    return select(power_heuristic(light_pdf, scatter_pdf), 0.0, DIRECT_LIGHTING == BSDF_SAMPLING);
}
