// The colour of a fractal by its orbit, where a ray has hit. Twin of paint.rs.

/// Colour that takes the place of the material's where w is above 0.
var<private> painted: vec4f;

/// Finds the colour of the surface at `p` of this leaf, of material `m`.
fn paint(m: u32, leaf: u32, p: vec3f) {
    painted = vec4f(0.0);
    let at = tables[PAINT_TABLE + m];
    if at == 0u || !has_orbit(leaf) {
        return;
    }
    var values = orbit(leaf, p);
    let value = values[tables[at]];
    let from_ = bitcast<f32>(tables[at + 1u]);
    let to = bitcast<f32>(tables[at + 2u]);
    let last = tables[at + 3u];
    let span = select(to - from_, 1e-20, to == from_);
    let place = clamp((value - from_) / span, 0.0, 1.0) * f32(last);
    let first = min(u32(place), max(last, 1u) - 1u);
    let colours = at + 4u;
    let a = table_colour(colours + 3u * first);
    let b = table_colour(colours + 3u * min(first + 1u, last));
    painted = vec4f(a + (b - a) * (place - f32(first)), 1.0);
}

fn table_colour(at: u32) -> vec3f {
    return vec3f(bitcast<f32>(tables[at]), bitcast<f32>(tables[at + 1u]), bitcast<f32>(tables[at + 2u]));
}

/// The colour of a material and its fourth number.
fn base(m: u32) -> vec4f {
    let a = materials[m].a;
    return vec4f(select(a.xyz, painted.xyz, painted.w > 0.0), a.w);
}
