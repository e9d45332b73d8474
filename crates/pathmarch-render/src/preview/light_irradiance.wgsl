// import: integrator/light_sampling
// Irradiance of lights without occlusion. Twin of light_irradiance.rs, which explains it.

struct UnoccludedLight {
    direction: vec3f,
    distance: f32,
    irradiance: vec3f,
    sine: f32,
}

fn unoccluded_light(light: Light, radius: f32, p: vec3f, n: vec3f) -> UnoccludedLight {
    if HAS_SUN && light.kind == SUN {
        let sine = sqrt(max(light.radius * (2.0 - light.radius), 0.0));
        return UnoccludedLight(light.position, AT_INFINITY, light.emission * max(dot(light.position, n), 0.0), sine);
    }
    let offset = light.position - p;
    let square = max(dot(offset, offset), 1e-12);
    let distance = sqrt(square);
    let direction = offset / distance;
    if HAS_POINT && light.kind == POINT {
        return UnoccludedLight(direction, distance, light.emission * (max(dot(direction, n), 0.0) / square), 0.0);
    }
    if (HAS_RECT && light.kind == RECT) || (HAS_DISC && light.kind == DISC) {
        return from_sheet(light, offset, n);
    }
    let sine = min(radius / distance, 1.0);
    let irradiance = light.emission * (3.14159265 * sine * sine * above_horizon(dot(direction, n), sine));
    return UnoccludedLight(direction, max(distance - radius, 0.0), irradiance, sine);
}

/// The cosine of a sphere's middle, or what is left of it where the horizon cuts the sphere.
fn above_horizon(cosine: f32, sine: f32) -> f32 {
    let shown = max(cosine + sine, 0.0);
    return select(shown * shown / max(4.0 * sine, 1e-6), cosine, cosine >= sine);
}

fn from_sheet(light: Light, offset: vec3f, n: vec3f) -> UnoccludedLight {
    let half = select(1.0, 0.8862269 * light.radius, light.kind == DISC);
    let x = light.x * half;
    let z = light.z * half;
    let below = -dot(offset, light.y);
    let a = normalize(offset + x + z);
    let b = normalize(offset + x - z);
    let c = normalize(offset - x - z);
    let d = normalize(offset - x + z);
    var factor = edge(a, b) + edge(b, c) + edge(c, d) + edge(d, a);
    factor *= select(1.0, -1.0, dot(factor, offset) < 0.0);
    let share = length(factor);
    if below <= 0.0 || share < 1e-9 {
        return UnoccludedLight(light.y, 0.0, vec3f(0.0), 0.0);
    }
    let direction = factor / share;
    let toward = -dot(direction, light.y);
    let distance = below / max(toward, 1e-4);
    let radius = sqrt(4.0 / 3.14159265 * length(x) * length(z));
    let irradiance = light.emission * (3.14159265 * share * above_horizon(dot(direction, n), sqrt(min(share, 1.0))));
    let narrow = radius * max(toward, 0.0);
    let sine = narrow / sqrt(narrow * narrow + distance * distance);
    return UnoccludedLight(direction, distance * max(1.0 - radius / distance, 0.3), irradiance, sine);
}

/// Angle between two directions times the unit vector across both, over 2π.
fn edge(a: vec3f, b: vec3f) -> vec3f {
    let x = dot(a, b);
    let y = abs(x);
    let v = (0.8543985 + (0.4965155 + 0.0145206 * y) * y) / (3.417594 + (4.1616724 + y) * y);
    return cross(a, b) * select(0.5 * inverseSqrt(max(1.0 - x * x, 1e-7)) - v, v, x > 0.0);
}
