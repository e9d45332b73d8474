// A quick look without noise. Twin of preview.rs, which explains it.

// Only clear surfaces let a ray go on.
const THROUGH = select(1u, 6u, TRANSMISSION);
const REFLECTED = select(0u, select(1u, 3u, TRANSMISSION), MIRRORS);
const SHADOWED = 3u;
const FAINT = 0.02;
const WEAK = 0.1;
const HARDEST = 64.0;
const HIDES = 0.15;
const INVERSE_PI = 0.31830989;

/// Where the lights, and behind them the materials, stand in the mode's numbers.
const FIRST_LIGHT = 29u;
const LOOK_SIZE = 14u;

/// A material.
struct Look {
    diffuse: vec3f,
    roughness: f32,
    straight: vec3f,
    grazing: vec3f,
    transmitted: vec3f,
    ior: f32,
}

fn mode_number(k: u32) -> f32 {
    return bitcast<f32>(tables[MODE_TABLE + k]);
}

fn mode_colour(k: u32) -> vec3f {
    return vec3f(mode_number(k), mode_number(k + 1u), mode_number(k + 2u));
}

fn look_of(m: u32) -> Look {
    let k = FIRST_LIGHT + 2u * tables[MODE_TABLE + 28u] + LOOK_SIZE * m;
    return Look(mode_colour(k), mode_number(k + 3u), mode_colour(k + 4u), mode_colour(k + 7u), mode_colour(k + 10u), mode_number(k + 13u));
}

/// Irradiance from all around on a surface with this normal.
fn irradiance_around(n: vec3f) -> vec3f {
    let sum = mode_colour(0u) + mode_colour(3u) * n.y + mode_colour(6u) * n.z + mode_colour(9u) * n.x
        + mode_colour(12u) * (n.x * n.y) + mode_colour(15u) * (n.y * n.z) + mode_colour(18u) * (3.0 * n.z * n.z - 1.0)
        + mode_colour(21u) * (n.x * n.z) + mode_colour(24u) * (n.x * n.x - n.y * n.y);
    return max(sum, vec3f(0.0));
}

fn blurred_around(direction: vec3f) -> vec3f {
    return irradiance_around(direction) * INVERSE_PI;
}

fn fifth(x: f32) -> f32 {
    let square = x * x;
    return square * square * x;
}

fn preview_along(camera: Ray, random: Random) -> vec3f {
    var colour = vec3f(0.0);
    var ray = camera;
    var weight = vec3f(1.0);
    var medium = frame.medium;
    var before = 0.0;
    var surfaces_left = THROUGH;
    // Whether this is the camera's ray and has no reflection yet.
    var may_mirror = true;
    var is_reflection = false;
    // The reflection that waits; none where its weight is 0.
    var mirror = Ray(vec3f(0.0), vec3f(0.0));
    var mirror_weight = vec3f(0.0);
    var mirror_medium = vec3f(0.0);
    var mirror_before = 0.0;
    for (var k = 0u; k < THROUGH + REFLECTED; k++) {
        var goes_on = false;
        let hit = march(ray, before, AT_INFINITY);
        if ABSORPTION {
            weight *= exp(-medium * min(select(hit.t, 1e9, hit.t < 0.0), 1e9));
        }
        if hit.t < 0.0 {
            colour += weight * (sky_lookup(ray.direction).xyz + suns_beyond(ray.direction, 0.0));
        } else {
            before += hit.t;
            let seen = visible(ray, hit, random);
            let m = leaves[seen.leaf].material;
            if (materials[m].flags & EMITS) != 0u {
                colour += select(vec3f(0.0), weight * materials[m].emission, shines(seen.leaf, seen.normal));
            } else {
                var n = seen.normal;
                var look = look_of(m);
                if HAS_PAINT {
                    let outward = select(n, -n, seen.inside);
                    paint(m, seen.leaf, seen.p, outward, before);
                    look = changed_look(look);
                    n = shaded_normal(outward, n, -ray.direction);
                }
                let clear = TRANSMISSION && largest(look.transmitted) > 0.0;
                let cosine = clamp(-dot(ray.direction, n), 0.0, 1.0);
                let grazing = max(look.grazing * (1.0 - look.roughness), look.straight);
                let fresnel = look.straight + (grazing - look.straight) * fifth(1.0 - cosine);
                let mirrored = select(fresnel, vec3f(0.0), !MIRRORS || (clear && seen.inside));
                let sharp = 1.0 - smoothstep(0.05, 0.45, look.roughness);
                let reflection = ray.direction + n * (2.0 * cosine);
                var blurred = 1.0;
                if MIRRORS && may_mirror && largest(weight * mirrored) * sharp > FAINT {
                    may_mirror = false;
                    blurred = 1.0 - sharp;
                    mirror = Ray(seen.p + seen.away, normalize(reflection));
                    mirror_weight = weight * mirrored * sharp;
                    mirror_medium = medium;
                    mirror_before = before;
                }
                let diffuse = look.diffuse * (vec3f(1.0) - mirrored) * INVERSE_PI;
                var around = diffuse * irradiance_around(n);
                if MIRRORS {
                    around += mirrored * blurred_around(reflection) * blurred;
                }
                var open = vec3f(1.0);
                if !clear {
                    open = unoccluded(seen, look.diffuse);
                }
                colour += weight * around * open;
                if !(clear && seen.inside) {
                    let gloss = Gloss(look.straight, grazing, look.roughness, blurred);
                    let shadows = select(select(SHADOWED, 1u, is_reflection), 0u, clear);
                    var shaded = seen;
                    shaded.normal = n;
                    colour += weight * lit(shaded, -ray.direction, before, diffuse, gloss, shadows);
                }
                if clear {
                    let bent = refract(ray.direction, n, select(1.0 / look.ior, look.ior, seen.inside));
                    if all(bent == vec3f(0.0)) {
                        // Total reflection.
                        ray = Ray(seen.p + seen.away, normalize(reflection));
                    } else {
                        let passes = weight * look.transmitted * (vec3f(1.0) - mirrored);
                        colour += passes * blurred_around(bent) * (1.0 - sharp);
                        weight = passes * sharp;
                        let absorbed = materials[m].absorption;
                        medium = max(select(medium + absorbed, medium - absorbed, seen.inside), vec3f(0.0));
                        ray = Ray(seen.p - seen.away, normalize(bent));
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
        if !MIRRORS || largest(mirror_weight) == 0.0 {
            break;
        }
        ray = mirror;
        weight = mirror_weight;
        medium = mirror_medium;
        before = mirror_before;
        mirror_weight = vec3f(0.0);
        may_mirror = false;
        is_reflection = true;
        surfaces_left = REFLECTED;
    }
    return colour;
}

/// How much of the light from all around comes to a surface of this albedo.
fn unoccluded(seen: Visible, albedo: vec3f) -> vec3f {
    var hidden = 0.0;
    var height = mode_number(27u);
    for (var k = 0u; k < 5u; k++) {
        hidden += max(1.0 - neighbour_distance(seen.p + seen.normal * height, seen.leaf) / height, 0.0);
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
fn lit(seen: Visible, view: vec3f, before: f32, diffuse: vec3f, gloss: Gloss, shadows: u32) -> vec3f {
    var colour = vec3f(0.0);
    if !HAS_LIGHTS {
        return colour;
    }
    // Colour, and the place of the light among the known ones.
    var strongest: array<vec4f, SHADOWED>;
    let glossy = MIRRORS && largest(gloss.grazing) > 0.0;
    let count = tables[MODE_TABLE + 28u];
    for (var k = 0u; k < count; k++) {
        let light = known_light(k);
        let falls = falling(light, known_radius(k), seen.p, seen.normal);
        if largest(falls.irradiance) <= 0.0 {
            continue;
        }
        var scattered = diffuse;
        if glossy {
            let shown = light.kind > SUN || falls.sine > 0.0;
            scattered += highlight(falls, view, seen.normal, gloss) * select(1.0, gloss.blurred, shown);
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
    let origin = seen.p + seen.away + seen.normal * (10.0 * frame.tolerance * before);
    for (var place = 0u; place < min(count, SHADOWED); place++) {
        let one = strongest[place];
        if largest(one.xyz) <= WEAK * largest(strongest[0].xyz) || place >= shadows {
            colour += one.xyz;
            continue;
        }
        let light = known_light(u32(one.w));
        let falls = falling(light, known_radius(u32(one.w)), seen.p, seen.normal);
        let towards = falls.direction + seen.normal * max(0.1 - dot(falls.direction, seen.normal), 0.0);
        let sharpness = shadow_sharpness(falls, light.penumbra, seen.normal);
        colour += one.xyz * soft_shadow(Ray(origin, normalize(towards)), seen.leaf, falls.distance, sharpness);
    }
    return colour;
}

fn known_light(k: u32) -> Light {
    return lights[tables[MODE_TABLE + FIRST_LIGHT + 2u * k]];
}

fn known_radius(k: u32) -> f32 {
    return mode_number(FIRST_LIGHT + 2u * k + 1u);
}

/// How hard the edge of a shadow is. The surface itself is not taken for a near miss.
fn shadow_sharpness(falls: Falling, penumbra: f32, n: vec3f) -> f32 {
    let seen = sqrt(max(1.0 - falls.sine * falls.sine, 0.0)) / max(falls.sine, 1.0 / HARDEST);
    let sharpness = select(seen, penumbra, penumbra > 0.0);
    return min(max(sharpness, 1.0 / max(dot(falls.direction, n), 0.1)), HARDEST);
}

/// BRDF of the highlight of a light, 1/sr; `view` is towards the eye.
fn highlight(falls: Falling, view: vec3f, n: vec3f, gloss: Gloss) -> vec3f {
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
