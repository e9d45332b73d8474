// Glass. Twin of glass.rs.

fn glass_eval(m: u32, wo: vec3f, wi: vec3f, inside: bool) -> vec4f {
    let a = packed(m, 0u);
    let index = packed(m, 1u);
    let ior = dispersed_index(index.x, index.y);
    let eta = select(ior, 1.0 / ior, inside);
    if a.w < MIRROR_ALPHA || wi.z == 0.0 {
        return vec4f(0.0);
    }
    if wi.z > 0.0 {
        let h = normalize(wo + wi);
        let lobe = fresnel(dot(wo, h), eta) * microfacet_reflection(wo, wi, h, a.w);
        return vec4f(vec3f(lobe.x), lobe.y);
    }
    let h = refracting_normal(wo, wi, eta);
    if h.z == 0.0 {
        return vec4f(0.0);
    }
    let pdf = (1.0 - fresnel(dot(wo, h), eta)) * refraction_pdf(wo, wi, h, a.w, eta);
    return vec4f(a.xyz * (pdf * unhidden(wi, a.w) / (eta * eta)), pdf);
}

fn glass_sample(m: u32, wo: vec3f, inside: bool, u: vec3f) -> Scattered {
    let a = packed(m, 0u);
    let index = packed(m, 1u);
    let ior = dispersed_index(index.x, index.y);
    let eta = select(ior, 1.0 / ior, inside);
    let smooth_ = a.w < MIRROR_ALPHA;
    var h = vec3f(0.0, 0.0, 1.0);
    if !smooth_ {
        h = visible_normal(wo, a.w, u.xy);
    }
    let reflected = fresnel(dot(wo, h), eta);
    if u.z < reflected {
        let wi = mirrored(wo, h);
        if smooth_ {
            return Scattered(wi, 0.0, vec3f(1.0), 1.0);
        }
        if wi.z <= 0.0 {
            return ABSORBED;
        }
        return Scattered(wi, reflected * microfacet_reflection(wo, wi, h, a.w).y, vec3f(unshadowed(wo, wi, a.w)), 1.0);
    }
    let wi = refracted(wo, h, eta);
    if wi.z >= 0.0 {
        return ABSORBED;
    }
    let weight = a.xyz / (eta * eta);
    if smooth_ {
        return Scattered(wi, 0.0, weight, eta);
    }
    let pdf = (1.0 - reflected) * refraction_pdf(wo, wi, h, a.w, eta);
    return Scattered(wi, pdf, weight * unhidden(wi, a.w), eta);
}
