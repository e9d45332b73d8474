// Opacity of triangles. Twin of opacity.rs, which explains it.

fn opacity_hash(value: u32) -> u32 {
    let state = value * 747796405u + 2891336453u;
    let word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}

/// Hash of a ray.
fn ray_seed(origin: vec3f, direction: vec3f) -> u32 {
    let o = bitcast<vec3u>(origin);
    let d = bitcast<vec3u>(direction);
    var state = opacity_hash(opacity_hash(opacity_hash(o.x) ^ o.y) ^ o.z);
    state = opacity_hash(state ^ d.x);
    state = opacity_hash(state ^ d.y);
    return opacity_hash(state ^ d.z);
}

/// Texel of a row of `count` that a position stands for.
fn alpha_texel(position: i32, count: i32, wrap: u32) -> u32 {
    let twice = ((position % (2 * count)) + 2 * count) % (2 * count);
    let mirrored = select(min(twice, 2 * count - 1 - twice), clamp(position, 0, count - 1), wrap == 2u);
    return u32(select(mirrored, ((position % count) + count) % count, wrap == 0u));
}

/// Alpha of a texel of the texture at this offset.
fn alpha_at_texel(texture: u32, index: u32) -> f32 {
    return f32((mesh_word(texture + 9u + (index >> 2u)) >> (8u * (index & 3u))) & 0xffu) / 255.0;
}

/// Alpha of the texture at this offset for a point of a triangle, bilinear.
fn alpha_of_texture(texture: u32, surface_offset: u32, triangle: u32, weights: vec2f) -> f32 {
    let width = mesh_word(texture);
    let height = mesh_word(texture + 1u);
    let modes = mesh_word(texture + 2u);
    let uvs = triangle_uvs(surface_offset, triangle, (modes >> 5u) & 1u);
    let uv = vec3f(uvs[0] + uvs[1] * weights.x + uvs[2] * weights.y, 1.0);
    let place = vec2f(dot(uv, mesh_vector(texture + 3u)), dot(uv, mesh_vector(texture + 6u)));
    // Larger coordinates are not told apart.
    let at = clamp(place, vec2f(-1e4), vec2f(1e4)) * vec2f(f32(width), f32(height)) - 0.5;
    let corner = floor(at);
    let part = select(at - corner, floor(at - corner + 0.5), (modes & 16u) != 0u);
    let first = vec2i(corner);
    let x0 = alpha_texel(first.x, i32(width), modes & 3u);
    let x1 = alpha_texel(first.x + 1, i32(width), modes & 3u);
    let y0 = width * alpha_texel(first.y, i32(height), (modes >> 2u) & 3u);
    let y1 = width * alpha_texel(first.y + 1, i32(height), (modes >> 2u) & 3u);
    let upper = mix(alpha_at_texel(texture, y0 + x0), alpha_at_texel(texture, y0 + x1), part.x);
    let lower = mix(alpha_at_texel(texture, y1 + x0), alpha_at_texel(texture, y1 + x1), part.x);
    return mix(upper, lower, part.y);
}

/// Reports whether a ray with this hash hits a triangle rather than passes it. `weights` are those of its second and third
/// corner.
fn is_present(opacity: u32, surface_offset: u32, triangle: u32, weights: vec2f, is_back: bool, seed: u32) -> bool {
    if opacity == 0u {
        return true;
    }
    let materials = mesh_word(surface_offset + 6u);
    var record = opacity;
    if materials != 0u {
        record += OPACITY_WORDS * mesh_word(materials + triangle);
    }
    let flags = mesh_word(record);
    if (flags & 4u) != 0u && is_back {
        return false;
    }
    if (flags & 3u) == 0u {
        return true;
    }
    var alpha = mesh_float(record + 1u) * triangle_colour(surface_offset, triangle, weights).w;
    let texture = mesh_word(record + 3u);
    if texture != 0u {
        alpha *= alpha_of_texture(texture, surface_offset, triangle, weights);
    }
    var threshold = mesh_float(record + 2u);
    if (flags & 3u) == 2u {
        threshold = (f32(opacity_hash(seed ^ triangle) >> 8u) + 1.0) / 16777216.0;
    }
    return alpha >= threshold;
}
