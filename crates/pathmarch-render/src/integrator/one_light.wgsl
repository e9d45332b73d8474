// The only light of a scene, a constant. Takes the place of light_table.wgsl.

fn chosen_light(p: vec3f, normal: vec3f, choice: f32) -> Light {
    return one_light;
}

fn chosen_light_along(ray: Ray, length: f32, choice: f32) -> LightAlong {
    return LightAlong(one_light, 0u);
}

fn light_from(index: u32, p: vec3f, normal: vec3f) -> Light {
    return one_light;
}
