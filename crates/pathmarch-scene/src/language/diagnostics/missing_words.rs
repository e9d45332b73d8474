//! Words of other programs that the scene language does not have, with what to do instead.

/// A word, and what to do instead of it.
pub(crate) type MissingWord = (&'static str, &'static str);

const BOOLEAN: &str = "Use `union`, `subtract` or `intersect`; `smooth=` blends them.";
const EMITTER: &str = "Give a `rect`, `disc` or `sphere` a material that emits: material \"lamp\" { emit 8 }.";
const EMISSION: &str =
    "Use `emit` for a material that only emits: emit 8; and `emission` beside another: diffuse 0.5; emission 2.";
const VOLUME: &str =
    "Use `fog { scatter 0.1 }` for the whole scene, or a material without a surface: material \"smoke\" { medium 2 }.";
const NORMAL_MAP: &str = "Use `bump` with a texture: bump { fbm size=0.05 height=0.005 }.";
const KEYFRAMES: &str = "Use a formula of the time t in seconds: sphere \"0.5 + 0.1 * sin(t)\".";
const SPLINE: &str = "Use `curve`, in `extrude` or `revolve`.";
const DECAL: &str = "Use `decal \"logo.png\" size=0.1 { at x y z }` of a material.";
const RAMP: &str =
    "Give a texture colours, with positions if need be: fbm { colour 0; colour 1 0.5 0 at=0.3; colour 1 }.";
const SCATTERING: &str = "Use `scatter` of a `glass` or `principled` material: glass 1; scatter 60 50 40.";

/// Words in use elsewhere, in alphabetical order.
pub(crate) const MISSING_WORDS: &[MissingWord] = &[
    ("absorption", "Use `absorb r g b` of a material that transmits, or of `fog`."),
    ("albedo", "Use `diffuse r g b` or the colour of a `principled` material."),
    ("aperture", "Use `lens radius=0.02 focus=3` of a camera."),
    ("area", EMITTER),
    ("arealight", EMITTER),
    ("array", "Use `repeat`, or `polar` around an axis."),
    ("background", "Use `sky`: one radiance, a gradient, a day or a picture."),
    ("basecolor", "Write the colour after `principled`: principled 0.8 0.1 0.1."),
    ("bevel", "Use `round`, or `smooth=` of an operator."),
    ("bezier", SPLINE),
    ("boolean", BOOLEAN),
    ("clearcoat", "Use `coat` of a `principled` material."),
    ("code", "Write `glsl` or `wgsl` before the code of a `field`."),
    ("conductor", "Use `metal`."),
    ("cube", "Use `box`."),
    ("density", VOLUME),
    ("depthoffield", "Use `lens radius=0.02 focus=3` of a camera."),
    ("dielectric", "Use `glass`, or `principled` for opaque ones."),
    ("difference", "Use `subtract`: its first child minus all the others."),
    ("directional", "Use `sun { direction x y z; irradiance r g b }`."),
    ("displacement", "Use `displace` for the shape, or `bump` of a material for its look."),
    ("dof", "Use `lens radius=0.02 focus=3` of a camera."),
    ("emission", EMISSION),
    ("emissive", EMISSION),
    ("environment", "Use a sky with a picture: sky \"studio.hdr\"."),
    ("envmap", "Use a sky with a picture: sky \"studio.hdr\"."),
    ("eta", "Use `ior`."),
    ("falloff", "Use `blend` of a `spot`."),
    ("fur", "Not supported yet: there are no hairs."),
    ("fuzz", "Not supported yet: there is no sheen."),
    ("glossy", "Use `principled` with a small `roughness`."),
    ("gradient", RAMP),
    ("ground", "Use `object \"floor\" { plane }`."),
    ("group", "Use `union`, which takes `at`, `rotate` and `scale`."),
    ("hair", "Not supported yet: there are no hairs."),
    ("hdri", "Use a sky with a picture: sky \"studio.hdr\"."),
    ("ies", "Not supported yet: lights have no profiles."),
    ("instance", "Declare a `shape` and use it by its name."),
    ("keyframe", KEYFRAMES),
    ("keyframes", KEYFRAMES),
    ("label", DECAL),
    ("lambert", "Use `diffuse`."),
    ("lamp", EMITTER),
    ("lathe", "Use `revolve` around a `curve`."),
    ("light", "Use `point`, `spot`, `sun`, `sky`, or an object with a material that emits."),
    ("lights", "Use `point`, `spot`, `sun`, `sky`, or an object with a material that emits."),
    ("logo", DECAL),
    ("lookat", "Use `target x y z` of a camera."),
    ("nodes", "Write textures in the braces of a parameter: diffuse { wood }."),
    ("normalmap", NORMAL_MAP),
    ("offset", "Use `round`, which adds to the distance, or `shell`."),
    ("opacity", "Not supported: use `glass` for clear solids, or `subtract` for holes."),
    ("orthographic", "Not supported yet: use a small `fov` from far away."),
    ("plastic", "Use `principled` with a `roughness`."),
    ("pointlight", "Use `point { at x y z; intensity r g b }`."),
    ("quad", "Use `rect`."),
    ("ramp", RAMP),
    ("reflectivity", "Use `metal`, or `metallic` of a `principled` material."),
    ("rotation", "Use `rotate x y z`, in degrees."),
    ("scattering", SCATTERING),
    ("sdf", "Use `field` for a distance function in WGSL."),
    ("shader", "Write the code in a `field`: field \"name\" { bounds 4; glsl \"float map(vec3 p) { … }\" }."),
    ("sheen", "Not supported yet: there is no sheen."),
    ("shininess", "Use `roughness`: 0 is a mirror."),
    ("skybox", "Use a sky with a picture: sky \"studio.hdr\"."),
    ("smoke", VOLUME),
    ("specular", "Use `metal` for conductors, or `ior` of a `principled` material."),
    ("spline", SPLINE),
    ("spotlight", "Use `spot { at x y z; target x y z; intensity r g b }`."),
    ("sss", SCATTERING),
    ("sticker", DECAL),
    ("stop", RAMP),
    ("subsurface", SCATTERING),
    ("svg", "Use `path`."),
    ("texture", "Write a texture in the braces of a parameter: diffuse { wood }."),
    ("transform", "Use `at`, `rotate` and `scale` in the braces of the shape."),
    ("translate", "Use `at x y z`."),
    ("translation", "Use `at x y z`."),
    ("transparent", "Use `glass`."),
    ("tube", "Use `subtract` of two cylinders, or `shell`."),
    ("units", "Use `unit \"cm\"` at the top of the file."),
    ("velvet", "Not supported yet: there is no sheen."),
    ("volume", VOLUME),
    ("wall", "Use `box`."),
];

/// Advice for a word that is spelt like this, whatever its case and the signs in it.
pub(crate) fn advice(word: &str) -> Option<&'static str> {
    let letters =
        |word: &str| -> String { word.chars().filter(char::is_ascii_alphanumeric).collect::<String>().to_lowercase() };
    let wanted = letters(word);
    MISSING_WORDS.iter().find(|(word, _)| letters(word) == wanted).map(|(_, advice)| *advice)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::language::keywords::{TOP, solids};
    use crate::{materials, settings, textures};

    #[test]
    fn words_are_sorted_and_missing() {
        assert!(MISSING_WORDS.is_sorted_by_key(|(word, _)| word));
        for (word, advice) in MISSING_WORDS {
            let exists = TOP.contains(word)
                || solids().any(|solid| solid == *word)
                || materials::kind(word).is_some()
                || textures::names().contains(word)
                || settings::RENDER.iter().chain(settings::CAMERA).any(|setting| setting.name == *word);
            assert!(!exists, "{word} exists");
            assert!(advice.ends_with('.'), "{word}");
        }
    }

    #[test]
    fn case_and_signs_do_not_matter() {
        assert_eq!(advice("Spot_Light"), advice("spotlight"));
        assert!(advice("FUR").is_some_and(|advice| advice.starts_with("Not supported yet")));
        assert_eq!(advice("sphere"), None);
    }
}
