// import: integrator/light_sampling, integrator/medium, integrator/sky, intersect/march, preview/light_irradiance
// import: preview/soft_shadow, sampler, sampling/basis, shading/surface_interaction, textures
// Previews without noise. Twin of preview/mod.rs, which explains them.

// Only clear surfaces let a ray continue.
const SURFACES = select(1u, MAX_SURFACES, TRANSMISSION);
const REFLECTED = select(0u, select(1u, MAX_REFLECTED, TRANSMISSION), HAS_REFLECTIONS);
const INVERSE_PI = 0.31830989;

/// Material of a preview.
struct PreviewMaterial {
    diffuse: vec3f,
    roughness: f32,
    /// Specular reflectance at normal incidence.
    straight: vec3f,
    /// Specular reflectance at grazing angles.
    grazing: vec3f,
    transmitted: vec3f,
    ior: f32,
}

fn preview_number(k: u32) -> f32 {
    return bitcast<f32>(scene_data[MODE_DATA + k]);
}

fn preview_colour(k: u32) -> vec3f {
    return vec3f(preview_number(k), preview_number(k + 1u), preview_number(k + 2u));
}

fn preview_material(m: u32) -> PreviewMaterial {
    let k = FIRST_LIGHT + 2u * scene_data[MODE_DATA + FIRST_LIGHT - 1u] + PREVIEW_PARAMETERS * m;
    return PreviewMaterial(preview_colour(k), preview_number(k + 3u), preview_colour(k + 4u), preview_colour(k + 7u), preview_colour(k + 10u), preview_number(k + 13u));
}

/// Irradiance from all around on a surface with this normal.
fn irradiance_around(n: vec3f) -> vec3f {
    let sum = preview_colour(0u) + preview_colour(3u) * n.y + preview_colour(6u) * n.z + preview_colour(9u) * n.x
        + preview_colour(12u) * (n.x * n.y) + preview_colour(15u) * (n.y * n.z) + preview_colour(18u) * (3.0 * n.z * n.z - 1.0)
        + preview_colour(21u) * (n.x * n.z) + preview_colour(24u) * (n.x * n.x - n.y * n.y);
    return max(sum, vec3f(0.0));
}

fn blurred_around(direction: vec3f) -> vec3f {
    return irradiance_around(direction) * INVERSE_PI;
}

fn fifth(x: f32) -> f32 {
    let square = x * x;
    return square * square * x;
}

/// Value of one sample of a pixel, for the film.
fn estimate(camera: Ray, sampler: PixelSampler) -> vec3f {
    var colour = vec3f(0.0);
    var ray = camera;
    var weight = vec3f(1.0);
    var medium = frame.medium;
    var path_length = 0.0;
    var surfaces_left = SURFACES;
    // Whether this is the camera ray, and it has no reflection yet.
    var may_mirror = true;
    var is_reflection = false;
    // The reflection that waits; none where its weight is 0.
    var mirror = Ray(vec3f(0.0), vec3f(0.0));
    var mirror_weight = vec3f(0.0);
    var mirror_medium = vec3f(0.0);
    var mirror_length = 0.0;
    for (var k = 0u; k < SURFACES + REFLECTED; k++) {
        var goes_on = false;
        let hit = march(ray, path_length, AT_INFINITY);
        if ABSORPTION {
            weight *= transmittance(medium, select(hit.t, UNBOUNDED_LENGTH, hit.t < 0.0));
        }
        if hit.t < 0.0 {
            colour += weight * (sky_lookup(ray.direction).xyz + sun_radiance(ray.direction, 0.0));
        } else {
            path_length += hit.t;
            let at = surface_interaction(ray, hit, unstratified_seed(sampler, 0u));
            let m = leaves[at.leaf].material;
            if (materials[m].flags & EMITS) != 0u {
                colour += select(vec3f(0.0), weight * materials[m].emission, emits_towards(at.leaf, at.normal));
            } else {
                var n = at.normal;
                var material = preview_material(m);
                if HAS_TEXTURES {
                    let outward = outward_normal(at);
                    evaluate_textures(m, at.leaf, at.p, outward, path_length);
                    material = textured_preview(material);
                    n = shading_normal(outward, n, -ray.direction);
                }
                let clear = TRANSMISSION && largest(material.transmitted) > 0.0;
                let cosine = clamp(-dot(ray.direction, n), 0.0, 1.0);
                let grazing = max(material.grazing * (1.0 - material.roughness), material.straight);
                let fresnel = material.straight + (grazing - material.straight) * fifth(1.0 - cosine);
                let mirrored = select(fresnel, vec3f(0.0), !HAS_REFLECTIONS || (clear && at.inside));
                let sharp = 1.0 - smoothstep(0.05, 0.45, material.roughness);
                let reflection = ray.direction + n * (2.0 * cosine);
                var blurred = 1.0;
                if HAS_REFLECTIONS && may_mirror && largest(weight * mirrored) * sharp > FAINT {
                    may_mirror = false;
                    blurred = 1.0 - sharp;
                    mirror = Ray(spawn_origin(at, false), normalize(reflection));
                    mirror_weight = weight * mirrored * sharp;
                    mirror_medium = medium;
                    mirror_length = path_length;
                }
                let diffuse = material.diffuse * (vec3f(1.0) - mirrored) * INVERSE_PI;
                var around = diffuse * irradiance_around(n);
                if HAS_REFLECTIONS {
                    around += mirrored * blurred_around(reflection) * blurred;
                }
                var open = vec3f(1.0);
                if !clear {
                    open = unoccluded(at, material.diffuse);
                }
                colour += weight * around * open;
                if !(clear && at.inside) {
                    let gloss = Gloss(material.straight, grazing, material.roughness, blurred);
                    let shadows = select(select(SHADOWED, 1u, is_reflection), 0u, clear);
                    var shaded = at;
                    shaded.normal = n;
                    colour += weight * lit(shaded, -ray.direction, path_length, diffuse, gloss, shadows);
                }
                if clear {
                    let bent = refract(ray.direction, n, select(1.0 / material.ior, material.ior, at.inside));
                    if all(bent == vec3f(0.0)) {
                        // Total reflection.
                        ray = Ray(spawn_origin(at, false), normalize(reflection));
                    } else {
                        let passes = weight * material.transmitted * (vec3f(1.0) - mirrored);
                        colour += passes * blurred_around(bent) * (1.0 - sharp);
                        weight = passes * sharp;
                        medium = medium_beyond(medium, materials[m].absorption, at.inside);
                        ray = Ray(spawn_origin(at, true), normalize(bent));
                    }
                    goes_on = true;
                }
            }
        }
        surfaces_left -= 1u;
        if goes_on && surfaces_left > 0u {
            continue;
        }
        if goes_on {
            colour += weight * blurred_around(ray.direction);
        }
        if !HAS_REFLECTIONS || largest(mirror_weight) == 0.0 {
            break;
        }
        ray = mirror;
        weight = mirror_weight;
        medium = mirror_medium;
        path_length = mirror_length;
        mirror_weight = vec3f(0.0);
        may_mirror = false;
        is_reflection = true;
        surfaces_left = REFLECTED;
    }
    return colour;
}

/// How much of the light from all around comes to a surface of this albedo.
fn unoccluded(at: SurfaceInteraction, albedo: vec3f) -> vec3f {
    var hidden = 0.0;
    var height = preview_number(27u);
    for (var k = 0u; k < 5u; k++) {
        hidden += max(1.0 - neighbour_distance(at.p + at.normal * height, at.leaf) / height, 0.0);
        height *= 0.5;
    }
    let open = 1.0 - HIDES * hidden;
    return vec3f(open) / (vec3f(1.0) - albedo * (1.0 - open));
}

/// What a surface mirrors.
struct Gloss {
    straight: vec3f,
    grazing: vec3f,
    roughness: f32,
    /// Share of lamps that the reflection does not show.
    blurred: f32,
}

/// What a surface shows of all lights; the strongest cast shadows.
fn lit(at: SurfaceInteraction, view: vec3f, path_length: f32, diffuse: vec3f, gloss: Gloss, shadows: u32) -> vec3f {
    var colour = vec3f(0.0);
    if !HAS_LIGHTS {
        return colour;
    }
    // Colour, and the place of the light among the known ones.
    var strongest: array<vec4f, SHADOWED>;
    let glossy = HAS_REFLECTIONS && largest(gloss.grazing) > 0.0;
    let count = scene_data[MODE_DATA + FIRST_LIGHT - 1u];
    for (var k = 0u; k < count; k++) {
        let light = preview_light(k);
        let falls = unoccluded_light(light, preview_radius(k), at.p, at.normal);
        if largest(falls.irradiance) <= 0.0 {
            continue;
        }
        var scattered = diffuse;
        if glossy {
            let shown = light.kind > SUN || falls.sine > 0.0;
            scattered += highlight(falls, view, at.normal, gloss) * select(1.0, gloss.blurred, shown);
        }
        var one = vec4f(scattered * falls.irradiance, f32(k));
        for (var place = 0u; place < SHADOWED; place++) {
            let other = strongest[place];
            let stronger = largest(one.xyz) > largest(other.xyz);
            strongest[place] = select(other, one, stronger);
            one = select(one, other, stronger);
        }
        colour += one.xyz;
    }
    let origin = spawn_origin(at, false) + at.normal * (10.0 * frame.tolerance * path_length);
    for (var place = 0u; place < min(count, SHADOWED); place++) {
        let one = strongest[place];
        if largest(one.xyz) <= WEAK * largest(strongest[0].xyz) || place >= shadows {
            colour += one.xyz;
            continue;
        }
        let light = preview_light(u32(one.w));
        let falls = unoccluded_light(light, preview_radius(u32(one.w)), at.p, at.normal);
        let towards = falls.direction + at.normal * max(0.1 - dot(falls.direction, at.normal), 0.0);
        let sharpness = shadow_sharpness(falls, light.penumbra, at.normal);
        colour += one.xyz * soft_shadow(Ray(origin, normalize(towards)), at.leaf, falls.distance, sharpness);
    }
    return colour;
}

fn preview_light(k: u32) -> Light {
    return lights[scene_data[MODE_DATA + FIRST_LIGHT + 2u * k]];
}

fn preview_radius(k: u32) -> f32 {
    return preview_number(FIRST_LIGHT + 2u * k + 1u);
}

/// How hard the edge of a shadow is. The surface itself is not taken for a near miss.
fn shadow_sharpness(falls: UnoccludedLight, penumbra: f32, n: vec3f) -> f32 {
    let seen = sqrt(max(1.0 - falls.sine * falls.sine, 0.0)) / max(falls.sine, 1.0 / HARDEST);
    let sharpness = select(seen, penumbra, penumbra > 0.0);
    return min(max(sharpness, 1.0 / max(dot(falls.direction, n), 0.1)), HARDEST);
}

/// BRDF of the highlight of a light, 1/sr; `view` is towards the eye.
fn highlight(falls: UnoccludedLight, view: vec3f, n: vec3f, gloss: Gloss) -> vec3f {
    let alpha = max(gloss.roughness * gloss.roughness, 0.02);
    let reflection = n * (2.0 * dot(n, view)) - view;
    let across = reflection * dot(falls.direction, reflection) - falls.direction;
    let nearest = falls.direction + across * min(falls.sine / max(length(across), 1e-6), 1.0);
    let sum = normalize(nearest) + view;
    let half = select(n, sum / max(length(sum), 1e-6), dot(sum, sum) > 1e-12);
    let exponent = 2.0 / (alpha * alpha) - 2.0;
    let cosine = max(dot(n, half), 0.0);
    // Far from the highlight there is none.
    if exponent * (1.0 - cosine) > 12.0 {
        return vec3f(0.0);
    }
    let widened = alpha / min(alpha + 0.5 * falls.sine, 1.0);
    let peak = (exponent + 8.0) / (8.0 * 3.14159265) * widened * widened;
    let fresnel = gloss.straight + (gloss.grazing - gloss.straight) * fifth(1.0 - clamp(dot(half, view), 0.0, 1.0));
    return fresnel * (peak * pow(cosine, exponent));
}
