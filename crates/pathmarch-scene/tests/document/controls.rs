//! Every parameter of every node: it has a control, the control's limits are the parser's, and setting it changes it
//! alone.

use super::{all_items, path};
use pathmarch_field::Outline;
use pathmarch_field::{Unit, registry};
use pathmarch_scene::document::{Control, ControlKind, Document, Item, ItemKind, Value, key};
use pathmarch_scene::{Scene, materials, textures};
use std::collections::HashSet;

const HEAD: &str = "pathmarch 1\ncamera \"first\" { position 0 1 5; target 0 1 0 }\n\
                    material \"white\" { diffuse 0.5 }\nmaterial \"other\" { emit 1 }\n";

/// A picture, as seen from the document.
const PICTURE_FILE: &str = "../../../../scenes/spot.png";

/// Nodes that together have every parameter there is.
pub(super) fn nodes() -> Vec<(String, &'static str)> {
    let mut nodes: Vec<(String, &'static str)> = [
        ("camera \"it\" { position 0 1 5; target 0 1 0 }", "it"),
        ("camera \"it\" {\n    position 0 1 5\n    target 0 1 0\n    up 0 2 0\n    fov 30\n    lens radius=0.1 focus=3\n    exposure 1\n}", "it"),
        ("render", "render"),
        ("render {\n\tsize 64 48\n\tsamples 4\n\tbounces 2\n\ttonemap \"srgb\"\n\tsampler independent\n\tcaustics \"fast\"\n\tclamp 3\n\tdetail 0.5\n}", "render"),
        ("sky 0.5", "sky"),
        ("sky \"#102030\"", "sky"),
        ("sky \"gradient\" { zenith 1; horizon 0.5 0.4 0.3 }", "sky"),
        ("sky \"gradient\" { zenith 1; horizon 0.5 0.4 0.3; ground \"#fff\" }", "sky"),
        ("sky \"day\"", "sky"),
        ("sky \"day\" elevation=30 azimuth=10 haze=2 strength=2 sun=#false { ground 0.3 }", "sky"),
        ("sky \"small.hdr\"", "sky"),
        ("sky \"small.hdr\" rotate=20 strength=2", "sky"),
        ("sun { direction 1 2 3; irradiance 1 }", "sun"),
        ("sun {\n    direction 1 2 3 // c\n    irradiance 1 2 3\n    angle 2\n    penumbra 8 }", "sun"),
        ("point { at 1 2 3; intensity 1 }", "point"),
        ("point { at 1 2 3; intensity 1 2 3; penumbra 3; }", "point"),
        ("param it 1", "it"),
        ("param \"it\" 1 min=0 max=2 doc=\"What it does.\"", "it"),
        ("object \"it\" { sphere }", "it"),
        ("object it material=white { sphere }", "it"),
        ("object it material=other lumen=30 { sphere }", "it"),
    ]
    .into_iter()
    .map(|(text, title)| (text.to_owned(), title))
    .collect();
    for kind in materials::kinds() {
        let value = |param: &materials::MaterialParam| format!("{} {}", param.name(), param.default_in_words());
        let all: Vec<String> = kind.params.iter().skip(1).map(value).collect();
        nodes.push((format!("material \"it\" {{ {} }}", kind.name), "it"));
        nodes.push((
            format!("material it {{\n  {} {}\n  {}\n}}", kind.name, kind.params[0].spec.default, all.join("\n  ")),
            "it",
        ));
    }
    nodes.push((
        format!(
            "material \"it\" {{ metal {{ fbm {{ colour 1 at=0.1; colour 0.5 at=0.4; colour 0 at=0.9 }} }}\n    \
             decal \"{PICTURE_FILE}\" size=2 depth=1 angle=20 opacity=0.5 world=#true {{\n        at 1 2 3\n    }}\n}}"
        ),
        "it",
    ));
    for kind in textures::kinds() {
        let name = kind.name;
        let all: Vec<String> = kind.params.iter().map(|param| format!("{}={}", param.name, param.default)).collect();
        let all = all.join(" ");
        nodes.push((format!("material \"it\" {{ diffuse {{ {name} }} }}"), "it"));
        nodes.push((
            format!(
                "material \"it\" {{ principled {{ {name} {all} {{ colour 1; colour \"#102030\"; at 1 2 3 }} }}\n    roughness {{ {name} from=0.1 \
                 to=0.2 }}\n    bump {{\n        {name} height=0.1 {{ rotate 1 2 3; scale 2 }}\n    }}\n}}"
            ),
            "it",
        ));
    }
    nodes.push((
        "material \"it\" { metal 0.5; orbit-trap \"line\" from=0.2 to=2 { colour 0.1; colour 1 0.5 0.2 } }".to_owned(),
        "it",
    ));
    for shape in registry::shapes() {
        let name = &*shape.info().name;
        let default = |param: &pathmarch_field::Param| format!("{}", param.default);
        let all: Vec<String> = shape.params().iter().map(default).collect();
        let named: Vec<String> =
            shape.params().iter().map(|param| format!("{}={}", param.name, param.default)).collect();
        let normal = if shape.info().facing { "normal 0 1 1" } else { "" };
        let (open, close) = if shape.info().profile { ("extrude {", "}") } else { ("", "") };
        nodes.push((format!("object \"o\" {{ {open} {name}; {close} }}"), name));
        nodes.push((
            format!(
                "object \"o\" {{ {open} {name} material=\"white\" {} {{ at 1 2 3; rotate 1 2 3; scale 2\n{normal} }} {close} }}",
                (if shape.info().outline.is_some() { &named } else { &all }).join(" ")
            ),
            name,
        ));
        nodes.push((
            format!(
                "object \"o\" {{ {open}\n    {name} {} {{\n        scale 2 // c\n    }}\n{close} }}",
                named.join(" ")
            ),
            name,
        ));
        match shape.info().outline {
            Some(Outline::Points) => nodes.push((
                format!("object \"o\" {{ {open} {name} {{ point 0 0; point 1 0\n point 0 1 }} {close} }}"),
                name,
            )),
            Some(Outline::Text) => nodes.push((
                format!("object \"o\" {{ {open} {name} \"a b\" size=0.3 font=\"../../fonts/Cantarell-Regular.ttf\" {close} }}"),
                name,
            )),
            Some(Outline::Curve) => nodes.push((
                format!("object \"o\" {{ {open} {name} 0.1 {{ point 0 0; point 1 0 corner=#true\n point 0 1 }} {close} }}"),
                name,
            )),
            Some(Outline::Path) => nodes.push((
                format!("object \"o\" {{ {open} {name} \"M 0 0 H 1 V 1 Z\" width=0.1 {close} }}"),
                name,
            )),
            None => {}
        }
        if shape.info().size_params > 1 {
            nodes.push((format!("object \"o\" {{ {open} {name} 3; {close} }}"), name));
        }
    }
    for operator in registry::operators() {
        let name = &*operator.info().name;
        nodes.push((format!("object \"o\" {{ {name} {{ sphere; box }} }}"), name));
        let properties = match operator.params().first() {
            Some(param) => &[format!("{}=0.2", param.name), "0.3".to_owned()][..],
            None => &["smooth=0.2", "smooth=0.2 profile=\"stairs\" steps=3"].map(str::to_owned)[..],
        };
        for properties in properties {
            nodes.push((
                format!(
                    "object \"o\" {{\n  {name} {properties} material=white {{\n    at 0 1 0\n    sphere\n    box\n  }}\n}}"
                ),
                name,
            ));
        }
    }
    for modifier in registry::modifiers() {
        let name = &*modifier.info().name;
        let words = modifier.params().iter().map(|param| match param.unit {
            Unit::Axis => (&*param.name, "\"y\"".to_owned()),
            _ => (&*param.name, param.default.to_string()),
        });
        let words: Vec<(&str, String)> = words.collect();
        let places: Vec<&str> = words.iter().map(|(_, value)| &**value).collect();
        let named: Vec<String> = words.iter().map(|(word, value)| format!("{word}={value}")).collect();
        nodes.push((format!("object \"o\" {{ {name} {{ sphere; box }} }}"), name));
        nodes.push((format!("object \"o\" {{ {name} {} {{ sphere; box }} }}", places.join(" ")), name));
        nodes.push((
            format!(
                "object \"o\" {{\n  {name} {} material=white {{\n    at 0 1 0\n    sphere\n    box\n  }}\n}}",
                named.join(" ")
            ),
            name,
        ));
    }
    nodes
}

pub(super) fn document(node: &str) -> Document {
    let document = Document::new("tests/data/test.kdl", format!("{HEAD}{node}\n"));
    let problem = document.scene().err().map(|error| error.mistakes()[0].message.clone());
    assert_eq!(problem, None, "{node}");
    document
}

/// Values that a control takes, and values that it does not.
fn values(control: &Control) -> (Vec<Value>, Vec<Value>) {
    match &control.kind {
        ControlKind::Number(range) => {
            let (low, high) = range.soft;
            assert!(range.accepts(low) && range.accepts(high) && low < high, "{control:?}");
            let mut good = vec![low, high, (0.5 * (low + high)).round().clamp(low, high)];
            good.extend(control.default.clone().number());
            let mut bad = vec![f32::NAN, f32::INFINITY];
            let end = |end: f32, allowed: bool, step: f32, good: &mut Vec<f32>, bad: &mut Vec<f32>| {
                if end.abs() < f32::MAX {
                    if allowed {
                        good.push(end)
                    } else {
                        bad.push(end)
                    }
                    bad.push(end + step * end.abs().max(1.0));
                }
            };
            end(range.allowed.min, range.allowed.min_allowed, -0.01, &mut good, &mut bad);
            end(range.allowed.max, range.allowed.max_allowed, 0.01, &mut good, &mut bad);
            if range.whole {
                bad.push(range.allowed.min + 0.5);
            }
            (good.into_iter().map(Value::Number).collect(), bad.into_iter().map(Value::Number).collect())
        }
        ControlKind::Triple { direction } => {
            let good = [[1.0, 2.5, -3.0], [0.125, 1e-4, 7.0]].map(Value::Triple).to_vec();
            let mut bad = vec![Value::Triple([0.0, f32::NAN, 0.0])];
            bad.extend(direction.then_some(Value::Triple([0.0; 3])));
            (good, bad)
        }
        ControlKind::Colour { max } => {
            let top = max.min(1000.0);
            let good = [[0.0; 3], [0.5, 0.25, 0.125], [top, 0.0, 0.3], [0.4; 3]].map(Value::Colour).to_vec();
            let mut bad = vec![Value::Colour([0.1, -0.1, 0.1])];
            bad.extend((*max < f32::MAX).then_some(Value::Colour([0.1, 0.1, max * 1.01])));
            (good, bad)
        }
        ControlKind::Choice(words) if control.key != key::KIND => {
            (words.iter().map(|word| Value::Text(word.to_string())).collect(), vec![Value::Text("teapot".to_owned())])
        }
        ControlKind::Choice(_) => (Vec::new(), vec![Value::Text("teapot".to_owned())]),
        ControlKind::Text if control.key == key::PATH => {
            (vec![Value::Text("M 0 0 H 2 V 1 Z".to_owned())], vec![Value::Text(String::new())])
        }
        // Formulas could not name what is no name.
        ControlKind::Text => (vec![Value::Text("new_name".to_owned())], vec![Value::Text(String::new())]),
        ControlKind::Picture => (Vec::new(), vec![Value::Text(String::new())]),
        ControlKind::Flag => ([true, false].map(Value::Flag).to_vec(), vec![Value::Number(1.0)]),
        ControlKind::Material(names) => {
            (names.iter().cloned().map(Value::Text).collect(), vec![Value::Text("teapot".to_owned())])
        }
        ControlKind::Size { min, max } => (
            [[*min, *max], [640, 480]].map(Value::Size).to_vec(),
            [[*min - 1, 5], [5, *max + 1]].map(Value::Size).to_vec(),
        ),
    }
}

trait Number {
    fn number(self) -> Option<f32>;
}
impl Number for Value {
    fn number(self) -> Option<f32> {
        if let Value::Number(number) = self { Some(number) } else { None }
    }
}

/// All of a scene but its texts, as text.
pub(super) fn meaning(scene: &Scene) -> String {
    let Scene { cameras, render, sky, lights, materials, objects, field, params, .. } = scene;
    let parts =
        |m: &materials::Material| format!("{:?}{:?}{:?}{:?}{:?}", m.values, m.orbit_trap, m.textured, m.decals, m.bump);
    let materials: Vec<_> = materials.iter().map(|m| (&m.name, m.kind.name, parts(m))).collect();
    let sky = match sky {
        pathmarch_scene::Sky::Map(map) => format!("{map:?} {:?}", &map.texels[map.texels.len() / 3]),
        sky => format!("{sky:?}"),
    };
    let objects: Vec<_> = objects.iter().map(|object| (&object.name, object.material, &object.root)).collect();
    format!("{params:?}\n{cameras:?}\n{render:?}\n{sky}\n{lights:?}\n{materials:?}\n{objects:?}\n{:?}", field.leaves())
}

/// What each control of each node holds.
fn all_values(document: &Document) -> Vec<(String, String, Value)> {
    let items: Vec<Item> = all_items(document);
    let controls = items.iter().flat_map(|item| {
        document
            .controls(&item.path)
            .into_iter()
            .map(|control| (item.path.to_string(), control.key.to_string(), control.value))
    });
    controls.collect()
}

mod slow {
    use super::*;

    #[test]
    fn setting_a_control_changes_it_alone() {
        let mut count = 0;
        for (node, title) in nodes() {
            let original = document(&node);
            let at = path(&original, title);
            let controls = original.controls(&at);
            let keys: HashSet<&str> = controls.iter().map(|control| &*control.key).collect();
            assert_eq!(keys.len(), controls.len(), "keys of {title}: {controls:?}");
            let before = all_values(&original);
            for control in &controls {
                assert!(!control.doc.is_empty() && !control.label.is_empty(), "{control:?}");
                let (good, bad) = values(control);
                for value in bad {
                    let mut document = document(&node);
                    assert!(
                        document.set(&at, &control.key, value.clone(), None).is_err(),
                        "{} = {value:?} in {node}",
                        control.key
                    );
                    assert_eq!(document.text(), original.text());
                }
                for value in good {
                    let mut document = document(&node);
                    let context = format!("{} = {value:?} in {node}", control.key);
                    document
                        .set(&at, &control.key, value.clone(), None)
                        .unwrap_or_else(|error| panic!("{context}: {error}"));
                    count += 1;
                    assert_eq!(
                        document.control(&at, &control.key).map(|control| control.value),
                        Some(value.clone()),
                        "{context}"
                    );
                    let after = all_values(&document);
                    let renamed = control.key == key::NAME;
                    // A texture, an orbit trap and a material that emits bring controls of their own.
                    let brings =
                        control.key.ends_with(key::TEXTURE) || ["orbit-trap", key::MATERIAL].contains(&&*control.key);
                    assert!(brings || before.len() == after.len(), "{context}");
                    let find =
                        |old: &(String, String, Value)| after.iter().find(|new| (&new.0, &new.1) == (&old.0, &old.1));
                    let owner = control.key.split('.').next();
                    let is_beside = |old: &&(String, String, Value)| old.1.split('.').next() != owner;
                    let pairs: Vec<_> = match brings {
                        true => before.iter().filter(is_beside).filter_map(|old| Some((old, find(old)?))).collect(),
                        false => before.iter().zip(&after).collect(),
                    };
                    for (old, new) in pairs {
                        let same = old == new || (&*old.0, &*old.1) == (&*at.to_string(), &*control.key);
                        assert!(same || renamed, "{context}: {old:?} became {new:?}\n{}", document.text());
                    }
                    let scene = document.scene().unwrap();
                    let changed = meaning(scene) != meaning(original.scene().unwrap());
                    // The material of an object whose shapes have their own is nothing in the picture, but is in the object.
                    let idle = ["profile", "steps"].contains(&&*control.key) && !node.contains("smooth=");
                    assert_eq!(changed, value != control.value && !idle, "{context}\n{}", document.text());
                    if document.text() != original.text() {
                        assert!(document.undo().is_some());
                    }
                    assert_eq!(document.text(), original.text());
                }
            }
        }
        assert!(count > 1500, "{count} values");
    }
}

#[test]
fn resetting_a_control_gives_its_default() {
    for (node, title) in nodes() {
        let original = document(&node);
        let at = path(&original, title);
        let before = all_values(&original);
        for control in original.controls(&at) {
            let mut document = document(&node);
            let context = format!("{} in {node}", control.key);
            let result = document.reset(&at, &control.key);
            assert_eq!(result.is_err(), control.required, "{context}");
            let stays = control.required || !control.given;
            assert!(!stays || document.text() == original.text(), "{context}");
            if control.required {
                continue;
            }
            let now = document.control(&at, &control.key).unwrap();
            assert_eq!(now.value, control.default, "{context}\n{}", document.text());
            let is_decal = control.key.starts_with("decal.") && control.key.ends_with(key::PICTURE);
            let brings = control.key.ends_with(key::TEXTURE) || control.key == "orbit-trap" || is_decal;
            for (old, new) in before.iter().zip(&all_values(&document)).filter(|_| !brings) {
                assert!(old == new || old.1 == control.key, "{context}: {old:?} became {new:?}\n{}", document.text());
            }
            document.undo();
            assert_eq!(document.text(), original.text());
        }
    }
}

/// The parser's own limits, found by what it accepts, are those of the control: a control written with values just
/// outside of them is a mistake, and with every value inside it is none.
#[test]
fn limits_are_those_of_the_parser() {
    let mut tried = 0;
    for (node, title) in nodes() {
        let original = document(&node);
        let at = path(&original, title);
        for control in original.controls(&at) {
            let (good, bad) = values(&control);
            // A value is written by way of one that is allowed, then replaced in the text.
            let Some(Value::Number(_)) = good.first() else { continue };
            let candidates = match &control.kind {
                ControlKind::Number(range) if range.whole => [range.allowed.min + 3.0, range.allowed.min + 7.0],
                ControlKind::Number(range) => [range.allowed.min.max(0.5) + 0.0625, range.allowed.min.max(0.5) + 0.125],
                _ => continue,
            };
            let marker = if control.value == Value::Number(candidates[0]) { candidates[1] } else { candidates[0] };
            let mut document = document(&node);
            document.set(&at, &control.key, Value::Number(marker), None).unwrap();
            let (before, written) = (original.text(), document.text());
            let number = marker.to_string();
            let differs = before.bytes().zip(written.bytes()).take_while(|(a, b)| a == b).count();
            let from = differs.saturating_sub(number.len());
            let place = from + written[from..].find(&number).unwrap_or_else(|| panic!("{number} in {written}"));
            for (values, accepted) in [(good, true), (bad, false)] {
                for value in values.into_iter().filter_map(Number::number).filter(|value| value.is_finite()) {
                    let text = format!("{}{value}{}", &written[..place], &written[place + number.len()..]);
                    let result = Scene::parse("tests/data/test.kdl", &text);
                    assert_eq!(result.is_ok(), accepted, "{} = {value}:\n{text}", control.key);
                    tried += 1;
                }
            }
        }
    }
    assert!(tried > 500, "{tried} values");
}

/// Words that the parser knows have controls. It lists them itself, in its answer to a misspelt one.
#[test]
fn every_word_of_the_parser_has_a_control() {
    let cases = [
        ("camera \"it\" { position 0 1 5; target 0 1 0; ZZ }", "it"),
        ("render { ZZ }", "render"),
        ("sun { direction 1 2 3; irradiance 1; ZZ }", "sun"),
        ("point { at 1 2 3; intensity 1; ZZ }", "point"),
        ("spot { at 1 2 3; target 0 0 0; intensity 1; ZZ }", "spot"),
        ("sky \"gradient\" { zenith 1; horizon 1; ZZ }", "sky"),
        ("sky \"day\" { ZZ }", "sky"),
        ("sky \"day\" ZZ=1", "sky"),
        ("sky \"small.hdr\" ZZ=1", "sky"),
        ("camera \"it\" { position 0 1 5; target 0 1 0; lens ZZ=1 }", "it"),
        ("object \"it\" ZZ=1 { sphere }", "it"),
        ("object \"o\" { union ZZ=1 { sphere } }", "union"),
        ("object \"o\" { sphere { ZZ } }", "sphere"),
        ("object \"o\" { plane { ZZ } }", "plane"),
        ("object \"o\" { sphere ZZ=1 }", "sphere"),
        ("object \"o\" { rounded-box ZZ=1 }", "rounded-box"),
        ("material \"it\" { principled 1; ZZ }", "it"),
    ];
    for (node, title) in cases {
        let misspelt = Document::new("tests/data/test.kdl", format!("{HEAD}{node}\n"));
        let mistake = misspelt.scene().expect_err("misspelt").mistakes()[0].clone();
        let help = mistake.help.expect("help");
        let words: Vec<&str> = help.split('`').skip(1).step_by(2).collect();
        assert!(help.starts_with("Expected") && !words.is_empty(), "{help}");
        let document = document(&node.replace("; ZZ", "").replace("ZZ=1", "").replace(" { ZZ }", ""));
        let controls = document.controls(&path(&document, title));
        let keys: Vec<&str> = controls.iter().map(|control| &*control.key).collect();
        for word in words {
            let kinds = materials::kinds().iter().any(|kind| kind.name == word);
            let known = keys
                .iter()
                .any(|key| *key == word || key.rsplit('.').next() == Some(word) || key.split('.').next() == Some(word));
            // A light shows its intensity in the unit that it is given in.
            let other_unit = matches!(word, "candela" | "lumen" | "colour") && matches!(title, "point" | "spot");
            // Only an object that emits has a flux.
            let is_flux = word == "lumen" && title == "it";
            assert!(known || kinds || other_unit || is_flux, "{word} of {title} in {keys:?}");
        }
    }
}

#[test]
fn decals_are_added_changed_and_removed() {
    let mut it = document("material \"m\" { diffuse 0.5 }");
    let material = path(&it, "m");
    let text = |it: &Document| it.text().lines().last().expect("a line").replace(PICTURE_FILE, "p.png");
    let picture = || Value::Text(PICTURE_FILE.to_owned());
    it.set(&material, "decal.1.picture", picture(), None).expect("set");
    it.set(&material, "decal.2.picture", picture(), None).expect("set");
    it.set(&material, "decal.2.size", Value::Number(0.5), None).expect("set");
    it.set(&material, "decal.1.at", Value::Triple([1.0, 2.0, 3.0]), None).expect("set");
    let expected = "material \"m\" { diffuse 0.5; decal \"p.png\" { at 1 2 3 }; decal \"p.png\" size=0.5 }";
    assert_eq!(text(&it), expected);
    it.reset(&material, "decal.1.picture").expect("reset");
    assert_eq!(text(&it), "material \"m\" { diffuse 0.5; decal \"p.png\" size=0.5 }");
    let controls = it.controls(&material);
    let given = controls.iter().filter(|control| control.key.starts_with("decal.") && control.given);
    assert_eq!(given.map(|control| &*control.key).collect::<Vec<_>>(), ["decal.1.picture", "decal.1.size"]);
}

#[test]
fn lights_show_their_intensity_in_its_unit() {
    let keys = |intensity: &str| {
        let document = document(&format!("spot {{ at 0 2 0; target 0 0 0; {intensity} }}"));
        let controls = document.controls(&path(&document, "spot"));
        let units = ["intensity", "candela", "lumen", "colour"];
        let shown = controls.into_iter().map(|control| control.key.into_owned());
        shown.filter(|key| units.contains(&key.as_str())).collect::<Vec<_>>()
    };
    assert_eq!(keys("intensity 3"), ["intensity"]);
    assert_eq!(keys("candela 3"), ["candela", "colour"]);
    assert_eq!(keys("lumen 3; colour 1 0.5 0"), ["lumen", "colour"]);
}

#[test]
fn the_registries_are_what_can_be_added() {
    let document = document("object \"it\" { union { sphere; extrude { circle } } }");
    for (parent, kind) in [
        (None, "top"),
        (Some(path(&document, "it")), "object"),
        (Some(path(&document, "union")), "operator"),
        (Some(path(&document, "extrude")), "operator of profiles"),
    ] {
        for addition in document.additions(parent.as_ref()) {
            let mut document = Document::new("", document.text());
            let added = document
                .add(parent.as_ref(), &addition)
                .unwrap_or_else(|error| panic!("{addition:?} to {kind}: {error}"));
            let item = document.item(&added).unwrap();
            assert!(document.scene().is_ok() && !addition.doc.is_empty());
            fn is_in(name: &str, item: &Item) -> bool {
                item.word == name || item.children.iter().any(|child| is_in(name, child))
            }
            let named = item.material.as_deref() == Some(&*addition.name)
                || is_in(&addition.name, item)
                || item.kind == ItemKind::Sky;
            assert!(named, "{addition:?}: {item:?}");
        }
    }
    let names: Vec<_> =
        document.additions(Some(&path(&document, "it"))).into_iter().map(|addition| addition.name).collect();
    assert_eq!(names, registry::solids().map(|solid| &*solid.info().name).collect::<Vec<_>>());
}

#[test]
fn every_shape_and_material_can_become_every_other() {
    for (from, from_title) in nodes() {
        let original = document(&from);
        let at = path(&original, from_title);
        let Some(control) = original.control(&at, key::KIND) else { continue };
        let ControlKind::Choice(kinds) = &control.kind else { panic!("{control:?}") };
        for kind in kinds.iter().filter(|kind| **kind != "picture") {
            let mut document = document(&from);
            document.set_kind(&at, kind).unwrap_or_else(|error| panic!("{from} to {kind}: {error}"));
            let now = document.control(&at, key::KIND).unwrap();
            assert_eq!(now.value, Value::Text(kind.to_string()), "{}", document.text());
            let old: Vec<_> = original.controls(&at).into_iter().filter(|control| control.given).collect();
            for control in document.controls(&at) {
                let same =
                    old.iter().find(|old| old.key == control.key && old.kind == control.kind && old.key != key::KIND);
                // A sky's colours are its own.
                if let Some(same) = same.filter(|_| from_title != "sky") {
                    assert_eq!(same.value, control.value, "{from} to {kind}:\n{}", document.text());
                }
            }
        }
    }
}
