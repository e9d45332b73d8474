// import: backend/gpu/film, guides, integrator/camera_ray_index, integrator/path
// Samples of the pixels of a tile, which share the light at second surfaces. Twin of path_reuse.rs, which explains it.

/// Second surface of a path; a path without one has no normal.
struct SecondSurface {
    p: vec3f,
    /// Distance from `p` along `normal` to the origin of rays that leave the surface, metres.
    offset: f32,
    /// Unit normal on the side of the first surface.
    normal: vec3f,
    /// Radiance that leaves the surface, later divided by the density with which the group samples it.
    radiance: vec3f,
}

/// Second surfaces of each pixel of the tile: those of its paths, as many as share a camera ray.
var<workgroup> second_surfaces: array<SecondSurface, SPLITTING * REUSE_TILE * REUSE_TILE>;
/// Densities over area with which each pixel samples the second surfaces of the pixels of its group, 1/m².
var<workgroup> densities: array<f32, GROUP * REUSE_TILE * REUSE_TILE>;

/// Place of a pixel in the memory of its tile: group by group, and row by row in a group.
fn place_in_tile(pixel: vec2u) -> u32 {
    let group = interleaved_group(pixel);
    let block = pixel % REUSE_TILE / 2u;
    return GROUP * (2u * group.y + group.x) + REUSE_TILE / 2u * block.y + block.x;
}

/// True if the camera hit of a path is on an opaque surface that is no mirror, and not seen through a medium.
fn shares(path: Path) -> bool {
    let flags = material_at(leaf_at(path.interaction.leaf).material).flags;
    return (flags & (DELTA | TRANSMITS)) == 0u && (!ABSORPTION || all(absorption_of(path.medium) == vec3f(0.0)));
}

/// Adds the film values of the slice's samples of a pixel to those before. All invocations of the workgroup call it at once,
/// also those of pixels outside the picture.
fn add_shared_samples(before: vec4f, x: u32, y: u32, is_inside: bool) -> vec4f {
    let own_place = place_in_tile(vec2u(x, y));
    let own_index = own_place % GROUP;
    let first_of_group = own_place - own_index;
    let first_second_surface = SPLITTING * own_place;
    for (var k = 0u; k < SPLITTING; k++) {
        second_surfaces[first_second_surface + k].normal = vec3f(0.0);
    }
    var sum = vec4f(0.0);
    var first_path: Path;
    var is_shared = false;
    if is_inside {
        let sampler = pixel_sampler(x, y, camera_ray_index(slice.sample), frame.seed);
        let camera = camera_ray(x, y, sampler);
        begin_guide(camera);
        first_path = path_from(camera, sampler);
        if path_intersect(&first_path) {
            is_shared = shares(first_path);
            sum += trace_paths(first_path, is_shared, first_second_surface);
        } else {
            sum += f32(slice.samples) * kept(film_value(first_path.radiance));
        }
    }
    let interaction = first_path.interaction;
    let material = leaf_at(interaction.leaf).material;
    if is_shared {
        evaluate_textures(material, interaction, first_path.length);
    }
    let world_from_local = basis(interaction.normal);
    let wo_unclamped = -first_path.ray.direction * world_from_local;
    let wo = vec3f(wo_unclamped.xy, max(abs(wo_unclamped.z), 1e-5));
    let origin = spawn_origin(interaction, false);
    // No constant, so that compilers do not unroll the loops.
    let group_size = GROUP * min(slice.samples, 1u);
    var shared_radiance = vec3f(0.0);
    workgroupBarrier();
    for (var k = 0u; k < slice.samples; k++) {
        // Connections with the second surfaces of the group: density, and BSDF times both cosines over the square of the distance.
        var values: array<vec3f, GROUP>;
        for (var index = 0u; index < group_size; index++) {
            let second = second_surfaces[SPLITTING * (first_of_group + index) + k];
            let offset = second.p - interaction.p;
            let square = dot(offset, offset);
            let direction = offset / sqrt(square);
            let wi = direction * world_from_local;
            let cosine = -dot(direction, second.normal);
            var connection = vec4f(0.0);
            if is_shared && square > 0.0 && wi.z > 0.0 && cosine > 0.0 {
                connection = bsdf_eval(material_at(material).kind, material, wo, wi, interaction.inside) * (cosine / square);
            }
            if connection.w > 0.0 && index != own_index {
                let segment = second.p + second.normal * second.offset - origin;
                let distance = length(segment);
                if march(Ray(origin, segment / distance), first_path.length, distance).t >= 0.0 {
                    connection = vec4f(0.0);
                }
            }
            values[index] = connection.xyz;
            densities[GROUP * own_place + index] = connection.w;
        }
        workgroupBarrier();
        var density = 0.0;
        for (var index = 0u; index < group_size; index++) {
            density += densities[GROUP * (first_of_group + index) + own_index];
        }
        if density > 0.0 {
            second_surfaces[first_second_surface + k].radiance /= density;
        }
        workgroupBarrier();
        for (var index = 0u; index < group_size; index++) {
            if any(values[index] > vec3f(0.0)) {
                shared_radiance +=
                    values[index] * second_surfaces[SPLITTING * (first_of_group + index) + k].radiance;
            }
        }
    }
    sum += kept(shared_radiance);
    if is_inside {
        record_shared(shared_radiance);
        store_guide(y * frame.width + x, sum.xyz);
    }
    return before + sum;
}

/// Traces the slice's samples of a pixel from its camera hit on. Returns the sum of their film values, but for the light that
/// leaves second surfaces, which it stores with them.
fn trace_paths(first_path: Path, is_shared: bool, first_second_surface: u32) -> vec4f {
    var sum = vec4f(0.0);
    var samples_done = 0u;
    var path = first_path;
    path.sampler.sample = slice.sample;
    var second: SecondSurface;
    var radiance_before = vec3f(0.0);
    // A lane whose path has ended takes the next path of its pixel, so that lanes do not wait for each other.
    loop {
        var goes_on = path_scatter(&path);
        if goes_on {
            goes_on = path_intersect(&path);
            record_arrival(path.length);
        }
        if goes_on {
            let material = leaf_at(path.interaction.leaf).material;
            let flags = material_at(material).flags;
            if is_shared && path.surfaces == 1u && (flags & (LAMBERTIAN | GLOWS)) == LAMBERTIAN {
                let interaction = path.interaction;
                second = SecondSurface(interaction.p, interaction.offset, interaction.normal, vec3f(0.0));
                record_scattering(material, 1u, path.radiance);
                radiance_before = path.radiance;
                path.radiance = vec3f(0.0);
                path.throughput = vec3f(1.0);
            }
            continue;
        }
        if any(second.normal != vec3f(0.0)) {
            second.radiance = path.radiance;
            second_surfaces[first_second_surface + samples_done] = second;
            path.radiance = radiance_before;
            second.normal = vec3f(0.0);
        }
        sum += kept(film_value(path.radiance));
        samples_done++;
        if samples_done >= slice.samples {
            break;
        }
        path = first_path;
        path.sampler.sample = slice.sample + samples_done;
    }
    return sum;
}
