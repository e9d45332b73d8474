//! Samplers converge to the same picture, on every backend.

use crate::common::{cpu, data, on_both_backends};
use pathmarch_render::image::Picture;
use pathmarch_render::metrics::relmse;
use pathmarch_render::pathmarch_scene::{Sampler, Scene};
use pathmarch_render::{Renderer, Settings};
use pathmarch_testing::{plain, tests};

/// Picture of a scene with a lamp.
fn picture(renderer: &Renderer, sampler: Sampler, samples: u32, seed: u32) -> Picture {
    let scene = Scene::load(data("diffuse_sphere_plane_area.kdl")).expect("a valid scene");
    let settings = Settings { size: [96, 54], samples, seed, sampler, ..Settings::of(&scene) };
    renderer.render(&scene, &settings).expect("renders").mean()
}

fn samplers_agree_with_each_other() {
    let cpu = cpu();
    let reference = picture(&cpu, Sampler::Sobol, 512, 1);
    let errors = Sampler::ALL.map(|sampler| {
        let picture = picture(&cpu, sampler, 64, 0);
        let (a, b) = (picture.mean_colour()[1], reference.mean_colour()[1]);
        assert!((a / b - 1.0).abs() < 5e-3, "{}: {a} for {b}", sampler.name());
        relmse(&picture, &reference).expect("equal sizes")
    });
    println!("relMSE of 64 samples: Sobol' {:.1e}, independent {:.1e}", errors[0], errors[1]);
    assert!(errors[0] < 0.6 * errors[1]);
}

fn samplers_agree_on_both_backends(renderers: &mut [Renderer; 2]) {
    for sampler in Sampler::ALL {
        let [a, b] = [0, 1].map(|k| picture(&renderers[k], sampler, 4, 0));
        let difference = relmse(&a, &b).expect("equal sizes");
        println!("{} on both backends: relMSE {difference:.1e}", sampler.name());
        assert!(difference < 1e-4, "{}: {difference:.1e}", sampler.name());
    }
}

fn samplers_have_names() {
    for sampler in Sampler::ALL {
        assert_eq!(Sampler::from_name(sampler.name()), Some(sampler));
    }
}

tests! {
    plain: [samplers_agree_with_each_other, samplers_have_names],
    on_both_backends: [samplers_agree_on_both_backends],
}
