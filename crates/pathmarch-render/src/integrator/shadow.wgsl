// import: integrator/light_sampling, integrator/medium, near_misses, shading/surface_interaction, textures
// Visibility of a sampled light. Twin of shadow.rs, which explains it.

/// Share of a sampled light that arrives along a ray, with its weight against the density of scattering.
fn light_transmittance(start: Ray, path_length: f32, light: LightSample, scatter_pdf: f32, between: vec3f, seed: u32) -> vec3f {
    if PENUMBRA && light.penumbra > 0.0 {
        return near_misses(start, light.distance, light.penumbra) * transmittance(between, light.distance);
    }
    var weight = sample_weight(light.pdf, scatter_pdf);
    var passed = vec3f(1.0);
    var medium = between;
    var ray = start;
    var limit = light.distance;
    for (var k = 0u; k <= select(0u, MAX_PASSED, FAST_CAUSTICS); k++) {
        let hit = march(ray, path_length, limit);
        if ABSORPTION {
            passed *= transmittance(medium, select(hit.t, limit, hit.t < 0.0));
        }
        if hit.t < 0.0 {
            return select(vec3f(0.0), passed * weight, light.target_leaf == NO_TARGET);
        }
        if (!HAS_BOUNDED || light.target_leaf == NO_TARGET) && !FAST_CAUSTICS {
            return vec3f(0.0);
        }
        let at = surface_interaction(ray, hit, seed);
        let leaf = leaves[at.leaf];
        if HAS_BOUNDED && at.leaf == light.target_leaf {
            // From inside glass, paths alone find the light.
            let from_glass = TRANSMISSION && (leaf.flags & IN_GLASS) != 0u && at.inside;
            return select(vec3f(0.0), passed * weight, emits_towards(at.leaf, -ray.direction) && !from_glass);
        }
        let m = leaf.material;
        if !FAST_CAUSTICS || (materials[m].flags & (DELTA | TRANSMITS)) != (DELTA | TRANSMITS) {
            return vec3f(0.0);
        }
        let cosine = min(abs(dot(at.normal, ray.direction)), 1.0);
        let colour = glass_colour(m, at.leaf, at.p, outward_normal(at), path_length);
        passed *= colour * (1.0 - fresnel(cosine, materials[m].parameters[1].x));
        medium = medium_beyond(medium, materials[m].absorption, at.inside);
        // No path finds this light again.
        weight = 1.0;
        ray.origin = spawn_origin(at, true);
        limit -= hit.t;
    }
    return vec3f(0.0);
}
