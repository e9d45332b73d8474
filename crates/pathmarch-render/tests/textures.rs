//! Textures: both backends agree on every texture and every use of one, and bump maps conserve energy.

use crate::common::{mean, on_both_backends, on_each_backend, on_one_and_both_backends, parse, render};
use pathmarch_render::image::{Picture, PictureKind};
use pathmarch_render::metrics::compare;
use pathmarch_render::pathmarch_scene::{Material, Scene, textures};
use pathmarch_render::{Mode, Renderer, Settings};
use pathmarch_testing::tests;

/// Pictures of a scene by each renderer.
fn pictures(renderers: &mut [Renderer], scene: &Scene, mode: Mode, samples: u32, size: [u32; 2]) -> Vec<Picture> {
    let settings = Settings { size, samples, mode, ..Settings::of(scene) };
    let show = |renderer: &mut _| mode.picture(&render(renderer, scene, &settings));
    renderers.iter_mut().map(show).collect()
}

/// Fraction of pixels with a channel that differs by more than `more_than`; 0 for a single backend.
fn differing(pictures: &[Picture], more_than: f32) -> f64 {
    let [a, b] = pictures else { return 0.0 };
    let differ = |(a, b): &(&[f32; 3], &[f32; 3])| (0..3).any(|k| (a[k] - b[k]).abs() > more_than);
    a.pixels.iter().zip(&b.pixels).filter(differ).count() as f64 / a.pixels.len() as f64
}

/// Scene of a material on a rotated and scaled ball, and on a twisted ring of three boxes.
fn textured_scene(material: &str) -> Scene {
    parse(&format!(
        "pathmarch 1\ncamera {{ position 1 2 4; target 0.6 0.1 0; fov 40 }}\nsky 1\nmaterial \"m\" {{ {material} }}\n\
         object \"ball\" material=\"m\" {{ sphere 1 {{ rotate 20 30 40; scale 0.9; at -0.5 0.1 0.2 }} }}\n\
         object \"ring\" material=\"m\" {{ twist 0.2 {{ polar 3 {{ box 0.5 0.9 0.5 {{ rotate 0 20 10; at 0.6 0 0 }} }}; at 1.6 0 0; scale 1.1 }} }}"
    ))
}

fn both_backends_show_every_texture_alike(renderers: &mut [Renderer]) {
    for kind in textures::kinds() {
        for (place, sizes) in [("", 0.2), ("at 0.1 0.2 0.3; rotate 10 20 30; scale 0.3;", 1.0)] {
            let name = kind.name;
            let size = if name == "brick" { String::new() } else { format!("size={sizes}") };
            let scene =
                textured_scene(&format!("diffuse {{ {name} {size} {{ {place} colour 0.1 0.9 0.2; colour 1 0 1 }} }}"));
            let pictures = pictures(renderers, &scene, Mode::Albedo, 1, [96, 64]);
            let differing = differing(&pictures, 2e-3);
            println!("{name} {place}: {differing}");
            // At edges, rounding decides on which side a point is.
            assert!(differing < 5e-3, "{name}: {differing} of the pixels");
            let textured_scene = mean(&pictures[0], |_, _| true);
            assert!(textured_scene > 0.005 && textured_scene < 0.6, "{name}: {textured_scene}");
        }
    }
}

/// Textures of every parameter: on a blend, on a fractal in a modifier, in glass.
const EVERYTHING: &str = "pathmarch 1
camera { position 0 2 6; target 0 0.6 0; fov 40 }
render { bounces 6; caustics \"fast\" }
sky 0.4 0.5 0.6
sun { direction 1 2 1; irradiance 2; angle 2 }
point { at -3 4 3; intensity 20 }
material \"floor\" {
    principled { wood size=0.2 { colour 0.5 0.3 0.1; colour 0.2 0.1 0.05; rotate 90 0 0 } }
    roughness { fbm size=0.3 from=0.1 to=0.6 }
    coat { checker size=0.5 }
    bump { brick length=0.5 course=0.25 }
}
material \"stone\" { diffuse { marble { colour 0.9; colour 0.2 0.2 0.3 } }; bump { voronoi size=0.1 height=0.02 } }
material \"gold\" { metal { cracks { colour 1 0.6 0.2; colour 1 0.9 0.5 } }; roughness { cells from=0 to=0.5 } }
material \"pane\" { glass { cells size=0.2 { colour 1 0.3 0.3; colour 0.3 1 0.4 } } }
material \"wavy\" { glass 1; bump { fbm size=0.3 octaves=2 height=0.01 } }
material \"flesh\" { diffuse 0.5; orbit-trap \"point\" from=0.4 to=1.1 { colour 0.9 0.1 0.1; colour 0.1 0.1 0.9 } }
object \"floor\" material=\"floor\" { plane }
object \"blend\" { union smooth=0.4 { sphere 0.6 material=\"stone\" { at -1.4 0.6 0 }; box 0.8 material=\"gold\" { at -0.7 0.4 0.3 } } }
object \"sponge\" material=\"flesh\" { twist 0.1 { menger 3 { scale 0.45 }; at 1.7 0.7 0 } }
object \"pane\" material=\"pane\" { box 0.8 1 0.06 { at 0.4 0.6 1.2; rotate 0 20 0 } }
object \"lens\" material=\"wavy\" { sphere 0.3 { at -0.3 0.35 1.6 } }";

fn both_backends_trace_textures_alike(renderers: &mut [Renderer; 2]) {
    let scene = parse(EVERYTHING);
    let pictures = pictures(renderers, &scene, Mode::Path, 8, [60, 40]);
    if let [cpu, gpu] = &pictures[..] {
        let comparison = compare(gpu, cpu, PictureKind::Hdr).expect("equal sizes");
        println!("relMSE {}", comparison.relmse);
        assert!(comparison.relmse < 5e-3, "{}", comparison.relmse);
    }
}

fn both_backends_preview_textures_alike(renderers: &mut [Renderer; 2]) {
    let scene = parse(EVERYTHING);
    let pictures = pictures(renderers, &scene, Mode::Preview, 1, [96, 64]);
    let differing = differing(&pictures, 0.02);
    println!("{differing}");
    assert!(differing < 0.02, "{differing} of the pixels");
}

fn pictures_are_shown_alike_and_upright(renderers: &mut [Renderer]) {
    let folder = tempfile::tempdir().expect("a folder");
    // Red increases to the right, green upwards.
    let picture = image::RgbImage::from_fn(64, 32, |x, y| image::Rgb([(x * 4) as u8, ((31 - y) * 8) as u8, 40]));
    picture.save(folder.path().join("p.png")).expect("saved");
    let name = folder.path().join("scene.kdl").display().to_string();
    let load = |text: &str| Scene::parse(&name, text).expect("a valid scene");
    let all_around = load(
        "pathmarch 1\ncamera { position 1 2 4; target 0 0 0 }\nmaterial \"m\" { diffuse { picture \"p.png\" size=0.3 } }\n\
         object \"ball\" material=\"m\" { sphere 1.2 { rotate 10 20 30 } }",
    );
    let differing = differing(&pictures(renderers, &all_around, Mode::Albedo, 1, [96, 64]), 4e-3);
    assert!(differing < 2e-3, "{differing} of the pixels");
    // A wall of the picture's size fills the view.
    let wall = load(
        "pathmarch 1\ncamera { position 1 0.5 10; target 1 0.5 0; fov 5.7 }\nmaterial \"m\" { diffuse { picture \"p.png\" size=2 } }\n\
         object \"wall\" material=\"m\" { box 8 8 1 { at 0 0 -0.5 } }",
    );
    // Coordinates are in the box's space: its middle is at the picture's corner.
    for picture in pictures(renderers, &wall, Mode::Albedo, 1, [64, 32]) {
        let [left, right] = [8, 56].map(|x| picture.pixels[16 * 64 + x]);
        let [top, bottom] = [4, 28].map(|y| picture.pixels[y * 64 + 32]);
        assert!(left[0] < right[0], "{left:?} {right:?}");
        assert!(top[1] > bottom[1], "{top:?} {bottom:?}");
    }
}

/// Folder with a scene of decals and ramps with positions, and its text: over a texture, above each other, in the
/// coordinates of the scene, on metal, glass and a fractal.
fn decal_scene() -> (tempfile::TempDir, Scene) {
    let folder = tempfile::tempdir().expect("a folder");
    // Red increases to the right, alpha upwards; a hole in the middle.
    let picture = image::RgbaImage::from_fn(48, 24, |x, y| {
        let is_hole = x.abs_diff(24) + y.abs_diff(12) < 6;
        image::Rgba([(x * 5) as u8, 40, 200, if is_hole { 0 } else { ((23 - y) * 11) as u8 }])
    });
    picture.save(folder.path().join("p.png")).expect("saved");
    let text = "pathmarch 1
camera { position 0 2 6; target 0 0.6 0; fov 40 }
render { bounces 6; caustics \"fast\" }
sky 0.6
sun { direction 1 2 3; irradiance 2; angle 2 }
material \"floor\" {
    principled { checker size=0.4 { colour 0.3 0.5 0.2; colour 0.8 at=0.4; colour 0.9 0.6 0.3 at=0.4 } }
    decal \"p.png\" size=1.6 world=#true depth=0.2 { rotate -90 0 0; at 0.2 0 1.8 }
    decal \"p.png\" size=1 world=#true opacity=0.6 angle=30 { rotate -90 0 40; at 0.5 0 1.7; scale 1.2 }
}
material \"ball\" {
    metal { fbm size=0.3 { colour 0.9 0.2 0.1; colour 1 0.9 0.2 at=0.45; colour 0.2 0.9 0.3 at=0.5; colour 0.9 at=0.8 } }
    roughness 0.3
    decal \"p.png\" size=0.6 angle=60 { rotate 0 20 10; at 0 0.1 0.5 }
}
material \"pane\" { glass 0.9; decal \"p.png\" size=0.7 depth=0.4 }
material \"flesh\" {
    diffuse 0.5
    orbit-trap \"point\" from=0.4 to=1.1 { colour 0.9 0.1 0.1 at=0.2; colour 0.1 0.9 0.2 at=0.3; colour 0.1 0.1 0.9 }
    decal \"p.png\" depth=4 { scale 1.6 }
}
object \"floor\" material=\"floor\" { plane }
object \"ball\" material=\"ball\" { sphere 0.6 { rotate 0 20 0; at -1.5 0.6 0 } }
object \"sponge\" material=\"flesh\" { twist 0.1 { menger 3 { scale 0.45 }; at 1.7 0.7 0 } }
object \"pane\" material=\"pane\" { box 0.8 1 0.06 { at 0.2 0.6 0.6; rotate 0 20 0 } }";
    let name = folder.path().join("scene.kdl").display().to_string();
    let scene = Scene::parse(&name, text).expect("a valid scene");
    (folder, scene)
}

fn both_backends_show_decals_and_ramps_alike(renderers: &mut [Renderer; 2]) {
    let (_folder, scene) = decal_scene();
    let bare = {
        let materials = scene.materials.iter().map(|material| Material { decals: Vec::new(), ..material.clone() });
        Scene { materials: materials.collect(), ..scene.clone() }
    };
    for (mode, more_than, most) in [(Mode::Albedo, 4e-3, 5e-3), (Mode::Preview, 0.02, 0.02)] {
        let shown = pictures(renderers, &scene, mode, 1, [96, 64]);
        let found = differing(&shown, more_than);
        println!("{}: {found}", mode.name());
        assert!(found < most, "{}: {found} of the pixels", mode.name());
        let without = pictures(&mut renderers[..1], &bare, mode, 1, [96, 64]);
        let changed = differing(&[shown[0].clone(), without[0].clone()], 0.02);
        assert!(changed > 0.05 && changed < 0.5, "decals change {changed} of the pixels");
    }
    let shown = pictures(renderers, &scene, Mode::Path, 8, [60, 40]);
    let comparison = compare(&shown[1], &shown[0], PictureKind::Hdr).expect("equal sizes");
    println!("relMSE {}", comparison.relmse);
    assert!(comparison.relmse < 5e-3, "{}", comparison.relmse);
}

fn a_decal_is_shown_once_upright_and_over_its_material(renderers: &mut [Renderer]) {
    let folder = tempfile::tempdir().expect("a folder");
    // The left half is red, of which the lower half is half transparent; the right half is clear green.
    let picture = image::RgbaImage::from_fn(64, 64, |x, y| match (x < 32, y < 32) {
        (true, true) => image::Rgba([255, 0, 0, 255]),
        (true, false) => image::Rgba([255, 0, 0, 128]),
        _ => image::Rgba([0, 255, 0, 0]),
    });
    picture.save(folder.path().join("p.png")).expect("saved");
    let name = folder.path().join("scene.kdl").display().to_string();
    // Boxes at x = -1 and 1 of which the camera sees the sides at z = 0.5, four units wide.
    let boxes = |decal: &str, turned: f32| {
        let text = format!(
            "pathmarch 1\ncamera {{ position 0 0 100; target 0 0 0; fov 1.1518 }}\n\
             material \"m\" {{ diffuse 0 0 0.5; decal \"p.png\" size=0.8 {decal} }}\n\
             object \"boxes\" material=\"m\" {{ box 1 {{ rotate 0 {turned} 0; at -0.5 0 0 }}; box 1 {{ at 0.5 0 0 }} }}"
        );
        Scene::parse(&name, &text).expect("a valid scene")
    };
    // Colours at the upper left, lower left and right of the decals of both boxes.
    let mut colours = |decal: &str, turned: f32| -> Vec<[[f32; 3]; 6]> {
        let pictures = pictures(renderers, &boxes(decal, turned), Mode::Albedo, 1, [200, 200]);
        let at = |picture: &Picture, [x, y]: [f32; 2]| {
            let [column, row] = [100.0 + 100.0 * x, 100.0 - 100.0 * y].map(|v| v as usize);
            picture.pixels[row * 200 + column]
        };
        let places = [-0.5, 0.5].map(|x| [[x - 0.2, 0.2], [x - 0.2, -0.2], [x + 0.2, 0.2]]);
        let all = |picture| std::array::from_fn(|k| at(picture, places[k / 3][k % 3]));
        pictures.iter().map(all).collect()
    };
    let (blue, red) = ([0.0, 0.0, 0.5], [1.0, 0.0, 0.0]);
    let half = [128.0 / 255.0, 0.0, 0.5 * 127.0 / 255.0];
    let near = |found: [[f32; 3]; 6], expected: [[f32; 3]; 6]| {
        let off = found.as_flattened().iter().zip(expected.as_flattened()).any(|(a, b)| (a - b).abs() > 2e-3);
        assert!(!off, "{found:?} is not {expected:?}");
    };
    let both = [red, half, blue, red, half, blue];
    // In the coordinates of each shape, in front of its middle; the left one is turned away in the second scene.
    colours("{ at 0 0 0.5 }", 0.0).into_iter().for_each(|found| near(found, both));
    let right = [blue, blue, blue, red, half, blue];
    colours("{ at 0 0 0.5 }", 180.0).into_iter().for_each(|found| near(found, right));
    // In the coordinates of the scene, only where it is.
    colours("world=#true { at 0.5 0 0.5 }", 180.0).into_iter().for_each(|found| near(found, right));
    // Too far from the surface, facing away, and at an angle that is too large.
    for decal in
        ["depth=0.2 { at 0 0 0.65 }", "{ at 0 0 0.5; rotate 0 180 0 }", "angle=15 { at 0 0 0.5; rotate 0 20 0 }"]
    {
        colours(decal, 0.0).into_iter().for_each(|found| near(found, [blue; 6]));
    }
}

fn a_bump_map_adds_no_light_and_loses_little(renderer: &Renderer) {
    for (material, least) in [("diffuse 1", 0.93), ("metal 1; roughness 0", 0.93), ("principled 1; roughness 0.3", 0.9)]
    {
        let scene = parse(&format!(
            "pathmarch 1\ncamera {{ position 0 0 8; target 0 0 0; fov 20 }}\nsky 1\nrender {{ bounces 8 }}\n\
             material \"m\" {{ {material}; bump {{ fbm size=0.2 octaves=3 height=0.02 }} }}\n\
             object \"ball\" material=\"m\" {{ sphere 1 }}"
        ));
        let settings = Settings { size: [48, 48], samples: 64, ..Settings::of(&scene) };
        let picture = render(renderer, &scene, &settings).mean();
        let ball = mean(&picture, |x, y| (x as f32 - 23.5).hypot(y as f32 - 23.5) < 16.0);
        let darkest = picture.pixels.iter().map(|pixel| pixel[1]).fold(f32::INFINITY, f32::min);
        println!("{material}: {ball}, darkest {darkest}");
        assert!(ball > least && ball < 1.003, "{material}: {ball}");
        assert!(darkest > 0.5, "{material}: a pixel of {darkest}");
    }
}

tests! {
    on_each_backend: [a_bump_map_adds_no_light_and_loses_little],
    on_one_and_both_backends: [pictures_are_shown_alike_and_upright, a_decal_is_shown_once_upright_and_over_its_material],
    on_one_and_both_backends slow: [both_backends_show_every_texture_alike],
    on_both_backends: [both_backends_preview_textures_alike, both_backends_show_decals_and_ramps_alike],
    on_both_backends slow: [both_backends_trace_textures_alike],
}
