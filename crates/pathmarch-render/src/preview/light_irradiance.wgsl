// import: integrator/light_sampling
// Irradiance of unoccluded lights. Twin of light_irradiance.rs, which explains it.

/// Unoccluded light at a point of a surface.
struct UnoccludedLight {
    /// Unit vector to the centre of the light's part above the horizon.
    direction: vec3f,
    /// Largest distance of an occluder, metres.
    distance: f32,
    /// Irradiance of the surface, cosine included, W/m².
    irradiance: vec3f,
    /// Sine of half the angle that the light subtends.
    sine: f32,
}

/// Unoccluded light at the point `p` of a surface with normal `n`. A sphere of `radius` replaces boxes and bounded
/// lights.
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
    if HAS_SPOT && light.kind == SPOT {
        let irradiance = light.emission * (spot_falloff(light, -direction) * max(dot(direction, n), 0.0) / square);
        return UnoccludedLight(direction, distance, irradiance, 0.0);
    }
    if (HAS_RECT && light.kind == RECT) || (HAS_DISC && light.kind == DISC) {
        return from_sheet(light, offset, n);
    }
    let sine = min(radius / distance, 1.0);
    let irradiance = light.emission * (3.14159265 * sine * sine * clipped_cosine(dot(direction, n), sine));
    return UnoccludedLight(direction, max(distance - radius, 0.0), irradiance, sine);
}

/// Cosine factor of a sphere's irradiance: the cosine to its centre, less where the horizon cuts the sphere.
fn clipped_cosine(cosine: f32, sine: f32) -> f32 {
    let visible = max(cosine + sine, 0.0);
    return select(visible * visible / max(4.0 * sine, 1e-6), cosine, cosine >= sine);
}

/// Unoccluded light of a rectangle or disc.
fn from_sheet(light: Light, offset: vec3f, n: vec3f) -> UnoccludedLight {
    let half = select(1.0, 0.8862269 * light.radius, light.kind == DISC);
    let x = light.x * half;
    let z = light.z * half;
    let plane_distance = -dot(offset, light.y);
    let a = normalize(offset + x + z);
    let b = normalize(offset + x - z);
    let c = normalize(offset - x - z);
    let d = normalize(offset - x + z);
    var vector_factor = edge_term(a, b) + edge_term(b, c) + edge_term(c, d) + edge_term(d, a);
    vector_factor *= select(1.0, -1.0, dot(vector_factor, offset) < 0.0);
    let form_factor = length(vector_factor);
    if plane_distance <= 0.0 || form_factor < 1e-9 {
        return UnoccludedLight(light.y, 0.0, vec3f(0.0), 0.0);
    }
    let direction = vector_factor / form_factor;
    let cosine = -dot(direction, light.y);
    let distance = plane_distance / max(cosine, 1e-4);
    let radius = sqrt(4.0 / 3.14159265 * length(x) * length(z));
    let irradiance = light.emission * (3.14159265 * form_factor * clipped_cosine(dot(direction, n), sqrt(min(form_factor, 1.0))));
    let foreshortened_radius = radius * max(cosine, 0.0);
    let sine = foreshortened_radius / sqrt(foreshortened_radius * foreshortened_radius + distance * distance);
    return UnoccludedLight(direction, distance * max(1.0 - radius / distance, 0.3), irradiance, sine);
}

/// Lambert's term of an edge: the angle between two directions times the unit normal of both, divided by 2π.
fn edge_term(a: vec3f, b: vec3f) -> vec3f {
    let x = dot(a, b);
    let y = abs(x);
    let v = (0.8543985 + (0.4965155 + 0.0145206 * y) * y) / (3.417594 + (4.1616724 + y) * y);
    return cross(a, b) * select(0.5 * inverseSqrt(max(1.0 - x * x, 1e-7)) - v, v, x > 0.0);
}
