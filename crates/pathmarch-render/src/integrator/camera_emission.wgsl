// import: integrator/path_state, intersect/march
// Emission that camera rays see. Twin of `emission_along` in path.rs.

/// Light that the surface which a camera ray hits emits towards the camera; 1 in w if it is an emitter, which scatters no
/// light.
fn emission_along(camera: Ray, sampler: PixelSampler) -> vec4f {
    var path = path_from(camera, sampler);
    let hit = march(path.ray, path.length, AT_INFINITY);
    if hit.t < 0.0 {
        return vec4f(0.0);
    }
    if ABSORPTION {
        path.throughput *= transmittance(path.medium, hit.t);
    }
    let scatters = arrive(&path, hit);
    let m = leaf_at(path.interaction.leaf).material;
    if scatters && HAS_GLOW && (material_at(m).flags & GLOWS) != 0u {
        evaluate_textures(m, path.interaction, path.length);
        add_emission(&path, path.interaction, emission_at(m));
    }
    return vec4f(path.radiance, select(0.0, 1.0, (material_at(m).flags & EMITS) != 0u));
}
