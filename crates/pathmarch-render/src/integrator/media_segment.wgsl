// import: guides, integrator/light_sampling, integrator/shadow, media, nested_dielectrics, sampler
// Segments of paths through participating media. Part of path.wgsl, twin of media_segment.rs.

/// Follows the ray of a path to its next surface or scattering event. Adds light that the media on the way emit and scatter,
/// and light of the surface or of the sky. Returns false if the path ends.
fn path_intersect(path: ptr<function, Path>) -> bool {
    let surface_index = (*path).surfaces;
    (*path).is_in_medium = false;
    for (var crossing = 0u; crossing < MAX_CROSSINGS; crossing++) {
        let ray = (*path).ray;
        let hit = march(ray, (*path).length, AT_INFINITY);
        let length = select(hit.t, UNBOUNDED_LENGTH, hit.t < 0.0);
        if MEDIA_ARE_BOUNDED && hit.t < 0.0 {
            // A ray that escapes is outside of all solids, even if it missed a surface on its way.
            (*path).medium = Medium(vec3f(0.0), 0.0, vec3f(0.0), 0u, vec3f(0.0), NO_SOLIDS);
        }
        let medium = with_fog((*path).medium);
        if PARTICIPATING_MEDIA && largest(medium.emission) > 0.0 {
            // Light that a ray hits counts as direct light of the previous surface.
            let bounces = max(surface_index, 1u) - 1u;
            let emitted = clamped((*path).throughput * emitted_radiance(medium, length), bounces);
            (*path).radiance += emitted;
            if surface_index == 0u {
                let depth = 0.5 * min(min(length, 1.0 / largest(extinction_of(medium))), frame.far);
                record_medium(ray.origin + ray.direction * depth, emitted);
            }
        }
        if PARTICIPATING_MEDIA && surface_index <= frame.bounces && largest(medium.scattering) > 0.0 {
            let pair = PAIR_SEGMENT + PAIRS_PER_SEGMENT * (surface_index + SEGMENTS_PER_CROSSING * crossing);
            if surface_index == 0u {
                record_medium(ray.origin, vec3f(0.0));
            }
            if HAS_LIGHTS && (LIGHTS_IN_SOLIDS || FAST_CAUSTICS || !is_displaced((*path).medium)) {
                add_scattered_light(path, medium, length, pair);
            }
            let end = sample_distance(medium, (*path).throughput, length, sample_2d((*path).sampler, pair + PAIR_DISTANCE));
            if end.distance >= 0.0 {
                if guide_waits() {
                    record_surface_behind(path, hit);
                }
                let margin = SURFACE_MARGIN * frame.rounding * largest(abs(ray.origin + ray.direction * length));
                let t = select(end.distance, min(end.distance, max(hit.t - margin, 0.5 * hit.t)), hit.t > 0.0);
                (*path).throughput *= end.weight;
                (*path).ray.origin = ray.origin + ray.direction * t;
                (*path).length += t;
                (*path).is_in_medium = true;
                record_event((*path).ray.origin, surface_index, (*path).radiance);
                return true;
            }
            (*path).throughput *= end.weight;
        } else {
            (*path).throughput *= transmittance(extinction_of(medium), length);
        }
        if hit.t < 0.0 {
            add_escaped_radiance(path);
            return false;
        }
        if !HAS_BOUNDARIES && !NESTED_DIELECTRICS {
            return arrive(path, hit);
        }
        let interaction = surface_interaction(ray, hit, unstratified_seed((*path).sampler, surface_index));
        let is_boundary = (material_at(leaf_at(interaction.leaf).material).flags & BOUNDARY) != 0u;
        if !is_boundary && !(NESTED_DIELECTRICS && is_skipped((*path).medium, interaction.leaf)) {
            return arrive(path, hit);
        }
        // Like an event in the medium, the boundary is found to rounding, so that no chord is missed.
        (*path).length = select((*path).length + hit.t, LENGTH_IN_MEDIUM, is_boundary);
        (*path).ray.origin = spawn_origin(interaction, true);
        (*path).medium = medium_after((*path).medium, interaction.leaf, interaction.inside);
    }
    return false;
}

/// Adds light of one light that the medium scatters into the path, on a segment of this length.
fn add_scattered_light(path: ptr<function, Path>, medium: Medium, length: f32, pair: u32) {
    let ray = (*path).ray;
    let limited = min(length, UNBOUNDED_LENGTH);
    let extinction = extinction_of(medium);
    let least = min(min(extinction.x, extinction.y), extinction.z);
    let lit_length = min(min(limited, LIT_DEPTH / max(least, 1e-30)), frame.far);
    let chosen = chosen_light_along(ray, lit_length, sample_2d((*path).sampler, pair + PAIR_SEGMENT_CHOICE).x);
    let u = sample_2d((*path).sampler, pair + PAIR_POINT);
    let point = sample_point(ray, limited, medium, (*path).throughput, chosen.light, u);
    let p = ray.origin + ray.direction * point.distance;
    var sampled = sample_direction(chosen.light, p, sample_2d((*path).sampler, pair + PAIR_SEGMENT_LIGHT));
    if sampled.pdf > 0.0 {
        // Rays that hit the light assume the probability of choosing it at their origin, whatever it is for a segment.
        sampled.pdf *= light_from(chosen.index, p, vec3f(0.0)).pmf / chosen.light.pmf;
    }
    let phase = phase_function(anisotropy_of(medium), dot(ray.direction, sampled.direction));
    let remaining = exp(-extinction * point.distance);
    let scattered = (*path).throughput * medium.scattering * remaining * (phase / point.pdf) * sampled.irradiance;
    if largest(scattered) > 0.0 {
        let attenuation = light_transmittance(
            Ray(p, sampled.direction),
            LENGTH_IN_MEDIUM,
            sampled,
            phase,
            (*path).medium,
            unstratified_seed((*path).sampler, (*path).surfaces),
        );
        let light = clamped(scattered * attenuation, (*path).surfaces);
        (*path).radiance += light;
        if (*path).surfaces == 0u {
            record_medium(p, light);
        }
    }
}

/// Records the surface behind a scattering event of a path, whose segment ends at a hit.
fn record_surface_behind(path: ptr<function, Path>, first_hit: Hit) {
    var ray = (*path).ray;
    var length = (*path).length;
    var medium = (*path).medium;
    var hit = first_hit;
    for (var crossing = 0u; crossing < MAX_CROSSINGS && hit.t >= 0.0; crossing++) {
        let interaction = surface_interaction(ray, hit, unstratified_seed((*path).sampler, (*path).surfaces));
        let m = leaf_at(interaction.leaf).material;
        let is_boundary = (material_at(m).flags & BOUNDARY) != 0u;
        length += hit.t;
        if !is_boundary && !is_skipped(medium, interaction.leaf) {
            var colour = material_at(m).emission;
            if (material_at(m).flags & EMITS) == 0u {
                evaluate_textures(m, interaction, length);
                colour = packed(m, 0u).xyz;
            }
            record_guide(interaction, (*path).throughput, length, (*path).surfaces, colour);
            break;
        }
        if (*path).surfaces > 0u {
            break;
        }
        length = select(length, LENGTH_IN_MEDIUM, is_boundary);
        ray.origin = spawn_origin(interaction, true);
        medium = medium_after(medium, interaction.leaf, interaction.inside);
        hit = march(ray, length, AT_INFINITY);
    }
    end_guide();
}

/// Samples the next ray of a path at a scattering event in a medium. Returns false if the path ends.
fn scatter_in_medium(path: ptr<function, Path>) -> bool {
    let pair = PAIR_SURFACE + PAIRS_PER_SURFACE * (*path).surfaces;
    let anisotropy = anisotropy_of(with_fog((*path).medium));
    let incoming = (*path).ray.direction;
    let direction = sample_phase(anisotropy, incoming, sample_2d((*path).sampler, pair + PAIR_SCATTER));
    if !survives(path, sample_2d((*path).sampler, pair + PAIR_CHOICE).y) {
        return false;
    }
    (*path).previous_vertex = (*path).ray.origin;
    (*path).previous_normal = vec3f(0.0);
    (*path).length = LENGTH_IN_MEDIUM;
    (*path).ray.direction = direction;
    (*path).scatter_pdf = phase_function(anisotropy, dot(incoming, direction));
    (*path).lights_are_counted = false;
    (*path).met_photons = false;
    (*path).surfaces += 1u;
    return true;
}
