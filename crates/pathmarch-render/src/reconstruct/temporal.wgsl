// import: reconstruct/history
// Reprojection and temporal accumulation. Twin of temporal.rs.

/// Divides the radiance of a film by the albedo, moves the points of the guides back to the earlier scene, and looks up the
/// objects of the guides.
@compute @workgroup_size(8, 8)
fn divide(@builtin(global_invocation_id) id: vec3u) {
    let position = vec2i(id.xy);
    if !is_inside(position) {
        return;
    }
    let pixel = pixel_index(position);
    let guide = guide_at(pixel);
    let rest = max(film_mean(id.xy, pixel) - guide.reflected, vec3f(0.0));
    let irradiance = min(rest / divisor(guide), vec3f(MAX_IRRADIANCE));
    estimates[pixel] = vec4f(irradiance, luminance(irradiance));
    store_earlier(pixel, guide.position, guide.normal);
    if guide.leaf != NO_LEAF && leaf_motions[guide.leaf].moves != 0u {
        let motion = leaf_motions[guide.leaf];
        let rows = mat3x3f(motion.x, motion.y, motion.z);
        let offset = vec3f(motion.offset_x, motion.offset_y, motion.offset_z);
        store_earlier(pixel, guide.position * rows * motion.scale + offset, guide.normal * rows);
    }
    if guide.object != GLOSSY_BIT - 1u {
        let flags = guides[4u * pixel + 2u].x & ~(GLOSSY_BIT - 1u);
        guides[4u * pixel + 2u].x = flags | leaf_motions[guide.object].object;
        guides[4u * pixel + 2u].y = leaf_motions[guide.seen_object].object
            | (guides[4u * pixel + 2u].y & (MIXED_BIT | COLOURED_BIT));
    }
}

/// Continues the means of the last picture.
@compute @workgroup_size(8, 8)
fn accumulate(@builtin(global_invocation_id) id: vec3u) {
    let position = vec2i(id.xy);
    if !is_inside(position) {
        return;
    }
    let pixel = pixel_index(position);
    let guide = guide_at(pixel);
    let irradiance = estimates[pixel].xyz;
    let alone = new_mean(irradiance, base_square(guide, luminance(irradiance)));
    history[pixel] = alone;
    if uniforms.max_history <= 0.0 {
        return;
    }
    let moved = earlier(guide, pixel);
    let place = project_before(moved.position);
    let found = mean_at(place, moved, coarser_pixel(guide), false);
    if found.length <= 0.0 {
        return;
    }
    var limits = vec2f(0.0, 3e38);
    if uniforms.scene_changed != 0u {
        limits = plausible_luminance(position);
    }
    var max_length = uniforms.max_history;
    if uniforms.camera_moves != 0u {
        if guide.is_glossy && guide.alpha == 0.0 {
            max_length = min(max_length, MAX_GLOSSY_HISTORY);
        } else if curvature(position, guide).y < f32(SMOOTH_NEIGHBOURS) {
            max_length = min(max_length, MAX_ROUGH_HISTORY);
        }
    }
    history[pixel] = joined(found, alone, limits, max_length);
}

/// Mean square of the luminance of samples without the light of facets, see mod.rs.
fn base_square(guide: Guide, mean_of_base: f32) -> f32 {
    if guide.alpha == 0.0 {
        return guide.square;
    }
    let all = divisor(guide);
    let of_facets = reflection_divisor(guide);
    let unit = luminance(of_facets / all);
    let mean = mean_of_base + luminance(guide.reflected / all);
    let variance = max(guide.square - mean * mean, 0.0);
    let mean_of_facets = luminance(guide.reflected / of_facets);
    let variance_of_facets = max(guide.reflected_square - mean_of_facets * mean_of_facets, 0.0) * unit * unit;
    return mean_of_base * mean_of_base + max(variance - variance_of_facets, LEAST_BASE_VARIANCE * variance);
}

/// Least and largest luminance that the mean of a pixel may have, judged from the samples around it.
fn plausible_luminance(position: vec2i) -> vec2f {
    var sum = vec2f(0.0);
    var count = 0.0;
    for (var y = -PLAUSIBLE_RADIUS; y <= PLAUSIBLE_RADIUS; y++) {
        for (var x = -PLAUSIBLE_RADIUS; x <= PLAUSIBLE_RADIUS; x++) {
            let place = position + vec2i(x, y);
            if is_inside(place) {
                let l = luminance(estimates[pixel_index(place)].xyz);
                sum += vec2f(l, l * l);
                count += 1.0;
            }
        }
    }
    let mean = sum.x / count;
    let reach = PLAUSIBLE_REACH * sqrt(max(sum.y / count - mean * mean, 0.0));
    return vec2f(max(mean - reach, 0.0), mean + reach);
}
