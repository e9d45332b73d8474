// Glass. Twin of glass.rs.

/// Roughness of a surface with a relative index.
fn alpha_at_surface(alpha: f32, ior: f32) -> f32 {
    return select(alpha, 0.0, NESTED_DIELECTRICS && abs(ior - 1.0) < MATCHED_INDEX);
}

/// Albedo of reflection and refraction together at an entry of a table of twelve cosines; `side` is its first parameter.
fn glass_albedo(m: u32, side: u32, k: u32) -> f32 {
    return packed(m, (side + k) / 4u)[(side + k) % 4u];
}

/// Factor that gives back light lost between the facets.
fn glass_compensation(m: u32, wo: vec3f, inside: bool) -> f32 {
    let share = packed(m, 1u).z;
    if !COMPENSATES || share == 0.0 {
        return 1.0;
    }
    if NESTED_DIELECTRICS && abs(surface_index / packed(m, 1u).x - 1.0) > COMPENSATED_CHANGE {
        return 1.0;
    }
    let side = select(7u, 19u, inside);
    let place = sqrt(clamp(wo.z, 0.0, 1.0)) * 11.0;
    let k = min(u32(place), 10u);
    let albedo = mix(glass_albedo(m, side, k), glass_albedo(m, side, k + 1u), place - f32(k));
    return 1.0 + share * (1.0 / max(albedo, 0.1) - 1.0);
}

fn glass_eval(m: u32, wo: vec3f, wi: vec3f, inside: bool) -> vec4f {
    let a = packed(m, 0u);
    let index = packed(m, 1u);
    let ior = index_at_surface(index.x, index.y);
    let alpha = alpha_at_surface(a.w, ior);
    let eta = select(ior, 1.0 / ior, inside);
    if alpha < MIRROR_ALPHA || wi.z == 0.0 {
        return vec4f(0.0);
    }
    if wi.z > 0.0 {
        let h = normalize(wo + wi);
        let lobe = fresnel(dot(wo, h), eta) * microfacet_reflection(wo, wi, h, alpha);
        return vec4f(vec3f(lobe.x * glass_compensation(m, wo, inside)), lobe.y);
    }
    let h = refracting_normal(wo, wi, eta);
    if h.z == 0.0 {
        return vec4f(0.0);
    }
    let pdf = (1.0 - fresnel(dot(wo, h), eta)) * refraction_pdf(wo, wi, h, alpha, eta);
    return vec4f(a.xyz * (pdf * unhidden(wi, alpha) * glass_compensation(m, wo, inside) / (eta * eta)), pdf);
}

fn glass_sample(m: u32, wo: vec3f, inside: bool, u: vec3f) -> Scattered {
    let a = packed(m, 0u);
    let index = packed(m, 1u);
    let ior = index_at_surface(index.x, index.y);
    if THIN_GLASS && packed(m, 7u).w > 0.0 {
        // Both faces lie between the same two media, whichever side light comes from.
        if u.z < sheet_reflection(fresnel(wo.z, ior)) {
            return Scattered(mirrored(wo, vec3f(0.0, 0.0, 1.0)), 0.0, vec3f(1.0), 1.0);
        }
        return Scattered(-wo, 0.0, a.xyz, 1.0);
    }
    let alpha = alpha_at_surface(a.w, ior);
    let eta = select(ior, 1.0 / ior, inside);
    let smooth_ = alpha < MIRROR_ALPHA;
    var h = vec3f(0.0, 0.0, 1.0);
    if !smooth_ {
        h = visible_normal(wo, alpha, u.xy);
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
        let weight = unshadowed(wo, wi, alpha) * glass_compensation(m, wo, inside);
        return Scattered(wi, reflected * microfacet_reflection(wo, wi, h, alpha).y, vec3f(weight), 1.0);
    }
    let wi = refracted(wo, h, eta);
    if wi.z >= 0.0 {
        return ABSORBED;
    }
    let weight = a.xyz / (eta * eta);
    if smooth_ {
        return Scattered(wi, 0.0, weight, eta);
    }
    let pdf = (1.0 - reflected) * refraction_pdf(wo, wi, h, alpha, eta);
    return Scattered(wi, pdf, weight * (unhidden(wi, alpha) * glass_compensation(m, wo, inside)), eta);
}

/// Alpha of the facets, and 1 if they reflect in the colour of the surface.
fn glass_facets(m: u32) -> vec2f {
    return vec2f(packed(m, 0u).w, 0.0);
}

/// Share of the facets in `glass_eval`.
fn glass_facet_share(m: u32, wo: vec3f, wi: vec3f, inside: bool) -> vec3f {
    return vec3f(1.0);
}

/// Chance that a direction of `glass_sample` is one of the facets.
fn glass_facet_chance(m: u32, wo: vec3f, inside: bool) -> f32 {
    return 1.0;
}
