// import: guides, integrator/light_sampling, integrator/sky, media, nested_dielectrics, photons, sampler
// import: shading/surface_interaction, textures
// State of a path on its way from the camera, and the light that it meets. Twin of path_state.rs.

/// Contribution of light after this many bounces; that of indirect light is clamped to the limit of the frame.
fn clamped(contribution: vec3f, bounces: u32) -> vec3f {
    if !CLAMPS || bounces == 0u {
        return contribution;
    }
    return contribution * (frame.clamp / max(largest(contribution), frame.clamp));
}

/// Path at its current hit: `ray.origin` is the hit point.
struct Path {
    ray: Ray,
    sampler: PixelSampler,
    /// Point that the light at the previous surface was sampled from, in world space.
    previous_vertex: vec3f,
    /// Shading normal of the previous surface; zero if it transmits, so that light arrives on both sides.
    previous_normal: vec3f,
    radiance: vec3f,
    throughput: vec3f,
    /// Length from the camera, metres.
    length: f32,
    /// Pdf of the ray's direction over solid angle; 0 for a delta distribution.
    scatter_pdf: f32,
    /// Medium around the path.
    medium: Medium,
    /// True if others have contributed the lights that the ray hits, see path_state.rs.
    lights_are_counted: bool,
    /// True if the path met photons where it last scattered at anything but a focusing surface.
    met_photons: bool,
    /// Square of the refractive index around the path.
    index_square: f32,
    /// Wavelength, nanometres; 0 before the first surface that disperses.
    wavelength: f32,
    /// Number of surfaces at which the path was scattered.
    surfaces: u32,
    interaction: SurfaceInteraction,
    /// True at a scattering event in a medium.
    is_in_medium: bool,
}

/// Path that starts with a camera ray.
fn path_from(camera: Ray, sampler: PixelSampler) -> Path {
    var path: Path;
    path.ray = camera;
    path.sampler = sampler;
    path.previous_vertex = camera.origin;
    path.throughput = vec3f(1.0);
    path.medium = camera_medium();
    path.index_square = camera_index_square();
    return path;
}

/// Adds light that the surface at an interaction of a path emits.
fn add_emission(path: ptr<function, Path>, interaction: SurfaceInteraction, emission: vec3f) {
    let leaf = leaf_at(interaction.leaf);
    let light = light_of_triangle(leaf.flags >> LIGHT_SHIFT, interaction.triangle);
    // Shadow rays or photons have already contributed it.
    var counted = (FAST_CAUSTICS || TRACED_CAUSTICS) && (*path).lights_are_counted && light > 0u;
    if TRACED_CAUSTICS && counted {
        counted = starts_light_paths(light_at(light - 1u));
    }
    if !emits_towards(interaction.leaf, interaction.normal) || counted {
        return;
    }
    var weight = 1.0;
    if TRANSMISSION && interaction.inside && (leaf.flags & IN_GLASS) != 0u {
        weight = (*path).index_square;
    } else if HAS_SURFACE_LIGHTS && light > 0u && (*path).scatter_pdf > 0.0 {
        let cosine = abs(dot(interaction.normal, (*path).ray.direction));
        let vertex = (*path).previous_vertex;
        let record = light_from(light - 1u, vertex, (*path).previous_normal);
        weight = hit_weight((*path).scatter_pdf, light_pdf(record, vertex, (*path).ray.origin, cosine));
    }
    // Light that a ray hits counts as direct light of the previous surface.
    (*path).radiance += clamped((*path).throughput * emission * weight, max((*path).surfaces, 1u) - 1u);
}

/// Adds light of the sky and the suns to a path that hits nothing.
fn add_escaped_radiance(path: ptr<function, Path>) {
    // Light that a ray hits counts as direct light of the previous surface.
    let bounces = max((*path).surfaces, 1u) - 1u;
    let direction = (*path).ray.direction;
    if TRACED_CAUSTICS && (*path).lights_are_counted {
        (*path).radiance += clamped((*path).throughput * sky_radiance(direction, (*path).scatter_pdf), bounces);
    } else if !(FAST_CAUSTICS && (*path).lights_are_counted) {
        let escaped_radiance = sky_radiance(direction, (*path).scatter_pdf) + sun_radiance(direction, (*path).scatter_pdf);
        (*path).radiance += clamped((*path).throughput * escaped_radiance, bounces);
    } else {
        (*path).radiance += clamped((*path).throughput * unsampled_sky_radiance(direction), bounces);
    }
}

/// Moves a path to its hit and adds light that the surface emits. Returns false if the path ends.
fn arrive(path: ptr<function, Path>, hit: Hit) -> bool {
    let ray = (*path).ray;
    (*path).length += hit.t;
    let hit_point = ray.origin + ray.direction * hit.t;
    (*path).ray.origin = hit_point;
    let interaction = surface_interaction(ray, hit, unstratified_seed((*path).sampler, (*path).surfaces));
    (*path).interaction = interaction;
    let m = leaf_at(interaction.leaf).material;
    if HAS_EMITTERS && (material_at(m).flags & EMITS) != 0u {
        record_guide(interaction, (*path).throughput, (*path).length, (*path).surfaces, material_at(m).emission);
        add_emission(path, interaction, material_at(m).emission);
        return false;
    }
    return (*path).surfaces <= frame.bounces || (HAS_GLOW && (material_at(m).flags & GLOWS) != 0u);
}
