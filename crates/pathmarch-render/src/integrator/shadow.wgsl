// What of a light's sample arrives. Twin of shadow.rs, which explains it.

/// Clear glass that a shadow ray passes at most.
const MAX_PASSED = 8u;

/// The share of a sampled light that arrives along a ray, its weight against the density of scattering included.
fn light_through(start: Ray, before: f32, light: LightSample, scatter_pdf: f32, between: vec3f, seed: u32) -> vec3f {
    if PENUMBRA && light.penumbra > 0.0 {
        return near_misses(start, light.distance, light.penumbra) * left_after(between, light.distance);
    }
    var weight = sampled_weight(light.pdf, scatter_pdf);
    var passed = vec3f(1.0);
    var medium = between;
    var ray = start;
    var limit = light.distance;
    for (var k = 0u; k <= select(0u, MAX_PASSED, FAST_CAUSTICS); k++) {
        let hit = march(ray, before, limit);
        let obstacle = hit.t;
        if ABSORPTION {
            passed *= left_after(medium, select(obstacle, limit, obstacle < 0.0));
        }
        if obstacle < 0.0 {
            return select(vec3f(0.0), passed * weight, light.target_leaf == NO_TARGET);
        }
        if (!HAS_BOUNDED || light.target_leaf == NO_TARGET) && !FAST_CAUSTICS {
            return vec3f(0.0);
        }
        let reached = ray.origin + ray.direction * obstacle;
        let met = surface(reached, hit.met, seed);
        let leaf = leaves[met.leaf];
        if HAS_BOUNDED && met.leaf == light.target_leaf {
            // A sheet's gradient points to the side it is seen from.
            // From inside glass, paths alone find the light.
            let from_glass = TRANSMISSION && (leaf.flags & IN_GLASS) != 0u && dot(met.gradient, ray.direction) > 0.0;
            let seen = ((leaf.flags & SHEET) == 0u || dot(ray.direction, leaf.facing) < 0.0) && !from_glass;
            return select(vec3f(0.0), passed * weight, seen);
        }
        let m = leaf.material;
        if !FAST_CAUSTICS || (materials[m].flags & (DELTA | TRANSMITS)) != (DELTA | TRANSMITS) {
            return vec3f(0.0);
        }
        let steepness = max(length(met.gradient), 1e-6);
        let outward = met.gradient / steepness;
        let cosine = dot(outward, ray.direction);
        passed *= tint(m, met.leaf, reached, outward, before) * (1.0 - fresnel(min(abs(cosine), 1.0), materials[m].numbers[1].x));
        medium = medium_beyond(medium, materials[m].absorption, cosine > 0.0);
        // No path finds this light again.
        weight = 1.0;
        let on = reached - outward * (met.distance / steepness);
        let off = rounding_at(reached, leaf.at);
        let margin = start_offset(off, met.distance / steepness);
        ray.origin = on + outward * select(-margin, margin, cosine > 0.0);
        limit -= obstacle;
    }
    return vec3f(0.0);
}
