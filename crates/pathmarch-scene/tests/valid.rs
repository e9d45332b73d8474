//! Files that are right, and what becomes of them.

#[path = "../../pathmarch-render/tests/common/random_scenes.rs"]
mod random_scenes;

use pathmarch_field::Node;
use pathmarch_field::graph::Kind;
use pathmarch_field::registry;
use pathmarch_scene::{Caustics, LengthUnit, Light, Sampler, Scene, Sky, Tonemap};

const HEAD: &str = "pathmarch 1\ncamera { position 0 1 5; target 0 1 0 }\nsky 1\n";

fn parse(text: &str) -> Scene {
    match Scene::parse("tests/data/test.kdl", text) {
        Ok(scene) => scene,
        Err(error) => panic!("{:?}", miette::Report::new(error)),
    }
}

/// The scene of `body` after a version, a camera and a sky.
fn body(text: &str) -> Scene {
    parse(&format!("{HEAD}{text}"))
}

/// The same with a unit of length.
fn body_in(unit: &str, text: &str) -> Scene {
    parse(&format!("{}{text}", HEAD.replacen('\n', &format!("\nunit \"{unit}\"\n"), 1)))
}

/// The numbers of the only shape.
fn params(shape: &str) -> Vec<f32> {
    let is_profile = |word| registry::shape(word).is_some_and(|shape| shape.info().profile);
    let solid = if shape.split(' ').next().is_some_and(is_profile) {
        format!("extrude {{ {shape} }}")
    } else {
        shape.to_owned()
    };
    let scene = body(&format!("object \"o\" {{ {solid} }}"));
    fn first(node: &Node) -> Vec<f32> {
        match &node.kind {
            // Behind them stands the outline of what is drawn.
            Kind::Shape { shape, params, .. } => params[..shape.params().len()].to_vec(),
            Kind::Operator { children, .. } | Kind::Modifier { children, .. } => first(&children[0]),
        }
    }
    first(&scene.objects[0].root)
}

#[test]
fn reference_scenes() {
    let scene = parse(include_str!("data/diffuse_sphere_plane.kdl"));
    assert!(scene.warnings.is_empty());
    assert_eq!(scene.render.size, (320, 180));
    assert_eq!((scene.render.bounces, scene.render.samples), (4, 256));
    assert_eq!(scene.render.tonemap, Tonemap::Agx);
    assert_eq!(scene.sky, Sky::Constant([0.3, 0.375, 0.5]));
    assert_eq!(scene.lights, [Light::Point { at: [4.0, 6.0, 4.0], intensity: [120.0; 3], penumbra: None }]);
    assert_eq!(scene.cameras.len(), 1);
    let camera = &scene.cameras[0];
    assert_eq!((camera.name.as_str(), camera.position, camera.fov), ("main", [0.0, 4.0, 7.0], 35.0));
    assert_eq!(scene.objects.len(), 2);
    assert_eq!(scene.objects[1].name, "ball");
    assert_eq!(scene.materials[scene.objects[1].material].name, "white");
    assert_eq!(scene.field.leaves()[1].tag, 0);
    assert_eq!(scene.field.leaves()[0].tag, 1);
    assert_eq!(scene.field.distance(pathmarch_field::number::Vec3::new(0.0, 3.0, 0.0)), 1.0);

    let area = parse(include_str!("data/diffuse_sphere_plane_area.kdl"));
    assert_eq!(area.materials[2].emission(), [106.103; 3]);
    assert_eq!(area.materials[2].albedo(), [0.0; 3]);
    assert_eq!(area.materials[0].emission(), [0.0; 3]);
    assert!(area.warnings.is_empty());
    parse(include_str!("data/furnace_050.kdl"));
    let cornell = parse(include_str!("data/cornell.kdl"));
    assert_eq!(cornell.objects.len(), 8);
    assert!(cornell.warnings.is_empty());
}

#[test]
fn scene_defaults() {
    let scene = parse("pathmarch 1\ncamera { position 0 1 5; target 0 1 0 }");
    assert_eq!((scene.render.size, scene.render.samples, scene.render.bounces), ((1280, 720), 256, 4));
    assert_eq!(scene.sky, Sky::Constant([0.0; 3]));
    let camera = &scene.cameras[0];
    assert_eq!(camera.name, "main");
    assert_eq!((camera.up, camera.fov, camera.exposure), ([0.0, 1.0, 0.0], 40.0, 0.0));
    assert_eq!((camera.lens_radius, camera.focus), (0.0, None));
    let codes: Vec<_> = scene.warnings.iter().map(|warning| warning.code).collect();
    assert_eq!(codes, ["pathmarch::no_objects", "pathmarch::no_light"]);
}

#[test]
fn settings() {
    let scene = parse(
        "pathmarch 1
        camera wide { position 0 6 0; target 0 1 0; up 0 0 -3; fov 90; lens radius=0.1 focus=6; exposure -1.5 }
        camera \"two words\" { position 1 2 3; target 0 0 0; exposure \"auto\" }
        render { size 64 32; samples 1; bounces 0; tonemap srgb }
        sky \"#fff\"
        sun { direction 0 2 0; irradiance 3; angle 0 }
        sun { direction 1 0 0; irradiance \"#000080\" }",
    );
    let wide = &scene.cameras[0];
    assert_eq!((wide.up, wide.fov, wide.exposure), ([0.0, 0.0, -1.0], 90.0, -1.5));
    assert_eq!((wide.lens_radius, wide.focus), (0.1, Some(6.0)));
    assert_eq!(scene.cameras[1].name, "two words");
    assert_eq!((wide.auto_exposure, scene.cameras[1].auto_exposure, scene.cameras[1].exposure), (false, true, 0.0));
    assert_eq!((scene.render.size, scene.render.samples, scene.render.bounces), ((64, 32), 1, 0));
    assert_eq!(scene.render.tonemap, Tonemap::Srgb);
    assert_eq!(scene.sky, Sky::Constant([1.0; 3]));
    assert_eq!(
        scene.lights[0],
        Light::Sun { direction: [0.0, 1.0, 0.0], irradiance: [3.0; 3], angle: 0.0, penumbra: None }
    );
    let Light::Sun { irradiance, angle, .. } = scene.lights[1] else { panic!("not a sun") };
    assert_eq!(angle, 0.53);
    assert!((irradiance[2] - 0.215_860_5).abs() < 1e-6 && irradiance[0] == 0.0);
    let defaults = body("").render;
    assert_eq!(
        (defaults.sampler, defaults.caustics, defaults.clamp, defaults.detail),
        (Sampler::Sobol, Caustics::Sampled, None, 0.1)
    );
    let other = body("render { sampler \"independent\"; caustics \"fast\"; clamp 10; detail 0.5 }").render;
    assert_eq!(
        (other.sampler, other.caustics, other.clamp, other.detail),
        (Sampler::Independent, Caustics::Fast, Some(10.0), 0.5)
    );
}

#[test]
fn penumbrae() {
    let lights = body(
        "sun { direction 0 1 0; irradiance 3; penumbra 16 }
        point { at 0 1 0; intensity 3; penumbra 0.5 }
        point { at 0 1 0; intensity 3 }",
    )
    .lights;
    let penumbrae = lights.iter().map(|light| match light {
        Light::Sun { penumbra, .. } | Light::Point { penumbra, .. } | Light::Spot { penumbra, .. } => *penumbra,
    });
    assert_eq!(penumbrae.collect::<Vec<_>>(), [Some(16.0), Some(0.5), None]);
}

#[test]
fn spot_lights() {
    let lights = body(
        "spot { at 1 3 0; target 1 0 4; intensity 5 4 3; cone 30; blend 0.5 }
        spot { at 0 2 0; target 0 0 0; intensity 1; penumbra 4 }
        spot hidden=#true { at 0 2 0; target 0 0 0; intensity 1 }",
    )
    .lights;
    let spot = |at, direction, intensity, cone, blend, penumbra| Light::Spot {
        at,
        direction,
        intensity,
        cone,
        blend,
        penumbra,
    };
    let first = spot([1.0, 3.0, 0.0], [0.0, -0.6, 0.8], [5.0, 4.0, 3.0], 30.0, 0.5, None);
    assert_eq!(lights, [first, spot([0.0, 2.0, 0.0], [0.0, -1.0, 0.0], [1.0; 3], 45.0, 0.15, Some(4.0))]);
}

/// Candela and lumen are what other programs make of them.
#[test]
fn lights_in_candela_and_lumen() {
    let intensity = |unit: &str, light: &str| body_in(unit, light).lights[0].power();
    let near = |found: [f32; 3], expected: [f32; 3]| {
        let near = found.iter().zip(expected).all(|(a, b)| (a / b - 1.0).abs() < 1e-4);
        assert!(near, "{found:?} instead of {expected:?}");
    };
    near(intensity("m", "point { at 0 1 0; candela 683 }"), [1.0; 3]);
    near(intensity("m", "point { at 0 1 0; lumen 8582.8 }"), [1.0; 3]);
    // The same light at the same place: distances are a hundred times as large.
    near(intensity("cm", "point { at 0 100 0; candela 683 }"), [1e4; 3]);
    // A cone of 180 degrees with a hard edge is a half of all directions.
    near(intensity("m", "spot { at 0 1 0; target 0 0 0; cone 180; blend 0; lumen 4291.4 }"), [1.0; 3]);
    near(intensity("m", "spot { at 0 1 0; target 0 0 0; cone 180; blend 1; lumen 2145.7 }"), [1.0; 3]);
    // The colour has the luminance of white.
    let [r, g, b] = intensity("m", "point { at 0 1 0; candela 683; colour 1 0.5 0 }");
    assert!((0.2126 * r + 0.7152 * g + 0.0722 * b - 1.0).abs() < 1e-5 && (r / g - 2.0).abs() < 1e-5 && b == 0.0);
    assert_eq!(intensity("m", "point { at 0 1 0; candela 683; colour 0 }"), [0.0; 3]);
}

#[test]
fn a_scene_has_a_unit() {
    assert_eq!(body("").unit, LengthUnit::M);
    for unit in LengthUnit::ALL {
        assert_eq!(body_in(unit.name(), "").unit, unit);
    }
}

/// A scene without a unit whose camera is far away may be in centimetres.
#[test]
fn large_numbers_are_doubted() {
    let warnings = |unit: &str, distance: f32| {
        let text = format!(
            "pathmarch 1\n{unit}\ncamera {{ position 0 0 {distance}; target 0 0 0 }}\nsky 1\nobject \"a\" {{ sphere 9 }}"
        );
        parse(&text).warnings.iter().filter(|warning| warning.code == "pathmarch::large_numbers").count()
    };
    assert_eq!([warnings("", 20.0), warnings("", 250.0), warnings("unit \"cm\"", 250.0)], [0, 1, 0]);
    assert_eq!([warnings("unit \"m\"", 250.0), warnings("", 1e6)], [0, 0]);
}

/// A number of turns that was most likely meant in degrees.
#[test]
fn many_turns_are_doubted() {
    let doubts = |shape: &str| {
        let warnings = body(&format!("object \"a\" {{ {shape} }}")).warnings;
        warnings.into_iter().filter(|warning| warning.code == "pathmarch::many_turns").collect::<Vec<_>>()
    };
    let bar = "box 1 2 1 { at 0 1 0 }";
    let doubt = &doubts(&format!("twist 60 {{ {bar} }}"))[0];
    assert!(doubt.help.as_ref().is_some_and(|help| help.contains("60° per metre are 0.167")), "{doubt:?}");
    assert_eq!(doubts(&format!("bend 45 {{ {bar} }}")).len(), 1);
    // A thread of 1.25 mm, and a drill.
    for meant in [
        format!("twist 0.167 {{ {bar} }}"),
        "twist 800 { box 0.008 0.03 0.008 }".into(),
        "twist 10 { box 0.2 9 0.2 }".into(),
    ] {
        assert_eq!(doubts(&meant).len(), 0, "{meant}");
    }
}

/// Every name of every setting is read as what it names.
#[test]
fn named_settings() {
    for tonemap in Tonemap::ALL {
        assert_eq!(body(&format!("render {{ tonemap \"{}\" }}", tonemap.name())).render.tonemap, tonemap);
    }
    for sampler in Sampler::ALL {
        assert_eq!(body(&format!("render {{ sampler \"{}\" }}", sampler.name())).render.sampler, sampler);
    }
    for caustics in Caustics::ALL {
        assert_eq!(body(&format!("render {{ caustics \"{}\" }}", caustics.name())).render.caustics, caustics);
    }
}

#[test]
fn shape_arguments() {
    assert_eq!(params("box 1 2 3"), [1.0, 2.0, 3.0]);
    assert_eq!(params("box 2"), [2.0; 3]);
    assert_eq!(params("box"), [1.0; 3]);
    assert_eq!(params("box z=4"), [1.0, 1.0, 4.0]);
    assert_eq!(params("box 2 3 z=4"), [2.0, 3.0, 4.0]);
    assert_eq!(params("torus 2"), [2.0, 0.25]);
    assert_eq!(params("torus minor=0.5 major=3"), [3.0, 0.5]);
    assert_eq!(params("torus 2 minor=0.5"), [2.0, 0.5]);
}

/// One size for several parameters, over every shape that takes one.
#[test]
fn one_size() {
    for shape in pathmarch_field::registry::shapes() {
        let (info, all) = (shape.info(), shape.params());
        let sizes = info.size_params;
        if sizes < 2 {
            continue;
        }
        let values = params(&format!("{} 1.5", info.name));
        assert!(values[..sizes].iter().all(|&v| v == 1.5), "{}: {values:?}", &*info.name);
        if all.len() > sizes && sizes > 2 {
            let values = params(&format!("{} 1.5 0.25", info.name));
            assert!(values[..sizes].iter().all(|&v| v == 1.5), "{}: {values:?}", &*info.name);
            assert_eq!(values[sizes], 0.25, "{}", &*info.name);
        }
    }
}

/// Every shape with every parameter by name, at its default.
#[test]
fn every_shape() {
    for shape in pathmarch_field::registry::shapes() {
        let mut text = shape.info().name.to_string();
        for param in shape.params() {
            text += &format!(" {}={}", param.name, param.default);
        }
        let defaults: Vec<f32> = shape.params().iter().map(|param| param.default).collect();
        assert_eq!(params(&text), defaults, "{text}");
        assert_eq!(params(&shape.info().name), defaults, "{text}");
    }
}

#[test]
fn materials_and_tags() {
    let scene = body(
        "object \"a\" material=\"red\" {
            subtract smooth=0.05 material=\"green\" {
                at 0 1 0
                box 2 { at 0 0.5 0; rotate 0 45 0 }
                sphere 0.7 material=\"red\" { scale 2 }
                union { sphere; sphere }
            }
            sphere
        }
        object \"b\" { sphere; sphere material=\"red\" }
        object \"c\" { sphere material=\"green\" }
        material \"red\" { diffuse 1 0 0 }
        material green { diffuse \"#0f0\" }",
    );
    let tags: Vec<_> = scene.field.leaves().iter().map(|leaf| leaf.tag).collect();
    assert_eq!(tags, [1, 0, 1, 1, 0, 2, 0, 1]);
    let names: Vec<_> = scene.materials.iter().map(|material| material.name.as_str()).collect();
    assert_eq!(names, ["red", "green", "default"]);
    assert_eq!(scene.materials[2].albedo(), [0.8; 3]);
    assert_eq!(scene.materials[1].albedo(), [0.0, 1.0, 0.0]);
    let own: Vec<_> = scene.objects.iter().map(|object| object.material).collect();
    assert_eq!(own, [0, 2, 1]);
    let Kind::Operator { operator, smooth: None, children } = &scene.objects[0].root.kind else { panic!("no union") };
    assert_eq!((&*operator.info().name, children.len()), ("union", 2));
    let Kind::Operator { operator, smooth: Some(blend), children } = &children[0].kind else { panic!("not smooth") };
    assert_eq!((&*operator.info().name, blend.amount, children.len()), ("subtract", 0.05, 3));
}

#[test]
fn placement() {
    let scene = body("object \"o\" { plane { normal 0 1 1; at 1 2 3; scale 2; rotate 10 20 30 } }");
    let placement = scene.objects[0].root.placement;
    let half = 0.5_f32.sqrt();
    assert_eq!(placement.normal, Some([0.0, half, half]));
    assert_eq!((placement.at, placement.scale), (Some([1.0, 2.0, 3.0]), Some(2.0)));
    assert_eq!(placement.rotate, Some([10.0, 20.0, 30.0]));
}

#[test]
fn zero_blend_is_sharp() {
    let scene = body("object \"o\" { union smooth=0 { sphere; box } }");
    assert!(matches!(scene.objects[0].root.kind, Kind::Operator { smooth: None, .. }));
}

#[test]
fn comments_and_strings() {
    let scene = body(
        "/- object \"gone\" { nonsense { /- a } }
        object #\"raw \"name\"\"# /-material=\"none\" { /* a /* b */ c */ sphere \\
            2 /-{ nothing } { at 1 /-2 3 \\ // joined
               4 } }
        object \"a\\tb\\u{e9}\" { sphere 0x2; /-sphere }",
    );
    assert_eq!(scene.objects[0].name, "raw \"name\"");
    assert_eq!(scene.objects[1].name, "a\tb\u{e9}");
    assert_eq!(scene.objects[0].root.placement.at, Some([1.0, 3.0, 4.0]));
    assert_eq!(scene.field.leaves()[1].params, [2.0]);
}

#[test]
fn endless_light_warns() {
    let scene = body("material \"lamp\" { emit 1 }\nobject \"o\" material=\"lamp\" { plane }");
    assert_eq!(scene.warnings.len(), 1);
    assert_eq!(scene.warnings[0].code, "pathmarch::endless_light");
    let cut = body("material \"lamp\" { emit 1 }\nobject \"o\" material=\"lamp\" { intersect { plane; box } }");
    assert!(cut.warnings.is_empty());
}

#[test]
fn hidden_point_warns() {
    let codes = |text: &str| body(text).warnings.iter().map(|warning| warning.code).collect::<Vec<_>>();
    let solid = "object \"a\" { sphere { at 9 0 0 } }\nobject \"b\" { box 2 { at 0 1 0 } }";
    assert_eq!(codes(&format!("point {{ at 0 1.9 0; intensity 1 }}\n{solid}")), ["pathmarch::hidden_light"]);
    assert!(codes(&format!("point {{ at 0 2.1 0; intensity 1 }}\n{solid}")).is_empty());
    // A hollow is outside.
    let hollow = "object \"a\" { subtract { box 2; box 1 } }";
    assert!(codes(&format!("point {{ at 0 0 0; intensity 1 }}\n{hollow}")).is_empty());
}

/// The outlines of polygons and texts, by what they hold.
#[test]
fn polygons_and_texts() {
    use pathmarch_field::number::Vec3;
    let field = |text: &str| body(&format!("object \"o\" {{ extrude 0.5 {{ {text} }} }}")).field;
    let inside = |text: &str, x: f32, y: f32| field(text).distance(Vec3::new(x, y, 0.0)) < 0.0_f32;
    let notched = "polygon { point 0 0; point 2 0; point 2 2; point 1 0.5; at 1 0 0; point 0 2 }";
    assert!(inside(notched, 1.2, 1.0) && inside(notched, 2.8, 1.0) && !inside(notched, 2.0, 1.0));
    // The hole of an o is none, and what stands beside it is not there.
    assert!(!inside("text \"o\"", 0.0, 0.25) && inside("text \"o\" size=2", -0.45, 0.5));
    let width = |text: &str| {
        let bounds = field(text).bounds();
        bounds.max[0] - bounds.min[0]
    };
    assert!((width("text \"Hello\" size=2") - 2.0 * width("text \"Hello\"")).abs() < 1e-3);
    assert!((width("text \"Hello\" font=\"../../fonts/Cantarell-Regular.ttf\"") - width("text Hello")).abs() < 1e-6);
    assert!(width("text") > 1.0 && width("text \"AAAA\"") > 3.0 * width("text \"A\""));
    let lines = field("text \"up\\nxx\"").bounds();
    assert!(lines.min[1].abs() < 0.02 && lines.max[1] > 1.3, "{lines:?}");
}

/// Curves and paths, by what they contain.
#[test]
fn curves_and_paths() {
    use pathmarch_field::number::Vec3;
    let field = |text: &str| body(&format!("object \"o\" {{ extrude 0.5 {{ {text} }} }}")).field;
    let distance = |text: &str, x: f32, y: f32| -> f32 { field(text).distance(Vec3::new(x, y, 0.0)) };
    let square = |corner: &str| {
        let point = |x, y| format!("point {x} {y} {corner};");
        format!("curve {{ {} {} {} {} }}", point(-1, -1), point(1, -1), point(1, 1), point(-1, 1))
    };
    // With corners it is the square; without, its sides bulge by a quarter.
    assert!((distance(&square("corner=#true"), 1.5, 0.0) - 0.5).abs() < 1e-5);
    assert!(distance(&square(""), 1.2, 0.0) < 0.0 && distance(&square(""), 1.3, 0.0) > 0.0);
    // A line is where its points are, and has no inside; one that returns is closed.
    let line = "curve 0.2 { point 0 0; point 1 0; point 2 1; at 0 1 0 }";
    assert!((distance(line, 1.0, 1.0) + 0.1).abs() < 1e-5 && (distance(line, -0.5, 1.0) - 0.4).abs() < 1e-5);
    let ring = "curve width=0.1 { point 1 0; point 0 1; point -1 0; point 0 -1; point 1 0 }";
    assert!(
        distance(ring, 0.0, 0.0) > 0.8 && distance(ring, 0.625, -0.625) < 0.0 && distance(ring, 0.625, 0.625) < 0.0
    );
    // y points up; arcs, curves, relative commands; holes wind the other way.
    let path = "path \"M0 0h2v-1H0z m.5-.25h1v-.5h-1z\"";
    assert!(distance(path, 0.25, 0.5) < 0.0 && distance(path, 1.0, 0.1) < 0.0 && distance(path, 1.0, -0.5) > 0.0);
    let holed = "path \"M0 0h2v-1H0z m.5-.25v-.5h1v.5z\"";
    assert!(distance(holed, 1.0, 0.5) > 0.0 && distance(holed, 0.25, 0.5) < 0.0);
    let circle = "path \"M-1 0A1 1 0 0 1 1 0A1 1 0 0 1-1 0\"";
    for k in 0..40 {
        let (y, x) = (k as f32 * 0.157).sin_cos();
        // A Bézier curve of a quarter is within 0.00027 of the circle.
        assert!((distance(circle, 1.2 * x, 1.2 * y) - 0.2).abs() < 5e-4);
    }
    let wire = "path \"M0 0C0-1 1-1 1 0\" width=0.1";
    assert!((distance(wire, 0.5, 0.75) + 0.05).abs() < 1e-3 && distance(wire, 0.5, 0.2) > 0.0);
}

/// A hidden object or light is as if it were not there, but for mistakes in it.
#[test]
fn hidden_nodes_are_left_out() {
    let scene = |hidden: &str| {
        body(&format!(
            "sun {hidden} {{ direction 0 1 0; irradiance 1 }}\npoint {hidden} {{ at 0 3 0; intensity 5 }}
object \"a\" {hidden} {{ sphere 1; box 1 }}\nobject \"b\" {{ sphere 2 }}"
        ))
    };
    let (all, some) = (scene("hidden=#false"), scene("hidden=#true"));
    assert_eq!((all.lights.len(), all.objects.len(), all.field.leaves().len()), (2, 2, 3));
    assert_eq!((some.lights.len(), some.objects.len(), some.field.leaves().len()), (0, 1, 1));
    let text = "pathmarch 1\ncamera { position 0 0 5; target 0 0 0 }\nobject \"a\" hidden=#true { sphere -1 }";
    assert!(Scene::parse("scene.kdl", text).is_err());
}

/// The scenes that both backends are compared on: right, small, and seen from outside.
#[test]
fn random_scenes_are_valid() {
    let (mut shapes, mut leaves) = (std::collections::HashSet::new(), 0);
    for number in 0..1000 {
        let text = random_scenes::random_scene(number);
        let scene = Scene::parse("random.kdl", &text).unwrap_or_else(|error| panic!("{error:?}\n{text}"));
        assert!(scene.warnings.is_empty(), "{:?}\n{text}", scene.warnings);
        let count = scene.field.leaves().len();
        assert!((1..=random_scenes::MAX_SHAPES).contains(&count), "{count} shapes\n{text}");
        leaves += count;
        let [x, y, z] = scene.cameras[0].position;
        let distance = scene.field.distance(pathmarch_field::number::Vec3::new(x, y, z));
        assert!(distance > 0.1, "number {number}: the camera is at {distance}\n{text}");
        let objects = scene.objects.iter().zip(scene.field.object_bounds());
        for (_, bounds) in objects.filter(|(object, _)| object.name != "floor") {
            let farthest = bounds.min.into_iter().chain(bounds.max).fold(0.0_f32, |most, v| most.max(v.abs()));
            assert!(farthest <= random_scenes::MAX_EXTENT, "number {number}: {farthest} m\n{text}");
        }
        shapes.extend(text.split([' ', '"']).filter(|word| registry::solid(word).is_some()).map(str::to_owned));
        assert_eq!(text, random_scenes::random_scene(number));
    }
    println!("{leaves} shapes of {} kinds", shapes.len());
    // But for what has no end and drawn outlines, all kinds of shapes and operators occur.
    assert!(shapes.len() >= registry::solids().count() - 7, "{shapes:?}");
}

/// The scenes of the tutorial have neither mistakes nor warnings, and each has more to see than the one before.
#[test]
fn the_tutorial_goes_up_step_by_step() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/tutorial");
    let entries = std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("a file").path());
    let mut paths: Vec<_> =
        entries.filter(|path| path.extension().is_some_and(|extension| extension == "kdl")).collect();
    paths.sort();
    assert_eq!(paths.len(), 10);
    let page = std::fs::read_to_string(format!("{folder}.md")).expect("the page");
    let mut before = 0;
    for path in paths {
        let scene = Scene::load(&path).unwrap_or_else(|error| panic!("{error:?}"));
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
        let things = scene.objects.len() + scene.lights.len() + scene.materials.len();
        let name = path.file_stem().and_then(|stem| stem.to_str()).expect("a name");
        assert!(things > before, "{name} has {things} things, the scene before it {before}");
        let (picture, link) = (format!("(tutorial/{name}.jpg)"), format!("(tutorial/{name}.kdl)"));
        assert!(page.contains(&picture) && page.contains(&link), "{name} is on the page");
        before = things;
    }
}
