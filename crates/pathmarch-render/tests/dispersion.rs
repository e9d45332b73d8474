//! Dispersion against pictures of single wavelengths, and against a furnace.

use crate::common::{mean, on_each_backend, parse, render};
use pathmarch_render::image::Picture;
use pathmarch_render::metrics::{block_means, mean_colour};
use pathmarch_render::pathmarch_scene::Scene;
use pathmarch_render::pathmarch_scene::materials::dispersion;
use pathmarch_render::{Renderer, Settings};
use pathmarch_testing::tests;

/// Refractive index at the line d, and Abbe number.
const GLASS: [f32; 2] = [1.6, 3.0];

/// A prism and a frosted ball before stripes of light.
fn prism(ior: f32, abbe: f32) -> Scene {
    parse(&format!(
        "pathmarch 1\ncamera {{ position 0 0.6 4; target 0 0.6 0; fov 40 }}\nrender {{ bounces 6 }}\nsky 0.1\n\
         material \"glass\" {{ glass 1; ior {ior}; abbe {abbe} }}\n\
         material \"frosted\" {{ glass 1; ior {ior}; abbe {abbe}; roughness 0.3 }}\n\
         material \"lamp\" {{ emit 4 }}\nmaterial \"grey\" {{ diffuse 0.5 }}\n\
         object \"prism\" material=\"glass\" {{ prism 1.4 1.6 {{ at -0.5 0.5 0 }} }}\n\
         object \"ball\" material=\"frosted\" {{ sphere 0.45 {{ at 0.9 0.5 0 }} }}\n\
         object \"stripe\" material=\"lamp\" {{ rect 6 0.5 {{ normal 0 0 1; at 0 0.2 -3 }} }}\n\
         object \"higher stripe\" material=\"lamp\" {{ rect 6 0.4 {{ normal 0 0 1; at 0 1.8 -3 }} }}\n\
         object \"ground\" material=\"grey\" {{ plane {{ at 0 -0.2 0 }} }}\n"
    ))
}

fn picture(renderer: &Renderer, scene: &Scene, samples: u32, seed: u32) -> Picture {
    let settings = Settings { size: [64, 48], samples, seed, ..Settings::of(scene) };
    render(renderer, scene, &settings).mean()
}

/// Sum of pictures of single wavelengths, each in its colour.
fn spectrum(renderer: &Renderer, wavelengths: u32, samples: u32) -> Picture {
    let mut sum = Picture::new(64, 48);
    for k in 0..wavelengths {
        let wavelength = dispersion::wavelength((k as f32 + 0.5) / wavelengths as f32);
        let [ior, abbe] = GLASS;
        let ior = ior + (ior - 1.0) / abbe * dispersion::index_offset(wavelength);
        let weight = (dispersion::colour(wavelength) / wavelengths as f32).to_array();
        let single = picture(renderer, &prism(ior, 0.0), samples, 100 + k);
        for (sum, pixel) in sum.pixels.iter_mut().zip(&single.pixels) {
            *sum = std::array::from_fn(|k| sum[k] + weight[k] * pixel[k]);
        }
    }
    sum
}

/// Saturation of the most colourful block.
fn colourfulness(blocks: &Picture) -> f32 {
    let range = |[r, g, b]: [f32; 3]| r.max(g).max(b) - r.min(g).min(b);
    blocks.pixels.iter().map(|&pixel| range(pixel)).fold(0.0, f32::max)
}

fn a_spectrum_is_the_sum_of_its_wavelengths(renderer: &Renderer) {
    const BLOCK: u32 = 8;
    // Surfaces that do not disperse have all wavelengths: their parts of the two pictures differ by noise only where the
    // colours' sum is not exactly white, far below the tolerance.
    let reference = block_means(&spectrum(renderer, 48, 16), BLOCK);
    let dispersed = block_means(&picture(renderer, &prism(GLASS[0], GLASS[1]), 768, 1), BLOCK);
    let clear = block_means(&picture(renderer, &prism(GLASS[0], 0.0), 768, 1), BLOCK);
    let difference = |other: &Picture| {
        let squares =
            other.pixels.iter().zip(&reference.pixels).flat_map(|(a, b)| (0..3).map(|k| (a[k] - b[k]).powi(2)));
        (squares.sum::<f32>() / (3 * reference.pixels.len()) as f32).sqrt()
    };
    let [with, without] = [difference(&dispersed), difference(&clear)];
    let [colour, grey] = [colourfulness(&dispersed), colourfulness(&clear)];
    println!("deviation {with:.4}, without dispersion {without:.4}; colour {colour:.3}, {grey:.3}");
    assert!(with < 0.01 && without > 3.0 * with, "deviation {with}, without dispersion {without}");
    assert!(colour > 0.1 && grey < 0.01, "colour {colour}, without dispersion {grey}");
}

fn dispersing_glass_is_invisible_in_a_furnace(renderer: &Renderer) {
    let scene = parse(
        "pathmarch 1\ncamera { position 0 0 3; target 0 0 0; fov 40 }\nrender { bounces 60 }\nsky 1\n\
         material \"glass\" { glass 1; ior 1.6; abbe 15 }\nobject \"ball\" material=\"glass\" { sphere 1 }\n",
    );
    let settings = Settings { size: [32, 32], samples: 256, ..Settings::of(&scene) };
    let picture = render(renderer, &scene, &settings).mean();
    let colour = mean_colour(&picture);
    println!("{colour:?}, green {}", mean(&picture, |_, _| true));
    assert!(colour.iter().all(|channel| (channel - 1.0).abs() < 0.01), "{colour:?}");
}

tests! {
    on_each_backend: [
        a_spectrum_is_the_sum_of_its_wavelengths,
        dispersing_glass_is_invisible_in_a_furnace,
    ],
}
