//! The examples do what they say. They write into the current directory, so that this is the only test of its process.

#[path = "../examples/built_in_code.rs"]
mod built_in_code;
#[path = "../examples/ten_lines.rs"]
mod ten_lines;

use pathmarch_render::image::load;

#[test]
fn examples_write_their_pictures() {
    let directory = tempfile::tempdir().expect("a directory");
    std::env::set_current_dir(directory.path()).expect("it is there");
    ten_lines::main().expect("it renders");
    built_in_code::main().expect("it renders");
    for (file, [r, g, b]) in [("ball.png", [0.4, 0.6, 1.0]), ("spiral.png", [0.8, 0.9, 1.0])] {
        let picture = load(&directory.path().join(file)).expect("written").picture;
        assert_eq!((picture.width, picture.height), (160, 90), "{file}");
        // The sky in a corner is bluer than it is red, and what stands in the middle is another colour.
        let [corner, middle] = [picture.get(0, 0), picture.get(80, 45)].map(|pixel| pixel.expect("within"));
        assert!(b > g && g > r && corner[2] > corner[0], "{file}: {corner:?}");
        let difference: f32 = corner.iter().zip(middle).map(|(a, b)| (a - b).abs()).sum();
        assert!(difference > 0.1, "{file}: {corner:?} and {middle:?}");
    }
}
