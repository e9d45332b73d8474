// import: reconstruct/direct
// Indirect light at half the resolution. Twin of indirect.rs, which explains it.

/// Guides, irradiance and earlier points of pixels of half the resolution.
@group(0) @binding(17) var<storage, read_write> half_guides: array<vec4u>;
@group(0) @binding(18) var<storage, read_write> half_estimates: array<vec4f>;
@group(0) @binding(19) var<storage, read_write> half_earlier: array<vec4u>;

/// Size of the picture of half the size.
fn half_size() -> vec2u {
    return (vec2u(uniforms.width, uniforms.height) + 1u) / 2u;
}

/// Averages the indirect light of blocks of 2x2 pixels.
@compute @workgroup_size(8, 8)
fn halve(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= half_size()) {
        return;
    }
    // What is in front counts, so that thin objects have light; but the mean of several surfaces is that of none.
    let corner = 2 * vec2i(id.xy);
    var front = guide_at(pixel_index(corner));
    for (var k = 1; k < 4; k++) {
        let place = corner + vec2i(k % 2, k / 2);
        if is_inside(place) {
            let guide = guide_at(pixel_index(place));
            var is_before = path_length(guide) < path_length(front);
            is_before = select(is_before, front.is_mixed, guide.is_mixed != front.is_mixed);
            if guide.guide_class == GUIDE_SURFACE && (is_before || front.guide_class != GUIDE_SURFACE) {
                front = guide;
            }
        }
    }
    let pixel = id.y * half_size().x + id.x;
    var averaged = front;
    var irradiance = vec3f(0.0);
    if front.guide_class == GUIDE_SURFACE {
        var position = vec3f(0.0);
        var variance = 0.0;
        var count = 0.0;
        for (var k = 0; k < 4; k++) {
            let place = corner + vec2i(k % 2, k / 2);
            if !is_inside(place) {
                continue;
            }
            let guide = guide_at(pixel_index(place));
            let is_same = guide.object == front.object && guide.is_mixed == front.is_mixed
                && has_medium(guide) == has_medium(front);
            let is_part = guide.guide_class == GUIDE_SURFACE && is_same;
            if is_part && dot(guide.normal, front.normal) >= MIN_BLOCK_COSINE {
                irradiance += guide.indirect / divisor(guide);
                position += guide.position;
                let direct = direct_irradiance(vec2u(place), pixel_index(place), guide);
                variance += variance_without_facets(guide, luminance(direct));
                count += 1.0;
            }
        }
        irradiance /= count;
        averaged.position = position / count;
        averaged.albedo = vec3f(1.0);
        let mean = luminance(irradiance);
        averaged.square = mean * mean + variance / (count * count);
        averaged.is_glossy = front.is_glossy && !has_facets(front);
        averaged.alpha = select(0.0, MEDIUM_ALPHA, has_medium(front));
        averaged.reflected = vec3f(0.0);
        averaged.reflected_square = 0.0;
        averaged.indirect = vec3f(0.0);
        averaged.has_coloured_facets = false;
    }
    let words = packed_guide(averaged);
    for (var k = 0u; k < 4u; k++) {
        half_guides[4u * pixel + k] = words[k];
    }
    half_estimates[pixel] = vec4f(irradiance, luminance(irradiance));
    half_earlier[pixel] = earlier_words(moved_back(averaged));
}

/// Weight of a pixel of half the resolution for one of the full resolution.
fn interpolation_weight(guide: Guide, half: Guide) -> f32 {
    if half.guide_class != GUIDE_SURFACE || half.object != guide.object || has_medium(half) != has_medium(guide) {
        return 0.0;
    }
    let apart = half.position - guide.position;
    let along = max(abs(dot(guide.normal, apart)), abs(dot(half.normal, apart)));
    let plane = 1.0 - along / (INTERPOLATION_REACH * uniforms.pixel * path_length(guide));
    let cosine = max(dot(guide.normal, half.normal), 0.0);
    let fourth = cosine * cosine * cosine * cosine;
    return max(plane, 0.0) * fourth * fourth;
}

/// Adds filtered indirect light of half the resolution to the irradiance of the direct light.
@compute @workgroup_size(8, 8)
fn add_indirect(@builtin(global_invocation_id) id: vec3u) {
    let position = vec2i(id.xy);
    if !is_inside(position) {
        return;
    }
    let pixel = pixel_index(position);
    let guide = guide_at(pixel);
    if guide.guide_class != GUIDE_SURFACE {
        return;
    }
    let size = vec2i(half_size());
    let beside = 2 * (position % 2) - 1;
    var sum = vec3f(0.0);
    var total = 0.0;
    for (var k = 0; k < 4; k++) {
        let place = position / 2 + vec2i(k % 2, k / 2) * beside;
        if all(place >= vec2i(0)) && all(place < size) {
            let there = u32(place.y * size.x + place.x);
            let first = 4u * there;
            let half = unpacked_guide(array<vec4u, 4>(
                half_guides[first],
                half_guides[first + 1u],
                half_guides[first + 2u],
                half_guides[first + 3u],
            ));
            let kernel = select(1.0, 3.0, k % 2 == 0) * select(1.0, 3.0, k / 2 == 0);
            let weight = kernel * interpolation_weight(guide, half);
            sum += half_estimates[there].xyz * weight;
            total += weight;
        }
    }
    let indirect = select(guide.indirect / divisor(guide), sum / max(total, 1e-30), total > MIN_INTERPOLATION_WEIGHT);
    estimates[pixel] = vec4f(estimates[pixel].xyz + indirect, estimates[pixel].w);
}
