//! The examples run and write their pictures.

use pathmarch_render::image::load;
use pathmarch_testing::{ignore, plain, tests};
use std::process::Command;

fn examples_write_their_pictures() {
    let directory = tempfile::tempdir().expect("a directory");
    // Cargo builds the examples beside the tests; they write into the current directory.
    let test = std::env::current_exe().expect("this program");
    let built = test.parent().and_then(|deps| deps.parent()).expect("a build folder").join("examples");
    for name in ["ten_lines", "built_in_code"] {
        let program = built.join(name).with_extension(std::env::consts::EXE_EXTENSION);
        if !program.exists() {
            ignore("the examples are not built: name no targets, as `cargo test --release --workspace` does");
        }
        let status = Command::new(&program).current_dir(directory.path()).status();
        assert!(status.is_ok_and(|status| status.success()), "{}", program.display());
    }
    for (file, [r, g, b]) in [("ball.png", [0.4, 0.6, 1.0]), ("spiral.png", [0.8, 0.9, 1.0])] {
        let picture = load(&directory.path().join(file)).expect("written").picture;
        assert_eq!((picture.width, picture.height), (160, 90), "{file}");
        // The sky in a corner is more blue than red, and the object in the middle has another colour.
        let [corner, middle] = [picture.get(0, 0), picture.get(80, 45)].map(|pixel| pixel.expect("within"));
        assert!(b > g && g > r && corner[2] > corner[0], "{file}: {corner:?}");
        let difference: f32 = corner.iter().zip(middle).map(|(a, b)| (a - b).abs()).sum();
        assert!(difference > 0.1, "{file}: {corner:?} and {middle:?}");
    }
}

tests! {
    plain: [examples_write_their_pictures],
}
