//! The sky of a clear day, computed from the air.
//!
//! **Idea.** Sunlight is scattered by molecules (Rayleigh) and by haze (Mie) and absorbed by ozone. [`Day::bake`] follows
//! every direction from an observer on the ground through a spherical atmosphere, sums the light that is scattered once
//! into it, and adds what was scattered more often from a table. All of it is done for eight bands of wavelengths side by
//! side, which then become a colour. The picture is an [`Environment`] turned so that the sun, which it does not contain,
//! is at its place.
//!
//! **Source.** The atmosphere: Bruneton and Neyret 2008, with the haze that their program calls a clear sky; the ozone
//! layer as in Hillaire 2020, table 1.
//! Spectra of sun, air and ozone: Bruneton 2017, of sun and ozone after ASTM G-173 and Serdyuchenko et al. 2014; here
//! their means over each band. Table of transmittance: Bruneton and Neyret 2008, section 4. Multiple scattering: Hillaire
//! 2020, section 5.5. Phase of haze: Cornette and Shanks 1992. Colours: `observer.rs`.
//!
//! **Where we differ.** Eight bands, not the usual three wavelengths, because those make twilight purple: none of them is
//! where ozone absorbs most. The table of multiple scattering is denser near the horizon. A part of the sun's disc in the
//! planet's shadow is a smooth step over its diameter. The lower hemisphere is one colour: the diffuse ground, lit by sun
//! and sky. Colours outside Rec. 709 are clipped. Not simulated: refraction, clouds, polarisation, night.
//!
//! **Cost.** The way of light along a row of texels does not depend on the sun: its exponentials are computed once a row.
//! About 85 ms of one core for the 512 by 256 texels, on all cores side by side.

use crate::environment::{Environment, MAX_RADIANCE};
use crate::light::Light;
use crate::observer::{REC709_FROM_XYZ, xyz};
use glam::Vec3;
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};
use wide::f32x8;

/// A clear day; [`Day::default`] is a bright one.
#[derive(Clone, Debug, PartialEq)]
pub struct Day {
    /// Height of the sun's centre above the horizon, degrees, -20 to 90.
    pub elevation: f32,
    /// Direction of the sun, degrees clockwise from -z (north) as seen from above: 90 is +x.
    pub azimuth: f32,
    /// Factor of haze, 0 to 20: 0 is air alone, 1 a clear day (optical depth 0.027), 4 a usual one, 20 thick haze.
    pub haze: f32,
    /// Factor of all radiance, 0 or more.
    pub strength: f32,
    /// Fraction of light that the ground reflects, 0 to 1.
    pub ground: [f32; 3],
}

impl Day {
    /// A bright day with a clear sky.
    pub const DEFAULT: Self = Self { elevation: 40.0, azimuth: 135.0, haze: 1.0, strength: 1.0, ground: [0.2; 3] };
}

impl Default for Day {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// One number for each band: 390 to 710 nm in steps of 40 nm.
type Bands = f32x8;

/// Irradiance of the sun above the air, luminance, W/m²: a white surface at noon then has a radiance of about 1.
const SUN: f32 = 5.0;
/// Spectrum of the sun above the air, W/(m² nm); only the ratios matter.
const SUN_SPECTRUM: [f32; 8] = [1.574, 1.895, 1.958, 1.861, 1.833, 1.728, 1.582, 1.461];
/// Apparent diameter of the sun, degrees.
pub(crate) const SUN_ANGLE: f32 = 0.53;

/// Radius of the planet, kilometres. Lengths in this module are kilometres.
const GROUND: f64 = 6360.0;
/// Radius of the upper end of the air.
const TOP: f64 = 6460.0;
/// Height of the observer's eye.
const EYE: f64 = 0.002;

/// Scattering by molecules at the ground, per kilometre: 1.24062e-3 over the fourth power of the wavelength in micrometres.
const RAYLEIGH: Bands = Bands::new([4.447e-2, 3.059e-2, 2.173e-2, 1.586e-2, 1.184e-2, 9.022e-3, 6.994e-3, 5.505e-3]);
/// Height in which their density falls to 1/e.
const RAYLEIGH_HEIGHT: f64 = 8.0;
/// Scattering by haze at the ground, per kilometre, alike in all bands.
const MIE_SCATTERING: f32 = 2e-2;
/// Scattering and absorption by haze; a tenth is absorbed.
const MIE_EXTINCTION: f32 = MIE_SCATTERING / 0.9;
const MIE_HEIGHT: f64 = 1.2;
/// Asymmetry of haze: mostly forwards.
const MIE_ASYMMETRY: f64 = 0.76;
/// Absorption by ozone where it is densest, per kilometre: 300 Dobson units between 10 and 40 km.
const OZONE: Bands = Bands::new([1.407e-5, 1.130e-4, 4.903e-4, 1.288e-3, 2.262e-3, 2.387e-3, 1.339e-3, 5.871e-4]);

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
        let colours = band_colours();
        let albedo = albedo_of_bands(self.ground);
        let air = Air::new(self.haze, albedo);
        let (sine, cosine) = f64::from(self.elevation).to_radians().sin_cos();
        let half = HEIGHT / 2;
        let rows: Vec<Vec<Bands>> =
            (0..half).into_par_iter().map(|row| air.row(elevation(row as f64 + 0.5), sine, cosine)).collect();
        let sun = air.sunlight(GROUND + EYE, sine);
        let projected = |(row, bands): (usize, &Vec<Bands>)| {
            let (upper, lower) = (elevation(row as f64).sin(), elevation(row as f64 + 1.0).sin());
            // Mean radiance of the row, and its projected solid angle.
            sum(bands.iter().copied()) * (2.0 / WIDTH as f32) * (PI * (upper * upper - lower * lower)) as f32
        };
        let from_sky = sum(rows.iter().enumerate().map(projected));
        let ground = albedo * (sun * sine.max(0.0) as f32 + from_sky) * (1.0 / PI) as f32;
        let colour = |bands: Bands| -> [f32; 3] {
            let colour: Vec3 = bands.to_array().iter().zip(&colours).map(|(&band, colour)| *colour * band).sum();
            (colour * SUN * self.strength).clamp(Vec3::ZERO, Vec3::splat(MAX_RADIANCE)).into()
        };
        let upper = rows.iter().flat_map(|row| row.iter().chain(row.iter().rev())).map(|&bands| colour(bands));
        let lower = std::iter::repeat_n(colour(ground), WIDTH * half);
        let environment = Environment {
            width: WIDTH as u32,
            height: HEIGHT as u32,
            texels: upper.chain(lower).collect(),
            // The middle of the unturned picture is +z, an azimuth of 180 degrees.
            rotate: 180.0 - self.azimuth,
        };
        let irradiance = colour(sun);
        let light = Light::Sun { direction: self.direction(), irradiance, angle: SUN_ANGLE, penumbra: None };
        (environment, (irradiance != [0.0; 3]).then_some(light))
    }

    /// Towards the sun, of length one.
    pub fn direction(&self) -> [f32; 3] {
        let (elevation, azimuth) = (f64::from(self.elevation).to_radians(), f64::from(self.azimuth).to_radians());
        [azimuth.sin() * elevation.cos(), elevation.sin(), -azimuth.cos() * elevation.cos()].map(|v| v as f32)
    }
}

/// Angle above the horizon of a place in the rows of the picture, radians.
fn elevation(row: f64) -> f64 {
    PI * (0.5 - row / HEIGHT as f64)
}

/// Linear Rec. 709 colour of each band of the sun's light above the air; they add up to a luminance of 1.
fn band_colours() -> [Vec3; 8] {
    let band = |index: usize| {
        let mean: Vec3 = (0..40).map(|step| xyz(390.5 + (40 * index + step) as f32)).sum();
        mean * SUN_SPECTRUM[index]
    };
    let bands: [Vec3; 8] = std::array::from_fn(band);
    let luminance: f32 = bands.iter().map(|band| band.y).sum();
    bands.map(|band| REC709_FROM_XYZ * band / luminance)
}

/// Albedo of each band for a surface of this colour, with the red, green and blue parts of the spectrum each as a
/// whole.
fn albedo_of_bands([red, green, blue]: [f32; 3]) -> Bands {
    Bands::new([blue, blue, 0.5 * (blue + green), green, 0.5 * (green + red), red, red, red])
}

fn sum(bands: impl Iterator<Item = Bands>) -> Bands {
    bands.fold(Bands::ZERO, |sum, bands| sum + bands)
}

/// Bands over a unit square, bilinear between its nodes.
#[derive(Default)]
struct Table {
    rows: usize,
    columns: usize,
    nodes: Vec<Bands>,
}

impl Table {
    /// `node` of each place in the square, row by row, on all cores.
    fn new((rows, columns): (usize, usize), row: impl Fn(f64) -> Vec<Bands> + Sync) -> Self {
        let place = |index: usize| index as f64 / (rows - 1) as f64;
        let nodes = (0..rows).into_par_iter().flat_map_iter(|index| row(place(index))).collect();
        Self { rows, columns, nodes }
    }
    fn at(&self, row: f64, column: f64) -> Bands {
        let split = |place: f64, count: usize| {
            let place = place.clamp(0.0, 1.0) * (count - 1) as f64;
            let index = (place as usize).min(count - 2);
            (index, (place - index as f64) as f32)
        };
        let ((row, down), (column, right)) = (split(row, self.rows), split(column, self.columns));
        let first = row * self.columns + column;
        let mix = |a: Bands, b: Bands, t: f32| a + (b - a) * t;
        let across = |first: usize| mix(self.nodes[first], self.nodes[first + 1], right);
        mix(across(first), across(first + self.columns), down)
    }
}

/// A piece of a path through the air.
struct Piece {
    /// From the start of the path to its middle.
    distance: f64,
    /// Distance of its middle from the planet's centre.
    radius: f64,
    /// Fraction of the light at it that molecules scatter and that reaches the start of the path.
    rayleigh: Bands,
    /// The same of haze.
    mie: Bands,
}

struct Air {
    haze: f32,
    /// Transmittance to space.
    clear: Table,
    /// Radiance scattered more than once, from every direction alike.
    multiple: Table,
}

impl Air {
    fn new(haze: f32, albedo: Bands) -> Self {
        let mut air = Self { haze, clear: Table::default(), multiple: Table::default() };
        air.clear = air.transmittances();
        air.multiple = air.multiple_scattering(albedo);
        air
    }

    /// Scattering by molecules, scattering by haze, and extinction, per kilometre.
    fn coefficients(&self, radius: f64) -> (Bands, f32, Bands) {
        let height = (radius - GROUND).max(0.0);
        let rayleigh = RAYLEIGH * (-height / RAYLEIGH_HEIGHT).exp() as f32;
        let haze = self.haze * (-height / MIE_HEIGHT).exp() as f32;
        let ozone = OZONE * (1.0 - (height - 25.0).abs() / 15.0).max(0.0) as f32;
        (rayleigh, MIE_SCATTERING * haze, rayleigh + ozone + MIE_EXTINCTION * haze)
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
                let middle = |piece: usize| along(radius, cosine, step * (piece as f64 + 0.5));
                let depth = sum((0..PIECES).map(|piece| self.coefficients(middle(piece)).2)) * step as f32;
                (-depth).exp()
            };
            (0..CLEAR.1).map(column).collect()
        })
    }

    /// Transmittance towards the sun; 0 in the planet's shadow. `cosine` is that of its angle from the zenith.
    fn sunlight(&self, radius: f64, cosine: f64) -> Bands {
        let sine = GROUND / radius;
        let horizon = -(1.0 - sine * sine).max(0.0).sqrt();
        let half_angle = f64::from(SUN_ANGLE).to_radians() / 2.0;
        let visible = ((cosine - horizon) / (sine * half_angle) * 0.5 + 0.5).clamp(0.0, 1.0);
        if visible == 0.0 {
            return Bands::ZERO;
        }
        let rho = (radius * radius - GROUND * GROUND).max(0.0).sqrt();
        let longest = (TOP * TOP - GROUND * GROUND).sqrt();
        let distance = to_top(radius, cosine);
        let column = (distance - (TOP - radius)) / (rho + longest - (TOP - radius));
        self.clear.at(rho / longest, column) * (visible * visible * (3.0 - 2.0 * visible)) as f32
    }

    /// The path from `radius` in the direction of this cosine, in pieces that `spacing` maps from 0..1 to 0..1.
    /// Also the transmittance of the whole.
    fn path(
        &self,
        radius: f64,
        cosine: f64,
        length: f64,
        count: usize,
        spacing: fn(f64) -> f64,
    ) -> (Vec<Piece>, Bands) {
        let mut clear = Bands::ONE;
        let piece = |index: usize| {
            let ends = [index, index + 1].map(|end| length * spacing(end as f64 / count as f64));
            let (distance, step) = (0.5 * (ends[0] + ends[1]), ends[1] - ends[0]);
            let radius = along(radius, cosine, distance);
            let (rayleigh, mie, extinction) = self.coefficients(radius);
            let depth = extinction * step as f32;
            let through = (-depth).exp();
            // The integral of a constant source over the piece, seen through the piece itself; of a clear piece, the
            // start of its series.
            let thin = depth.simd_lt(Bands::splat(1e-2));
            let share = thin.select(Bands::ONE - depth * 0.5, (Bands::ONE - through) / depth);
            let seen = clear * share * step as f32;
            clear *= through;
            Piece { distance, radius, rayleigh: rayleigh * seen, mie: mie * seen }
        };
        let pieces = (0..count).map(piece).collect();
        (pieces, clear)
    }

    /// Radiance scattered at least twice, for a sun of irradiance 1. Hillaire 2020, equations 5 to 10.
    fn multiple_scattering(&self, albedo: Bands) -> Table {
        const HEIGHTS: usize = 8;
        const TURNS: usize = 4;
        /// Density of a direction of which nothing is known.
        const ISOTROPIC: f32 = (1.0 / (4.0 * PI)) as f32;
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
            let again = sum(paths.iter().flat_map(|(_, pieces, _)| pieces).map(|piece| piece.rayleigh + piece.mie));
            let again = again * (1.0 / HEIGHTS as f32);
            let column = |index: usize| {
                let sun = from_place(index as f64 / (MULTIPLE.1 - 1) as f64);
                let mut light = Bands::ZERO;
                for (cosine, pieces, ground) in &paths {
                    for turn in 0..TURNS {
                        let turn = ((turn as f64 + 0.5) / TURNS as f64 * PI).cos();
                        let between = cosine * sun + turn * ((1.0 - cosine * cosine) * (1.0 - sun * sun)).sqrt();
                        for piece in pieces {
                            let sun = (radius * sun + piece.distance * between) / piece.radius;
                            light += (piece.rayleigh + piece.mie) * self.sunlight(piece.radius, sun) * ISOTROPIC;
                        }
                        if let Some((distance, clear)) = ground {
                            let sun = (radius * sun + distance * between) / GROUND;
                            let facing = 4.0 * ISOTROPIC * sun.max(0.0) as f32;
                            light += albedo * *clear * self.sunlight(GROUND, sun) * facing;
                        }
                    }
                }
                light * (1.0 / (HEIGHTS * TURNS) as f32) / (Bands::ONE - again)
            };
            (0..MULTIPLE.1).map(column).collect()
        })
    }

    /// Radiance of the left half of a row of texels, from opposite the sun to the sun; the sun of irradiance 1 is at an
    /// elevation with this sine and cosine.
    fn row(&self, elevation: f64, sun_sine: f64, sun_cosine: f64) -> Vec<Bands> {
        let start = GROUND + EYE;
        let cosine = elevation.sin();
        // Short pieces near the observer, where the air is densest.
        let (pieces, _) = self.path(start, cosine, to_top(start, cosine), 64, |t| t * t);
        let column = |column: usize| {
            let turn = (PI - TAU * (column as f64 + 0.5) / WIDTH as f64).cos();
            let between = cosine * sun_sine + turn * elevation.cos() * sun_cosine;
            let (rayleigh, mie) = (rayleigh_phase(between) as f32, mie_phase(between) as f32);
            let scattered = |piece: &Piece| {
                let sun = (start * sun_sine + piece.distance * between) / piece.radius;
                let height = ((piece.radius - GROUND) / (TOP - GROUND)).max(0.0).sqrt();
                let once = (piece.rayleigh * rayleigh + piece.mie * mie) * self.sunlight(piece.radius, sun);
                once + (piece.rayleigh + piece.mie) * self.multiple.at(height, to_place(sun))
            };
            sum(pieces.iter().map(scattered))
        };
        (0..WIDTH / 2).map(column).collect()
    }
}

/// Distance from the planet's centre after a distance `way` from `radius` in the direction of this cosine.
fn along(radius: f64, cosine: f64, way: f64) -> f64 {
    (radius * radius + way * way + 2.0 * radius * way * cosine).max(0.0).sqrt()
}

/// Distance to the top of the atmosphere.
fn to_top(radius: f64, cosine: f64) -> f64 {
    (radius * radius * (cosine * cosine - 1.0) + TOP * TOP).max(0.0).sqrt() - radius * cosine
}

/// Distance to the ground, if the ray hits it.
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
