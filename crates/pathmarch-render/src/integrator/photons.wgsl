// import: integrator/light_sampling, shading/surface_interaction, textures
// Light that surfaces reflect of photons. Twin of scene/photon_map.rs, which explains it.

/// True if light paths start at a light.
fn starts_light_paths(light: Light) -> bool {
    if (HAS_BOUNDED && light.kind == BOUNDED) || (HAS_ENVIRONMENT && light.kind == ENVIRONMENT) {
        return false;
    }
    let is_object = light.kind != POINT && light.kind != SPOT && light.kind != SUN;
    return !(is_object && (leaf_at(light.leaf).flags & IN_GLASS) != 0u);
}

fn decoded_direction(code: f32, codes: f32) -> vec3f {
    let y_code = floor(code / (codes + 1.0));
    let x = (code - y_code * (codes + 1.0)) / codes * 2.0 - 1.0;
    let y = y_code / codes * 2.0 - 1.0;
    let z = 1.0 - abs(x) - abs(y);
    let folded = max(-z, 0.0);
    return normalize(vec3f(x - select(-folded, folded, x >= 0.0), y - select(-folded, folded, y >= 0.0), z));
}

/// Radius of a photon at `p`, metres, for the header of its grid.
fn photon_radius(p: vec3f, header: vec4f) -> f32 {
    return max(header.x * distance(p, frame.position), header.y * largest(abs(p)));
}

/// Level of the smallest cells that are wider than two radii.
fn photon_level(radius: f32) -> i32 {
    return i32(bitcast<u32>(2.0 * radius) >> 23u) - 126;
}

fn photon_cell(p: vec3f, level: i32) -> vec3i {
    return vec3i(floor(p * exp2(-f32(level))));
}

/// Radiance that a surface reflects of the photons around it.
fn photon_radiance(
    m: u32,
    interaction: SurfaceInteraction,
    wo: vec3f,
    world_from_local: mat3x3f,
    transmits: bool,
    footprint: f32,
    surface_index: u32,
    seed: u32,
) -> vec3f {
    let p = interaction.p;
    let normal = interaction.normal;
    let blurred = photon_radius(p, scene_vector(PHOTON_DATA + 1u));
    // Radius divided by the distance from the camera, smallest radius divided by the largest coordinate, number of slots, and
    // offset of the first.
    let header = scene_vector(PHOTON_DATA + select(0u, 1u, footprint > blurred * blurred));
    let mask = u32(header.z) - 1u;
    let slots = PHOTON_DATA + u32(header.w);
    let radius = photon_radius(p, header);
    let margin = 1.0 + 1.5 * header.x;
    let reach = radius * margin;
    let last_level = photon_level(reach);
    var sum = vec3f(0.0);
    for (var level = photon_level(radius / margin); level <= last_level; level++) {
        let low = photon_cell(p - reach, level);
        let high = photon_cell(p + reach, level);
        let size = high - low + vec3i(1);
        for (var k = 0; k < size.x * size.y * size.z; k++) {
            let cell = low + vec3i(k % size.x, k / size.x % size.y, k / (size.x * size.y));
            let words = vec3u(cell);
            let place = hash(words.x ^ hash(words.y ^ hash(words.z ^ (u32(level) * 0x9e3779b9u))));
            let key = f32(hash(place ^ words.x) >> 8u);
            var slot = place & mask;
            var range = scene_vector(slots + slot);
            while range.y > 0.0 && range.z != key {
                slot = (slot + 1u) & mask;
                range = scene_vector(slots + slot);
            }
            let count = u32(range.y);
            if count == 0u {
                continue;
            }
            let stride = (count + MAX_VISITS - 1u) / MAX_VISITS;
            let first_photon = slots + mask + 1u + PHOTON_VECTORS * u32(range.x);
            var part = vec3f(0.0);
            for (var index = hash(seed ^ place) % stride; index < count; index += stride) {
                let at = scene_vector(first_photon + PHOTON_VECTORS * index);
                let offset = at.xyz - p;
                let photon_reach = photon_radius(at.xyz, header);
                let height = dot(offset, normal);
                let share = (dot(offset, offset) - height * height) / (photon_reach * photon_reach);
                if share >= 1.0 || abs(height) > photon_reach {
                    continue;
                }
                let carried = scene_vector(first_photon + PHOTON_VECTORS * index + 1u);
                let code = u32(carried.w);
                if ((code >> 16u) & 15u) + surface_index > frame.bounces {
                    continue;
                }
                let alignment = dot(decoded_direction(f32(code & 0xffffu), NORMAL_CODES), normal);
                if abs(alignment) < LEAST_NORMAL_COSINE || (alignment < 0.0 && !transmits) {
                    continue;
                }
                let direction = decoded_direction(at.w, DIRECTION_CODES);
                let wi = direction * world_from_local;
                let cosine = dot(direction, normal);
                let crosses_surface = SHADING_NORMALS && (wi.z < 0.0) != (cosine < 0.0);
                if (wi.z > 0.0 || transmits) && !crosses_surface {
                    let kernel = 2.0 * (1.0 - max(share, 0.0)) / (3.14159265 * photon_reach * photon_reach);
                    let evaluated = bsdf_eval(material_at(m).kind, m, wo, wi, interaction.inside);
                    part += evaluated.xyz * carried.xyz * (kernel / max(abs(cosine), LEAST_INCIDENCE));
                }
            }
            sum += part * f32(stride);
        }
    }
    return sum;
}
