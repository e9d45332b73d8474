//! End-to-end tests of the window: the program runs on a virtual display (Xvfb), is driven by mouse and keyboard
//! (XTEST), and is checked by its pixels, title, files and output.
//!
//! Without Xvfb or a way to draw, the tests are reported as ignored; with `PATHMARCH_REQUIRE_DISPLAY`, as in CI, they
//! fail. No window manager runs.

use crate::display::{Person, Screen, with_display};
use pathmarch_testing::tests;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use x11rb::protocol::xproto::ConfigureWindowAux;

/// A red emissive sphere beside the camera's target, and a green one.
const SCENE: &str = r#"pathmarch 1
// The numbers of this scene are changed by tests.
camera "main" { position 0 0 6; target 0 0 0; fov 40 }
render { size 320 180; samples 4; bounces 1; tonemap "srgb" }
sky 0
material "red" { emit 1 0 0 }
material "green" { emit 0 1 0 }
object "ball" material="red" { sphere 0.7 { at 1 0 0 } } // round
object "other" material="green" { sphere 0.3 { at -1 0 1 } }
"#;

/// A display, and a directory for files.
fn at_display() -> (Screen, tempfile::TempDir) {
    (Screen::start().expect("a display, as before"), tempfile::tempdir().expect("a directory"))
}

fn scene_in(directory: &Path) -> PathBuf {
    let path = directory.join("scene.kdl");
    fs::write(&path, SCENE).expect("written");
    path
}

/// Moves the cursor to the sphere's radius in the text and replaces it by one digit.
fn type_radius(person: &Person, from: &str, digit: char) {
    let line = SCENE.lines().position(|line| line.contains("\"ball\"")).expect("there");
    let column = SCENE.lines().nth(line).expect("there").find("sphere ").expect("there") + "sphere ".len();
    person.key("Home", &["Control_L"]);
    person.keys("Down", line);
    person.keys("Right", column);
    person.keys("Delete", from.len());
    person.text(&digit.to_string());
}

/// Opens the source editor and clicks into it.
fn open_source(person: &Person) {
    person.key("F4", &[]);
    let [width, height] = person.size();
    person.until("the text is shown", |person| {
        let image = person.image();
        // Letters where the picture was black.
        image.count_in([0.05, 0.75, 0.5, 0.9], |[r, g, b]| r.min(g).min(b) > 100) > 200
    });
    person.click(width / 4, height * 4 / 5);
}

fn is_red([r, g, b]: [u8; 3]) -> bool {
    r > 180 && g < 60 && b < 60
}
fn is_outline([r, g, b]: [u8; 3]) -> bool {
    r > 230 && (150..220).contains(&g) && (50..130).contains(&b)
}

fn red(person: &Person) -> usize {
    person.image().count(is_red)
}

/// Waits until the picture is there and stable.
fn rested(person: &Person) -> usize {
    person.until("the ball is seen", |person| red(person) > 300);
    person.still();
    red(person)
}

fn a_scene_is_seen_turned_selected_edited_saved_and_seen_again() {
    let (screen, directory) = at_display();
    let file = scene_in(directory.path());
    let mut person = screen.person(directory.path(), Some(&file));
    person.until("the times are printed", |person| person.printed().contains("all samples"));
    for line in ["window drawn", "first picture", "whole picture"] {
        assert!(person.printed().contains(line), "{}", person.printed());
    }
    assert_eq!(person.title(), "scene.kdl - pathmarch");
    let seen = rested(&person);

    // Orbit: the sphere moves away and comes back.
    let [x, y] = person.image().centre_of(is_red);
    let [width, height] = person.size();
    let empty = [width / 2, height / 4];
    person.drag_until(empty, [10, 0], "the ball has moved", |person| {
        let image = person.image();
        image.count(is_red) < 50 || image.centre_of(is_red)[0].abs_diff(x) > 20
    });
    person.key("Home", &[]);
    person.until("the ball is back", |person| person.image().centre_of(is_red)[0].abs_diff(x) < 4);

    // Selection: its bounding box is drawn.
    assert_eq!(person.image().count(is_outline), 0);
    person.click(x, y);
    person.until("it is selected", |person| person.image().count(is_outline) > 40);
    person.key("Escape", &[]);
    person.until("nothing is selected", |person| person.image().count(is_outline) == 0);

    // An edit is visible and can be saved.
    open_source(&person);
    person.still();
    let before = red(&person);
    type_radius(&person, "0.7", '1');
    person.until("the ball has grown", |person| red(person) > before * 3 / 2);
    assert_eq!(fs::read_to_string(&file).expect("read"), SCENE);
    person.until("the title says so", |person| person.title() == "• scene.kdl - pathmarch");
    person.key("s", &["Control_L"]);
    person.until("it is saved", |person| person.title() == "scene.kdl - pathmarch");
    let saved = SCENE.replace("sphere 0.7", "sphere 1");
    assert_eq!(fs::read_to_string(&file).expect("read"), saved, "only that number has changed");

    // Closing the window asks about unsaved work.
    person.text("2");
    person.until("there is unsaved work", |person| person.title().starts_with('•'));
    person.still();
    let image = person.image();
    person.close();
    person.until("it is asked", |person| person.image().differs_from(&image) > 20_000);
    assert!(person.is_running());
    person.key("Escape", &[]);
    person.until("the question is gone", |person| person.image().differs_from(&image) < 2_000);
    assert!(person.is_running() && fs::read_to_string(&file).expect("read") == saved);
    // The first button saves.
    person.close();
    person.until("it is asked", |person| person.image().differs_from(&image) > 20_000);
    person.key("Tab", &[]);
    person.key("Return", &[]);
    assert!(person.ends().success());
    assert_eq!(fs::read_to_string(&file).expect("read"), SCENE.replace("sphere 0.7", "sphere 12"));

    // The saved scene looks the same.
    fs::write(&file, SCENE).expect("written");
    let mut person = screen.person(directory.path(), Some(&file));
    let again = rested(&person);
    person.key("F4", &[]);
    person.until("it is as before", |person| red(person).abs_diff(seen) * 50 < seen + 50);
    assert!(again > 0);
    person.close();
    assert!(person.ends().success(), "nothing is unsaved, nothing is asked");
}

fn work_survives_a_kill() {
    let (screen, directory) = at_display();
    let file = scene_in(directory.path());
    let mut person = screen.person(directory.path(), Some(&file));
    rested(&person);
    open_source(&person);
    type_radius(&person, "0.7", '1');
    let changed = SCENE.replace("sphere 0.7", "sphere 1");
    let kept = || {
        let files = fs::read_dir(directory.path().join("home/recovery")).ok()?;
        let paths = files.filter_map(|entry| Some(entry.ok()?.path()));
        // A file that is being written when the program is killed has not got its name yet.
        let whole = paths.filter(|path| path.to_string_lossy().ends_with(".unsaved.kdl"));
        whole.filter_map(|path| fs::read_to_string(path).ok()).find(|text| text.ends_with(&changed))
    };
    person.until("it is kept", |_| kept().is_some());
    person.kill();
    assert_eq!(fs::read_to_string(&file).expect("read"), SCENE);

    // Recovered work is offered at the next start; the first button opens it.
    let mut person = screen.person(directory.path(), None);
    person.still();
    person.key("Tab", &[]);
    person.key("Return", &[]);
    person.until("it is opened", |person| person.title() == "• scene.kdl - pathmarch");
    rested(&person);
    person.key("s", &["Control_L"]);
    person.until("it is saved", |person| person.title() == "scene.kdl - pathmarch");
    assert_eq!(fs::read_to_string(&file).expect("read"), changed);
    // The window's recovery thread removes its file after the save.
    person.until("what is saved is not kept any more", |_| kept().is_none());
    person.close();
    assert!(person.ends().success());
}

fn work_that_survives_a_kill_does_not_replace_what_another_program_wrote() {
    let (screen, directory) = at_display();
    let file = scene_in(directory.path());
    let mut person = screen.person(directory.path(), Some(&file));
    rested(&person);
    open_source(&person);
    type_radius(&person, "0.7", '1');
    let theirs = SCENE.replace("emit 0 1 0", "emit 0 0 1");
    let kept = || {
        let mut files = fs::read_dir(directory.path().join("home/recovery")).into_iter().flatten();
        files.any(|entry| {
            let path = entry.expect("an entry").path();
            path.to_string_lossy().ends_with(".unsaved.kdl")
                && fs::read_to_string(path).is_ok_and(|text| text.contains("sphere 1 {"))
        })
    };
    person.until("it is kept", |_| kept());
    let image = person.image();
    fs::write(&file, &theirs).expect("written");
    person.until("it is asked", |person| person.image().differs_from(&image) > 20_000);
    person.kill();

    let mut person = screen.person(directory.path(), None);
    person.still();
    person.key("Tab", &[]);
    person.key("Return", &[]);
    person.until("it is opened", |person| person.title() == "• scene.kdl - pathmarch");
    // Saving waits for the answer to the dialog.
    person.key("s", &["Control_L"]);
    person.still();
    assert_eq!(person.title(), "• scene.kdl - pathmarch");
    assert_eq!(fs::read_to_string(&file).expect("read"), theirs);
    person.kill();
}

/// Resizes, flattens and hides the window, and restores it.
fn resize(person: &Person) {
    let original = person.size();
    for round in 0..40_u32 {
        let size = match round % 4 {
            0 => [1, 1],
            1 => [1 + 30 * round, 700 - 15 * round],
            2 => [1300 - 20 * round, 1],
            _ => [200 + 10 * round, 200 + 5 * round],
        };
        person.configure(&ConfigureWindowAux::new().width(size[0]).height(size[1]));
        if round % 10 == 9 {
            person.show(false);
            person.show(true);
        }
    }
    let size = ConfigureWindowAux::new().width(u32::from(original[0])).height(u32::from(original[1]));
    person.configure(&size);
    person.focus();
    rested(person);
}

fn any_size_is_survived_without_a_gpu() {
    let (screen, directory) = at_display();
    let file = scene_in(directory.path());
    let drawing = ["--drawing", "cpu"];
    let mut person = screen.person_with(directory.path(), Some(&file), &drawing);
    rested(&person);
    resize(&person);
    person.close();
    assert!(person.ends().success());
}

fn any_size_and_a_lost_device_are_survived() {
    let (screen, directory) = at_display();
    let file = scene_in(directory.path());
    let drawing = ["--drawing", "gpu"];
    let mut person = screen.person_with(directory.path(), Some(&file), &drawing);
    rested(&person);
    resize(&person);
    assert!(person.is_running());

    // Both devices are lost and reopened.
    let [x, _] = person.image().centre_of(is_red);
    person.key("F12", &["Control_L", "Shift_L"]);
    person.until("the device is lost", |person| person.printed().contains("graphics device failed"));
    person.until("the ball is back", |person| red(person) > 300);
    // The picture is drawn again, not left over.
    let [width, height] = person.size();
    let empty = [width / 2, height / 4];
    person.drag_until(empty, [5, 0], "it can be moved", |person| {
        let image = person.image();
        image.count(is_red) > 0 && image.centre_of(is_red)[0].abs_diff(x) > 20
    });
    assert_eq!(person.title(), "scene.kdl - pathmarch");
    person.close();
    assert!(person.ends().success());
}

/// A small disk, if the system allows one; removed with its directory.
struct Disk(PathBuf);

impl Disk {
    fn mounted(at: &Path) -> Option<Self> {
        fs::create_dir(at).expect("made");
        let mount = Command::new("mount").args(["-t", "tmpfs", "-o", "size=64k", "none"]).arg(at).output();
        mount.is_ok_and(|output| output.status.success()).then(|| Self(at.to_owned()))
    }
}

impl Drop for Disk {
    fn drop(&mut self) {
        // A disk that cannot be unmounted disappears with the machine.
        let _ = Command::new("umount").arg("-l").arg(&self.0).status();
    }
}

fn a_save_that_fails_is_said_and_loses_nothing() {
    let (screen, directory) = at_display();
    let place = directory.path().join("disk");
    let disk = Disk::mounted(&place);
    let file = scene_in(&place);
    let mut person = screen.person(directory.path(), Some(&file));
    rested(&person);
    open_source(&person);
    type_radius(&person, "0.7", '1');
    person.until("there is unsaved work", |person| person.title().starts_with('•'));
    person.still();
    if disk.is_some() {
        // Fill the rest of the disk.
        let filler = place.join("filler");
        let mut bytes = 64 * 1024;
        while bytes > 0 && fs::write(&filler, vec![b'x'; bytes]).is_err() {
            bytes -= 512;
        }
    } else {
        let mut permissions = fs::metadata(&file).expect("there").permissions();
        permissions.set_readonly(true);
        fs::set_permissions(&file, permissions).expect("set");
    }
    let image = person.image();
    person.key("s", &["Control_L"]);
    person.until("a message appears", |person| person.image().differs_from(&image) > 1_000);
    assert_eq!(person.title(), "• scene.kdl - pathmarch", "it is not saved");
    assert_eq!(fs::read_to_string(&file).expect("read"), SCENE, "the old file is whole");
    // With free space, saving works.
    if disk.is_some() {
        fs::remove_file(place.join("filler")).expect("removed");
    } else {
        let mut permissions = fs::metadata(&file).expect("there").permissions();
        #[expect(clippy::permissions_set_readonly_false, reason = "a file of this test")]
        permissions.set_readonly(false);
        fs::set_permissions(&file, permissions).expect("set");
    }
    person.key("s", &["Control_L"]);
    person.until("it is saved", |person| person.title() == "scene.kdl - pathmarch");
    assert_eq!(fs::read_to_string(&file).expect("read"), SCENE.replace("sphere 0.7", "sphere 1"));
    person.close();
    assert!(person.ends().success());
}

tests! {
    with_display slow: [a_scene_is_seen_turned_selected_edited_saved_and_seen_again, work_survives_a_kill, work_that_survives_a_kill_does_not_replace_what_another_program_wrote, any_size_is_survived_without_a_gpu, any_size_and_a_lost_device_are_survived, a_save_that_fails_is_said_and_loses_nothing],
}
