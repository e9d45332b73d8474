// Phong shading of a rasterised mesh: ambient light, then diffuse light, then highlights (Phong 1975).

struct Scene {
    clip_from_world: mat4x4f,
    eye: vec4f,
    /// Position of a light, w = 1; or the direction towards it, w = 0.
    light: vec4f,
    light_colour: vec4f,
    /// Ambient colour; w is the number of terms, from 1 to 3.
    ambient: vec4f,
}

@group(0) @binding(0) var<uniform> scene: Scene;

struct Vertex {
    @builtin(position) clip: vec4f,
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) colour: vec3f,
}

@vertex
fn vertex(@location(0) position: vec3f, @location(1) normal: vec3f, @location(2) colour: vec3f) -> Vertex {
    return Vertex(scene.clip_from_world * vec4f(position, 1.0), position, normal, colour);
}

@fragment
fn fragment(v: Vertex) -> @location(0) vec4f {
    let n = normalize(v.normal);
    let to_light = normalize(scene.light.xyz - v.position * scene.light.w);
    let to_eye = normalize(scene.eye.xyz - v.position);
    var colour = v.colour * scene.ambient.rgb;
    if scene.ambient.w > 1.0 {
        colour += v.colour * scene.light_colour.rgb * max(dot(n, to_light), 0.0);
    }
    if scene.ambient.w > 2.0 {
        let highlight = pow(max(dot(reflect(-to_light, n), to_eye), 0.0), 32.0);
        colour += 0.4 * scene.light_colour.rgb * select(0.0, highlight, dot(n, to_light) > 0.0);
    }
    return vec4f(colour, 1.0);
}
