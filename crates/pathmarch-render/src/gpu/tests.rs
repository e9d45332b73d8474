//! What makes pictures faster leaves them as they are: with it and without, on both backends.

use super::{Device, GpuJob, Printed, WHOLE};
use crate::cpu::CpuJob;
use crate::film::Film;
use crate::frame::Prepared;
use crate::metrics::relmse;
use crate::settings::Settings;
use pathmarch_field::Field;
use pathmarch_scene::Scene;
use std::sync::Arc;

/// The preferred adapter, if there is one; says so where not, and fails where there must be one.
fn device() -> Option<Device> {
    match Device::open(None) {
        Ok(device) => Some(device),
        Err(error) if std::env::var_os("PATHMARCH_REQUIRE_GPU").is_some() => panic!("{error}"),
        Err(error) => {
            eprintln!("NOT TESTED on a GPU: {error}");
            None
        }
    }
}

fn on_gpu(device: Arc<Device>, prepared: &Prepared, samples: u32) -> Film {
    let printed = Printed::new(prepared, &device);
    let mut job = GpuJob::of_printed(device, prepared, &printed, 0, WHOLE).expect("starts");
    while job.samples_done() < f64::from(samples) {
        job.advance(samples).expect("goes on");
    }
    job.film().expect("is read")
}

fn on_cpu(prepared: &Prepared, samples: u32) -> Film {
    let mut job = CpuJob::new(prepared.clone(), 0);
    (0..samples).for_each(|_| job.advance(samples));
    job.film().clone()
}

fn scene(text: &str) -> Scene {
    Scene::parse("test.kdl", text).expect("valid")
}

#[test]
fn pictures_do_not_depend_on_the_kind_of_memory() {
    let Some(mut device) = device() else { return };
    let scene = scene(
        r#"pathmarch 1
camera "main" { position 0 1 4; target 0 0.5 0; fov 40 }
sky 0.2 0.3 0.4
point { at 1 3 2; intensity 20 }
material "red" { diffuse 0.8 0.1 0.1 }
material "glass" { glass 1; ior 1.5 }
material "lamp" { emit 4 }
object "floor" material="red" { plane }
object "ball" material="glass" { torus 0.4 0.15 { at 0 0.3 0 } }
object "lamp" material="lamp" { sphere 0.2 { at 0.6 1 -0.5 } }
"#,
    );
    let prepared = Prepared::new(&scene, &Settings { size: [24, 16], ..Settings::of(&scene) });
    let [a, b] = ["software", "discrete GPU"].map(|kind| {
        device.description.kind = kind;
        let device = Arc::new(std::mem::replace(&mut device, Device::open(None).expect("opens again")));
        assert_eq!(Printed::new(&prepared, &device).memory.is_uniform(super::memory::FRAME), !device.is_software());
        assert_eq!(Printed::new(&prepared, &device).memory.is_uniform(super::memory::LEAVES), device.is_software());
        on_gpu(device, &prepared, 2).sums
    });
    assert!(a.iter().flatten().sum::<f32>() > 0.0);
    let difference = a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| (a - b).abs());
    assert!(difference.fold(0.0, f32::max) < 1e-3);
}

/// Wires of half a millimetre, a thin shell and a needle between large shapes: what long steps would miss.
const THIN: &str = r#"pathmarch 1
camera "main" { position 0.4 1.3 4; target 0 0.55 0; fov 36 }
sky 0.7 0.8 1
sun { direction 1 2 1.5; irradiance 2.5; angle 3 }
material "grey" { diffuse 0.6 }
material "red" { diffuse 0.8 0.2 0.1 }
object "floor" material="grey" { plane }
object "wires" material="red" {
    union smooth=0.002 {
        capsule 0.004 1.4 { at -0.9 0.8 0.3 }
        capsule 0.004 1.4 { at -0.7 0.8 0.3; rotate 0 0 8 }
        capsule 0.004 1.4 { at -0.5 0.8 0.3; rotate 12 0 -8 }
    }
}
object "shell" material="grey" { subtract smooth=0.004 { sphere 0.5 { at 0.9 0.6 -0.2 }; sphere 0.494 { at 0.9 0.6 -0.2 }; box 1 0.5 1 { at 0.9 1.05 0 } } }
object "cut" material="grey" { subtract { box 0.5 0.5 0.5; sphere 0.3; cylinder 0.12 2 { rotate 90 0 0 }; at 0.1 0.25 0.6 } }
object "needle" material="red" { cone 0.01 1.2 { at -0.15 0.6 0.7 } }
"#;

#[test]
fn pictures_do_not_depend_on_long_steps_and_closed_forms() {
    let scene = scene(THIN);
    let roots: Vec<_> = scene.objects.iter().map(|object| object.root.clone()).collect();
    let marched = Scene { field: Field::all_marched(&roots), ..scene.clone() };
    assert!(
        marched
            .field
            .direct_hit::<f32>(
                pathmarch_field::number::Vec3::new(0.0, 1.0, 0.0),
                pathmarch_field::number::Vec3::new(0.0, -1.0, 0.0)
            )
            .1
            < 0.0
    );
    const SAMPLES: u32 = 256;
    let settings = Settings { size: [80, 45], samples: SAMPLES, bounces: 2, detail: 0.005, ..Settings::of(&scene) };
    let mut plain = Prepared::new(&marched, &settings);
    plain.features.relaxation = 0.0;
    let reference = on_cpu(&plain, SAMPLES).mean();
    let relaxed = Prepared::new(&marched, &settings);
    let whole = Prepared::new(&scene, &settings);
    let device = device().map(Arc::new);
    for (name, prepared) in [("long steps", &relaxed), ("long steps and closed forms", &whole)] {
        let mut films = vec![("CPU", on_cpu(prepared, SAMPLES))];
        films.extend(device.as_ref().map(|device| ("GPU", on_gpu(device.clone(), prepared, SAMPLES))));
        for (backend, film) in films {
            let error = relmse(&film.mean(), &reference).expect("of one size");
            println!("{name} on {backend}: relMSE {error:.1e}");
            assert!(error < 5e-4, "{name} on {backend}: {error:.1e}");
        }
    }
}
