// import: integrator/light_sampling, media, near_misses, nested_dielectrics, shading/surface_interaction, textures
// Shadow tests of light samples. Twin of shadow.rs, which explains them.

/// Transmittance of a shadow ray to a sampled light, times the MIS weight of the light. `first_medium` is that
/// around the origin of the ray.
fn light_transmittance(first_ray: Ray, path_length: f32, light: LightSample, scatter_pdf: f32, first_medium: Medium, seed: u32) -> vec3f {
    if PENUMBRA && light.penumbra > 0.0 {
        return near_misses(first_ray, light.distance, light.penumbra) * transmittance_in(first_medium, light.distance);
    }
    var weight = sample_weight(light.pdf, scatter_pdf);
    var attenuation = vec3f(1.0);
    var medium = first_medium;
    var ray = first_ray;
    var limit = light.distance;
    for (var k = 0u; k <= select(select(0u, MAX_CLEAR_SURFACES, FAST_CAUSTICS), MAX_CROSSINGS, HAS_BOUNDARIES || NESTED_DIELECTRICS); k++) {
        let hit = march(ray, path_length, limit);
        if ABSORPTION {
            attenuation *= transmittance_in(medium, select(hit.t, limit, hit.t < 0.0));
        }
        if hit.t < 0.0 {
            return select(vec3f(0.0), attenuation * weight, light.target_leaf == NO_TARGET);
        }
        if (!HAS_BOUNDED || light.target_leaf == NO_TARGET) && !FAST_CAUSTICS && !HAS_BOUNDARIES && !NESTED_DIELECTRICS {
            return vec3f(0.0);
        }
        let occluder = surface_interaction(ray, hit, seed);
        let leaf = leaf_at(occluder.leaf);
        if HAS_BOUNDED && occluder.leaf == light.target_leaf {
            // From inside glass, only BSDF sampling contributes the light.
            let from_glass = TRANSMISSION && (leaf.flags & IN_GLASS) != 0u && occluder.inside;
            return select(vec3f(0.0), attenuation * weight, emits_towards(occluder.leaf, -ray.direction) && !from_glass);
        }
        let m = leaf.material;
        let is_boundary = HAS_BOUNDARIES && (material_at(m).flags & BOUNDARY) != 0u;
        if is_boundary || (NESTED_DIELECTRICS && is_skipped(medium, occluder.leaf)) {
            medium = medium_after(medium, occluder.leaf, occluder.inside);
            ray.origin = spawn_origin(occluder, true);
            limit -= hit.t;
            continue;
        }
        if !FAST_CAUSTICS || (material_at(m).flags & (DELTA | TRANSMITS)) != (DELTA | TRANSMITS) {
            return vec3f(0.0);
        }
        let cosine = min(abs(dot(occluder.normal, ray.direction)), 1.0);
        let colour = glass_colour(m, occluder, path_length);
        let index = relative_index(medium, occluder.leaf, 0.0);
        var reflected = fresnel(cosine, select(index, max(index, 1.0 / index), NESTED_DIELECTRICS));
        if THIN_GLASS && material_parameter(m, 7u).w > 0.0 {
            reflected = sheet_reflection(reflected);
        }
        attenuation *= colour * (1.0 - reflected);
        medium = medium_after(medium, occluder.leaf, occluder.inside);
        // BSDF sampling leaves out this light.
        weight = 1.0;
        ray.origin = spawn_origin(occluder, true);
        limit -= hit.t;
    }
    return vec3f(0.0);
}
