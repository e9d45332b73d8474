//! Controls of which numbers are formulas.

use super::controls::{document, meaning, nodes};
use super::path;
use pathmarch_scene::document::{Document, EditError, ItemKind, Value, key};
use pathmarch_scene::{Camera, Moment};

const HEAD: &str = "pathmarch 1\ncamera { position 0 1 5; target 0 1 0 }\nsky 1\n";

/// The numbers of a value.
fn numbers(value: &Value) -> Option<Vec<f32>> {
    match value {
        Value::Number(number) => Some(vec![*number]),
        Value::Triple(numbers) | Value::Colour(numbers) => Some(numbers.to_vec()),
        Value::Size(size) => Some(size.map(|side| side as f32).to_vec()),
        _ => None,
    }
}

#[test]
fn every_number_may_become_a_formula_and_a_number_again() {
    let mut count = 0;
    for (node, title) in nodes() {
        let original = document(&node);
        let at = path(&original, title);
        let before = meaning(original.scene().unwrap());
        for control in original.controls(&at) {
            assert_eq!(control.value, control.present, "{control:?}");
            let Some(now) = numbers(&control.value) else { continue };
            let what = format!("{} of {node}", control.key);
            let texts: Vec<String> = now.iter().map(|number| format!("({number})*1")).collect();
            let mut document = document(&node);
            let formulas = Value::Formulas(texts);
            document.set(&at, &control.key, formulas.clone(), None).unwrap_or_else(|error| panic!("{what}: {error}"));
            // A place that is written differs from none.
            let same = meaning(document.scene().unwrap()) == before;
            assert!(same || !control.given, "{what}: {}", document.text());
            let read = document.control(&at, &control.key).unwrap();
            assert_eq!((&read.value, &read.present, read.given), (&formulas, &control.value, true), "{what}");
            // What it is worth changes nothing; other numbers do not take its place.
            document.set(&at, &control.key, control.value.clone(), None).unwrap();
            assert_eq!(document.control(&at, &control.key).unwrap().value, formulas, "{what}");
            let other = match &control.value {
                Value::Number(number) => Value::Number(number * 0.75),
                Value::Triple(numbers) => Value::Triple(numbers.map(|number| number * 0.75 + 0.1)),
                Value::Colour(numbers) => Value::Colour(numbers.map(|number| number * 0.75 + 0.1)),
                _ => Value::Size([33, 44]),
            };
            let text = document.text().to_owned();
            assert!(
                numbers(&other) == Some(now.clone()) || document.set(&at, &control.key, other, None).is_err(),
                "{what}"
            );
            assert_eq!(document.text(), text);
            // Typed numbers do.
            let plain = Value::Formulas(now.iter().map(f32::to_string).collect());
            document.set(&at, &control.key, plain, None).unwrap();
            let back = document.control(&at, &control.key).unwrap();
            assert_eq!((back.value, back.present), (control.value.clone(), control.value), "{what}");
            assert!(!document.text().contains(")*1"), "{}", document.text());
            count += 1;
        }
    }
    assert!(count > 200, "{count}");
}

#[test]
fn handles_move_what_is_no_formula() {
    let text = format!("{HEAD}object \"o\" {{ sphere {{ at 1 \"2*t + 1\" 3; rotate 0 \"90*t\" 0 }} }}\n");
    let mut document = Document::new("", text);
    document.set_moment(Moment::of_seconds(0.5, 24.0));
    let at = path(&document, "sphere");
    let control = document.control(&at, key::AT).unwrap();
    assert_eq!(control.present, Value::Triple([1.0, 2.0, 3.0]));
    document.set(&at, key::AT, Value::Triple([4.0, 2.0001, 3.0]), None).unwrap();
    assert!(document.text().contains("at 4 \"2*t + 1\" 3;"), "{}", document.text());
    let error = document.set(&at, key::AT, Value::Triple([4.0, 2.5, 3.0]), None).unwrap_err();
    assert_eq!(error.to_string(), "`position` is the formula \"2*t + 1\". Change that, or reset it first.");
    assert!(matches!(error, EditError::Formula { .. }));
    document.set(&at, key::AT, Value::Formulas(["1", "t", "2 + 1"].map(str::to_owned).to_vec()), None).unwrap();
    assert!(document.text().contains("at 1 \"t\" \"2 + 1\";"), "{}", document.text());
    let wrong = Value::Formulas(["1", "tt", "2 + 1"].map(str::to_owned).to_vec());
    let error = document.set(&at, key::AT, wrong, None).unwrap_err().to_string();
    assert_eq!(
        error,
        "This would make a mistake in the scene: There is no parameter `tt`. Declare it at the top: param tt 1."
    );
    document.reset(&at, key::ROTATE).unwrap();
    assert!(!document.text().contains("rotate"), "{}", document.text());
}

#[test]
fn parameters_are_controls() {
    let text = format!(
        "{HEAD}param spin 30 min=0 max=90 doc=\"Turn of the mill.\"\nparam half \"spin/2 + 1e1 - 10\"\n\
         object \"o\" {{ sphere {{ rotate 0 spin \"spin + half\" }} }}\nobject \"spin\" {{ sphere }}\n"
    );
    let mut document = Document::new("", text);
    let at = path(&document, "spin");
    assert_eq!(document.item(&at).unwrap().kind, ItemKind::Param);
    let control = document.control(&at, key::VALUE).unwrap();
    assert_eq!((&control.value, &*control.doc), (&Value::Number(30.0), "Turn of the mill."));
    document.set(&at, key::VALUE, Value::Number(45.0), None).unwrap();
    assert!(document.text().contains("param spin 45 min=0 max=90"));
    assert_eq!(document.scene().unwrap().params[1].value, 22.5);
    assert!(document.set(&at, key::VALUE, Value::Number(91.0), None).is_err());
    document.rename(&at, "turn").unwrap();
    let expected = "param turn 45 min=0 max=90 doc=\"Turn of the mill.\"\nparam half \"turn/2 + 1e1 - 10\"\n\
                    object \"o\" { sphere { rotate 0 \"turn\" \"turn + half\" } }\nobject \"spin\" { sphere }\n";
    assert_eq!(document.text().strip_prefix(HEAD).unwrap(), expected);
    let copy = document.duplicate(&at).unwrap();
    assert_eq!(document.item(&copy).unwrap().title(), "turn_2");
    assert!(document.rename(&copy, "sin").is_err() && document.rename(&copy, "a b").is_err());
    let error = document.remove(&at).unwrap_err().to_string();
    assert!(error.starts_with("This would make a mistake in the scene: There is no parameter `turn`."), "{error}");
    document.remove(&copy).unwrap();
}

#[test]
fn kinds_keep_formulas() {
    let text = format!(
        "{HEAD}param r 0.5\nmaterial \"m\" {{ metal 0.9; roughness \"r/2\" }}\n\
         object \"o\" {{ cylinder r height=\"2*r\" {{ at 0 r 0 }} }}\n"
    );
    let mut document = Document::new("", text);
    document.set_kind(&path(&document, "cylinder"), "capsule").unwrap();
    document.set_kind(&path(&document, "m"), "glass").unwrap();
    assert!(document.text().contains("capsule \"r\" \"2*r\" { at 0 r 0 }"), "{}", document.text());
    assert!(document.text().contains("roughness \"r/2\""), "{}", document.text());
    assert_eq!(document.scene().unwrap().field.leaves()[0].params, [0.5, 1.0]);
}

#[test]
fn a_camera_with_formulas_is_not_overwritten() {
    let text = "pathmarch 1\ncamera { position \"sin(t)\" 1 5; target 0 1 0 }\nsky 1\nobject \"o\" { sphere }\n";
    let mut document = Document::new("", text);
    let scene = document.scene().unwrap().clone();
    let at = path(&document, "main");
    let moved = Camera { position: [0.0, 2.0, 4.0], ..scene.cameras[0].clone() };
    document.write_camera(&moved, Some(&at)).unwrap();
    assert!(document.text().contains("position \"sin(t)\" 2 4;"), "{}", document.text());
    let moved = Camera { position: [1.0, 2.0, 4.0], ..scene.cameras[0].clone() };
    assert!(document.write_camera(&moved, Some(&at)).is_err());
}
