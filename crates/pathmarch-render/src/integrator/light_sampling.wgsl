// import: sampling/basis, sampling/unit_circle, integrator/light_weights, integrator/sky, light_choice, mesh_lights
// Light sampling. Twin of light_sampling.rs, which explains it.

/// Number for the choice of light sample `k` of `count` at a surface, in a stratum of its own.
fn nth_light_choice(k: u32, count: u32, choice: f32) -> f32 {
    return min((choice + f32(k)) * (1.0 / f32(count)), ONE_MINUS_EPSILON);
}

/// Position on the light of light sample `k` at a surface.
fn nth_position(k: u32, position: vec2f) -> vec2f {
    return fract(position + fract(f32(k) * vec2f(LIGHT_STEP_X, LIGHT_STEP_Y)));
}

/// Sample of a light, before visibility.
struct LightSample {
    /// Unit vector towards the light, in world space.
    direction: vec3f,
    /// Largest distance of an occluder, metres.
    distance: f32,
    /// Monte Carlo estimate of the irradiance on a surface that faces the light, W/m².
    irradiance: vec3f,
    /// Pdf of the sample over solid angle; zero for lights that no ray hits.
    pdf: f32,
    /// Leaf that the shadow ray must hit, or NO_TARGET.
    target_leaf: u32,
    /// Sharpness of shadows from near misses; 0 for exact shadows.
    penumbra: f32,
}

/// Light that is chosen for the medium on a segment.
struct LightAlong {
    light: Light,
    index: u32,
}

/// Target of a light that the shadow ray cannot miss.
const NO_TARGET = 0xffffffffu;

/// Samples a light with the uniform number `choice`, and a direction from `p` to it with those of `position`. `normal` is the unit
/// normal of a surface that is lit on this side only, or zero. The scene must have a light.
fn sample_light(p: vec3f, normal: vec3f, choice: f32, position: vec2f) -> LightSample {
    return sample_direction(chosen_light(p, normal, choice), p, position);
}

/// Samples a direction from `p` to a chosen light.
fn sample_direction(light: Light, p: vec3f, position: vec2f) -> LightSample {
    let emission = light.emission * light.inverse_pmf;
    let offset = light.position - p;
    let square = dot(offset, offset);
    if HAS_POINT && light.kind == POINT {
        let distance = sqrt(square);
        let inverse = 1.0 / distance;
        return LightSample(offset * inverse, distance, emission * (inverse * inverse), 0.0, NO_TARGET, light.penumbra);
    }
    if HAS_SPOT && light.kind == SPOT {
        let distance = sqrt(square);
        let inverse = 1.0 / distance;
        let direction = offset * inverse;
        let irradiance = emission * (spot_falloff(light, -direction) * inverse * inverse);
        return LightSample(direction, select(0.0, distance, any(irradiance > vec3f(0.0))), irradiance, 0.0, NO_TARGET, light.penumbra);
    }
    if HAS_SUN && light.kind == SUN {
        let direction = cone_direction(light.position, light.radius, position);
        let pdf = select(0.0, light.pmf / (6.2831853 * light.radius), light.radius > 0.0);
        return LightSample(direction, AT_INFINITY, emission * (2.0 / (2.0 - light.radius)), pdf, NO_TARGET, light.penumbra);
    }
    if HAS_ENVIRONMENT && light.kind == ENVIRONMENT {
        let sample = sample_environment(position);
        // This pdf includes the choice of the light.
        let irradiance = select(vec3f(0.0), sample.radiance / sample.pdf, sample.pdf > 0.0);
        return LightSample(sample.direction, AT_INFINITY, irradiance, sample.pdf, NO_TARGET, 0.0);
    }
    if (HAS_SPHERE || HAS_BOUNDED) && (light.kind == SPHERE || light.kind == BOUNDED) {
        let one_minus_cos = subtended_cone(square, light.radius);
        let axis = select(vec3f(0.0, 1.0, 0.0), offset * inverseSqrt(max(square, 1e-30)), square > 1e-30);
        let direction = cone_direction(axis, one_minus_cos, position);
        let solid_angle = 6.2831853 * one_minus_cos;
        var distance = AT_INFINITY;
        var leaf = light.leaf;
        if HAS_SPHERE && light.kind == SPHERE {
            distance = sphere_entry(offset, direction, light.radius) * SHADOW_RAY_SHARE;
            leaf = NO_TARGET;
        }
        return LightSample(direction, distance, emission * solid_angle, light.pmf / solid_angle, leaf, 0.0);
    }
    if HAS_TRIANGLES && light.kind == TRIANGLES {
        return sample_mesh(light, p, position);
    }
    if HAS_RECT || HAS_DISC || HAS_BOX {
        return sample_area(light, p, emission, position);
    }
    return LightSample(vec3f(0.0), 0.0, vec3f(0.0), 0.0, NO_TARGET, 0.0);
}

/// Share of a spot's intensity in a direction away from it: a smoothstep of its cosine to the axis.
fn spot_falloff(light: Light, direction: vec3f) -> f32 {
    let t = clamp((dot(direction, light.y) - light.x.x) * light.x.y, 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
}

/// 1 - cosine of the half angle of the cone that a sphere subtends at this squared distance from its centre. Inside the
/// sphere it is 2, all directions.
fn subtended_cone(square: f32, radius: f32) -> f32 {
    let sine_square = radius * radius / max(square, 1e-30);
    return select(sine_square / (1.0 + sqrt(max(1.0 - sine_square, 0.0))), 2.0, sine_square >= 1.0);
}

/// Uniform direction in the cone around `axis` with this 1 - cosine of its half angle.
fn cone_direction(axis: vec3f, one_minus_cos: f32, position: vec2f) -> vec3f {
    let one_minus_cos_theta = one_minus_cos * position.x;
    let sine = sqrt(max(one_minus_cos_theta * (2.0 - one_minus_cos_theta), 0.0));
    return renormalized(basis(axis) * vec3f(sine * unit_circle(position.y), 1.0 - one_minus_cos_theta));
}

/// Distance at which a ray enters a sphere with its centre at `offset`, metres. Inside the sphere, the distance at
/// which it leaves.
fn sphere_entry(offset: vec3f, direction: vec3f, radius: f32) -> f32 {
    let along = dot(offset, direction);
    let across = offset - direction * along;
    let half_chord = sqrt(max(radius * radius - dot(across, across), 0.0));
    return select(along + half_chord, along - half_chord, along > half_chord);
}

/// Samples a point by area on the part of a rectangle, disc or box that may be visible from `p`.
fn sample_area(light: Light, p: vec3f, emission: vec3f, position: vec2f) -> LightSample {
    var point = light.position;
    var normal = light.y;
    var area = light.area;
    if HAS_RECT && light.kind == RECT {
        point += light.x * (2.0 * position.x - 1.0) + light.z * (2.0 * position.y - 1.0);
    } else if HAS_DISC && light.kind == DISC {
        let disc_point = light.radius * sqrt(position.x) * unit_circle(position.y);
        point += light.x * disc_point.x + light.z * disc_point.y;
    } else if HAS_BOX {
        let areas = visible_areas(light, p);
        area = areas.w;
        let sum = areas.x + areas.y + areas.z;
        var u = position.x * sum;
        var axis = light.x;
        var a = light.y;
        var b = light.z;
        if u < areas.x {
            u = u / max(areas.x, 1e-30);
        } else if u < areas.x + areas.y {
            u = (u - areas.x) / max(areas.y, 1e-30);
            axis = light.y;
            a = light.z;
            b = light.x;
        } else {
            u = (u - areas.x - areas.y) / max(areas.z, 1e-30);
            axis = light.z;
            a = light.x;
            b = light.y;
        }
        u = clamp(u, 0.0, 1.0);
        let along = dot(p - light.position, axis) / dot(axis, axis);
        var side = select(1.0, -1.0, along < 0.0);
        if abs(along) < 1.0 {
            side = select(1.0, -1.0, u < 0.5);
            u = fract(2.0 * u);
        }
        point += axis * side + a * (2.0 * u - 1.0) + b * (2.0 * position.y - 1.0);
        normal = normalize(axis) * side;
    }
    let offset = point - p;
    let square = dot(offset, offset);
    let distance = sqrt(square);
    let direction = offset * (1.0 / distance);
    let signed_cosine = -dot(normal, direction);
    let cosine = select(signed_cosine, abs(signed_cosine), light.kind == BOX);
    if cosine <= 0.0 {
        return LightSample(direction, 0.0, vec3f(0.0), 0.0, NO_TARGET, 0.0);
    }
    let solid_angle = area * cosine / square;
    return LightSample(
        direction,
        distance * SHADOW_RAY_SHARE,
        emission * solid_angle,
        light.pmf / solid_angle,
        NO_TARGET,
        0.0,
    );
}

/// Area of a face of a box across each axis, zero where none is visible from `p`, and the area of all visible faces.
fn visible_areas(light: Light, p: vec3f) -> vec4f {
    let offset = p - light.position;
    let size = vec3f(length(light.x), length(light.y), length(light.z));
    let areas = 4.0 * size.yzx * size.zxy;
    let along = abs(vec3f(dot(offset, light.x), dot(offset, light.y), dot(offset, light.z)));
    let visible = along > size * size;
    if !any(visible) {
        return vec4f(areas, 2.0 * (areas.x + areas.y + areas.z));
    }
    let face_areas = select(vec3f(0.0), areas, visible);
    return vec4f(face_areas, face_areas.x + face_areas.y + face_areas.z);
}

/// Pdf over solid angle of `sample_direction` for the direction from `p` to the point `hit` on the light, a record of
/// `light_from(index, p, normal)`.
fn light_pdf(light: Light, p: vec3f, hit: vec3f, cosine: f32) -> f32 {
    let t = distance(p, hit);
    if (HAS_SPHERE || HAS_BOUNDED) && (light.kind == SPHERE || light.kind == BOUNDED) {
        let offset = light.position - p;
        let one_minus_cos = subtended_cone(dot(offset, offset), light.radius);
        // A blend may extend the light beyond its bounding sphere.
        let outside = light.kind == BOUNDED && dot(hit - p, offset) < (1.0 - one_minus_cos) * t * length(offset);
        return select(light.pmf / (6.2831853 * one_minus_cos), 0.0, outside);
    }
    var area = light.area;
    if HAS_BOX && light.kind == BOX {
        area = visible_areas(light, p).w;
    }
    return light.pmf * t * t / (area * max(cosine, 1e-6));
}

/// Radiance of the suns in the direction of a ray with this pdf, times its MIS weight.
fn sun_radiance(direction: vec3f, scatter_pdf: f32) -> vec3f {
    var radiance = vec3f(0.0);
    if !HAS_SUN {
        return radiance;
    }
    for (var k = 0u; k < frame.sun_count; k++) {
        let x = light_at(k).radius;
        let offset = direction - light_at(k).position;
        if 0.5 * dot(offset, offset) < x {
            let weight = hit_weight(scatter_pdf, light_at(k).pmf / (6.2831853 * x));
            radiance += light_at(k).emission * (weight / (3.14159265 * x * (2.0 - x)));
        }
    }
    return radiance;
}
