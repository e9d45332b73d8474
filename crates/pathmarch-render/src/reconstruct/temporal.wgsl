// import: reconstruct/pass
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
    let irradiance = min(film_mean(id.xy, pixel) / divisor(guide), vec3f(MAX_IRRADIANCE));
    estimates[pixel] = vec4f(irradiance, luminance(irradiance));
    store_earlier(pixel, guide.position, guide.normal);
    if guide.leaf != NO_LEAF && leaf_motions[guide.leaf].moves != 0u {
        let motion = leaf_motions[guide.leaf];
        let rows = mat3x3f(motion.x, motion.y, motion.z);
        let offset = vec3f(motion.offset_x, motion.offset_y, motion.offset_z);
        store_earlier(pixel, guide.position * rows * motion.scale + offset, guide.normal * rows);
    }
    if guide.object != GLOSSY_BIT - 1u {
        let flags = guides[3u * pixel + 2u].x & ~(GLOSSY_BIT - 1u);
        guides[3u * pixel + 2u].x = flags | leaf_motions[guide.object].object;
        guides[3u * pixel + 2u].y = leaf_motions[guide.seen_object].object | select(0u, MIXED_BIT, guide.is_mixed);
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
    let samples = f32(uniforms.samples);
    let irradiance = estimates[pixel].xyz;
    let l = luminance(irradiance);
    // Fireflies of a single sample have been spread.
    let square = select(l * l, guide.square, uniforms.samples > 1u);
    history[pixel] = History(irradiance, samples, vec2f(l, square), vec2f(-1e9));
    if uniforms.max_history <= 0.0 {
        return;
    }
    var found = find(earlier(guide, pixel), coarser_pixel(guide));
    if found.length <= 0.0 {
        return;
    }
    if uniforms.scene_changed != 0u {
        let limits = plausible_luminance(position);
        let old = luminance(found.irradiance);
        let clamped = clamp(old, limits.x, limits.y);
        let factor = clamped / max(old, 1e-9);
        found.irradiance *= factor;
        found.moments *= vec2f(factor, factor * factor);
        // The less of it is plausible, the fewer samples it is worth.
        let agreement = (min(clamped, old) + 1e-9) / (max(clamped, old) + 1e-9);
        found.length *= agreement * agreement;
    }
    let is_limited = uniforms.camera_moves != 0u && guide.is_glossy;
    let limit = select(uniforms.max_history, min(uniforms.max_history, MAX_GLOSSY_HISTORY), is_limited);
    let length = min(found.length, limit);
    let share = samples / (samples + length);
    history[pixel] = History(
        mix(found.irradiance, irradiance, share),
        samples + length,
        mix(found.moments, vec2f(l, square), share),
        found.before,
    );
}

/// Mean of the point of an earlier guide in the last picture; its length is 0 if that does not show the point. `side` is that
/// of a pixel at the point.
fn find(guide: Guide, side: f32) -> History {
    var found: History;
    found.before = project_before(guide.position);
    let corner = floor(found.before - 0.5);
    let part = found.before - 0.5 - corner;
    var total = 0.0;
    for (var k = 0; k < 4; k++) {
        let offset = vec2i(k & 1, k >> 1u);
        let place = vec2i(corner) + offset;
        if any(place < vec2i(0)) || any(place >= vec2i(i32(uniforms.past_width), i32(uniforms.past_height))) {
            continue;
        }
        let pixel = u32(place.y) * uniforms.past_width + u32(place.x);
        if !same_point(guide, past_guide_at(pixel), side) {
            continue;
        }
        let weights = select(1.0 - part, part, offset == vec2i(1));
        let weight = weights.x * weights.y;
        let past = past_history[pixel];
        found.irradiance += past.irradiance * weight;
        found.moments += past.moments * weight;
        found.length += past.length * weight;
        total += weight;
    }
    if total <= 0.01 {
        found.length = 0.0;
        return found;
    }
    found.irradiance /= total;
    found.moments /= total;
    found.length /= total;
    return found;
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
