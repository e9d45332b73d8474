// import: layer, reconstruct/pass
// Spatial filter and fireflies. Twin of spatial.rs.

/// Distance between the taps of a pass of the filter, pixels.
override STEP: i32 = 1;
/// Difference of luminance, in standard deviations, at which the weight ends.
override LUMINANCE_REACH: f32 = 2.0;

/// Surface of pixels without noise.
const NOT_FILTERED = 0xffffffffu;

/// Surface of pixels with light of media.
const MEDIUM = 0xfffffffeu;

/// Equal on pixels that may share their light; `NOT_FILTERED` for those without noise.
fn surface_of(guide: Guide) -> u32 {
    if is_of_medium(guide) {
        return MEDIUM;
    }
    // The mean of several surfaces is that of none.
    if guide.guide_class == GUIDE_SKY || guide.guide_class == GUIDE_EMITTER || (uniforms.settles != 0u && guide.is_mixed) {
        return NOT_FILTERED;
    }
    if !is_in_layer(guide) {
        return NOT_FILTERED;
    }
    // Pixels of glass share light if they show one object.
    let surface = select(2u * guide.object, 2u * guide.seen_object + 1u, guide.guide_class == GUIDE_GLASS);
    return 2u * surface + u32(has_medium(guide));
}

/// Weight of two pixels, `distance` pixels apart, as parts of one smooth surface; the same for both. They have these indices.
fn similarity(a: Guide, b: Guide, pixels: vec2u, distance: f32) -> f32 {
    let surface = surface_of(a);
    if surface == NOT_FILTERED || surface != surface_of(b) {
        return 0.0;
    }
    if surface == MEDIUM {
        return shared_medium(pixels);
    }
    let apart = a.position - b.position;
    let along = max(abs(dot(a.normal, apart)), abs(dot(b.normal, apart)));
    let side = uniforms.pixel * max(path_length(a), path_length(b));
    let plane = 1.0 - along / (PLANE_REACH * distance * side);
    let cosine = max(dot(a.seen_normal, b.seen_normal), 0.0);
    let fourth = cosine * cosine * cosine * cosine;
    return max(plane, 0.0) * fourth * fourth * fourth * shared_reflection(a, b, pixels, apart, side);
}

/// True if a firefly of guide `a` may give light to a pixel of guide `b`.
fn shares_fireflies(a: Guide, b: Guide) -> bool {
    let is_glass = a.guide_class == GUIDE_GLASS;
    return a.guide_class == b.guide_class && a.object == b.object
        && (is_glass || dot(a.seen_normal, b.seen_normal) > MIN_FIREFLY_COSINE);
}

/// Finds samples that are far above their neighbours: what is above, for each taker.
@compute @workgroup_size(8, 8)
fn find_fireflies(@builtin(global_invocation_id) id: vec3u) {
    let position = vec2i(id.xy);
    if !is_inside(position) {
        return;
    }
    let pixel = pixel_index(position);
    next_estimates[pixel] = vec4f(0.0);
    let here = estimates[pixel];
    let guide = guide_at(pixel);
    if guide.guide_class == GUIDE_SKY || guide.guide_class == GUIDE_EMITTER {
        return;
    }
    // Most pixels are not above all of the next ones, let alone of those on the same surface.
    for (var k = 0; k < 9; k++) {
        let place = position + vec2i(k % 3 - 1, k / 3 - 1);
        if k != 4 && is_inside(place) && estimates[pixel_index(place)].w >= here.w {
            return;
        }
    }
    var sum = 0.0;
    var count = 0.0;
    for (var y = -FIREFLY_RADIUS; y <= FIREFLY_RADIUS; y++) {
        for (var x = -FIREFLY_RADIUS; x <= FIREFLY_RADIUS; x++) {
            let place = position + vec2i(x, y);
            if (x != 0 || y != 0) && is_inside(place) && shares_fireflies(guide, guide_at(pixel_index(place))) {
                sum += estimates[pixel_index(place)].w;
                count += 1.0;
            }
        }
    }
    let limit = (1.0 + FIREFLY / sqrt(f32(uniforms.samples))) * sum / max(count, 1.0);
    // Without light around it, nothing tells a firefly from the only lit pixel.
    if sum > 0.0 && here.w > limit {
        next_estimates[pixel] = vec4f(here.xyz * (1.0 - limit / here.w), count);
    }
}

/// Moves what is above from fireflies to their neighbours.
@compute @workgroup_size(8, 8)
fn spread_fireflies(@builtin(global_invocation_id) id: vec3u) {
    let position = vec2i(id.xy);
    if !is_inside(position) {
        return;
    }
    let pixel = pixel_index(position);
    let guide = guide_at(pixel);
    var irradiance = estimates[pixel].xyz - next_estimates[pixel].xyz;
    for (var y = -FIREFLY_RADIUS; y <= FIREFLY_RADIUS; y++) {
        for (var x = -FIREFLY_RADIUS; x <= FIREFLY_RADIUS; x++) {
            let place = position + vec2i(x, y);
            if (x == 0 && y == 0) || !is_inside(place) {
                continue;
            }
            let excess = next_estimates[pixel_index(place)];
            if excess.w > 0.0 && shares_fireflies(guide_at(pixel_index(place)), guide) {
                irradiance += excess.xyz / excess.w;
            }
        }
    }
    estimates[pixel] = vec4f(irradiance, luminance(irradiance));
}

/// Starts the filter: the mean of each pixel and its variance. That of a young history is taken from its neighbours on the
/// same surface.
@compute @workgroup_size(8, 8)
fn start_filter(@builtin(global_invocation_id) id: vec3u) {
    let position = vec2i(id.xy);
    if !is_inside(position) {
        return;
    }
    let pixel = pixel_index(position);
    let guide = guide_at(pixel);
    let here = history[pixel];
    var moments = here.moments;
    if here.length < TRUSTED_SAMPLES {
        var total = 1.0;
        for (var y = -VARIANCE_RADIUS; y <= VARIANCE_RADIUS; y++) {
            for (var x = -VARIANCE_RADIUS; x <= VARIANCE_RADIUS; x++) {
                let place = position + vec2i(x, y);
                if (x == 0 && y == 0) || !is_inside(place) {
                    continue;
                }
                let other = pixel_index(place);
                let weight = similarity(guide, guide_at(other), vec2u(pixel, other), f32(VARIANCE_RADIUS));
                moments += history[other].moments * weight;
                total += weight;
            }
        }
        moments /= total;
    }
    let variance = max(moments.y - moments.x * moments.x, 0.0) / here.length;
    estimates[pixel] = vec4f(here.irradiance, select(variance, 0.0, surface_of(guide) == NOT_FILTERED));
}

/// Averages the variances with those of the next pixels on the same surface. What a pixel has above all of these is noise,
/// too, unless it shows glass.
@compute @workgroup_size(8, 8)
fn smooth_variance(@builtin(global_invocation_id) id: vec3u) {
    let position = vec2i(id.xy);
    if !is_inside(position) {
        return;
    }
    let pixel = pixel_index(position);
    let guide = guide_at(pixel);
    let here = estimates[pixel];
    var variance = here.w;
    var total = 1.0;
    var most = -1.0;
    for (var k = 0; k < 9; k++) {
        let place = position + vec2i(k % 3 - 1, k / 3 - 1);
        if k != 4 && is_inside(place) {
            let other = pixel_index(place);
            let weight = similarity(guide, guide_at(other), vec2u(pixel, other), 1.0);
            let there = estimates[other];
            variance += there.w * weight;
            total += weight;
            most = select(most, max(most, luminance(there.xyz)), weight > 0.0);
        }
    }
    variance /= total;
    if variance > 0.0 && most >= 0.0 && guide.guide_class != GUIDE_GLASS {
        let above = PEAK_DEVIATION * max(luminance(here.xyz) - most, 0.0);
        variance = max(variance, above * above);
    }
    next_estimates[pixel] = vec4f(here.xyz, variance);
}

/// One pass of the filter.
@compute @workgroup_size(8, 8)
fn filter_once(@builtin(global_invocation_id) id: vec3u) {
    let position = vec2i(id.xy);
    if !is_inside(position) {
        return;
    }
    let pixel = pixel_index(position);
    let guide = guide_at(pixel);
    let here = estimates[pixel];
    var sum = here;
    var total = 1.0;
    // Pixels that saw no light yet take what their neighbours give: otherwise these would lose it.
    if surface_of(guide) != NOT_FILTERED {
        for (var k = 0; k < 9; k++) {
            let offset = vec2i(k % 3 - 1, k / 3 - 1);
            let place = position + STEP * offset;
            if k == 4 || !is_inside(place) {
                continue;
            }
            let other = pixel_index(place);
            let surface = similarity(guide, guide_at(other), vec2u(pixel, other), f32(STEP));
            let there = estimates[other];
            // The same for both, so that each gives the other as much as it takes.
            let reach = LUMINANCE_REACH * sqrt(here.w + there.w) + 1e-6;
            let difference = abs(luminance(here.xyz) - luminance(there.xyz)) / reach;
            let kernel = select(0.25, 0.5, offset.x == 0 || offset.y == 0);
            let weight = kernel * surface * max(1.0 - difference, 0.0);
            sum += there * vec4f(vec3f(weight), weight * weight);
            total += weight;
        }
    }
    next_estimates[pixel] = sum / vec4f(vec3f(total), total * total);
}
