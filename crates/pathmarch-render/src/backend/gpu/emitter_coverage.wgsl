// import: backend/gpu/buffers, backend/gpu/film, guides, integrator/camera, integrator/camera_emission
// import: integrator/emitter_coverage, integrator/lens_targets
// Entry point: coverage of the pixels of a live picture by emitters, in place of the film. Twin of `EmitterLayer` in
// reconstruct/emitters.rs. Eight lanes trace the rays of a pixel, and look at the eight samples around its own.

/// Emission along the ray of each lane, times its weight, which is in w if it is that of an emitter, and what the lane found
/// beside the pixel.
var<workgroup> emissions: array<vec4f, 64>;
var<workgroup> neighbours: array<u32, 64>;

/// Words of the guide of a sample that tell its emitter.
fn emitter_words(sample: u32) -> EmitterWords {
    return EmitterWords(guides[4u * sample + 1u], guides[4u * sample + 2u]);
}

@compute @workgroup_size(64)
fn trace(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    load_frame();
    end_guide();
    let size = vec2u(slice.columns, slice.rows);
    let samples = vec2u(frame.width, frame.height);
    let pixel = COVERAGES_PER_GROUP * (group.y * MAX_GROUPS_ACROSS + group.x) + lane / COVERAGE_RAYS;
    let exists = pixel < size.x * size.y;
    let position = select(vec2u(0u), vec2u(pixel % size.x, pixel / size.x), exists);
    let factor = vec2f(size) / vec2f(samples);
    let sample_position = min(vec2u((vec2f(position) + 0.5) / factor), samples - 1u);
    let here = emitter_words(sample_position.y * samples.x + sample_position.x);
    let ray_of_pixel = lane % COVERAGE_RAYS;
    // The ninth of the square is the sample itself.
    let neighbour = i32(ray_of_pixel + select(0u, 1u, ray_of_pixel >= 4u));
    let beside = vec2i(sample_position) + vec2i(neighbour % 3 - 1, neighbour / 3 - 1);
    neighbours[lane] = 0u;
    if all(beside >= vec2i(0)) && all(beside < vec2i(samples)) {
        neighbours[lane] = emitter_relation(here, emitter_words(u32(beside.y) * samples.x + u32(beside.x)));
    }
    for (var k = ray_of_pixel; k < lens_target_count(); k += COVERAGE_RAYS) {
        neighbours[lane] |= select(0u, HAS_LENS_TARGET, is_in_target(sample_position, samples, light_at(k)));
    }
    workgroupBarrier();
    var relations = emitter_relation(here, here);
    for (var k = 0u; k < COVERAGE_RAYS; k++) {
        relations = joined_relations(relations, neighbours[lane - ray_of_pixel + k]);
    }
    let place = emitter_place(here, relations);
    let has_rays = place == AT_EMITTER_EDGE || place == IN_LENS_TARGET;
    emissions[lane] = vec4f(0.0);
    // A loop, since llvmpipe skips no branches.
    for (var k = 0u; k < select(0u, 1u, exists && has_rays); k++) {
        let sampler =
            pixel_sampler(position.x, position.y, slice.sample * COVERAGE_RAYS + ray_of_pixel, hash(~frame.seed));
        let camera = further_ray(position, size, sampler, ray_of_pixel, COVERAGE_RAYS);
        let seen = emission_along(camera.ray, sampler);
        emissions[lane] = select(vec4f(0.0), vec4f(kept(seen.xyz).xyz, 1.0) * camera.weight, seen.w > 0.0);
    }
    workgroupBarrier();
    if exists && ray_of_pixel == 0u {
        var sum = vec4f(0.0);
        for (var k = 0u; k < COVERAGE_RAYS; k++) {
            sum += emissions[lane + k];
        }
        var coverage = sum / f32(COVERAGE_RAYS);
        if has_rays {
            let share = max(coverage.w, LEAST_COVERAGE);
            coverage.w = select(share, -share, place == IN_LENS_TARGET);
        }
        let within = vec4f(0.0, 0.0, 0.0, FULL_COVERAGE);
        store_film(pixel, select(coverage, within, place == WITHIN_EMITTERS));
    }
}
