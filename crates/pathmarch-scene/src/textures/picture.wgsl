// Pictures on surfaces. Twin of picture.rs, which explains them.

struct TexturePicture {
    /// Where its texels start in the tables.
    at: u32,
    width: u32,
    height: u32,
    levels: u32,
    /// Whether its codes are sRGB.
    encoded: bool,
}

fn picture_texel(picture: TexturePicture, index: u32) -> vec3f {
    let word = scene_word(picture.at + index);
    let codes = vec3f(f32(word & 255u), f32((word >> 8u) & 255u), f32((word >> 16u) & 255u)) / 255.0;
    let bright = pow((codes + 0.055) / 1.055, vec3f(2.4));
    return select(codes, select(bright, codes / 12.92, codes <= vec3f(0.04045)), picture.encoded);
}

fn wrapped_texel(v: f32, count: u32) -> u32 {
    let n = i32(count);
    return u32(((i32(v) % n) + n) % n);
}

/// A level of a picture: its first texel, relative to that of the picture, and its size.
struct PictureLevel {
    start: u32,
    width: u32,
    height: u32,
}

fn picture_level(picture: TexturePicture, level: u32) -> PictureLevel {
    var found = PictureLevel(0u, picture.width, picture.height);
    for (var k = 0u; k < level; k++) {
        found.start += found.width * found.height;
        found.width = max(found.width / 2u, 1u);
        found.height = max(found.height / 2u, 1u);
    }
    return found;
}

fn picture_bilinear(picture: TexturePicture, level: u32, place: vec2f) -> vec3f {
    let mip = picture_level(picture, level);
    let inside = place - floor(place);
    let at = vec2f(inside.x * f32(mip.width), (1.0 - inside.y) * f32(mip.height)) - 0.5;
    let corner = floor(at);
    let part = at - corner;
    let x0 = wrapped_texel(corner.x, mip.width);
    let x1 = wrapped_texel(corner.x + 1.0, mip.width);
    let y0 = mip.start + mip.width * wrapped_texel(corner.y, mip.height);
    let y1 = mip.start + mip.width * wrapped_texel(corner.y + 1.0, mip.height);
    let upper = mix(picture_texel(picture, y0 + x0), picture_texel(picture, y0 + x1), part.x);
    let lower = mix(picture_texel(picture, y1 + x0), picture_texel(picture, y1 + x1), part.x);
    return mix(upper, lower, part.y);
}

fn picture_filtered(picture: TexturePicture, level: f32, place: vec2f) -> vec3f {
    let first = floor(level);
    let last = picture.levels - 1u;
    let fine = picture_bilinear(picture, min(u32(first), last), place);
    if level == first {
        return fine;
    }
    return mix(fine, picture_bilinear(picture, min(u32(first) + 1u, last), place), level - first);
}

fn picture_projected(picture: TexturePicture, spot: Spot, size: f32) -> vec3f {
    let texel = size / f32(picture.width);
    let level = min(log2(max(spot.footprint / texel, 1.0)), f32(picture.levels - 1u));
    let scale = vec2f(1.0, f32(picture.width) / f32(picture.height)) / size;
    let n = spot.normal;
    let fourth = (n * n) * (n * n);
    let powers = fourth * fourth;
    let weights = powers / max(powers.x + powers.y + powers.z, 1e-30);
    let side = select(vec3f(1.0), vec3f(-1.0), n < vec3f(0.0));
    let p = spot.p;
    var sum = vec3f(0.0);
    if weights.x > 1e-3 {
        sum += picture_filtered(picture, level, vec2f(-side.x * p.z, p.y) * scale) * weights.x;
    }
    if weights.y > 1e-3 {
        sum += picture_filtered(picture, level, vec2f(p.x, -side.y * p.z) * scale) * weights.y;
    }
    if weights.z > 1e-3 {
        sum += picture_filtered(picture, level, vec2f(side.z * p.x, p.y) * scale) * weights.z;
    }
    return sum;
}
