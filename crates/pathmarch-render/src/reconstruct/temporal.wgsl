// import: reconstruct/direct, reconstruct/history
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
    let irradiance = direct_irradiance(id.xy, pixel, guide);
    estimates[pixel] = vec4f(irradiance, luminance(irradiance));
    earlier_points[pixel] = earlier_words(moved_back(guide));
    if guide.object != OBJECT_BITS {
        let flags = guides[4u * pixel + 2u].x & ~OBJECT_BITS;
        guides[4u * pixel + 2u].x = flags | leaf_motions[guide.object].object;
        guides[4u * pixel + 2u].y = leaf_motions[guide.seen_object].object
            | (guides[4u * pixel + 2u].y & (MIXED_BIT | COLOURED_BIT));
    }
}

/// Continues the means of the last picture. After a change of the scene it finds them only, see changed_light.wgsl.
@compute @workgroup_size(8, 8)
fn accumulate(@builtin(global_invocation_id) id: vec3u) {
    let position = vec2i(id.xy);
    if !is_inside(position) {
        return;
    }
    let pixel = pixel_index(position);
    let guide = guide_at(pixel);
    let irradiance = estimates[pixel].xyz;
    let alone = new_mean(irradiance, direct_square(guide, luminance(irradiance)));
    history[pixel] = alone;
    if uniforms.max_history <= 0.0 {
        return;
    }
    let moved = earlier(guide, pixel);
    let place = project_before(moved.position) + offset_to_middle(position, guide.position);
    var found = mean_at(place, moved, coarser_pixel(guide), FINDS_POINT);
    var max_length = uniforms.max_history;
    if uniforms.camera_moves != 0u {
        if guide.is_glossy && !has_facets(guide) {
            max_length = min(max_length, MAX_GLOSSY_HISTORY);
        } else if curvature(position, guide).count < f32(SMOOTH_NEIGHBOURS) {
            max_length = min(max_length, MAX_ROUGH_HISTORY);
        }
    }
    found.length = min(found.length, max_length);
    if uniforms.scene_changed != 0u {
        history[pixel] = found;
    } else if found.length > 0.0 {
        history[pixel] = joined(found, alone);
    }
}
