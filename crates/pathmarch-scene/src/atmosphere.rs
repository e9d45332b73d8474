//! The sky of a clear day, computed from the air.
//!
//! **Idea.** Sunlight is scattered by molecules (Rayleigh) and by haze (Mie) and absorbed by ozone. [`Day::bake`] follows
//! every direction from an observer on the ground through a spherical atmosphere, sums the light that is scattered once
//! into it, and adds what was scattered more often from a table. Red, green and blue are three wavelengths (680, 550 and
//! 440 nm), each with its own coefficients. The picture is an [`Environment`] turned so that the sun, which it does not
//! contain, is at its place.
//!
//! **Source.** The atmosphere: Bruneton and Neyret 2008, coefficients and profiles as in Hillaire 2020, table 1 (with Mie
//! extinction 4.44e-6 per metre, of which a tenth is absorbed). Table of transmittance: Bruneton and Neyret 2008, section
//! 4. Multiple scattering: Hillaire 2020, section 5.5. Phase of haze: Cornette and Shanks 1992.
//!
//! **Where we differ.** The table of multiple scattering is denser near the horizon (the square root of the sun's height),
//! for twilight. The height of the sun's disc in the planet's shadow is a smooth step over its diameter. The lower
//! hemisphere is one diffuse colour: the ground lit by sun and sky. Not simulated: refraction, clouds, polarisation, night.
//!
//! **Cost.** The optical path of a row of texels does not depend on the sun: its exponentials are computed once a row.
//! About 35 ms on two cores for the 512 by 256 texels.

use crate::environment::Environment;
use crate::scene::Light;
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// A clear day; [`Day::default`] is a bright one.
#[derive(Clone, Debug, PartialEq)]
pub struct Day {
    /// Height of the sun's centre above the horizon, degrees, -20 to 90.
    pub elevation: f32,
    /// Direction of the sun, degrees clockwise from -z (north) as seen from above: 90 is +x.
    pub azimuth: f32,
    /// Factor of haze, 0 to 20; 1 is very clear air.
    pub haze: f32,
    /// Factor of all radiance, 0 or more.
    pub strength: f32,
    /// Fraction of light that the ground reflects, 0 to 1.
    pub ground: [f32; 3],
}

impl Default for Day {
    fn default() -> Self {
        Self { elevation: 40.0, azimuth: 135.0, haze: 1.0, strength: 1.0, ground: [0.2; 3] }
    }
}

/// Irradiance of the sun above the air, W/m²: luminance 5, so that a white surface at noon has a radiance of about 1, in the
/// colour of a black body of 5772 K (the sun's effective temperature), linear Rec. 709.
const SUN: DVec3 = DVec3::new(5.56, 4.88, 4.56);
/// Apparent diameter of the sun, degrees.
pub(crate) const SUN_ANGLE: f32 = 0.53;

/// Radius of the planet, kilometres. Lengths in this module are kilometres.
const GROUND: f64 = 6360.0;
/// Radius of the upper end of the air.
const TOP: f64 = 6460.0;
/// Height of the observer's eye.
const EYE: f64 = 0.002;

const RAYLEIGH: DVec3 = DVec3::new(5.802e-3, 13.558e-3, 33.1e-3);
const RAYLEIGH_HEIGHT: f64 = 8.0;
const MIE_SCATTERING: f64 = 3.996e-3;
const MIE_EXTINCTION: f64 = 4.44e-3;
const MIE_HEIGHT: f64 = 1.2;
/// Asymmetry of haze: mostly forwards.
const MIE_ASYMMETRY: f64 = 0.8;
const OZONE: DVec3 = DVec3::new(0.650e-3, 1.881e-3, 0.085e-3);

/// Texels of the picture; the even numbers put the horizon and the sun between texels, so that the sun is in the middle
/// of a symmetric picture.
const WIDTH: usize = 512;
const HEIGHT: usize = 256;

/// Size of the table of transmittance: heights, directions.
const CLEAR: (usize, usize) = (48, 128);
/// Size of the table of multiple scattering: heights, heights of the sun.
const MULTIPLE: (usize, usize) = (24, 64);

impl Day {
    /// The sky as a picture of 512 by 256 texels, without the sun's disc; and the sun as it is seen through the air, `None`
    /// where it has set.
    pub fn bake(&self) -> (Environment, Option<Light>) {
        let air = Air { haze: f64::from(self.haze), clear: Table::default(), multiple: Table::default() };
        let air = Air { clear: air.transmittances(), ..air };
        let albedo = Vec3::from(self.ground).as_dvec3();
        let air = Air { multiple: air.multiple_scattering(albedo), ..air };
        let (sine, cosine) = f64::from(self.elevation).to_radians().sin_cos();
        let scale = SUN * f64::from(self.strength);
        let half = HEIGHT / 2;
        let rows: Vec<Vec<DVec3>> =
            (0..half).into_par_iter().map(|row| air.row(elevation(row as f64 + 0.5), sine, cosine)).collect();
        let sun = air.sunlight(GROUND + EYE, sine) * scale;
        let from_sky: DVec3 = rows
            .iter()
            .enumerate()
            .map(|(row, colours)| {
                let (upper, lower) = (elevation(row as f64).sin(), elevation(row as f64 + 1.0).sin());
                let mean = 2.0 * colours.iter().sum::<DVec3>() / WIDTH as f64;
                // Projected solid angle of the row, and its mean radiance.
                mean * scale * PI * (upper * upper - lower * lower)
            })
            .sum();
        let ground = albedo / PI * (sun * sine.max(0.0) + from_sky);
        let texel = |colour: DVec3| colour.min(DVec3::splat(1e12)).as_vec3().to_array();
        let upper = rows.iter().flat_map(|row| row.iter().chain(row.iter().rev()).map(|colour| texel(*colour * scale)));
        let lower = std::iter::repeat_n(texel(ground), WIDTH * half);
        let environment = Environment {
            width: WIDTH as u32,
            height: HEIGHT as u32,
            texels: upper.chain(lower).collect(),
            // The middle of the unturned picture is +z, an azimuth of 180 degrees.
            rotate: 180.0 - self.azimuth,
        };
        let light = Light::Sun {
            direction: self.direction(),
            irradiance: texel(sun),
            angle: SUN_ANGLE,
            penumbra: None,
        };
        (environment, (sun.max_element() > 0.0).then_some(light))
    }

    /// Towards the sun, of length one.
    pub fn direction(&self) -> [f32; 3] {
        let (elevation, azimuth) = (f64::from(self.elevation).to_radians(), f64::from(self.azimuth).to_radians());
        let direction = DVec3::new(azimuth.sin() * elevation.cos(), elevation.sin(), -azimuth.cos() * elevation.cos());
        direction.as_vec3().to_array()
    }
}

/// Angle above the horizon of a place in the rows of the picture, radians.
fn elevation(row: f64) -> f64 {
    PI * (0.5 - row / HEIGHT as f64)
}

/// Colours over a unit square, bilinear between its nodes.
#[derive(Default)]
struct Table {
    rows: usize,
    columns: usize,
    nodes: Vec<DVec3>,
}

impl Table {
    /// `node` of each place in the square, row by row, on all cores.
    fn new((rows, columns): (usize, usize), row: impl Fn(f64) -> Vec<DVec3> + Sync) -> Self {
        let place = |index: usize| index as f64 / (rows - 1) as f64;
        let nodes = (0..rows).into_par_iter().flat_map_iter(|index| row(place(index))).collect();
        Self { rows, columns, nodes }
    }
    fn at(&self, row: f64, column: f64) -> DVec3 {
        let split = |place: f64, count: usize| {
            let place = place.clamp(0.0, 1.0) * (count - 1) as f64;
            let index = (place as usize).min(count - 2);
            (index, place - index as f64)
        };
        let ((row, down), (column, right)) = (split(row, self.rows), split(column, self.columns));
        let first = row * self.columns + column;
        let across = |first: usize| self.nodes[first].lerp(self.nodes[first + 1], right);
        across(first).lerp(across(first + self.columns), down)
    }
}

/// A piece of a path through the air.
struct Piece {
    /// From the start of the path to its middle.
    distance: f64,
    /// Distance of its middle from the planet's centre.
    radius: f64,
    /// Fraction of the light at it that molecules scatter and that reaches the start of the path.
    rayleigh: DVec3,
    /// The same of haze.
    mie: DVec3,
}

struct Air {
    haze: f64,
    /// Transmittance to space.
    clear: Table,
    /// Radiance scattered more than once, from every direction alike.
    multiple: Table,
}

impl Air {
    /// Scattering by molecules, scattering by haze, and extinction, per kilometre.
    fn coefficients(&self, radius: f64) -> (DVec3, f64, DVec3) {
        let height = (radius - GROUND).max(0.0);
        let rayleigh = RAYLEIGH * (-height / RAYLEIGH_HEIGHT).exp();
        let haze = self.haze * (-height / MIE_HEIGHT).exp();
        let ozone = OZONE * (1.0 - (height - 25.0).abs() / 15.0).max(0.0);
        (rayleigh, MIE_SCATTERING * haze, rayleigh + MIE_EXTINCTION * haze + ozone)
    }

    fn transmittances(&self) -> Table {
        let horizon = (TOP * TOP - GROUND * GROUND).sqrt();
        Table::new(CLEAR, |row| {
            let rho = horizon * row;
            let radius = rho.hypot(GROUND);
            let (shortest, longest) = (TOP - radius, rho + horizon);
            let column = |index: usize| {
                let distance = shortest + (longest - shortest) * index as f64 / (CLEAR.1 - 1) as f64;
                let cosine = (horizon * horizon - rho * rho - distance * distance) / (2.0 * radius * distance);
                let cosine = if distance > 0.0 { cosine.clamp(-1.0, 1.0) } else { 1.0 };
                const PIECES: usize = 64;
                let step = distance / PIECES as f64;
                let depth: DVec3 = (0..PIECES)
                    .map(|piece| self.coefficients(along(radius, cosine, step * (piece as f64 + 0.5))).2 * step)
                    .sum();
                (-depth).exp()
            };
            (0..CLEAR.1).map(column).collect()
        })
    }

    /// What is left of the sun's light; 0 in the planet's shadow. `cosine` is that of its angle from the zenith.
    fn sunlight(&self, radius: f64, cosine: f64) -> DVec3 {
        let sine = GROUND / radius;
        let horizon = -(1.0 - sine * sine).max(0.0).sqrt();
        let half_angle = f64::from(SUN_ANGLE).to_radians() / 2.0;
        let visible = ((cosine - horizon) / (sine * half_angle) * 0.5 + 0.5).clamp(0.0, 1.0);
        if visible == 0.0 {
            return DVec3::ZERO;
        }
        let rho = (radius * radius - GROUND * GROUND).max(0.0).sqrt();
        let longest = (TOP * TOP - GROUND * GROUND).sqrt();
        let distance = to_top(radius, cosine);
        let column = (distance - (TOP - radius)) / (rho + longest - (TOP - radius));
        visible * visible * (3.0 - 2.0 * visible) * self.clear.at(rho / longest, column)
    }

    /// The path from `radius` in the direction of this cosine, in pieces that `spacing` maps from 0..1 to 0..1.
    /// Also the transmittance of the whole.
    fn path(&self, radius: f64, cosine: f64, length: f64, count: usize, spacing: fn(f64) -> f64) -> (Vec<Piece>, DVec3) {
        let mut clear = DVec3::ONE;
        let piece = |index: usize| {
            let ends = [index, index + 1].map(|end| length * spacing(end as f64 / count as f64));
            let (distance, step) = (0.5 * (ends[0] + ends[1]), ends[1] - ends[0]);
            let radius = along(radius, cosine, distance);
            let (rayleigh, mie, extinction) = self.coefficients(radius);
            let through = (-extinction * step).exp();
            // The integral of a constant source over the piece, seen through the piece itself.
            let seen = clear * (DVec3::ONE - through) / extinction.max(DVec3::splat(1e-12));
            clear *= through;
            Piece { distance, radius, rayleigh: rayleigh * seen, mie: mie * seen }
        };
        let pieces = (0..count).map(piece).collect();
        (pieces, clear)
    }

    /// Radiance scattered at least twice, for a sun of irradiance 1. Hillaire 2020, equations 5 to 10.
    fn multiple_scattering(&self, albedo: DVec3) -> Table {
        const HEIGHTS: usize = 8;
        const TURNS: usize = 4;
        Table::new(MULTIPLE, |row| {
            let radius = (GROUND + (TOP - GROUND) * row * row).clamp(GROUND + EYE, TOP - EYE);
            // Directions of equal solid angle; only a half of them, because the other is its mirror image.
            let paths: Vec<_> = (0..HEIGHTS)
                .map(|index| {
                    let cosine = (2 * index + 1) as f64 / HEIGHTS as f64 - 1.0;
                    let ground = to_ground(radius, cosine);
                    let length = ground.unwrap_or_else(|| to_top(radius, cosine));
                    let (pieces, clear) = self.path(radius, cosine, length, 20, |t| t);
                    (cosine, pieces, ground.map(|distance| (distance, clear)))
                })
                .collect();
            let again = paths.iter().flat_map(|(_, pieces, _)| pieces).map(|piece| piece.rayleigh + piece.mie);
            let again = again.sum::<DVec3>() / HEIGHTS as f64;
            let column = |index: usize| {
                let sun = from_place(index as f64 / (MULTIPLE.1 - 1) as f64);
                let mut light = DVec3::ZERO;
                for (cosine, pieces, ground) in &paths {
                    for turn in 0..TURNS {
                        let turn = ((turn as f64 + 0.5) / TURNS as f64 * PI).cos();
                        let between = cosine * sun + turn * ((1.0 - cosine * cosine) * (1.0 - sun * sun)).sqrt();
                        for piece in pieces {
                            let sun = (radius * sun + piece.distance * between) / piece.radius;
                            light += (piece.rayleigh + piece.mie) * self.sunlight(piece.radius, sun) / (4.0 * PI);
                        }
                        if let Some((distance, clear)) = ground {
                            let sun = (radius * sun + distance * between) / GROUND;
                            light += albedo / PI * clear * self.sunlight(GROUND, sun) * sun.max(0.0);
                        }
                    }
                }
                light / (HEIGHTS * TURNS) as f64 / (DVec3::ONE - again)
            };
            (0..MULTIPLE.1).map(column).collect()
        })
    }

    /// Radiance of the left half of a row of texels, from opposite the sun to the sun; the sun of irradiance 1 is at an
    /// elevation with this sine and cosine.
    fn row(&self, elevation: f64, sun_sine: f64, sun_cosine: f64) -> Vec<DVec3> {
        let start = GROUND + EYE;
        let cosine = elevation.sin();
        // Short pieces near the observer, where the air is densest.
        let (pieces, _) = self.path(start, cosine, to_top(start, cosine), 64, |t| t * t);
        let column = |column: usize| {
            let turn = (PI - TAU * (column as f64 + 0.5) / WIDTH as f64).cos();
            let between = cosine * sun_sine + turn * elevation.cos() * sun_cosine;
            let (rayleigh, mie) = (rayleigh_phase(between), mie_phase(between));
            let scattered = |piece: &Piece| {
                let sun = (start * sun_sine + piece.distance * between) / piece.radius;
                let height = ((piece.radius - GROUND) / (TOP - GROUND)).max(0.0).sqrt();
                let once = (piece.rayleigh * rayleigh + piece.mie * mie) * self.sunlight(piece.radius, sun);
                once + (piece.rayleigh + piece.mie) * self.multiple.at(height, to_place(sun))
            };
            pieces.iter().map(scattered).sum()
        };
        (0..WIDTH / 2).map(column).collect()
    }
}

/// Distance from the planet's centre after some way from `radius` in the direction of this cosine.
fn along(radius: f64, cosine: f64, way: f64) -> f64 {
    (radius * radius + way * way + 2.0 * radius * way * cosine).max(0.0).sqrt()
}

/// Way to the upper end of the air.
fn to_top(radius: f64, cosine: f64) -> f64 {
    (radius * radius * (cosine * cosine - 1.0) + TOP * TOP).max(0.0).sqrt() - radius * cosine
}

/// Way to the ground, if it is met.
fn to_ground(radius: f64, cosine: f64) -> Option<f64> {
    let square = radius * radius * (cosine * cosine - 1.0) + GROUND * GROUND;
    (cosine < 0.0 && square >= 0.0).then(|| -radius * cosine - square.sqrt())
}

/// Place in the table of a sun of this cosine from the zenith: denser near the horizon.
fn to_place(cosine: f64) -> f64 {
    0.5 + 0.5 * cosine.abs().sqrt().copysign(cosine)
}

/// The inverse of [`to_place`].
fn from_place(place: f64) -> f64 {
    let signed = 2.0 * place - 1.0;
    signed * signed.abs()
}

/// Density over solid angle of scattering by molecules, of the cosine between old and new direction.
fn rayleigh_phase(cosine: f64) -> f64 {
    3.0 / (16.0 * PI) * (1.0 + cosine * cosine)
}

/// The same of haze (Cornette and Shanks 1992).
fn mie_phase(cosine: f64) -> f64 {
    const G: f64 = MIE_ASYMMETRY;
    let shape = (1.0 - G * G) * (1.0 + cosine * cosine) / ((2.0 + G * G) * (1.0 + G * G - 2.0 * G * cosine).powf(1.5));
    3.0 / (8.0 * PI) * shape
}
