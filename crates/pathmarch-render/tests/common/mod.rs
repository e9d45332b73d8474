//! Helpers of the rendering tests.
//!
//! GPU tests need an adapter (Mesa's software Vulkan is enough). Without one they are reported as ignored; they fail if
//! `PATHMARCH_REQUIRE_GPU` is set, as in CI.

pub mod random_scenes;

use pathmarch_render::film::Film;
use pathmarch_render::image::Picture;
use pathmarch_render::metrics::block_means;
use pathmarch_render::pathmarch_scene::Scene;
use pathmarch_render::{Backend, Renderer, Settings};
use pathmarch_testing::{Requirement, Test};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};

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

/// CPU backend, which is always available.
pub fn cpu() -> Renderer {
    Renderer::open(Backend::Cpu, None).expect("the CPU backend")
}

/// Opened GPU backends that no test uses at present; opening one is slow.
static IDLE: Mutex<Vec<Renderer>> = Mutex::new(Vec::new());

fn idle() -> MutexGuard<'static, Vec<Renderer>> {
    IDLE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Requirement of a GPU adapter that can be opened.
pub static GPU: Requirement = Requirement {
    variable: "PATHMARCH_REQUIRE_GPU",
    missing: || {
        static MISSING: OnceLock<Option<String>> = OnceLock::new();
        let open = || Renderer::open(Backend::Gpu, None).map(|renderer| idle().push(renderer));
        MISSING.get_or_init(|| open().err().map(|error| error.to_string())).clone()
    },
};

/// Lends the GPU backend to a test. A failed test does not return it.
fn lend_gpu(test: impl FnOnce(Renderer) -> Renderer) {
    let open = idle().pop();
    let renderer = test(open.unwrap_or_else(|| Renderer::open(Backend::Gpu, None).expect("a GPU adapter")));
    idle().push(renderer);
}

/// Lends the CPU and the GPU backend to a test, in this order.
fn lend_both(test: impl FnOnce(&mut [Renderer; 2])) {
    lend_gpu(|gpu| {
        let mut renderers = [cpu(), gpu];
        test(&mut renderers);
        let [_, gpu] = renderers;
        gpu
    });
}

/// Registers a test of one backend twice: on the CPU and on the GPU.
pub fn on_each_backend(name: &str, test: fn(&Renderer)) -> [Test; 2] {
    let on_gpu = move || {
        lend_gpu(|gpu| {
            test(&gpu);
            gpu
        });
    };
    [Test::new(&format!("{name}::cpu"), move || test(&cpu())), Test::requiring(&format!("{name}::gpu"), &GPU, on_gpu)]
}

/// Registers a test that opens its own backend twice: for the CPU and for the GPU.
pub fn for_each_backend(name: &str, test: fn(Backend)) -> [Test; 2] {
    [
        Test::new(&format!("{name}::cpu"), move || test(Backend::Cpu)),
        Test::requiring(&format!("{name}::gpu"), &GPU, move || test(Backend::Gpu)),
    ]
}

/// Registers a test that compares the CPU's and the GPU's backend, in this order.
pub fn on_both_backends(name: &str, test: fn(&mut [Renderer; 2])) -> [Test; 1] {
    [Test::requiring(name, &GPU, move || lend_both(test))]
}

/// Registers a test of any number of backends twice: with the CPU's alone, and with both, the CPU's first.
pub fn on_one_and_both_backends(name: &str, test: fn(&mut [Renderer])) -> [Test; 2] {
    [
        Test::new(&format!("{name}::cpu"), move || test(&mut [cpu()])),
        Test::requiring(&format!("{name}::both"), &GPU, move || lend_both(|renderers| test(renderers))),
    ]
}

/// Registers a test that opens a GPU itself.
pub fn with_gpu(name: &str, test: fn()) -> [Test; 1] {
    [Test::requiring(name, &GPU, test)]
}

pub fn render(renderer: &Renderer, scene: &Scene, settings: &Settings) -> Film {
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

/// Largest relative difference of a channel's mean over a block of pixels; darker blocks count as 0.01.
pub fn worst_block(picture: &Picture, reference: &Picture, side: u32) -> f32 {
    let (a, b) = (block_means(picture, side), block_means(reference, side));
    let pairs = a.pixels.iter().zip(&b.pixels);
    pairs.flat_map(|(a, b)| (0..3).map(|k| (a[k] - b[k]).abs() / b[k].max(0.01))).fold(0.0, f32::max)
}
