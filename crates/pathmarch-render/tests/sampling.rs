//! Samplers: the same picture in the mean, on every backend. `PATHMARCH_REQUIRE_GPU` as in `backends.rs`.

use pathmarch_render::metrics::relmse;
use pathmarch_render::pathmarch_scene::{Sampler, Scene};
use pathmarch_render::{Backend, Renderer, Settings};

#[test]
fn samplers_agree_with_each_other_and_on_both_backends() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/diffuse_sphere_plane_area.kdl");
    let scene = Scene::load(path).expect("a valid scene");
    let render = |renderer: &mut Renderer, sampler, samples, seed| {
        let settings = Settings { size: [96, 54], samples, seed, sampler, ..Settings::of(&scene) };
        renderer.render(&scene, &settings).expect("renders").mean()
    };
    let mut cpu = Renderer::open(Backend::Cpu, None).expect("the CPU is there");
    let reference = render(&mut cpu, Sampler::Sobol, 512, 1);
    let errors = Sampler::ALL.map(|sampler| {
        let picture = render(&mut cpu, sampler, 64, 0);
        let (a, b) = (picture.mean_colour()[1], reference.mean_colour()[1]);
        assert!((a / b - 1.0).abs() < 5e-3, "{}: {a} for {b}", sampler.name());
        relmse(&picture, &reference).expect("two of a size")
    });
    println!("relMSE of 64 samples: Sobol' {:.1e}, independent {:.1e}", errors[0], errors[1]);
    assert!(errors[0] < 0.6 * errors[1]);
    match Renderer::open(Backend::Gpu, None) {
        Ok(mut gpu) => {
            for sampler in Sampler::ALL {
                let [a, b] = [&mut cpu, &mut gpu].map(|renderer| render(renderer, sampler, 4, 0));
                let difference = relmse(&a, &b).expect("two of a size");
                println!("{} on both backends: relMSE {difference:.1e}", sampler.name());
                assert!(difference < 1e-4, "{}: {difference:.1e}", sampler.name());
            }
        }
        Err(error) if std::env::var_os("PATHMARCH_REQUIRE_GPU").is_some() => panic!("{error}"),
        Err(error) => println!("NOT TESTED on a GPU: {error}"),
    }
}

#[test]
fn samplers_have_names() {
    for sampler in Sampler::ALL {
        assert_eq!(Sampler::from_name(sampler.name()), Some(sampler));
    }
}
