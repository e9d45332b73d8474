//! Tests of the file dialog as a user sees it.

use super::*;
use egui::Ui;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use std::fs;

struct State {
    dialog: FileDialog,
    choice: Option<Choice>,
}

/// A directory with `a.kdl`, `b.KDL`, `c.txt`, `.d.kdl` and `sub/e.kdl`.
fn directory() -> tempfile::TempDir {
    let directory = tempfile::tempdir().expect("a directory");
    fs::create_dir(directory.path().join("sub")).expect("made");
    for name in ["a.kdl", "b.KDL", "c.txt", ".d.kdl", "sub/e.kdl"] {
        fs::write(directory.path().join(name), "old").expect("written");
    }
    directory
}

fn scenes() -> FileDialogOptions {
    FileDialogOptions { title: "Choose a scene".to_owned(), extensions: vec!["kdl"] }
}

fn harness(dialog: FileDialog) -> Harness<'static, State> {
    let show = |ui: &mut Ui, state: &mut State| {
        if state.choice.is_none() {
            state.choice = state.dialog.show(ui.ctx());
        }
    };
    let state = State { dialog, choice: None };
    let mut harness = Harness::builder()
        .with_size([900.0, 600.0])
        // Short enough for double clicks.
        .with_step_dt(1.0 / 60.0)
        .with_max_steps(200)
        .allow_missing_glyphs()
        .build_ui_state(show, state);
    harness.run();
    harness
}

fn press(harness: &mut Harness<'static, State>, label: &str) {
    harness.get_by_label(label).click();
    harness.run();
}

fn key(harness: &mut Harness<'static, State>, key: Key) {
    harness.key_press(key);
    harness.run();
}

/// Replaces the text of a field.
fn fill(harness: &mut Harness<'static, State>, label: &str, text: &str) {
    let field = harness.get_by_role_and_label(egui::accesskit::Role::TextInput, label);
    field.focus();
    harness.run();
    harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
    harness.run();
    harness.get_by_role_and_label(egui::accesskit::Role::TextInput, label).type_text(text);
    harness.run();
}

fn chosen(path: PathBuf) -> Option<Choice> {
    Some(Choice::Chosen(path))
}

#[test]
fn a_file_is_opened_by_the_mouse() {
    let directory = directory();
    let mut harness = harness(FileDialog::open(directory.path(), scenes()));
    for (label, visible) in
        [("sub/", true), ("a.kdl", true), ("b.KDL", true), ("c.txt", false), (".d.kdl", false), ("Home", true)]
    {
        assert_eq!(harness.query_by_label(label).is_some(), visible, "{label}");
    }
    press(&mut harness, "All files");
    assert!(harness.query_by_label("c.txt").is_some());
    press(&mut harness, "a.kdl");
    assert_eq!(harness.state().choice, None);
    press(&mut harness, "Open");
    assert_eq!(harness.state().choice, chosen(directory.path().join("a.kdl")));
}

#[test]
fn a_double_click_opens() {
    let directory = directory();
    let mut harness = harness(FileDialog::open(directory.path(), scenes()));
    for label in ["sub/", "e.kdl"] {
        harness.get_by_label(label).click();
        harness.get_by_label(label).click();
        // Long enough for the next click to be a single one.
        harness.run_steps(60);
    }
    assert_eq!(harness.state().choice, chosen(directory.path().join("sub/e.kdl")));
}

#[test]
fn a_file_is_opened_by_the_keyboard() {
    let directory = directory();
    let mut harness = harness(FileDialog::open(directory.path(), scenes()));
    key(&mut harness, Key::ArrowDown);
    key(&mut harness, Key::Enter);
    assert_eq!(harness.state().dialog.directory(), directory.path().join("sub"));
    key(&mut harness, Key::Backspace);
    assert_eq!(harness.state().dialog.directory(), directory.path());
    // The directory that we came from is selected.
    key(&mut harness, Key::ArrowDown);
    key(&mut harness, Key::ArrowDown);
    key(&mut harness, Key::ArrowDown);
    key(&mut harness, Key::Enter);
    assert_eq!(harness.state().choice, chosen(directory.path().join("b.KDL")));
}

#[test]
fn it_is_cancelled() {
    let directory = directory();
    let mut by_key = harness(FileDialog::open(directory.path(), scenes()));
    key(&mut by_key, Key::Escape);
    assert_eq!(by_key.state().choice, Some(Choice::Cancelled));
    let mut by_button = harness(FileDialog::save(directory.path(), "x", scenes()));
    press(&mut by_button, "Cancel");
    assert_eq!(by_button.state().choice, Some(Choice::Cancelled));
}

#[test]
fn a_path_is_typed() {
    let directory = directory();
    let mut harness = harness(FileDialog::open(directory.path(), scenes()));
    fill(&mut harness, "Path", "nowhere/x.kdl");
    key(&mut harness, Key::Enter);
    assert!(harness.query_by_label_contains("nowhere/x.kdl does not exist").is_some());
    // A directory is listed while its path is typed.
    fill(&mut harness, "Path", &format!("{}/sub/", directory.path().display()));
    assert!(harness.query_by_label("e.kdl").is_some() && harness.query_by_label_contains("does not exist").is_none());
    fill(&mut harness, "Path", &directory.path().to_string_lossy());
    key(&mut harness, Key::Enter);
    assert!(harness.query_by_label("a.kdl").is_some());
    fill(&mut harness, "Path", "sub/e.kdl");
    key(&mut harness, Key::Enter);
    assert_eq!(harness.state().choice, chosen(directory.path().join("sub/e.kdl")));
}

#[test]
fn a_name_to_save_under_gets_its_extension() {
    let directory = directory();
    let mut harness = harness(FileDialog::save(directory.path(), "untitled", scenes()));
    harness.get_by_role_and_label(egui::accesskit::Role::TextInput, "Name").type_text("-2");
    harness.run();
    key(&mut harness, Key::Enter);
    let Some(Choice::Chosen(path)) = &harness.state().choice else { panic!("it is chosen") };
    let name = path.file_name().expect("a name").to_string_lossy();
    assert!(name.contains("untitled") && name.contains("-2") && name.ends_with(".kdl"), "{name}");
}

#[test]
fn replacing_needs_a_confirmation() {
    let directory = directory();
    let mut harness = harness(FileDialog::save(directory.path(), "a", scenes()));
    press(&mut harness, "Save");
    assert!(harness.query_by_label_contains("Replace it?").is_some());
    key(&mut harness, Key::Escape);
    assert_eq!(harness.state().choice, None, "only the question is gone");
    press(&mut harness, "Save");
    press(&mut harness, "Do not replace");
    assert_eq!(harness.state().choice, None);
    press(&mut harness, "b.KDL");
    press(&mut harness, "Save");
    press(&mut harness, "Replace");
    assert_eq!(harness.state().choice, chosen(directory.path().join("b.KDL")));
    assert_eq!(fs::read(directory.path().join("b.KDL")).expect("there"), b"old", "that is up to the caller");
}

#[test]
fn names_to_save_under_may_be_paths() {
    let directory = directory();
    let mut harness = harness(FileDialog::save(directory.path(), "sub", scenes()));
    press(&mut harness, "Save");
    assert_eq!(harness.state().dialog.directory(), directory.path().join("sub"));
    fill(&mut harness, "Name", "no/x");
    key(&mut harness, Key::Enter);
    assert!(harness.query_by_label_contains("create it first").is_some());
    fill(&mut harness, "Name", "../new");
    key(&mut harness, Key::Enter);
    let Some(Choice::Chosen(path)) = &harness.state().choice else { panic!("it is chosen") };
    assert!(path.ends_with("new.kdl"), "{}", path.display());
}

#[test]
fn bookmarks_work_and_errors_are_shown() {
    let directory = directory();
    let gone = directory.path().join("gone");
    let sub = directory.path().join("sub");
    let dialog = FileDialog::open(&gone.join("deeper"), scenes()).with_bookmarks(Some(&sub), &[sub.clone(), gone]);
    assert_eq!(dialog.directory(), directory.path(), "the nearest directory that is there");
    let mut harness = harness(dialog);
    assert!(harness.query_by_label_contains("does not exist").is_some());
    press(&mut harness, "Scene directory");
    assert!(harness.query_by_label("e.kdl").is_some());
    press(&mut harness, "gone");
    assert!(harness.query_by_label_contains("gone does not exist").is_some());
    assert!(harness.query_by_label("e.kdl").is_some(), "and it stays where it was");
    press(&mut harness, "Up");
    assert!(harness.query_by_label("a.kdl").is_some());
}

#[cfg(unix)]
#[test]
fn odd_names_are_chosen_as_they_are() {
    use std::os::unix::ffi::OsStringExt;
    let directory = tempfile::tempdir().expect("a directory");
    let odd = directory.path().join(OsString::from_vec(b"\xff\n.kdl".to_vec()));
    if fs::write(&odd, "old").is_err() {
        return; // Some file systems hold only Unicode.
    }
    let mut opening = harness(FileDialog::open(directory.path(), scenes()));
    key(&mut opening, Key::ArrowDown);
    key(&mut opening, Key::Enter);
    assert_eq!(opening.state().choice, chosen(odd.clone()));
    let mut saving = harness(FileDialog::save(directory.path(), "", scenes()));
    press(&mut saving, "\u{fffd}\u{fffd}.kdl");
    press(&mut saving, "Save");
    press(&mut saving, "Replace");
    assert_eq!(saving.state().choice, chosen(odd));
}

#[test]
fn large_directories_are_scrolled_by_the_keyboard() {
    let directory = tempfile::tempdir().expect("a directory");
    for number in 0..500 {
        fs::write(directory.path().join(format!("{number:03}.kdl")), "").expect("written");
    }
    let mut harness = harness(FileDialog::open(directory.path(), scenes()));
    assert!(harness.query_by_label("499.kdl").is_none(), "rows out of sight are not drawn");
    key(&mut harness, Key::End);
    assert!(harness.query_by_label("499.kdl").is_some());
    key(&mut harness, Key::PageUp);
    key(&mut harness, Key::Enter);
    assert_eq!(harness.state().choice, chosen(directory.path().join("489.kdl")));
}
