// import: reconstruct/pass
// Radiance of the filtered light, without emitters. Twin of `without_emitters` in emitters.rs.

/// Radiance of a pixel of the samples. In a picture of their size, textures are averaged over pixels.
fn sample_at(pixel: u32, sampled: Guide) -> vec3f {
    var guide = sampled;
    if uniforms.has_albedos != 0u && !is_enlarged() && albedos[pixel].w > 0.0 {
        guide.albedo = albedos[pixel].xyz;
    }
    if uniforms.has_facets == 0u {
        return estimates[pixel].xyz * divisor(guide);
    }
    return base[pixel].xyz * divisor(guide) + estimates[pixel].xyz * reflection_divisor(guide);
}

/// Shares of the radiance of a pixel of the samples that are in proportion to its albedo, as a whole number: eight bits of each
/// channel.
fn shares_of_albedo(pixel: u32, guide: Guide, radiance: vec3f) -> f32 {
    var apart = vec3f(0.0);
    if uniforms.has_facets != 0u && !guide.has_coloured_facets {
        apart = estimates[pixel].xyz;
    }
    let shares = vec3u(clamp(1.0 - apart / max(radiance, vec3f(1e-30)), vec3f(0.0), vec3f(1.0)) * 255.0 + 0.5);
    return f32(shares.r | (shares.g << 8u) | (shares.b << 16u));
}

/// Coverage of the pixel in the middle of a sample's.
fn coverage_at(position: vec2i) -> vec4f {
    let size = vec2u(uniforms.shown_width, uniforms.shown_height);
    let factor = vec2f(size) / vec2f(f32(uniforms.width), f32(uniforms.height));
    let shown = min(vec2u((vec2f(position) + 0.5) * factor), size - 1u);
    return coverages[shown.y * size.x + shown.x];
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
    next_estimates[pixel] = vec4f(colour, shares_of_albedo(pixel, here, colour));
    if uniforms.has_emitters == 0u || !(is_seen_emitter(here) || here.is_mixed) {
        return;
    }
    if coverage_at(position).w == 0.0 {
        return;
    }
    var sum = vec3f(0.0);
    var count = 0.0;
    // What is left of all pixels without the emitters, and its share in them.
    var left = vec3f(0.0);
    var rest = 0.0;
    for (var k = 0; k < 9; k++) {
        let place = position + vec2i(k % 3 - 1, k / 3 - 1);
        if is_inside(place) {
            let guide = guide_at(pixel_index(place));
            let there = sample_at(pixel_index(place), guide);
            if !is_seen_emitter(guide) && !guide.is_mixed {
                sum += there;
                count += 1.0;
            }
            let coverage = coverage_at(place);
            if coverage.w != FULL_COVERAGE {
                left += there - coverage.xyz;
                rest += max(1.0 - abs(coverage.w), LEAST_REST);
            }
        }
    }
    let without = select(max(left, vec3f(0.0)) / max(rest, LEAST_REST), vec3f(0.0), is_seen_emitter(here) && !here.is_mixed);
    next_estimates[pixel] = vec4f(select(without, sum / max(count, 1.0), count > 0.0), 0.0);
}
