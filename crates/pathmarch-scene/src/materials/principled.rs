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
    Bsdf, BsdfInLanes, BsdfParameters, Dielectric, Eval, EvalInLanes, Facets, KindInLanes, MaterialKind,
    ParametersInLanes, PreviewMaterial, Scattered, ScatteredInLanes, Texturing, absorption, anisotropy, colour,
    emission, fraction, glow, ior, priority, roughness, scattering,
};
use crate::medium::Medium;
use glam::Vec3;
use pathmarch_field::Range;
use pathmarch_field::number::{Mask8, Real, Vec3 as FieldVec3};
use std::f32::consts::FRAC_1_PI;
use wide::f32x8;

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
            chance: |parameters, wo, inside| {
                let surface = Principled::<f32>::new(parameters, wo.into(), inside);
                surface.coat_chance + surface.interface_chance
            },
            are_coloured: |parameters| parameters[METALLIC] > 0.5,
        }),
        in_lanes: Some(KindInLanes::Principled),
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
    parameters[SPECULAR_MEAN] = hemisphere_mean(|cosine| parameters.specular_albedo(cosine));
    parameters[COAT] = coat;
    parameters[COAT_ROUGHNESS] = coat_rough;
    parameters[COAT_MEAN] = hemisphere_mean(|cosine| coat_albedo(cosine, coat_rough));
    parameters[TRANSMISSION] = transmission;
    parameters
}

/// Factor that gives back what is lost between the facets; the same for light of any colour but for its F0.
fn compensation<N: Real>(f0: N, [a, b]: [N; 2]) -> N {
    N::one() + f0 * (N::one() / (a + b) - N::one())
}

/// Cosines at which the numbers hold the share of light that the dielectric interface reflects.
const SHARES: usize = 16;

/// Parameters of one surface, or of eight.
trait Parameters<N> {
    /// The first of them.
    fn first(&self) -> [N; TRANSMISSION + 1];
    /// True if a surface has a coat.
    fn has_coat(&self) -> bool;
    /// Share of the light from a direction that the dielectric interface reflects.
    fn specular_albedo(&self, cosine: N) -> N;
}

impl Parameters<f32> for BsdfParameters {
    fn first(&self) -> [f32; TRANSMISSION + 1] {
        std::array::from_fn(|k| self[k])
    }
    fn has_coat(&self) -> bool {
        self[COAT] > 0.0
    }
    fn specular_albedo(&self, cosine: f32) -> f32 {
        let place = cosine.clamp(0.0, 1.0).sqrt() * (SHARES - 1) as f32;
        let k = (place as usize).min(SHARES - 2);
        let share = |k: usize| self[TABLE + k];
        share(k) + (share(k + 1) - share(k)) * (place - k as f32)
    }
}

impl Parameters<f32x8> for ParametersInLanes<'_> {
    #[inline(always)]
    fn first(&self) -> [f32x8; TRANSMISSION + 1] {
        std::array::from_fn(|k| self.first[k])
    }
    #[inline(always)]
    fn has_coat(&self) -> bool {
        self.first[COAT].to_array() != [0.0; 8]
    }
    #[inline(always)]
    fn specular_albedo(&self, cosine: f32x8) -> f32x8 {
        let cosines = cosine.to_array();
        f32x8::from(std::array::from_fn(|lane| self.surfaces[lane].specular_albedo(cosines[lane])))
    }
}

/// Reflected fraction at the cosine of table entry `k`, by integration.
fn integrated_albedo(k: usize, roughness: f32, ior: f32, f0: f32) -> f32 {
    let root = k as f32 / (SHARES - 1) as f32;
    let cosine = (root * root).max(1e-4);
    let single = albedo::integrate(cosine, roughness * roughness, |cosine| fresnel(cosine, ior));
    (single * compensation(f0, lookup(cosine, roughness))).min(1.0)
}

/// Share of the light from a direction that a full coat reflects.
#[inline(always)]
fn coat_albedo<N: Real>(cosine: N, roughness: N) -> N {
    let [a, b] = lookup(cosine, roughness);
    N::constant(COAT_F0) * a + b
}

/// Surface of one path, or of eight, seen from a direction.
struct Principled<N> {
    colour: FieldVec3<N>,
    metallic: N,
    transmission: N,
    /// Refractive index beyond the interface over that before it.
    eta: N,
    alpha: N,
    coat_alpha: N,
    coat_roughness: N,
    /// How much of the surface a coat covers: 0 from within.
    coat: N,
    /// Share that the coat leaves, towards `wo`.
    below_coat: N,
    /// Factor of the dielectric that gives back what is lost between its facets; that of a metal of unit colour, less one.
    compensation: N,
    metal_compensation: N,
    /// What the base scatters of a colour of 1, over the shares of the interface and the coat towards `wi`.
    base: N,
    /// Chances of the coat and of the interface; the rest is diffuse.
    coat_chance: N,
    interface_chance: N,
}

/// Light of a pair of directions: what the facets of coat, interface and metal reflect or refract, and what the base
/// scatters.
struct Layers<N> {
    facets: FieldVec3<N>,
    base: FieldVec3<N>,
    pdf: N,
}

impl<N: Real> Principled<N> {
    #[inline(always)]
    fn new(parameters: &impl Parameters<N>, wo: FieldVec3<N>, inside: N::Mask) -> Self {
        let [r, g, b, metallic, rough, ior, f0, specular_mean, coat, coat_roughness, coat_mean, transmission] =
            parameters.first();
        let (zero, one, tiny) = (N::zero(), N::one(), N::constant(1e-6));
        let coat = N::select(inside, zero, coat);
        let coat_reflects = if parameters.has_coat() { coat * coat_albedo(wo.z, coat_roughness) } else { zero };
        let split = lookup(wo.z, rough);
        let specular = parameters.specular_albedo(wo.z);
        let colour = FieldVec3::new(r, g, b);
        let (brightest, dielectric) = (colour.largest(), one - metallic);
        let interface = metallic * brightest.max(split[1]) + dielectric * (specular + transmission * (one - specular));
        let scatters = N::select(inside, zero, dielectric * (one - transmission) * (one - specular));
        let scattered = scatters * brightest;
        let below_coat = one - coat_reflects;
        let coat_chance = coat_reflects / (coat_reflects + below_coat * (interface + scattered)).max(tiny);
        let interface_chance = (one - coat_chance) * interface / (interface + scattered).max(tiny);
        let below = below_coat / ((one - specular_mean).max(N::constant(1e-3)) * (one - coat * coat_mean));
        Self {
            colour,
            metallic,
            transmission,
            eta: N::select(inside, one / ior, ior),
            alpha: rough * rough,
            coat_alpha: coat_roughness * coat_roughness,
            coat_roughness,
            coat,
            below_coat,
            compensation: compensation(f0, split),
            metal_compensation: compensation(one, split) - one,
            base: scatters * below,
            coat_chance,
            interface_chance,
        }
    }

    /// Chance that a facet of this Fresnel factor reflects rather than refracts.
    #[inline(always)]
    fn reflect_chance(&self, facet: N) -> N {
        let dielectric = N::one() - self.metallic;
        let reflected = self.metallic + dielectric * facet;
        let refracted = dielectric * self.transmission * (N::one() - facet);
        reflected / (reflected + refracted).max(N::constant(1e-6))
    }

    /// Light of directions above the surface.
    #[inline(always)]
    fn reflected(&self, parameters: &impl Parameters<N>, wo: FieldVec3<N>, wi: FieldVec3<N>) -> Layers<N> {
        let one = N::one();
        let h = (wo + wi).normalized();
        let cosine = wo.dot(h);
        let facet = fresnel(cosine, self.eta);
        let metal = schlick(self.colour, FieldVec3::splat(one), cosine)
            .times(FieldVec3::splat(one) + self.colour * self.metal_compensation);
        let interface = metal * self.metallic + FieldVec3::splat((one - self.metallic) * facet * self.compensation);
        let (value, density) = reflection(wo, wi, h, self.alpha);
        let mut through_coat = one;
        let mut coat = N::zero();
        let mut pdf = self.interface_chance * self.reflect_chance(facet) * density;
        if parameters.has_coat() {
            through_coat = one - self.coat * coat_albedo(wi.z, self.coat_roughness);
            let (value, density) = reflection(wo, wi, h, self.coat_alpha);
            let f0 = N::constant(COAT_F0);
            coat = self.coat * (f0 + (one - f0) * fifth_power(one - cosine)) * value;
            pdf = pdf + self.coat_chance * density;
        }
        let facets = interface * (value * self.below_coat * through_coat) + FieldVec3::splat(coat);
        let lambertian = wi.z * N::constant(FRAC_1_PI);
        let base = self.base * through_coat * (one - parameters.specular_albedo(wi.z)) * lambertian;
        let base_chance = N::select(N::zero().lt(self.base), one - self.coat_chance - self.interface_chance, N::zero());
        Layers { facets, base: self.colour * base, pdf: pdf + base_chance * lambertian }
    }
}

impl Principled<f32> {
    /// Light of directions below the surface.
    fn refracted(&self, wo: Vec3, wi: Vec3) -> Layers<f32> {
        let Some(h) = refracting_normal(wo, wi, self.eta) else { return Layers::NONE };
        let facet = fresnel(wo.dot(h), self.eta);
        let density = refraction_pdf(wo, wi, h, self.alpha, self.eta);
        let share = (1.0 - self.metallic) * self.transmission * (1.0 - facet) * self.below_coat;
        Layers {
            facets: self.colour * (share * density * unhidden(wi, self.alpha) / (self.eta * self.eta)),
            pdf: self.interface_chance * (1.0 - self.reflect_chance(facet)) * density,
            ..Layers::NONE
        }
    }

    fn layers(&self, parameters: &BsdfParameters, wo: Vec3, wi: Vec3) -> Layers<f32> {
        match wi.z {
            ..0.0 => self.refracted(wo, wi),
            0.0 => Layers::NONE,
            _ => self.reflected(parameters, wo.into(), wi.into()),
        }
    }
}

impl Layers<f32> {
    const NONE: Self =
        Self { facets: FieldVec3 { x: 0.0, y: 0.0, z: 0.0 }, base: FieldVec3 { x: 0.0, y: 0.0, z: 0.0 }, pdf: 0.0 };

    fn eval(self) -> Eval {
        Eval { value: (self.facets + self.base).into(), pdf: self.pdf }
    }
}

fn eval(parameters: &BsdfParameters, wo: Vec3, wi: Vec3, inside: bool) -> Eval {
    Principled::<f32>::new(parameters, wo.into(), inside).layers(parameters, wo, wi).eval()
}

fn share(parameters: &BsdfParameters, wo: Vec3, wi: Vec3, inside: bool) -> Vec3 {
    let layers = Principled::<f32>::new(parameters, wo.into(), inside).layers(parameters, wo, wi);
    Vec3::from(layers.facets) / Vec3::from(layers.facets + layers.base).max(Vec3::splat(f32::MIN_POSITIVE))
}

fn sample(parameters: &BsdfParameters, wo: Vec3, inside: bool, [u, v, choice]: [f32; 3]) -> Option<Scattered> {
    let surface = Principled::<f32>::new(parameters, wo.into(), inside);
    let mut eta = 1.0;
    let wi: Vec3 = if choice < surface.coat_chance {
        reflect(wo, visible_normal(wo, surface.coat_alpha, [u, v])).into()
    } else if choice < surface.coat_chance + surface.interface_chance {
        let h: Vec3 = visible_normal(wo, surface.alpha, [u, v]).into();
        let facet_choice = (choice - surface.coat_chance) / surface.interface_chance;
        if facet_choice < surface.reflect_chance(fresnel(wo.dot(h), surface.eta)) {
            reflect(wo, h).into()
        } else {
            eta = surface.eta;
            refract(wo, h, eta).into()
        }
    } else {
        cosine_direction([u, v]).into()
    };
    if (wi.z > 0.0) != (eta == 1.0) {
        return None;
    }
    let Eval { value, pdf } = surface.layers(parameters, wo, wi).eval();
    (pdf > 0.0).then(|| Scattered { wi, weight: value / pdf, pdf, eta })
}

/// Principled surfaces of eight paths, none of which transmits.
pub struct PrincipledInLanes(Principled<f32x8>);

impl BsdfInLanes for PrincipledInLanes {
    const PARAMETERS: usize = TRANSMISSION + 1;

    #[inline(always)]
    fn new(parameters: &ParametersInLanes, wo: FieldVec3<f32x8>, inside: Mask8) -> Self {
        Self(Principled::new(parameters, wo, inside))
    }

    #[inline(always)]
    fn eval(&self, parameters: &ParametersInLanes, wo: FieldVec3<f32x8>, wi: FieldVec3<f32x8>) -> EvalInLanes {
        let Layers { facets, base, pdf } = self.0.reflected(parameters, wo, wi);
        let (is_above, zero) = (f32x8::ZERO.lt(wi.z), f32x8::ZERO);
        let value = FieldVec3::select(is_above, facets + base, FieldVec3::splat(zero));
        EvalInLanes { value, pdf: Real::select(is_above, pdf, zero) }
    }

    #[inline(always)]
    fn sample(
        &self,
        parameters: &ParametersInLanes,
        wo: FieldVec3<f32x8>,
        [u, v, choice]: [f32x8; 3],
    ) -> ScatteredInLanes {
        let surface = &self.0;
        let (zero, one) = (f32x8::ZERO, f32x8::ONE);
        let is_coat = choice.lt(surface.coat_chance);
        let is_base = !choice.lt(surface.coat_chance + surface.interface_chance);
        let h = visible_normal(wo, Real::select(is_coat, surface.coat_alpha, surface.alpha), [u, v]);
        let facet_choice = (choice - surface.coat_chance) / surface.interface_chance;
        let is_mirrored = is_coat | facet_choice.lt(surface.reflect_chance(fresnel(wo.dot(h), surface.eta)));
        let below = FieldVec3::new(zero, zero, -one);
        let of_facets = FieldVec3::select(is_mirrored, reflect(wo, h), below);
        let wi = FieldVec3::select(is_base, cosine_direction([u, v]), of_facets);
        let EvalInLanes { value, pdf } = self.eval(parameters, wo, wi);
        let exists = zero.lt(pdf);
        let weight = FieldVec3::select(exists, value / pdf, FieldVec3::splat(zero));
        ScatteredInLanes { wi: FieldVec3::select(exists, wi, below), weight, pdf }
    }
}
