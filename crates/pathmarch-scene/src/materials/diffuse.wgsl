// Lambert's surface. Twin of diffuse.rs.

fn diffuse_eval(m: u32, wo: vec3f, wi: vec3f, inside: bool) -> vec4f {
    let pdf = max(wi.z, 0.0) * 0.31830989;
    return vec4f(packed(m, 0u).xyz * pdf, pdf);
}

fn diffuse_sample(m: u32, wo: vec3f, inside: bool, u: vec3f) -> Scattered {
    let wi = cosine_direction(u.xy);
    return Scattered(wi, wi.z * 0.31830989, packed(m, 0u).xyz, 1.0);
}
