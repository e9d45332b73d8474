//! Noise of the samplers.
//!
//! Renders scenes with independent random numbers and with Sobol' points, and prints relMSE against a converged picture,
//! of the pixels and after a Gaussian blur of two pixels' deviation, a model of the eye. The gain is the ratio of the errors:
//! the factor of independent samples that are needed for the same error. `cargo bench -p pathmarch-render --bench sampling [-- SCENE...]`

use pathmarch_render::image::Picture;
use pathmarch_render::metrics::relmse;
use pathmarch_render::pathmarch_scene::{Sampler, Scene};
use pathmarch_render::{Backend, Renderer, Settings};
use std::path::{Path, PathBuf};

const SIZE: [u32; 2] = [160, 90];
const REFERENCE_SAMPLES: u32 = 4096;
const COUNTS: [u32; 7] = [1, 2, 3, 4, 8, 16, 64];
const SEEDS: u32 = 8;

/// Filters a picture by a Gaussian of two pixels' deviation; the picture is mirrored at its edges.
fn blurred(picture: &Picture) -> Picture {
    let (width, height) = (picture.width as i32, picture.height as i32);
    let weights: Vec<f32> = (-6..=6).map(|d| (-(d * d) as f32 / 8.0).exp()).collect();
    let total: f32 = weights.iter().sum();
    let mirror = |v: i32, size: i32| if v < 0 { -1 - v } else { v.min(2 * size - 1 - v) };
    let along = |of: &Picture, step: [i32; 2]| {
        let mut result = of.clone();
        for (p, pixel) in (0..).zip(&mut result.pixels) {
            *pixel = [0.0; 3];
            for (d, weight) in (-6..=6).zip(&weights) {
                let (x, y) = (mirror(p % width + d * step[0], width), mirror(p / width + d * step[1], height));
                for (sum, value) in pixel.iter_mut().zip(of.pixels[(y * width + x) as usize]) {
                    *sum += weight / total * value;
                }
            }
        }
        result
    };
    along(&along(picture, [1, 0]), [0, 1])
}

fn main() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut scenes: Vec<PathBuf> =
        std::env::args().skip(1).filter(|a| !a.starts_with('-')).map(PathBuf::from).collect();
    if scenes.is_empty() {
        scenes = ["../../scenes/thesis/diffuse-sphere.kdl", "../../scenes/thesis/open-room.kdl"]
            .map(|s| root.join(s))
            .into();
        scenes.push(root.join("tests/data/diffuse_sphere_plane_area.kdl"));
    }
    let renderer = Renderer::open(Backend::Cpu, None).expect("the CPU backend");
    println!("{:36}{:>8}{:>24}{:>24}", "", "", "relMSE of pixels", "relMSE of blurred");
    println!(
        "{:36}{:>8}{:>10}{:>8}{:>6}{:>10}{:>8}{:>6}",
        "scene", "samples", "indep.", "sobol", "gain", "indep.", "sobol", "gain"
    );
    for path in scenes {
        let scene = Scene::load(&path).expect("a valid scene");
        let render = |samples, seed, sampler| {
            let settings = Settings { size: SIZE, samples, seed, sampler, ..Settings::of(&scene) };
            renderer.render(&scene, &settings).expect("renders").mean()
        };
        let reference = render(REFERENCE_SAMPLES, 1_000_000, Sampler::Sobol);
        let smooth = blurred(&reference);
        for samples in COUNTS {
            let [independent, sobol] = [Sampler::Independent, Sampler::Sobol].map(|sampler| {
                let mut errors = [0.0; 2];
                for seed in 0..SEEDS {
                    let picture = render(samples, seed, sampler);
                    errors[0] += relmse(&picture, &reference).expect("equal sizes") / f64::from(SEEDS);
                    errors[1] += relmse(&blurred(&picture), &smooth).expect("equal sizes") / f64::from(SEEDS);
                }
                errors
            });
            print!("{:36}{samples:8}", path.file_stem().unwrap_or_default().to_string_lossy());
            for (a, b) in independent.into_iter().zip(sobol) {
                print!("{a:10.1e}{b:8.1e}{:6.1}", a / b);
            }
            println!();
        }
    }
}
