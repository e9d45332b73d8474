//! Every kind of mistake, as people see it. The reports are in `snapshots/`; review changes there word by word.

use miette::{GraphicalReportHandler, GraphicalTheme};
use pathmarch_scene::{Mistake, Scene, SceneError};

/// The report without colours, 100 columns wide.
fn rendered(diagnostic: &dyn miette::Diagnostic) -> String {
    let mut out = String::new();
    let handler = GraphicalReportHandler::new_themed(GraphicalTheme::unicode_nocolor()).with_width(100);
    handler.render_report(&mut out, diagnostic).expect("a string takes all text");
    // miette leaves white space at line ends, which editors like to remove.
    out.lines().map(str::trim_end).collect::<Vec<_>>().join("\n")
}

fn error(text: &str) -> SceneError {
    match Scene::parse("scene.kdl", text) {
        Ok(_) => panic!("this is no mistake: {text}"),
        Err(error) => error,
    }
}

const HEAD: &str = "pathmarch 1\ncamera { position 0 1 5; target 0 1 0 }\nsky 1\n";

fn snapshot(name: &str, diagnostic: &dyn miette::Diagnostic) {
    insta::with_settings!({ omit_expression => true, prepend_module_to_snapshot => false }, {
        insta::assert_snapshot!(name, rendered(diagnostic));
    });
}

/// A snapshot of the report on a whole file, named like the test.
macro_rules! file {
    ($name:ident, $text:expr) => {
        #[test]
        fn $name() {
            snapshot(stringify!($name), &error($text));
        }
    };
}

/// The same for a file that starts with a version, a camera and a sky.
macro_rules! body {
    ($name:ident, $text:expr) => {
        file!($name, &format!("{HEAD}{}", $text));
    };
}

file!(empty_file, "");
file!(no_version, "camera { position 0 1 5; target 0 1 0 }");
file!(version_not_first, "camera { position 0 1 5; target 0 1 0 }\npathmarch 1");
file!(version_newer, "pathmarch 2\nhologram 1 2 3");
file!(version_wrong, "pathmarch \"1\"\npathmarch 1\ncamera { position 0 1 5; target 0 1 0 }");
file!(version_fraction, "pathmarch 1.5\ncamera { position 0 1 5; target 0 1 0 }");
file!(no_camera, "pathmarch 1\nsky 1");

file!(a_shader, "// A ball.\nfloat map(vec3 p) {\n    return length(p) - 1.0;\n}\n");
file!(units, "pathmarch 1\nunit \"ft\"\nunit \"cm\"\ncamera { position 0 1 5; target 0 1 0 }");
body!(
    spots,
    "spot { at 0 1 0 }
spot { at 0 1 0; target 0 1 0; intensity 1 }
spot { at 0 1 0; target 0 0 0; intensity 1; lumen 800 }
spot { at 0 1 0; target 0 0 0; intensity 1; cone 200; blend 2 }
point { at 0 1 0; intensity 1; colour 1 0 0 }
point { at 0 1 0; candela -1 }"
);
body!(
    words_of_other_programs,
    "smoke { density 1 }
hair { count 10 }
material \"lamp\" { emit 4; roughness 0.2 }
material \"clay\" { diffuse 0.4; coat 1; sheen 1 }
object \"a\" { cube 1; sphere 1 { translate 1 0 0 } }
field \"ball\" {
    bounds 2
    wgsl \"\"\"
        uniform float radius;
        float map(vec3 p) {
            return length(p) - radius;
        }
        \"\"\"
}"
);
body!(
    unknown_nodes,
    "objekt \"a\" { sphere }
object \"b\" { spher 1; sphere { att 0 1 0 }; plane { nromal 0 1 0 }; union { Box 1; tours; zzzzzz } }
material \"c\" { difuse 0.5 }
render { smaples 4 }
zzzzzz 1"
);
body!(
    misplaced_nodes,
    "sphere 1
at 0 1 0
fov 40
diffuse 1
object \"a\" { camera; at 0 1 0; sphere { normal 0 1 0; sphere } }
object \"b\" { union { diffuse 0.8; sphere } }"
);
body!(
    own_fields,
    "object \"a\" { field 8; sphere; gyroid 5 wall=1; gyroit; broken cell=2; good 9 8 { sphere } }
field
field \"sphere\" { wgsl \"fn distance(p: vec3f) -> f32 { return p.x; }\"; bounds none }
field \"2d\" { bounds 2; wgsl \"fn distance(p: vec3f) -> f32 { return p.x; }\" }
field \"gyroid\" { param cell 4 max=4.5; lipschitz 1.5; bounds 2; wgsl \"fn distance(p: vec3f) -> f32 { return p.x - cell; }\" }
field \"good\" { bounds 2; wgsl \"fn distance(p: vec3f) -> f32 { return p.x; }\" }
field \"good\" { bounds 2; wgsl \"fn distance(p: vec3f) -> f32 { return p.x; }\" }
field \"broken\" { lipschits 1; lipschitz 0; bounds 1 2; param a; param b one; wgsl 5; color 1 }
field \"empty\" { }
field \"wide\" { bounds 1 -2 3; wgsl \"fn distance(p: vec3f) -> f32 { return p.x; }\"; wgsl \"\"; lipschitz 1 2 }"
);
body!(
    own_field_texts,
    "field \"one\" {
    param cell 4
    bounds 2
    wgsl \"\"\"
        fn helper(x: f32) -> f32 {
            return x * 2.0;
        }
        fn distance(p: vec3f) -> f32 {
            return helper(p.x) + lenght(p) - cell;
        }
        \"\"\"
}
field \"two\" { bounds 2; wgsl \"fn distance(p: vec3f) -> f32 {\\n\\tlet é\\u{e9} = 1.0; return p; }\" }
field \"three\" { bounds 2; wgsl #\"\"\"
    var<private> seen: f32;
    @group(0) @binding(0) var<storage> memory: array<f32>;
    override size: f32;
    fn distance(p: vec3f) -> f32 { return p.x; }
    \"\"\"# }
field \"four\" { bounds 2; wgsl \"fn map(p: vec3f) -> f32 { return p.x; }\" }
field \"five\" { bounds 2; wgsl \"fn distance(p: vec3f, t: f32) -> f32 { return p.x; }\" }
field \"six\" { bounds 2; wgsl \"fn distance(p: vec3f) -> f32 { p.x = 1.0; return frame.tolerance; }\" }
field \"seven\" { bounds 2; wgsl \"fn distance(p: vec3f) -> f32 { let a = modf(p.x); return a.fract; }\" }
field \"eight\" { bounds 2; wgsl \"fn distance(p: vec3f) -> f32 { return p.x }\" }
field \"nine\" { bounds 2; wgsl \"fn distance(p: vec3f) -> f32 { return distance(p); }\" }
field \"ten\" { param loop 1; bounds 2; wgsl \"fn distance(p: vec3f) -> f32 { return p.x + 1; }\" }"
);
file!(
    skies,
    "pathmarch 1
camera { position 0 1 5; target 0 1 0 }
sky \"gradient\" 2 strength=1 { zenith -1; horizn 0.5; colour 1 }
sky 1"
);
file!(sky_constant, "pathmarch 1\ncamera { position 0 1 5; target 0 1 0 }\nsky 1 strength=2");
file!(sky_misspelt, "pathmarch 1\ncamera { position 0 1 5; target 0 1 0 }\nsky \"gradent\" { zenith 1 }");
file!(sky_unknown, "pathmarch 1\ncamera { position 0 1 5; target 0 1 0 }\nsky \"red\"");
file!(sky_empty_name, "pathmarch 1\ncamera { position 0 1 5; target 0 1 0 }\nsky \"\"");
file!(
    sky_day,
    "pathmarch 1
camera { position 0 1 5; target 0 1 0 }
sky \"day\" elevation=91 azimuth=north haze=21 strength=-1 sun=1 rotate=3 { ground 1.5; zenith 1 }"
);
body!(
    unknown_properties,
    "object \"a\" materail=\"x\" { sphere raduis=1; sphere 1 { at x=1 0 0 0 }; union smoth=1 { sphere } }
render quality=3"
);
body!(
    profiles,
    "object \"a\" { circle 1; union { rectangle 1 2 3; star } }
object \"b\" { extrude { twist { circle }; polar { union { star } }; circle { normal 0 1 0 } } }
object \"c\" { extrude { repeat { plane } }; twist { plane }; revolve offset=-1; extrude 0 { sphere } }"
);
body!(
    blends,
    "object \"a\" { union smooth=1 profile=\"rond\" steps=0 { sphere; box }; union profile=3 steps=1.5 { sphere } }
object \"b\" { morph 2 { sphere; box }; morph smooth=1 { sphere }; morph { sphere; box; torus; at 0 1 0 } }"
);
body!(
    outlines,
    "object \"a\" { extrude { polygon { point 0 0; point 1 0 }; polygon { point 0 0; point 1 1; point 2 2; at 0 0 0 }
polygon { point 0; point 1 x; point 2e6 0; pont 1 1 }; polygon 3 { point 0 0; sphere }; text 5; text \"\"; text \" \" size=0
text \"a\" 2 font=\"none.ttf\"; text \"\u{4e2d}\"; text font=\"\"; text font=3 { point 0 0 }; text fnt=\"a\"
text \"ab\" font=\"Cargo.toml\"; circle { point 0 0 }; text font=\"tests\" } }
object \"b\" { polygon; text \"c\" }"
);
body!(
    curves,
    "object \"a\" { extrude { curve { point 0 0; point 1 0 }; curve 0.1 { point 0 0 }; curve { point 0 0; point 1 1; point 2 2 }
curve -1 { point 0; point 1 2 3; point 1 2 corner=1; point 1 2 korner=#true { at 0 0 0 } }; curve 1 2 { point 0 0; point 0 0 }
path \"M 0 0 L 1\"; path \"\"; path 3; path \"M 0 0 L 1 1\"; path \"M 0 0 L 1e9 1 L 0 1\"; path \"M 0 0 1 1 1 0\" width=-1 } }
object \"b\" hidden=1 { sphere { at \"keys(t, 0, 1, 0, 2)\" 0 0 } }"
);
body!(
    unused_arguments,
    "object \"a\" \"b\" { sphere 1 2; plane 3 4; union 0.1 { sphere { at 1 2 3 4 } } }
render 5 { samples 1 2 }"
);
body!(
    missing_arguments,
    "object { sphere { at 1 2; scale } }
material { diffuse 1 2 }
object \"b\" { box 1 2 }
render { size 640; tonemap }"
);
body!(
    wrong_types,
    "object 1 material=2 { sphere \"1\"; sphere #true; box x=red; sphere { at a b c } }
render { samples many; tonemap 3 }"
);
body!(
    formulas,
    r##"param spin 30 min=0 max=90
param "gap" "spin/100"
object "a" {
    sphere "0.5 + 0.1*sin(2*pi*tt)"
    sphere radius="spn"
    sphere "sine(1)"
    sphere "spin(2)"
    sphere "clamp(1, 2)"
    sphere "1 + * 2"
    sphere "2*(1 + 3"
    sphere "gap - 2"
    sphere "1/(gap - 0.3)"
    sphere ""
    sphere "2m"
    box "one" 1 "#fff"
    menger iterations="1.5"
    sphere { at 0 "\\u{74}t" 0; rotate 0 "10^400" 0 }
    sphere \"((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((1))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))\"
}
material "m" { diffuse "blue"; }
material "n" { diffuse "spin/10" }"##
        .replace("\\\"", "\"")
);
body!(
    params,
    r##"param spin 30 min=0 max=20
param spin 1
param t 1
param sin 1
param "two words" 1
param a-b 1
param lonely
param
param word "#true" min=2 max=1
param late "later" mni=2
param later 1 doc=3
param "x" 1 2 { y }
object "a" { param inside 1; sphere late { at lonely word 0 } }"##
);
body!(
    declared_shapes,
    r##"shape "bolt" { param length 0.1 min=0.01; param head "length/5"; cylinder 0.01 length; sphre 1 }
shape "sphere" { box }
shape "at" { box }
shape "pin" { param r 1; sphere "r - 1.5"; at 0 1 0 }
shape "tube" { param r 1; cylinder r "2 - r" }
shape "tube" { box }
shape "empty" { param r 1 }
shape "a" { union { b } }
shape "b" { c; sphere }
shape "c" { box; a 1 { at 0 1 0 } }
shape { box }
shape "slab" { param material 1; box }
object "o" {
    tube r=-1
    tube 3 r=2
    tube r=3
    tube r=4
    tube lenght=1 2 3
    tube { sphere; at 0 1 0 }
    tub
    a
    sphere { tube }
    tube material="iron"
}"##
);
body!(not_finite, "object \"a\" { sphere #inf; sphere radius=#nan; sphere { at 0 #-inf 1e300 } }");
body!(
    out_of_range,
    "object \"a\" { sphere -1; box 1 0 2; sphere { scale 0 }; union smooth=-0.1 { sphere } }
material \"b\" { diffuse 1.5 0 -0.1 }
material \"c\" { emit -1 }
render { size 0 20000; samples 1.5; bounces -1 }
camera \"d\" { position 0 0 0; target 0 0 1; fov 180; lens radius=-1 focus=0 }
sun { direction 0 1 0; irradiance -1; angle 181 }"
);
body!(
    given_twice,
    "object \"a\" material=\"b\" material=\"b\" { sphere 1 radius=2; sphere { at 0 0 0; at 1 1 1 } }
object \"a\" { sphere }
material \"b\" { diffuse 1 }
material \"b\" { diffuse 0.5; diffuse 1 }
material \"c\" { diffuse 1; emit 1 }
camera \"main\" { position 0 0 0; target 1 0 0; fov 40; fov 50 }
sky 2"
);
body!(
    unknown_material,
    "material \"white\" { diffuse 0.8 }
object \"a\" material=\"whit\" { sphere material=\"gold\" }"
);
body!(
    too_few_shapes,
    "object \"a\" { subtract { }; subtract { sphere }; union; intersect { at 0 1 0 } }
object \"b\"
object \"c\" { }"
);
body!(
    unexpected_children,
    "object \"a\" { sphere { at 0 1 0 { x 1 }; box 1 } }
render { samples 4 { max 5 } }"
);
body!(annotations, "object (name)\"a\" { (solid)sphere (f32)1 { at 1 (u)2 3 } }");
body!(
    directions,
    "camera \"a\" { position 0 0 0; target 0 0 0 }
camera \"b\" { position 0 5 0; target 0 0 0 }
camera \"c\" { position 0 5 1; target 0 0 0; up 0 0 0 }
sun { direction 0 0 0; irradiance 1 }
object \"d\" { plane { normal 0 0 0 } }"
);
body!(
    colours,
    "material \"a\" { diffuse \"#ggg\" }\nmaterial \"b\" { diffuse \"red\" }\nmaterial \"c\" { emit \"#12345\" }"
);
body!(unknown_tonemap, "render { tonemap \"agz\" }\n");
body!(
    unknown_settings,
    "render { sampler \"sobl\"; caustics \"slow\"; clamp 0 }
sun { direction 0 1 0; irradiance 1; penumbra 0 }
point { at 0 1 0; intensity 1; penumbra -1 }
penumbra 16
zenith 1
ground 1"
);
body!(missing_nodes, "camera \"a\" { fov 30 }\nsun { }\npoint { at 0 1 0 }\nmaterial \"b\" { }\nmaterial \"c\"");
body!(empty_names, "camera \"\" { position 0 0 0; target 0 0 1 }\nobject \"\" { sphere }\nmaterial \"\" { diffuse 1 }");
file!(
    syntax,
    "pathmarch 1
camera { position 0, 1, 5; target 0 .5 1. }
object \"a { sphere }
object \"b\" { sphere 1x; sphere radius=; sphere [2]; true 1 }
object \"c\" { sphere 1 } material \"d\" { diffuse #ff0000 }
{ sphere }
}
object \"e\" { sphere \"\\q\"; spher 1; /- }
object \"f\" { sphere"
);
file!(syntax_open_comment, "pathmarch 1\ncamera { position 0 1 5; target 0 1 0 }\n/* sphere");
file!(hidden_characters, "pathmarch 1\ncamera { position 0 1\u{200e} 5; target 0 1 0 }\u{0}");
body!(wide_characters, "object \"日本\" material=\"ünï\" { spheré 1 }");

#[test]
fn nested_too_deep() {
    let text = format!("{HEAD}object \"a\" {{ {}sphere{} }}", "union { ".repeat(64), " }".repeat(64));
    let error = error(&text);
    assert_eq!(error.mistakes().len(), 1);
    assert_eq!(error.mistakes()[0].code, "pathmarch::nesting");
    let fits = format!("{HEAD}object \"a\" {{ {}sphere{} }}", "union { ".repeat(63), " }".repeat(63));
    assert!(Scene::parse("scene.kdl", &fits).is_ok());
}

#[test]
fn too_many_shapes() {
    let text = |count: usize| format!("{HEAD}object \"a\" {{\n{}}}", "sphere\n".repeat(count));
    assert!(Scene::parse("scene.kdl", &text(100_000)).is_ok());
    let error = error(&text(100_002));
    assert_eq!(error.mistakes().len(), 1);
    assert!(rendered(&error).contains("The scene has more than 100000 shapes."));
}

#[test]
fn too_many_mistakes() {
    let error = error(&format!("{HEAD}{}", "sphere 1\n".repeat(5000)));
    assert_eq!(error.to_string(), "scene.kdl has 5000 mistakes, of which 100 are shown");
    assert_eq!(error.mistakes().len(), 100);
}

#[test]
fn many_unknown_materials_are_counted() {
    let objects: String = (0..20_000).map(|k| format!("object \"o{k}\" material=\"n{k}\" {{ sphere }}\n")).collect();
    let materials: String = (0..20_000).map(|k| format!("material \"m{k}\" {{ diffuse 0.5 }}\n")).collect();
    let error = error(&format!("{HEAD}{materials}{objects}"));
    assert_eq!(error.to_string(), "scene.kdl has 20000 mistakes, of which 100 are shown");
    assert!(rendered(&error).contains("Did you mean `m0`?"));
}

#[test]
fn of_long_lines_a_part_is_shown() {
    let semicolons = error(&format!("{HEAD}{}", ";".repeat(1_000_000)));
    let report = rendered(&semicolons);
    assert!(report.contains("scene.kdl:4:100]") && report.len() < 100_000, "{} bytes", report.len());
    // A mistake as long as its line, beside wide characters, and between long lines.
    let name = "ü".repeat(5000);
    let long = "x".repeat(5000);
    for text in [
        format!("{HEAD}{name} 1\n"),
        format!("{HEAD}object \"{name}\" {{ spher }}"),
        format!("{HEAD}// {long}\nspher 1\n// {long}"),
        format!("{HEAD}object \"a\" {{ sphere {{\n{}spher\n }} }}", " ".repeat(5000)),
        format!("{HEAD}object \"a\" {{ sphere\n\n // {long}"),
    ] {
        let report = rendered(&error(&text));
        assert!(report.contains("scene.kdl:") && report.len() < 10_000, "{report}");
    }
}

#[test]
fn polygons_cross_themselves_a_limited_number_of_times() {
    let polygon = |points: u32, turns: u32| {
        let points = (0..points).map(|k| {
            let angle = f64::from(k * turns % points) / f64::from(points) * std::f64::consts::TAU;
            format!("point {} {}\n", angle.cos(), angle.sin())
        });
        format!("{HEAD}object \"a\" {{ extrude 1 {{ polygon {{\n{}}} }} }}", points.collect::<String>())
    };
    // A star of 101 points crosses itself 101 times for each turn but the first.
    assert!(Scene::parse("scene.kdl", &polygon(101, 20)).is_ok());
    let report = rendered(&error(&polygon(999, 400)));
    assert!(report.contains("crosses itself too often") && report.contains("more than 10000 crossings"), "{report}");
}

#[test]
fn unreadable() {
    let folder = std::env::temp_dir().join(format!("pathmarch-scene-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("the folder for temporary files is writable");
    let reason = |path: &std::path::Path| match Scene::load(path) {
        Err(SceneError::Unreadable { reason, .. }) => reason,
        other => panic!("{other:?}"),
    };
    assert_eq!(reason(&folder.join("missing.kdl")), "there is no such file");
    assert_eq!(reason(&folder), "it is a directory");
    let file = folder.join("scene.kdl");
    std::fs::write(&file, b"pathmarch 1\nsky \xff").expect("the folder is writable");
    assert_eq!(reason(&file), "it is not UTF-8 text (line 2, byte 16)");
    std::fs::write(&file, vec![b' '; (16 << 20) + 1]).expect("the folder is writable");
    assert_eq!(reason(&file), "it is larger than 16 MiB");
    std::fs::write(&file, "pathmarch 1\ncamera { position 0 1 5; target 0 1 0 }").expect("the folder is writable");
    assert_eq!(Scene::load(&file).expect("this file is right").cameras.len(), 1);
    std::fs::remove_dir_all(&folder).expect("the folder is ours");
}

/// The only warning of a text.
fn warning(text: &str) -> Mistake {
    let mut scene = Scene::parse("scene.kdl", text).expect("only a warning");
    assert_eq!(scene.warnings.len(), 1, "{text}");
    scene.warnings.remove(0)
}

const CAMERA: &str = "pathmarch 1\ncamera { position 0 1 5; target 0 1 0 }\n";

#[test]
fn warnings() {
    snapshot("warnings", &warning(&format!("{CAMERA}object \"a\" {{ sphere }}")));
}

#[test]
fn hidden_light() {
    let text = "object \"far\" { sphere { at 9 0 0 } }\nobject \"near\" { sphere }\npoint { at 0 0.5 0; intensity 1 }";
    snapshot("hidden_light", &warning(&format!("{CAMERA}{text}")));
}

/// Warnings point at the nodes that the scene has, not at hidden ones before them.
#[test]
fn hidden_nodes_have_no_warnings() {
    let text = "object \"away\" hidden=#true { sphere }\nobject \"near\" { sphere }\n\
                point hidden=#true { at 9 0 0; intensity 1 }\npoint { at 0 0.5 0; intensity 1 }";
    let text = format!("{CAMERA}{text}");
    assert_eq!(warning(&text).span.offset(), text.rfind("point").expect("a light"));
}

/// A light in clear glass is not hidden.
#[test]
fn lights_in_glass_shine() {
    let text =
        "material \"g\" { glass 1 }\nobject \"bulb\" material=\"g\" { sphere }\npoint { at 0 0.5 0; intensity 1 }";
    let fast = format!("{CAMERA}render {{ caustics \"fast\" }}\n{text}");
    assert!(Scene::parse("scene.kdl", &fast).expect("no mistake").warnings.is_empty());
    // Without, no path finds a light that has no size behind glass.
    snapshot("lost_light", &warning(&format!("{CAMERA}{text}")));
}

#[test]
fn clear_sheet() {
    let text = "sky 1\nmaterial \"g\" { glass 1 }\nobject \"pane\" material=\"g\" { rect 1 1 }";
    snapshot("clear_sheet", &warning(&format!("{CAMERA}{text}")));
}

/// Black in whatever form, a sky lights nothing.
#[test]
fn no_light() {
    for sky in ["", "sky 0", "sky \"gradient\" { zenith 0; horizon 0 }", "sky \"day\" strength=0"] {
        assert_eq!(warning(&format!("{CAMERA}{sky}\nobject \"a\" {{ sphere }}")).code, "pathmarch::no_light", "{sky}");
    }
    for sky in ["sky 0 0 1", "sky \"gradient\" { zenith 0; horizon 0; ground 0.1 }", "sky \"day\" elevation=-10"] {
        let scene = Scene::parse("scene.kdl", &format!("{CAMERA}{sky}\nobject \"a\" {{ sphere }}"));
        assert!(scene.expect("nothing is wrong").warnings.is_empty(), "{sky}");
    }
}

body!(
    modifiers,
    "object \"a\" { mirror \"w\" { sphere }; mirror 1 { sphere }; twist { plane }; polar 2.5 { sphere }; repeat { } }
object \"b\" { repeat 1 count=-1 { union { sphere; repeat { box } } }; shell -1 { sphere }; bend turn=2 { box } }"
);
body!(
    orbit_traps,
    "material \"a\" { diffuse 1; orbit-trap \"pont\" { colour 0.5; color 1 } }
material \"b\" { metal 1; orbit-trap from=1 to=1 { colour 0.5 } }
material \"c\" { emit 1; orbit-trap { colour 1 } }
material \"d\" { glass 1; orbit-trap \"line\" \"plane\" size=2; orbit-trap { colour 2 } }"
);
body!(
    near_auto,
    "camera \"a\" { position 0 1 5; target 0 1 0; exposure \"automatic\" }
camera \"b\" { position 0 1 5; target 0 1 0; exposure Auto }
camera \"c\" { position 0 1 5; target 0 1 0; exposure \"autp\" }
camera \"d\" { position 0 1 5; target 0 1 0; exposure \"bright\" }"
);
body!(
    endless_flux,
    "material \"lamp\" { emit 2 }
object \"a\" material=\"lamp\" lumen=800 { plane }
object \"b\" material=\"lamp\" lumen=-1 { sphere 1 }"
);
body!(
    decals_and_ramps,
    "material \"a\" { diffuse 1; decal; decal \"\" size=0; decal \"no.png\" siz=1 angle=200 opacity=2 world=1 }
material \"b\" { emit 1; decal \"tests\" }
material \"c\" { metal 1; decal \"tests\" { at 1 2; colour 1; scale 0 } }
material \"e\" { diffuse { fbm { colour 0 at=2; colour 1 att=0.5; colour at=0.5 } } }
material \"f\" { diffuse 0.5 at=1 }"
);
body!(
    textures,
    "material \"a\" { diffuse { marbel size=0.1 } }
material \"b\" { diffuse 0.5 { fbm } }
material \"c\" { emit { fbm } }
material \"d\" { glass 1; absorb { fbm }; ior { cells }; roughness { picture } }
material \"e\" { diffuse { fbm; wood } }
material \"f\" { principled { fbm size=0 octaves=2.5 from=1 { color 1; colour 2; att 1 2 3 } }; roughness { fbm from=2; } }
material \"g\" { metal { picture \"no.png\" }; edge { picture \"\" size=-1 }; bump { }; roughness { checker { colour 1 } } }
material \"h\" { diffuse { picture \"tests/data/small.hdr\" }; bump 2 { fbm heigt=1 } }
material \"i\" { diffuse { picture \"tests\" } }"
);
