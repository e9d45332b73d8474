// Views of what the camera's ray meets. Twin of views.rs, which explains them.

/// Evaluations of the field so far, and its steepest change over what is allowed, where the march is watched.
var<private> steps: u32;
var<private> steepest: f32;

/// Distances may be off by this many roundings of their point without a word.
const NOISE = 16.0;
/// The last colour of violations, and how many stand for a steepness of 1.
const VIOLATIONS = 1024.0;
const VIOLATIONS_UNIT = 256.0;

/// A number of the mode.
fn mode_number(k: u32) -> f32 {
    return bitcast<f32>(tables[MODE_TABLE + k]);
}

fn mode_colour(k: u32) -> vec3f {
    return vec3f(mode_number(3u * k), mode_number(3u * k + 1u), mode_number(3u * k + 2u));
}

/// Light of these codes on a screen.
fn light_of_code(code: vec3f) -> vec3f {
    let bright = pow((code + vec3f(0.055)) / 1.055, vec3f(2.4));
    return select(bright, code / 12.92, code <= vec3f(0.04045));
}

fn view_along(ray: Ray, random: Random) -> vec3f {
    let hit = march(ray, 0.0, AT_INFINITY);
    if VIEW == VIEW_STEPS {
        return mode_colour(steps);
    }
    if VIEW == VIEW_VIOLATIONS {
        let place = clamp(round(steepest * VIOLATIONS_UNIT), 0.0, VIOLATIONS);
        return select(vec3f(0.0), mode_colour(u32(place)), steps > 0u);
    }
    if hit.t < 0.0 {
        return vec3f(0.0);
    }
    let seen = visible(ray, hit, random);
    if VIEW == VIEW_NORMAL {
        return light_of_code(vec3f(0.5) + 0.5 * seen.normal);
    }
    if VIEW == VIEW_DEPTH {
        let beyond = max(dot(seen.p - frame.position, frame.forward) - mode_number(0u), 0.0) / mode_number(1u);
        return light_of_code(vec3f(1.0 / (1.0 + beyond * beyond)));
    }
    var shown = mode_colour(seen.leaf);
    if HAS_PAINT {
        paint(leaves[seen.leaf].material, seen.leaf, seen.p, select(seen.normal, -seen.normal, seen.inside), hit.t);
        shown = select(shown, painted_colour.xyz, painted_colour.w > 0.0);
    }
    let dark = VIEW == VIEW_ALBEDO && (materials[leaves[seen.leaf].material].flags & EMITS) != 0u && !shines(seen.leaf, seen.normal);
    return select(shown, vec3f(0.0), dark);
}
