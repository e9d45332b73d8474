// import: integrator/light_sampling, integrator/medium, integrator/sky, intersect/march, preview/light_irradiance
// import: preview/soft_shadow, sampler, sampling/basis, shading/shading_normal, shading/surface_interaction, textures
// Previews without noise. Twin of preview/mod.rs, which explains them.

/// Largest number of surfaces along the camera ray: rays pass only through clear surfaces.
const CAMERA_SURFACES = select(1u, MAX_SURFACES, TRANSMISSION);
/// Largest number of surfaces along the reflected ray.
const REFLECTED_SURFACES = select(0u, select(1u, MAX_REFLECTED_SURFACES, TRANSMISSION), HAS_REFLECTIONS);
const INVERSE_PI = 0.31830989;

/// Preview material.
struct PreviewMaterial {
    diffuse: vec3f,
    roughness: f32,
    /// Specular reflectance at normal incidence.
    f0: vec3f,
    /// Specular reflectance at grazing angles.
    f90: vec3f,
    transmitted: vec3f,
    ior: f32,
}

/// True if the preview has the step of this bit.
fn has_step(bit: u32) -> bool {
    return (frame.preview_steps & bit) != 0u;
}

/// Number of the preview data.
fn preview_number(k: u32) -> f32 {
    return bitcast<f32>(scene_word(MODE_DATA + k));
}

/// Colour of the preview data.
fn preview_colour(k: u32) -> vec3f {
    return vec3f(preview_number(k), preview_number(k + 1u), preview_number(k + 2u));
}

/// Preview material of a material.
fn preview_material(m: u32) -> PreviewMaterial {
    let k = FIRST_LIGHT + 2u * scene_word(MODE_DATA + FIRST_LIGHT - 1u) + PREVIEW_PARAMETERS * m;
    return PreviewMaterial(preview_colour(k), preview_number(k + 3u), preview_colour(k + 4u), preview_colour(k + 7u), preview_colour(k + 10u), preview_number(k + 13u));
}

/// Ambient irradiance on a surface with this normal, W/m².
fn ambient_irradiance(n: vec3f) -> vec3f {
    let sum = preview_colour(0u) + preview_colour(3u) * n.y + preview_colour(6u) * n.z + preview_colour(9u) * n.x
        + preview_colour(12u) * (n.x * n.y) + preview_colour(15u) * (n.y * n.z) + preview_colour(18u) * (3.0 * n.z * n.z - 1.0)
        + preview_colour(21u) * (n.x * n.z) + preview_colour(24u) * (n.x * n.x - n.y * n.y);
    return max(sum, vec3f(0.0));
}

/// Radiance of ambient light from around a direction, W/(m² sr), for rough reflections.
fn ambient_radiance(direction: vec3f) -> vec3f {
    return ambient_irradiance(direction) * INVERSE_PI;
}

/// Fifth power.
fn pow5(x: f32) -> f32 {
    let square = x * x;
    return square * square * x;
}

/// Film value of one sample of a pixel.
fn estimate(camera: Ray, sampler: PixelSampler) -> vec3f {
    var radiance = vec3f(0.0);
    var ray = camera;
    var weight = vec3f(1.0);
    var medium = frame.medium;
    var path_length = 0.0;
    var surfaces_left = CAMERA_SURFACES;
    // True along the camera ray until it has a reflected ray.
    var may_reflect = true;
    var is_reflection = false;
    // Reflected ray to trace after the camera ray; none if its weight is 0.
    var reflected_ray = Ray(vec3f(0.0), vec3f(0.0));
    var reflected_weight = vec3f(0.0);
    var reflected_medium = vec3f(0.0);
    var reflected_length = 0.0;
    for (var k = 0u; k < CAMERA_SURFACES + REFLECTED_SURFACES; k++) {
        var continues = false;
        let hit = march(ray, path_length, AT_INFINITY);
        if ABSORPTION {
            weight *= transmittance(medium, select(hit.t, UNBOUNDED_LENGTH, hit.t < 0.0));
        }
        if hit.t < 0.0 {
            radiance += weight * (sky_lookup(ray.direction).xyz + sun_radiance(ray.direction, 0.0));
        } else {
            path_length += hit.t;
            let interaction = surface_interaction(ray, hit, unstratified_seed(sampler, 0u));
            let m = leaf_at(interaction.leaf).material;
            if (material_at(m).flags & EMITS) != 0u {
                radiance += select(vec3f(0.0), weight * material_at(m).emission, emits_towards(interaction.leaf, interaction.normal));
            } else {
                var n = interaction.normal;
                var material = preview_material(m);
                if HAS_TEXTURES {
                    evaluate_textures(m, interaction, path_length);
                    material = textured_preview(material);
                }
                if HAS_GLOW && (material_at(m).flags & GLOWS) != 0u && emits_towards(interaction.leaf, interaction.normal) {
                    radiance += weight * emission_at(m);
                }
                n = shading_normal(interaction, -ray.direction);
                if !has_step(STEP_ALBEDO) && largest(material.diffuse) > 0.0 {
                    material.diffuse = vec3f(GREY_ALBEDO);
                }
                let clear = TRANSMISSION && largest(material.transmitted) > 0.0;
                let cosine = clamp(-dot(ray.direction, n), 0.0, 1.0);
                let f90 = max(material.f90 * (1.0 - material.roughness), material.f0);
                let fresnel = material.f0 + (f90 - material.f0) * pow5(1.0 - cosine);
                let reflectance = select(fresnel, vec3f(0.0), !HAS_REFLECTIONS || (clear && interaction.inside));
                let sharp_share = 1.0 - smoothstep(0.05, 0.45, material.roughness);
                let reflection = ray.direction + n * (2.0 * cosine);
                var untraced = 1.0;
                if HAS_REFLECTIONS && may_reflect && has_step(STEP_REFLECTION) && largest(weight * reflectance) * sharp_share > MIN_REFLECTION_WEIGHT {
                    may_reflect = false;
                    untraced = 1.0 - sharp_share;
                    reflected_ray = Ray(spawn_origin(interaction, false), normalize(reflection));
                    reflected_weight = weight * reflectance * sharp_share;
                    reflected_medium = medium;
                    reflected_length = path_length;
                }
                var diffuse = material.diffuse * (vec3f(1.0) - reflectance) * INVERSE_PI;
                if !has_step(STEP_DIFFUSE) {
                    radiance += weight * select(material.f0, material.diffuse, largest(material.diffuse) > 0.0);
                    diffuse = vec3f(0.0);
                }
                var ambient_light = diffuse * ambient_irradiance(n);
                if HAS_REFLECTIONS && has_step(STEP_SPECULAR) {
                    ambient_light += reflectance * ambient_radiance(reflection) * untraced;
                }
                var visibility = vec3f(1.0);
                if !clear && has_step(STEP_OCCLUSION) {
                    visibility = ambient_visibility(interaction, material.diffuse);
                }
                radiance += weight * ambient_light * visibility;
                if !(clear && interaction.inside) {
                    let highlight_f90 = select(vec3f(0.0), f90, has_step(STEP_SPECULAR));
                    let specular = Specular(material.f0, highlight_f90, material.roughness, untraced);
                    let shadows = select(select(MAX_SHADOWS, 1u, is_reflection), 0u, clear || !has_step(STEP_SHADOWS));
                    var shaded = interaction;
                    shaded.normal = n;
                    radiance += weight * direct_light(shaded, -ray.direction, path_length, diffuse, specular, shadows);
                }
                if clear {
                    let refracted = refract(ray.direction, n, select(1.0 / material.ior, material.ior, interaction.inside));
                    if all(refracted == vec3f(0.0)) {
                        // Total internal reflection.
                        ray = Ray(spawn_origin(interaction, false), normalize(reflection));
                    } else {
                        let transmitted_weight = weight * material.transmitted * (vec3f(1.0) - reflectance);
                        radiance += transmitted_weight * ambient_radiance(refracted) * (1.0 - sharp_share);
                        weight = transmitted_weight * sharp_share;
                        medium = medium_beyond(medium, material_at(m).absorption, interaction.inside);
                        ray = Ray(spawn_origin(interaction, true), normalize(refracted));
                    }
                    continues = true;
                }
            }
        }
        surfaces_left -= 1u;
        if continues && surfaces_left > 0u {
            continue;
        }
        if continues {
            radiance += weight * ambient_radiance(ray.direction);
        }
        if !HAS_REFLECTIONS || largest(reflected_weight) == 0.0 {
            break;
        }
        ray = reflected_ray;
        weight = reflected_weight;
        medium = reflected_medium;
        path_length = reflected_length;
        reflected_weight = vec3f(0.0);
        may_reflect = false;
        is_reflection = true;
        surfaces_left = REFLECTED_SURFACES;
    }
    return radiance;
}

/// Ambient visibility of a surface of this albedo, with interreflection.
fn ambient_visibility(interaction: SurfaceInteraction, albedo: vec3f) -> vec3f {
    var occlusion = 0.0;
    var height = preview_number(27u);
    for (var k = 0u; k < 5u; k++) {
        occlusion += max(1.0 - neighbour_distance(interaction.p + interaction.normal * height, interaction.leaf) / height, 0.0);
        height *= 0.5;
    }
    let visibility = 1.0 - OCCLUSION_PER_EVALUATION * occlusion;
    return vec3f(visibility) / (vec3f(1.0) - albedo * (1.0 - visibility));
}

/// Specular reflection of a surface.
struct Specular {
    /// Reflectance at normal incidence.
    f0: vec3f,
    /// Reflectance at grazing angles.
    f90: vec3f,
    roughness: f32,
    /// Share of the reflection that the reflected ray does not trace.
    untraced: f32,
}

/// Radiance of a surface by direct light, W/(m² sr); the `shadows` strongest lights have shadows.
fn direct_light(interaction: SurfaceInteraction, view: vec3f, path_length: f32, diffuse: vec3f, specular: Specular, shadows: u32) -> vec3f {
    var radiance = vec3f(0.0);
    if !HAS_LIGHTS {
        return radiance;
    }
    // Radiance without shadow, and the index of the light in the preview data.
    var strongest: array<vec4f, MAX_SHADOWS>;
    let is_specular = HAS_REFLECTIONS && largest(specular.f90) > 0.0;
    let count = scene_word(MODE_DATA + FIRST_LIGHT - 1u);
    for (var k = 0u; k < count; k++) {
        let light = preview_light(k);
        let unoccluded = unoccluded_light(light, preview_radius(k), interaction.p, interaction.normal);
        if largest(unoccluded.irradiance) <= 0.0 {
            continue;
        }
        var scattered = diffuse;
        if is_specular {
            let is_reflected = (light.kind > SUN && light.kind != SPOT) || unoccluded.sine > 0.0;
            scattered += highlight(unoccluded, view, interaction.normal, specular) * select(1.0, specular.untraced, is_reflected);
        }
        var contribution = vec4f(scattered * unoccluded.irradiance, f32(k));
        for (var rank = 0u; rank < MAX_SHADOWS; rank++) {
            let entry = strongest[rank];
            let stronger = largest(contribution.xyz) > largest(entry.xyz);
            strongest[rank] = select(entry, contribution, stronger);
            contribution = select(contribution, entry, stronger);
        }
        radiance += contribution.xyz;
    }
    let origin = spawn_origin(interaction, false) + interaction.normal * (10.0 * frame.tolerance * path_length);
    for (var rank = 0u; rank < min(count, MAX_SHADOWS); rank++) {
        let contribution = strongest[rank];
        if largest(contribution.xyz) <= MIN_SHADOWED_LIGHT * largest(strongest[0].xyz) || rank >= shadows {
            radiance += contribution.xyz;
            continue;
        }
        let light = preview_light(u32(contribution.w));
        let unoccluded = unoccluded_light(light, preview_radius(u32(contribution.w)), interaction.p, interaction.normal);
        let direction = unoccluded.direction + interaction.normal * max(0.1 - dot(unoccluded.direction, interaction.normal), 0.0);
        let sharpness = shadow_sharpness(unoccluded, light.penumbra, interaction.normal);
        radiance += contribution.xyz * soft_shadow(Ray(origin, normalize(direction)), interaction.leaf, unoccluded.distance, sharpness);
    }
    return radiance;
}

/// Light `k` of the preview.
fn preview_light(k: u32) -> Light {
    return light_at(scene_word(MODE_DATA + FIRST_LIGHT + 2u * k));
}

/// Radius of the sphere that approximates light `k` of the preview, metres.
fn preview_radius(k: u32) -> f32 {
    return preview_number(FIRST_LIGHT + 2u * k + 1u);
}

/// Sharpness of the shadow of a light, limited so that the surface itself is no near miss.
fn shadow_sharpness(unoccluded: UnoccludedLight, penumbra: f32, n: vec3f) -> f32 {
    let cone_sharpness = sqrt(max(1.0 - unoccluded.sine * unoccluded.sine, 0.0)) / max(unoccluded.sine, 1.0 / MAX_SHARPNESS);
    let sharpness = select(cone_sharpness, penumbra, penumbra > 0.0);
    return min(max(sharpness, 1.0 / max(dot(unoccluded.direction, n), 0.1)), MAX_SHARPNESS);
}

/// BRDF of the highlight of a light, 1/sr; `view` is the unit vector towards the viewer.
fn highlight(unoccluded: UnoccludedLight, view: vec3f, n: vec3f, specular: Specular) -> vec3f {
    let alpha = max(specular.roughness * specular.roughness, 0.02);
    let reflection = n * (2.0 * dot(n, view)) - view;
    let offset = reflection * dot(unoccluded.direction, reflection) - unoccluded.direction;
    let nearest = unoccluded.direction + offset * min(unoccluded.sine / max(length(offset), 1e-6), 1.0);
    let sum = normalize(nearest) + view;
    let half = select(n, sum / max(length(sum), 1e-6), dot(sum, sum) > 1e-12);
    let exponent = 2.0 / (alpha * alpha) - 2.0;
    let cosine = max(dot(n, half), 0.0);
    // The highlight is negligible here.
    if exponent * (1.0 - cosine) > 12.0 {
        return vec3f(0.0);
    }
    let widening = alpha / min(alpha + 0.5 * unoccluded.sine, 1.0);
    let peak = (exponent + 8.0) / (8.0 * 3.14159265) * widening * widening;
    let fresnel = specular.f0 + (specular.f90 - specular.f0) * pow5(1.0 - clamp(dot(half, view), 0.0, 1.0));
    return fresnel * (peak * pow(cosine, exponent));
}
