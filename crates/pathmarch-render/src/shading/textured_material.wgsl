// What varies along a surface. Twin of paint.rs, which explains it. What a layer changes depends on the mode: `apply_layer`.

/// The slope of the relief over the world, metres per metre.
var<private> relief: vec3f;

fn texture_number(at: u32) -> f32 {
    return bitcast<f32>(tables[at]);
}

fn texture_vector(at: u32) -> vec3f {
    return vec3f(texture_number(at), texture_number(at + 1u), texture_number(at + 2u));
}

/// Where `p` is in the coordinates of a leaf.
fn leaf_coordinates(leaf: u32, p: vec3f) -> Coordinates {
    let at = PAINT_TABLE + 13u * leaf;
    let outer = modifier_coordinates(tables[at + 12u], p);
    let x = texture_vector(at + 3u);
    let y = texture_vector(at + 6u);
    let z = texture_vector(at + 9u);
    let offset = outer.p - texture_vector(at);
    return coordinates_inside(outer, vec3f(dot(x, offset), dot(y, offset), dot(z, offset)), x, y, z);
}

/// What a texture shows: its colour and its value, below 0 where it has none.
fn texture_at(at: u32, leaf: u32, of_shape: Spot) -> vec4f {
    let kind = tables[at];
    if HAS_ORBITS && kind == ORBIT_SOURCE {
        if !has_orbit(leaf) {
            return vec4f(0.0, 0.0, 0.0, -1.0);
        }
        var values = orbit(leaf, of_shape.p);
        let from_ = texture_number(at + 16u);
        let to = texture_number(at + 17u);
        let span = select(to - from_, 1e-20, to == from_);
        return vec4f(clamp((values[tables[at + 15u]] - from_) / span, 0.0, 1.0));
    }
    let x = texture_vector(at + 4u);
    let y = texture_vector(at + 7u);
    let z = texture_vector(at + 10u);
    let scale = texture_number(at + 13u);
    let offset = of_shape.p - texture_vector(at + 1u);
    let n = of_shape.normal;
    let p = vec3f(dot(x, offset), dot(y, offset), dot(z, offset));
    let spot = Spot(p, vec3f(dot(x, n), dot(y, n), dot(z, n)) * scale, of_shape.footprint / scale);
    if HAS_PICTURES && kind == PICTURE_SOURCE {
        let picture = TexturePicture(tables[at + 15u], tables[at + 16u], tables[at + 17u], tables[at + 18u], tables[at + 20u] != 0u);
        let colour = picture_projected(picture, spot, texture_number(at + 19u));
        return vec4f(colour, clamp(dot(colour, vec3f(0.2126, 0.7152, 0.0722)), 0.0, 1.0));
    }
    var numbers: array<f32, 8>;
    for (var k = 0u; k < 8u; k++) {
        numbers[k] = texture_number(at + 15u + k);
    }
    let value = computed_texture(kind, spot, numbers);
    // What is not a number is 0.
    return vec4f(select(0.0, min(value, 1.0), value > 0.0));
}

/// The colour of a layer that is one, for what its texture shows.
fn layer_colour(layer: u32, shown: vec4f) -> vec3f {
    if tables[layer + 1u] == OWN_COLOURS_LAYER {
        return shown.xyz;
    }
    let last = tables[layer + 4u];
    let place = shown.w * f32(last);
    let first = min(u32(place), max(last, 1u) - 1u);
    let a = texture_vector(layer + 5u + 3u * first);
    let b = texture_vector(layer + 5u + 3u * min(first + 1u, last));
    return a + (b - a) * (place - f32(first));
}

/// Applies all that varies of material `m` at `p` on this leaf, whose outward normal is `outward`, at the end of a path of this
/// length.
fn paint(m: u32, leaf: u32, p: vec3f, outward: vec3f, path_length: f32) {
    relief = vec3f(0.0);
    start_paint(m);
    let what = tables[PAINT_TABLE + 13u * LEAF_COUNT + m];
    if what == 0u {
        return;
    }
    let here = leaf_coordinates(leaf, p);
    let cofactors = mat3x3f(cross(here.y, here.z), cross(here.z, here.x), cross(here.x, here.y));
    let determinant = dot(here.x, cofactors[0]);
    let size = pow(max(abs(determinant), 1e-30), -1.0 / 3.0);
    let across = (outward * cofactors) * select(1.0, -1.0, determinant < 0.0);
    let normal = select(vec3f(0.0, 1.0, 0.0), normalize(across), dot(across, across) > 0.0);
    let spot = Spot(here.p, normal, frame.pixel * path_length / size);
    let layers = tables[what];
    let bump = tables[what + 1u];
    var step = 1.0;
    if HAS_BUMP && bump != 0u {
        let texture = tables[bump];
        step = max(texture_number(texture + 14u) * texture_number(texture + 13u), 0.5 * spot.footprint);
    }
    var heights = vec4f(0.0);
    // The relief is looked at in four places. One loop, so that every texture stands in the code once.
    for (var k = 0u; k < layers + select(0u, 4u, HAS_BUMP && bump != 0u); k++) {
        var looked = spot;
        let layer = select(bump, tables[what + 2u + min(k, max(layers, 1u) - 1u)], k < layers);
        if k > layers {
            looked.p += step * vec3f(f32(k == layers + 1u), f32(k == layers + 2u), f32(k == layers + 3u));
        }
        let shown = texture_at(tables[layer], leaf, looked);
        if k >= layers {
            heights[k - layers] = shown.w;
        } else if shown.w >= 0.0 {
            apply_layer(layer, shown);
        }
    }
    if HAS_BUMP && bump != 0u {
        let slope = (heights.yzw - heights.x) * (texture_number(bump + 1u) / step);
        relief = mat3x3f(here.x, here.y, here.z) * slope * size;
    }
}

/// The normal that light sees on the side of `normal`, after `paint`.
fn shaded_normal(outward: vec3f, normal: vec3f, view: vec3f) -> vec3f {
    if !HAS_BUMP || all(relief == vec3f(0.0)) {
        return normal;
    }
    let along = relief - outward * dot(outward, relief);
    let bent = normalize(outward - along) * select(1.0, -1.0, dot(normal, outward) < 0.0);
    let above = max(dot(view, normal), 1e-5);
    let height = dot(bent, normal);
    let sheer = bent - normal * height;
    let tilt = length(sheer);
    if tilt < 1e-6 {
        return normal;
    }
    let aside = sheer / tilt;
    let sideways = dot(view, aside);
    let least = min(0.9 * above, 0.01);
    let steepest = 0.5 * (atan2(sideways, above) + acos(least / length(vec2f(sideways, above))));
    let angle = min(atan2(tilt, height), steepest);
    return normal * cos(angle) + aside * sin(angle);
}
