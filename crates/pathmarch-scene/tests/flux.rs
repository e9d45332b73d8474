//! Objects that emit a luminous flux.

use pathmarch_scene::Scene;
use pathmarch_scene::light::LUMENS_OF_WATT;
use std::f64::consts::PI;

/// Luminance of the radiance of each object's leaves.
fn radiances(text: &str) -> Vec<f64> {
    let text = format!("pathmarch 1\n{text}\ncamera {{ position 0 1 5; target 0 1 0 }}\nsky 1\n");
    let scene = Scene::parse("scene.kdl", &text).unwrap_or_else(|error| panic!("{text}: {error:?}"));
    let leaves = scene.field.leaves().iter();
    leaves
        .map(|leaf| {
            let [r, g, b] = scene.materials[leaf.tag as usize].emission().map(f64::from);
            0.2126 * r + 0.7152 * g + 0.0722 * b
        })
        .collect()
}

/// Lumens that a surface emits.
fn lumens(radiance: f64, area: f64) -> f64 {
    radiance * area * PI * f64::from(LUMENS_OF_WATT)
}

#[test]
fn the_flux_of_a_lamp_is_the_one_that_is_given() {
    let lamp = "material \"lamp\" { emit 3 2 1 }\n";
    for (shape, area, tolerance) in [
        ("sphere 0.03", 4.0 * PI * 0.03 * 0.03, 1e-5),
        ("sphere 0.03 { scale 2; at 5 5 5 }", 4.0 * PI * 0.06 * 0.06, 1e-5),
        ("rect 2 0.5", 1.0, 1e-5),
        ("sphere 0.1; sphere 0.2 { at 1 0 0 }", 4.0 * PI * 0.05, 1e-5),
        ("union { box 1; box 1 { at 0.5 0 0 } }", 8.0, 1e-2),
        ("ellipsoid 1 1 1", 4.0 * PI, 1e-2),
        ("repeat 3 0 0 count-x=2 { box 1 }", 12.0, 1e-2),
    ] {
        let found = radiances(&format!("{lamp}object \"it\" material=\"lamp\" lumen=800 {{ {shape} }}"));
        assert!(found.windows(2).all(|pair| pair[0] == pair[1]), "{found:?}");
        let flux = lumens(found[0], area);
        println!("{shape}: {flux}");
        assert!((flux - 800.0).abs() < 800.0 * tolerance, "{shape}: {flux} lm");
    }
}

#[test]
fn other_objects_and_surfaces_keep_their_materials() {
    let text = "material \"lamp\" { emit 2 }
material \"glow\" { principled 0.5; emission 4 }
material \"socket\" { diffuse 0.5 }
object \"plain\" material=\"lamp\" { sphere 1 { at -5 0 0 } }
object \"bulb\" material=\"lamp\" lumen=500 { sphere 1; sphere 1 material=\"glow\" { at 5 0 0 }; cylinder 1 1 material=\"socket\" { at 0 -3 0 } }";
    let found = radiances(text);
    assert_eq!((found[0], found[3]), (2.0, 0.0));
    // Materials of the object keep their ratio.
    assert!((found[2] - 2.0 * found[1]).abs() < 1e-6, "{found:?}");
    let flux = lumens(found[1] + found[2], 4.0 * PI);
    assert!((flux - 500.0).abs() < 0.05, "{flux} lm");
}

#[test]
fn lengths_are_in_the_unit_of_the_scene() {
    let lamp = "material \"lamp\" { emit 1 }\nobject \"it\" material=\"lamp\" lumen=800";
    let [metres, centimetres] = ["m", "cm"].map(|unit| {
        let radius = if unit == "m" { 0.03 } else { 3.0 };
        radiances(&format!("unit \"{unit}\"\n{lamp} {{ sphere {radius} }}"))[0]
    });
    assert!((metres - centimetres).abs() < 1e-5 * metres, "{metres} {centimetres}");
}
