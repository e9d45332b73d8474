// Lights without a surface: points and the sun. Twin of lights.rs.

struct Light {
    place: vec3f,
    one_minus_cosine: f32,
    power: vec3f,
    probability: f32,
    threshold: f32,
    alias_: u32,
}

struct LightSample {
    direction: vec3f,
    distance: f32,
    irradiance: vec3f,
}

/// A distance beyond every scene, for lights at infinity.
const AT_INFINITY = 1e30;

/// Chooses a light and a point on it, as seen from `p`; there must be a light.
fn light_sample(p: vec3f, choice: f32, position: vec2f) -> LightSample {
    let cell = choice * f32(frame.light_count);
    var index = min(u32(cell), frame.light_count - 1u);
    if cell - f32(index) >= lights[index].threshold {
        index = lights[index].alias_;
    }
    let light = lights[index];
    let power = light.power / light.probability;
    if light.one_minus_cosine < 0.0 {
        let offset = light.place - p;
        let square = dot(offset, offset);
        let distance = sqrt(square);
        return LightSample(offset / distance, distance, power / square);
    }
    let below = light.one_minus_cosine * position.x;
    let sine = sqrt(max(below * (2.0 - below), 0.0));
    let angle = 6.2831853 * position.y;
    let direction = normalize(basis(light.place) * vec3f(sine * cos(angle), sine * sin(angle), 1.0 - below));
    return LightSample(direction, AT_INFINITY, power * (2.0 / (2.0 - light.one_minus_cosine)));
}

/// Radiance of the suns' discs in a direction, for rays that see them.
fn sun_radiance(direction: vec3f) -> vec3f {
    var radiance = vec3f(0.0);
    for (var k = 0u; k < frame.light_count; k++) {
        let x = lights[k].one_minus_cosine;
        let offset = direction - lights[k].place;
        if 0.5 * dot(offset, offset) < x {
            radiance += lights[k].power / (3.14159265 * x * (2.0 - x));
        }
    }
    return radiance;
}
