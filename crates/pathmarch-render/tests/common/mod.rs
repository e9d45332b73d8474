//! What the tests of rendering share.
//!
//! GPU tests need an adapter (Mesa's software Vulkan will do). Without one they say so and pass, unless
//! `PATHMARCH_REQUIRE_GPU` is set, as in CI: then they fail.
#![allow(dead_code)]

pub mod random_scenes;

use pathmarch_render::film::Film;
use pathmarch_render::image::Picture;
use pathmarch_render::metrics::block_means;
use pathmarch_render::pathmarch_scene::Scene;
use pathmarch_render::{Backend, Renderer, Settings};
use std::path::{Path, PathBuf};

pub fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

pub fn scenes() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let mut found = Vec::new();
    for directory in [root.clone(), root.join("thesis"), root.join("fractals"), root.join("benchmarks")] {
        for file in std::fs::read_dir(&directory).expect("the scenes are there") {
            let path = file.expect("a file").path();
            if path.extension().is_some_and(|extension| extension == "kdl") {
                found.push(path);
            }
        }
    }
    found
}

/// Every backend to test.
pub fn renderers() -> Vec<Renderer> {
    let mut renderers = vec![Renderer::open(Backend::Cpu, None).expect("the CPU is there")];
    match Renderer::open(Backend::Gpu, None) {
        Ok(renderer) => renderers.push(renderer),
        Err(error) if std::env::var_os("PATHMARCH_REQUIRE_GPU").is_some() => panic!("{error}"),
        Err(error) => println!("NOT TESTED on a GPU: {error}"),
    }
    renderers
}

pub fn render(renderer: &mut Renderer, scene: &Scene, settings: &Settings) -> Film {
    let film = renderer.render(scene, settings).expect("renders");
    assert_eq!(film.non_finite(), 0, "every sample is finite");
    film
}

pub fn parse(text: &str) -> Scene {
    Scene::parse("test.kdl", text).expect("a valid scene")
}

pub fn mean(picture: &Picture, inside: impl Fn(u32, u32) -> bool) -> f64 {
    let (mut sum, mut count) = (0.0, 0);
    for y in 0..picture.height {
        for x in 0..picture.width {
            if inside(x, y) {
                sum += f64::from(picture.pixels[(y * picture.width + x) as usize][1]);
                count += 1;
            }
        }
    }
    sum / f64::from(count)
}

/// The largest relative difference of a channel's mean over a block of pixels; blocks darker than 0.01 count as that dark.
pub fn worst_block(picture: &Picture, reference: &Picture, side: u32) -> f32 {
    let (a, b) = (block_means(picture, side), block_means(reference, side));
    let pairs = a.pixels.iter().zip(&b.pixels);
    pairs.flat_map(|(a, b)| (0..3).map(|k| (a[k] - b[k]).abs() / b[k].max(0.01))).fold(0.0, f32::max)
}
