//! Writes the sky of a day at several heights of the sun, to be looked at: `day [FOLDER] [HAZE]` makes one PNG for each
//! height in the folder, equirectangular, exposed for its own brightness, and prints what was measured.

use pathmarch_scene::{Day, Light};
use std::time::Instant;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::path::PathBuf::from(std::env::args().nth(1).unwrap_or_else(|| ".".to_owned()));
    let haze = std::env::args().nth(2).map_or(Ok(1.0), |haze| haze.parse())?;
    for elevation in [60.0, 20.0, 5.0, 0.0, -5.0, -10.0] {
        let start = Instant::now();
        let (sky, sun) = Day { elevation, haze, azimuth: 180.0, ..Day::default() }.bake();
        let elapsed = start.elapsed();
        let luminance = |[r, g, b]: [f32; 3]| 0.2126 * r + 0.7152 * g + 0.0722 * b;
        let upper = &sky.texels[..sky.texels.len() / 2];
        let mean = upper.iter().map(|&texel| luminance(texel)).sum::<f32>() / upper.len() as f32;
        let exposure = 0.3 / mean.max(1e-9);
        let encode = |v: f32| {
            let v = 1.0 - (-v * exposure).exp();
            (255.0 * if v <= 0.0031308 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 }).round() as u8
        };
        let codes: Vec<u8> = sky.texels.as_flattened().iter().map(|&v| encode(v)).collect();
        let path = folder.join(format!("day_{elevation}.png"));
        image::save_buffer(&path, &codes, sky.width, sky.height, image::ColorType::Rgb8)?;
        let irradiance = sun.map_or([0.0; 3], |sun| match sun {
            Light::Sun { irradiance, .. } => irradiance,
            _ => [0.0; 3],
        });
        println!(
            "{}: sun {irradiance:.4?} W/m2, zenith {:.4?}, below the sun {:.4?}, ground {:.4?} W/(m2 sr), {:.1} ms",
            path.display(),
            sky.radiance([0.0, 1.0, 0.0]),
            sky.radiance([0.0, 0.02, 1.0]),
            sky.radiance([0.0, -1.0, 0.0]),
            elapsed.as_secs_f64() * 1e3
        );
    }
    Ok(())
}
