// import: layer, reconstruct/history
// Means of the past after a change of the scene. Twin of changed_light.rs, which explains it. The kernels that find the
// past leave it in the history, with a length of 0 where there is none.

/// Difference of pixels without a past.
const NO_DIFFERENCE = 3e38;

/// Adds up new light and past light along the rows, over the pixels that have a past, and their number, in buffers that are
/// written later.
@compute @workgroup_size(8, 8)
fn add_up_light(@builtin(global_invocation_id) id: vec3u) {
    let position = vec2i(id.xy);
    if !is_inside(position) {
        return;
    }
    let here = pixel_index(position);
    let normal = normal_at(here);
    var present = vec4f(0.0);
    var past_light = vec3f(0.0);
    for (var x = max(position.x - LIGHT_RADIUS, 0); x <= min(position.x + LIGHT_RADIUS, i32(uniforms.width) - 1); x++) {
        let there = pixel_index(vec2i(x, position.y));
        if history[there].length > 0.0 && are_one_side(here, normal, there, ~GLOSSY_BIT) {
            present += vec4f(estimates[there].xyz, 1.0);
            past_light += history[there].irradiance;
        }
    }
    next_estimates[here] = present;
    colours[here] = vec4f(past_light, 0.0);
}

/// Scales the past by the ratio of new light to past light around each pixel, from the sums along rows. Leaves the difference of
/// the new samples from it in the last number of the estimates.
@compute @workgroup_size(8, 8)
fn scale_past(@builtin(global_invocation_id) id: vec3u) {
    let position = vec2i(id.xy);
    if !is_inside(position) {
        return;
    }
    let here = pixel_index(position);
    let past = history[here];
    if past.length <= 0.0 {
        estimates[here].w = NO_DIFFERENCE;
        return;
    }
    let normal = normal_at(here);
    var present = vec4f(0.0);
    var past_light = vec3f(0.0);
    for (var y = max(position.y - LIGHT_RADIUS, 0); y <= min(position.y + LIGHT_RADIUS, i32(uniforms.height) - 1); y++) {
        let there = pixel_index(vec2i(position.x, y));
        if are_one_side(here, normal, there, ~GLOSSY_BIT) {
            present += next_estimates[there];
            past_light += colours[there].xyz;
        }
    }
    let ratios = min(present.xyz / max(past_light, vec3f(MIN_PAST_LIGHT)), vec3f(MAX_LIGHT_FACTOR));
    let scaled = past.irradiance * select(vec3f(1.0), ratios, present.w >= MIN_SCALED_PIXELS);
    let factor = luminance(scaled) / max(luminance(past.irradiance), MIN_PAST_LIGHT);
    history[here].irradiance = scaled;
    history[here].moments = past.moments * vec2f(factor, factor * factor);
    estimates[here].w = luminance(estimates[here].xyz) - luminance(scaled);
}

/// Joins the new samples with the past, which counts fewer samples where they differ by more than their noise.
@compute @workgroup_size(8, 8)
fn join_past(@builtin(global_invocation_id) id: vec3u) {
    let position = vec2i(id.xy);
    if !is_inside(position) {
        return;
    }
    let here = pixel_index(position);
    let irradiance = estimates[here].xyz;
    let guide = guide_at(here);
    let alone = new_mean(irradiance, mean_square(guide, luminance(irradiance)));
    var past = history[here];
    if past.length <= 0.0 {
        history[here] = alone;
        return;
    }
    var sum = 0.0;
    var squares = 0.0;
    var count = 0.0;
    for (var k = 0; k < 9; k++) {
        let place = position + vec2i(k % 3 - 1, k / 3 - 1);
        if !is_inside(place) {
            continue;
        }
        let there = pixel_index(place);
        if estimates[there].w < NO_DIFFERENCE && are_one_side(here, guide.normal, there, ~GLOSSY_BIT) {
            let difference = estimates[there].w;
            sum += difference;
            squares += difference * difference;
            count += 1.0;
        }
    }
    past.length = plausible_length(past, vec3f(sum, squares, count));
    history[here] = joined(past, alone);
}

/// Samples that the past counts, from these sums over the differences of new samples from it: they, their squares and 1.
fn plausible_length(past: History, sums: vec3f) -> f32 {
    let mean = sums.x / sums.z;
    let around = (sums.y - mean * sums.x) / max(sums.z - 1.0, 1.0);
    let own = past.moments.y - past.moments.x * past.moments.x;
    let rounding = past.moments.x * LIGHT_ROUNDING;
    let variance = max(select(own, around, sums.z >= MIN_COMPARED_PIXELS), rounding * rounding);
    let error = mean * mean - variance / sums.z;
    return select(past.length, past.length * variance / (error * past.length + variance), error > 0.0);
}
