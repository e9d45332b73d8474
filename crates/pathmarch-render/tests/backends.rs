//! Light in closed form, agreement of both backends, and the choice between them.

use crate::common::{
    data, mean, on_both_backends, on_each_backend, on_one_and_both_backends, parse, render, scenes, with_gpu,
};
use pathmarch_render::image::PictureKind;
use pathmarch_render::metrics::compare;
use pathmarch_render::pathmarch_field::graph::Leaf;
use pathmarch_render::pathmarch_field::registry::shapes;
use pathmarch_render::pathmarch_field::{Field, ShapeRef};
use pathmarch_render::pathmarch_scene::Scene;
use pathmarch_render::{Backend, Renderer, Settings, testing};
use pathmarch_testing::{plain, some_of, tests};

fn a_white_furnace_shows_the_albedo(renderer: &Renderer) {
    let scene = Scene::load(data("furnace_050.kdl")).expect("a valid scene");
    let settings = Settings { size: [64, 64], samples: 64, ..Settings::of(&scene) };
    let picture = render(renderer, &scene, &settings).mean();
    // The ball covers a disc of 23 pixels radius.
    let ball = mean(&picture, |x, y| (x as f32 - 31.5).hypot(y as f32 - 31.5) < 20.0);
    println!("{}: {ball}", renderer.backend().name);
    assert!((ball - 0.5).abs() < 0.0025, "{ball}");
}

/// In a furnace, rough metal and rough glass vanish with compensation, and are darker without.
fn compensated_surfaces_vanish_in_a_furnace(renderer: &Renderer) {
    for (material, roughness) in
        [("metal 1", 0.5), ("metal 1", 1.0), ("glass 1; ior 1.5", 0.5), ("glass 1; ior 1.8", 0.9)]
    {
        let [single, multiple] = [0, 1].map(|share| {
            let scene = parse(&format!(
                "pathmarch 1\ncamera {{ position 0 0 5; target 0 0 0; fov 30 }}\nrender {{ bounces 40 }}\nsky 1\n\
                 material \"rough\" {{ {material}; roughness {roughness}; multiscatter {share} }}\n\
                 object \"ball\" material=\"rough\" {{ sphere 1 }}"
            ));
            let settings = Settings { size: [32, 32], samples: 256, ..Settings::of(&scene) };
            let picture = render(renderer, &scene, &settings).mean();
            mean(&picture, |x, y| (x as f32 - 15.5).hypot(y as f32 - 15.5) < 10.0)
        });
        println!("{material}, roughness {roughness}: {single} and {multiple}");
        assert!(single < 0.98 && (multiple - 1.0).abs() < 0.012, "{material}: {single} {multiple}");
    }
}

fn a_point_light_falls_off_by_the_square_and_the_cosine(renderer: &Renderer) {
    // A floor of albedo 0.5 seen from above through a narrow lens; the light at height 2.
    for (offset, [x, y, z]) in [(0.0, [0.0, 2.0, 0.0]), (3.0, [3.0, 2.0, 0.0]), (1.0, [0.0, 4.0, 1.0])] {
        let scene = parse(&format!(
            "pathmarch 1\ncamera {{ position 0 5 0; target 0 0 0; up 0 0 -1; fov 0.1 }}\n\
             point {{ at {x} {y} {z}; intensity 10 }}\nmaterial \"m\" {{ diffuse 0.5 }}\n\
             object \"floor\" material=\"m\" {{ plane }}"
        ));
        let height: f64 = y;
        let square = offset * offset + height * height;
        let expected = 0.5 / std::f64::consts::PI * 10.0 * height / square.sqrt() / square;
        let settings = Settings { size: [8, 8], samples: 4, bounces: 0, ..Settings::of(&scene) };
        let shown = mean(&render(renderer, &scene, &settings).mean(), |_, _| true);
        println!("{}: {shown} for {expected}", renderer.backend().name);
        assert!((shown / expected - 1.0).abs() < 1e-3, "{shown} for {expected}");
    }
}

fn the_sun_has_its_irradiance_at_every_angle(renderer: &Renderer) {
    for angle in [0.0, 0.53, 20.0] {
        let scene = parse(&format!(
            "pathmarch 1\ncamera {{ position 0 5 0; target 0 0 0; up 0 0 -1; fov 0.1 }}\n\
             sun {{ direction 1 1 0; irradiance 3; angle {angle} }}\nmaterial \"m\" {{ diffuse 0.5 }}\n\
             object \"floor\" material=\"m\" {{ plane }}"
        ));
        let expected = 0.5 / std::f64::consts::PI * 3.0 * std::f64::consts::FRAC_1_SQRT_2;
        let settings = Settings { size: [8, 8], samples: 64, bounces: 0, ..Settings::of(&scene) };
        let shown = mean(&render(renderer, &scene, &settings).mean(), |_, _| true);
        assert!((shown / expected - 1.0).abs() < 2e-3, "{angle}°: {shown} for {expected}");
    }
}

fn a_sheet_emits_on_the_side_it_faces_only(renderer: &Renderer) {
    let scene = |facing: &str| {
        parse(&format!(
            "pathmarch 1\ncamera {{ position 0 0 5; target 0 0 0; fov 10 }}\nmaterial \"lamp\" {{ emit 2 }}\n\
             object \"lamp\" material=\"lamp\" {{ rect 10 10 {{ normal 0 0 {facing} }} }}"
        ))
    };
    for (facing, expected) in [("1", 2.0), ("-1", 0.0)] {
        let scene = scene(facing);
        let settings = Settings { size: [8, 8], samples: 1, ..Settings::of(&scene) };
        assert_eq!(mean(&render(renderer, &scene, &settings).mean(), |_, _| true), expected);
    }
}

fn samples_that_are_not_finite_are_excluded_from_the_mean(renderer: &Renderer) {
    // A lamp too bright for a film, before a part of the sky.
    let scene = parse(
        "pathmarch 1\ncamera { position 0 0 5; target 0 0 0; fov 40 }\nsky 0.5\nmaterial \"lamp\" { emit 1e35 }\n\
         object \"lamp\" material=\"lamp\" { disc 1 { normal 0 0 1 } }",
    );
    let settings = Settings { size: [24, 24], samples: 16, ..Settings::of(&scene) };
    let film = renderer.render(&scene, &settings).expect("renders");
    let counts = film.sample_counts();
    assert_eq!(film.non_finite(), counts.iter().map(|count| u64::from(16 - count)).sum::<u64>());
    for edge in [counts.contains(&0), counts.contains(&16), counts.iter().any(|count| (1..16).contains(count))] {
        assert!(edge, "{counts:?}");
    }
    for (pixel, count) in film.mean().pixels.iter().zip(counts) {
        assert_eq!(*pixel, if count == 0 { [0.0; 3] } else { [0.5; 3] });
    }
}

fn ranges_of_samples_add_up_to_the_whole_and_seeds_differ(renderer: &Renderer) {
    let scene = Scene::load(data("diffuse_sphere_plane.kdl")).expect("a valid scene");
    let settings = Settings { size: [64, 36], samples: 24, ..Settings::of(&scene) };
    let whole = render(renderer, &scene, &settings);
    assert_eq!(whole, render(renderer, &scene, &settings), "the same again, to the bit");
    let mut parts = render(renderer, &scene, &Settings { samples: 9, ..settings.clone() });
    let rest = Settings { first_sample: 9, samples: 15, ..settings.clone() };
    parts.add(&render(renderer, &scene, &rest)).expect("equal sizes");
    assert_eq!(parts.samples, 24);
    for (a, b) in parts.sums.iter().flatten().zip(whole.sums.iter().flatten()) {
        assert!((a - b).abs() <= 1e-5 * b.abs(), "{a} for {b}");
    }
    assert_ne!(whole.sums, render(renderer, &scene, &Settings { seed: 1, ..settings }).sums);
}

fn every_scene_renders_alike_on_both_backends(renderers: &mut [Renderer; 2]) {
    let mut failures = Vec::new();
    for path in some_of(scenes(), 2) {
        let scene = Scene::load(&path).expect("a valid scene");
        let settings = Settings { size: [96, 54], samples: 4, ..Settings::of(&scene) };
        let [cpu, gpu] = [0, 1].map(|k| render(&renderers[k], &scene, &settings).mean());
        let differing = cpu
            .pixels
            .iter()
            .zip(&gpu.pixels)
            .filter(|(a, b)| (0..3).any(|k| (a[k] - b[k]).abs() > 0.01 * b[k].abs().max(0.01)))
            .count();
        let share = differing as f64 / cpu.pixels.len() as f64;
        let (a, b) = (cpu.mean_colour()[1], gpu.mean_colour()[1]);
        println!("{}: {:.2} % of pixels differ by over 1 %, means {a:.5} {b:.5}", path.display(), share * 100.0);
        // Gradients of custom fields are differences, whose rounding turns normals by 0.0002, and a fractal multiplies rounding
        // errors by the scale of all its iterations. Some paths then continue differently.
        let is_rough = |leaf: &Leaf| matches!(leaf.shape, ShapeRef::Custom(_)) || leaf.shape.has_orbit();
        let limit = if scene.field.leaves().iter().any(is_rough) { 0.1 } else { 0.02 };
        failures.extend((share >= limit).then(|| format!("{}: {share}", path.display())));
        failures.extend(((a / b - 1.0).abs() >= 2e-3).then(|| format!("{}: means {a} {b}", path.display())));
        assert!(a > 0.01, "the picture is not black");
    }
    assert!(failures.is_empty(), "{failures:#?}");
}

fn sphere_traced_shapes_look_like_analytic_ones(renderer: &Renderer) {
    // A blend of a sphere with a small one inside is sphere-traced; the picture is that of the plain sphere.
    let text = |ball: &str| {
        format!(
            "pathmarch 1\ncamera {{ position 0 3 6; target 0 0.8 0; fov 35 }}\nsky 0.3 0.375 0.5\n\
             point {{ at 4 6 4; intensity 120 }}\nobject \"floor\" {{ plane }}\nobject \"ball\" {{ {ball} }}"
        )
    };
    let analytic = parse(&text("sphere 1 { at 0 1 0 }"));
    let sphere_traced = parse(&text("union smooth=1e-6 { sphere 1 { at 0 1 0 }; sphere 0.001 { at 0 1 0 } }"));
    let settings = Settings { size: [160, 90], samples: 256, ..Settings::of(&analytic) };
    let [a, b] = [&analytic, &sphere_traced].map(|scene| render(renderer, scene, &settings).mean());
    let result = compare(&b, &a, PictureKind::Hdr).expect("equal sizes");
    println!("{}: relMSE {:.2e}, FLIP {:.4}", renderer.backend().name, result.relmse, result.flip);
    assert!(result.relmse < 1e-3);
}

/// Every registered shape, rotated and scaled, once by itself and once in a blend, which is sphere-traced.
fn every_shape_renders_alike_on_both_backends_and_in_closed_form(renderers: &mut [Renderer]) {
    for shape in shapes() {
        let name = &*shape.info().name;
        let text = |solid: &str| {
            format!(
                "pathmarch 1\ncamera {{ position 1 2 5; target 0 0.2 0; fov 35 }}\nsky 0.3 0.375 0.5\n\
                 sun {{ direction 1 2 1.5; irradiance 2; angle 0 }}\nobject \"floor\" {{ plane {{ at 0 -1.5 0 }} }}\n\
                 object \"solid\" {{ {solid} }}"
            )
        };
        let (open, close) = if shape.info().profile { ("extrude {", ";") } else { ("", "{") };
        let placed = format!("{open} {name} {close} rotate 25 30 10; scale 1.2; at 0 0.1 0 }}");
        let alone = parse(&text(&placed));
        let sphere_traced = parse(&text(&format!("union smooth=1e-6 {{ {placed}; sphere 0.001 {{ at 0 0.1 0 }} }}")));
        let settings = Settings { size: [96, 54], samples: 16, ..Settings::of(&alone) };
        let mut pictures = Vec::new();
        for renderer in &mut *renderers {
            let [a, b] = [&alone, &sphere_traced].map(|scene| render(renderer, scene, &settings).mean());
            let result = compare(&b, &a, PictureKind::Hdr).expect("equal sizes");
            println!(
                "{name} on {}: analytic against sphere-traced relMSE {:.1e}",
                renderer.backend().name,
                result.relmse
            );
            assert!(result.relmse < 5e-4, "{name}: {:.1e}", result.relmse);
            pictures.push([a, b]);
        }
        if let [cpu, gpu] = pictures.as_slice() {
            for (cpu, gpu) in cpu.iter().zip(gpu) {
                let result = compare(cpu, gpu, PictureKind::Hdr).expect("equal sizes");
                println!("{name}: CPU against GPU relMSE {:.1e}", result.relmse);
                // The orbits of fractals amplify rounding errors.
                let limit = if shape.has_orbit() { 2e-4 } else { 1e-5 };
                assert!(result.relmse < limit, "{name}: {:.1e}", result.relmse);
            }
        }
    }
}

fn settings_out_of_range_are_refused_with_a_message() {
    let scene = Scene::load(data("furnace_050.kdl")).expect("a valid scene");
    let good = Settings::of(&scene);
    let bad = [
        Settings { size: [0, 10], ..good.clone() },
        Settings { size: [10, 20_000], ..good.clone() },
        Settings { samples: 0, ..good.clone() },
        Settings { bounces: 1001, ..good.clone() },
        Settings { first_sample: u32::MAX, ..good.clone() },
        Settings { camera: 1, ..good },
    ];
    for settings in bad {
        let renderer = Renderer::open(Backend::Cpu, None).expect("the CPU backend");
        assert!(renderer.start(&scene, &settings).is_err_and(|error| error.to_string().len() > 10), "{settings:?}");
    }
}

/// Scene of `count` balls; the GPU refuses more than 2,048 shapes as code.
fn balls(count: usize) -> Scene {
    let mut text = String::from("pathmarch 1\ncamera { position 0 0 4; target 0 0 0 }\n");
    (0..count).for_each(|k| text += &format!("object \"o{k}\" {{ sphere 0.01 {{ at 0 {} 0 }} }}\n", k as f32 * 1e-3));
    let scene = parse(&text);
    let roots: Vec<_> = scene.objects.iter().map(|object| object.root.clone()).collect();
    Scene { field: Field::with_shape_grids_from(&roots, usize::MAX), ..scene }
}

fn a_refused_scene_leaves_the_backend_as_it_was() {
    // A software adapter would be compared with the CPU.
    let renderer = testing::auto_renderer_as("discrete GPU").expect("opens");
    let settings = |scene: &Scene| Settings { size: [8, 8], samples: 1, ..Settings::of(scene) };
    let backend_of = |scene: &Scene| renderer.start(scene, &settings(scene)).expect("starts").backend().clone();
    let (small, large) = (balls(1), balls(2100));
    let before = backend_of(&small);
    let refused = backend_of(&large);
    assert_ne!(before.name, "CPU");
    assert_eq!(refused.name, "CPU");
    assert!(refused.notice.is_some_and(|notice| notice.contains("2100 shapes")));
    assert_eq!(backend_of(&small), before);
}

fn software_adapters_are_compared_with_the_cpu() {
    let renderer = testing::auto_renderer_as("software").expect("opens");
    let scene = parse("pathmarch 1\ncamera { position 0 0 4; target 0 0 0 }\nobject \"o\" { torus 1 0.3 }\n");
    // Fast on the CPU, so that no kernel is compiled.
    let settings = Settings { size: [8, 8], samples: 1, ..Settings::of(&scene) };
    let backend = renderer.start(&scene, &settings).expect("starts").backend().clone();
    assert_eq!(backend.name, "CPU");
    assert!(backend.notice.is_some_and(|notice| notice.contains("software")));
    // Slow enough to be measured; either may be faster.
    let settings = Settings { size: [640, 360], samples: 4096, ..settings };
    let job = renderer.start(&scene, &settings).expect("starts");
    assert_eq!(job.backend().name == "CPU", job.backend().notice.is_some(), "{:?}", job.backend());
    // A requested GPU is used.
    let asked = Renderer::open(Backend::Gpu, None).expect("opens");
    assert_ne!(asked.start(&scene, &settings).expect("starts").backend().name, "CPU");
}

/// GPU time is measured on request, if the adapter has timestamps, and grows with the samples.
fn gpu_time_is_measured(renderer: &Renderer) {
    let scene = parse("pathmarch 1\ncamera { position 0 1 4; target 0 0 0 }\nsky 1\nobject \"ball\" { sphere 1 }");
    let settings = Settings { size: [64, 36], samples: 8, ..Settings::of(&scene) };
    let mut job = renderer.start(&scene, &settings).expect("starts");
    assert_eq!(job.gpu_time().expect("works"), None, "not requested");
    let measured = job.measure_gpu_time().expect("works");
    assert!(!measured || renderer.backend().name != "CPU");
    let mut before = std::time::Duration::ZERO;
    for samples in [4, 8] {
        while job.samples_done() < f64::from(samples) {
            job.advance(samples).expect("renders");
        }
        let time = job.gpu_time().expect("works");
        assert_eq!(time.is_some(), measured);
        assert!(!measured || time.is_some_and(|time| time > before));
        before = time.unwrap_or_default();
    }
}

tests! {
    plain: [settings_out_of_range_are_refused_with_a_message],
    on_each_backend: [
        a_white_furnace_shows_the_albedo,
        compensated_surfaces_vanish_in_a_furnace,
        a_point_light_falls_off_by_the_square_and_the_cosine,
        the_sun_has_its_irradiance_at_every_angle,
        a_sheet_emits_on_the_side_it_faces_only,
        samples_that_are_not_finite_are_excluded_from_the_mean,
        ranges_of_samples_add_up_to_the_whole_and_seeds_differ,
        sphere_traced_shapes_look_like_analytic_ones,
        gpu_time_is_measured,
    ],
    on_one_and_both_backends slow: [every_shape_renders_alike_on_both_backends_and_in_closed_form],
    on_both_backends slow: [every_scene_renders_alike_on_both_backends],
    with_gpu: [a_refused_scene_leaves_the_backend_as_it_was, software_adapters_are_compared_with_the_cpu],
}
