//! Priorities and thin glass in the scene language: values, mistakes and warnings.

use crate::parsed::{mistakes, scene, warnings};
use pathmarch_scene::Medium;
use pathmarch_scene::materials::Dielectric;

#[test]
fn dielectrics_have_the_values_of_the_text() {
    let read = scene(
        "material \"a\" { glass 1; ior 1.33; priority -3 }\nmaterial \"b\" { principled 1; transmission 1; priority \"1 + 2\" }\n\
         material \"c\" { glass 0.5; thin #true }\nmaterial \"d\" { glass 0.5; thin #false; absorb 2 }\n\
         material \"e\" { diffuse 1 }\nmaterial \"f\" { glass 1; ior 1.6; abbe 30 }",
    );
    let dielectric = |index: usize| read.materials[index].dielectric();
    assert_eq!(dielectric(0), Dielectric { ior: 1.33, priority: -3, ..Dielectric::VACUUM });
    assert_eq!(dielectric(1), Dielectric { ior: 1.5, priority: 3, ..Dielectric::VACUUM });
    assert_eq!(dielectric(2), Dielectric { ior: 1.5, is_thin: true, ..Dielectric::VACUUM });
    assert_eq!(dielectric(3), Dielectric { ior: 1.5, ..Dielectric::VACUUM });
    assert_eq!(read.materials[3].medium(), Medium { absorption: [2.0; 3], ..Medium::VACUUM });
    assert_eq!(dielectric(4), Dielectric::VACUUM);
    assert!((dielectric(5).index_difference - 0.02).abs() < 1e-6);
}

#[test]
fn bad_dielectrics_are_mistakes() {
    for text in [
        "material \"a\" { glass 1; priority 101 }",
        "material \"a\" { glass 1; priority -101 }",
        "material \"a\" { glass 1; priority 1.5 }",
        "material \"a\" { glass 1; priority { fbm } }",
        "material \"a\" { glass 1; priority \"high\" }",
        "material \"a\" { glass 1; priority 1; priority 2 }",
        "material \"a\" { glass 1; thin 1 }",
        "material \"a\" { glass 1; thin }",
        "material \"a\" { glass 1; thin \"yes\" }",
        "material \"a\" { glass 1; thin #true #true }",
        "material \"a\" { principled 1; transmission 1; thin #true }",
        "material \"a\" { medium 1; priority 1 }",
        "material \"a\" { diffuse 1; priority 1 }",
        "material \"a\" { glass 1; ior 0.75 }",
    ] {
        assert!(!mistakes(text).is_empty(), "{text}");
    }
    assert_eq!(
        mistakes("material \"a\" { glass 1; priority 101 }"),
        ["`priority` must be a whole number from -100 to 100."]
    );
    assert_eq!(mistakes("material \"a\" { glass 1; thin 1 }"), ["`thin` must be #true or #false."]);
    let bubble = "`ior` must be from 1 to 10; a bubble has 1, and a `priority` above its surroundings.";
    assert_eq!(mistakes("material \"a\" { glass 1; ior 0.75 }"), [bubble]);
    assert_eq!(mistakes("material \"a\" { glass 1; ior 11 }"), ["`ior` must be from 1 to 10."]);
}

#[test]
fn parameters_without_effect_are_warned_of() {
    let warned = |text: &str| warnings(text, "no_effect").len();
    assert_eq!(warned("material \"a\" { principled 1; priority 2 }"), 1);
    assert_eq!(warned("material \"a\" { principled 1; transmission 0.1; priority 2 }"), 0);
    assert_eq!(warned("material \"a\" { principled 1; priority 0 }"), 0);
    for parameter in [
        "roughness 0.2",
        "roughness { fbm }",
        "abbe 30",
        "absorb 1",
        "scatter 1",
        "anisotropy 0.5",
        "glow 1",
        "priority 1",
    ] {
        assert_eq!(warned(&format!("material \"a\" {{ glass 1; thin #true; {parameter} }}")), 1, "{parameter}");
        assert_eq!(warned(&format!("material \"a\" {{ glass 1; {parameter} }}")), 0, "{parameter}");
    }
    assert_eq!(warned("material \"a\" { glass 1; thin #true; roughness 0; absorb 0 }"), 0);
    let sheet = "object \"pane\" material=\"a\" { rect 1 1 }";
    assert_eq!(warnings(&format!("material \"a\" {{ glass 1; thin #true }}\n{sheet}"), "clear_sheet"), [""; 0]);
    assert_eq!(warnings(&format!("material \"a\" {{ glass 1 }}\n{sheet}"), "clear_sheet").len(), 1);
}
