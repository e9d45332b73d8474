//! Shapes that a scene declares, as people meet them: among the shapes to add, with their parameters as controls.

use pathmarch_scene::document::{ControlKind, Document, Group, ItemKind, Path, Value, key};

const TEXT: &str = "pathmarch 1
camera { position 0 1 5; target 0 1 0 }
sky 1
field \"gyroid\" {
    doc \"A wall without end.\"
    param cell 0.6 min=0.1 max=4 doc=\"Edge of a cell.\"
    param wall 0.04
    lipschitz 1.75
    bounds 2
    wgsl \"\"\"
        fn distance(p: vec3f) -> f32 {
            let k = 6.2831853 / cell; // tau
            return abs(dot(sin(k * p), cos(k * p.yzx))) / k - wall;
        }
        \"\"\"
}
object \"a\" { intersect { gyroid cell=0.7; sphere 1 } }
";

fn document() -> Document {
    let document = Document::new("scene.kdl", TEXT);
    assert!(document.scene().is_ok(), "{:?}", document.scene().err().map(|error| error.mistakes().to_vec()));
    document
}

/// The use of the shape.
fn used() -> Path {
    Path::top(4).child(0).child(0)
}

#[test]
fn they_are_in_the_outline() {
    let document = document();
    let field = document.item(&Path::top(3)).expect("the field");
    assert_eq!((field.kind, field.title()), (ItemKind::Field, "gyroid"));
    let shape = document.item(&used()).expect("its use");
    assert_eq!((shape.kind, &*shape.word), (ItemKind::Shape, "gyroid"));
    assert_eq!(document.path_of_leaf(0), Some(used()));
    assert_eq!(document.scene().expect("valid").field.leaves().len(), 2);
}

#[test]
fn parameters_are_controls() {
    let mut document = document();
    let control = document.control(&used(), "cell").expect("a control");
    assert_eq!(
        (control.value, control.default, &*control.doc),
        (Value::Number(0.7), Value::Number(0.6), "Edge of a cell.")
    );
    assert!(matches!(control.kind, ControlKind::Number(range) if range.allowed.min == 0.1 && range.allowed.max == 4.0));
    document.set(&used(), "wall", Value::Number(0.1), None).expect("set");
    assert!(document.text().contains("gyroid cell=0.7 wall=0.1;"), "{}", document.text());
    let leaf = &document.scene().expect("valid").field.leaves()[0];
    assert_eq!(leaf.params[..2], [0.7, 0.1]);
    assert!(document.set(&used(), "cell", Value::Number(5.0), None).is_err());
    document.reset(&used(), "cell").expect("reset");
    assert_eq!(document.control(&used(), "cell").expect("there").value, Value::Number(0.6));
}

#[test]
fn they_are_added_and_shapes_become_them() {
    let mut document = document();
    for (group, parent) in [(Group::Shape, Some(Path::top(4))), (Group::Object, None)] {
        let additions = document.additions(parent.as_ref());
        let addition = additions.iter().find(|addition| addition.name == "gyroid").expect("among the shapes");
        assert_eq!((addition.group, &*addition.doc), (group, "A wall without end."));
        document.add(parent.as_ref(), &addition.clone()).expect("added");
        assert!(document.scene().is_ok());
    }
    assert!(document.text().contains("gyroid 0.6 0.04"), "{}", document.text());
    let sphere = Path::top(4).child(0).child(1);
    document.set_kind(&sphere, "gyroid").expect("changed");
    document.set_kind(&used(), "box").expect("changed back");
    let kinds = document.control(&sphere, key::KIND).expect("a kind").kind;
    assert!(matches!(kinds, ControlKind::Choice(words) if words.iter().any(|word| word == "gyroid")));
    assert!(document.scene().is_ok());
}

#[test]
fn a_new_name_is_that_of_its_uses() {
    let mut document = document();
    document.rename(&Path::top(3), "lattice").expect("renamed");
    assert!(document.text().contains("field \"lattice\"") && document.text().contains("{ lattice cell=0.7;"));
    assert!(document.scene().is_ok());
    assert!(document.rename(&Path::top(3), "sphere").is_err(), "the name of another shape");
    assert!(document.remove(&Path::top(3)).is_err(), "it is in use");
}

/// A text that is wrong for a while, as while it is typed, leaves the last good scene; what is the same is not compiled again.
#[test]
fn typing_keeps_the_last_good_scene() {
    let mut document = document();
    let broken = TEXT.replace("return abs", "return abss");
    document.replace_text(broken, "Type", None);
    let error = document.scene().expect_err("a mistake");
    let mistake = &error.mistakes()[0];
    let offset = mistake.span.offset();
    assert_eq!(&document.text()[offset..offset + mistake.span.len()], "abss");
    assert_eq!(error.mistakes().len(), 1, "its use is no second mistake");
    assert!(document.last_good().is_some());
    assert_eq!(document.item(&used()).expect("still there").kind, ItemKind::Shape);
    document.undo().expect("undone");
    assert!(document.scene().is_ok());
}
