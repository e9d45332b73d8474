//! Animated scenes: playback, stepping, and the state that stays unchanged.

use super::*;

const MOVING: &str = "pathmarch 1
camera \"main\" { position 0 1.2 4.5; target 0 0.6 0; fov 40 }
render { size 64 48; samples 2; bounces 1 }
sky 0.6
object \"ball\" { sphere 0.4 { at \"2*t\" 0.5 0 } }
object \"floor\" { plane }
";

impl Person {
    fn frame(&self) -> u32 {
        self.document().moment().frame
    }
    /// Position of the sphere along x, metres.
    fn place(&self) -> f32 {
        self.scene().field.leaves()[0].pose.at[0]
    }
}

#[test]
fn a_scene_is_played_and_stops_where_it_is() {
    let mut person = Start::with(MOVING).go();
    assert_eq!((person.frame(), person.place()), (0, 0.0));
    person.key(Key::Space);
    person.until("half a second is over", |person| person.frame() >= 12);
    person.key(Key::Space);
    let (frame, place) = (person.frame(), person.place());
    assert!((place - frame as f32 / 12.0).abs() < 1e-5, "{place} in frame {frame}");
    person.wait(10);
    assert_eq!(person.frame(), frame, "it rests");
    assert_eq!(person.text(), MOVING, "the text stays");
    assert!(!person.app().title().contains('•'), "nothing has to be saved");
    person.key(Key::Period);
    assert_eq!(person.frame(), frame + 1);
    person.key(Key::Comma);
    person.key(Key::Comma);
    assert_eq!(person.frame(), frame - 1);
    person.rest();
}

#[test]
fn the_slider_shows_any_frame_and_a_moved_camera_stays() {
    let mut person = Start::with(MOVING).go();
    person.rest();
    person.drag(person.point(0.5, 0.5), person.point(0.6, 0.5), PointerButton::Primary, Modifiers::NONE);
    let camera = person.open().view.camera.clone();
    person.type_number("Frame", "48");
    assert_eq!((person.frame(), person.place()), (48, 4.0));
    assert_eq!(person.open().view.camera, camera);
    // The first frame follows the last one.
    person.fill(Role::SpinButton, "Last frame", "50");
    person.key(Key::Period);
    person.key(Key::Period);
    person.key(Key::Period);
    assert_eq!(person.frame(), 0);
}

#[test]
fn a_frame_with_an_error_keeps_the_picture_and_reports_it() {
    let text = MOVING.replace("sphere 0.4", "sphere \"0.4 - 0.2*t\"");
    let mut person = Start::with(&text).go();
    person.type_number("Frame", "72");
    assert!(person.has("1 error"), "a negative radius after 2 s");
    person.type_number("Frame", "24");
    assert!(!person.has("1 error") && person.frame() == 24);
}

#[test]
fn a_still_scene_has_no_timeline() {
    let mut person = Person::at_scene();
    assert!(!person.has("Last frame"));
    person.key(Key::Space);
    person.assert_said("This scene is not animated");
    assert_eq!(person.frame(), 0);
}

#[test]
fn frames_are_rendered_to_files_of_their_own() {
    let mut person = Start::with(MOVING).go();
    person.click("Render frames…");
    assert!(person.has("Render to file"));
    let pattern = person.file().with_file_name("scene-####.png");
    person.answer("Start");
    assert_eq!(person.app().renders.len(), 1, "{:?}", person.messages());
    person.until("the first frames are there", |person| person.file().with_file_name("scene-0001.png").exists());
    assert!(person.has("Stop and keep") && !pattern.exists());
    person.click("Stop and keep");
    person.until("it has stopped", |person| person.app().renders.is_empty());
    person.assert_said("Stopped; wrote");
    assert!(!person.file().with_file_name("scene-0119.png").exists());
}

#[test]
fn a_turntable_starts_at_the_view_and_goes_around() {
    let mut person = Person::at_scene();
    let before = person.open().view.camera.position;
    person.menu("Camera", "Turntable");
    assert!(person.scene().animated, "{:?}", person.messages());
    let near = |a: [f32; 3], b: [f32; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 2e-3);
    assert!(near(person.scene().cameras[0].position, before), "{:?}", person.scene().cameras[0].position);
    assert_eq!(person.open().playback.last, 239);
    // After a quarter of the turn the camera is a quarter around the target.
    let fps = person.scene().render.fps;
    person.app_mut().show_frame(60, fps);
    let position = person.scene().cameras[0].position;
    assert!((position[1] - before[1]).abs() < 1e-3 && (position[0].abs() - 4.5).abs() < 0.01, "{position:?}");
}

#[test]
fn keys_are_set_and_dragging_at_another_frame_sets_more() {
    let text = "pathmarch 1
camera \"main\" { position 0 1.2 4.5; target 0 0.6 0; fov 40 }
render { size 64 48; samples 2; bounces 1 }
sky 0.6
object \"ball\" { sphere 0.4 { at 0 0.5 0 } }
";
    let mut person = Start::with(text).go();
    person.select("sphere");
    person.key(Key::K);
    assert!(person.text().contains("at \"keys(t, 0, 0)\" \"keys(t, 0, 0.5)\" \"keys(t, 0, 0)\""), "{}", person.text());
    person.type_number("Frame", "24");
    let path = person.path("sphere");
    person.app_mut().edit(|open| open.document.set(&path, "place.at", Value::Triple([2.0, 0.5, 0.0]), None));
    person.wait(2);
    assert!(person.text().contains("at \"keys(t, 0, 0, 1, 2)\" \"keys(t, 0, 0.5)\""), "{}", person.text());
    person.type_number("Frame", "12");
    assert_eq!(person.place(), 1.0);
}
