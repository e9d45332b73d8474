// import: integrator/camera, integrator/light_sampling
// Camera rays that aim at emitters far out of focus. Twin of lens_targets.rs, which explains them.

/// Part of the lens from which a target is seen, a disc, in radii of the lens.
struct LensPart {
    centre: vec2f,
    /// Negative if the part lies beside the lens, or if there is no target.
    radius: f32,
}

/// Camera ray, and the weight of what it sees.
struct WeightedRay {
    ray: Ray,
    weight: f32,
}

/// Number of lights that may be targets.
fn lens_target_count() -> u32 {
    return select(0u, min(frame.light_count, MAX_LENS_TARGETS), frame.lens_radius > 0.0);
}

/// Radius of the sphere around an emitter, metres; negative if the light is none.
fn emitter_radius(light: Light) -> f32 {
    switch light.kind {
        case SPHERE, BOUNDED, DISC, TRIANGLES: {
            return light.radius;
        }
        case RECT: {
            return length(vec2f(length(light.x), length(light.z)));
        }
        case BOX: {
            return length(vec3f(length(light.x), length(light.y), length(light.z)));
        }
        default: {
            return -1.0;
        }
    }
}

/// True if an emitter, in a sphere of this radius, is seen from a small part of the lens only.
fn is_lens_target(light: Light, radius: f32) -> bool {
    let depth = dot(light.position - frame.position, frame.forward);
    return radius > 0.0 && depth > 2.0 * radius
        && radius * frame.focus <= MAX_LENS_SHARE * frame.lens_radius * abs(depth - frame.focus);
}

/// Part of the lens from which the point in focus sees a light.
fn lens_part(in_focus: vec3f, light: Light) -> LensPart {
    let sphere = emitter_radius(light);
    let apart = light.position - in_focus;
    let distance = length(apart);
    let beyond = dot(light.position - frame.position, frame.forward) - frame.focus;
    let on_lens = in_focus - apart * (frame.focus / beyond) - frame.position;
    let centre = vec2f(dot(on_lens, normalize(frame.right)), dot(on_lens, normalize(frame.up))) / frame.lens_radius;
    let sine = sphere / distance;
    let oblique = abs(beyond) / distance;
    let cosine = sqrt(max(1.0 - sine * sine, 0.0));
    let least_cosine = oblique * cosine - sqrt(max(1.0 - oblique * oblique, 0.0)) * sine;
    let length_on_lens = distance * abs(frame.focus / beyond) * sine / max(least_cosine, MIN_LENS_COSINE);
    let radius = max(length_on_lens / frame.lens_radius, MIN_LENS_PART);
    return LensPart(centre, select(-1.0, radius, is_lens_target(light, sphere) && length(centre) < 1.0 + radius));
}

/// True if the disc of a target in a picture of this size covers a pixel, or is next to it.
fn is_in_target(pixel: vec2u, size: vec2u, light: Light) -> bool {
    let radius = emitter_radius(light);
    if !is_lens_target(light, radius) {
        return false;
    }
    let offset = light.position - frame.position;
    let depth = dot(offset, frame.forward);
    let right = dot(offset, frame.right) / dot(frame.right, frame.right);
    let up = dot(offset, frame.up) / dot(frame.up, frame.up);
    let half_size = 0.5 * vec2f(size);
    let at = half_size * (1.0 + vec2f(right, -up) / depth);
    let stretch = dot(offset, offset) / (depth * depth);
    let blur = frame.lens_radius * abs(1.0 / frame.focus - 1.0 / depth);
    let reach = (radius / (depth - radius) * stretch + blur) * half_size.y / length(frame.up);
    return distance(vec2f(pixel) + 0.5, at) <= reach + EMITTER_MARGIN;
}

/// Further camera ray of a pixel of a picture of this size: the one of an index among so many.
fn further_ray(pixel: vec2u, size: vec2u, sampler: PixelSampler, index: u32, count: u32) -> WeightedRay {
    let lights = lens_target_count();
    if lights == 0u {
        return WeightedRay(camera_ray_of(pixel, size, sampler), 1.0);
    }
    let in_focus = frame.position + view_vector(pixel, size, sampler) * frame.focus;
    var parts = 0u;
    for (var k = 0u; k < lights; k++) {
        parts += select(0u, 1u, lens_part(in_focus, light_at(k)).radius >= 0.0);
    }
    let aimed = count / 2u;
    let is_aimed = index >= count - aimed && parts > 0u;
    let chosen = (index - (count - aimed)) % max(parts, 1u);
    let random = sample_2d(sampler, PAIR_LENS);
    let on_disc = sqrt(random.x) * unit_circle(random.y);
    var point = on_disc;
    var part_index = 0u;
    for (var k = 0u; k < lights; k++) {
        let part = lens_part(in_focus, light_at(k));
        if part.radius >= 0.0 {
            if is_aimed && part_index == chosen {
                point = part.centre + on_disc * part.radius;
            }
            part_index++;
        }
    }
    let from_all = f32(count - select(0u, aimed, parts > 0u));
    var own = from_all;
    var squares = from_all * from_all;
    part_index = 0u;
    for (var k = 0u; k < lights; k++) {
        let part = lens_part(in_focus, light_at(k));
        if part.radius >= 0.0 {
            let apart = point - part.centre;
            let is_own = is_aimed && part_index == chosen;
            if is_own || dot(apart, apart) <= part.radius * part.radius {
                let rays = aimed / parts + select(0u, 1u, part_index < aimed % parts);
                let density = f32(rays) / (part.radius * part.radius);
                squares += density * density;
                own = select(own, density, is_own);
            }
            part_index++;
        }
    }
    let offset = (normalize(frame.right) * point.x + normalize(frame.up) * point.y) * frame.lens_radius;
    let origin = frame.position + offset;
    return WeightedRay(
        Ray(origin, normalize(in_focus - origin)),
        select(f32(count) * own / squares, 0.0, dot(point, point) > 1.0),
    );
}
