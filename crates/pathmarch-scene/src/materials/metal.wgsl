// Metal. Twin of metal.rs.

/// Factor that gives back light lost between the facets.
fn metal_compensation(m: u32, wo: vec3f) -> vec3f {
    let share = packed(m, 1u).w;
    if share == 0.0 {
        return vec3f(1.0);
    }
    let a = packed(m, 0u);
    let split = ggx_split(wo.z, sqrt(a.w));
    return vec3f(1.0) + a.xyz * (share * (1.0 / (split.x + split.y) - 1.0));
}

fn metal_eval(m: u32, wo: vec3f, wi: vec3f, inside: bool) -> vec4f {
    let a = packed(m, 0u);
    if wi.z <= 0.0 || a.w < MIRROR_ALPHA {
        return vec4f(0.0);
    }
    let h = normalize(wo + wi);
    let lobe = microfacet_reflection(wo, wi, h, a.w);
    var colour = schlick(a.xyz, packed(m, 1u).xyz, dot(wo, h));
    if COMPENSATES {
        colour *= metal_compensation(m, wo);
    }
    return vec4f(colour * lobe.x, lobe.y);
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
    var colour = schlick(a.xyz, edge, dot(wo, h));
    if COMPENSATES {
        colour *= metal_compensation(m, wo);
    }
    return Scattered(wi, pdf, colour * unshadowed(wo, wi, a.w), 1.0);
}

/// Alpha of the facets, and 1 if they reflect in the colour of the surface.
fn metal_facets(m: u32) -> vec2f {
    return vec2f(packed(m, 0u).w, 1.0);
}

/// Share of the facets in `metal_eval`.
fn metal_facet_share(m: u32, wo: vec3f, wi: vec3f, inside: bool) -> vec3f {
    return vec3f(1.0);
}

/// Chance that a direction of `metal_sample` is one of the facets.
fn metal_facet_chance(m: u32, wo: vec3f, inside: bool) -> f32 {
    return 1.0;
}
