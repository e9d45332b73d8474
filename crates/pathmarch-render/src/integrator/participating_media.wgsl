// import: integrator/light_sampling, integrator/medium, nested_dielectrics, sampling/basis, sampling/unit_circle
// Media that scatter and emit. Twin of participating_media.rs, which explains them, and of scene/medium.rs.

/// Solids around a path, in scenes with nested dielectrics.
struct Solids {
    /// One more than the leaf of each, or 0.
    leaves: vec4u,
    /// Their keys, see nested_dielectrics.wgsl.
    keys: vec4u,
}

/// Medium, or the sum of the media of overlapping solids. Coefficients are per metre.
struct Medium {
    absorption: vec3f,
    /// Anisotropy times the mean of the channels of `scattering`.
    forward: f32,
    scattering: vec3f,
    /// Number of solids in the lower half, number of solids that displace the fog in the upper half.
    solids: u32,
    /// Emitted radiance, W/(m³ sr).
    emission: vec3f,
    /// Those solids, in scenes with nested dielectrics.
    around: Solids,
}

const NO_SOLIDS = Solids(vec4u(0u), vec4u(0u));

/// Medium number `index` of the scene: 0 is the fog, the others are those of the materials.
fn stored_medium(index: u32) -> Medium {
    let first = MEDIUM_DATA + MEDIUM_WORDS * index;
    let absorption = vec3u(scene_word(first), scene_word(first + 1u), scene_word(first + 2u));
    let scattering = vec3u(scene_word(first + 3u), scene_word(first + 4u), scene_word(first + 5u));
    let emission = vec3u(scene_word(first + 6u), scene_word(first + 7u), scene_word(first + 8u));
    return Medium(
        bitcast<vec3f>(absorption),
        bitcast<f32>(scene_word(first + 9u)),
        bitcast<vec3f>(scattering),
        scene_word(first + 10u),
        bitcast<vec3f>(emission),
        NO_SOLIDS,
    );
}

/// Media of the solids around the camera.
fn camera_medium() -> Medium {
    return resumed_medium(
        frame.medium,
        frame.medium_forward,
        frame.medium_scattering,
        frame.medium_solids,
        frame.medium_emission,
        frame.medium_around,
    );
}

/// Sum of two media.
fn sum_of_media(a: Medium, b: Medium) -> Medium {
    return Medium(
        a.absorption + b.absorption,
        a.forward + b.forward,
        a.scattering + b.scattering,
        a.solids + b.solids,
        a.emission + b.emission,
        a.around,
    );
}

/// True within solids that displace the fog.
fn is_displaced(medium: Medium) -> bool {
    return medium.solids >= 65536u;
}

/// Medium around a path within these solids.
fn with_fog(medium: Medium) -> Medium {
    if !PARTICIPATING_MEDIA || is_displaced(medium) {
        return medium;
    }
    return sum_of_media(medium, stored_medium(0u));
}

/// Media of the solids beyond the surface of a leaf that a path crosses.
fn medium_after(medium: Medium, leaf: u32, inside: bool) -> Medium {
    if NESTED_DIELECTRICS {
        return medium_across(medium, leaf, inside);
    }
    let solid = stored_medium(leaf_at(leaf).material + 1u);
    if THIN_GLASS && solid.solids == 0u {
        return medium;
    }
    if !inside {
        return sum_of_media(medium, solid);
    }
    let solids = medium.solids & 65535u;
    if solids <= 1u {
        return Medium(vec3f(0.0), 0.0, vec3f(0.0), 0u, vec3f(0.0), NO_SOLIDS);
    }
    let displacing = medium.solids >> 16u;
    let remaining = displacing - min(displacing, solid.solids >> 16u);
    return Medium(
        max(medium.absorption - solid.absorption, vec3f(0.0)),
        medium.forward - solid.forward,
        max(medium.scattering - solid.scattering, vec3f(0.0)),
        solids - 1u + (remaining << 16u),
        max(medium.emission - solid.emission, vec3f(0.0)),
        medium.around,
    );
}

/// Extinction coefficient: what is absorbed and what is scattered.
fn extinction_of(medium: Medium) -> vec3f {
    if !PARTICIPATING_MEDIA {
        return medium.absorption;
    }
    return medium.absorption + medium.scattering;
}

/// Mean cosine of scattering angles.
fn anisotropy_of(medium: Medium) -> f32 {
    let mean = (medium.scattering.x + medium.scattering.y + medium.scattering.z) * (1.0 / 3.0);
    return clamp(medium.forward / max(mean, 1e-30), -MAX_ANISOTROPY, MAX_ANISOTROPY);
}

/// Transmittance over a length in metres, within these solids.
fn transmittance_in(medium: Medium, length: f32) -> vec3f {
    return transmittance(extinction_of(with_fog(medium)), length);
}

/// 1 - exp(-x), without cancellation for small x.
fn absorbed_share(x: f32) -> f32 {
    return select(1.0 - exp(-x), x * (1.0 - x * (0.5 - x * 0.16666667)), x < SMALL_DEPTH);
}

/// Radiance that a medium adds to light along a length in metres.
fn emitted_radiance(medium: Medium, length: f32) -> vec3f {
    let extinction = extinction_of(medium);
    let limited = min(length, UNBOUNDED_LENGTH);
    let depth = extinction * limited;
    let share = vec3f(absorbed_share(depth.x), absorbed_share(depth.y), absorbed_share(depth.z));
    return medium.emission * select(vec3f(limited), share / extinction, extinction > vec3f(0.0));
}

/// Henyey and Greenstein's phase function, 1/sr, for the cosine between the directions before and after.
fn phase_function(anisotropy: f32, cosine: f32) -> f32 {
    let g = anisotropy;
    let square = max(1.0 + g * g - 2.0 * g * cosine, 1e-12);
    return (1.0 - g * g) / (12.566371 * square * sqrt(square));
}

/// Direction that the phase function chooses.
fn sample_phase(anisotropy: f32, incoming: vec3f, u: vec2f) -> vec3f {
    let g = anisotropy;
    var cosine = 1.0 - 2.0 * u.x;
    if abs(g) > ISOTROPIC {
        let root = (1.0 - g * g) / (1.0 + g - 2.0 * g * u.x);
        cosine = clamp((1.0 + g * g - root * root) / (2.0 * g), -1.0, 1.0);
    }
    let sine = sqrt(max(1.0 - cosine * cosine, 0.0));
    return renormalized(basis(incoming) * vec3f(sine * unit_circle(u.y), cosine));
}

/// Probabilities of the channels, in proportion to what they carry.
fn channel_weights(carried: vec3f) -> vec3f {
    let sum = carried.x + carried.y + carried.z;
    return select(vec3f(1.0 / 3.0), carried / sum, sum > 0.0);
}

/// Component of a vector for the channel that a random number chooses.
fn of_channel(weights: vec3f, random: f32, values: vec3f) -> f32 {
    return select(select(values.z, values.y, random < weights.x + weights.y), values.x, random < weights.x);
}

/// Sampled end of a segment: the distance of a scattering event, or a negative number, and the weight of the path.
struct SegmentEnd {
    distance: f32,
    weight: vec3f,
}

/// Samples the distance to the next scattering event on a segment of this length.
fn sample_distance(medium: Medium, throughput: vec3f, length: f32, u: vec2f) -> SegmentEnd {
    let extinction = extinction_of(medium);
    let weights = channel_weights(throughput);
    let sigma = of_channel(weights, u.y, extinction);
    if sigma > 0.0 {
        let t = -log(1.0 - u.x) / sigma;
        if t < min(length, UNBOUNDED_LENGTH) {
            let remaining = exp(-extinction * t);
            return SegmentEnd(t, remaining * medium.scattering / dot(weights, extinction * remaining));
        }
    }
    let remaining = transmittance(extinction, length);
    return SegmentEnd(-1.0, remaining / dot(weights, remaining));
}

/// Sampled point of a segment: its distance, and its pdf over length, 1/m.
struct SegmentPoint {
    distance: f32,
    pdf: f32,
}

/// Samples a point of a segment for the light that it scatters.
fn sample_point(ray: Ray, limited: f32, medium: Medium, throughput: vec3f, light: Light, u: vec2f) -> SegmentPoint {
    let extinction = extinction_of(medium);
    let weights = channel_weights(throughput * medium.scattering);
    let depth = extinction * limited;
    let share = vec3f(absorbed_share(depth.x), absorbed_share(depth.y), absorbed_share(depth.z));
    let is_near = light.kind != SUN && light.kind != ENVIRONMENT;
    var axis = 0.0;
    var height = 1.0;
    var first_angle = 0.0;
    var angle = 1.0;
    var choice = u.y;
    var t = 0.0;
    if is_near {
        let offset = light.position - ray.origin;
        axis = dot(offset, ray.direction);
        let across = length(offset - ray.direction * axis);
        var radius = max(light.radius, RADIUS_OF_AREA * sqrt(light.area));
        if light.kind == BOX {
            radius = sqrt(dot(light.x, light.x) + dot(light.y, light.y) + dot(light.z, light.z));
        }
        if light.kind == TRIANGLES {
            radius = light.radius;
        }
        height = max(max(across, radius), max(SMALLEST_HEIGHT * length(offset), 1e-18));
        first_angle = atan2(-axis, height);
        angle = max(atan2(limited - axis, height) - first_angle, 1e-12);
        choice = 2.0 * u.y;
    }
    if is_near && choice < 1.0 {
        t = axis + height * tan(first_angle + angle * u.x);
    } else {
        if is_near {
            choice -= 1.0;
        }
        let sigma = of_channel(weights, choice, extinction);
        let y = u.x * of_channel(weights, choice, share);
        let series = y * (1.0 + y * (0.5 + y * (0.33333333 + y * 0.25)));
        t = select(select(-log(1.0 - y), series, y < SMALL_DEPTH) / sigma, u.x * limited, sigma <= 0.0);
    }
    t = clamp(t, 0.0, limited);
    let densities = select(vec3f(1.0 / limited), extinction * exp(-extinction * t) / share, extinction > vec3f(0.0));
    var pdf = dot(weights, densities);
    if is_near {
        let d = t - axis;
        pdf = 0.5 * (pdf + height / (angle * (height * height + d * d)));
    }
    return SegmentPoint(t, pdf);
}

/// The second medium if the condition is true, else the first.
fn chosen_medium(first: Medium, second: Medium, is_second: bool) -> Medium {
    if is_second {
        return second;
    }
    return first;
}

/// Medium of a resumed path.
fn resumed_medium(absorption: vec3f, forward: f32, scattering: vec3f, solids: u32, emission: vec3f, around: vec4u) -> Medium {
    return Medium(absorption, forward, scattering, solids, emission, solids_from(around));
}

fn absorption_of(medium: Medium) -> vec3f {
    return medium.absorption;
}

fn scattering_of(medium: Medium) -> vec3f {
    return medium.scattering;
}

fn forward_of(medium: Medium) -> f32 {
    return medium.forward;
}

fn emission_of(medium: Medium) -> vec3f {
    return medium.emission;
}

fn solids_of(medium: Medium) -> u32 {
    return medium.solids;
}

fn around_of(medium: Medium) -> vec4u {
    return medium.around.leaves;
}
