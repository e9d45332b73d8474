// import: reconstruct/pass
// Means of pixels, how new samples join them, and how they are found in the last picture. Twin of means.rs and of `History` in
// temporal.rs.

/// Mean of new samples alone; `square` is that of their luminance.
fn new_mean(irradiance: vec3f, square: f32) -> History {
    let l = luminance(irradiance);
    // Fireflies of a single sample have been spread.
    let moments = vec2f(l, select(l * l, square, uniforms.samples > 1u));
    return History(irradiance, f32(uniforms.samples), moments, vec2f(-1e9));
}

/// A mean of the past with a luminance within limits, and with at most so many samples.
fn limited(past: History, limits: vec2f, max_length: f32) -> History {
    let old = luminance(past.irradiance);
    let clamped = clamp(old, limits.x, limits.y);
    let factor = select(clamped / max(old, 1e-9), 1.0, clamped == old);
    // The less of it is plausible, the fewer samples it is worth.
    let agreement = (min(clamped, old) + 1e-9) / (max(clamped, old) + 1e-9);
    return History(
        past.irradiance * factor,
        min(past.length * agreement * agreement, max_length),
        past.moments * vec2f(factor, factor * factor),
        past.before,
    );
}

/// Joins the mean of the past with that of new samples.
fn joined(past: History, present: History) -> History {
    let share = present.length / (present.length + past.length);
    return History(
        mix(past.irradiance, present.irradiance, share),
        present.length + past.length,
        mix(past.moments, present.moments, share),
        past.before,
    );
}

/// True if a guide of the last picture shows a part of a surface that mirrors what the sought point of it mirrors. `side` is
/// that of a pixel at the point.
fn shows_reflector(sought: Guide, there: Guide, side: f32) -> bool {
    let apart = sought.position - there.position;
    let along = min(abs(dot(sought.normal, apart)), abs(dot(there.normal, apart)));
    return sought.guide_class == there.guide_class && sought.object == there.object
        && dot(sought.normal, there.normal) >= MIN_NORMAL_COSINE
        && along <= PLANE_TOLERANCE * side + CURVED_TOLERANCE * length(apart);
}

/// Depth of a surface at a distance from the camera in a medium whose light has this mean distance.
fn depth_of_surface(length: f32, distance: f32) -> f32 {
    return length / (length + max(distance, 1.1754944e-38));
}

/// True if a guide of the last picture shows a medium in front of a surface that is as deep in it as that of the sought one.
/// `light_distance` is that of the light of the medium.
fn shows_medium(sought: Guide, there: Guide, light_distance: f32) -> bool {
    let depth = depth_of_surface(path_length(sought), light_distance);
    let depth_there = depth_of_surface(distance(there.position, uniforms.past_position), light_distance);
    return has_medium(there) && abs(depth - depth_there) < MEDIUM_REACH;
}

/// Offset from a point that the sample of a pixel shows to the middle of the pixel, in pixels of the last picture. Twin of
/// `offset_to_middle` in temporal.rs.
fn offset_to_middle(position: vec2i, point: vec3f) -> vec2f {
    let now = project(point);
    let size = vec2f(f32(uniforms.width), f32(uniforms.height));
    let past_size = vec2f(f32(uniforms.past_width), f32(uniforms.past_height));
    return select((vec2f(position) + 0.5 - now) * past_size / size, vec2f(0.0), now.x < -1e8);
}

/// What `mean_at` looks for: the sought point, a reflector of its image, or a medium.
const FINDS_POINT = 0u;
const FINDS_REFLECTOR = 1u;
const FINDS_MEDIUM = 2u;

/// Mean at a position of the last picture, of the pixels that show what is looked for; its length is 0 if there are none.
/// `side` is that of a pixel at the point; for media, the distance of their light.
fn mean_at(place: vec2f, sought: Guide, side: f32, finds: u32) -> History {
    var found: History;
    found.before = place;
    let corner = floor(place - 0.5);
    let part = place - 0.5 - corner;
    var total = 0.0;
    var squares = 0.0;
    for (var k = 0; k < 4; k++) {
        let offset = vec2i(k & 1, k >> 1u);
        let at = vec2i(corner) + offset;
        if any(at < vec2i(0)) || any(at >= vec2i(i32(uniforms.past_width), i32(uniforms.past_height))) {
            continue;
        }
        let pixel = u32(at.y) * uniforms.past_width + u32(at.x);
        let there = past_guide_at(pixel);
        // The mean of several surfaces is that of none.
        let is_point = finds == FINDS_POINT && !there.is_mixed && same_point(sought, there, side);
        let is_reflector = finds == FINDS_REFLECTOR && shows_reflector(sought, there, side);
        let is_medium = finds == FINDS_MEDIUM && shows_medium(sought, there, side);
        if !is_point && !is_reflector && !is_medium {
            continue;
        }
        let weights = select(1.0 - part, part, offset == vec2i(1));
        let weight = weights.x * weights.y;
        let past = past_history[pixel];
        found.irradiance += past.irradiance * weight;
        found.moments += past.moments * weight;
        squares += past.moments.x * past.moments.x * weight;
        found.length += past.length * weight;
        total += weight;
    }
    if total <= MIN_FOUND_WEIGHT {
        found.length = 0.0;
        return found;
    }
    found.irradiance /= total;
    found.moments /= total;
    found.length /= total;
    found.length = contrast_limited_length(found.moments, squares / total, found.length);
    return found;
}

/// Length of the history of an interpolated mean, shortened by contrast; `square` is the mean square of the interpolated
/// luminances.
fn contrast_limited_length(moments: vec2f, square: f32, length: f32) -> f32 {
    let mean_square = moments.x * moments.x;
    let deviation = max(square - mean_square, 0.0);
    let variance = max(moments.y - square, 0.0) / length;
    let known = length * (MAX_CONTRAST * variance + CONTRAST_ROUNDING * mean_square) / max(deviation, 1.1754944e-38);
    return min(length, max(known, MIN_CONTRAST_HISTORY));
}

/// Shape of a surface at a pixel.
struct Curvature {
    /// Mean curvature, per metre, above 0 if it is convex.
    curvature: f32,
    /// By how much the normal turns, per metre.
    turn: f32,
    /// Number of pixels beside it on the same smooth surface.
    count: f32,
}

/// Shape of the surface at a pixel, from the pixels beside it.
fn curvature(position: vec2i, guide: Guide) -> Curvature {
    var found: Curvature;
    for (var k = 0; k < 4; k++) {
        let step = select(-1, 1, k < 2);
        let place = position + select(vec2i(0, step), vec2i(step, 0), (k & 1) == 0);
        if !is_inside(place) {
            continue;
        }
        let there = guide_at(pixel_index(place));
        let apart = there.position - guide.position;
        let is_same = there.object == guide.object && there.guide_class == guide.guide_class;
        if is_same && dot(there.normal, guide.normal) >= MIN_SMOOTH_COSINE {
            let turned = there.normal - guide.normal;
            let square = max(dot(apart, apart), 1.1754944e-38);
            found.curvature += dot(turned, apart) / square;
            found.turn += sqrt(dot(turned, turned) / square);
            found.count += 1.0;
        }
    }
    found.curvature /= max(found.count, 1.0);
    found.turn /= max(found.count, 1.0);
    return found;
}
