// import: film_value, guides, integrator/camera, integrator/light_sampling, integrator/path_state, integrator/shadow
// import: media, nested_dielectrics, path_segment, photons, sampler, sampling/basis, shading/shading_normal
// import: shading/surface_interaction, textures
// Path tracing. Twin of path.rs, which explains it.

/// Chooses the wavelength of a path, unless it has one, and makes BSDFs refract at it.
fn disperse(path: ptr<function, Path>, random: f32) {
    if (*path).wavelength == 0.0 {
        (*path).wavelength = wavelength_of(random);
        (*path).throughput *= wavelength_colour((*path).wavelength);
    }
    wavelength_offset = index_offset((*path).wavelength);
}

/// Makes the BSDF of a leaf refract by the index relative to what is around the path. Chooses the wavelength with a random
/// number if the index depends on it.
fn refract_at(path: ptr<function, Path>, leaf: u32, random: f32) {
    let m = leaf_at(leaf).material;
    if (material_at(m).flags & TRANSMITS) == 0u {
        surface_index = own_index(leaf, 0.0);
        return;
    }
    if DISPERSION && disperses_at((*path).medium, leaf) {
        disperse(path, random);
    }
    let offset = select(0.0, index_offset((*path).wavelength), (*path).wavelength > 0.0);
    surface_index = relative_index((*path).medium, leaf, offset);
}

/// Russian roulette with a random number. Returns false if the path ends.
fn survives(path: ptr<function, Path>, random: f32) -> bool {
    // Not short-circuited: software Vulkan would compile the kernel again for a branch by a uniform alone.
    if (frame.bounces > ROULETTE_DEPTH) & ((*path).surfaces > ROULETTE_DEPTH) {
        let survival_probability = min(SURVIVAL_FACTOR * largest((*path).throughput) * (*path).index_square, 1.0);
        if random >= survival_probability {
            return false;
        }
        (*path).throughput /= survival_probability;
    }
    return true;
}

/// Number of the ray that leaves the first surface, below INDIRECT_SAMPLES. Lights are sampled with the first.
var<private> part: u32;

/// Samples a light at the surface of a path, and the next ray. Returns false if the path ends.
fn path_scatter(path: ptr<function, Path>) -> bool {
    if PARTICIPATING_MEDIA && (*path).is_in_medium {
        return scatter_in_medium(path);
    }
    let surface_index = (*path).surfaces;
    let incoming = (*path).ray.direction;
    let interaction = (*path).interaction;
    let m = leaf_at(interaction.leaf).material;
    let flags = material_at(m).flags;
    record_scattering(m, surface_index, (*path).radiance);
    evaluate_textures(m, interaction, (*path).length);
    let is_further = INDIRECT_SAMPLES > 1u && surface_index == 0u && part > 0u;
    if HAS_GLOW && (flags & GLOWS) != 0u {
        if !is_further {
            add_emission(path, interaction, emission_at(m));
        }
        if surface_index > frame.bounces {
            return false;
        }
    }
    record_guide(interaction, (*path).throughput, (*path).length, surface_index, packed(m, 0u).xyz);
    // Shading normal; the geometric normal decides on which side a direction is.
    let ns = shading_normal(interaction, -incoming);
    let world_from_local = basis(ns);
    let wo_unclamped = -incoming * world_from_local;
    // The normal of a rough field may point away from the ray: then its mirrored direction replaces it.
    let wo = vec3f(wo_unclamped.xy, max(abs(wo_unclamped.z), 1e-5));
    let transmits = TRANSMISSION && (flags & TRANSMITS) != 0u;
    let medium_beyond_surface = medium_after((*path).medium, interaction.leaf, interaction.inside);
    let pair = PAIR_SURFACE + PAIRS_PER_SURFACE * surface_index;
    let choice = sample_2d((*path).sampler, pair + PAIR_CHOICE);
    var leaving = (*path).sampler;
    if INDIRECT_SAMPLES > 1u && surface_index == 0u {
        leaving.sample = leaving.sample * INDIRECT_SAMPLES + part;
    }
    if NESTED_DIELECTRICS {
        refract_at(path, interaction.leaf, sample_2d(leaving, pair + PAIR_LOBE).y);
    } else if DISPERSION && (flags & DISPERSES) != 0u {
        disperse(path, sample_2d(leaving, pair + PAIR_LOBE).y);
    }
    let focuses = TRACED_CAUSTICS && (flags & FOCUSES) != 0u;
    let previous_vertex = (*path).previous_vertex;
    let previous_pdf = (*path).scatter_pdf;
    if HAS_LIGHTS && (flags & DELTA) == 0u {
        (*path).previous_vertex = select(spawn_origin(interaction, false), interaction.p, transmits);
        (*path).previous_normal = select(ns, vec3f(0.0), transmits);
        let position = sample_2d((*path).sampler, pair + PAIR_LIGHT);
        let light_samples = select(select(1u, LIGHT_SAMPLES, surface_index == 0u), 0u, is_further);
        for (var k = 0u; k < light_samples; k++) {
            let number = nth_light_choice(k, light_samples, choice.x);
            let chosen = chosen_light((*path).previous_vertex, (*path).previous_normal, number);
            let light = sample_direction(chosen, (*path).previous_vertex, nth_position(k, position));
            // Photons have already contributed it.
            let counted = focuses && (*path).met_photons && starts_light_paths(chosen);
            let wi = light.direction * world_from_local;
            let is_transmission = wi.z < 0.0;
            let crosses_surface = SHADING_NORMALS && is_transmission != (dot(light.direction, interaction.normal) < 0.0);
            if (wi.z > 0.0 || transmits) && !crosses_surface && !counted && largest(light.irradiance) > 0.0 {
                let evaluated = bsdf_eval(material_at(m).kind, m, wo, wi, interaction.inside);
                if largest(evaluated.xyz) > 0.0 {
                    let attenuation = light_transmittance(
                        Ray(spawn_origin(interaction, is_transmission), light.direction),
                        (*path).length,
                        light,
                        evaluated.w,
                        chosen_medium((*path).medium, medium_beyond_surface, is_transmission),
                        unstratified_seed((*path).sampler, surface_index),
                    );
                    let unclamped = (*path).throughput * evaluated.xyz * light.irradiance * attenuation;
                    let sampled = clamped(unclamped, surface_index) / f32(light_samples);
                    (*path).radiance += sampled;
                    record_light_sample(m, wo, wi, interaction.inside, light.distance, sampled);
                }
            }
        }
    }
    if TRACED_CAUSTICS && !focuses && !is_further {
        let seed = unstratified_seed((*path).sampler, surface_index);
        let offset = interaction.p - previous_vertex;
        var footprint = select(0.0, dot(offset, offset) / previous_pdf, previous_pdf > 0.0);
        footprint = select(footprint, 1e30, (*path).lights_are_counted);
        let caustics = photon_radiance(m, interaction, wo, world_from_local, transmits, footprint, surface_index, seed);
        (*path).radiance += clamped((*path).throughput * caustics, surface_index);
    }
    var u = vec3f(sample_2d(leaving, pair + PAIR_SCATTER), 0.0);
    if CHOOSES_LOBES {
        u.z = sample_2d(leaving, pair + PAIR_LOBE).x;
    }
    let scattered = bsdf_sample(material_at(m).kind, m, wo, interaction.inside, u);
    if scattered.pdf < 0.0 {
        return false;
    }
    let direction = renormalized(world_from_local * scattered.wi);
    if SHADING_NORMALS && (scattered.wi.z < 0.0) != (dot(direction, interaction.normal) < 0.0) {
        return false;
    }
    (*path).throughput *= scattered.weight;
    if TRANSMISSION {
        (*path).index_square *= scattered.eta * scattered.eta;
    }
    if !survives(path, choice.y) {
        return false;
    }
    record_next_ray(m, wo, scattered.wi, interaction.inside, (*path).radiance);
    let is_transmission = TRANSMISSION && scattered.wi.z < 0.0;
    (*path).ray = Ray(spawn_origin(interaction, is_transmission), direction);
    if is_transmission {
        (*path).medium = medium_beyond_surface;
    }
    if FAST_CAUSTICS {
        (*path).lights_are_counted =
            scattered.pdf == 0.0 && scattered.wi.z < 0.0 && ((*path).lights_are_counted || (*path).scatter_pdf > 0.0);
    }
    if TRACED_CAUSTICS {
        (*path).met_photons = (*path).met_photons || !focuses;
        (*path).lights_are_counted = focuses && (*path).met_photons;
    }
    (*path).scatter_pdf = scattered.pdf;
    if INDIRECT_SAMPLES > 1u && surface_index == 0u {
        (*path).throughput /= f32(INDIRECT_SAMPLES);
        (*path).sampler = leaving;
    }
    (*path).surfaces += 1u;
    return true;
}

/// Film value of one sample of a pixel, with several rays that leave the first surface. A lane whose path has ended takes the next
/// of them, so that lanes do not wait for each other.
fn several_estimates(camera_path: Path) -> vec3f {
    var path = camera_path;
    if !path_intersect(&path) {
        return film_value(path.radiance);
    }
    let first = path;
    part = 0u;
    loop {
        if !path_scatter(&path) || !path_intersect(&path) {
            part++;
            if part >= INDIRECT_SAMPLES {
                break;
            }
            let radiance = path.radiance;
            path = first;
            path.radiance = radiance;
        }
    }
    return film_value(path.radiance);
}

/// Film value of one sample of a pixel.
fn estimate(camera: Ray, sampler: PixelSampler) -> vec3f {
    begin_guide(camera);
    var path = path_from(camera, sampler);
    if INDIRECT_SAMPLES > 1u {
        return several_estimates(path);
    }
    loop {
        let is_hit = path_intersect(&path);
        record_arrival(path.length);
        if !is_hit || !path_scatter(&path) {
            break;
        }
    }
    return film_value(path.radiance);
}
