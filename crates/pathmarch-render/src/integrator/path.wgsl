// import: film_value, integrator/camera, integrator/light_sampling, integrator/shadow, integrator/sky
// import: sampler, sampling/basis, shading/surface_interaction, textures
// Path tracing. Twin of path.rs, which explains the estimator.

/// Contribution of light after this many bounces, within the limit of the frame.
fn limited(contribution: vec3f, bounces: u32) -> vec3f {
    if bounces == 0u {
        return contribution;
    }
    return contribution * (frame.clamp / max(largest(contribution), frame.clamp));
}

/// Path at the surface that it has reached.
struct Path {
    ray: Ray,
    sampler: PixelSampler,
    /// Point that the lights of the previous surface were sampled from.
    previous_vertex: vec3f,
    radiance: vec3f,
    throughput: vec3f,
    length: f32,
    /// Pdf of the ray's direction over solid angle; 0 for a delta distribution.
    scatter_pdf: f32,
    /// Absorption coefficient of the medium around it, per metre.
    medium: vec3f,
    /// Whether it has gone straight through clear glass, as shadow rays do, since it last sampled a light.
    passing: bool,
    /// Square of the refractive index around it.
    index_square: f32,
    /// Number of surfaces that it has left.
    surfaces: u32,
    at: SurfaceInteraction,
}

fn path_from(camera: Ray, sampler: PixelSampler) -> Path {
    var path: Path;
    path.ray = camera;
    path.sampler = sampler;
    path.previous_vertex = camera.origin;
    path.throughput = vec3f(1.0);
    path.medium = frame.medium;
    path.index_square = 1.0;
    return path;
}

/// Follows the path's ray to the next surface and adds what it emits; returns false where the path ends.
fn path_arrive(path: ptr<function, Path>) -> bool {
    // Light that a ray hits was reflected one bounce before.
    let bounces = max((*path).surfaces, 1u) - 1u;
    let ray = (*path).ray;
    let hit = march(ray, (*path).length, AT_INFINITY);
    if ABSORPTION {
        (*path).throughput *= transmittance((*path).medium, select(hit.t, UNBOUNDED_LENGTH, hit.t < 0.0));
    }
    if hit.t < 0.0 {
        if !(FAST_CAUSTICS && (*path).passing) {
            let beyond = sky_radiance(ray.direction, (*path).scatter_pdf) + sun_radiance(ray.direction, (*path).scatter_pdf);
            (*path).radiance += limited((*path).throughput * beyond, bounces);
        } else {
            (*path).radiance += limited((*path).throughput * unsampled_sky_radiance(ray.direction), bounces);
        }
        return false;
    }
    (*path).length += hit.t;
    (*path).at = surface_interaction(ray, hit, unstratified_seed((*path).sampler, (*path).surfaces));
    let at = (*path).at;
    let leaf = leaves[at.leaf];
    let m = leaf.material;
    if HAS_EMITTERS && (materials[m].flags & EMITS) != 0u {
        let light = leaf.flags >> LIGHT_SHIFT;
        // Shadow rays have counted it already.
        let counted = FAST_CAUSTICS && (*path).passing && light > 0u;
        if emits_towards(at.leaf, at.normal) && !counted {
            var weight = 1.0;
            if TRANSMISSION && at.inside && (leaf.flags & IN_GLASS) != 0u {
                weight = (*path).index_square;
            } else if HAS_SURFACE_LIGHTS && light > 0u {
                let cosine = abs(dot(at.normal, ray.direction));
                let reached = ray.origin + ray.direction * hit.t;
                weight = hit_weight((*path).scatter_pdf, light_pdf(lights[light - 1u], (*path).previous_vertex, reached, cosine));
            }
            (*path).radiance += limited((*path).throughput * materials[m].emission * weight, bounces);
        }
        return false;
    }
    return (*path).surfaces <= frame.bounces;
}

/// Samples a light at the surface that the path has reached, and its next direction; returns false where the path ends.
fn path_scatter(path: ptr<function, Path>) -> bool {
    let surface_index = (*path).surfaces;
    let incoming = (*path).ray.direction;
    let at = (*path).at;
    let m = leaves[at.leaf].material;
    let flags = materials[m].flags;
    let outward = outward_normal(at);
    evaluate_textures(m, at.leaf, at.p, outward, (*path).length);
    // The shading normal; the geometric one decides on which side a direction is.
    let shaded = shading_normal(outward, at.normal, -incoming);
    let world_from_local = basis(shaded);
    let back = -incoming * world_from_local;
    // Where the field is so rough that its normal looks away from the ray, the mirrored direction stands for the ray.
    let wo = vec3f(back.xy, max(abs(back.z), 1e-5));
    let transmits = TRANSMISSION && (flags & TRANSMITS) != 0u;
    let beyond = medium_beyond((*path).medium, materials[m].absorption, at.inside);
    let pair = PAIR_SURFACE + PAIRS_PER_SURFACE * surface_index;
    let choice = sample_2d((*path).sampler, pair + PAIR_CHOICE);
    if HAS_LIGHTS && (flags & DELTA) == 0u {
        (*path).previous_vertex = select(spawn_origin(at, false), at.p, transmits);
        let light = light_sample((*path).previous_vertex, choice.x, sample_2d((*path).sampler, pair + PAIR_LIGHT));
        let wi = light.direction * world_from_local;
        let below = wi.z < 0.0;
        let crosses = HAS_BUMP && below != (dot(light.direction, at.normal) < 0.0);
        if (wi.z > 0.0 || transmits) && !crosses && largest(light.irradiance) > 0.0 {
            let scattering = bsdf_eval(materials[m].kind, m, wo, wi, at.inside);
            if largest(scattering.xyz) > 0.0 {
                let arrives = light_transmittance(
                    Ray(spawn_origin(at, below), light.direction),
                    (*path).length,
                    light,
                    scattering.w,
                    select((*path).medium, beyond, below),
                    unstratified_seed((*path).sampler, surface_index),
                );
                (*path).radiance +=
                    limited((*path).throughput * scattering.xyz * light.irradiance * arrives, surface_index);
            }
        }
    }
    var u = vec3f(sample_2d((*path).sampler, pair + PAIR_SCATTER), 0.0);
    if CHOOSES_LOBES {
        u.z = sample_2d((*path).sampler, pair + PAIR_LOBE).x;
    }
    let scattered = bsdf_sample(materials[m].kind, m, wo, at.inside, u);
    if scattered.pdf < 0.0 {
        return false;
    }
    let direction = normalize(world_from_local * scattered.wi);
    if HAS_BUMP && (scattered.wi.z < 0.0) != (dot(direction, at.normal) < 0.0) {
        return false;
    }
    (*path).throughput *= scattered.weight;
    if TRANSMISSION {
        (*path).index_square *= scattered.eta * scattered.eta;
    }
    if surface_index > ROULETTE_DEPTH {
        let survival = min(SURVIVAL * largest((*path).throughput) * (*path).index_square, 1.0);
        if choice.y >= survival {
            return false;
        }
        (*path).throughput /= survival;
    }
    let crossing = TRANSMISSION && scattered.wi.z < 0.0;
    (*path).ray = Ray(spawn_origin(at, crossing), direction);
    if crossing {
        (*path).medium = beyond;
    }
    if FAST_CAUSTICS {
        (*path).passing =
            scattered.pdf == 0.0 && scattered.wi.z < 0.0 && ((*path).passing || (*path).scatter_pdf > 0.0);
    }
    (*path).scatter_pdf = scattered.pdf;
    (*path).surfaces += 1u;
    return true;
}

/// Value of one sample of a pixel, for the film.
fn estimate(camera: Ray, sampler: PixelSampler) -> vec3f {
    var path = path_from(camera, sampler);
    while path_arrive(&path) && path_scatter(&path) {
    }
    return film_value(path.radiance);
}
