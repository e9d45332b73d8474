//! Work that was not saved when the program ended.

use super::*;
use crate::window::dialogs::Dialog;

fn left(person: &Person) -> usize {
    if let Some(Dialog::Recovered(left)) = &person.app().dialog { left.len() } else { 0 }
}

#[test]
fn work_left_behind_is_offered_and_opened() {
    let mut person = Person::at_scene();
    person.select("sphere");
    person.type_number("radius", "0.85");
    let changed = person.text().to_owned();
    let mut person = person.crash();
    assert_eq!(left(&person), 1);
    assert!(person.has("Unsaved work was found") && person.has("scene.kdl, just now"));
    person.answer("Open");
    assert_eq!(person.text(), changed);
    assert_eq!(person.on_disk(), SCENE);
    assert!(person.open().has_unsaved_work() && person.app().dialog.is_none());
    assert_eq!(person.app().title(), "• scene.kdl - pathmarch");
    // It is kept still: another crash loses nothing either.
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
fn work_left_behind_can_wait_or_be_discarded() {
    let mut person = Person::at_scene();
    person.select("sphere");
    person.type_number("radius", "0.85");
    let mut person = person.crash();
    person.click("Ask again next time");
    assert!(person.app().dialog.is_none());
    let mut person = person.crash();
    assert_eq!(left(&person), 1);
    person.click_role(Role::Button, "Discard");
    assert!(person.app().dialog.is_none());
    let person = person.crash();
    assert!(person.app().dialog.is_none());
}

#[test]
fn of_several_works_none_takes_the_place_of_another() {
    let mut first = Person::at_scene();
    first.select("sphere");
    first.type_number("radius", "0.85");
    let one = first.text().to_owned();
    let directory = first.directory.clone();
    drop(first);
    let mut second = Start { directory: directory.clone(), ..Start::new() }.go();
    second.click("Ask again next time");
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
