// One sample of every pixel of a band of rows: a path from the camera. Twin of path.rs, which explains the estimator.

struct Frame {
    position: vec3f,
    lens_radius: f32,
    right: vec3f,
    focus: f32,
    up: vec3f,
    tolerance: f32,
    forward: vec3f,
    rounding: f32,
    sky: vec3f,
    step_factor: f32,
    bounds_min: vec3f,
    far: f32,
    bounds_max: vec3f,
    light_count: u32,
    width: u32,
    height: u32,
    bounces: u32,
    seed: u32,
    sampler: u32,
}

/// Which sample of which rows a dispatch computes.
struct Slice {
    sample: u32,
    first_row: u32,
    rows: u32,
    padding: u32,
}

/// What is known of a leaf of the field.
struct LeafRecord {
    /// Where a sheet faces.
    facing: vec3f,
    material: u32,
    at: vec3f,
    flags: u32,
}

/// A surface without thickness, which emits on one side.
const SHEET = 1u;
/// Rays meet it in closed form.
const DIRECT = 2u;
/// Where one more than the index of the leaf's light starts in the flags.
const LIGHT_SHIFT = 2u;

struct Material {
    albedo: vec3f,
    emits: u32,
    emission: vec3f,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<uniform> slice: Slice;
@group(0) @binding(3) var<storage, read> leaves: array<LeafRecord>;
@group(0) @binding(4) var<storage, read> materials: array<Material>;
@group(0) @binding(5) var<storage, read> lights: array<Light>;
/// Sums of radiance; the fourth number counts samples that were not finite and were left out.
@group(0) @binding(6) var<storage, read_write> film: array<vec4f>;

/// Whether light arrives along a shadow ray that met something after `obstacle` metres, or nothing.
fn shines(light: LightSample, ray: Ray, obstacle: f32, seed: u32) -> bool {
    if light.target_leaf == NO_TARGET {
        return obstacle < 0.0;
    }
    if obstacle < 0.0 {
        return false;
    }
    let met = surface(ray.origin + ray.direction * obstacle, seed);
    let leaf = leaves[met.leaf];
    // A sheet's gradient points to the side it is seen from.
    return met.leaf == light.target_leaf
        && ((leaf.flags & SHEET) == 0u || dot(ray.direction, leaf.facing) < 0.0);
}

fn radiance_along(camera: Ray, random: Random) -> vec3f {
    var ray = camera;
    var radiance = vec3f(0.0);
    var throughput = vec3f(1.0);
    var path_length = 0.0;
    // Density of the ray's direction over solid angle.
    var scatter_pdf = 0.0;
    for (var surface_index = 0u; surface_index <= frame.bounces + 1u; surface_index++) {
        let t = march(ray, path_length, AT_INFINITY);
        if t < 0.0 {
            var beyond = frame.sky;
            if surface_index == 0u {
                beyond += sun_radiance(ray.direction);
            }
            radiance += throughput * beyond;
            break;
        }
        path_length += t;
        let reached = ray.origin + ray.direction * t;
        let near = surface(reached, random_loose(random, surface_index));
        let steepness = max(length(near.gradient), 1e-6);
        let outward = near.gradient / steepness;
        let leaf = leaves[near.leaf];
        let off = direct_tolerance(reached, leaf.at);
        // On the surface but for rounding, the side is the one the ray comes from; else the field says it.
        let on_surface = (leaf.flags & DIRECT) != 0u || abs(near.distance) <= off + frame.rounding * t;
        let inside = select((near.distance < 0.0), (dot(outward, ray.direction) > 0.0), on_surface);
        let normal = select(outward, -outward, inside);
        let material = materials[leaf.material];
        if material.emits != 0u {
            if (leaf.flags & SHEET) == 0u || dot(normal, leaf.facing) > 0.0 {
                let light = leaf.flags >> LIGHT_SHIFT;
                var weight = 1.0;
                if surface_index > 0u && light > 0u {
                    let cosine = abs(dot(normal, ray.direction));
                    weight = heuristic(scatter_pdf, light_pdf(lights[light - 1u], ray.origin, t, cosine));
                }
                radiance += throughput * material.emission * weight;
            }
            break;
        }
        if surface_index > frame.bounces {
            break;
        }
        let p = reached - outward * (near.distance / steepness);
        let start = START_OFFSET * select(tolerance(p, path_length), off, (leaf.flags & DIRECT) != 0u);
        let origin = p + normal * start;
        let pair = PAIR_SURFACE + PAIRS_PER_SURFACE * surface_index;
        let choice = random_pair(random, pair + PAIR_CHOICE);
        if frame.light_count > 0u {
            let light = light_sample(origin, choice.x, random_pair(random, pair + PAIR_LIGHT));
            let cosine = dot(normal, light.direction);
            if cosine > 0.0 && light.irradiance.x + light.irradiance.y + light.irradiance.z > 0.0 {
                let towards = Ray(origin, light.direction);
                let obstacle = march(towards, path_length, light.distance);
                if shines(light, towards, obstacle, random_loose(random, surface_index)) {
                    let weight = select(1.0, heuristic(light.pdf, cosine / 3.14159265), light.pdf > 0.0);
                    radiance += throughput * material.albedo * light.irradiance * (weight * cosine / 3.14159265);
                }
            }
        }
        throughput *= material.albedo;
        if surface_index > 4u {
            let survival = min(largest(throughput), 1.0);
            if choice.y >= survival {
                break;
            }
            throughput /= survival;
        }
        ray = Ray(origin, cosine_direction(normal, random_pair(random, pair + PAIR_SCATTER)));
        scatter_pdf = dot(normal, ray.direction) / 3.14159265;
    }
    return radiance;
}

@compute @workgroup_size(8, 8)
fn trace(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= frame.width || id.y >= slice.rows {
        return;
    }
    let y = slice.first_row + id.y;
    let random = random_new(id.x, y, slice.sample, frame.seed);
    let radiance = radiance_along(camera_ray(id.x, y, random), random);
    let pixel = y * frame.width + id.x;
    // Comparisons with what is not a number are false, so this also catches NaN.
    if all(radiance >= vec3f(0.0)) && all(radiance < vec3f(1e30)) {
        film[pixel] += vec4f(radiance, 0.0);
    } else {
        film[pixel].w += 1.0;
    }
}
