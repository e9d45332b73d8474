//! Parameters and formulas: what they are worth, and when.

use pathmarch_scene::{Animation, Moment, Scene, Sky};

const HEAD: &str = "pathmarch 1\ncamera { position 0 1 5; target 0 1 0 }\n";

fn at(text: &str, moment: Moment) -> Scene {
    match Scene::parse_at("test.kdl", &format!("{HEAD}{text}"), moment) {
        Ok(scene) => scene,
        Err(error) => panic!("{:?}", miette::Report::new(error)),
    }
}

fn now(text: &str) -> Scene {
    at(text, Moment::default())
}

#[test]
fn formulas_stand_wherever_numbers_do() {
    let scene = now(r##"
param size 2
param half "size/2" min=0 max=1
render { size "320*size" "180*size"; samples "4^2" }
sky "gradient" { zenith "half/2" 0.5 "1 - half"; horizon "half" }
sun { direction "half" 1 0; irradiance half; angle "0.5*size" }
material "a" { principled "#ff0000"; roughness "half/4" }
material "b" { diffuse "half/10" }
object "o" { sphere "half + 0.5" { at size 0 "-half"; scale half } }
object "p" material="b" { box "size" { rotate 0 "degrees(pi/2)" 0 } }
object "q" { repeat 2 0 2 count="size + 1" { torus major="1" minor="half/4" } }
"##);
    assert_eq!((scene.render.size, scene.render.samples), ((640, 360), 16));
    assert_eq!(scene.sky, Sky::Gradient { zenith: [0.5, 0.5, 0.0], horizon: [1.0; 3], ground: [1.0; 3] });
    assert_eq!(scene.materials[0].values[0], [1.0, 0.0, 0.0]);
    assert_eq!(scene.materials[0].values[2][0], 0.25);
    assert_eq!(scene.materials[1].values[0], [0.1; 3]);
    let leaves = scene.field.leaves();
    assert_eq!((leaves[0].params[0], leaves[0].pose.at), (1.5, [2.0, 0.0, -1.0]));
    assert_eq!(leaves[1].params, [2.0; 3]);
    assert_eq!(leaves[2].params, [1.0, 0.25]);
    let params: Vec<_> = scene.params.iter().map(|p| (p.name.as_str(), p.value, p.range, p.animated)).collect();
    assert_eq!(params, [("size", 2.0, (None, None), false), ("half", 1.0, (Some(0.0), Some(1.0)), false)]);
    assert!(!scene.animated);
}

#[test]
fn skies_and_colours_may_be_formulas() {
    assert_eq!(now("param x 2\nsky \"x/4\"").sky, Sky::Constant([0.5; 3]));
    assert_eq!(now("param x 2\nsky x").sky, Sky::Constant([2.0; 3]));
    assert_eq!(now("param x 2\nsky x 1 \"x/4\"").sky, Sky::Constant([2.0, 1.0, 0.5]));
    assert_eq!(now("sky \"#fff\"").sky, Sky::Constant([1.0; 3]));
}

#[test]
fn scenes_depend_on_the_moment() {
    let text =
        "param speed \"90*t\" doc=\"Turn, degrees.\"\nsky 1\nobject \"o\" { sphere \"1 + frame/10\" { at t 0 speed } }";
    let mut animation = Animation::new("test.kdl", format!("{HEAD}{text}"));
    for frame in [0, 7, 48] {
        let moment = Moment::of_frame(frame, 24.0);
        let t = frame as f32 / 24.0;
        for scene in [at(text, moment), animation.at(moment).expect("a scene")] {
            assert!(scene.animated && scene.params[0].animated);
            assert_eq!((scene.moment, scene.params[0].value), (moment, 90.0 * t));
            assert_eq!(scene.params[0].doc.as_deref(), Some("Turn, degrees."));
            let leaf = &scene.field.leaves()[0];
            assert!((leaf.params[0] - (1.0 + frame as f32 / 10.0)).abs() < 1e-6);
            assert!((leaf.pose.at[0] - t).abs() < 1e-6 && (leaf.pose.at[2] - 90.0 * t).abs() < 1e-4);
        }
    }
    assert_eq!(Moment::of_seconds(2.0, 24.0), Moment::of_frame(48, 24.0));
    assert_eq!(Moment::of_seconds(1.99, 24.0).frame, 47);
    // A parameter that nothing uses makes no animation.
    assert!(!now("sky 1\nobject \"o\" { sphere }").animated);
}

#[test]
fn a_mistake_may_be_one_of_a_moment() {
    let text = format!("{HEAD}sky 1\nobject \"o\" {{ sphere \"1 - t\" }}");
    let mut animation = Animation::new("test.kdl", text);
    assert!(animation.at(Moment::default()).is_ok());
    let error = animation.at(Moment::of_seconds(1.5, 24.0)).expect_err("a negative radius");
    let mistake = &error.mistakes()[0];
    assert_eq!(
        (mistake.message.as_str(), mistake.label.as_str()),
        ("`radius` must be above 0.", "is -0.5 at t = 1.5 s, frame 36")
    );
    assert!(animation.at(Moment::of_seconds(0.5, 24.0)).is_ok());
}

/// Many long formulas are given up before they take long.
#[test]
fn formulas_take_a_bounded_time() {
    let long = format!("{}1", "sin(1)*".repeat(90));
    let mut text = format!("{HEAD}sky 1\nobject \"o\" {{\n");
    (0..20_000).for_each(|_| text += &format!("sphere \"{long}\" {{ at \"{long}\" \"{long}\" \"{long}\" }}\n"));
    text.truncate(16_000_000);
    let text = &text[..text.rfind("sphere").unwrap()];
    let start = std::time::Instant::now();
    let _ = Scene::parse("test.kdl", &format!("{text}}}"));
    assert!(start.elapsed().as_secs() < 10, "{:?}", start.elapsed());
}
