//! One material for most things: plastic, paint, coated wood, brushed or polished metal, frosted glass. Names and meaning
//! as in glTF 2.0 (KHR_materials_clearcoat, _transmission, _ior) and OpenPBR 1.1, with fewer knobs.
//!
//! From the top: a **coat** (GGX, index 1.5); below it, mixed by `metallic`, a **metal** (GGX, F0 the colour) and a
//! **dielectric**, whose GGX reflection lies over Lambert's surface or, mixed by `transmission`, over refraction. Fresnel's
//! law for the dielectric, Schlick's approximation for metal and coat.
//!
//! Energy: what a layer reflects is taken from what lies below by its directional albedo, on the way in and on the way out
//! (Kulla and Conty 2017, "Revisiting Physically Based Shading at Imageworks"), so that with a white colour a diffuse base
//! under any interface and coat returns all light. Light that GGX loses between its facets is given back by scaling
//! (Turquin 2019, "Practical Multiple Scattering Compensation for Microfacet Models"), which is not quite reciprocal.
//! Refraction is of single scattering and is not compensated. From within the solid, the coat does not act, and what is
//! not transmitted is absorbed. A `roughness` below 0.03 looks like 0.03.

use super::albedo::{self, hemisphere_mean, lookup};
use super::diffuse::cosine_direction;
use super::microfacet::{
    MIN_ALPHA, fifth_power, fresnel, head_on, reflect, reflection, refract, refracting_normal, refraction_pdf, schlick,
    unhidden, visible_normal,
};
use super::{
    Bsdf, BsdfParameters, Dielectric, Eval, Facets, MaterialKind, PreviewMaterial, Scattered, Texturing, absorption,
    anisotropy, colour, colour_of, emission, fraction, glow, ior, priority, roughness, scattering,
};
use crate::medium::Medium;
use glam::Vec3;
use pathmarch_field::Range;
use std::f32::consts::PI;

/// Reflection of the coat at normal incidence: index 1.5.
pub(super) const COAT_F0: f32 = 0.04;

pub(super) static KIND: MaterialKind = MaterialKind {
    name: "principled",
    doc: "Most things: plastic, paint, coated wood, metal, frosted glass.",
    source: "glTF 2.0 and OpenPBR 1.1; Kulla and Conty 2017; Turquin 2019",
    params: &[
        colour(
            "colour",
            0.8,
            Range::from_to(0.0, 1.0),
            "Colour of the base: albedo of a dielectric, reflection of a metal, tint of what is transmitted.",
            Texturing::Colour(0),
        ),
        fraction("metallic", 0.0, "0 is a dielectric, 1 a metal."),
        roughness(0.4),
        ior(),
        fraction("coat", 0.0, "How much of the surface a clear coat covers."),
        fraction("coat-roughness", 0.0, "Roughness of the coat."),
        fraction("transmission", 0.0, "How much of what enters the dielectric is refracted rather than scattered."),
        absorption(),
        emission(),
        scattering("scatter", 0.0),
        anisotropy(),
        glow(),
        priority(),
    ],
    albedo: |values| values[0],
    emission: |values| values[8],
    medium: |values| Medium {
        absorption: values[7],
        scattering: values[9],
        anisotropy: values[10][0],
        emission: values[11],
    },
    dielectric: |values| Dielectric {
        ior: values[3][0].max(MIN_IOR),
        priority: values[12][0] as i32,
        ..Dielectric::VACUUM
    },
    has_surface: true,
    preview,
    bsdf: Some(&Bsdf {
        pack,
        is_delta: |_| false,
        is_lambertian: false,
        focuses: |_| false,
        transmits: |parameters| parameters[TRANSMISSION] * (1.0 - parameters[METALLIC]) > 0.0,
        chooses_lobes: true,
        reads_albedos: |_| true,
        compensates: |_| false,
        at_wavelength: None,
        with_index: Some(|parameters, index| {
            let mut parameters = *parameters;
            let is_matched = (index - 1.0).abs() < MIN_IOR - 1.0;
            parameters[IOR] = if is_matched { MIN_IOR } else { index };
            parameters
        }),
        eval,
        sample,
        facets: Some(&Facets {
            share,
            alpha: |parameters| {
                let covers = parameters[COAT] > 0.0;
                let least =
                    if covers { parameters[ROUGHNESS].min(parameters[COAT_ROUGHNESS]) } else { parameters[ROUGHNESS] };
                least * least
            },
            are_coloured: |parameters| parameters[METALLIC] > 0.5,
        }),
        in_lanes: None,
        smooth_in_lanes: None,
        wgsl: include_str!("principled.wgsl"),
    }),
};

/// Coat and interface as one, as rough as the one that reflects more.
fn preview(values: &[[f32; 3]]) -> PreviewMaterial {
    let [colour, [metallic, ..], [roughness, ..], [ior, ..], [coat, ..], [coat_roughness, ..], [transmission, ..]] =
        std::array::from_fn(|k| values[k]);
    let below = colour.map(|channel| metallic * channel + (1.0 - metallic) * head_on(ior));
    let strongest = below.into_iter().fold(0.0, f32::max);
    // What the eye takes from a sharp reflection over a blurred one is more than its share of the light.
    let (sharp, blurred) = (4.0 * COAT_F0 * coat, strongest);
    let share = sharp / (sharp + blurred).max(1e-6);
    PreviewMaterial {
        diffuse: colour.map(|channel| channel * (1.0 - metallic) * (1.0 - transmission)),
        specular: [below.map(|channel| channel + (1.0 - channel) * COAT_F0 * coat), [1.0; 3]],
        roughness: roughness + (coat_roughness - roughness) * share,
        transmission: colour.map(|channel| channel * (1.0 - metallic) * transmission),
        ior,
    }
}

/// Smallest refractive index: a surface that bends no light has no normal of its facets.
pub(super) const MIN_IOR: f32 = 1.001;

// Places in the numbers, after the colour.
const METALLIC: usize = 3;
const ROUGHNESS: usize = 4;
const IOR: usize = 5;
const F0: usize = 6;
const SPECULAR_MEAN: usize = 7;
const COAT: usize = 8;
const COAT_ROUGHNESS: usize = 9;
const COAT_MEAN: usize = 10;
const TRANSMISSION: usize = 11;
const TABLE: usize = 16;

fn pack(values: &[[f32; 3]]) -> BsdfParameters {
    let [metallic, rough, ior, coat, coat_rough, transmission] = std::array::from_fn(|k| values[k + 1][0]);
    let ior = ior.max(MIN_IOR);
    let f0 = head_on(ior);
    let least = MIN_ALPHA.sqrt();
    let (rough, coat_rough) = (rough.max(least), coat_rough.max(least));
    let mut parameters = BsdfParameters::default();
    parameters[..3].copy_from_slice(&values[0]);
    parameters[METALLIC] = metallic;
    parameters[ROUGHNESS] = rough;
    parameters[IOR] = ior;
    parameters[F0] = f0;
    for k in 0..SHARES {
        parameters[TABLE + k] = integrated_albedo(k, rough, ior, f0);
    }
    parameters[SPECULAR_MEAN] = hemisphere_mean(|cosine| specular_albedo(&parameters, cosine));
    parameters[COAT] = coat;
    parameters[COAT_ROUGHNESS] = coat_rough;
    parameters[COAT_MEAN] = hemisphere_mean(|cosine| coat_albedo(cosine, coat_rough));
    parameters[TRANSMISSION] = transmission;
    parameters
}

/// Factor that gives back what is lost between the facets; the same for light of any colour but for its F0.
fn compensation(f0: f32, [a, b]: [f32; 2]) -> f32 {
    1.0 + f0 * (1.0 / (a + b) - 1.0)
}

/// Cosines at which the numbers hold the share of light that the dielectric interface reflects.
const SHARES: usize = 16;

/// Share of the light from a direction that the dielectric interface reflects.
fn specular_albedo(parameters: &BsdfParameters, cosine: f32) -> f32 {
    let place = cosine.clamp(0.0, 1.0).sqrt() * (SHARES - 1) as f32;
    let k = (place as usize).min(SHARES - 2);
    let share = |k: usize| parameters[TABLE + k];
    share(k) + (share(k + 1) - share(k)) * (place - k as f32)
}

/// Reflected fraction at the cosine of table entry `k`, by integration.
fn integrated_albedo(k: usize, roughness: f32, ior: f32, f0: f32) -> f32 {
    let root = k as f32 / (SHARES - 1) as f32;
    let cosine = (root * root).max(1e-4);
    let single = albedo::integrate(cosine, roughness * roughness, |cosine| fresnel(cosine, ior));
    (single * compensation(f0, lookup(cosine, roughness))).min(1.0)
}

/// Share of the light from a direction that a full coat reflects.
fn coat_albedo(cosine: f32, roughness: f32) -> f32 {
    let [a, b] = lookup(cosine, roughness);
    COAT_F0 * a + b
}

/// Fresnel's factor of the dielectric.
fn dielectric(parameters: &BsdfParameters, cosine: f32, inside: bool) -> f32 {
    fresnel(cosine, if inside { 1.0 / parameters[IOR] } else { parameters[IOR] })
}

/// Terms that depend on `wo` only.
struct View {
    alpha: f32,
    coat_alpha: f32,
    /// 1 outside, 0 inside.
    coat: f32,
    /// Share that the coat leaves, towards `wo`.
    below_coat: f32,
    /// Albedo split at this direction.
    split: [f32; 2],
    specular: f32,
    /// Chances of the coat and of the interface; the rest is diffuse.
    coat_chance: f32,
    interface_chance: f32,
}

fn view(parameters: &BsdfParameters, wo: Vec3, inside: bool) -> View {
    let (metallic, rough, transmission) = (parameters[METALLIC], parameters[ROUGHNESS], parameters[TRANSMISSION]);
    let coat = if inside { 0.0 } else { parameters[COAT] };
    let coat_reflects = coat * coat_albedo(wo.z, parameters[COAT_ROUGHNESS]);
    let split = lookup(wo.z, rough);
    let specular = specular_albedo(parameters, wo.z);
    let colour = colour_of(parameters).max_element();
    let interface = metallic * colour.max(split[1]) + (1.0 - metallic) * (specular + transmission * (1.0 - specular));
    let scattered = (1.0 - metallic) * (1.0 - transmission) * (1.0 - specular) * colour;
    let scattered = if inside { 0.0 } else { scattered };
    let below = (1.0 - coat_reflects) * (interface + scattered);
    let coat_chance = coat_reflects / (coat_reflects + below).max(1e-6);
    let interface_chance = (1.0 - coat_chance) * interface / (interface + scattered).max(1e-6);
    View {
        alpha: rough * rough,
        coat_alpha: parameters[COAT_ROUGHNESS] * parameters[COAT_ROUGHNESS],
        coat,
        below_coat: 1.0 - coat_reflects,
        split,
        specular,
        coat_chance,
        interface_chance,
    }
}

/// Chance that a facet at this cosine reflects rather than refracts.
fn reflect_chance(parameters: &BsdfParameters, dielectric: f32) -> f32 {
    let reflected = parameters[METALLIC] + (1.0 - parameters[METALLIC]) * dielectric;
    let refracted = (1.0 - parameters[METALLIC]) * parameters[TRANSMISSION] * (1.0 - dielectric);
    reflected / (reflected + refracted).max(1e-6)
}

/// Light of a pair of directions: what the facets of coat, interface and metal reflect or refract, and what the base
/// scatters.
struct Layers {
    facets: Vec3,
    base: Vec3,
    pdf: f32,
}

fn eval(parameters: &BsdfParameters, wo: Vec3, wi: Vec3, inside: bool) -> Eval {
    let Layers { facets, base, pdf } = layers(parameters, wo, wi, inside);
    Eval { value: facets + base, pdf }
}

fn share(parameters: &BsdfParameters, wo: Vec3, wi: Vec3, inside: bool) -> Vec3 {
    let Layers { facets, base, .. } = layers(parameters, wo, wi, inside);
    facets / (facets + base).max(Vec3::splat(f32::MIN_POSITIVE))
}

fn layers(parameters: &BsdfParameters, wo: Vec3, wi: Vec3, inside: bool) -> Layers {
    const NONE: Layers = Layers { facets: Vec3::ZERO, base: Vec3::ZERO, pdf: 0.0 };
    let view = view(parameters, wo, inside);
    let (colour, metallic, transmission) = (colour_of(parameters), parameters[METALLIC], parameters[TRANSMISSION]);
    if wi.z < 0.0 {
        let eta = if inside { 1.0 / parameters[IOR] } else { parameters[IOR] };
        let Some(h) = refracting_normal(wo, wi, eta) else { return NONE };
        let facet = dielectric(parameters, wo.dot(h), inside);
        let density = refraction_pdf(wo, wi, h, view.alpha, eta);
        let share = (1.0 - metallic) * transmission * (1.0 - facet) * view.below_coat;
        let facets = colour * (share * density * unhidden(wi, view.alpha) / (eta * eta));
        return Layers {
            facets,
            base: Vec3::ZERO,
            pdf: view.interface_chance * (1.0 - reflect_chance(parameters, facet)) * density,
        };
    }
    if wi.z == 0.0 {
        return NONE;
    }
    let h = (wo + wi).normalize();
    let cosine = wo.dot(h);
    let coat_reflects = view.coat * coat_albedo(wi.z, parameters[COAT_ROUGHNESS]);
    let through_coat = view.below_coat * (1.0 - coat_reflects);

    let facet = dielectric(parameters, cosine, inside);
    let [a, b] = view.split;
    let metal = Vec3::from(schlick(colour, Vec3::ONE, cosine)) * (Vec3::ONE + colour * (1.0 / (a + b) - 1.0));
    let interface = metal * metallic + Vec3::splat((1.0 - metallic) * facet * compensation(parameters[F0], view.split));
    let (value, density) = reflection(wo, wi, h, view.alpha);
    let mut facets = interface * (value * through_coat);
    let mut pdf = view.interface_chance * reflect_chance(parameters, facet) * density;

    let (coat_value, coat_density) = reflection(wo, wi, h, view.coat_alpha);
    facets += Vec3::splat(view.coat * (COAT_F0 + (1.0 - COAT_F0) * fifth_power(1.0 - cosine)) * coat_value);
    pdf += view.coat_chance * coat_density;

    let mut base = Vec3::ZERO;
    if !inside {
        let below = (1.0 - view.specular) * (1.0 - specular_albedo(parameters, wi.z))
            / (1.0 - parameters[SPECULAR_MEAN]).max(1e-3);
        let below_coat = through_coat / (1.0 - view.coat * parameters[COAT_MEAN]);
        let share = (1.0 - metallic) * (1.0 - transmission) * below * below_coat;
        base = colour * (share * wi.z / PI);
        pdf += (1.0 - view.coat_chance - view.interface_chance) * wi.z / PI;
    }
    Layers { facets, base, pdf }
}

fn sample(parameters: &BsdfParameters, wo: Vec3, inside: bool, [u, v, choice]: [f32; 3]) -> Option<Scattered> {
    let view = view(parameters, wo, inside);
    let mut eta = 1.0;
    let wi: Vec3 = if choice < view.coat_chance {
        reflect(wo, visible_normal(wo, view.coat_alpha, [u, v])).into()
    } else if choice < view.coat_chance + view.interface_chance {
        let h: Vec3 = visible_normal(wo, view.alpha, [u, v]).into();
        let facet_choice = (choice - view.coat_chance) / view.interface_chance;
        if facet_choice < reflect_chance(parameters, dielectric(parameters, wo.dot(h), inside)) {
            reflect(wo, h).into()
        } else {
            eta = if inside { 1.0 / parameters[IOR] } else { parameters[IOR] };
            refract(wo, h, eta).into()
        }
    } else {
        cosine_direction([u, v]).into()
    };
    if (wi.z > 0.0) != (eta == 1.0) {
        return None;
    }
    let Eval { value, pdf } = eval(parameters, wo, wi, inside);
    (pdf > 0.0).then(|| Scattered { wi, weight: value / pdf, pdf, eta })
}
