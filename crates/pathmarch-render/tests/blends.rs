//! Energy of blended materials that emit or transmit: it equals that of the materials in the blend.

use crate::common::{on_each_backend, parse, render};
use pathmarch_render::{Renderer, Settings};
use pathmarch_testing::tests;

fn mean(scene: &str, renderer: &Renderer, samples: u32) -> f64 {
    let scene = parse(scene);
    let settings = Settings { size: [128, 72], samples, ..Settings::of(&scene) };
    let picture = render(renderer, &scene, &settings).mean();
    picture.pixels.iter().map(|pixel| f64::from(pixel[1])).sum::<f64>() / picture.pixels.len() as f64
}

/// Two coincident balls blend in equal parts, and the blend is a ball that is larger by a quarter of `smooth`. It lights the
/// floor as much as an analytic one: sphere tracing that ended before the surface made it 0.6 % too bright.
fn a_blended_lamp_lights_its_surroundings_like_a_plain_one(renderer: &Renderer) {
    let scene = |ball: &str| {
        format!(
            "pathmarch 1\ncamera {{ position 0 1.5 5; target 0 0.7 0; fov 40 }}\nrender {{ bounces 4 }}\nsky 0.1\n\
             material \"lamp\" {{ emit 2 }}\nmaterial \"double\" {{ emit 4 }}\nmaterial \"black\" {{ diffuse 0 }}\n\
             material \"floor\" {{ diffuse 0.5 }}\nobject \"floor\" material=\"floor\" {{ plane }}\n\
             object \"ball\" {{ {ball} }}"
        )
    };
    for smooth in [0.1, 0.01] {
        let radius = 0.6 + 0.25 * smooth;
        let plain = scene(&format!("sphere {radius} material=\"lamp\" {{ at 0 0.8 0 }}"));
        let plain = mean(&plain, renderer, 256);
        for (first, second) in [("lamp", "lamp"), ("double", "black"), ("black", "double")] {
            let solids = [first, second].map(|name| format!("sphere 0.6 material=\"{name}\" {{ at 0 0.8 0 }}; "));
            let blend = scene(&format!("union smooth={smooth} {{ {} }}", solids.concat()));
            let excess = 100.0 * (mean(&blend, renderer, 256) / plain - 1.0);
            println!("{}: {first} with {second}, smooth {smooth}: {excess:+.3} %", renderer.backend().name);
            assert!(excess.abs() < 0.25, "{first} with {second}, smooth {smooth}: {excess:+.3} %");
        }
    }
}

/// In surroundings of radiance 1, every blend of materials that emit 1, reflect all or transmit all has radiance 1, too. The
/// balls coincide, so that total internal reflection traps no light in them.
fn every_blend_vanishes_in_a_furnace(renderer: &Renderer) {
    let materials =
        [("lamp", "emit 1"), ("white", "diffuse 1"), ("glass", "glass 1; ior 1.5"), ("mirror", "metal 1; roughness 0")];
    let all = materials.map(|(name, kind)| format!("material \"{name}\" {{ {kind} }}\n")).concat();
    for (k, (first, _)) in materials.iter().enumerate() {
        for (second, _) in &materials[..=k] {
            let scene = format!(
                "pathmarch 1\ncamera {{ position 0 0 3; target 0 0 0; fov 50 }}\nrender {{ bounces 64 }}\nsky 1\n{all}\
                 object \"ball\" {{ union smooth=0.2 {{ sphere 0.8 material=\"{first}\"; sphere 0.8 material=\"{second}\" }} }}"
            );
            let mean = mean(&scene, renderer, 16);
            println!("{}: {first} with {second}: {mean:.5}", renderer.backend().name);
            assert!((mean - 1.0).abs() < 0.002, "{first} with {second}: {mean}");
        }
    }
}

tests! {
    on_each_backend slow: [a_blended_lamp_lights_its_surroundings_like_a_plain_one, every_blend_vanishes_in_a_furnace],
}
