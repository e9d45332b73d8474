// import: reconstruct/history
// Light of facets and media. Twin of reflections.rs, which explains it.

/// Divides the light that facets reflect by their colour.
@compute @workgroup_size(8, 8)
fn divide_reflected(@builtin(global_invocation_id) id: vec3u) {
    let position = vec2i(id.xy);
    if !is_inside(position) {
        return;
    }
    let pixel = pixel_index(position);
    let guide = guide_at(pixel);
    let light = guide.reflected / reflection_divisor(guide);
    estimates[pixel] = vec4f(light, luminance(light));
}

/// True if the light of media in front of a pixel is recorded apart: their alpha is 1.
fn is_medium_at(pixel: u32) -> bool {
    return (guides[4u * pixel + 3u].w >> 24u) == 255u;
}

/// True if the layers of two pixels, of which the first has this normal, are parts of one: that of an object's side, or of
/// media.
fn are_one_layer(here: u32, normal: vec3f, there: u32) -> bool {
    let are_media = is_medium_at(here);
    return are_media == is_medium_at(there) && (are_media || are_one_side(here, normal, there, OBJECT_BITS));
}

/// Adds up luminance, its square, weight and weighted depth along the rows, and the number of pixels of the layer, which the
/// length of the history holds until that is written.
@compute @workgroup_size(8, 8)
fn add_up_rows(@builtin(global_invocation_id) id: vec3u) {
    let position = vec2i(id.xy);
    if !is_inside(position) {
        return;
    }
    var sum = vec4f(0.0);
    var facets = 0.0;
    let here = pixel_index(position);
    let normal = normal_at(here);
    for (var x = max(position.x - IMAGE_RADIUS, 0); x <= min(position.x + IMAGE_RADIUS, i32(uniforms.width) - 1); x++) {
        let pixel = pixel_index(vec2i(x, position.y));
        let words = guides[4u * pixel + 3u];
        if (words.w >> 24u) != 0u && are_one_layer(here, normal, pixel) {
            let weight = luminance(bitcast<vec3f>(words.xyz)) + DARK_WEIGHT;
            let light = estimates[pixel].w;
            sum += vec4f(light, light * light, weight, weight * depth_of_facets(words.w));
            facets += 1.0;
        }
    }
    images[here] = sum;
    history[here].length = facets;
}

/// Finds the image of what the facets of each pixel mirror, from the sums along rows.
@compute @workgroup_size(8, 8)
fn find_images(@builtin(global_invocation_id) id: vec3u) {
    let position = vec2i(id.xy);
    if !is_inside(position) {
        return;
    }
    let pixel = pixel_index(position);
    next_estimates[pixel] = vec4f(0.0);
    let guide = guide_at(pixel);
    if guide.alpha == 0.0 {
        return;
    }
    var sum = vec4f(0.0);
    var facets = 0.0;
    for (var y = max(position.y - IMAGE_RADIUS, 0); y <= min(position.y + IMAGE_RADIUS, i32(uniforms.height) - 1); y++) {
        let there = pixel_index(vec2i(position.x, y));
        if are_one_layer(pixel, guide.normal, there) {
            sum += images[there];
            facets += history[there].length;
        }
    }
    let depth = min(sum.w / sum.z, MAX_IMAGE_DEPTH);
    let mean = sum.x / facets;
    let reach = sqrt(max(sum.y / facets - mean * mean, 0.0)) * IMAGE_REACH;
    let limits = vec2f(max(mean - reach, 0.0), mean + reach);
    if has_medium(guide) {
        let distance = distance_in_medium(depth, uniforms.far);
        let length = path_length(guide);
        next_estimates[pixel] = vec4f(distance - length, depth_of_surface(length, distance), limits);
        return;
    }
    let distance = path_length(guide) * depth / (1.0 - depth);
    let lobe_reach = LOBE_REACH * guide.alpha * distance;
    let curved = curvature(position, guide);
    if curved.count < f32(SMOOTH_NEIGHBOURS) {
        next_estimates[pixel] = vec4f(NO_IMAGE, lobe_reach, 0.0, 3e38);
        return;
    }
    let bent = 1.0 + 2.0 * curved.curvature * distance;
    next_estimates[pixel] = vec4f(distance / max(bent, MIN_MAGNIFICATION), lobe_reach, limits);
}

/// Continues the means of the last picture. After a change of the scene it finds them only, see changed_light.wgsl.
@compute @workgroup_size(8, 8)
fn accumulate_reflected(@builtin(global_invocation_id) id: vec3u) {
    let position = vec2i(id.xy);
    if !is_inside(position) {
        return;
    }
    let pixel = pixel_index(position);
    let guide = guide_at(pixel);
    let alone = new_mean(estimates[pixel].xyz, guide.reflected_square);
    history[pixel] = alone;
    if uniforms.max_history <= 0.0 || uniforms.past_has_facets == 0u {
        return;
    }
    if guide.alpha == 0.0 {
        if uniforms.scene_changed != 0u {
            history[pixel].length = 0.0;
        }
        return;
    }
    let image = images[pixel];
    let moved = earlier(guide, pixel);
    let side = coarser_pixel(guide);
    let moves = uniforms.camera_moves != 0u;
    let mirrored = guide.position + normalize(guide.position - uniforms.position) * image.x;
    let to_middle = offset_to_middle(position, guide.position);
    let is_medium = has_medium(guide);
    var found: History;
    var max_history = uniforms.max_history;
    if is_medium {
        found = mean_at(project_before(mirrored) + to_middle, moved, image.x + path_length(guide), FINDS_MEDIUM);
        max_history = select(max_history, min(max_history, MAX_MEDIUM_HISTORY), moves);
    } else {
        // In a surface that moves, the image moves as well.
        if moves && image.x > NO_IMAGE && all(moved.position == guide.position) {
            found = mean_at(project_before(mirrored) + to_middle, moved, side, FINDS_REFLECTOR);
        }
        if found.length <= 0.0 {
            found = mean_at(project_before(moved.position) + to_middle, moved, side, FINDS_POINT);
            found.length = select(found.length, min(found.length, MAX_IMAGELESS_HISTORY), moves);
        }
        if moves && image.x > NO_IMAGE {
            let turn = curvature(position, guide).turn * uniforms.pixel * path_length(guide);
            max_history = min(max_history, guide.alpha / (turn + MIN_TURN));
        }
    }
    // What media scatter has no limits.
    found = limited(found, select(vec2f(0.0, 3e38), image.zw, moves && !is_medium), max_history);
    if uniforms.scene_changed != 0u {
        history[pixel] = found;
    } else if found.length > 0.0 {
        history[pixel] = joined(found, alone);
    }
}
