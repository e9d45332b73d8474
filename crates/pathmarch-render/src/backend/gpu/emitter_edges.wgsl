// import: backend/gpu/buffers, integrator/camera, integrator/camera_emission, integrator/camera_ray_index
// import: integrator/lens_targets
// Entry point: further camera rays at the edges of emitters in a slice. Twin of emitter_edges.rs, which explains them. Sixteen
// lanes trace the rays of a pixel: the further ones, and the last lane the path's own.

/// Emission along the ray of each lane.
var<workgroup> emissions: array<vec3f, 64>;

@compute @workgroup_size(64)
fn trace(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    load_frame();
    let edge = EDGES_PER_GROUP * (group.y * MAX_GROUPS_ACROSS + group.x) + lane / RAYS_PER_EDGE;
    let exists = edge < slice.edges;
    let pixel = select(0u, scene_word(EDGE_DATA + slice.first_edge + min(edge, slice.edges - 1u)), exists);
    let x = pixel % frame.width;
    let y = pixel / frame.width;
    let is_inside = exists && x >= slice.first_column && x < slice.first_column + slice.columns;
    let ray_of_pixel = lane % RAYS_PER_EDGE;
    emissions[lane] = vec3f(0.0);
    if is_inside {
        let camera_ray_index = camera_ray_index(slice.sample);
        var sampler = pixel_sampler(x, y, camera_ray_index, frame.seed);
        var camera = WeightedRay(camera_ray(x, y, sampler), 1.0);
        if ray_of_pixel < EDGE_RAYS {
            sampler = pixel_sampler(x, y, camera_ray_index * RAYS_PER_EDGE + ray_of_pixel, hash(~frame.seed));
            camera = further_ray(vec2u(x, y), vec2u(frame.width, frame.height), sampler, ray_of_pixel, EDGE_RAYS);
        }
        emissions[lane] = emission_along(camera.ray, sampler).xyz * camera.weight;
    }
    workgroupBarrier();
    if is_inside && ray_of_pixel == 0u {
        var sum = vec3f(0.0);
        for (var k = 0u; k < EDGE_RAYS; k++) {
            sum += emissions[lane + k];
        }
        let difference = f32(slice.samples) * (sum / f32(EDGE_RAYS) - emissions[lane + EDGE_RAYS]);
        // The film rejects samples that are not finite. Comparisons with NaN are false.
        if all(abs(difference) < vec3f(1e30)) {
            store_film(pixel, film_sum(pixel) + vec4f(difference, 0.0));
        }
    }
}
