//! Modes of a picture: their values, and agreement of both backends.

use crate::common::{cpu, data, mean, on_both_backends, on_each_backend, parse, render, scenes};
use pathmarch_render::aov;
use pathmarch_render::film::Film;
use pathmarch_render::image::PictureKind;
use pathmarch_render::metrics::{compare, relmse};
use pathmarch_render::pathmarch_scene::Scene;
use pathmarch_render::tonemap::{Display, Tonemap};
use pathmarch_render::{Mode, PreviewStep, Renderer, Settings, clearance, pick, relative_error};
use pathmarch_testing::{plain, some_of, tests};
use std::collections::HashSet;

/// Display codes of a pixel of a mode's picture.
fn codes(film: &Film, mode: Mode, x: u32, y: u32) -> [u8; 3] {
    let display = mode.display(Display { tonemap: Tonemap::Agx, exposure_stops: 3.0 });
    display.encode_8bit(mode.picture(film).get(x, y).expect("in the picture"))
}

fn every_mode_looks_alike_on_both_backends(renderers: &mut [Renderer; 2]) {
    let chosen = ["cornell", "glass-still-life", "many-lights", "combinations"];
    for path in scenes().iter().filter(|path| path.file_stem().is_some_and(|name| chosen.iter().any(|c| name == *c))) {
        let scene = Scene::load(path).expect("a valid scene");
        for mode in Mode::ALL {
            let settings = Settings { size: [96, 54], samples: 4, mode, ..Settings::of(&scene) };
            let [cpu, gpu] = [0, 1].map(|k| render(&renderers[k], &scene, &settings).mean());
            let differs =
                |a: &[f32; 3], b: &[f32; 3]| (0..3).any(|k| (a[k] - b[k]).abs() > 0.02 * b[k].abs().max(0.02));
            let differing = cpu.pixels.iter().zip(&gpu.pixels).filter(|(a, b)| differs(a, b)).count();
            let share = differing as f64 / cpu.pixels.len() as f64;
            let (a, b) = (cpu.mean_colour(), gpu.mean_colour());
            println!(
                "{} {}: {:.2} % of pixels differ, means {a:.4?} {b:.4?}",
                path.display(),
                mode.name(),
                share * 100.0
            );
            assert!(share < 0.03, "{} {}: {share}", path.display(), mode.name());
            // The squares of rare bright paths dominate the differences.
            let tolerance = if mode == Mode::Variance { 0.2 } else { 5e-3 };
            for k in 0..3 {
                assert!((a[k] - b[k]).abs() <= tolerance * b[k].max(1e-3), "{} {}", path.display(), mode.name());
            }
            let black = matches!(mode, Mode::Steps | Mode::Violations)
                && scene.field.sphere_traced_bounds().min[0] > scene.field.sphere_traced_bounds().max[0];
            assert_eq!(a.iter().sum::<f64>() < 1e-3, black, "{} {}", path.display(), mode.name());
        }
    }
}

/// But for scenes in fog, whose previews show no light that the fog scatters; of glass that disperses light, which it does not in
/// previews; and for a room that only indirect light reaches.
fn previews_are_about_as_bright_as_pictures() {
    let renderer = cpu();
    for path in some_of(scenes(), 3) {
        let scene = Scene::load(&path).expect("a valid scene");
        // Each picture has an exposure of its own where the camera chooses it.
        let is_indirect = path.ends_with("keyhole-room.kdl");
        let disperses = scene.materials.iter().any(|material| material.dielectric().index_difference != 0.0);
        if scene.fog.scattering != [0.0; 3] || disperses || is_indirect || scene.cameras[0].auto_exposure {
            continue;
        }
        let [traced, preview] = [Mode::Path, Mode::Preview].map(|mode| {
            let samples = if mode == Mode::Path { 32 } else { 2 };
            let settings = Settings { size: [96, 54], samples, mode, ..Settings::of(&scene) };
            let camera = &scene.cameras[0];
            let display = Display { tonemap: scene.render.tonemap, exposure_stops: camera.exposure };
            let picture = render(&renderer, &scene, &settings).mean();
            let codes = picture.pixels.iter().map(|pixel| f64::from(display.encode(*pixel).iter().sum::<f32>() / 3.0));
            codes.sum::<f64>() / picture.pixels.len() as f64
        });
        println!("{}: mean code {traced:.3} traced, {preview:.3} previewed", path.display());
        assert!((preview - traced).abs() < 0.06 && preview > 0.7 * traced, "{}", path.display());
    }
}

fn modes_without_noise_ignore_the_seed_and_their_ranges_add_up(renderer: &Renderer) {
    let scene = Scene::load(data("diffuse_sphere_plane_area.kdl")).expect("a valid scene");
    for mode in Mode::ALL.into_iter().filter(|mode| !mode.traces_paths()) {
        let settings = Settings { size: [64, 36], samples: 1, mode, ..Settings::of(&scene) };
        let first = render(renderer, &scene, &settings);
        assert_eq!(first, render(renderer, &scene, &Settings { seed: 7, ..settings.clone() }), "{}", mode.name());
        let mut parts = render(renderer, &scene, &Settings { first_sample: 1, samples: 4, ..settings.clone() });
        parts.add(&first).expect("equal sizes");
        let whole = render(renderer, &scene, &Settings { samples: 5, seed: 3, ..settings });
        for (a, b) in parts.sums.iter().flatten().zip(whole.sums.iter().flatten()) {
            assert!((a - b).abs() <= 1e-5 * b.abs(), "{}: {a} for {b}", mode.name());
        }
    }
}

/// Ball of radius 1 around the origin, five metres in front of the camera, and a wall four metres behind it; no floor.
fn ball(shape: &str) -> Scene {
    parse(&format!(
        "pathmarch 1\ncamera {{ position 0 0 5; target 0 0 0; fov 40 }}\nsky 1\n\
         material \"ball\" {{ diffuse 0.5 0.25 0.125 }}\nmaterial \"wall\" {{ principled 0.2; roughness 0.5 }}\n\
         object \"ball\" material=\"ball\" {{ {shape} }}\n\
         object \"wall\" material=\"wall\" {{ box 2 9 1 {{ at 3 0 -4.5 }} }}"
    ))
}

const ANALYTIC: &str = "sphere 1";
const SPHERE_TRACED: &str = "union smooth=1e-6 { sphere 1; sphere 0.001 }";

fn views_of_a_ball_match_the_closed_form(renderer: &Renderer) {
    for shape in [ANALYTIC, SPHERE_TRACED] {
        let scene = ball(shape);
        let show = |mode, [x, y]: [u32; 2]| {
            let film = render(renderer, &scene, &Settings { size: [81, 61], samples: 1, mode, ..Settings::of(&scene) });
            codes(&film, mode, x, y)
        };
        let (middle, corner) = ([40, 30], [0, 0]);
        let near = |found: [u8; 3], expected: [f32; 3]| {
            let close = (0..3).all(|k| (f32::from(found[k]) - 255.0 * expected[k]).abs() <= 1.0);
            assert!(close, "{shape}: {found:?} for {expected:?}");
        };
        near(show(Mode::Normal, middle), [0.5, 0.5, 1.0]);
        // Right limb of the ball in the middle row; the normal from the intersection with the ray.
        let half = 20f32.to_radians().tan();
        let across = half * 81.0 / 61.0 * (2.0 * 52.5 / 81.0 - 1.0);
        let along = 1.0 / (1.0 + across * across).sqrt();
        let t = 5.0 * along - (1.0 - (5.0 * across * along).powi(2)).sqrt();
        near(show(Mode::Normal, [52, 30]), [0.5 + 0.5 * across * along * t, 0.5, 0.5 + 0.5 * (5.0 - along * t)]);
        near(show(Mode::Albedo, middle), [0.735_357, 0.537_099, 0.388_573]);
        // The scene is larger than the distance to the target, which is then middle grey; the ball's front is at 4 m of 5.
        near(show(Mode::Depth, middle), [1.0 / (1.0 + 0.64); 3]);
        for mode in Mode::ALL.into_iter().filter(|mode| !mode.traces_paths() && *mode != Mode::Preview) {
            assert_eq!(show(mode, corner), [0; 3], "{}: the background is black", mode.name());
        }
        let is_sphere_traced = show(Mode::Steps, middle).iter().any(|&code| code > 0);
        assert_eq!(is_sphere_traced, shape == SPHERE_TRACED, "{shape}");
    }
}

fn violations_show_a_wrong_lipschitz_constant(renderer: &Renderer) {
    let scene = |lipschitz: f32| {
        parse(&format!(
            "pathmarch 1\ncamera {{ position 0 0 5; target 0 0 0; fov 40 }}\n\
             field \"ball\" {{ lipschitz {lipschitz}; bounds 3; \
             wgsl \"fn distance(p: vec3f) -> f32 {{ return 3.0 * (length(p) - 1.0); }}\" }}\n\
             object \"it\" {{ ball }}"
        ))
    };
    let coloured = |lipschitz: f32| {
        let scene = scene(lipschitz);
        let settings = Settings { size: [64, 64], samples: 1, mode: Mode::Violations, ..Settings::of(&scene) };
        let picture = render(renderer, &scene, &settings).mean();
        let is_grey = |[r, g, b]: [f32; 3]| (r - g).abs() < 1e-6 && (g - b).abs() < 1e-6;
        picture.pixels.into_iter().filter(|&pixel| !is_grey(pixel)).count()
    };
    let counts = [coloured(3.0), coloured(1.0)];
    println!("{counts:?} of 4096 pixels are coloured");
    assert!(counts[0] == 0 && counts[1] > 500, "{counts:?}");
}

fn the_depth_of_a_plane_across_the_view_is_one_grey(renderer: &Renderer) {
    let scene = parse(
        "pathmarch 1\ncamera { position 0 0 3; target 0 0 0; fov 90 }\nsky 1\nobject \"wall\" { plane { normal 0 0 1 } }",
    );
    let settings = Settings { size: [32, 32], samples: 1, mode: Mode::Depth, ..Settings::of(&scene) };
    let film = render(renderer, &scene, &settings);
    for (x, y) in [(0, 0), (16, 16), (31, 5)] {
        // At the target: half.
        assert!(codes(&film, Mode::Depth, x, y).iter().all(|&code| (127..=129).contains(&code)), "{x} {y}");
    }
}

fn every_object_and_material_has_its_colour(renderer: &Renderer) {
    let scene = Scene::load(data("../../../../scenes/material-grid.kdl")).expect("a valid scene");
    let settings = Settings { size: [192, 108], samples: 1, ..Settings::of(&scene) };
    let aovs = aov::render(&scene, &settings).expect("renders");
    for (mode, ids) in [(Mode::ObjectId, &aovs.object), (Mode::MaterialId, &aovs.material)] {
        let film = render(renderer, &scene, &Settings { mode, ..settings.clone() });
        let seen: HashSet<(u32, [u8; 3])> =
            (0..192 * 108).map(|k| (ids[k as usize], codes(&film, mode, k % 192, k / 192))).collect();
        let ids: HashSet<u32> = seen.iter().map(|(id, _)| *id).collect();
        let colours: HashSet<[u8; 3]> = seen.iter().map(|(_, colour)| *colour).collect();
        assert!(ids.len() > 20, "{} ids", ids.len());
        assert_eq!((seen.len(), colours.len()), (ids.len(), ids.len()), "{}: one colour each", mode.name());
    }
}

fn a_lamp_is_visible_on_the_side_that_emits(renderer: &Renderer) {
    for (facing, expected) in [(1, [2.0, 0.5, 0.25]), (-1, [0.0; 3])] {
        let scene = parse(&format!(
            "pathmarch 1\ncamera {{ position 0 0 5; target 0 0 0; fov 10 }}\nmaterial \"lamp\" {{ emit 2 0.5 0.25 }}\n\
                 object \"lamp\" material=\"lamp\" {{ rect 10 10 {{ normal 0 0 {facing} }} }}"
        ));
        let show = |mode| {
            let settings = Settings { size: [8, 8], samples: 1, mode, ..Settings::of(&scene) };
            render(renderer, &scene, &settings).mean().pixels[27]
        };
        assert_eq!(show(Mode::Preview), expected);
        assert_eq!(show(Mode::Albedo), expected.map(|channel: f32| channel.min(1.0)));
    }
}

fn a_preview_of_a_lit_floor_is_exact_where_it_can_be(renderer: &Renderer) {
    // A point, a sun and a square lamp, without occlusion and without a sky.
    let cases = [
        ("point { at 0 2 0; intensity 10 }", 10.0 / 4.0),
        ("sun { direction 0 1 0; irradiance 3; angle 0.53 }", 3.0),
        // Four quarters of a square of half edge 1 at height 2: form factor 4 · leg · atan(leg) · 2/(2π), leg = 1/√5.
        (
            "material \"lamp\" { emit 2 }\nobject \"lamp\" material=\"lamp\" { rect 2 2 { normal 0 -1 0; at 0 2 0 } }",
            2.0 * 4.0 * (1.0 / 5f64.sqrt()) * (1.0 / 5f64.sqrt()).atan(),
        ),
    ];
    for (light, irradiance) in cases {
        let scene = parse(&format!(
            "pathmarch 1\ncamera {{ position 0 0.5 0; target 0 0 0; up 0 0 -1; fov 0.5 }}\n{light}\n\
             material \"m\" {{ diffuse 0.5 }}\nobject \"floor\" material=\"m\" {{ plane }}"
        ));
        let settings = Settings { size: [8, 8], samples: 1, bounces: 0, mode: Mode::Preview, ..Settings::of(&scene) };
        let shown = mean(&render(renderer, &scene, &settings).mean(), |_, _| true);
        let expected = 0.5 / std::f64::consts::PI * irradiance;
        assert!((shown / expected - 1.0).abs() < 0.02, "{light}: {shown} for {expected}");
    }
}

fn a_white_furnace_looks_white_in_a_preview(renderer: &Renderer) {
    // Under a constant sky a ball in the air shows its albedo, except for the approximation of occlusion.
    let scene = Scene::load(data("furnace_050.kdl")).expect("a valid scene");
    let settings = Settings { size: [64, 64], samples: 1, mode: Mode::Preview, ..Settings::of(&scene) };
    let picture = render(renderer, &scene, &settings).mean();
    let ball = mean(&picture, |x, y| (x as f32 - 31.5).hypot(y as f32 - 31.5) < 20.0);
    assert!((ball - 0.5).abs() < 0.08, "{ball}");
}

fn uncertainty_falls_with_the_root_of_the_samples(renderer: &Renderer) {
    let scene = Scene::load(data("diffuse_sphere_plane_area.kdl")).expect("a valid scene");
    let base = Settings { size: [48, 27], sampler: scene.render.sampler, mode: Mode::Variance, ..Settings::of(&scene) };
    let mut errors = [64, 1024].map(|samples| {
        let film = render(renderer, &scene, &Settings { samples, ..base.clone() });
        let pairs = film.sums.iter().filter(|sum| sum[0] > 0.0);
        let mut errors: Vec<f64> = pairs.map(|sum| relative_error(sum[0], sum[1], samples)).collect();
        errors.sort_by(f64::total_cmp);
        errors
    });
    let [few, many] = errors.each_mut().map(|errors| errors[errors.len() * 3 / 4]);
    println!("{}: {few:.4} at 64 samples, {many:.4} at 1024", renderer.backend().name);
    assert!((few / many / 4.0 - 1.0).abs() < 0.1, "{few} {many}");
}

/// The mean equals the luminance of the path-traced picture, up to rounding.
fn the_mean_of_variance_is_that_of_the_picture() {
    let scene = Scene::load(data("diffuse_sphere_plane_area.kdl")).expect("a valid scene");
    let base = Settings { size: [48, 27], sampler: scene.render.sampler, mode: Mode::Variance, ..Settings::of(&scene) };
    let cpu = cpu();
    let of = |mode| Settings { samples: 16, mode, ..base.clone() };
    let traced = render(&cpu, &scene, &of(Mode::Path)).mean();
    for (moments, traced) in render(&cpu, &scene, &of(Mode::Variance)).mean().pixels.iter().zip(traced.pixels) {
        let luminance = 0.2126 * traced[0] + 0.7152 * traced[1] + 0.0722 * traced[2];
        assert!((moments[0] - luminance).abs() <= 1e-4 * luminance, "{moments:?} {luminance}");
    }
}

fn later_samples_smooth_the_edges(renderer: &Renderer) {
    let scene = ball(SPHERE_TRACED);
    let settings = Settings { size: [81, 61], samples: 16, mode: Mode::Albedo, ..Settings::of(&scene) };
    let one = render(renderer, &scene, &Settings { samples: 1, ..settings.clone() }).mean();
    let all = render(renderer, &scene, &settings).mean();
    let partial = |pixel: &[f32; 3]| pixel[0] > 0.02 && pixel[0] < 0.18;
    assert!(!one.pixels.iter().any(partial), "one sample is a plain picture");
    assert!(all.pixels.iter().filter(|pixel| partial(pixel)).count() > 20);
    let result = compare(&one, &all, PictureKind::Hdr).expect("equal sizes");
    assert!(result.flip < 0.1, "{}", result.flip);
}

fn picks_agree_with_aovs() {
    for name in ["cornell.kdl", "depth-of-field.kdl", "ten-lines.kdl"] {
        let scene = Scene::load(data("../../../../scenes").join(name)).expect("a valid scene");
        let settings = Settings { size: [64, 36], ..Settings::of(&scene) };
        let aovs = aov::render(&scene, &settings).expect("renders");
        let mut hits = 0;
        for y in (0..36).step_by(5) {
            for x in (0..64).step_by(5) {
                let k = y * 64 + x;
                let picked = pick(&scene, &settings, [x as f32 + 0.5, y as f32 + 0.5]);
                assert_eq!(picked.map_or(0, |picked| picked.object as u32 + 1), aovs.object[k], "{name} {x} {y}");
                let Some(picked) = picked else { continue };
                hits += 1;
                let leaf = &scene.field.leaves()[picked.leaf];
                assert_eq!((leaf.object as usize, leaf.tag + 1), (picked.object, aovs.material[k]), "{name} {x} {y}");
                assert_eq!((picked.position, picked.depth), (aovs.position[k], aovs.depth[k]), "{name} {x} {y}");
                assert!(picked.distance >= picked.depth && clearance(&scene, picked.position) < 1e-3);
                let length = picked.normal.iter().map(|v| v * v).sum::<f32>();
                assert!((length - 1.0).abs() < 1e-4);
            }
        }
        assert!(hits > 20, "{name}: {hits}");
    }
}

fn picks_and_clearances_of_a_ball_are_exact() {
    let scene = ball(ANALYTIC);
    let settings = Settings { size: [81, 61], ..Settings::of(&scene) };
    let picked = pick(&scene, &settings, [40.5, 30.5]).expect("the ball");
    assert_eq!((picked.object, picked.leaf), (0, 0));
    assert!((picked.distance - 4.0).abs() < 1e-5 && (picked.depth - 4.0).abs() < 1e-5);
    assert!((picked.position[2] - 1.0).abs() < 1e-5 && (picked.normal[2] - 1.0).abs() < 1e-5);
    assert_eq!(pick(&scene, &settings, [0.0, 0.0]), None);
    assert_eq!(pick(&scene, &Settings { camera: 3, ..settings }, [40.5, 30.5]), None, "no such camera");
    for (z, expected) in [(5.0, 4.0), (0.25, 0.75)] {
        assert!((clearance(&scene, [0.0, 0.0, z]) - expected).abs() < 1e-5, "from both sides");
    }
}

fn each_step_of_the_preview_changes_the_picture(renderers: &mut [Renderer; 2]) {
    let text = "pathmarch 1\ncamera { position 0 1.2 4; target 0 0.5 0 }\nsky 0.6\nsun { direction 1 2 1; irradiance 2 }\n\
        material \"red\" { diffuse 0.7 0.1 0.1 }\nmaterial \"mirror\" { metal 0.9; roughness 0 }\n\
        material \"satin\" { metal 0.8; roughness 0.4 }\nobject \"floor\" material=\"red\" { plane }\n\
        object \"ball\" material=\"mirror\" { sphere 0.5 { at -0.6 0.5 0 } }\n\
        object \"knot\" material=\"satin\" { torus 0.3 0.15 { at 0.6 0.4 0.3 } }";
    let scene = parse(text);
    let whole = Settings { size: [48, 32], samples: 1, mode: Mode::Preview, ..Settings::of(&scene) };
    let pictures = |settings: &Settings| renderers.each_ref().map(|renderer| render(renderer, &scene, settings).mean());
    let [all, _] = pictures(&whole);
    for step in PreviewStep::ALL {
        let mut settings = whole.clone();
        settings.preview_steps.set(step, false);
        let [cpu, gpu] = pictures(&settings);
        let (change, difference) = (relmse(&cpu, &all).expect("finite"), relmse(&cpu, &gpu).expect("finite"));
        println!("without {}: changed by {change:.4}, backends differ by {difference:.2e}", step.name());
        assert!(change > 1e-4 && difference < 1e-4, "{}: {change} {difference}", step.name());
    }
    let mut flat = whole.clone();
    PreviewStep::ALL
        .into_iter()
        .filter(|step| *step != PreviewStep::Albedo)
        .for_each(|step| flat.preview_steps.set(step, false));
    // Nothing but the colour of the floor is left.
    let [cpu, _] = pictures(&flat);
    let corner = cpu.get(0, 31).expect("a pixel");
    assert!((0..3).all(|k| (corner[k] - [0.7, 0.1, 0.1][k]).abs() < 1e-5), "{corner:?}");
}

tests! {
    plain: [
        picks_agree_with_aovs,
        picks_and_clearances_of_a_ball_are_exact,
        the_mean_of_variance_is_that_of_the_picture,
    ],
    plain slow: [previews_are_about_as_bright_as_pictures],
    on_each_backend: [
        modes_without_noise_ignore_the_seed_and_their_ranges_add_up,
        views_of_a_ball_match_the_closed_form,
        violations_show_a_wrong_lipschitz_constant,
        the_depth_of_a_plane_across_the_view_is_one_grey,
        every_object_and_material_has_its_colour,
        a_lamp_is_visible_on_the_side_that_emits,
        a_preview_of_a_lit_floor_is_exact_where_it_can_be,
        a_white_furnace_looks_white_in_a_preview,
        later_samples_smooth_the_edges,
        uncertainty_falls_with_the_root_of_the_samples,
    ],
    on_both_backends: [each_step_of_the_preview_changes_the_picture],
    on_both_backends slow: [every_mode_looks_alike_on_both_backends],
}
