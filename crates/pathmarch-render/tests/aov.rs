//! AOVs, compared with surfaces in closed form.

use pathmarch_render::aov::{self, Aovs, Layer};
use pathmarch_render::film::Film;
use pathmarch_render::image::ChannelValues;
use pathmarch_render::pathmarch_scene::Scene;
use pathmarch_render::{RenderError, Settings};
use pathmarch_testing::{plain, tests};

fn parse(text: &str) -> Scene {
    Scene::parse("test.kdl", text).expect("a valid scene")
}

fn render(scene: &Scene, size: [u32; 2]) -> Aovs {
    let aovs = aov::render(scene, &Settings { size, ..Settings::of(scene) }).expect("renders");
    let vectors = aovs.albedo.iter().chain(&aovs.normal).chain(&aovs.position);
    assert!(vectors.flatten().all(|value| value.is_finite()));
    assert!(aovs.albedo.iter().flatten().all(|value| (0.0..=1.0).contains(value)));
    for (k, &object) in aovs.object.iter().enumerate() {
        assert_eq!(aovs.depth[k].is_finite(), object > 0);
        assert_eq!(aovs.material[k] > 0, object > 0);
    }
    aovs
}

const SIZE: [u32; 2] = [81, 61];
const GROUND: f64 = 0.25;
const BALL: f64 = 0.5;
/// Distance of the camera from the ball's centre, metres; both are one metre above the ground.
const DISTANCE: f64 = 6.0;

fn ball_on_ground(ball: &str, camera: &str) -> Scene {
    parse(&format!(
        "pathmarch 1\ncamera {{ position 0 1 {DISTANCE}; target 0 1 0; fov 40; {camera} }}\n\
         material \"grey\" {{ diffuse {GROUND} }}\nmaterial \"ball\" {{ diffuse {BALL} }}\n\
         object \"ground\" material=\"grey\" {{ plane }}\nobject \"ball\" material=\"ball\" {{ {ball} }}"
    ))
}

/// Depth and object at a point of the picture, pixels from its top left corner.
fn expected(x: f64, y: f64) -> (f64, u32) {
    let [width, height] = SIZE.map(f64::from);
    let half = 20f64.to_radians().tan();
    let (across, up) = (half * width / height * (2.0 * x / width - 1.0), half * (1.0 - 2.0 * y / height));
    // A ray of length one along the view axis: |(0, 0, DISTANCE) + t (across, up, -1)| = 1.
    let square = across * across + up * up + 1.0;
    let root = DISTANCE * DISTANCE - square * (DISTANCE * DISTANCE - 1.0);
    if root > 0.0 {
        ((DISTANCE - root.sqrt()) / square, 2)
    } else if up < 0.0 {
        (-1.0 / up, 1)
    } else {
        (f64::INFINITY, 0)
    }
}

fn aovs_of_a_ball_on_the_ground_match_the_closed_form() {
    // The same ball, analytic, sphere-traced, and through a wide lens, which has no effect.
    // Sphere tracing ends up to a tenth of a pixel before an edge, and so may hit it from the next pixel: at four positions.
    for (ball, camera, tolerance) in [
        ("sphere 1 { at 0 1 0 }", "", 1e-6),
        ("union { sphere 1 { at 0 1 0 }; sphere 0.001 { at 0 1 0 } }", "", 4.0 / 16.0 * BALL + 1e-6),
        ("sphere 1 { at 0 1 0 }", "lens radius=0.2", 1e-6),
    ] {
        let aovs = render(&ball_on_ground(ball, camera), SIZE);
        let (mut off, mut edges) = (0.0, 0);
        for y in 0..SIZE[1] {
            for x in 0..SIZE[0] {
                let k = (y * SIZE[0] + x) as usize;
                let (column, row) = (f64::from(x), f64::from(y));
                let (depth, object) = expected(column + 0.5, row + 0.5);
                let points = (0..16).map(|point| {
                    expected(column + (f64::from(point % 4) + 0.5) / 4.0, row + (f64::from(point / 4) + 0.5) / 4.0).1
                });
                let points: Vec<u32> = points.collect();
                let albedo = points.iter().map(|&object| [0.0, GROUND, BALL][object as usize]).sum::<f64>() / 16.0;
                let error = (f64::from(aovs.albedo[k][1]) - albedo).abs();
                off += error;
                assert!(error < tolerance || points.iter().any(|&point| point != object), "{x}, {y}: {error}");
                if error > 1e-6 || points.iter().any(|&point| point != object) {
                    edges += 1;
                    continue;
                }
                assert_eq!((aovs.object[k], aovs.material[k]), (object, object), "{x}, {y}");
                let [px, py, pz] = aovs.position[k].map(f64::from);
                let [nx, ny, nz] = aovs.normal[k].map(f64::from);
                match object {
                    0 => {
                        assert_eq!(
                            (aovs.depth[k], aovs.position[k], aovs.normal[k]),
                            (f32::INFINITY, [0.0; 3], [0.0; 3])
                        )
                    }
                    1 => {
                        assert!(py.abs() < 1e-4 * depth, "{py}");
                        assert_eq!(aovs.normal[k], [0.0, 1.0, 0.0]);
                    }
                    _ => {
                        assert!(((px * px + (py - 1.0).powi(2) + pz * pz).sqrt() - 1.0).abs() < 1e-4);
                        assert!(px * nx + (py - 1.0) * ny + pz * nz > 0.99, "{x}, {y}: {:?}", aovs.normal[k]);
                    }
                }
                if object > 0 {
                    // Sphere tracing may be off by a tenth of a pixel.
                    let around = [(-0.1, -0.1), (0.1, -0.1), (-0.1, 0.1), (0.1, 0.1)]
                        .map(|(dx, dy)| expected(column + 0.5 + dx, row + 0.5 + dy).0);
                    let nearest = around.iter().copied().fold(f64::INFINITY, f64::min);
                    let farthest = around.iter().copied().fold(0.0, f64::max);
                    let found = f64::from(aovs.depth[k]);
                    assert!(found > nearest * 0.9999 && found < farthest * 1.0001, "{x}, {y}: {found} for {depth}");
                    assert!((DISTANCE - pz - f64::from(aovs.depth[k])).abs() < 1e-4 * depth);
                }
            }
        }
        println!("{ball}: coverage is off by {:.2} pixels in {edges} of the edge", off / BALL);
        assert!(edges > 50);
        assert!(off / BALL < 0.1 * f64::from(edges), "{off}");
        let middle = aovs.depth.len() / 2;
        assert!((aovs.depth[middle] - 5.0).abs() < 1e-3 && (aovs.position[middle][2] - 1.0).abs() < 1e-3);
    }
}

fn samples_bounces_and_seed_have_no_effect() {
    let scene = ball_on_ground("sphere 1 { at 0 1 0 }", "");
    let settings = Settings { size: SIZE, ..Settings::of(&scene) };
    let again = Settings { samples: 1, first_sample: 9, bounces: 0, seed: 5, ..settings.clone() };
    assert_eq!(aov::render(&scene, &settings).expect("renders"), aov::render(&scene, &again).expect("renders"));
    let empty = Settings { size: [0, 4], ..settings };
    assert!(matches!(aov::render(&scene, &empty), Err(RenderError::Settings(_))));
}

fn normals_face_a_camera_inside() {
    for ball in ["sphere 2", "union { sphere 2; sphere 0.001 { at 1 1 1 } }"] {
        let scene = parse(&format!(
            "pathmarch 1\ncamera {{ position 0 0 1; target 0 0 0; fov 90 }}\nobject \"ball\" {{ {ball} }}"
        ));
        let aovs = render(&scene, [16, 16]);
        for (p, n) in aovs.position.iter().zip(&aovs.normal) {
            let cosine = -(p[0] * n[0] + p[1] * n[1] + p[2] * n[2]) / 2.0;
            assert!(cosine > 0.99, "{ball} {p:?} {n:?}");
        }
    }
}

fn lamps_show_their_clipped_radiance_on_the_side_that_emits() {
    for (facing, expected) in [(1, [1.0, 0.5, 0.25]), (-1, [0.0; 3])] {
        let scene = parse(&format!(
            "pathmarch 1\ncamera {{ position 0 0 5; target 0 0 0; fov 10 }}\nmaterial \"lamp\" {{ emit 2 0.5 0.25 }}\n\
             object \"lamp\" material=\"lamp\" {{ rect 10 10 {{ normal 0 0 {facing} }} }}"
        ));
        let aovs = render(&scene, [4, 4]);
        assert_eq!(aovs.albedo, [expected; 16]);
        assert!(aovs.normal.iter().all(|normal| normal[2] > 0.9999));
    }
}

fn blends_are_blended_and_the_heavier_material_names_them() {
    let scene = parse(
        "pathmarch 1\ncamera { position 0 0 5; target 0 0 0; fov 20 }\n\
         material \"black\" { diffuse 0 }\nmaterial \"white\" { diffuse 1 }\n\
         object \"pair\" { union smooth=2 { sphere 1 material=\"black\" { at -0.7 0 0 }; sphere 1 material=\"white\" { at 0.7 0 0 } } }",
    );
    let aovs = render(&scene, [64, 48]);
    let row = 24 * 64..25 * 64;
    let (white, material) = (aovs.albedo[row.clone()].iter().map(|albedo| albedo[0]), &aovs.material[row]);
    let white: Vec<f32> = white.collect();
    assert!(white.is_sorted(), "{white:?}");
    for k in 0..64 {
        assert!((white[k] + white[63 - k] - 1.0).abs() < 0.07, "as black on the left as white on the right");
        assert_eq!(material[k], if k < 32 { 1 } else { 2 });
    }
    assert!(white.iter().filter(|white| (0.1..0.9).contains(*white)).count() > 10, "{white:?}");
}

fn layers_become_channels() {
    let scene = ball_on_ground("sphere 1 { at 0 1 0 }", "");
    let aovs = render(&scene, [3, 1]);
    let mut film = Film::new(3, 1);
    film.samples = 4;
    film.count_rejected(1, 3);
    let channels: Vec<_> = Layer::ALL.iter().flat_map(|layer| layer.channels(&aovs, &film)).collect();
    let names: Vec<_> = channels.iter().map(|channel| channel.name.as_str()).collect();
    let expected = "albedo.R albedo.G albedo.B normal.X normal.Y normal.Z depth.Z position.X position.Y position.Z \
                    objectId.X materialId.X sampleCount.X";
    assert_eq!(names.join(" "), expected);
    assert_eq!(channels[4].values, ChannelValues::F32(aovs.normal.iter().map(|normal| normal[1]).collect()));
    assert_eq!(channels[10].values, ChannelValues::U32(aovs.object.clone()));
    assert_eq!(channels[12].values, ChannelValues::U32(vec![4, 1, 4]));
    for layer in Layer::ALL {
        assert_eq!(Layer::from_name(layer.name()), Some(layer));
    }
}

tests! {
    plain: [
        aovs_of_a_ball_on_the_ground_match_the_closed_form,
        samples_bounces_and_seed_have_no_effect,
        normals_face_a_camera_inside,
        lamps_show_their_clipped_radiance_on_the_side_that_emits,
        blends_are_blended_and_the_heavier_material_names_them,
        layers_become_channels,
    ],
}
