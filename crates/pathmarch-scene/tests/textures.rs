//! Every texture: from 0 to 1 and of a sensible spread, without jumps where it promises none, moved as it is placed; and what
//! a material's parameters make of them.

use crate::random::Random;
use glam::Vec3;
use pathmarch_field::Placement;
use pathmarch_field::number::Vec3 as FieldVec3;
use pathmarch_scene::materials::{TextureMapping, Texturing, kinds};
use pathmarch_scene::textures::{
    self, MeshAttributes, Pattern, Place, Ramp, Spot, Texture, TextureKind, TextureParameters,
};
use pathmarch_scene::{Material, Scene};
use wide::f32x8;

fn spot(p: Vec3) -> Spot {
    Spot { p, normal: Vec3::Z, footprint: 0.0, attributes: MeshAttributes::default() }
}

fn defaults(kind: &TextureKind) -> TextureParameters {
    std::array::from_fn(|k| kind.params.get(k).map_or(0.0, |param| param.default))
}

fn texture(kind: &'static TextureKind, placement: Placement) -> Texture {
    Texture { pattern: Pattern::Computed { kind, parameters: defaults(kind) }, pose: placement.pose() }
}

#[test]
fn values_are_between_0_and_1_and_spread_over_them() {
    for kind in textures::kinds() {
        let texture = texture(kind, Placement::default());
        let mut random = Random(1);
        let n = 40_000;
        let values: Vec<f32> = (0..n).map(|_| texture.value(&spot(random.point(5.0)))).collect();
        let mean = values.iter().sum::<f32>() / n as f32;
        let deviation = (values.iter().map(|v| (v - mean).powi(2)).sum::<f32>() / n as f32).sqrt();
        println!("{}: {mean} ± {deviation}", kind.name);
        assert!(values.iter().all(|v| (0.0..=1.0).contains(v)), "{}", kind.name);
        assert!((0.1..0.95).contains(&mean), "{}: a mean of {mean}", kind.name);
        assert!(deviation > 0.1, "{}: a deviation of {deviation}", kind.name);
        // Uncut but for few.
        let cut = values.iter().filter(|v| **v <= 0.0 || **v >= 1.0).count() as f32 / n as f32;
        let has_flats = ["checker", "brick", "cracks", "voronoi"].contains(&kind.name);
        assert!(has_flats || cut < 0.05, "{}: {cut} are cut", kind.name);
        // Mirrored and far points have values, too.
        for p in [Vec3::splat(-1e6), Vec3::splat(1e30), Vec3::new(0.0, 1e12, -1e12), Vec3::ZERO] {
            assert!(texture.value(&spot(p)).is_finite(), "{} at {p}", kind.name);
        }
    }
}

#[test]
fn eight_spots_have_the_values_of_each() {
    let turned = Placement {
        at: Some([0.3, -0.2, 1.0]),
        rotate: Some([10.0, 40.0, 0.0]),
        scale: Some(2.0),
        ..Placement::default()
    };
    let ramps = [
        Ramp::even(vec![[0.1, 0.2, 0.3], [0.9, 0.5, 0.1]]),
        Ramp::even(vec![[0.0; 3], [1.0, 0.5, 0.2], [0.3; 3]]),
        Ramp { colours: vec![[0.0; 3], [1.0; 3]], positions: Some(vec![0.4, 0.6]) },
    ];
    let mut random = Random(4);
    for (kind, placement) in textures::kinds().iter().flat_map(|kind| [(kind, Placement::default()), (kind, turned)]) {
        let texture = texture(kind, placement);
        let spot = Spot { normal: random.point(1.0).normalize(), ..spot(Vec3::ZERO) };
        for reach in [0.2, 5.0, 1e6] {
            let points: [Vec3; 8] = std::array::from_fn(|_| random.point(reach));
            let [x, y, z] = [0, 1, 2].map(|k| f32x8::from(points.map(|p| p[k])));
            let values = texture.values_around(&spot, FieldVec3::new(x, y, z));
            let colours = texture.colours_around(&spot, FieldVec3::new(x, y, z));
            let spots = points.map(|p| Spot { p, ..spot });
            let together = texture.values(spots.each_ref());
            let of_ramps = ramps.each_ref().map(|ramp| ramp.colours(values));
            for (lane, p) in points.into_iter().enumerate() {
                let at = Spot { p, ..spot };
                let value = texture.value(&at);
                assert!((values.to_array()[lane] - value).abs() < 1e-4, "{} at {p}: {values} and {value}", kind.name);
                assert!((colours.y.to_array()[lane] - texture.colour(&at).y).abs() < 1e-4, "{} at {p}", kind.name);
                assert_eq!(together.to_array()[lane], value, "{} at {p}", kind.name);
                for (ramp, colours) in ramps.iter().zip(of_ramps) {
                    assert!((colours.z.to_array()[lane] - ramp.colour(value)[2]).abs() < 1e-3, "{} at {p}", kind.name);
                }
            }
        }
    }
}

#[test]
fn those_without_edges_do_not_jump() {
    for kind in textures::kinds().iter().filter(|kind| !["checker", "cells"].contains(&kind.name)) {
        let texture = texture(kind, Placement::default());
        let step = 1e-3 * (kind.step)(&defaults(kind));
        let mut random = Random(2);
        let mut worst = 0.0_f32;
        for _ in 0..40_000 {
            let p = random.point(1.0);
            let towards = random.point(1.0).normalize() * step;
            worst = worst.max((texture.value(&spot(p + towards)) - texture.value(&spot(p))).abs());
        }
        println!("{}: {worst}", kind.name);
        assert!(worst < 0.02, "{}: {worst} over {step} m", kind.name);
    }
}

#[test]
fn a_seed_is_another_one() {
    for kind in textures::kinds() {
        let Some(seed) = kind.params.iter().position(|param| &*param.name == "seed") else { continue };
        let mut random = Random(3);
        let differing = (0..1000).filter(|_| {
            let at = Place { p: random.point(2.0).into(), normal: Vec3::Z.into() };
            let mut numbers = defaults(kind);
            let first = (kind.value)(&at, &numbers);
            numbers[seed] = 12.0;
            (first - (kind.value)(&at, &numbers)).abs() > 1e-3
        });
        // Bricks differ by their own values alone, most of the cracks are none.
        let differing = differing.count();
        assert!(differing > 200, "{}: {differing} of 1000", kind.name);
    }
}

#[test]
fn a_checker_is_exact_and_whole_on_its_lattice() {
    let kind = textures::kind("checker").expect("registered");
    let texture = Texture {
        pattern: Pattern::Computed { kind, parameters: [0.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0] },
        pose: Placement::default().pose(),
    };
    for (x, y, z) in (-3..3).flat_map(|x| (-3..3).flat_map(move |y| (-3..3).map(move |z| (x, y, z)))) {
        let corner = Vec3::new(x as f32, y as f32, z as f32) * 0.5;
        let expected = i32::rem_euclid(x + y + z, 2) as f32;
        for inside in [0.01, 0.25, 0.49] {
            assert_eq!(texture.value(&spot(corner + inside)), expected, "{corner} + {inside}");
        }
        // A face in the lattice is of one side, whatever rounding does.
        let above = texture.value(&spot(corner + Vec3::new(0.25, 1e-6, 0.25)));
        let below = texture.value(&spot(corner + Vec3::new(0.25, -1e-6, 0.25)));
        assert_eq!(above, below, "at {corner}");
    }
}

#[test]
fn a_texture_is_where_it_is_placed() {
    let placement = Placement {
        at: Some([0.3, -0.2, 1.0]),
        rotate: Some([0.0, 90.0, 0.0]),
        scale: Some(2.0),
        ..Placement::default()
    };
    for kind in textures::kinds().iter().filter(|kind| kind.name != "brick") {
        let (plain, placed) = (texture(kind, Placement::default()), texture(kind, placement));
        let mut random = Random(4);
        for _ in 0..200 {
            let p = random.point(0.5);
            // A right-handed quarter turn about y takes z to x and x to -z.
            let moved = Vec3::new(0.3, -0.2, 1.0) + 2.0 * Vec3::new(p.z, p.y, -p.x);
            let (a, b) = (plain.value(&spot(p)), placed.value(&spot(moved)));
            assert!((a - b).abs() < 2e-2 || ["checker", "cells"].contains(&kind.name), "{} at {p}: {a} {b}", kind.name);
        }
    }
}

/// What a texture may stand for says truly what the numbers of its material are.
#[test]
fn parameters_that_may_be_textured_keep_their_numbers_apart() {
    for kind in kinds() {
        let Some(bsdf) = kind.bsdf else {
            assert!(kind.params.iter().all(|param| param.texturing == Texturing::None));
            continue;
        };
        let plain: Vec<[f32; 3]> = kind.params.iter().map(|param| param.default_value()).collect();
        let numbers = (bsdf.pack)(&plain);
        let mut taken = [None; 32];
        for (index, param) in kind.params.iter().enumerate() {
            let changed = |value: [f32; 3]| {
                let mut values = plain.clone();
                values[index] = value;
                (bsdf.pack)(&values)
            };
            let places: Vec<usize> = match param.texturing {
                Texturing::None => continue,
                Texturing::Colour(place) => {
                    let with = changed([0.125, 0.25, 0.375]);
                    assert_eq!(with[place..place + 3], [0.125, 0.25, 0.375], "{} {}", kind.name, param.name());
                    assert!((0..32).all(|k| with[k] == numbers[k] || (place..place + 3).contains(&k)), "{}", kind.name);
                    assert_eq!(place % 4, 0, "a vector of its own");
                    (place..place + 3).collect()
                }
                Texturing::Packed => {
                    let all: Vec<_> = [0.0, 0.3, 0.7, 1.0].map(|value| changed([value, 0.0, 0.0])).to_vec();
                    (0..32).filter(|&k| all.iter().any(|with| with[k] != numbers[k])).collect()
                }
            };
            for place in places {
                assert_eq!(taken[place].replace(param.name()), None, "{}: number {place}", kind.name);
            }
        }
    }
}

fn material(text: &str) -> Material {
    let scene = format!(
        "pathmarch 1\ncamera {{ position 0 1 5; target 0 1 0 }}\nsky 1\nmaterial \"it\" {{ {text} }}\nobject \"o\" material=\"it\" {{ sphere }}"
    );
    Scene::parse("scene.kdl", &scene).unwrap_or_else(|error| panic!("{text}: {error:?}")).materials[0].clone()
}

#[test]
fn every_way_to_write_a_texture_is_read() {
    let it = material(
        "principled { marble size=2 octaves=3 { colour 1 0.5 0; colour \"#000\"; at 1 2 3; scale 2 } }; roughness { fbm from=0.6 to=0.1 }; \
         metallic { checker }; bump { cracks height=-0.01 { rotate 0 90 0 } }",
    );
    let names: Vec<_> = it.textured.iter().map(|painted| it.kind.params[painted.param].name()).collect();
    assert_eq!(names, ["colour", "metallic", "roughness"]);
    assert_eq!(it.textured[0].mapping, TextureMapping::Ramp(Ramp::even(vec![[1.0, 0.5, 0.0], [0.0; 3]])));
    assert_eq!(it.textured[2].mapping, TextureMapping::Range([0.6, 0.1]));
    assert!((it.value("roughness").expect("a parameter")[0] - 0.35).abs() < 1e-6);
    assert_eq!(it.albedo(), [0.5, 0.25, 0.0]);
    assert_eq!((it.textured[0].texture.pose.at, it.textured[0].texture.pose.scale), ([1.0, 2.0, 3.0], 2.0));
    assert_eq!(it.bump.expect("a relief").height, -0.01);
    for kind in textures::kinds() {
        let all: Vec<String> = kind.params.iter().map(|param| format!("{}={}", param.name, param.default)).collect();
        material(&format!("diffuse {{ {} {} }}", kind.name, all.join(" ")));
    }
}

#[test]
fn colours_of_a_ramp_have_positions_where_they_are_given() {
    let positions = |colours: &str| {
        let it = material(&format!("diffuse {{ fbm {{ {colours} }} }}"));
        match &it.textured[0].mapping {
            TextureMapping::Ramp(ramp) => ramp.positions.clone(),
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(positions("colour 0; colour 1"), None);
    assert_eq!(positions("colour 0; colour \"#fff\" at=0.5"), Some(vec![0.0, 0.5]));
    assert_eq!(positions("colour 0 at=0.25; colour 1"), Some(vec![0.25, 1.0]));
    assert_eq!(
        positions("colour 0; colour 1; colour 0 at=0.5; colour 1 0 0 at=0.5; colour 1; colour 1; colour 0.5"),
        Some(vec![0.0, 0.25, 0.5, 0.5, 0.5 + 0.5 / 3.0, 0.5 + 1.0 / 3.0, 1.0])
    );
    assert_eq!(positions("colour 0.3 at=0.7"), Some(vec![0.7]));
    // One that falls counts as the last one, as in CSS.
    assert_eq!(positions("colour 0; colour 1 at=0.5; colour 0 at=0.25"), Some(vec![0.0, 0.5, 0.5]));
    let trap =
        material("diffuse 1; orbit-trap { colour 0; colour 1 at=\"1/4\"; colour 0 }").orbit_trap.expect("a trap");
    assert_eq!(trap.ramp.positions, Some(vec![0.0, 0.25, 1.0]));
}
