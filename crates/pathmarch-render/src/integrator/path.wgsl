// A path from the camera. Twin of path.rs, which explains the estimator.

/// Over its throughput, the probability that a path goes on.
const SURVIVAL = 3.0;

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

/// A path at the surface that it reached last.
struct Path {
    ray: Ray,
    random: Random,
    /// Where the lights of the last surface were seen from.
    reference: vec3f,
    radiance: vec3f,
    throughput: vec3f,
    length: f32,
    /// Density of the ray's direction over solid angle; 0 for a single direction.
    scatter_pdf: f32,
    medium: vec3f,
    /// Whether it went straight through clear glass, as shadow rays do, since it last sampled a light.
    passing: bool,
    /// Square of the refractive index where it is.
    index_square: f32,
    /// Surfaces that it has left.
    surfaces: u32,
    near: Surface,
    /// Length of the last ray.
    last: f32,
    direct: bool,
}

fn path_from(camera: Ray, random: Random) -> Path {
    var path: Path;
    path.ray = camera;
    path.random = random;
    path.reference = camera.origin;
    path.throughput = vec3f(1.0);
    path.medium = frame.medium;
    path.index_square = 1.0;
    return path;
}

/// Whether a path comes to its surface from the inside.
fn is_inside(path: Path, outward: vec3f, off: f32) -> bool {
    // On the surface but for rounding, the side is the one the ray comes from; else the field says it.
    let on_surface = path.direct || abs(path.near.distance) <= off + frame.rounding * path.last;
    return select((path.near.distance < 0.0), (dot(outward, path.ray.direction) > 0.0), on_surface);
}

/// Follows the path's ray to the next surface and gathers what it emits; false where the path ends.
fn path_arrive(path: ptr<function, Path>) -> bool {
    // Light that a ray meets fell on the surface before.
    let bounces_met = max((*path).surfaces, 1u) - 1u;
    let direction = (*path).ray.direction;
    let hit = march((*path).ray, (*path).length, AT_INFINITY);
    let t = hit.t;
    if ABSORPTION {
        (*path).throughput *= left_after((*path).medium, select(t, 1e9, t < 0.0));
    }
    if t < 0.0 {
        if !(FAST_CAUSTICS && (*path).passing) {
            let beyond = sky_beyond(direction, (*path).scatter_pdf) + suns_beyond(direction, (*path).scatter_pdf);
            (*path).radiance += limited((*path).throughput * beyond, bounces_met);
        } else {
            (*path).radiance += limited((*path).throughput * sky_not_sampled(direction), bounces_met);
        }
        return false;
    }
    (*path).length += t;
    (*path).last = t;
    (*path).direct = hit.direct;
    let reached = (*path).ray.origin + direction * t;
    (*path).ray.origin = reached;
    (*path).near = surface(reached, hit.met, random_loose((*path).random, (*path).surfaces));
    let leaf = leaves[(*path).near.leaf];
    let m = leaf.material;
    if HAS_EMITTERS && (materials[m].flags & EMITS) != 0u {
        let outward = (*path).near.gradient / max(length((*path).near.gradient), 1e-6);
        let inside = is_inside(*path, outward, rounding_at(reached, leaf.at));
        let normal = select(outward, -outward, inside);
        let light = leaf.flags >> LIGHT_SHIFT;
        let seen = (leaf.flags & SHEET) == 0u || dot(normal, leaf.facing) > 0.0;
        // Shadow rays have brought it already.
        let counted = FAST_CAUSTICS && (*path).passing && light > 0u;
        if seen && !counted {
            var weight = 1.0;
            if TRANSMISSION && inside && (leaf.flags & IN_GLASS) != 0u {
                weight = (*path).index_square;
            } else if HAS_SURFACE_LIGHTS && light > 0u {
                let cosine = abs(dot(normal, direction));
                weight = met_weight((*path).scatter_pdf, light_pdf(lights[light - 1u], (*path).reference, reached, cosine));
            }
            (*path).radiance += limited((*path).throughput * materials[m].emission * weight, bounces_met);
        }
        return false;
    }
    return (*path).surfaces <= frame.bounces;
}

/// Samples a light at the surface that the path reached, and its next direction; false where the path ends.
fn path_scatter(path: ptr<function, Path>) -> bool {
    let surface_index = (*path).surfaces;
    let incoming = (*path).ray.direction;
    let reached = (*path).ray.origin;
    let near = (*path).near;
    let steepness = max(length(near.gradient), 1e-6);
    let outward = near.gradient / steepness;
    let leaf = leaves[near.leaf];
    let off = rounding_at(reached, leaf.at);
    let inside = is_inside(*path, outward, off);
    let normal = select(outward, -outward, inside);
    let m = leaf.material;
    let flags = materials[m].flags;
    let p = reached - outward * (near.distance / steepness);
    let away = normal * start_offset(off, near.distance / steepness);
    paint(m, near.leaf, p, outward, (*path).length);
    // What light sees; that of the shape says on which side a direction is.
    let shaded = shaded_normal(outward, normal, -incoming);
    let world_from_local = basis(shaded);
    let back = -incoming * world_from_local;
    // Where the field is so rough that its normal looks away from the ray, the surface is met from the mirrored direction.
    let wo = vec3f(back.xy, max(abs(back.z), 1e-5));
    let transmits = TRANSMISSION && (flags & TRANSMITS) != 0u;
    let beyond = medium_beyond((*path).medium, materials[m].absorption, inside);
    let pair = PAIR_SURFACE + PAIRS_PER_SURFACE * surface_index;
    let choice = random_pair((*path).random, pair + PAIR_CHOICE);
    if HAS_LIGHTS && (flags & DELTA) == 0u {
        (*path).reference = select(p + away, p, transmits);
        let light = light_sample((*path).reference, choice.x, random_pair((*path).random, pair + PAIR_LIGHT));
        let wi = light.direction * world_from_local;
        let crosses = HAS_BUMP && (wi.z < 0.0) != (dot(light.direction, normal) < 0.0);
        if (wi.z > 0.0 || transmits) && !crosses && largest(light.irradiance) > 0.0 {
            let scattering = bsdf_eval(materials[m].kind, m, wo, wi, inside);
            if largest(scattering.xyz) > 0.0 {
                let towards = Ray(p + select(away, -away, wi.z < 0.0), light.direction);
                let between = select((*path).medium, beyond, wi.z < 0.0);
                let arrives = light_through(
                    towards,
                    (*path).length,
                    light,
                    scattering.w,
                    between,
                    random_loose((*path).random, surface_index),
                );
                (*path).radiance +=
                    limited((*path).throughput * scattering.xyz * light.irradiance * arrives, surface_index);
            }
        }
    }
    var u = vec3f(random_pair((*path).random, pair + PAIR_SCATTER), 0.0);
    if CHOOSES_LOBES {
        u.z = random_pair((*path).random, pair + PAIR_LOBE).x;
    }
    let scattered = bsdf_sample(materials[m].kind, m, wo, inside, u);
    if scattered.pdf < 0.0 {
        return false;
    }
    let direction = normalize(world_from_local * scattered.wi);
    if HAS_BUMP && (scattered.wi.z < 0.0) != (dot(direction, normal) < 0.0) {
        return false;
    }
    (*path).throughput *= scattered.weight;
    if TRANSMISSION {
        (*path).index_square *= scattered.eta * scattered.eta;
    }
    if surface_index > 4u {
        let survival = min(SURVIVAL * largest((*path).throughput) * (*path).index_square, 1.0);
        if choice.y >= survival {
            return false;
        }
        (*path).throughput /= survival;
    }
    if TRANSMISSION && scattered.wi.z < 0.0 {
        (*path).ray.origin = p - away;
        (*path).medium = beyond;
    } else {
        (*path).ray.origin = p + away;
    }
    if FAST_CAUSTICS {
        (*path).passing =
            scattered.pdf == 0.0 && scattered.wi.z < 0.0 && ((*path).passing || (*path).scatter_pdf > 0.0);
    }
    (*path).ray.direction = direction;
    (*path).scatter_pdf = scattered.pdf;
    (*path).surfaces += 1u;
    return true;
}

fn radiance_along(camera: Ray, random: Random) -> vec3f {
    var path = path_from(camera, random);
    while path_arrive(&path) && path_scatter(&path) {
    }
    return path.radiance;
}
