//! Steps back and forth, gestures, what is saved, and what belongs to what.

use super::{all_items, path};
use pathmarch_scene::document::{Document, ItemKind, Path, Value, key};
use pathmarch_scene::{Scene, Sky};
use std::sync::Arc;
use std::time::Instant;

const SCENE: &str = "pathmarch 1\ncamera { position 0 1 5; target 0 1 0 }\nobject \"a\" {\n    union {\n        sphere 1 // c\n        \
                     subtract { box 1; torus }\n    }\n}\nobject \"b\" { plane }\n";

#[test]
fn a_drag_is_one_step() {
    let mut document = Document::new("", SCENE);
    let sphere = path(&document, "sphere");
    for step in 1..=50 {
        document.set(&sphere, "radius", Value::Number(1.0 + step as f32 / 10.0), Some(1)).unwrap();
        document.set(&sphere, key::AT, Value::Triple([step as f32, 0.0, 0.0]), Some(1)).unwrap();
    }
    document.set(&sphere, "radius", Value::Number(2.0), Some(2)).unwrap();
    document.set(&sphere, "radius", Value::Number(3.0), None).unwrap();
    document.set(&sphere, "radius", Value::Number(4.0), None).unwrap();
    assert_eq!(document.can_undo(), Some("Change radius of sphere"));
    for text in ["sphere 3 {", "sphere 2 {", "sphere 6 { at 50 0 0 }", "sphere 1 // c"] {
        assert_eq!(document.undo().as_deref(), Some("Change radius of sphere"));
        assert!(document.text().contains(text), "{text} in {}", document.text());
    }
    assert_eq!((document.undo(), document.text()), (None, SCENE));
    for _ in 0..4 {
        assert!(document.redo().is_some());
    }
    assert!(document.redo().is_none() && document.text().contains("sphere 4 { at 50 0 0 } // c"));
    // A drag that ends where it began leaves the text as it was, and no step.
    let mut document = Document::new("", SCENE);
    for radius in [2.0, 3.0, 1.0] {
        document.set(&sphere, "radius", Value::Number(radius), Some(1)).unwrap();
    }
    assert_eq!((document.text(), document.can_undo()), (SCENE, None));
}

#[test]
fn what_changes_nothing_is_no_step() {
    let mut document = Document::new("", SCENE);
    let (sphere, b) = (path(&document, "sphere"), path(&document, "b"));
    document.set(&sphere, "radius", Value::Number(1.0), None).unwrap();
    document.set(&sphere, key::SCALE, Value::Number(1.0), None).unwrap();
    document.set(&sphere, key::MATERIAL, Value::None, None).unwrap();
    document.reset(&sphere, key::AT).unwrap();
    document.rename(&b, "b").unwrap();
    document.set_kind(&sphere, "sphere").unwrap();
    document.move_to(&sphere, sphere.parent().as_ref(), 0).unwrap();
    document.replace_text(SCENE.to_owned(), "Reload", None);
    assert_eq!((document.text(), document.can_undo(), document.revision()), (SCENE, None, 0));
}

#[test]
fn it_knows_what_is_saved() {
    let mut document = Document::new("", SCENE);
    assert!(document.is_saved());
    document.remove(&path(&document, "b")).unwrap();
    assert!(!document.is_saved());
    document.undo();
    assert!(document.is_saved());
    document.redo();
    document.mark_saved();
    assert!(document.is_saved());
    document.undo();
    assert!(!document.is_saved());
    document.replace_text(SCENE.replace("object \"b\" { plane }\n", ""), "Reload from disk", None);
    assert!(document.is_saved());
    assert_eq!(document.can_undo(), Some("Reload from disk"));
    document.undo();
    assert_eq!(document.text(), SCENE);
}

#[test]
fn broken_texts_keep_the_last_good_scene() {
    let mut document = Document::new("", SCENE);
    document.replace_text(SCENE.replace("plane", "plan"), "Reload", None);
    assert!(document.scene().is_err());
    assert_eq!(document.last_good().map(|scene| scene.objects.len()), Some(2));
    assert_eq!(document.outline().len(), 4);
    document.undo();
    assert!(document.scene().is_ok());
}

#[test]
fn leaves_belong_to_nodes() {
    let document = Document::new("", SCENE);
    let words = |leaf| document.path_of_leaf(leaf).and_then(|path| document.item(&path)).map(|item| item.word.as_str());
    assert_eq!([0, 1, 2, 3, 4].map(words), [Some("sphere"), Some("box"), Some("torus"), Some("plane"), None]);
    let scene = document.scene().unwrap();
    for (leaf, shape) in scene.field.leaves().iter().enumerate() {
        assert_eq!(words(leaf), Some(&*shape.shape.info().name));
    }
    assert_eq!(document.leaves_of(&path(&document, "subtract")), [1, 2]);
    assert_eq!(document.leaves_of(&path(&document, "a")), [0, 1, 2]);
    assert!(document.leaves_of(&Path::top(9)).is_empty());
    assert_eq!(document.path_of_object(1), Some(path(&document, "b")));
    assert_eq!(document.path_of_object(2), None);
    let lines: Vec<_> = all_items(&document).iter().map(|item| document.line_of(&item.path)).collect();
    assert_eq!(lines, [1, 2, 3, 4, 5, 6, 6, 6, 9, 9].map(Some));
    assert_eq!(document.path_at(SCENE.find("torus").unwrap()), Some(path(&document, "torus")));
    assert_eq!(document.path_at(SCENE.find("subtract").unwrap()), Some(path(&document, "subtract")));
    assert_eq!(document.path_at(SCENE.find("// c").unwrap()), Some(path(&document, "union")));
    assert_eq!(document.path_at(SCENE.len()), None);
}

#[test]
fn a_selection_follows_edits() {
    let mut document = Document::new("", SCENE);
    let selected = path(&document, "torus");
    let (from, to) = (path(&document, "subtract"), path(&document, "a"));
    let moved = document.move_to(&from, Some(&to), 0).unwrap();
    assert_eq!(selected.after_move(&from, &moved), path(&document, "torus"));
    assert_eq!(path(&Document::new("", SCENE), "sphere").after_move(&from, &moved), path(&document, "sphere"));
    let sphere = path(&document, "sphere");
    let copy = document.duplicate(&path(&document, "subtract")).unwrap();
    assert_eq!(sphere.after_insertion(&copy), path(&document, "sphere"));
    let sphere = path(&document, "sphere");
    document.remove(&copy).unwrap();
    assert_eq!(sphere.after_removal(&copy), Some(path(&document, "sphere")));
    assert_eq!(copy.child(0).after_removal(&copy), None);
}

/// What is costly to make is made once, and the same sky is the same `Arc`.
#[test]
fn skies_are_kept() {
    let head = "pathmarch 1\ncamera { position 0 1 5; target 0 1 0 }\nobject \"a\" { sphere 1 }\n";
    for sky in ["sky \"day\" elevation=30", "sky \"small.hdr\" strength=2 rotate=10"] {
        let mut document = Document::new("tests/data/test.kdl", format!("{head}{sky}\n"));
        let map = |document: &Document| match &document.scene().unwrap().sky {
            Sky::Map(map) => map.clone(),
            other => panic!("{other:?}"),
        };
        let (first, sphere) = (map(&document), path(&document, "sphere"));
        document.set(&sphere, "radius", Value::Number(2.0), None).unwrap();
        assert!(Arc::ptr_eq(&first, &map(&document)));
        let strength = path(&document, "sky");
        document.set(&strength, "strength", Value::Number(3.0), None).unwrap();
        let fresh = pathmarch_scene::Scene::parse(document.name(), document.text()).unwrap();
        assert_eq!(fresh.sky, document.scene().unwrap().sky);
        assert_ne!(first.texels, map(&document).texels);
        document.undo();
        assert_eq!(*first, *map(&document));
    }
}

/// An edit costs little more than one reading of the text, however large; idle, 10,000 objects take less than a tenth of
/// a second. Compared with a reading at the same time, for a machine may be busy.
#[test]
fn edits_are_fast() {
    let mut text =
        String::from("pathmarch 1\ncamera { position 0 1 5; target 0 1 0 }\nmaterial \"m\" { diffuse 0.5 }\n");
    for index in 0..10_000 {
        let (x, z) = (index % 100, index / 100);
        text += &format!("object \"number {index}\" material=\"m\" {{ sphere 0.25 {{ at {x}.5 1 {z} }} }}\n");
    }
    let (large, small) = (Document::new("", text), Document::new("", SCENE));
    for (mut document, title, limit) in [(large, "number 5000", 1.0), (small, "b", 0.01)] {
        let plane = path(&document, title).child(0);
        let (mut set, mut parse) = (f64::INFINITY, f64::INFINITY);
        for step in 1..=20 {
            let start = Instant::now();
            document.set(&plane, key::SCALE, Value::Number(1.0 + step as f32), Some(1)).unwrap();
            set = set.min(start.elapsed().as_secs_f64());
            let start = Instant::now();
            let scene = Scene::parse("", document.text()).unwrap();
            parse = parse.min(start.elapsed().as_secs_f64());
            drop(scene);
        }
        let start = Instant::now();
        let controls = document.controls(&plane).len();
        let look = start.elapsed().as_secs_f64();
        eprintln!(
            "{title}: set {:.3} ms, parse {:.3} ms, {controls} controls {:.3} ms",
            set * 1e3,
            parse * 1e3,
            look * 1e3
        );
        assert!(set < limit && set < 4.0 * parse + 1e-4, "{title}: {set} s");
    }
}

#[test]
fn kinds_of_items() {
    let document = Document::new("", SCENE);
    let kinds: Vec<ItemKind> = all_items(&document).iter().map(|item| item.kind).collect();
    use ItemKind::{Camera, Object, Operator, Shape, Version};
    assert_eq!(kinds, [Version, Camera, Object, Operator, Shape, Operator, Shape, Shape, Object, Shape]);
}
