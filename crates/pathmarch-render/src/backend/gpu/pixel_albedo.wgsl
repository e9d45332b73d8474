// import: backend/gpu/buffers, integrator/guide, integrator/light_sampling, guides, sampler, sampling/r2_point
// import: textures, texture_target
// Entry point: albedos of the pixels of a live picture, in place of the film; 1 in w where it is not that of the samples. Twin
// of pixel_albedo.rs, which explains them.

/// Albedo of the samples of a pixel.
fn sampled_albedo(pixel: u32) -> vec3f {
    return bitcast<vec3f>(vec3u(guides[4u * pixel + 1u].zw, guides[4u * pixel + 2u].w));
}

/// True if the samples of two neighbouring pixels show different parts of one texture.
fn differ(here: u32, beside: u32) -> bool {
    return guides[4u * here + 2u].z == guides[4u * beside + 2u].z
        && colours_differ(sampled_albedo(here), sampled_albedo(beside), ALBEDO_CONTRAST);
}

/// True if the texture of a pixel may be finer than it is.
fn has_fine_texture(pixel: u32) -> bool {
    let words = guides[4u * pixel + 2u];
    let is_surface = (words.x >> CLASS_SHIFT) == GUIDE_SURFACE && (words.y & MIXED_BIT) == 0u;
    if !is_surface || (words.z & MIRROR_BIT) != 0u || (leaf_at(words.z).flags & TEXTURED_IN_SPACE) == 0u {
        return false;
    }
    let size = vec2i(i32(frame.width), i32(frame.height));
    let here = vec2i(i32(pixel) % size.x, i32(pixel) / size.x);
    var differs = false;
    for (var k = 0; k < 9; k++) {
        let beside = here + vec2i(k % 3 - 1, k / 3 - 1);
        if all(beside >= vec2i(0)) && all(beside < size) {
            differs = differs || differ(pixel, u32(beside.y * size.x + beside.x));
        }
    }
    return differs;
}

@compute @workgroup_size(64)
fn trace(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    load_frame();
    let size = vec2u(slice.columns, slice.rows);
    let pixel = ALBEDOS_PER_GROUP * (group.y * MAX_GROUPS_ACROSS + group.x) + lane;
    if pixel >= size.x * size.y {
        return;
    }
    let samples = vec2u(frame.width, frame.height);
    let corner = vec2f(f32(pixel % size.x), f32(pixel / size.x));
    let sample_position = min(vec2u((corner + 0.5) / (vec2f(size) / vec2f(samples))), samples - 1u);
    let sample = sample_position.y * samples.x + sample_position.x;
    if !has_fine_texture(sample) {
        store_film(pixel, vec4f(0.0));
        return;
    }
    let position = bitcast<vec3f>(guides[4u * sample].xyz);
    let normal = from_octahedral(unpack2x16snorm(guides[4u * sample + 1u].x));
    let leaf = guides[4u * sample + 2u].z;
    let towards = position - frame.position;
    let start = hash(pixel);
    // Samples of an enlarged picture are those of several pixels.
    let count = select(0.0, f32(slice.samples), all(size == samples));
    let sampled = sampled_albedo(sample);
    var sum = vec4f(sampled * count, count);
    for (var k = 0u; k < ALBEDO_POINTS; k++) {
        let point = r2_point(slice.sample * ALBEDO_POINTS + k, vec2u(start, hash(start)));
        let place = (point + corner) * (2.0 / vec2f(size));
        let view = frame.forward + frame.right * (place.x - 1.0) + frame.up * (1.0 - place.y);
        let scale = dot(towards, normal) / dot(view, normal);
        // Nothing is beyond the horizon.
        if scale > 0.0 && length(view) * scale < ALBEDO_REACH * frame.far {
            let p = frame.position + view * scale;
            let m = leaf_at(leaf).material;
            evaluate_textures(m, SurfaceInteraction(p, leaf, normal, false, NO_TRIANGLE, false, 0.0), length(towards));
            sum += vec4f(packed(m, 0u).xyz, 1.0);
        }
    }
    store_film(pixel, vec4f(select(sampled, sum.xyz / max(sum.w, 1.0), sum.w > 0.0), 1.0));
}
