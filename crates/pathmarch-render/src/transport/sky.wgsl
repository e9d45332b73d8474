// stub
struct EnvironmentSample {
    direction: vec3f,
    radiance: vec3f,
    pdf: f32,
}
fn sky_beyond(direction: vec3f, scatter_pdf: f32) -> vec3f { return SKY_COLOUR; }
fn sky_not_sampled(direction: vec3f) -> vec3f { return SKY_COLOUR; }
fn environment_sample(position: vec2f) -> EnvironmentSample { return EnvironmentSample(vec3f(0.0), vec3f(0.0), 0.0); }
