//! Recovery of unsaved work after a crash.

use super::*;
use crate::window::app::dialog::Dialog;

fn left(person: &Person) -> usize {
    if let Some(Dialog::Recovered(left)) = &person.app().dialog { left.len() } else { 0 }
}

#[test]
fn abandoned_work_is_offered_and_opened() {
    let mut person = Person::at_scene();
    person.select("sphere");
    person.type_number("radius", "0.85");
    let changed = person.text().to_owned();
    let mut person = person.crash();
    assert_eq!(left(&person), 1);
    assert!(person.has("Unsaved work found") && person.has("scene.kdl, just now"));
    person.answer("Open");
    assert_eq!(person.text(), changed);
    assert_eq!(person.on_disk(), SCENE);
    assert!(person.open().has_unsaved_work() && person.app().dialog.is_none());
    assert_eq!(person.app().title(), "• scene.kdl - pathmarch");
    // The work is still stored: another crash loses nothing.
    let mut person = person.crash();
    assert_eq!(left(&person), 1);
    person.answer("Open");
    assert_eq!(person.text(), changed);
    person.ctrl(Key::S);
    assert_eq!(person.on_disk(), changed);
    let person = person.crash();
    assert!(person.app().dialog.is_none(), "saved is saved");
}

#[test]
fn abandoned_work_can_wait_or_be_discarded() {
    let mut person = Person::at_scene();
    person.select("sphere");
    person.type_number("radius", "0.85");
    let mut person = person.crash();
    person.click("Decide later");
    assert!(person.app().dialog.is_none());
    let mut person = person.crash();
    assert_eq!(left(&person), 1);
    person.click_role(Role::Button, "Discard");
    assert!(person.app().dialog.is_none());
    let person = person.crash();
    assert!(person.app().dialog.is_none());
}

#[test]
fn recovering_one_work_does_not_replace_another() {
    let mut first = Person::at_scene();
    first.select("sphere");
    first.type_number("radius", "0.85");
    let one = first.text().to_owned();
    let directory = first.directory.clone();
    drop(first);
    let mut second = Start { directory: directory.clone(), ..Start::new() }.go();
    second.click("Decide later");
    second.click("New scene");
    second.select("ball");
    second.key(Key::Delete);
    let two = second.text().to_owned();
    let mut person = second.crash();
    assert_eq!(left(&person), 2);
    person.harness.query_all_by_role_and_label(Role::Button, "Open").next().expect("there").click();
    person.wait(PAUSE);
    let opened = person.text().to_owned();
    assert!(opened == one || opened == two);
    assert_eq!(left(&person), 0, "one at a time");
    let person = person.crash();
    let Some(Dialog::Recovered(left)) = &person.app().dialog else { panic!("both are still there") };
    let mut texts: Vec<_> = left.iter().map(|one| one.text.clone().expect("a text")).collect();
    let mut expected = [one, two];
    texts.sort();
    expected.sort();
    assert_eq!(texts, expected);
}

#[test]
fn preferences_come_back() {
    let mut person = Person::at_scene();
    let dark = person.harness.ctx.theme() == egui::Theme::Dark;
    person.key(Key::F6);
    person.key(Key::F2);
    person.key(Key::F5);
    assert_eq!(person.harness.ctx.theme() == egui::Theme::Dark, !dark);
    let person = person.crash();
    assert_eq!(person.harness.ctx.theme() == egui::Theme::Dark, !dark);
    let preferences = &person.app().preferences;
    assert!(!preferences.left_open && preferences.right_open && preferences.show_plots);
    assert_eq!(preferences.recent.len(), 1);
}

/// Possible states of the scene file after the crash.
fn theirs() -> String {
    SCENE.replace("sky 0.6", "sky 0.3")
}

/// Changes the test scene without saving it and crashes; returns the changed text.
fn crash_with_work() -> (Arc<tempfile::TempDir>, PathBuf, String) {
    let mut person = Person::at_scene();
    person.select("sphere");
    person.type_number("radius", "0.85");
    (person.directory.clone(), person.file(), person.text().to_owned())
}

fn start_again(directory: &Arc<tempfile::TempDir>) -> Person {
    let mut person = Start { directory: directory.clone(), ..Start::new() }.go();
    person.answer("Open");
    person
}

fn is_asked(person: &Person) -> bool {
    matches!(person.app().dialog, Some(Dialog::Conflict))
}

#[test]
fn work_does_not_replace_what_another_program_wrote_before_the_crash() {
    let mut person = Person::at_scene();
    person.select("sphere");
    person.type_number("radius", "0.85");
    let mine = person.text().to_owned();
    std::fs::write(person.file(), theirs()).expect("written");
    person.until("it is asked", is_asked);
    // The program crashes before the answer, twice.
    for _ in 0..2 {
        person = person.crash();
        person.answer("Open");
        assert!(is_asked(&person) && person.has("The file changed on disk"), "{:?}", person.messages());
        assert_eq!((person.text(), person.on_disk()), (mine.as_str(), theirs()));
        person.ctrl(Key::S);
        assert_eq!(person.on_disk(), theirs(), "not before it is answered");
    }
    person.click("Keep mine");
    assert_eq!((person.text(), person.on_disk()), (mine.as_str(), theirs()));
    // An answered question is not asked again, even after another crash.
    let mut person = person.crash();
    person.answer("Open");
    assert!(person.app().dialog.is_none() && person.open().has_unsaved_work());
    person.ctrl(Key::S);
    assert_eq!(person.on_disk(), mine);
    assert!(person.crash().app().dialog.is_none());
}

#[test]
fn work_does_not_replace_what_another_program_wrote_after_the_crash() {
    let (directory, file, mine) = crash_with_work();
    std::fs::write(file, theirs()).expect("written");
    let mut person = start_again(&directory);
    assert!(is_asked(&person));
    person.click("Reload from disk");
    assert_eq!((person.text(), person.on_disk()), (theirs().as_str(), theirs()));
    assert!(!person.open().has_unsaved_work());
    person.ctrl(Key::Z);
    assert_eq!(person.text(), mine, "undo brings mine back");
    person.ctrl(Key::S);
    assert_eq!(person.on_disk(), mine);
}

#[test]
fn work_whose_file_is_missing_or_unreadable_is_a_conflict() {
    type Spoil = fn(&Path);
    let cases: [(Spoil, &str); 3] = [
        (|file| std::fs::remove_file(file).expect("removed"), "there is no such file"),
        (|file| std::fs::write(file, b"\xff\xfe").expect("written"), "not UTF-8"),
        (
            |file| {
                std::fs::remove_file(file).expect("removed");
                std::fs::create_dir(file).expect("made");
            },
            "it is a directory",
        ),
    ];
    for (spoil, why) in cases {
        let (directory, file, mine) = crash_with_work();
        spoil(&file);
        let mut person = start_again(&directory);
        assert!(is_asked(&person) && person.has("The file can no longer be read") && person.has(why), "{why}");
        assert!(!person.has("Reload from disk"), "there is none to take");
        assert_eq!((person.text(), person.app().title().as_str()), (mine.as_str(), "• scene.kdl - pathmarch"));
        person.ctrl(Key::S);
        assert!(is_asked(&person), "that must be answered");
        // The work is still stored.
        let mut person = person.crash();
        person.answer("Open");
        assert!(is_asked(&person));
        person.click("Keep mine");
        person.ctrl(Key::S);
        if file.is_dir() {
            person.assert_said("Not saved");
            assert!(person.open().has_unsaved_work());
        } else {
            assert_eq!(person.on_disk(), mine);
        }
    }
}

#[test]
fn work_of_an_older_program_is_a_conflict() {
    let (directory, _, mine) = crash_with_work();
    let recovery = directory.path().join("home").join("recovery");
    for entry in std::fs::read_dir(recovery).expect("there") {
        let path = entry.expect("an entry").path();
        let text = std::fs::read_to_string(&path).expect("read");
        let old: String = text.split_inclusive('\n').filter(|line| !line.starts_with("// based on: ")).collect();
        assert_eq!(old.lines().count() + 1, text.lines().count());
        std::fs::write(path, old).expect("written");
    }
    let mut person = start_again(&directory);
    assert!(is_asked(&person), "of which version it was is not known");
    assert_eq!((person.text(), person.on_disk().as_str()), (mine.as_str(), SCENE));
    person.click("Keep mine");
    person.ctrl(Key::S);
    assert_eq!(person.on_disk(), mine);
}

#[test]
fn work_equal_to_its_file_is_no_conflict() {
    let (directory, file, mine) = crash_with_work();
    std::fs::write(file, &mine).expect("written");
    let person = start_again(&directory);
    assert!(person.app().dialog.is_none() && !person.open().has_unsaved_work());
    assert!(person.crash().app().dialog.is_none(), "and not kept any more");
}
