// import: reconstruct/pass
// Radiance of the filtered light, without emitters. Twin of `without_emitters` in emitters.rs.

/// Radiance of a pixel of the samples.
fn sample_at(pixel: u32, guide: Guide) -> vec3f {
    if uniforms.has_facets == 0u {
        return estimates[pixel].xyz * divisor(guide);
    }
    return base[pixel].xyz * divisor(guide) + estimates[pixel].xyz * reflection_divisor(guide);
}

/// Radiance of each pixel; of one that shows an emitter, the mean of those around it that show none.
@compute @workgroup_size(8, 8)
fn remove_emitters(@builtin(global_invocation_id) id: vec3u) {
    let position = vec2i(id.xy);
    if !is_inside(position) {
        return;
    }
    let pixel = pixel_index(position);
    let here = guide_at(pixel);
    let colour = sample_at(pixel, here);
    next_estimates[pixel] = vec4f(colour, 0.0);
    if uniforms.has_emitters == 0u || !(is_seen_emitter(here) || here.is_mixed) {
        return;
    }
    var emitters = 0u;
    var sum = vec3f(0.0);
    var count = 0.0;
    for (var k = 0; k < 9; k++) {
        let place = position + vec2i(k % 3 - 1, k / 3 - 1);
        if is_inside(place) {
            let guide = guide_at(pixel_index(place));
            if is_seen_emitter(guide) {
                emitters++;
            } else if !guide.is_mixed {
                sum += sample_at(pixel_index(place), guide);
                count += 1.0;
            }
        }
    }
    if emitters >= MIN_EMITTER_SAMPLES {
        let rest = select(colour, vec3f(0.0), is_seen_emitter(here));
        next_estimates[pixel] = vec4f(select(rest, sum / max(count, 1.0), count > 0.0), 0.0);
    }
}
