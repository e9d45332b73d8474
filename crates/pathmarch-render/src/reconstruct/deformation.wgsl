// import: reconstruct/pass
// Points on the earlier surface of objects that deform. Twin of `on_surface` in motion.rs. In front of it is the code of the
// earlier field of these objects, whose numbers are in `field_parameters`.

/// Replaces the earlier points of objects that deform by points of their earlier surface; by points far from everything
/// where there are none.
@compute @workgroup_size(8, 8)
fn find_earlier_surface(@builtin(global_invocation_id) id: vec3u) {
    let position = vec2i(id.xy);
    if !is_inside(position) {
        return;
    }
    let pixel = pixel_index(position);
    let guide = guide_at(pixel);
    if guide.leaf == NO_LEAF || leaf_motions[min(guide.leaf, arrayLength(&leaf_motions) - 1u)].deforms == 0u {
        return;
    }
    let moved = earlier(guide, pixel);
    var p = moved.position;
    let tolerance = SURFACE_TOLERANCE * uniforms.pixel * path_length(guide);
    var found = surface(p, SPHERE_TRACED, NO_TRIANGLE, 0u);
    for (var k = 0u; k < EARLIER_STEPS && abs(found.distance) > 0.1 * tolerance; k++) {
        let square = max(dot(found.gradient, found.gradient), MIN_SQUARED_GRADIENT);
        p -= found.gradient * (found.distance / square);
        found = surface(p, SPHERE_TRACED, NO_TRIANGLE, 0u);
    }
    let normal = found.gradient / max(length(found.gradient), 1e-6);
    // On the side of the camera, as the normal of the guide.
    let side = select(1.0, -1.0, dot(normal, moved.normal) < 0.0);
    let is_near = abs(found.distance) <= tolerance;
    earlier_points[pixel] = earlier_words(SurfacePoint(select(vec3f(NOWHERE), p, is_near), normal * side));
}
