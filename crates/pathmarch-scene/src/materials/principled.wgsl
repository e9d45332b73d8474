// One material for most things. Twin of principled.rs, which explains it.

/// Refractive index of the solid, relative to what is outside.
fn principled_ior(m: u32) -> f32 {
    let ior = packed(m, 1u).y;
    if !NESTED_DIELECTRICS {
        return ior;
    }
    let index = index_at_surface(ior, 0.0);
    return select(index, MIN_IOR, abs(index - 1.0) < MIN_IOR - 1.0);
}

fn compensation(f0: f32, split: vec2f) -> f32 {
    return 1.0 + f0 * (1.0 / (split.x + split.y) - 1.0);
}

fn specular_share(m: u32, k: u32) -> f32 {
    return packed(m, 4u + k / 4u)[k % 4u];
}

fn specular_albedo(m: u32, cosine: f32) -> f32 {
    let place = sqrt(clamp(cosine, 0.0, 1.0)) * 15.0;
    let k = min(u32(place), 14u);
    return mix(specular_share(m, k), specular_share(m, k + 1u), place - f32(k));
}

fn coat_albedo(cosine: f32, roughness: f32) -> f32 {
    let split = ggx_split(cosine, roughness);
    return COAT_F0 * split.x + split.y;
}

struct PrincipledView {
    alpha: f32,
    coat_alpha: f32,
    coat: f32,
    below_coat: f32,
    split: vec2f,
    specular: f32,
    coat_chance: f32,
    interface_chance: f32,
}

fn principled_view(m: u32, wo: vec3f, inside: bool) -> PrincipledView {
    let a = packed(m, 0u);
    let b = packed(m, 1u);
    let c = packed(m, 2u);
    let coat = select(c.x, 0.0, inside);
    let coat_reflects = coat * coat_albedo(wo.z, c.y);
    let split = ggx_split(wo.z, b.x);
    let specular = specular_albedo(m, wo.z);
    let colour = largest(a.xyz);
    let interface_ = a.w * max(colour, split.y) + (1.0 - a.w) * (specular + c.w * (1.0 - specular));
    let scattered = select((1.0 - a.w) * (1.0 - c.w) * (1.0 - specular) * colour, 0.0, inside);
    let below = (1.0 - coat_reflects) * (interface_ + scattered);
    let coat_chance = coat_reflects / max(coat_reflects + below, 1e-6);
    let interface_chance = (1.0 - coat_chance) * interface_ / max(interface_ + scattered, 1e-6);
    return PrincipledView(b.x * b.x, c.y * c.y, coat, 1.0 - coat_reflects, split, specular, coat_chance, interface_chance);
}

fn reflect_chance(m: u32, dielectric: f32) -> f32 {
    let metallic = packed(m, 0u).w;
    let reflected = metallic + (1.0 - metallic) * dielectric;
    let refracted = (1.0 - metallic) * packed(m, 2u).w * (1.0 - dielectric);
    return reflected / max(reflected + refracted, 1e-6);
}

/// Light of a pair of directions: of the facets of coat, interface and metal, and of the base.
struct PrincipledLayers {
    facets: vec3f,
    base: vec3f,
    pdf: f32,
}

fn principled_eval(m: u32, wo: vec3f, wi: vec3f, inside: bool) -> vec4f {
    return principled_eval_from(m, principled_view(m, wo, inside), wo, wi, inside);
}

fn principled_eval_from(m: u32, view: PrincipledView, wo: vec3f, wi: vec3f, inside: bool) -> vec4f {
    let layers = principled_layers(m, view, wo, wi, inside);
    return vec4f(layers.facets + layers.base, layers.pdf);
}

/// Alpha of the smoothest facets, and 1 if they reflect in the colour of the surface.
fn principled_facets(m: u32) -> vec2f {
    let roughness = packed(m, 1u).x;
    let coat = packed(m, 2u).xy;
    let least = select(roughness, min(roughness, coat.y), coat.x > 0.0);
    return vec2f(least * least, select(0.0, 1.0, packed(m, 0u).w > 0.5));
}

/// Share of the facets in `principled_eval`.
fn principled_facet_share(m: u32, wo: vec3f, wi: vec3f, inside: bool) -> vec3f {
    let layers = principled_layers(m, principled_view(m, wo, inside), wo, wi, inside);
    return layers.facets / max(layers.facets + layers.base, vec3f(1.1754944e-38));
}

/// Chance that a direction of `principled_sample` is one of the facets.
fn principled_facet_chance(m: u32, wo: vec3f, inside: bool) -> f32 {
    let view = principled_view(m, wo, inside);
    return view.coat_chance + view.interface_chance;
}

fn principled_layers(m: u32, view: PrincipledView, wo: vec3f, wi: vec3f, inside: bool) -> PrincipledLayers {
    let a = packed(m, 0u);
    let b = packed(m, 1u);
    let c = packed(m, 2u);
    let ior = principled_ior(m);
    if wi.z < 0.0 {
        let eta = select(ior, 1.0 / ior, inside);
        let h = refracting_normal(wo, wi, eta);
        if h.z == 0.0 {
            return PrincipledLayers(vec3f(0.0), vec3f(0.0), 0.0);
        }
        let facet = fresnel(dot(wo, h), eta);
        let density = refraction_pdf(wo, wi, h, view.alpha, eta);
        let share = (1.0 - a.w) * c.w * (1.0 - facet) * view.below_coat;
        let value = a.xyz * (share * density * unhidden(wi, view.alpha) / (eta * eta));
        return PrincipledLayers(value, vec3f(0.0), view.interface_chance * (1.0 - reflect_chance(m, facet)) * density);
    }
    if wi.z == 0.0 {
        return PrincipledLayers(vec3f(0.0), vec3f(0.0), 0.0);
    }
    let h = normalize(wo + wi);
    let cosine = dot(wo, h);
    let coat_reflects = view.coat * coat_albedo(wi.z, c.y);
    let through_coat = view.below_coat * (1.0 - coat_reflects);

    let facet = fresnel(cosine, select(ior, 1.0 / ior, inside));
    let lost = 1.0 / (view.split.x + view.split.y) - 1.0;
    let metal = schlick(a.xyz, vec3f(1.0), cosine) * (1.0 + a.xyz * lost);
    let interface_ = metal * a.w + vec3f((1.0 - a.w) * facet * compensation(b.z, view.split));
    let lobe = microfacet_reflection(wo, wi, h, view.alpha);
    var facets = interface_ * (lobe.x * through_coat);
    var pdf = view.interface_chance * reflect_chance(m, facet) * lobe.y;

    let coat = microfacet_reflection(wo, wi, h, view.coat_alpha);
    facets += vec3f(view.coat * (COAT_F0 + (1.0 - COAT_F0) * fifth_power(1.0 - cosine)) * coat.x);
    pdf += view.coat_chance * coat.y;

    var base = vec3f(0.0);
    if !inside {
        let below = (1.0 - view.specular) * (1.0 - specular_albedo(m, wi.z)) / max(1.0 - b.w, 1e-3);
        let below_coat = through_coat / (1.0 - view.coat * c.z);
        base = a.xyz * ((1.0 - a.w) * (1.0 - c.w) * below * below_coat * wi.z / 3.14159265);
        pdf += (1.0 - view.coat_chance - view.interface_chance) * wi.z / 3.14159265;
    }
    return PrincipledLayers(facets, base, pdf);
}

fn principled_sample(m: u32, wo: vec3f, inside: bool, u: vec3f) -> Scattered {
    let view = principled_view(m, wo, inside);
    let ior = principled_ior(m);
    var eta = 1.0;
    var wi = vec3f(0.0);
    if u.z < view.coat_chance {
        wi = mirrored(wo, visible_normal(wo, view.coat_alpha, u.xy));
    } else if u.z < view.coat_chance + view.interface_chance {
        let h = visible_normal(wo, view.alpha, u.xy);
        let facet_choice = (u.z - view.coat_chance) / view.interface_chance;
        let facet = fresnel(dot(wo, h), select(ior, 1.0 / ior, inside));
        if facet_choice < reflect_chance(m, facet) {
            wi = mirrored(wo, h);
        } else {
            eta = select(ior, 1.0 / ior, inside);
            wi = refracted(wo, h, eta);
        }
    } else {
        wi = cosine_direction(u.xy);
    }
    if (wi.z > 0.0) != (eta == 1.0) {
        return ABSORBED;
    }
    let both = principled_eval_from(m, view, wo, wi, inside);
    if both.w <= 0.0 {
        return ABSORBED;
    }
    return Scattered(wi, both.w, both.xyz / both.w, eta);
}
