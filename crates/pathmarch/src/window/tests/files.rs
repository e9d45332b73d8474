//! Saving, unsaved work, and files changed by other programs.

use super::*;
use crate::window::app::actions::Action;
use crate::window::app::dialog::Dialog;

/// Makes an unsaved change.
fn change(person: &mut Person) -> String {
    person.select("sphere");
    person.type_number("radius", "0.85");
    assert!(person.open().has_unsaved_work());
    person.text().to_owned()
}

#[test]
fn saving_writes_the_text_as_it_is() {
    let mut person = Person::at_scene();
    assert_eq!(person.app().title(), "scene.kdl - pathmarch");
    let changed = change(&mut person);
    assert_eq!(person.app().title(), "• scene.kdl - pathmarch");
    assert_eq!(person.on_disk(), SCENE, "not before it is asked for");
    person.ctrl(Key::S);
    assert_eq!(person.on_disk(), changed);
    assert_eq!(person.on_disk(), SCENE.replace("sphere 0.7 {", "sphere 0.85 {"), "comments and order stay");
    assert!(!person.open().has_unsaved_work());
    person.assert_said("Saved");
    // The toolbar button does the same.
    person.ctrl(Key::Z);
    person.click_role(Role::Button, "Save");
    assert_eq!(person.on_disk(), SCENE);
}

#[test]
fn saves_that_follow_soon_after_each_other_are_no_changes_by_others() {
    let mut person = Person::at_scene();
    person.select("sphere");
    for k in 0..12 {
        let text = SCENE.replace("sphere 0.7 {", &format!("sphere 0.{} {{", 80 + k));
        person.app_mut().edit(|open| {
            open.document.replace_text(text.clone(), "Test", None);
            Ok(())
        });
        person.ctrl(Key::S);
        assert_eq!(person.on_disk(), text);
        // As long as the file watcher takes to check.
        std::thread::sleep(Duration::from_millis(15 * (k % 4)));
        person.wait(1);
        assert_eq!(person.text(), text, "what was saved before does not come back");
    }
    std::thread::sleep(Duration::from_millis(300));
    person.wait(2);
    assert_eq!(person.text(), person.on_disk());
    assert!(!person.messages().iter().any(|message| message.contains("changed on disk")), "{:?}", person.messages());
}

#[test]
fn saving_under_another_name_opens_the_file_dialog() {
    let mut person = Person::at_scene();
    let changed = change(&mut person);
    person.ctrl_shift(Key::S);
    assert!(person.app().file_dialog.is_some());
    person.fill(Role::TextInput, "Name", "other");
    let other = person.file().with_file_name("other.kdl");
    assert_eq!(std::fs::read_to_string(&other).expect("read"), changed);
    assert_eq!(person.on_disk(), SCENE);
    assert_eq!(person.app().title(), "other.kdl - pathmarch");
    // From now on this is its file.
    person.ctrl(Key::Z);
    person.ctrl(Key::S);
    assert_eq!(std::fs::read_to_string(&other).expect("read"), SCENE);
    // Replacing an existing file needs a confirmation.
    person.ctrl_shift(Key::S);
    person.fill(Role::TextInput, "Name", "scene");
    assert!(person.has("Replace it?"));
    person.click("Do not replace");
    person.key(Key::Escape);
    assert!(person.app().file_dialog.is_none());
}

#[test]
fn a_scene_without_a_file_asks_for_one() {
    let mut person = Start::new().go();
    person.click("New scene");
    let text = person.text().to_owned();
    person.ctrl(Key::S);
    assert!(person.app().file_dialog.is_some());
    let directory = person.directory.path().display().to_string();
    person.fill(Role::TextInput, "Path", &format!("{directory}/"));
    person.fill(Role::TextInput, "Name", "mine.kdl");
    assert_eq!(std::fs::read_to_string(person.file().with_file_name("mine.kdl")).expect("read"), text);
}

#[test]
fn a_save_that_fails_says_why_and_keeps_the_work() {
    let mut person = Person::at_scene();
    let changed = change(&mut person);
    let mut permissions = std::fs::metadata(person.file()).expect("there").permissions();
    permissions.set_readonly(true);
    std::fs::set_permissions(person.file(), permissions).expect("set");
    person.ctrl(Key::S);
    person.assert_said("Not saved");
    person.assert_said("read-only");
    assert!(person.open().has_unsaved_work());
    assert_eq!((person.text(), person.on_disk().as_str()), (changed.as_str(), SCENE));
    let kept = std::fs::read_to_string(person.app().recovery.file()).expect("kept");
    assert!(kept.ends_with(&changed), "and it is kept for recovery at once");
}

#[test]
fn quitting_asks_about_unsaved_work() {
    let mut person = Person::at_scene();
    let changed = change(&mut person);
    person.ctrl(Key::Q);
    assert!(person.has("Save changes?") && !person.app().should_quit());
    person.click("Cancel");
    assert!(!person.app().should_quit() && person.app().dialog.is_none());
    assert_eq!(person.text(), changed);
    person.app_mut().request_quit();
    person.wait(2);
    person.key(Key::Escape);
    assert!(!person.app().should_quit() && person.app().dialog.is_none(), "Escape cancels");
    person.ctrl(Key::Q);
    person.answer("Save");
    assert!(person.app().should_quit());
    assert_eq!(person.on_disk(), changed);
}

#[test]
fn unsaved_work_is_discarded_only_on_request() {
    let mut person = Person::at_scene();
    change(&mut person);
    person.ctrl(Key::Q);
    person.click("Discard");
    assert!(person.app().should_quit());
    assert_eq!(person.on_disk(), SCENE);
    person.app_mut().shut_down();
    let again = person.crash();
    assert!(again.app().dialog.is_none(), "what was discarded is not offered again");
    let mut saved = Person::at_scene();
    saved.ctrl(Key::Q);
    assert!(saved.app().should_quit(), "where nothing is unsaved nothing is asked");
}

#[test]
fn discarding_to_open_another_and_opening_none_loses_nothing() {
    let mut person = Person::at_scene();
    let changed = change(&mut person);
    person.ctrl(Key::O);
    person.click("Discard");
    assert!(person.app().file_dialog.is_some());
    person.key(Key::Escape);
    assert_eq!(person.text(), changed);
    let person = person.crash();
    let Some(Dialog::Recovered(left)) = &person.app().dialog else { panic!("it is still kept") };
    assert_eq!(left[0].text.as_deref(), Ok(changed.as_str()));
}

#[test]
fn the_recent_file_that_was_chosen_is_opened_also_after_a_save() {
    let mut person = Person::at_scene();
    let texts = ["a", "b"].map(|name| {
        let path = person.file().with_file_name(format!("{name}.kdl"));
        let text = format!("// {name}\n{SCENE}");
        std::fs::write(&path, &text).expect("written");
        person.app_mut().open_file(&path);
        text
    });
    person.ctrl(Key::N);
    person.select("ball");
    person.key(Key::Delete);
    person.click_role(Role::Button, "File");
    person.harness.get_by_label_contains("Open recent").click();
    person.wait(PAUSE);
    person.answer("a.kdl");
    person.answer("Save");
    person.fill(Role::TextInput, "Name", "c.kdl");
    assert_eq!(person.text(), texts[0]);
}

#[test]
fn a_change_on_disk_is_shown() {
    let mut person = Person::at_scene();
    let text = SCENE.replace("sphere 0.7 {", "sphere 0.5 {");
    std::fs::write(person.file(), &text).expect("written");
    person.until("the file is read", |person| person.text() == text);
    assert!(!person.open().has_unsaved_work());
    person.assert_said("Reloaded: the file changed on disk");
    // An editor may replace the file; undo brings the old text back.
    replace_file(&person.file(), SCENE);
    person.until("the file is read", |person| person.text() == SCENE);
    person.ctrl(Key::Z);
    assert_eq!(person.text(), text);
    assert!(person.open().has_unsaved_work());
}

#[test]
fn an_error_on_disk_keeps_the_picture_until_it_is_fixed() {
    let mut person = Person::at_scene();
    person.rest();
    let good = person.document().last_good().expect("a scene").clone();
    std::fs::write(person.file(), SCENE.replace("sphere 0.7", "sphere -0.7")).expect("written");
    person.until("the mistake shows", |person| person.has("1 error"));
    let line = 1 + SCENE[..SCENE.find("object \"ball\"").expect("there")].matches('\n').count();
    assert!(person.has(&format!("line {line}, ")));
    assert!(person.has("sphere -0.7"), "the line itself");
    assert!(Arc::ptr_eq(person.document().last_good().expect("a scene"), &good));
    assert!(person.open().view.picture.is_some());
    std::fs::write(person.file(), SCENE).expect("written");
    person.until("it is corrected", |person| !person.has("1 error"));
    assert_eq!(person.text(), SCENE);
    std::fs::remove_file(person.file()).expect("removed");
    person.until("the message appears", |person| person.messages().iter().any(|message| message.contains("scene.kdl")));
    assert_eq!(person.text(), SCENE, "what is open stays");
    person.select("sphere");
    person.type_number("radius", "0.85");
    person.ctrl(Key::S);
    assert_eq!(person.on_disk(), person.text());
}

/// A scene with unsaved changes whose file was changed, too.
fn conflict() -> (Person, String, String) {
    let mut person = Person::at_scene();
    let mine = change(&mut person);
    let theirs = SCENE.replace("sky 0.6", "sky 0.3");
    std::fs::write(person.file(), &theirs).expect("written");
    person.until("it is asked", |person| matches!(person.app().dialog, Some(Dialog::Conflict)));
    person.wait(2);
    assert!(person.has("The file changed on disk"));
    person.key(Key::Escape);
    assert!(matches!(person.app().dialog, Some(Dialog::Conflict)), "that must be answered");
    assert_eq!(person.text(), mine);
    (person, mine, theirs)
}

#[test]
fn a_conflict_can_keep_the_own_version() {
    let (mut person, mine, theirs) = conflict();
    person.click("Keep mine");
    assert_eq!((person.text(), person.on_disk()), (mine.as_str(), theirs));
    person.ctrl(Key::S);
    assert_eq!(person.on_disk(), mine);
    assert!(person.app().dialog.is_none());
}

#[test]
fn a_conflict_can_reload_from_disk() {
    let (mut person, mine, theirs) = conflict();
    person.click("Reload from disk");
    assert_eq!((person.text(), person.on_disk()), (theirs.as_str(), theirs.clone()));
    assert!(!person.open().has_unsaved_work());
    person.ctrl(Key::Z);
    assert_eq!(person.text(), mine, "undo brings mine back");
    assert!(person.open().has_unsaved_work());
}

#[test]
fn a_conflict_can_save_the_own_version_elsewhere() {
    let (mut person, mine, theirs) = conflict();
    person.click("Save mine as…");
    person.key(Key::Escape);
    person.wait(PAUSE);
    assert!(matches!(person.app().dialog, Some(Dialog::Conflict)), "without a name it is asked again");
    person.click("Save mine as…");
    assert!(person.app().file_dialog.is_some());
    let name = person.harness.get_by_role_and_label(Role::TextInput, "Name").value();
    assert_eq!(name.as_deref(), Some("scene-mine.kdl"));
    person.answer("Save");
    assert_eq!(person.on_disk(), theirs);
    let other = person.file().with_file_name("scene-mine.kdl");
    assert_eq!(std::fs::read_to_string(other).expect("read"), mine);
    assert!(person.app().dialog.is_none() && !person.open().has_unsaved_work());
}

#[test]
fn the_same_change_on_both_sides_is_no_conflict() {
    let mut person = Person::at_scene();
    let mine = change(&mut person);
    std::fs::write(person.file(), &mine).expect("written");
    person.until("it counts as saved", |person| !person.open().has_unsaved_work());
    assert!(person.app().dialog.is_none());
    assert_eq!(person.text(), mine);
}

#[test]
fn a_save_right_after_a_change_by_others_asks() {
    let mut person = Person::at_scene();
    let mine = change(&mut person);
    let theirs = SCENE.replace("sky 0.6", "sky 0.3");
    // Before the file watcher can have noticed it.
    std::fs::write(person.file(), &theirs).expect("written");
    person.ctrl(Key::S);
    assert!(matches!(person.app().dialog, Some(Dialog::Conflict)));
    assert_eq!((person.text(), person.on_disk()), (mine.as_str(), theirs));
    person.click("Keep mine");
    person.ctrl(Key::S);
    assert_eq!(person.on_disk(), mine);
}

#[test]
fn a_conflict_ends_when_both_versions_are_equal() {
    let (mut person, mine, _) = conflict();
    std::fs::write(person.file(), &mine).expect("written");
    person.until("nothing is asked any more", |person| person.app().dialog.is_none());
    assert!(!person.open().has_unsaved_work());
    assert!(person.crash().app().dialog.is_none(), "nothing is kept for after a crash");
}

#[test]
fn a_scene_reads_no_file_outside_its_folder_until_it_is_allowed() {
    let text = format!("{SCENE}include \"../parts.kdl\"\n");
    let mut start = Start::new();
    let folder = start.directory.path().join("strange");
    std::fs::create_dir(&folder).expect("created");
    std::fs::write(start.directory.path().join("parts.kdl"), "pathmarch 1\nobject \"secret\" { sphere }\n")
        .expect("written");
    std::fs::write(folder.join("scene.kdl"), text).expect("written");
    start.scene = Some(folder.join("scene.kdl"));
    let mut person = start.go();
    let error = person.document().scene().expect_err("refused").mistakes()[0].clone();
    assert!(error.message.contains("outside the folder of the scene"), "{}", error.message);
    assert!(error.help.expect("help").contains("Allow other files"));
    let ctx = person.harness.ctx.clone();
    person.app_mut().run_action(&ctx, Action::AllowFiles);
    person.wait(2);
    assert!(person.scene().objects.iter().any(|object| &*object.name == "secret"));
    person.assert_said("may read files");
    assert!(!person.open().has_unsaved_work());
}
