// The sums of a film as the codes that a screen shows, four bytes a pixel. Twin of display.rs.

struct Shown {
    width: u32,
    height: u32,
    /// Whole samples of every pixel.
    samples: u32,
    /// Pixels above the row, and of eight rows from there those left of the column, have so many more.
    begun: u32,
    row: u32,
    column: u32,
    /// What radiance is multiplied by.
    gain: f32,
    tonemap: u32,
    /// Not 0 where the film holds sums of luminance and of its square.
    variance: u32,
}

// No uniform, for the reason in frame.wgsl.
@group(0) @binding(0) var<storage, read> shown: Shown;
@group(0) @binding(1) var<storage, read> film: array<vec4f>;
@group(0) @binding(2) var<storage, read_write> picture: array<u32>;

@compute @workgroup_size(8, 8)
fn show(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= shown.width || id.y >= shown.height {
        return;
    }
    let pixel = id.y * shown.width + id.x;
    let sum = film[pixel];
    let has_more = id.y < shown.row || (id.y < shown.row + 8u && id.x < shown.column);
    let samples = f32(shown.samples + select(0u, shown.begun, has_more)) - sum.w;
    var colour = sum.xyz / max(samples, 1.0);
    if shown.variance != 0u {
        colour = uncertainty(vec4f(sum.xyz, samples)).xyz;
    }
    colour *= shown.gain;
    picture[pixel] = pack4x8unorm(vec4f(codes(shown.tonemap, vec4f(colour, 1.0)).xyz, 1.0));
}
