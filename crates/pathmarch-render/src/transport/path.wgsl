// A path from the camera. Twin of path.rs, which explains the estimator.

/// A contribution of light after this many bounces, within the limit that is set.
fn limited(contribution: vec3f, bounces: u32) -> vec3f {
    if bounces == 0u {
        return contribution;
    }
    return contribution * (frame.clamp / max(largest(contribution), frame.clamp));
}

/// What a medium leaves of light over a length.
fn left_after(medium: vec3f, length: f32) -> vec3f {
    return exp(-medium * min(length, 1e9));
}

/// The medium beyond a surface that the path passes.
fn medium_beyond(medium: vec3f, absorption: vec3f, inside: bool) -> vec3f {
    return max(select(medium + absorption, medium - absorption, inside), vec3f(0.0));
}

fn radiance_along(camera: Ray, random: Random) -> vec3f {
    var ray = camera;
    // Where the lights of the last surface were seen from.
    var reference = camera.origin;
    var radiance = vec3f(0.0);
    var throughput = vec3f(1.0);
    var path_length = 0.0;
    // Density of the ray's direction over solid angle; 0 for a single direction.
    var scatter_pdf = 0.0;
    var medium = frame.medium;
    // Whether the path went straight through clear glass, as shadow rays do, since it last sampled a light.
    var passing = false;
    // Square of the refractive index where the path is.
    var index_square = 1.0;
    for (var surface_index = 0u; surface_index <= frame.bounces + 1u; surface_index++) {
        // Light that a ray meets fell on the surface before.
        let bounces_met = max(surface_index, 1u) - 1u;
        let hit = march(ray, path_length, AT_INFINITY);
        let t = hit.t;
        if ABSORPTION {
            throughput *= left_after(medium, select(t, 1e9, t < 0.0));
        }
        if t < 0.0 {
            if !(FAST_CAUSTICS && passing) {
                let beyond = sky_beyond(ray.direction, scatter_pdf) + suns_beyond(ray.direction, scatter_pdf);
                radiance += limited(throughput * beyond, bounces_met);
            } else {
                radiance += limited(throughput * sky_not_sampled(ray.direction), bounces_met);
            }
            break;
        }
        path_length += t;
        let reached = ray.origin + ray.direction * t;
        let near = surface(reached, hit.met, random_loose(random, surface_index));
        let steepness = max(length(near.gradient), 1e-6);
        let outward = near.gradient / steepness;
        let leaf = leaves[near.leaf];
        let off = rounding_at(reached, leaf.at);
        // On the surface but for rounding, the side is the one the ray comes from; else the field says it.
        let on_surface = hit.direct || abs(near.distance) <= off + frame.rounding * t;
        let inside = select((near.distance < 0.0), (dot(outward, ray.direction) > 0.0), on_surface);
        let normal = select(outward, -outward, inside);
        let m = leaf.material;
        let flags = materials[m].flags;
        if HAS_EMITTERS && (flags & EMITS) != 0u {
            let light = leaf.flags >> LIGHT_SHIFT;
            let seen = (leaf.flags & SHEET) == 0u || dot(normal, leaf.facing) > 0.0;
            // Shadow rays have brought it already.
            let counted = FAST_CAUSTICS && passing && light > 0u;
            if seen && !counted {
                var weight = 1.0;
                if HAS_SURFACE_LIGHTS && light > 0u {
                    let cosine = abs(dot(normal, ray.direction));
                    weight = met_weight(scatter_pdf, light_pdf(lights[light - 1u], reference, reached, cosine));
                }
                radiance += limited(throughput * materials[m].emission * weight, bounces_met);
            }
            break;
        }
        if surface_index > frame.bounces {
            break;
        }
        let p = reached - outward * (near.distance / steepness);
        let away = normal * start_offset(off, near.distance / steepness);
        paint(m, near.leaf, p, outward, path_length);
        // What light sees; that of the shape says on which side a direction is.
        let shaded = shaded_normal(outward, normal, -ray.direction);
        let world_from_local = basis(shaded);
        let back = -ray.direction * world_from_local;
        // Where the field is so rough that its normal looks away from the ray, the surface is met from the mirrored direction.
        let wo = vec3f(back.xy, max(abs(back.z), 1e-5));
        let transmits = TRANSMISSION && (flags & TRANSMITS) != 0u;
        let beyond = medium_beyond(medium, materials[m].absorption, inside);
        let pair = PAIR_SURFACE + PAIRS_PER_SURFACE * surface_index;
        let choice = random_pair(random, pair + PAIR_CHOICE);
        if HAS_LIGHTS && (flags & DELTA) == 0u {
            reference = select(p + away, p, transmits);
            let light = light_sample(reference, choice.x, random_pair(random, pair + PAIR_LIGHT));
            let wi = light.direction * world_from_local;
            let crosses = HAS_BUMP && (wi.z < 0.0) != (dot(light.direction, normal) < 0.0);
            if (wi.z > 0.0 || transmits) && !crosses && largest(light.irradiance) > 0.0 {
                let scattering = bsdf_eval(materials[m].kind, m, wo, wi, inside);
                if largest(scattering.xyz) > 0.0 {
                    let towards = Ray(p + select(away, -away, wi.z < 0.0), light.direction);
                    let between = select(medium, beyond, wi.z < 0.0);
                    let arrives = light_through(towards, path_length, light, scattering.w, between, random_loose(random, surface_index));
                    radiance += limited(throughput * scattering.xyz * light.irradiance * arrives, surface_index);
                }
            }
        }
        var u = vec3f(random_pair(random, pair + PAIR_SCATTER), 0.0);
        if CHOOSES_LOBES {
            u.z = random_pair(random, pair + PAIR_LOBE).x;
        }
        let scattered = bsdf_sample(materials[m].kind, m, wo, inside, u);
        if scattered.pdf < 0.0 {
            break;
        }
        let direction = normalize(world_from_local * scattered.wi);
        if HAS_BUMP && (scattered.wi.z < 0.0) != (dot(direction, normal) < 0.0) {
            break;
        }
        throughput *= scattered.weight;
        if TRANSMISSION {
            index_square *= scattered.eta * scattered.eta;
        }
        if surface_index > 4u {
            let survival = min(largest(throughput) * index_square, 1.0);
            if choice.y >= survival {
                break;
            }
            throughput /= survival;
        }
        if TRANSMISSION && scattered.wi.z < 0.0 {
            ray.origin = p - away;
            medium = beyond;
        } else {
            ray.origin = p + away;
        }
        if FAST_CAUSTICS {
            passing = scattered.pdf == 0.0 && scattered.wi.z < 0.0 && (passing || scatter_pdf > 0.0);
        }
        ray.direction = direction;
        scatter_pdf = scattered.pdf;
    }
    return radiance;
}
