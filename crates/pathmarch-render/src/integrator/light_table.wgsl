// Choice of a light by one alias table for all places. Twin of `choose_light` in light_sampling.rs.

/// Light that the uniform number `choice` chooses.
fn chosen_light(p: vec3f, normal: vec3f, choice: f32) -> Light {
    return light_at(chosen_index(choice));
}

/// Light that the uniform number `choice` chooses for the medium on a segment.
fn chosen_light_along(ray: Ray, length: f32, choice: f32) -> LightAlong {
    let index = chosen_index(choice);
    return LightAlong(light_at(index), index);
}

/// Index of the light that the uniform number `choice` chooses.
fn chosen_index(choice: f32) -> u32 {
    let cell = choice * f32(frame.light_count);
    var index = min(u32(cell), frame.light_count - 1u);
    if cell - f32(index) >= light_at(index).threshold {
        index = light_at(index).alias_light;
    }
    return index;
}

/// Light with the probability that it is chosen.
fn light_from(index: u32, p: vec3f, normal: vec3f) -> Light {
    return light_at(index);
}
