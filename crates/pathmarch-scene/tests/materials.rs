//! Every kind of material that scatters: what it samples is what it says it samples, it makes no light, and it is the same
//! both ways where it should be.

use crate::random::Random;
use glam::Vec3;
use pathmarch_field::number::{Real, Vec3 as FieldVec3};
use pathmarch_scene::materials::{
    Bsdf, BsdfInLanes, BsdfParameters, DiffuseInLanes, KindInLanes, MaterialKind, MetalInLanes, ParamKind,
    ParametersInLanes, PrincipledInLanes, albedo, fresnel, kinds, straight_transmittance,
};
use std::f32::consts::{PI, TAU};
use wide::f32x8;

struct Variant {
    name: String,
    bsdf: &'static Bsdf,
    numbers: BsdfParameters,
    transmits: bool,
    delta: bool,
}

/// A kind with white colours, each number between its bounds at a few places, and every roughness given.
fn variants(roughnesses: &[f32]) -> Vec<Variant> {
    let mut all = Vec::new();
    for kind in kinds() {
        let Some(bsdf) = kind.bsdf else { continue };
        for &roughness in roughnesses {
            for mix in 0..4 {
                let values = values(kind, roughness, mix);
                let numbers = (bsdf.pack)(&values);
                let variant = |name: String, numbers: BsdfParameters| Variant {
                    name,
                    bsdf,
                    transmits: (bsdf.transmits)(&numbers),
                    delta: (bsdf.is_delta)(&numbers),
                    numbers,
                };
                let name = format!("{} roughness {roughness} mix {mix}", kind.name);
                // As in water: the index relative to it is below 1.
                let submerged = bsdf.with_index.map(|with_index| with_index(&numbers, 0.7));
                let submerged = submerged.filter(|numbers| mix < 3 && (bsdf.transmits)(numbers));
                all.extend(submerged.map(|numbers| variant(format!("{name} in water"), numbers)));
                all.push(variant(name, numbers));
            }
        }
    }
    all
}

/// White, and of the fractions other than roughness those that the mix names: none, the first, the second, all by half.
fn values(kind: &MaterialKind, roughness: f32, mix: usize) -> Vec<[f32; 3]> {
    let mut fraction = 0;
    let mut value = |param: &pathmarch_scene::materials::MaterialParam| match (param.name(), param.kind) {
        ("absorb" | "scatter" | "scattering" | "anisotropy" | "glow", _) => [0.0; 3],
        ("priority" | "thin", _) => [0.0; 3],
        ("multiscatter", _) => [f32::from(mix == 1), 0.0, 0.0],
        (_, ParamKind::Colour) => [1.0; 3],
        ("roughness" | "coat-roughness", _) => [roughness, 0.0, 0.0],
        ("ior", _) => [[1.5, 1.33, 1.5, 2.4][mix], 0.0, 0.0],
        _ => {
            fraction += 1;
            let chosen = [0.0, f32::from(fraction == 1), f32::from(fraction == 3), 0.5][mix];
            [chosen, 0.0, 0.0]
        }
    };
    kind.params.iter().map(&mut value).collect()
}

/// Directions the light leaves to, from the normal to grazing.
fn views() -> [Vec3; 4] {
    [0.0f32, 35.0, 65.0, 84.0].map(|degrees| {
        let (sine, cosine) = degrees.to_radians().sin_cos();
        Vec3::new(sine * 0.8, sine * 0.6, cosine)
    })
}

const ROWS: usize = 24;
const COLUMNS: usize = 48;

fn cell(w: Vec3) -> usize {
    let height = w.x.hypot(w.y).atan2(w.z) / PI;
    let row = ((height * ROWS as f32) as usize).min(ROWS - 1);
    let turn = w.y.atan2(w.x) / TAU;
    let column = (((turn - turn.floor()) * COLUMNS as f32) as usize).min(COLUMNS - 1);
    row * COLUMNS + column
}

/// Integral of the density over each cell of the sphere.
fn expected(variant: &Variant, wo: Vec3, inside: bool) -> Vec<f64> {
    const FINE: usize = 24;
    let mut cells = vec![0.0f64; ROWS * COLUMNS];
    for (index, mass) in cells.iter_mut().enumerate() {
        let (row, column) = (index / COLUMNS, index % COLUMNS);
        if row >= ROWS / 2 && !variant.transmits {
            continue;
        }
        for k in 0..FINE * FINE {
            let at =
                |whole: usize, part: usize, of: usize| (whole as f32 + (part as f32 + 0.5) / FINE as f32) / of as f32;
            let (radius, z) = (PI * at(row, k / FINE, ROWS)).sin_cos();
            let (sine, cosine) = (TAU * at(column, k % FINE, COLUMNS)).sin_cos();
            let wi = Vec3::new(radius * cosine, radius * sine, z);
            *mass += f64::from(radius * (variant.bsdf.eval)(&variant.numbers, wo, wi, inside).pdf);
        }
        *mass *= 2.0 * f64::from(PI * PI) / (ROWS * COLUMNS * FINE * FINE) as f64;
    }
    cells
}

/// Standard deviations by which a chi-squared statistic lies above its mean (Wilson and Hilferty 1931).
fn deviations(statistic: f64, freedom: f64) -> f64 {
    let spread = 2.0 / (9.0 * freedom);
    ((statistic / freedom).cbrt() - (1.0 - spread)) / spread.sqrt()
}

mod slow {
    use super::*;

    #[test]
    fn samples_are_of_the_density_they_claim() {
        const SAMPLES: usize = 60_000;
        let mut tested = 0;
        for variant in variants(&[0.25, 0.5, 1.0]).iter().filter(|variant| !variant.delta) {
            for (view, wo) in views().into_iter().enumerate() {
                for inside in [false, true] {
                    if inside && !variant.transmits {
                        continue;
                    }
                    let expected = expected(variant, wo, inside);
                    let mut random = Random(17 + view as u64);
                    let mut counts = vec![0.0f64; ROWS * COLUMNS];
                    for _ in 0..SAMPLES {
                        if let Some(scattered) = (variant.bsdf.sample)(&variant.numbers, wo, inside, random.three()) {
                            counts[cell(scattered.wi)] += 1.0;
                        }
                    }
                    // Cells of few samples are pooled.
                    let (mut statistic, mut freedom) = (0.0, 0.0);
                    let (mut rest_expected, mut rest_counted) = (0.0, 0.0);
                    for (share, count) in expected.iter().zip(&counts) {
                        let expected = share * SAMPLES as f64;
                        if expected < 8.0 {
                            rest_expected += expected;
                            rest_counted += count;
                        } else {
                            // The quadrature is good to about a hundredth where a lobe is narrow.
                            let variance = expected + (0.01 * expected).powi(2);
                            statistic += (count - expected).powi(2) / variance;
                            freedom += 1.0;
                        }
                    }
                    if rest_expected > 8.0 {
                        statistic += (rest_counted - rest_expected).powi(2) / rest_expected;
                        freedom += 1.0;
                    }
                    let total: f64 = expected.iter().sum();
                    let lost = 1.0 - counts.iter().sum::<f64>() / SAMPLES as f64;
                    assert!(total < 1.02, "{}: density adds up to {total}", variant.name);
                    assert!((1.0 - total - lost).abs() < 0.015, "{}: {total} and {lost} lost", variant.name);
                    let deviations = deviations(statistic, freedom);
                    assert!(
                        deviations < 5.0,
                        "{}, view {view}, inside {inside}: chi-squared {statistic:.0} of {freedom} is {deviations:.1} deviations off",
                        variant.name
                    );
                    tested += 1;
                }
            }
        }
        println!("{tested} densities agree with their samples");
    }
}

#[test]
fn a_samples_weight_is_its_value_over_its_density() {
    for variant in variants(&[0.1, 0.4, 1.0]).iter().filter(|variant| !variant.delta) {
        for wo in views() {
            for inside in [false, true] {
                let mut random = Random(5);
                for _ in 0..2000 {
                    let u = random.three();
                    let Some(scattered) = (variant.bsdf.sample)(&variant.numbers, wo, inside, u) else { continue };
                    assert!((scattered.wi.length() - 1.0).abs() < 1e-4, "{}: {}", variant.name, scattered.wi);
                    assert_eq!(scattered.wi.z < 0.0, scattered.eta != 1.0, "{}", variant.name);
                    let eval = (variant.bsdf.eval)(&variant.numbers, wo, scattered.wi, inside);
                    // Close to the horizon rounding decides.
                    if scattered.wi.z.abs() < 0.02 || wo.z < 0.02 {
                        continue;
                    }
                    assert!((eval.pdf / scattered.pdf - 1.0).abs() < 0.02, "{}: {eval:?} {scattered:?}", variant.name);
                    let value = eval.value / eval.pdf;
                    assert!(
                        (value - scattered.weight).abs().max_element() < 0.02 * (1.0 + value.max_element()),
                        "{}: {value} {scattered:?}",
                        variant.name
                    );
                }
            }
        }
    }
}

/// Compares the functions of eight surfaces with those of one, for surfaces of different colours and roughnesses.
fn check_lanes<B: BsdfInLanes>(kind: &MaterialKind) -> u32 {
    let bsdf = kind.bsdf.expect("a BSDF");
    let mut random = Random(11);
    let surfaces: [BsdfParameters; 8] = std::array::from_fn(|lane| {
        let roughness = [0.0, 0.05, 0.1, 0.3, 0.5, 0.7, 0.9, 1.0][lane];
        let mut values = values(kind, roughness, lane % 4);
        for (value, param) in values.iter_mut().zip(kind.params) {
            if param.kind == ParamKind::Colour {
                *value = random.three();
            }
            if param.name() == "transmission" {
                *value = [0.0; 3];
            }
        }
        (bsdf.pack)(&values)
    });
    let parameters = ParametersInLanes::new(surfaces.each_ref(), B::PARAMETERS);
    let vectors = |of: [Vec3; 8]| {
        let [x, y, z] = [0, 1, 2].map(|axis| f32x8::from(of.map(|v| v[axis])));
        FieldVec3::new(x, y, z)
    };
    let of_lane = |v: FieldVec3<f32x8>, lane: usize| Vec3::from([v.x, v.y, v.z].map(|value| value.to_array()[lane]));
    let mut compared = 0;
    for k in 0..200 {
        let inside = k % 4 == 3;
        let directions = [0, 1].map(|_| [(); 8].map(|()| random.point(1.0).normalize()));
        let wo = directions[0].map(|w| w.with_z(w.z.abs().max(1e-3)).normalize());
        let u = [(); 8].map(|()| random.three());
        let bsdf_in_lanes = B::new(&parameters, vectors(wo), f32x8::truth(inside));
        let evaluated = bsdf_in_lanes.eval(&parameters, vectors(wo), vectors(directions[1]));
        let random_numbers = [0, 1, 2].map(|k| f32x8::from(u.map(|u| u[k])));
        let scattered = bsdf_in_lanes.sample(&parameters, vectors(wo), random_numbers);
        for lane in 0..8 {
            let near = |a: f32, b: f32| (a - b).abs() <= 2e-3 * (a.abs() + b.abs()) + 1e-5;
            let near = |a: (Vec3, f32), b: (Vec3, f32)| {
                (0..3).all(|k| near(a.0[k], b.0[k])) && near(a.1, b.1) && b.0.is_finite()
            };
            let one = (bsdf.eval)(&surfaces[lane], wo[lane], directions[1][lane], inside);
            let (one, eight) = ((one.value, one.pdf), (of_lane(evaluated.value, lane), evaluated.pdf.to_array()[lane]));
            assert!(near(one, eight), "{} {lane}: {one:?} {eight:?}", kind.name);
            let wi = of_lane(scattered.wi, lane);
            let Some(one) = (bsdf.sample)(&surfaces[lane], wo[lane], inside, u[lane]) else {
                assert!(wi.z < 1e-4, "{} {lane}: {wi}", kind.name);
                continue;
            };
            // Close to the horizon rounding decides.
            if one.wi.z < 1e-3 {
                continue;
            }
            let eight = (of_lane(scattered.weight, lane), scattered.pdf.to_array()[lane]);
            assert!(one.wi.distance(wi) < 1e-4, "{} {lane}: {} {wi}", kind.name, one.wi);
            assert!(near((one.weight, one.pdf), eight), "{} {lane}: {one:?} {eight:?}", kind.name);
            compared += 1;
        }
    }
    compared
}

#[test]
fn functions_in_lanes_are_those_of_one_surface() {
    let mut compared = Vec::new();
    for kind in kinds() {
        match kind.bsdf.and_then(|bsdf| bsdf.in_lanes) {
            Some(KindInLanes::Diffuse) => compared.push(check_lanes::<DiffuseInLanes>(kind)),
            Some(KindInLanes::Metal) => compared.push(check_lanes::<MetalInLanes>(kind)),
            Some(KindInLanes::Principled) => compared.push(check_lanes::<PrincipledInLanes>(kind)),
            None => {}
        }
    }
    assert!(compared.len() == 3 && compared.iter().all(|count| *count > 1000), "{compared:?}");
}

/// The share of light that comes back from a uniform surrounding of one.
fn furnace(variant: &Variant, wo: Vec3, inside: bool) -> f32 {
    let n = 128;
    let mut sum = 0.0f64;
    let mut random = Random(3);
    for k in 0..n * n {
        let u = [
            (k % n) as f32 / n as f32 + random.next() / n as f32,
            (k / n) as f32 / n as f32 + random.next() / n as f32,
            random.next(),
        ];
        if let Some(scattered) = (variant.bsdf.sample)(&variant.numbers, wo, inside, u) {
            assert!(scattered.weight.is_finite(), "{}", variant.name);
            // Radiance over the square of the index is what is kept.
            sum += f64::from(scattered.weight.y * scattered.eta * scattered.eta);
        }
    }
    (sum / f64::from(n * n)) as f32
}

#[test]
fn nothing_makes_light_and_white_loses_none_where_it_should_not() {
    for variant in variants(&[0.0, 0.1, 0.3, 0.6, 1.0]) {
        for wo in views() {
            for inside in [false, true] {
                if inside && !variant.transmits {
                    continue;
                }
                let share = furnace(&variant, wo, inside);
                assert!(share < 1.012, "{} at {}: {share}", variant.name, wo.z);
                let smooth = variant.name.contains("roughness 0 ") || variant.name.contains("roughness 0.1");
                let opaque = variant.name.starts_with("principled") && !variant.transmits;
                let keeps =
                    variant.name.starts_with("diffuse") || smooth && !opaque && !variant.name.starts_with("principled");
                if keeps || (variant.bsdf.compensates)(&variant.numbers) {
                    assert!(share > 0.985, "{} at {}: {share}", variant.name, wo.z);
                }
                // A coat of index 1.5 over metal keeps a little in.
                if opaque {
                    let least = if variant.name.ends_with("mix 3") { 0.8 } else { 0.98 };
                    assert!(share > least, "{} at {}: {share}", variant.name, wo.z);
                }
            }
        }
    }
}

#[test]
fn light_takes_the_same_way_back() {
    let names = ["diffuse", "metal", "glass"];
    let is_reciprocal =
        |v: &&Variant| names.iter().any(|name| v.name.starts_with(name)) && !(v.bsdf.compensates)(&v.numbers);
    for variant in variants(&[0.2, 0.5, 1.0]).iter().filter(is_reciprocal) {
        let mut random = Random(9);
        for _ in 0..2000 {
            let mut direction = || {
                let (z, turn) = (0.05 + 0.95 * random.next(), TAU * random.next());
                let radius = (1.0 - z * z).sqrt();
                Vec3::new(radius * turn.cos(), radius * turn.sin(), z)
            };
            let (a, b) = (direction(), direction());
            for inside in [false, true] {
                let there = (variant.bsdf.eval)(&variant.numbers, a, b, inside).value.x / b.z;
                let back = (variant.bsdf.eval)(&variant.numbers, b, a, inside).value.x / a.z;
                assert!((there - back).abs() <= 1e-3 * there.max(1.0), "{}: {there} {back}", variant.name);
                if !variant.transmits {
                    continue;
                }
                // Through the surface the radiance is scaled by the square of the index.
                let under = |w: Vec3| w.with_z(-w.z);
                let ior = variant.numbers[4];
                let eta = if inside { 1.0 / ior } else { ior };
                let there = (variant.bsdf.eval)(&variant.numbers, a, under(b), inside).value.x / b.z;
                let back = (variant.bsdf.eval)(&variant.numbers, b, under(a), !inside).value.x / a.z;
                assert!((there * eta * eta - back).abs() <= 2e-3 * back.max(1.0), "{}: {there} {back}", variant.name);
            }
        }
    }
}

/// Mirrors and clear glass against Fresnel's and Snell's laws, worked out by hand.
#[test]
fn smooth_surfaces_follow_the_laws() {
    let glass = kinds().iter().find(|kind| kind.name == "glass").and_then(|kind| kind.bsdf).expect("there is glass");
    let numbers = (glass.pack)(&std::array::from_fn::<_, 11, _>(|k| [[1.0; 3], [1.5, 0.0, 0.0], [0.0; 3]][k.min(2)]));
    // At right angles 4 % are reflected; at 60° 8.9 %: Hecht, Optics, 5th ed., section 4.6.
    for (degrees, reflected) in [(0.0f32, 0.04), (60.0, 0.08919)] {
        let (sine, cosine) = degrees.to_radians().sin_cos();
        let wo = Vec3::new(sine, 0.0, cosine);
        let at = |choice| (glass.sample)(&numbers, wo, false, [0.5, 0.5, choice]).expect("goes on");
        assert!(at(reflected - 1e-3).wi.abs_diff_eq(Vec3::new(-sine, 0.0, cosine), 1e-5));
        let refracted = at(reflected + 1e-3);
        assert!((refracted.wi.x + sine / 1.5).abs() < 1e-5 && refracted.wi.z < 0.0, "{refracted:?}");
        assert!((refracted.weight.x - 1.0 / 2.25).abs() < 1e-5);
    }
    // From within, beyond 41.8°, all is reflected.
    let (sine, cosine) = 42.0f32.to_radians().sin_cos();
    let wo = Vec3::new(sine, 0.0, cosine);
    assert!((glass.sample)(&numbers, wo, true, [0.5, 0.5, 0.999_999]).expect("goes on").wi.z > 0.0);
}

/// Thin glass reflects by both faces, and bends no light.
#[test]
fn sheets_follow_the_laws() {
    let glass = kinds().iter().find(|kind| kind.name == "glass").and_then(|kind| kind.bsdf).expect("there is glass");
    let mut values = [[0.0; 3]; 11];
    (values[0], values[1], values[10]) = ([1.0, 0.5, 0.25], [1.5, 0.0, 0.0], [1.0, 0.0, 0.0]);
    let numbers = (glass.pack)(&values);
    let wo = Vec3::new(0.6, 0.0, 0.8);
    let face = fresnel(0.8, 1.5);
    let reflected = 2.0 * face / (1.0 + face);
    for inside in [false, true] {
        let at = |choice| (glass.sample)(&numbers, wo, inside, [0.5, 0.5, choice]).expect("goes on");
        assert!(at(reflected - 1e-4).wi.abs_diff_eq(Vec3::new(-0.6, 0.0, 0.8), 1e-5));
        let transmitted = at(reflected + 1e-4);
        assert!(transmitted.wi == -wo && transmitted.eta == 1.0 && transmitted.weight == Vec3::new(1.0, 0.5, 0.25));
    }
    let straight = straight_transmittance(&numbers, 0.8);
    assert!((straight - Vec3::new(1.0, 0.5, 0.25) * (1.0 - reflected)).abs().max_element() < 1e-6, "{straight}");
}

#[test]
fn the_albedo_table_splits_what_a_surface_reflects() {
    for (index, [a, b]) in albedo::table().iter().enumerate() {
        assert!(*a >= 0.0 && *b >= 0.0 && a + b <= 1.0 + 1e-5, "{index}: {a} {b}");
    }
    // A mirror at right angles reflects all, at the edge of F90 alone.
    let mirror = albedo::table()[albedo::COSINES - 1];
    assert!(mirror[0] > 0.999 && mirror[1] < 1e-3, "{mirror:?}");
    assert!(albedo::table()[0][1] > 0.9);
}
