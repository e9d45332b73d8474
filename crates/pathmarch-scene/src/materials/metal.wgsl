// Metal. Twin of metal.rs.

fn metal_eval(m: u32, wo: vec3f, wi: vec3f, inside: bool) -> vec4f {
    let a = packed(m, 0u);
    if wi.z <= 0.0 || a.w < MIRROR_ALPHA {
        return vec4f(0.0);
    }
    let h = normalize(wo + wi);
    let lobe = microfacet_reflection(wo, wi, h, a.w);
    return vec4f(schlick(a.xyz, packed(m, 1u).xyz, dot(wo, h)) * lobe.x, lobe.y);
}

fn metal_sample(m: u32, wo: vec3f, inside: bool, u: vec3f) -> Scattered {
    let a = packed(m, 0u);
    let edge = packed(m, 1u).xyz;
    if a.w < MIRROR_ALPHA {
        return Scattered(vec3f(-wo.xy, wo.z), 0.0, schlick(a.xyz, edge, wo.z), 1.0);
    }
    let h = visible_normal(wo, a.w, u.xy);
    let wi = mirrored(wo, h);
    if wi.z <= 0.0 {
        return ABSORBED;
    }
    let pdf = microfacet_reflection(wo, wi, h, a.w).y;
    return Scattered(wi, pdf, schlick(a.xyz, edge, dot(wo, h)) * unshadowed(wo, wi, a.w), 1.0);
}
