//! Gallery page, and files dropped onto the window.

use super::*;
use pathmarch_gallery::EXAMPLES;

#[test]
fn every_example_is_shown_and_opens_by_a_click() {
    // Tall enough that every card is visible.
    let mut person = Start::new().size(1000.0, 6000.0).go();
    person.wait(EXAMPLES.len());
    for example in EXAMPLES {
        assert!(person.has(example.name) && person.has(example.doc), "{}", example.name);
    }
    for example in EXAMPLES {
        person.click_role(Role::Button, example.name);
        assert!(person.app().open.is_some(), "{} is a button", example.name);
        assert!(person.document().scene().is_ok(), "{}", example.name);
        assert_eq!(person.text(), example.text);
        assert_eq!(person.open().path, None, "saving asks for a name");
        assert!(!person.open().has_unsaved_work());
        person.ctrl_shift(Key::G);
        assert!(person.app().open.is_none());
    }
}

#[test]
fn the_page_offers_a_new_scene_a_file_and_the_last_one() {
    let mut person = Start::new().go();
    assert!(!person.has("Continue with"));
    person.click("New scene");
    assert!(person.document().scene().is_ok());
    person.ctrl_shift(Key::G);
    std::fs::write(person.file(), SCENE).expect("written");
    person.click("Open file…");
    let path = person.file();
    person.fill(Role::TextInput, "Path", &path.display().to_string());
    assert_eq!(person.text(), SCENE);
    assert_eq!(person.app().title(), "scene.kdl - pathmarch");
    person.ctrl_shift(Key::G);
    person.click("Continue with scene.kdl");
    assert_eq!(person.text(), SCENE);
}

#[derive(Debug)]
struct Dropped(PathBuf);

impl egui::DroppedFile for Dropped {
    fn path(&self) -> &Path {
        &self.0
    }
    fn bytes(&self) -> Result<Vec<u8>, String> {
        std::fs::read(&self.0).map_err(|error| error.to_string())
    }
}

fn drop_file(person: &mut Person, path: &Path) {
    person.harness.input_mut().dropped_files.push(Arc::new(Dropped(path.to_owned())));
    person.wait(3);
}

#[test]
fn a_file_that_is_dropped_opens() {
    let mut person = Start::new().go();
    std::fs::write(person.file(), SCENE).expect("written");
    let path = person.file();
    drop_file(&mut person, &path);
    assert_eq!(person.text(), SCENE);
    drop_file(&mut person, Path::new("/nowhere/at-all.kdl"));
    person.assert_said("there is no such file");
    assert_eq!(person.text(), SCENE, "what was open stays");
    let picture = path.with_extension("png");
    std::fs::write(&picture, b"\x89PNG\xff").expect("written");
    drop_file(&mut person, &picture);
    person.assert_said("not UTF-8");
    // Unsaved work needs a decision first.
    person.select("sphere");
    person.type_number("radius", "0.9");
    drop_file(&mut person, &path);
    person.click("Discard");
    assert_eq!(person.text(), SCENE);
}

#[test]
fn a_mesh_that_is_dropped_stands_on_the_ground_and_one_undo_removes_it() {
    let mut person = Person::at_scene();
    let before = person.text().to_owned();
    let path = person.file().with_file_name("box.obj");
    std::fs::write(&path, "v 1 1 1\nv 2 1 1\nv 1 3 1\nv 1 1 2\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n").expect("written");
    drop_file(&mut person, &path);
    let text = person.text();
    assert!(text.contains("object \"box\" { mesh \"box.obj\" { at -1.5 -1 -1.5 } }"), "{text}");
    person.menu("Edit", "Undo: Add box");
    assert_eq!(person.text(), before);
}

#[test]
fn another_scene_never_shows_the_picture_of_the_one_before() {
    let mut person = Person::at_scene();
    person.rest();
    let before = person.app().live.picture().expect("a picture").request;
    person.app_mut().run_pending(crate::window::app::requests::PendingAction::New);
    person.harness.step();
    person.until("there is a picture", |person| person.open().view.picture.is_some());
    assert!(person.app().live.picture().expect("a picture").request > before);
}
