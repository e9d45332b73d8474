//! Media in the scene language: values, mistakes and warnings.

use crate::parsed::{mistakes, scene, warnings};
use pathmarch_scene::Medium;

#[test]
fn media_have_the_values_of_the_text() {
    let read = scene(
        "fog { scatter 0.1 0.2 0.3; absorb 0.02; anisotropy 0.5; glow 1 0 0 }\n\
         material \"smoke\" { medium 2; absorb 0.1 0.2 0.3; anisotropy -0.3; glow 4 }\n\
         material \"milk\" { glass 1; scatter 80; absorb 1 2 3; anisotropy 0.9 }\n\
         material \"skin\" { principled 0.9; transmission 1; scatter 50 40 30; glow 0 1 0 }\nmaterial \"white\" { diffuse 0.8 }",
    );
    let fog = Medium { scattering: [0.1, 0.2, 0.3], absorption: [0.02; 3], anisotropy: 0.5, emission: [1.0, 0.0, 0.0] };
    assert_eq!(read.fog, fog);
    let medium = |index: usize| read.materials[index].medium();
    let smoke = Medium { scattering: [2.0; 3], absorption: [0.1, 0.2, 0.3], anisotropy: -0.3, emission: [4.0; 3] };
    assert_eq!(medium(0), smoke);
    assert!(!read.materials[0].kind.has_surface && read.materials[0].transmits());
    assert_eq!(
        medium(1),
        Medium { scattering: [80.0; 3], absorption: [1.0, 2.0, 3.0], anisotropy: 0.9, ..Medium::VACUUM }
    );
    assert_eq!(medium(2), Medium { scattering: [50.0, 40.0, 30.0], emission: [0.0, 1.0, 0.0], ..Medium::VACUUM });
    assert_eq!(medium(3), Medium::VACUUM);
    assert_eq!(scene("sky 1").fog, Medium::VACUUM);
}

#[test]
fn bad_media_are_mistakes() {
    for text in [
        "fog { scatter -1 }",
        "fog { scatter 1; anisotropy 1 }",
        "fog { scatter 1; anisotropy -1 }",
        "fog { glow nan }",
        "fog { scater 1 }",
        "fog { scatter 1 }\nfog { scatter 2 }",
        "fog 1",
        "material \"a\" { medium -1 }",
        "material \"a\" { medium 1; anisotropy 1.5 }",
        "material \"a\" { glass 1; scatter -2 }",
        "material \"a\" { medium { fbm } }",
        "material \"a\" { diffuse 1; scatter 2 }",
    ] {
        let messages = mistakes(text);
        println!("{text}: {messages:?}");
        assert!(!messages.is_empty());
    }
    assert!(mistakes("fog { scatter 1; anisotropy 1 }")[0].contains("anisotropy"));
}

#[test]
fn light_that_does_not_pass_endless_fog_is_a_warning() {
    let ball = "object \"ball\" { sphere 1 }\n";
    for (text, count) in [
        ("sky 1\nfog { scatter 0.1 }", 1),
        ("sun { direction 0 1 0; irradiance 1 }\nfog { absorb 0.1 }", 1),
        ("point { at 0 4 0; intensity 1 }\nfog { scatter 0.1 }", 0),
        ("sky 1\nmaterial \"mist\" { medium 0.1 }\nobject \"mist\" material=\"mist\" { sphere 9 }", 0),
        ("sky 1\nfog { scatter 0; glow 0 }", 0),
    ] {
        assert_eq!(warnings(&format!("{ball}{text}"), "endless_fog").len(), count, "{text}");
    }
    // Without any light the picture is black; fog that glows lights it.
    assert_eq!(warnings(&format!("{ball}fog {{ scatter 0.1 }}"), "no_light").len(), 1);
    assert_eq!(warnings(&format!("{ball}fog {{ absorb 0.1; glow 1 }}"), "no_light").len(), 0);
    assert_eq!(warnings("fog { absorb 0.1 0.1 0; glow 1 }", "endless_glow").len(), 1);
    assert_eq!(warnings("fog { absorb 0.1 0.1 0; glow 1 1 0 }", "endless_glow").len(), 0);
}

#[test]
fn too_few_bounces_for_a_medium_are_a_warning() {
    let milk = |bounces: u32, inside: &str| {
        format!(
            "sky 1\nrender {{ bounces {bounces} }}\nmaterial \"milk\" {{ {inside} }}\n\
             object \"cup\" material=\"milk\" {{ sphere 0.5 }}"
        )
    };
    assert_eq!(warnings(&milk(4, "glass 1; scatter 20"), "few_bounces").len(), 1);
    assert_eq!(warnings(&milk(200, "glass 1; scatter 20"), "few_bounces").len(), 0);
    // What absorbs ends paths early; thin media scatter once.
    assert_eq!(warnings(&milk(8, "glass 1; scatter 20; absorb 20"), "few_bounces").len(), 0);
    assert_eq!(warnings(&milk(4, "medium 1"), "few_bounces").len(), 0);
}

/// Light without size shines through the boundary of a medium, but not through glass.
#[test]
fn boundaries_of_media_do_not_hide_lights() {
    let text = |inside: &str| {
        format!(
            "point {{ at 0 3 0; intensity 1 }}\nmaterial \"it\" {{ {inside} }}\nobject \"it\" material=\"it\" {{ sphere 1 }}"
        )
    };
    assert_eq!(warnings(&text("glass 1"), "lost_light").len(), 1);
    assert_eq!(warnings(&text("medium 1"), "lost_light").len(), 0);
}
