// import: integrator/guide
// Light that the facets of the guide's surface reflect, recorded with the path. Twin of reflected_light.rs.

/// The recorder waits for nothing.
const FACETS_DONE = 0u;
/// It waits for the samples of the surface.
const FACETS_SAMPLE = 1u;
/// It waits for the next vertex of the path.
const FACETS_ARRIVE = 2u;

var<private> facets_state: u32;
/// Length of the path at the surface, metres.
var<private> facets_length: f32;
/// Light of the light sample that the facets reflect, and the distance of the light.
var<private> facets_sampled: vec3f;
var<private> facets_sampled_distance: f32;
/// Radiance of the path before it went on, the share of the facets in the rest, and the distance to the next vertex.
var<private> facets_before: vec3f;
var<private> facets_share: vec3f;
var<private> facets_distance: f32;
/// Least alpha with which the light is filtered, see reflected_light.rs.
var<private> facets_least_alpha: f32;

/// Starts with a surface at this length of the path.
fn begin_facets(length: f32) {
    facets_state = FACETS_SAMPLE;
    facets_length = length;
    facets_sampled = vec3f(0.0);
    facets_sampled_distance = 0.0;
    facets_share = vec3f(0.0);
    facets_before = vec3f(0.0);
    facets_distance = frame.far;
    facets_least_alpha = 0.0;
}

/// Records the light that a light sample contributed from a direction.
fn record_light_sample(m: u32, wo: vec3f, wi: vec3f, inside: bool, distance: f32, light: vec3f) {
    if facets_state == FACETS_SAMPLE {
        facets_sampled = light * bsdf_facet_share(material_at(m).kind, m, wo, wi, inside);
        facets_sampled_distance = distance;
    }
}

/// Records the direction in which a path of this radiance goes on.
fn record_next_ray(m: u32, wo: vec3f, wi: vec3f, inside: bool, radiance: vec3f) {
    if facets_state == FACETS_SAMPLE {
        facets_share = bsdf_facet_share(material_at(m).kind, m, wo, wi, inside);
        let chance = bsdf_facet_chance(material_at(m).kind, m, wo, inside);
        let deviation = sqrt(max(1.0 - chance, 0.0) / max(chance, 1e-6));
        facets_least_alpha = min(CHOSEN_ALPHA * deviation, MAX_FACET_ALPHA);
        facets_before = radiance;
        facets_state = FACETS_ARRIVE;
    }
}

/// Records the length of the path at its next vertex; it has not grown if there is none.
fn record_arrival(length: f32) {
    if facets_state == FACETS_ARRIVE {
        facets_distance = select(frame.far, length - facets_length, length > facets_length);
        facets_state = FACETS_DONE;
    }
}

/// Light of the facets of a path of this radiance, and the depth of what they mirror.
fn reflected_light(radiance: vec3f) -> vec4f {
    let rest = (radiance - facets_before) * facets_share;
    let near = max(luminance(facets_sampled), 0.0);
    let farther = max(luminance(rest), 0.0);
    let distances = min(vec2f(facets_sampled_distance, facets_distance), vec2f(frame.far));
    let depths = distances / (distances + facets_length);
    let depth = select(depths.y, (depths.x * near + depths.y * farther) / max(near + farther, 1e-30), near + farther > 0.0);
    return vec4f(facets_sampled + rest, depth);
}
