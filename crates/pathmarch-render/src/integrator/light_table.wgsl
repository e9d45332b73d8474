// Choice of a light by one alias table for all places. Twin of `choose_light` in light_sampling.rs.

/// Light that the uniform number `choice` chooses.
fn chosen_light(p: vec3f, normal: vec3f, choice: f32) -> Light {
    let cell = choice * f32(frame.light_count);
    var index = min(u32(cell), frame.light_count - 1u);
    if cell - f32(index) >= lights[index].threshold {
        index = lights[index].alias_light;
    }
    return lights[index];
}

/// Light with the probability that it is chosen.
fn light_from(index: u32, p: vec3f, normal: vec3f) -> Light {
    return lights[index];
}
