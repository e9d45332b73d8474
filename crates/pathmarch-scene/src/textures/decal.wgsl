// Pictures that are projected once. Twin of decal.rs, which explains them.

/// Colour times alpha, and alpha, of a texel.
fn decal_texel(picture: TexturePicture, index: u32) -> vec4f {
    let alpha = f32(scene_word(picture.at + index) >> 24u) / 255.0;
    return vec4f(picture_texel(picture, index) * alpha, alpha);
}

fn decal_bilinear(picture: TexturePicture, level: u32, place: vec2f) -> vec4f {
    let mip = picture_level(picture, level);
    let at = vec2f(place.x * f32(mip.width), (1.0 - place.y) * f32(mip.height)) - 0.5;
    let corner = floor(at);
    let part = at - corner;
    let last = vec2f(f32(mip.width - 1u), f32(mip.height - 1u));
    let near = vec2u(clamp(corner, vec2f(0.0), last));
    let far = vec2u(clamp(corner + 1.0, vec2f(0.0), last));
    let y0 = mip.start + mip.width * near.y;
    let y1 = mip.start + mip.width * far.y;
    let upper = mix(decal_texel(picture, y0 + near.x), decal_texel(picture, y0 + far.x), part.x);
    let lower = mix(decal_texel(picture, y1 + near.x), decal_texel(picture, y1 + far.x), part.x);
    return mix(upper, lower, part.y);
}

/// Mean of the picture around a place, over `texels` texels.
fn decal_filtered(picture: TexturePicture, texels: f32, place: vec2f) -> vec4f {
    let last = picture.levels - 1u;
    let level = min(log2(max(texels, 1.0)), f32(last));
    let first = floor(level);
    let fine = decal_bilinear(picture, min(u32(first), last), place);
    if level == first {
        return fine;
    }
    return mix(fine, decal_bilinear(picture, min(u32(first) + 1u, last), place), level - first);
}

/// Colour times alpha, and alpha, of a decal at a spot in its coordinates.
fn decal_at(picture: TexturePicture, spot: Spot, size: f32, depth: f32, min_cosine: f32, opacity: f32) -> vec4f {
    let scale = vec2f(1.0, f32(picture.width) / f32(picture.height)) / size;
    let place = spot.p.xy * scale + 0.5;
    let is_outside = any(place < vec2f(0.0)) || any(place > vec2f(1.0));
    if is_outside || abs(spot.p.z) > 0.5 * depth || spot.normal.z <= min_cosine {
        return vec4f(0.0);
    }
    return decal_filtered(picture, spot.footprint * f32(picture.width) / size, place) * opacity;
}
