// Medium without a surface. Twin of medium.rs.

fn medium_eval(m: u32, wo: vec3f, wi: vec3f, inside: bool) -> vec4f {
    return vec4f(0.0);
}

fn medium_sample(m: u32, wo: vec3f, inside: bool, u: vec3f) -> Scattered {
    return Scattered(-wo, 0.0, vec3f(1.0), 1.0);
}
