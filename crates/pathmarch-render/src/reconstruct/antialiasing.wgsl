// import: reconstruct/pass
// Temporal anti-aliasing and upscaling. Twin of antialiasing.rs.

/// Lightness, orange against blue, green against magenta.
fn opponent_of(colour: vec3f) -> vec3f {
    return vec3f(
        0.25 * colour.r + 0.5 * colour.g + 0.25 * colour.b,
        0.5 * (colour.r - colour.b),
        0.5 * colour.g - 0.25 * (colour.r + colour.b),
    );
}

/// Inverse of `opponent_of`.
fn colour_of(opponent: vec3f) -> vec3f {
    return vec3f(
        opponent.x + opponent.y - opponent.z,
        opponent.x + opponent.z,
        opponent.x - opponent.y - opponent.z,
    );
}

/// True if the last picture shows the point of an earlier guide at a position or next to it. `side` is that of a pixel at the
/// point.
fn shown_before(guide: Guide, side: f32, position: vec2f) -> bool {
    let size = vec2i(i32(uniforms.past_width), i32(uniforms.past_height));
    for (var k = 0; k < 9; k++) {
        let place = vec2i(position) + vec2i(k % 3 - 1, k / 3 - 1);
        if all(place >= vec2i(0)) && all(place < size)
            && same_point(guide, past_guide_at(u32(place.y) * uniforms.past_width + u32(place.x)), side) {
            return true;
        }
    }
    return false;
}

/// Weights of four points at -1, 0, 1 and 2 for the value at `t`, 0 to 1.
fn catmull_rom(t: f32) -> vec4f {
    let t2 = t * t;
    let t3 = t2 * t;
    return vec4f(
        -0.5 * t + t2 - 0.5 * t3,
        1.0 - 2.5 * t2 + 1.5 * t3,
        0.5 * t + 2.0 * t2 - 1.5 * t3,
        -0.5 * t2 + 0.5 * t3,
    );
}

/// Colour of the last picture at a position, in its own pixels, by bicubic interpolation.
fn past_colour(position: vec2f) -> vec3f {
    let size = vec2i(i32(uniforms.past_shown_width), i32(uniforms.past_shown_height));
    let corner = floor(position - 0.5);
    let part = position - 0.5 - corner;
    let columns = catmull_rom(part.x);
    let rows = catmull_rom(part.y);
    var sum = vec3f(0.0);
    // Between the four nearest colours.
    var least = vec3f(1e38);
    var most = vec3f(-1e38);
    for (var k = 0; k < 16; k++) {
        let place = clamp(vec2i(corner) + vec2i(k % 4 - 1, k / 4 - 1), vec2i(0), size - 1);
        let colour = past_colours[place.y * size.x + place.x].xyz;
        sum += colour * (columns[k % 4] * rows[k / 4]);
        if (k % 4 == 1 || k % 4 == 2) && (k / 4 == 1 || k / 4 == 2) {
            least = min(least, colour);
            most = max(most, colour);
        }
    }
    return clamp(sum, least, most);
}

/// Length of the path to the point of a guide, metres; large and equal for all of the sky, and larger if it is no part of the
/// picture.
fn length_of_part(guide: Guide) -> f32 {
    let length = select(path_length(guide), 1e38, guide.guide_class == GUIDE_SKY);
    return select(length, 3e38, uniforms.has_emitters != 0u && is_seen_emitter(guide));
}

/// Distance of the first surface on the ray of a guide, which may be a mirror, from the camera, metres.
fn front_distance(guide: Guide) -> f32 {
    let distance = first_mirror_distance(guide.mirror);
    return select(length_of_part(guide), distance, distance > 0.0);
}

/// True if one of two guides is that of a mirror and the other is not, or if they are of different faces of mirrors.
fn mirrors_differ(a: Guide, b: Guide) -> bool {
    let are_mirrors = vec2<bool>(first_mirror_distance(a.mirror) > 0.0, first_mirror_distance(b.mirror) > 0.0);
    let turned = dot(first_mirror_normal(a.mirror), first_mirror_normal(b.mirror)) < MIN_MIRROR_COSINE;
    return are_mirrors.x != are_mirrors.y || (all(are_mirrors) && turned);
}

/// Colour of a sample with this albedo instead of that of its guide: in `sample.w` are the shares of its channels that are in
/// proportion to it, see emitters.wgsl.
fn with_albedo(sample: vec4f, guide: Guide, albedo: vec3f) -> vec3f {
    let shares = vec3f((vec3u(u32(sample.w)) >> vec3u(0u, 8u, 16u)) & vec3u(255u)) / 255.0;
    return sample.xyz * (1.0 + shares * (max(albedo, vec3f(MIN_ALBEDO)) / divisor(guide) - 1.0));
}

/// Averages samples with the last picture.
@compute @workgroup_size(8, 8)
fn antialias(@builtin(global_invocation_id) id: vec3u) {
    let shown = vec2u(uniforms.shown_width, uniforms.shown_height);
    if any(id.xy >= shown) {
        return;
    }
    let traced = vec2f(f32(uniforms.width), f32(uniforms.height));
    let factor = vec2f(shown) / traced;
    let point = (vec2f(id.xy) + 0.5) / factor;
    let centre = min(vec2i(point), vec2i(traced) - 1);
    let is_larger = is_enlarged();
    var albedo = vec4f(0.0);
    if uniforms.has_albedos != 0u && is_larger {
        albedo = albedos[id.y * shown.x + id.x];
    }
    var sum = vec3f(0.0);
    var squares = vec3f(0.0);
    var count = 0.0;
    // Edges move with what is in front.
    var nearest = guide_at(pixel_index(centre));
    var nearest_pixel = pixel_index(centre);
    // Outlines of mirrors move with these, not with their images.
    let here = nearest;
    var is_outline = false;
    var front = nearest;
    var front_pixel = nearest_pixel;
    var least = 3e38;
    var colour = estimates[pixel_index(centre)].xyz;
    var weighted = vec3f(0.0);
    var total = 0.0;
    var largest = 0.0;
    for (var k = 0; k < 9; k++) {
        let place = centre + vec2i(k % 3 - 1, k / 3 - 1);
        if !is_inside(place) {
            continue;
        }
        let guide = guide_at(pixel_index(place));
        let there = estimates[pixel_index(place)].xyz;
        if length_of_part(guide) < length_of_part(nearest) {
            nearest = guide;
            nearest_pixel = pixel_index(place);
        }
        is_outline = is_outline || (mirrors_differ(here, guide) && length_of_part(guide) < 3e38);
        if front_distance(guide) < least {
            least = front_distance(guide);
            front = guide;
            front_pixel = pixel_index(place);
        }
        let opponent = opponent_of(there);
        sum += opponent;
        squares += opponent * opponent;
        count += 1.0;
        if is_larger {
            let projected = project(guide.position);
            let position = select(projected, vec2f(place) + 0.5, projected.x < -1e8);
            let distance = (point - position) * factor;
            let weight = exp(-0.5 * dot(distance, distance) / (KERNEL_DEVIATION * KERNEL_DEVIATION));
            let is_textured = albedo.w > 0.0 && guide.leaf == here.leaf && !guide.is_mixed;
            weighted += select(there, with_albedo(estimates[pixel_index(place)], guide, albedo.xyz), is_textured) * weight;
            total += weight;
            largest = max(largest, weight);
        }
    }
    if total > 0.0 {
        colour = weighted / total;
    } else {
        largest = 1.0;
    }
    if albedo.w > 0.0 {
        // Only light is interpolated.
        largest = 1.0;
        colour = select(with_albedo(estimates[pixel_index(centre)], here, albedo.xyz), colour, total > 0.0);
    }
    let pixel = id.y * shown.x + id.x;
    colours[pixel] = vec4f(colour, 0.0);
    if uniforms.antialiases == 0u {
        return;
    }
    if is_outline {
        nearest = front;
        nearest_pixel = front_pixel;
    }
    let before = earlier(nearest, nearest_pixel);
    let distance_of_mirror = first_mirror_distance(nearest.mirror);
    let on_mirror =
        uniforms.position + (nearest.position - uniforms.position) * (distance_of_mirror / path_length(nearest));
    let old_position = project_before(select(before.position, on_mirror, is_outline && distance_of_mirror > 0.0));
    let new_position = project(nearest.position);
    if old_position.x < -1e8 || new_position.x < -1e8 {
        return;
    }
    let past_traced = vec2f(f32(uniforms.past_width), f32(uniforms.past_height));
    let place = (point - new_position) * past_traced / traced + old_position;
    if any(place < vec2f(0.0)) || any(place >= past_traced) || !shown_before(before, coarser_pixel(nearest), place) {
        return;
    }
    let past_shown = vec2f(f32(uniforms.past_shown_width), f32(uniforms.past_shown_height));
    let mean = sum / count;
    let deviation = REACH * sqrt(max(squares / count - mean * mean, vec3f(0.0)));
    let limited = clamp(opponent_of(past_colour(place * past_shown / past_traced)), mean - deviation, mean + deviation);
    let old = max(colour_of(limited), vec3f(0.0));
    let speed = min(length(place * traced / past_traced - point) / FAST_MOTION, 1.0);
    var new_weight = max(uniforms.new_weight, MOVING_WEIGHT * speed);
    if uniforms.scene_changed != 0u && here.alpha > 0.0 {
        // What facets show may move, whatever their surface does.
        let sharpness = min(SHARP_ALPHA / here.alpha, 1.0);
        new_weight = max(new_weight, IMAGE_WEIGHT * sharpness * sharpness);
    }
    colours[pixel] = vec4f(mix(old, colour, max(new_weight * largest, MIN_WEIGHT)), 0.0);
}
