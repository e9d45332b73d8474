// Pictures at the texture coordinates of meshes. Twin of uv.rs in the crate of scenes, which explains them.

/// Leaf, triangle and local point of the interaction that is being textured.
var<private> uv_leaf: u32;
var<private> uv_triangle: u32;
var<private> uv_point: vec3f;

/// Starts the evaluation of textures at a point in the coordinates of a leaf.
fn begin_uvs(leaf: u32, triangle: u32, local: vec3f) {
    uv_leaf = leaf;
    uv_triangle = triangle;
    uv_point = local;
}

/// Tangent of the triangle at the point that is being textured, in the coordinates of the leaf, and sign of the bitangent.
fn uv_tangent() -> vec4f {
    if uv_triangle == NO_TRIANGLE {
        return vec4f(0.0);
    }
    return mesh_tangent(uv_leaf, uv_triangle, uv_point);
}

/// Texel of a row of `count` that a position stands for.
fn uv_texel(position: i32, count: i32, wrap: u32) -> u32 {
    let twice = ((position % (2 * count)) + 2 * count) % (2 * count);
    let mirrored = select(min(twice, 2 * count - 1 - twice), clamp(position, 0, count - 1), wrap == 2u);
    return u32(select(mirrored, ((position % count) + count) % count, wrap == 0u));
}

/// Bilinear colour of a level; `modes` are the wrap modes, and a bit for texels that are not interpolated.
fn uv_bilinear(picture: TexturePicture, level: u32, place: vec2f, modes: u32) -> vec3f {
    let mip = picture_level(picture, level);
    let at = place * vec2f(f32(mip.width), f32(mip.height)) - 0.5;
    let corner = floor(at);
    let part = select(at - corner, floor(at - corner + 0.5), (modes & 16u) != 0u);
    let first = vec2i(corner);
    let x0 = uv_texel(first.x, i32(mip.width), modes & 3u);
    let x1 = uv_texel(first.x + 1, i32(mip.width), modes & 3u);
    let y0 = mip.start + mip.width * uv_texel(first.y, i32(mip.height), (modes >> 2u) & 3u);
    let y1 = mip.start + mip.width * uv_texel(first.y + 1, i32(mip.height), (modes >> 2u) & 3u);
    let upper = mix(picture_texel(picture, y0 + x0), picture_texel(picture, y0 + x1), part.x);
    let lower = mix(picture_texel(picture, y1 + x0), picture_texel(picture, y1 + x1), part.x);
    return mix(upper, lower, part.y);
}

/// Colour (xyz) and value (w) of the picture at offset `texture`, for a footprint in the coordinates of the leaf.
fn uv_picture(texture: u32, picture: TexturePicture, footprint: f32) -> vec4f {
    let flags = scene_word(texture + TEXTURE_PARAMETERS + 7u);
    var uv = vec3f(0.0);
    if uv_triangle != NO_TRIANGLE {
        uv = mesh_uv(uv_leaf, uv_triangle, uv_point, flags & 1u);
    }
    let rows = mat2x3f(texture_vector(texture + TEXTURE_ROWS), texture_vector(texture + TEXTURE_ROWS + 3u));
    // Larger coordinates are not told apart.
    let place = clamp(vec3f(uv.xy, 1.0) * rows, vec2f(-1e4), vec2f(1e4));
    let texels = footprint * uv.z * texture_number(texture + TEXTURE_PARAMETERS + 4u) * f32(max(picture.width, picture.height));
    let last = picture.levels - 1u;
    let level = min(log2(max(texels, 1.0)), f32(last));
    let first = floor(level);
    let modes = scene_word(texture + TEXTURE_PARAMETERS + 6u);
    var colour = uv_bilinear(picture, u32(first), place, modes);
    if level != first {
        colour = mix(colour, uv_bilinear(picture, min(u32(first) + 1u, last), place, modes), level - first);
    }
    colour *= texture_vector(texture + TEXTURE_ROWS + 6u);
    if (flags & 8u) != 0u && uv_triangle != NO_TRIANGLE {
        colour *= mesh_colour(uv_leaf, uv_triangle, uv_point).xyz;
    }
    var value = dot(colour, vec3f(0.2126, 0.7152, 0.0722));
    let channel = (flags >> 1u) & 3u;
    if channel != 0u {
        value = colour[channel - 1u];
    }
    return vec4f(colour, clamp(value, 0.0, 1.0));
}
