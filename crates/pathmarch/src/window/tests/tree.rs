//! Scene tree: rows and context menus.

use super::*;

#[test]
fn everything_is_listed_and_selected_by_a_click() {
    let mut person = Person::at_scene();
    let rows = [
        "camera “main”",
        "camera “other”",
        "render",
        "sky",
        "material “red”",
        "material “grey”",
        "object “ball”",
        "sphere",
        "object “carved”",
        "subtract",
        "box",
        "object “floor”",
        "plane",
    ];
    for row in rows {
        assert!(person.harness.query_all_by_role_and_label(Role::TreeItem, row).next().is_some(), "{row}");
    }
    person.click_role(Role::TreeItem, "material “red”");
    assert_eq!(person.selected().as_deref(), Some("red"));
    assert!(person.has("line 14"), "the inspector shows its line");
    person.click_role(Role::TreeItem, "box");
    assert_eq!(person.selected().as_deref(), Some("box"));
    person.key(Key::Escape);
    assert_eq!(person.selected(), None);
    assert!(person.has("Nothing selected"));
}

#[test]
fn rows_are_collapsed() {
    let mut person = Person::at_scene();
    assert!(person.harness.query_by_role_and_label(Role::TreeItem, "box").is_some());
    person.click("Collapse subtract");
    assert!(person.harness.query_by_role_and_label(Role::TreeItem, "box").is_none());
    person.click("Expand subtract");
    assert!(person.harness.query_by_role_and_label(Role::TreeItem, "box").is_some());
}

#[test]
fn a_row_is_renamed() {
    let mut person = Person::at_scene();
    person.context("material “red”", &["Rename"]);
    person.retype("crimson");
    let changed = changed_lines(SCENE, person.text());
    assert_eq!(changed.len(), 2, "the material and what is made of it: {changed:?}");
    assert!(changed.iter().all(|(_, new)| new.contains("\"crimson\"")), "{changed:?}");
    // Escape and a name that is taken change nothing.
    person.context("material “crimson”", &["Rename"]);
    person.ctrl(Key::A);
    person.harness.event(egui::Event::Text("blue".to_owned()));
    person.wait(2);
    person.key(Key::Escape);
    assert!(person.text().contains("crimson") && !person.text().contains("blue"));
    person.context("material “crimson”", &["Rename"]);
    person.retype("grey");
    assert!(person.text().contains("crimson"));
    assert_eq!(person.app().toasts.iter().filter(|toast| toast.is_error).count(), 1, "{:?}", person.messages());
    assert_eq!(person.undo_all(), 1);
    assert_eq!(person.text(), SCENE);
}

#[test]
fn a_row_is_duplicated_and_deleted() {
    let mut person = Person::at_scene();
    person.context("object “ball”", &["Duplicate"]);
    assert_eq!(person.scene().objects.len(), 4);
    let copy = person.selected().expect("the copy is selected");
    assert_ne!(copy, "ball");
    assert!(copy.starts_with("ball"), "{copy}");
    person.key(Key::Delete);
    assert_eq!(person.text(), SCENE);
    person.context("object “ball”", &["Delete"]);
    assert_eq!(person.scene().objects.len(), 2);
    assert!(!person.text().contains("// round") && person.text().contains("// What it is made of."));
    assert_eq!(person.undo_all(), 3);
    assert_eq!(person.text(), SCENE);
}

#[test]
fn shapes_are_grouped_and_ungrouped() {
    let mut person = Person::at_scene();
    person.context("object “ball”", &[]);
    assert!(person.has("Group into") || person.has("Duplicate"));
    person.key(Key::Escape);
    assert!(!person.has("Duplicate"), "Escape closes the menu");
    // The first sphere belongs to the ball.
    let sphere = person.path("sphere");
    person.app_mut().select(Some(sphere));
    person.wait(2);
    person.ctrl(Key::G);
    assert_eq!(person.selected().as_deref(), Some("union"));
    assert_eq!(person.scene().objects.len(), 3);
    let grouped = person.text().to_owned();
    person.context("union", &["Ungroup"]);
    assert!(!person.text().contains("union"));
    assert_eq!(person.selected().as_deref(), Some("sphere"));
    person.ctrl(Key::Z);
    assert_eq!(person.text(), grouped);
    person.ctrl(Key::Z);
    assert_eq!(person.text(), SCENE);
    // The menu lists every operator.
    person.context("plane", &["Group into", "intersect"]);
    assert!(person.text().contains("intersect"), "{}", person.text());
    assert_eq!(person.selected().as_deref(), Some("intersect"));
    assert_eq!(person.undo_all(), 1);
    assert_eq!(person.text(), SCENE);
}

#[test]
fn rows_are_moved() {
    let mut person = Person::at_scene();
    let names =
        |person: &Person| -> Vec<String> { person.scene().objects.iter().map(|object| object.name.clone()).collect() };
    person.context("object “ball”", &["Move down"]);
    assert_eq!(names(&person), ["carved", "ball", "floor"]);
    assert!(person.text().contains("{ at 0 0.7 0 } } // round"), "its comment goes with it");
    person.context("object “floor”", &["Move up"]);
    assert_eq!(names(&person), ["carved", "floor", "ball"]);
    // With the mouse: onto the lower half of the last row.
    let rect = |person: &Person, row: &str| person.harness.get_by_role_and_label(Role::TreeItem, row).rect();
    let from = rect(&person, "object “carved”").center();
    let target = rect(&person, "object “ball”");
    let to = Pos2::new(from.x, target.max.y - 2.0);
    person.drag(from, to, PointerButton::Primary, Modifiers::NONE);
    assert_eq!(names(&person), ["floor", "ball", "carved"]);
    assert_eq!(person.undo_all(), 3);
    assert_eq!(person.text(), SCENE);
}

#[test]
fn a_shape_is_dragged_into_another_object() {
    let scene = SCENE.replace("{ plane }", "{ plane; box 9 }");
    let scene = scene.replace("        box 0.6 0.6 0.6\n", "        torus\n        torus\n");
    let mut person = Start::with(&scene).go();
    let rect = |person: &Person, row: &str| person.harness.get_by_role_and_label(Role::TreeItem, row).rect();
    let (from, to) = (rect(&person, "box").center(), rect(&person, "object “ball”").center());
    person.drag(from, to, PointerButton::Primary, Modifiers::NONE);
    let ball = person.path("ball");
    let words: Vec<_> = person.document().item(&ball).expect("there").children.iter().map(|c| c.word.clone()).collect();
    assert_eq!(words, ["sphere", "box"], "{:?}", person.messages());
    person.ctrl(Key::Z);
    assert_eq!(person.text(), scene);
}

#[test]
fn everything_that_can_be_added_is_offered() {
    let mut person = Person::at_scene();
    person.click("Add…");
    for group in ["Object", "Material", "Light", "Camera"] {
        assert!(person.harness.query_all_by_role_and_label(Role::Button, group).next().is_some(), "{group}");
    }
    person.harness.query_all_by_role_and_label(Role::Button, "Light").last().expect("there").click();
    person.wait(PAUSE);
    person.harness.query_all_by_role_and_label(Role::Button, "point").last().expect("there").click();
    person.wait(PAUSE);
    assert_eq!(person.scene().lights.len(), 1);
    assert_eq!(person.selected().as_deref(), Some("point"));
    person.context("object “ball”", &["Add…", "Shape", "torus"]);
    assert_eq!(person.selected().as_deref(), Some("torus"));
    assert_eq!(person.undo_all(), 2);
    assert_eq!(person.text(), SCENE);
}

#[test]
fn an_edit_that_causes_an_error_is_refused_with_its_reason() {
    let mut person =
        Start::with(&SCENE.replace(
            "camera \"other\" {\n    position 3 2 3 // from the side\n    target 0 0.5 0\n    fov 30\n}\n",
            "",
        ))
        .go();
    let before = person.text().to_owned();
    person.context("camera “main”", &["Delete"]);
    assert_eq!(person.text(), before);
    assert!(person.app().toasts.iter().any(|toast| toast.is_error && toast.text.contains("camera")));
    let words = person.messages()[0].to_owned();
    assert!(person.has(&words), "it is on the screen");
    person.context("material “grey”", &["Delete"]);
    assert_eq!(person.text(), before, "it is still used");
}

/// Clicks rows with Ctrl, so that all of them are selected, in this order.
fn select_rows(person: &mut Person, rows: &[&str]) {
    for (index, row) in rows.iter().enumerate() {
        let at = person.harness.get_by_role_and_label(Role::TreeItem, row).rect().center();
        person.click_at(at, if index == 0 { Modifiers::NONE } else { CTRL });
        person.wait(PAUSE);
    }
}

#[test]
fn several_rows_are_selected_and_combined_by_keys_and_menus() {
    let mut person = Person::at_scene();
    select_rows(&mut person, &["object “carved”", "object “ball”"]);
    assert_eq!(person.open().view.selection.paths().len(), 2);
    person.hover(person.picture().center());
    person.key(Key::M);
    assert_eq!(person.scene().objects.len(), 2, "{:?}", person.messages());
    assert_eq!(person.selected().as_deref(), Some("subtract"));
    assert!(person.text().contains("sphere 0.7 material=\"red\" { at 0 0.7 0 }"), "{}", person.text());
    assert_eq!(person.undo_all(), 1);
    assert_eq!(person.text(), SCENE);
    select_rows(&mut person, &["object “ball”", "object “floor”"]);
    person.menu("Edit", "Unite");
    assert_eq!(person.selected().as_deref(), Some("union"));
    assert_eq!(person.undo_all(), 1);
    // A second click with Ctrl removes a row from the selection.
    select_rows(&mut person, &["object “ball”", "object “floor”", "object “ball”"]);
    assert_eq!(person.open().view.selection.paths().len(), 1);
    assert_eq!(person.selected().as_deref(), Some("floor"));
}

#[test]
fn shift_selects_rows_up_to_another_and_edits_change_all_of_them() {
    let mut person = Person::at_scene();
    person.click_role(Role::TreeItem, "object “ball”");
    let at = person.harness.get_by_role_and_label(Role::TreeItem, "subtract").rect().center();
    person.click_at(at, Modifiers::SHIFT);
    person.wait(PAUSE);
    // The ball, its sphere, the carved object and its operator.
    assert_eq!(person.open().view.selection.paths().len(), 4);
    person.ctrl(Key::D);
    assert_eq!(person.scene().objects.len(), 5);
    person.key(Key::Delete);
    assert_eq!(person.text(), SCENE);
    assert!(person.open().view.selection.paths().is_empty());
}

#[test]
fn an_object_is_dragged_into_an_operator() {
    let mut person = Person::at_scene();
    let rect = |person: &Person, row: &str| person.harness.get_by_role_and_label(Role::TreeItem, row).rect();
    let (from, to) = (rect(&person, "object “ball”").center(), rect(&person, "subtract").center());
    person.drag(from, to, PointerButton::Primary, Modifiers::NONE);
    assert_eq!(person.scene().objects.len(), 2, "{:?}", person.messages());
    let subtract = person.path("subtract");
    let words: Vec<_> =
        person.document().item(&subtract).expect("there").children.iter().map(|child| child.word.clone()).collect();
    assert_eq!(words, ["box", "sphere", "sphere"]);
    assert_eq!(person.undo_all(), 1);
    assert_eq!(person.text(), SCENE);
}

#[test]
fn a_box_selects_the_shapes_in_it() {
    let mut person = Person::at_scene();
    let picture = person.picture();
    person.drag(picture.min + Vec2::splat(2.0), picture.max - Vec2::splat(2.0), PointerButton::Primary, CTRL);
    let selected = person.open().view.selection.paths().len();
    assert_eq!(selected, 3, "the spheres and the box, but not the plane, which has no end");
    assert_eq!(person.text(), SCENE);
}

#[test]
fn a_shape_is_put_on_the_ground() {
    let mut person = Start::with(&SCENE.replace("at 0 0.7 0", "at 0 2 0")).go();
    person.select("ball");
    person.hover(person.picture().center());
    person.key(Key::G);
    assert!(person.text().contains("sphere 0.7 { at 0 0.7 0 }"), "{}", person.text());
    assert_eq!(person.undo_all(), 1);
}

#[test]
fn the_tree_is_searched() {
    let mut person = Person::at_scene();
    let field = person.harness.get_by_role_and_label(Role::SearchInput, "Search the scene");
    field.focus();
    person.wait(2);
    person.harness.event(egui::Event::Text("ball".to_owned()));
    person.wait(2);
    let has = |person: &Person, row: &str| person.harness.query_by_role_and_label(Role::TreeItem, row).is_some();
    assert!(has(&person, "object “ball”") && !has(&person, "object “floor”") && !has(&person, "box"));
}

#[test]
fn the_selection_survives_a_change_of_the_file() {
    let mut person = Person::at_scene();
    person.select("carved");
    let text = SCENE.replace("object \"ball\"", "object \"new\" { torus }\nobject \"ball\"");
    std::fs::write(person.file(), &text).expect("written");
    person.until("the file is read", |person| person.text() == text);
    person.wait(2);
    assert_eq!(person.selected().as_deref(), Some("carved"));
}

#[test]
fn objects_are_hidden_shown_and_locked() {
    let mut person = Person::at_scene();
    person.select("ball");
    person.key(Key::H);
    assert!(person.text().contains("object \"ball\" material=\"red\" hidden=#true { sphere"), "{}", person.text());
    assert_eq!(person.scene().objects.len(), 2);
    person.key(Key::H);
    assert_eq!(person.text(), SCENE);
    person.harness.key_press_modifiers(Modifiers::SHIFT, Key::H);
    person.wait(2);
    assert_eq!(person.scene().objects.iter().map(|object| &*object.name).collect::<Vec<_>>(), ["ball"]);
    person.harness.key_press_modifiers(Modifiers::ALT, Key::H);
    person.wait(2);
    assert_eq!(person.text(), SCENE);
    assert_eq!(person.undo_all(), 4);
    let at = person.point(0.5, 0.5);
    for (locked, selected) in [(true, None), (false, Some("sphere"))] {
        person.select("ball");
        person.key(Key::L);
        assert_eq!(person.open().locked.contains("ball"), locked);
        person.key(Key::Escape);
        person.click_at(at, Modifiers::NONE);
        assert_eq!(person.selected().as_deref(), selected);
    }
    assert_eq!(person.selected().as_deref(), Some("sphere"));
}

#[test]
fn shapes_are_aligned_to_the_one_selected_last() {
    let mut person = Person::at_scene();
    let (ball, carved) = (person.path("sphere"), person.path("subtract"));
    person.app_mut().select_all(vec![ball.clone(), carved]);
    person.wait(2);
    person.menu("Edit", "Align along x");
    assert_eq!(person.document().control(&ball, "place.at").expect("a place").value, Value::Triple([1.65, 0.7, 0.0]));
}
