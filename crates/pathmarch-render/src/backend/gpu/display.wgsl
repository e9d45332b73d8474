// Display pass: sums of a film to the 8-bit sRGB codes of a screen, four bytes a pixel. Twin of display.rs.

// Storage instead of uniform memory, see bindings.rs.
@group(0) @binding(0) var<storage, read> uniforms: DisplayUniforms;
@group(0) @binding(1) var<storage, read> film: array<vec4f>;
@group(0) @binding(2) var<storage, read_write> picture: array<u32>;

@compute @workgroup_size(8, 8)
fn show(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= uniforms.width || id.y >= uniforms.height {
        return;
    }
    let pixel = id.y * uniforms.width + id.x;
    let sum = film[pixel];
    let has_more = id.y < uniforms.row || (id.y < uniforms.row + 8u && id.x < uniforms.column);
    let samples = f32(uniforms.samples + select(0u, uniforms.begun, has_more)) - sum.w;
    var colour = sum.xyz / max(samples, 1.0);
    if uniforms.variance != 0u {
        colour = uncertainty(vec4f(sum.xyz, samples)).xyz;
    }
    colour *= uniforms.gain;
    picture[pixel] = pack4x8unorm(vec4f(codes(uniforms.tonemap, vec4f(colour, 1.0)).xyz, 1.0));
}
