// import: integrator/light_weights
// Light of the sky. Twin of scene/sky.rs, which explains it.

struct EnvironmentSample {
    direction: vec3f,
    pdf: f32,
    radiance: vec3f,
}

/// Radiance of a direction, W/(m² sr), and the mean luminance of the four texels around it.
fn sky_lookup(direction: vec3f) -> vec4f {
    if SKY == SKY_CONSTANT {
        return vec4f(frame.sky_zenith, 0.0);
    }
    if SKY == SKY_GRADIENT {
        if direction.y >= 0.0 {
            let below_zenith = 1.0 - min(direction.y, 1.0);
            return vec4f(mix(frame.sky_zenith, frame.sky_horizon, below_zenith * below_zenith * below_zenith), 0.0);
        }
        return vec4f(mix(frame.sky_horizon, frame.sky_ground, smoothstep(0.0, frame.sky_edge, -direction.y)), 0.0);
    }
    let x = direction.x * frame.sky_cosine - direction.z * frame.sky_sine;
    let z = direction.x * frame.sky_sine + direction.z * frame.sky_cosine;
    let size = vec2f(f32(frame.sky_width), f32(frame.sky_height));
    let column = fract(atan2(x, -z) / 6.2831853) * size.x - 0.5;
    let angle = atan2(length(vec2f(x, z)), direction.y);
    let row = clamp(angle / 3.14159265 * size.y - 0.5, 0.0, size.y - 1.0);
    let left = u32(floor(column) + size.x) % frame.sky_width;
    let right = (left + 1u) % frame.sky_width;
    let upper = u32(row);
    let lower = min(upper + 1u, frame.sky_height - 1u);
    let a = scene_vector(upper * frame.sky_width + left).xyz;
    let b = scene_vector(upper * frame.sky_width + right).xyz;
    let c = scene_vector(lower * frame.sky_width + left).xyz;
    let d = scene_vector(lower * frame.sky_width + right).xyz;
    let s = column - floor(column);
    let radiance = mix(mix(a, b, s), mix(c, d, s), fract(row));
    return vec4f(radiance, 0.25 * dot(a + b + c + d, vec3f(0.2126, 0.7152, 0.0722)));
}

/// Radiance of the sky in the direction of a ray with this pdf, times its MIS weight.
fn sky_radiance(direction: vec3f, scatter_pdf: f32) -> vec3f {
    let sky = sky_lookup(direction);
    if frame.sky_pdf_scale > 0.0 {
        return sky.xyz * hit_weight(scatter_pdf, frame.sky_pdf_scale * sky.w);
    }
    return sky.xyz;
}

/// Radiance of a sky that is not sampled; zero for an environment map.
fn unsampled_sky_radiance(direction: vec3f) -> vec3f {
    return select(sky_lookup(direction).xyz, vec3f(0.0), frame.sky_pdf_scale > 0.0);
}

/// Samples a direction of the environment map in proportion to its luminance.
fn sample_environment(position: vec2f) -> EnvironmentSample {
    let row = sample_alias_table(SKY_DATA, frame.sky_height + 1u, position.y);
    let columns = SKY_DATA + 2u * (frame.sky_height + 1u + u32(row.x) * frame.sky_width);
    let column = sample_alias_table(columns, frame.sky_width, position.x);
    let height = f32(frame.sky_height);
    let q_top = sin(1.57079633 * max(row.x - 0.5, 0.0) / height);
    let q_bottom = sin(1.57079633 * min(row.x + 0.5, height) / height);
    let q = mix(q_top * q_top, q_bottom * q_bottom, row.y);
    let angle = 6.2831853 * (column.x + 0.5 + column.y) / f32(frame.sky_width);
    let radius = 2.0 * sqrt(max(q * (1.0 - q), 0.0));
    let x = radius * sin(angle);
    let z = -radius * cos(angle);
    let direction = normalize(vec3f(
        x * frame.sky_cosine + z * frame.sky_sine, 1.0 - 2.0 * q, z * frame.sky_cosine - x * frame.sky_sine,
    ));
    let sky = sky_lookup(direction);
    return EnvironmentSample(direction, frame.sky_pdf_scale * sky.w, sky.xyz);
}

/// Samples an index with an alias table of `count` cells and a uniform number. Returns the index and the number
/// remapped to 0..1.
fn sample_alias_table(table: u32, count: u32, u: f32) -> vec2f {
    let scaled = u * f32(count);
    let cell = min(u32(scaled), count - 1u);
    let remapped = scaled - f32(cell);
    let threshold = bitcast<f32>(scene_word(table + 2u * cell));
    if remapped < threshold {
        return vec2f(f32(cell), clamp(remapped / threshold, 0.0, 1.0));
    }
    return vec2f(f32(scene_word(table + 2u * cell + 1u)), clamp((remapped - threshold) / (1.0 - threshold), 0.0, 1.0));
}
