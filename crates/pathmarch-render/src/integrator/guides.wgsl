// import: integrator/camera, integrator/guide, integrator/medium_light, integrator/reflected_light
// import: shading/surface_interaction
// Recorder of guides. Twin of guides.rs.

/// Guides of all pixels, four vectors each.
@group(0) @binding(10) var<storage, read_write> guides: array<vec4u>;

/// The recorder waits for the first surface that is no mirror.
const GUIDE_MIRRORED = 0u;
/// It waits for the first surface that scatters light, seen through glass.
const GUIDE_BEHIND_GLASS = 1u;
/// It waits for nothing.
const GUIDE_DONE = 2u;

/// Guide of the path, its camera ray, and the state of the recorder.
var<private> guide: Guide;
var<private> guide_ray: Ray;
var<private> guide_state: u32;
/// Whether a surface that scatters light waits for another, and the radiance of the path before that one's light.
var<private> waits_for_indirect: bool;
var<private> has_indirect: bool;
var<private> direct_radiance: vec3f;
/// Whether indirect light of the surface is recorded apart, and the light of the second surfaces of other pixels' paths.
var<private> separates_indirect: bool;
var<private> shared_light: vec3f;
/// Product of the mirror reflections so far.
var<private> guide_mirrors: mat3x3f;
/// Light of the media on the first segments, its luminance, and the sum of that times the distance from the camera.
var<private> medium_light: vec3f;
var<private> medium_weight: f32;
var<private> medium_weighted_distance: f32;
/// Distance of the scattering event that ends them, negative if there is none, and the radiance before it.
var<private> event_distance: f32;
var<private> event_radiance: vec3f;

/// Starts with the guide of the sky.
fn begin_guide(camera: Ray) {
    guide_ray = camera;
    guide_state = GUIDE_MIRRORED;
    guide_mirrors = mat3x3f(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0);
    guide.position = central_point(camera, camera.origin + camera.direction * frame.far);
    guide.normal = -camera.direction;
    guide.seen_normal = -camera.direction;
    guide.guide_class = GUIDE_SKY;
    guide.albedo = vec3f(1.0);
    guide.object = OBJECT_BITS;
    guide.seen_object = OBJECT_BITS;
    guide.is_mixed = false;
    guide.leaf = NO_LEAF;
    guide.mirror = MIRROR_BIT;
    guide.is_glossy = false;
    guide.alpha = 0.0;
    guide.has_coloured_facets = false;
    medium_light = vec3f(0.0);
    medium_weight = 0.0;
    medium_weighted_distance = 0.0;
    event_distance = -1.0;
    facets_state = FACETS_DONE;
    waits_for_indirect = false;
    has_indirect = false;
    separates_indirect = false;
    shared_light = vec3f(0.0);
}

/// Reports whether the recorder waits for a surface.
fn guide_waits() -> bool {
    return guide_state != GUIDE_DONE;
}

/// Ends the recording of a path.
fn end_guide() {
    guide_state = GUIDE_DONE;
    waits_for_indirect = false;
}

/// Records that a path passes through a medium on its first segments, which contributes this light around a point.
fn record_medium(p: vec3f, light: vec3f) {
    let weight = max(luminance(light), 0.0);
    guide.alpha = MEDIUM_ALPHA;
    medium_light += light;
    medium_weight += weight;
    medium_weighted_distance += weight * distance(p, guide_ray.origin);
}

/// Records that a path of this radiance scatters at a point in a medium. What follows is light of the medium before the first
/// surface, and indirect light behind one that scatters light.
fn record_event(p: vec3f, surface_index: u32, radiance: vec3f) {
    if surface_index == 0u {
        event_distance = distance(p, guide_ray.origin);
        event_radiance = radiance;
    } else if waits_for_indirect {
        waits_for_indirect = false;
        has_indirect = true;
        direct_radiance = radiance;
    }
}

/// Light of the media on the first segments of a path of this radiance, and its depth.
fn light_of_media(radiance: vec3f) -> vec4f {
    let later = select(vec3f(0.0), radiance - event_radiance, event_distance >= 0.0);
    let weight = max(luminance(later), 0.0);
    let weighted_distance = medium_weighted_distance + weight * event_distance;
    return vec4f(medium_light + later, depth_in_medium(weighted_distance / max(medium_weight + weight, 1e-30), frame.far));
}

/// Records that a path of this radiance has reached a surface that scatters light, unless it is a mirror or glass.
fn record_scattering(m: u32, surface_index: u32, radiance: vec3f) {
    let is_delta = (material_at(m).flags & DELTA) != 0u && surface_index < MAX_DELTA_SURFACES;
    if waits_for_indirect && !is_delta {
        waits_for_indirect = false;
        has_indirect = surface_index <= frame.bounces;
        direct_radiance = radiance;
    }
}

/// Records light of second surfaces that a group of pixels shares.
fn record_shared(light: vec3f) {
    shared_light = light;
}

/// Records the surface that a path has reached with this throughput and length; `colour` is its base colour.
fn record_guide(
    interaction: SurfaceInteraction,
    throughput: vec3f,
    length: f32,
    surface_index: u32,
    colour: vec3f,
) {
    if guide_state == GUIDE_DONE {
        return;
    }
    let flags = material_at(leaf_at(interaction.leaf).material).flags;
    let is_delta = (flags & DELTA) != 0u && surface_index < MAX_DELTA_SURFACES;
    let is_glass = is_delta && (flags & TRANSMITS) != 0u;
    if guide_state == GUIDE_BEHIND_GLASS {
        if !is_delta {
            guide.seen_normal = interaction.normal;
            guide.seen_object = interaction.leaf;
            guide_state = GUIDE_DONE;
        }
        return;
    }
    let n = interaction.normal;
    if is_delta && !is_glass {
        if surface_index == 0u {
            guide.mirror = packed_first_mirror(distance(interaction.p, guide_ray.origin), n);
            guide.object = interaction.leaf;
            guide.seen_object = interaction.leaf;
        }
        // For the sky, if no surface follows.
        guide.normal = reflect(guide.normal, n);
        guide.seen_normal = guide.normal;
        let reflection = mat3x3f(
            vec3f(1.0, 0.0, 0.0) - 2.0 * n.x * n,
            vec3f(0.0, 1.0, 0.0) - 2.0 * n.y * n,
            vec3f(0.0, 0.0, 1.0) - 2.0 * n.z * n,
        );
        guide_mirrors = guide_mirrors * reflection;
        return;
    }
    guide_state = select(GUIDE_DONE, GUIDE_BEHIND_GLASS, is_glass);
    // The length of a path starts anew at the boundaries of media.
    let starts_anew = HAS_BOUNDARIES && surface_index == 0u;
    let distance_along_ray = select(length, distance(interaction.p, guide_ray.origin), starts_anew);
    guide.position = central_point(guide_ray, guide_ray.origin + guide_ray.direction * distance_along_ray);
    guide.normal = guide_mirrors * n;
    guide.seen_normal = guide.normal;
    guide.guide_class = select(select(GUIDE_SURFACE, GUIDE_GLASS, is_glass), GUIDE_EMITTER, (flags & EMITS) != 0u);
    // Nothing is smooth on a fractal at half the resolution.
    let is_fractal = (leaf_at(interaction.leaf).flags & FRACTAL) != 0u;
    waits_for_indirect = guide.guide_class == GUIDE_SURFACE && !is_fractal;
    separates_indirect = waits_for_indirect && surface_index == 0u;
    guide.albedo = select(throughput * colour, vec3f(1.0), is_glass);
    guide.object = interaction.leaf;
    guide.seen_object = interaction.leaf;
    guide.leaf = select(NO_LEAF, interaction.leaf, surface_index == 0u);
    guide.is_glossy = is_glass || (flags & GLOSSY) != 0u;
    if guide.guide_class == GUIDE_SURFACE && guide.is_glossy && guide.alpha == 0.0 {
        let m = leaf_at(interaction.leaf).material;
        let facets = bsdf_facets(material_at(m).kind, m);
        guide.alpha = select(0.0, facets.x, facets.x <= select(MAX_FACET_ALPHA, MAX_FACET_ALPHA_OF_FRACTALS, is_fractal));
        guide.has_coloured_facets = facets.y > 0.0;
        begin_facets(length);
    }
}

/// Stores the guide of a pixel whose sample has this radiance. The surface is that of the first sample, albedo and square
/// are means.
fn store_guide(pixel: u32, radiance: vec3f) {
    if slice.guide_samples == 0u {
        return;
    }
    let irradiance = luminance(radiance / divisor(guide));
    var stored = guide;
    stored.square = irradiance * irradiance;
    stored.reflected = vec3f(0.0);
    stored.reflected_square = 0.0;
    stored.depth = 0.0;
    // Rejected samples have no light at all.
    let has_light = any(radiance != vec3f(0.0));
    // Other paths of the group bring light to one without a second surface.
    let shared_indirect = select(vec3f(0.0), shared_light, separates_indirect);
    stored.indirect = select(shared_indirect, radiance - direct_radiance, has_indirect);
    stored.indirect = select(vec3f(0.0), stored.indirect, has_light);
    if guide.alpha > 0.0 {
        var reflected: vec4f;
        if guide.alpha == MEDIUM_ALPHA {
            reflected = light_of_media(radiance);
        } else {
            reflected = reflected_light(radiance);
            stored.alpha = max(guide.alpha, facets_least_alpha);
            stored.indirect *= 1.0 - facets_share;
        }
        reflected = vec4f(select(vec3f(0.0), reflected.xyz, has_light), reflected.w);
        let of_facets = luminance(reflected.xyz / reflection_divisor(guide));
        stored.reflected = reflected.xyz;
        stored.reflected_square = of_facets * of_facets;
        stored.depth = reflected.w;
    }
    if slice.guide_samples > 1u {
        let sample = stored;
        let first = 4u * pixel;
        let before = unpacked_guide(array<vec4u, 4>(guides[first], guides[first + 1u], guides[first + 2u], guides[first + 3u]));
        let share = 1.0 / f32(slice.guide_samples);
        let turned = dot(before.normal, guide.normal) < MIN_COMMON_COSINE && guide.guide_class != GUIDE_SKY;
        let differs = before.guide_class != guide.guide_class || before.object != guide.object;
        stored = before;
        stored.is_mixed = before.is_mixed || differs || turned;
        stored.albedo = mix(before.albedo, guide.albedo, share);
        stored.square = mix(before.square, sample.square, share);
        let weights = vec2f(luminance(before.reflected) * (1.0 - share), luminance(sample.reflected) * share + 1e-9);
        stored.depth = mix(before.depth, sample.depth, weights.y / (weights.x + weights.y));
        stored.reflected = mix(before.reflected, sample.reflected, share);
        // Rounded to the nearest, the mean does not fall from sample to sample.
        let indirect = mix(before.indirect, sample.indirect, share);
        stored.indirect = indirect + 0.5 * packed_step(indirect);
        stored.reflected_square = mix(before.reflected_square, sample.reflected_square, share);
    }
    let words = packed_guide(stored);
    for (var k = 0u; k < 4u; k++) {
        guides[4u * pixel + k] = words[k];
    }
}
