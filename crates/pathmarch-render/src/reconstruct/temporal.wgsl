// import: reconstruct/direct, reconstruct/history
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
    let irradiance = direct_irradiance(id.xy, pixel, guide);
    estimates[pixel] = vec4f(irradiance, luminance(irradiance));
    earlier_points[pixel] = earlier_words(moved_back(guide));
    if guide.object != OBJECT_BITS {
        let flags = guides[4u * pixel + 2u].x & ~OBJECT_BITS;
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
    let alone = new_mean(irradiance, direct_square(guide, luminance(irradiance)));
    history[pixel] = alone;
    if uniforms.max_history <= 0.0 {
        return;
    }
    let moved = earlier(guide, pixel);
    let place = project_before(moved.position) + offset_to_middle(position, guide.position);
    let found = mean_at(place, moved, coarser_pixel(guide), FINDS_POINT);
    if found.length <= 0.0 {
        return;
    }
    var limits = vec2f(0.0, 3e38);
    if uniforms.scene_changed != 0u {
        limits = plausible_luminance(position);
    }
    var max_length = uniforms.max_history;
    if uniforms.camera_moves != 0u {
        if guide.is_glossy && !has_facets(guide) {
            max_length = min(max_length, MAX_GLOSSY_HISTORY);
        } else if curvature(position, guide).count < f32(SMOOTH_NEIGHBOURS) {
            max_length = min(max_length, MAX_ROUGH_HISTORY);
        }
    }
    history[pixel] = joined(found, alone, limits, max_length);
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
