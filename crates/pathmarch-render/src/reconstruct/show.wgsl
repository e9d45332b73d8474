// import: reconstruct/pass
// The picture or a buffer as sRGB codes, four bytes a pixel. Twin of `CpuReconstruction::buffer`.

/// Colour of a pixel of the picture, with emitters in front of it. Twin of `EmitterLayer::over`.
fn shown_colour(position: vec2u) -> vec3f {
    let size = vec2u(uniforms.shown_width, uniforms.shown_height);
    let pixel = position.y * size.x + position.x;
    let colour = colours[pixel].xyz;
    if uniforms.has_emitters == 0u {
        return colour;
    }
    let coverage = coverages[pixel];
    if coverage.w == FULL_COVERAGE {
        let samples = vec2u(uniforms.width, uniforms.height);
        let factor = vec2f(size) / vec2f(samples);
        let sample_position = min(vec2u((vec2f(position) + 0.5) / factor), samples - 1u);
        return film_mean(sample_position, sample_position.y * samples.x + sample_position.x);
    }
    return colour * max(1.0 - abs(coverage.w), 0.0) + coverage.xyz;
}

/// Squared difference between the picture and the means of its film, and the variance of these means. Twin of
/// `film_differences`.
@compute @workgroup_size(8, 8)
fn compare_with_film(@builtin(global_invocation_id) id: vec3u) {
    let size = vec2u(uniforms.shown_width, uniforms.shown_height);
    if any(id.xy >= size) {
        return;
    }
    let pixel = id.y * size.x + id.x;
    let guide = guide_at(pixel);
    let irradiance = luminance(film_mean(id.xy, pixel) / divisor(guide));
    let difference = irradiance - luminance(shown_colour(id.xy) / divisor(guide));
    next_estimates[pixel] = vec4f(difference * difference, film_variance(guide, irradiance), 0.0, 0.0);
}

/// Variance of the mean of a pixel of the film.
fn film_variance(guide: Guide, irradiance: f32) -> f32 {
    return max(guide.square - irradiance * irradiance, 0.0) / f32(uniforms.samples);
}

/// Weight of the film from its difference to the picture around a pixel. Twin of the function in cpu.rs.
fn unbiased_weight(position: vec2i) -> f32 {
    var sum = vec2f(0.0);
    var count = 0.0;
    for (var y = -BIAS_RADIUS; y <= BIAS_RADIUS; y++) {
        for (var x = -BIAS_RADIUS; x <= BIAS_RADIUS; x++) {
            let place = position + vec2i(x, y);
            if is_inside(place) {
                sum += next_estimates[pixel_index(place)].xy;
                count += 1.0;
            }
        }
    }
    let variance = max(sum.y, OWN_VARIANCE * count * next_estimates[pixel_index(position)].y);
    return max(1.0 - variance / max(sum.x, 1e-12), 0.0);
}

/// Mixes the picture with the means of its film, each pixel by the noise of the film and the error of the picture. Twin of
/// `mixed_with_film`.
@compute @workgroup_size(8, 8)
fn mix_with_film(@builtin(global_invocation_id) id: vec3u) {
    let size = vec2u(uniforms.shown_width, uniforms.shown_height);
    if any(id.xy >= size) {
        return;
    }
    let pixel = id.y * size.x + id.x;
    let shown = shown_colour(id.xy);
    estimates[pixel] = vec4f(shown, 0.0);
    if uniforms.settles < 2u {
        return;
    }
    let guide = guide_at(pixel);
    let mean = film_mean(id.xy, pixel);
    let samples = f32(uniforms.samples);
    let irradiance = luminance(mean / divisor(guide));
    let visible = sqrt(film_variance(guide, irradiance)) / (VISIBLE_NOISE * max(irradiance, 1e-4));
    let clean = max(1.0 - visible, 0.0);
    var settled = select(clean * clean, 1.0, guide.is_mixed) * min(samples / SETTLING_SAMPLES, 1.0);
    // Pixels of several surfaces are not filtered; their noise ends where no colour around them is.
    var settling = mean;
    if guide.is_mixed {
        settling = limited(vec2i(id.xy), mean);
    } else {
        settled = max(settled, unbiased_weight(vec2i(id.xy)));
    }
    // Discs of emitters out of focus have less noise than the film.
    if uniforms.has_emitters != 0u && coverages[pixel].w < 0.0 {
        settled = 0.0;
    }
    let colour = mix(mix(shown, settling, settled), mean, uniforms.weight);
    estimates[pixel] = vec4f(colour, 0.0);
}

/// A colour, limited to the range of those of the picture at a pixel and next to it.
fn limited(position: vec2i, colour: vec3f) -> vec3f {
    let size = vec2i(i32(uniforms.shown_width), i32(uniforms.shown_height));
    let here = shown_colour(vec2u(position));
    var least = here;
    var most = here;
    for (var k = 0; k < 9; k++) {
        let place = clamp(position + vec2i(k % 3 - 1, k / 3 - 1), vec2i(0), size - 1);
        let there = shown_colour(vec2u(place));
        least = min(least, there);
        most = max(most, there);
    }
    return clamp(colour, least, most);
}

/// sRGB codes from 0 to 1 of the shown buffer at a pixel of the samples.
fn buffer_codes(position: vec2i, pixel: u32) -> vec3f {
    let here = history[pixel];
    if uniforms.buffer == SHOWS_HISTORY_LENGTH {
        return vec3f(here.length / MAX_HISTORY);
    }
    if uniforms.buffer == SHOWS_DEVIATION {
        let variance = max(here.moments.y - here.moments.x * here.moments.x, 0.0) / here.length;
        return vec3f(sqrt(variance) / max(here.moments.x, 1e-6));
    }
    if here.before.x < -1e8 {
        return vec3f(0.0, 0.0, 1.0);
    }
    let scale = vec2f(f32(uniforms.width), f32(uniforms.height)) / vec2f(f32(uniforms.past_width), f32(uniforms.past_height));
    let motion = here.before * scale - vec2f(position) - 0.5;
    return vec3f(0.5 - 0.5 * motion / FULL_MOTION, 0.0);
}

@compute @workgroup_size(8, 8)
fn show(@builtin(global_invocation_id) id: vec3u) {
    let size = vec2u(uniforms.shown_width, uniforms.shown_height);
    if any(id.xy >= size) {
        return;
    }
    let pixel = id.y * size.x + id.x;
    var shown: vec3f;
    if uniforms.buffer == SHOWS_PICTURE {
        shown = codes(uniforms.tonemap, vec4f(estimates[pixel].xyz * uniforms.gain, 1.0)).xyz;
    } else {
        let position = id.xy * vec2u(uniforms.width, uniforms.height) / size;
        shown = buffer_codes(vec2i(position), position.y * uniforms.width + position.x);
    }
    screen[pixel] = pack4x8unorm(vec4f(shown, 1.0));
}
