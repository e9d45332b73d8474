// GGX with Smith's masking. Twin of microfacet.rs, which explains it.

fn microfacet_distribution(h: vec3f, alpha: f32) -> f32 {
    let square = alpha * alpha;
    return square / inverse_distribution(h, square);
}

/// Square of alpha, of which `square` is that, divided by the density of normals.
fn inverse_distribution(h: vec3f, square: f32) -> f32 {
    let slope = h.x * h.x + h.y * h.y + square * h.z * h.z;
    return 3.14159265 * slope * slope;
}

fn stretched(w: vec3f, alpha: f32) -> f32 {
    return sqrt(alpha * alpha * (w.x * w.x + w.y * w.y) + w.z * w.z);
}

fn unhidden(w: vec3f, alpha: f32) -> f32 {
    return 2.0 * abs(w.z) / (stretched(w, alpha) + abs(w.z));
}

/// BRDF times cosine with a Fresnel factor of one, and its density.
fn microfacet_reflection(wo: vec3f, wi: vec3f, h: vec3f, alpha: f32) -> vec2f {
    let o = stretched(wo, alpha);
    let i = stretched(wi, alpha);
    let square = alpha * alpha;
    let d = inverse_distribution(h, square);
    return square * vec2f(wi.z / (d * max(2.0 * (wi.z * o + wo.z * i), 1e-20)), 1.0 / (d * (2.0 * (o + wo.z))));
}

/// The weight of a sample of reflection with a Fresnel factor of one.
fn unshadowed(wo: vec3f, wi: vec3f, alpha: f32) -> f32 {
    let o = stretched(wo, alpha);
    let i = stretched(wi, alpha);
    return wi.z * (o + wo.z) / (wi.z * o + wo.z * i);
}

fn refraction_pdf(wo: vec3f, wi: vec3f, h: vec3f, alpha: f32, eta: f32) -> f32 {
    let cos_o = dot(wo, h);
    let cos_i = dot(wi, h);
    let visible = 2.0 * cos_o * microfacet_distribution(h, alpha) / (stretched(wo, alpha) + wo.z);
    let root = cos_o + eta * cos_i;
    return visible * eta * eta * abs(cos_i) / max(root * root, 1e-20);
}

fn visible_normal(wo: vec3f, alpha: f32, u: vec2f) -> vec3f {
    let round = normalize(vec3f(alpha * wo.x, alpha * wo.y, wo.z));
    let z = (1.0 - u.y) * (1.0 + round.z) - round.z;
    let radius = sqrt(max(1.0 - z * z, 0.0));
    let h = vec3f(radius * unit_circle(u.x), z) + round;
    return normalize(vec3f(alpha * h.x, alpha * h.y, max(h.z, 1e-9)));
}

fn fifth_power(x: f32) -> f32 {
    let y = clamp(x, 0.0, 1.0);
    return y * y * y * y * y;
}

fn schlick(f0: vec3f, f90: vec3f, cosine: f32) -> vec3f {
    return f0 + (f90 - f0) * fifth_power(1.0 - cosine);
}

fn refracted_cosine(cosine: f32, eta: f32) -> f32 {
    return sqrt(max(1.0 - (1.0 - cosine * cosine) / (eta * eta), 0.0));
}

fn fresnel(cosine: f32, eta: f32) -> f32 {
    let beyond = refracted_cosine(cosine, eta);
    if beyond <= 0.0 {
        return 1.0;
    }
    let parallel = (eta * cosine - beyond) / (eta * cosine + beyond);
    let perpendicular = (cosine - eta * beyond) / (cosine + eta * beyond);
    return 0.5 * (parallel * parallel + perpendicular * perpendicular);
}

/// Fraction that a sheet reflects whose faces reflect `face` each.
fn sheet_reflection(face: f32) -> f32 {
    return 2.0 * face / (1.0 + face);
}

fn mirrored(wo: vec3f, h: vec3f) -> vec3f {
    return h * (2.0 * dot(wo, h)) - wo;
}

fn refracted(wo: vec3f, h: vec3f, eta: f32) -> vec3f {
    let cosine = dot(wo, h);
    return h * (cosine / eta - refracted_cosine(cosine, eta)) - wo / eta;
}

/// The normal that refracts `wo` into `wi`; zero where there is none.
fn refracting_normal(wo: vec3f, wi: vec3f, eta: f32) -> vec3f {
    let sum = wo + wi * eta;
    let square = dot(sum, sum);
    if square < 1e-20 {
        return vec3f(0.0);
    }
    let h = sum * (select(1.0, -1.0, sum.z < 0.0) * inverseSqrt(square));
    return select(vec3f(0.0), h, dot(wo, h) > 0.0 && dot(wi, h) < 0.0);
}
