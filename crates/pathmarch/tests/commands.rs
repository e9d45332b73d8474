//! Tests of the command line: output, files and exit codes.

mod program;

use pathmarch_render::Mode;
use pathmarch_render::image::load;
use pathmarch_render::pathmarch_field::number::Vec3;
use pathmarch_render::pathmarch_scene::Scene;
use program::{code, pathmarch, stderr};
use std::path::{Path, PathBuf};

fn scene(name: &str) -> String {
    let path: PathBuf = [env!("CARGO_MANIFEST_DIR"), "../../scenes/thesis", name].iter().collect();
    path.to_string_lossy().into_owned()
}

#[test]
fn render_writes_a_picture_and_says_where_it_ran() {
    let directory = tempfile::tempdir().expect("a directory");
    let scene = scene("diffuse-sphere.kdl");
    let small = ["--size", "64x36", "--samples", "2"];
    for name in ["a.png", "a.jpg", "a.exr"] {
        let output =
            pathmarch(&[&["render", &scene, "--backend", "cpu", "-o", name], &small[..]].concat(), directory.path());
        assert_eq!(code(&output), 0, "{}", stderr(&output));
        assert!(stderr(&output).contains("on CPU"), "{}", stderr(&output));
        assert!(directory.path().join(name).metadata().expect("written").len() > 100);
    }
    let output = pathmarch(&[&["render", &scene], &small[..]].concat(), directory.path());
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert!(directory.path().join("diffuse-sphere.png").is_file(), "the scene's name, .png, in this directory");
    assert_eq!(directory.path().read_dir().expect("a directory").count(), 4, "nothing else is left behind");
}

/// A wrong exposure is reported with the one that suits; `auto` takes it.
#[test]
fn the_exposure_may_follow_the_picture() {
    let directory = tempfile::tempdir().expect("a directory");
    let text =
        "pathmarch 1\ncamera { position 0 0 4; target 0 0 0 }\nsky 46.08\nobject \"a\" { sphere 0.01 { at 9 0 0 } }\n";
    std::fs::write(directory.path().join("bright.kdl"), text).expect("written");
    let render = |arguments: &[&str]| {
        let fixed = ["render", "bright.kdl", "--size", "16x9", "--samples", "1", "--backend", "cpu"];
        pathmarch(&[&fixed[..], arguments].concat(), directory.path())
    };
    let [auto, same, plain] =
        [&["--exposure", "auto", "-o", "auto.png"][..], &["--exposure=-8", "-o", "same.png"], &["-o", "plain.png"]]
            .map(|arguments| stderr(&render(arguments)));
    assert!(auto.contains("exposure -8 EV") && !auto.contains("overexposed"), "{auto}");
    assert!(!same.contains("overexposed"), "{same}");
    assert!(plain.contains("100 % of the picture is overexposed; `exposure -8`"), "{plain}");
    let pixels = |name: &str| load(&directory.path().join(name)).expect("a picture").picture.pixels;
    assert_eq!(pixels("auto.png"), pixels("same.png"));
    assert_ne!(pixels("auto.png"), pixels("plain.png"));
    // Frames share one, and a film finds it when it becomes a picture.
    let output = render(&["--exposure", "auto", "--frames", "1-2", "-o", "f#.png"]);
    assert!(stderr(&output).contains("exposure -8 EV in all frames"), "{}", stderr(&output));
    assert!(["f1.png", "f2.png"].iter().all(|name| pixels(name) == pixels("same.png")));
    assert_eq!(code(&render(&["--exposure", "auto", "-o", "auto.film"])), 0);
    assert_eq!(code(&pathmarch(&["merge", "auto.film", "-o", "merged.png"], directory.path())), 0);
    assert_eq!(pixels("merged.png"), pixels("same.png"));
    // Scenes may ask for it; the option is stronger.
    std::fs::write(directory.path().join("bright.kdl"), text.replace("0 0 0 }", "0 0 0; exposure \"auto\" }"))
        .expect("written");
    assert!(stderr(&render(&["-o", "scene.png"])).contains("exposure -8 EV"));
    render(&["--exposure", "0", "-o", "option.png"]);
    assert_eq!((pixels("scene.png"), pixels("option.png")), (pixels("same.png"), pixels("plain.png")));
}

/// Walls and overhangs of what is to be printed, before it is exported.
#[test]
fn check_reports_walls_and_overhangs() {
    let directory = tempfile::tempdir().expect("a directory");
    let text = "pathmarch 1\nunit \"mm\"\ncamera { position 0 40 90; target 0 10 0 }\nsky 1\n\
                object \"cup\" { subtract { cylinder 10 10; cylinder 9 10 { at 0 1 0 }; at 0 10 0 } }\n\
                object \"floor\" { plane }\n";
    std::fs::write(directory.path().join("cup.kdl"), text).expect("written");
    let check = |arguments: &[&str]| {
        let output = pathmarch(&[&["check", "cup.kdl", "--print"], arguments].concat(), directory.path());
        assert_eq!(code(&output), 0, "{}", stderr(&output));
        String::from_utf8(output.stdout).expect("text")
    };
    let said = check(&[]);
    assert!(
        said.contains("cup: 20.00 x 20.00 x 20.00 mm; thinnest wall 1.0") || said.contains("thinnest wall 0.9"),
        "{said}"
    );
    assert!(said.contains("overhangs by more than 45°") && !said.contains("floor:"), "{said}");
    let json: serde_json::Value = serde_json::from_str(&check(&["--json"])).expect("JSON");
    let cup = &json["print"][0];
    let wall = cup["thinnest_wall"].as_f64().expect("a wall");
    assert!(cup["object"] == "cup" && (wall - 1.0).abs() < 0.1, "{json}");
}

#[test]
fn a_shape_is_described_as_json() {
    let output = pathmarch(&["shapes", "torus", "--json"], std::path::Path::new("."));
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert!(json["name"] == "torus" && json["params"][0]["name"].is_string(), "{json}");
}

#[test]
fn a_render_may_be_bounded_in_time() {
    let directory = tempfile::tempdir().expect("a directory");
    let scene = scene("diffuse-sphere.kdl");
    let arguments = ["render", &scene, "--size", "64x36", "--samples", "1000000", "--backend", "cpu", "-o", "a.exr"];
    let output = pathmarch(&[&arguments[..], &["--seconds", "0.2"]].concat(), directory.path());
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert!(stderr(&output).contains("of 1000000 samples in"), "{}", stderr(&output));
    assert!(directory.path().join("a.exr").is_file());
    for bad in ["0", "-1", "NaN", "soon"] {
        let output = pathmarch(&[&arguments[..], &[&format!("--seconds={bad}")]].concat(), directory.path());
        assert_eq!(code(&output), 2, "{bad}");
    }
}

const MOVING: &str = "pathmarch 1
camera { position 0 0 5; target 0 0 0 }
render { size 16 9; samples 2; fps 10 }
sky 1
object \"ball\" { sphere \"1.05 - t\" { at frame 0 0 } }
";

#[test]
fn frames_are_rendered_one_after_the_other() {
    let directory = tempfile::tempdir().expect("a directory");
    std::fs::write(directory.path().join("ball.kdl"), MOVING).expect("written");
    let run = |arguments: &[&str]| {
        pathmarch(&[&["render", "ball.kdl", "--backend", "cpu"], arguments].concat(), directory.path())
    };
    let there = |name: &str| directory.path().join(name).is_file();
    let output = run(&["--frames", "1-5x2", "-o", "f-###.exr"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert!(there("f-001.exr") && there("f-003.exr") && there("f-005.exr") && !there("f-002.exr"));
    assert!(stderr(&output).contains("wrote 3 frames to f-###.exr"), "{}", stderr(&output));
    // Frames differ; a frame rendered alone is the same.
    let picture = |name: &str| load(&directory.path().join(name)).expect("a picture").picture.pixels;
    assert_ne!(picture("f-001.exr"), picture("f-003.exr"));
    let output = run(&["--time", "0.3", "-o", "at.exr"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert_eq!(picture("f-003.exr"), picture("at.exr"));
    // Existing files are skipped if they are whole.
    std::fs::copy(directory.path().join("f-001.exr"), directory.path().join("f-003.exr")).expect("copied");
    std::fs::write(directory.path().join("f-002.exr"), "torn").expect("written");
    let output = run(&["--frames", "2-3", "-o", "f-###.exr", "--skip-existing"]);
    assert!(stderr(&output).contains("f-002.exr is damaged"), "{}", stderr(&output));
    assert!(
        stderr(&output).contains("wrote 1 frame to f-###.exr") && stderr(&output).contains("1 existed already"),
        "{}",
        stderr(&output)
    );
    assert_eq!(picture("f-003.exr"), picture("f-001.exr"), "it was left as it is");
    assert_ne!(picture("f-002.exr"), picture("f-001.exr"));
    // Without -o, a range gets a file name with digits.
    assert_eq!(code(&run(&["--frames", "7"])), 0);
    assert!(there("ball-0007.png"));
    // An error in a later frame names the frame; earlier frames are kept.
    let output = run(&["--frames", "9-12", "-o", "g#.png"]);
    assert_eq!(code(&output), 2);
    let message = stderr(&output);
    assert!(
        message.contains("frame 11 cannot be rendered") && message.contains("is -0.05") && message.contains("frame 11"),
        "{message}"
    );
    assert!(there("g9.png") && there("g10.png") && !there("g11.png"));
    for wrong in [
        &["--frames", "5-1"][..],
        &["--frames", "1-2", "-o", "one.png"],
        &["--frames", "1", "--time", "2"],
        &["--skip-existing"],
        &["--fps", "0"],
    ] {
        assert_eq!(code(&run(wrong)), 2, "{wrong:?}");
    }
    assert!(stderr(&run(&["--frames", "1-2", "-o", "one.png"])).contains("as in one-####.png"));
}

#[test]
fn a_picture_shows_what_its_mode_says() {
    let directory = tempfile::tempdir().expect("a directory");
    let scene = scene("diffuse-sphere.kdl");
    let render = |mode: &str, more: &[&str]| {
        let fixed = ["render", &scene, "--size", "32x18", "--backend", "cpu", "--mode", mode];
        pathmarch(&[&fixed[..], more].concat(), directory.path())
    };
    for mode in Mode::ALL.map(Mode::name) {
        let path = directory.path().join("a.exr");
        let samples: &[&str] = if mode == "path" || mode == "variance" { &["--samples", "2"] } else { &[] };
        let output = render(mode, &[&["-o", "a.exr"], samples].concat());
        assert_eq!(code(&output), 0, "{mode}: {}", stderr(&output));
        let loaded = load(&path).expect("written");
        let provenance = loaded.provenance.expect("our own");
        // Noise-free modes take only as many samples as smooth edges need.
        assert_eq!((provenance.mode.as_str(), provenance.samples), (mode, if samples.is_empty() { 16 } else { 2 }));
    }
    // Exposure and tone mapping do not affect data modes.
    for exposure in ["0", "5"] {
        let output = render("normal", &["-o", &format!("{exposure}.png"), "--exposure", exposure, "--samples", "1"]);
        assert_eq!(code(&output), 0, "{}", stderr(&output));
    }
    let [plain, exposed] = ["0.png", "5.png"].map(|name| std::fs::read(directory.path().join(name)).expect("written"));
    assert_eq!(plain, exposed);
    let output = render("fog", &[]);
    assert_eq!(code(&output), 2);
    assert!(stderr(&output).contains("expected one of path, preview, albedo"), "{}", stderr(&output));
    let help = pathmarch(&["render", "--help"], directory.path());
    let help = String::from_utf8_lossy(&help.stdout).into_owned();
    for mode in Mode::ALL {
        assert!(help.contains(mode.name()), "{} in {help}", mode.name());
    }
}

#[test]
fn layers_are_written_beside_the_picture() {
    let directory = tempfile::tempdir().expect("a directory");
    let scene = scene("diffuse-sphere.kdl");
    let small = ["render", &scene, "--size", "64x36", "--samples", "2", "-o", "a.exr"];
    let all = ["albedo.R", "normal.X", "depth.Z", "position.Z", "objectId.X", "materialId.X", "sampleCount.X"];
    for (arguments, expected) in [
        (&[][..], &[][..]),
        (&["--aov"], &all),
        (&["--aov", "all"], &all),
        (&["--aov", "depth, albedo,depth"], &["albedo.R", "depth.Z"]),
        (&["--aov", "--backend", "cpu"], &all),
    ] {
        let output = pathmarch(&[&small[..], arguments].concat(), directory.path());
        assert_eq!(code(&output), 0, "{arguments:?}: {}", stderr(&output));
        let bytes = std::fs::read(directory.path().join("a.exr")).expect("written");
        let has = |name: &&&str| bytes.windows(name.len() + 1).any(|part| part == format!("{name}\0").as_bytes());
        assert_eq!(all.iter().filter(has).collect::<Vec<_>>(), expected.iter().collect::<Vec<_>>(), "{arguments:?}");
    }
    let same = pathmarch(&["compare", "a.exr", "a.exr", "--max-relmse", "0"], directory.path());
    assert_eq!(code(&same), 0, "{}", stderr(&same));
    std::fs::remove_file(directory.path().join("a.exr")).expect("removed");
    for (wrong, words) in [
        (&["render", &scene, "--aov"][..], &["diffuse-sphere.png", "-o diffuse-sphere.exr"][..]),
        (&["render", &scene, "-o", "b.png", "--aov=depth"], &["b.png", "-o b.exr"]),
        (
            &["render", &scene, "-o", "b.exr", "--aov", "depth,colour"],
            &["\"colour\"", "albedo, normal, depth, position"],
        ),
        (&["render", &scene, "-o", "b.exr", "--aov="], &["albedo"]),
        (&["render", "-o", "b.exr", "--aov", &scene], &["comes before --aov"]),
    ] {
        let output = pathmarch(wrong, directory.path());
        assert_eq!(code(&output), 2, "{wrong:?}: {}", stderr(&output));
        for word in words {
            assert!(stderr(&output).contains(word), "{wrong:?}: {}", stderr(&output));
        }
    }
    assert_eq!(directory.path().read_dir().expect("a directory").count(), 0, "nothing is written");
}

#[test]
fn pictures_are_denoised_on_request() {
    let directory = tempfile::tempdir().expect("a directory");
    let scene = scene("diffuse-sphere.kdl");
    let small = ["render", &scene, "--size", "64x36", "--samples", "8", "--backend", "cpu", "-o"];
    let render = |name: &str, more: &[&str]| pathmarch(&[&small[..], &[name], more].concat(), directory.path());
    let file = |name: &str| load(&directory.path().join(name)).expect("written");
    for (name, more) in
        [("plain.exr", &[][..]), ("a.exr", &["--denoise"]), ("b.exr", &["--denoise=regression", "--aov"])]
    {
        let output = render(name, more);
        assert_eq!(code(&output), 0, "{}", stderr(&output));
        assert_eq!(stderr(&output).contains("denoised in"), !more.is_empty(), "{}", stderr(&output));
        let denoiser = file(name).provenance.expect("of an EXR file").denoiser;
        assert_eq!(denoiser.as_deref(), (!more.is_empty()).then_some("regression"));
    }
    let [plain, a, b] = ["plain.exr", "a.exr", "b.exr"].map(|name| file(name).picture);
    assert!(a == b && a != plain);
    let bytes = std::fs::read(directory.path().join("b.exr")).expect("written");
    assert!(bytes.windows(8).any(|part| part == b"noisy.R\0"));

    for (wrong, words) in [
        (&["--denoise", "--mode", "normal"][..], "not those of --mode normal"),
        (&["--denoise", "nothing"], "expected regression or oidn; the scene comes before --denoise"),
    ] {
        let output = render("wrong.exr", wrong);
        assert_eq!(code(&output), 2, "{wrong:?}: {}", stderr(&output));
        assert!(stderr(&output).contains(words), "{wrong:?}: {}", stderr(&output));
    }
    assert!(!directory.path().join("wrong.exr").exists());
}

/// Wall below a lamp, along which the camera moves.
const PASSING: &str = "pathmarch 1
camera { position \"0.1*frame\" 0 2; target \"0.1*frame\" 0 0 }
render { size 32 18; bounces 1 }
material \"lamp\" { emit 20 }
object \"wall\" { rect 9 9 { normal 0 0 1 } }
object \"lamp\" material=\"lamp\" { rect 1 1 { normal 0 -1 0; at 0 2 1 } }
";

#[test]
fn sequences_are_denoised() {
    let directory = tempfile::tempdir().expect("a directory");
    std::fs::write(directory.path().join("moving.kdl"), PASSING).expect("written");
    let render = |name: &str, more: &[&str]| {
        let fixed = ["render", "moving.kdl", "--denoise", "--samples", "4", "--backend", "cpu", "-o", name];
        let output = pathmarch(&[&fixed[..], more].concat(), directory.path());
        assert_eq!(code(&output), 0, "{}", stderr(&output));
    };
    let file = |name: &str| load(&directory.path().join(name)).expect("written");
    let denoiser = |name: &str| file(name).provenance.expect("of an EXR file").denoiser.expect("denoised");
    render("joined-#.exr", &["--frames", "1-4"]);
    render("apart-#.exr", &["--frames", "1-4", "--denoise-temporal", "off"]);
    assert_eq!(
        ["joined-1.exr", "joined-2.exr", "apart-2.exr"].map(denoiser),
        ["regression", "regression, temporal", "regression"]
    );
    assert!(file("joined-1.exr").picture == file("apart-1.exr").picture, "the first frame is a still");
    assert!(file("joined-2.exr").picture != file("apart-2.exr").picture);
    // Frames wait for each other, however many there are at a time.
    render("parallel-#.exr", &["--frames", "1-4", "--parallel", "3"]);
    for frame in 1..=4 {
        let [a, b] = ["joined", "parallel"].map(|name| file(&format!("{name}-{frame}.exr")).picture);
        assert!(a == b, "frame {frame}");
    }
    // A frame after one that an earlier run has written starts anew.
    for frame in [1, 3, 4] {
        std::fs::remove_file(directory.path().join(format!("joined-{frame}.exr"))).expect("removed");
    }
    render("joined-#.exr", &["--frames", "1-4", "--skip-existing"]);
    assert!(file("joined-3.exr").picture == file("apart-3.exr").picture);
    assert_eq!(denoiser("joined-4.exr"), "regression, temporal");

    for (wrong, words) in [
        (&["--denoise-temporal", "on"][..], "--frames"),
        (&["--denoise=oidn", "--denoise-temporal", "on", "--frames", "1-2"], "can be averaged, not those of oidn"),
    ] {
        let output = pathmarch(&[&["render", "moving.kdl", "-o", "wrong-#.exr"], wrong].concat(), directory.path());
        assert_eq!(code(&output), 2, "{wrong:?}: {}", stderr(&output));
        assert!(stderr(&output).contains(words), "{wrong:?}: {}", stderr(&output));
    }
}

/// Before anything is rendered, the message names what was looked for.
#[test]
fn a_missing_library_is_reported() {
    let directory = tempfile::tempdir().expect("a directory");
    let scene = scene("diffuse-sphere.kdl");
    let mut program = std::process::Command::new(env!("CARGO_BIN_EXE_pathmarch"));
    program.args(["render", &scene, "--denoise", "oidn", "-o", "a.exr"]).current_dir(directory.path());
    let output = program.env("OIDN_LIBRARY", "nowhere/libNone.so").output().expect("the program starts");
    assert_eq!(code(&output), 1, "{}", stderr(&output));
    for words in ["tried nowhere/libNone.so", "OIDN_LIBRARY", "built-in denoiser"] {
        assert!(stderr(&output).contains(words), "{}", stderr(&output));
    }
    assert!(!directory.path().join("a.exr").exists());
}

/// A reader such as `head` closes the pipe early.
#[cfg(unix)]
#[test]
fn a_closed_pipe_ends_the_program_quietly() {
    use std::process::{Command, Stdio};
    let (reader, writer) = std::io::pipe().expect("a pipe");
    drop(reader);
    let mut program = Command::new(env!("CARGO_BIN_EXE_pathmarch"));
    program.arg("shapes").stdout(writer).stderr(Stdio::piped());
    let output = program.output().expect("the program starts");
    assert!(!output.status.success());
    assert_eq!(String::from_utf8_lossy(&output.stderr), "");
}

#[test]
fn the_kernel_of_a_scene_can_be_read() {
    let directory = tempfile::tempdir().expect("a directory");
    std::fs::write(directory.path().join("ball.kdl"), MOVING).expect("written");
    let output = pathmarch(&["render", "ball.kdl", "--dump-wgsl", "ball.wgsl"], directory.path());
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let code = std::fs::read_to_string(directory.path().join("ball.wgsl")).expect("written");
    for part in ["// ---- integrator/path.wgsl ----", "struct Frame {", "const MAX_STEPS = ", "fn trace("] {
        assert!(code.contains(part), "{part}");
    }
    let output = pathmarch(&["render", "ball.kdl", "--dump-wgsl", "no/such/ball.wgsl"], directory.path());
    assert!(stderr(&output).contains("ball.wgsl: cannot be written"), "{}", stderr(&output));
}

#[test]
fn compare_measures_and_judges() {
    let directory = tempfile::tempdir().expect("a directory");
    let scene = scene("diffuse-sphere.kdl");
    for (name, seed) in [("a.exr", "0"), ("b.exr", "1")] {
        let arguments =
            ["render", &scene, "--backend", "cpu", "--size", "64x36", "--samples", "4", "--seed", seed, "-o", name];
        assert_eq!(code(&pathmarch(&arguments, directory.path())), 0);
    }
    let same = pathmarch(&["compare", "a.exr", "a.exr", "--max-relmse", "0"], directory.path());
    assert_eq!(code(&same), 0);
    let text = String::from_utf8_lossy(&same.stdout).into_owned();
    assert!(text.contains("relMSE     0.000e0") && text.contains("FLIP       0.00000"), "{text}");
    assert_eq!(code(&pathmarch(&["compare", "a.exr", "b.exr", "--max-relmse", "0.1"], directory.path())), 0);
    assert_eq!(code(&pathmarch(&["compare", "a.exr", "b.exr", "--max-relmse", "1e-9"], directory.path())), 1);
    assert_eq!(code(&pathmarch(&["compare", "a.exr", "missing.exr"], directory.path())), 1);
    std::fs::write(directory.path().join("broken.exr"), [1, 2, 3]).expect("written");
    assert_eq!(code(&pathmarch(&["compare", "a.exr", "broken.exr"], directory.path())), 1);
}

#[test]
fn mistakes_end_with_code_2_and_nothing_is_written() {
    let directory = tempfile::tempdir().expect("a directory");
    std::fs::write(directory.path().join("bad.kdl"), "pathmarch 1\nobejct \"a\" { spere 1 }\n").expect("written");
    let output = pathmarch(&["render", "bad.kdl"], directory.path());
    assert_eq!(code(&output), 2);
    assert!(stderr(&output).contains("object") && stderr(&output).contains("bad.kdl:2:1"), "{}", stderr(&output));
    assert!(!directory.path().join("bad.png").exists());
    let scene = scene("solids.kdl");
    for wrong in [
        &["render"][..],
        &["render", "missing.kdl"],
        &["render", &scene, "--size", "10"],
        &["render", &scene, "--size", "0x10"],
        &["render", &scene, "--samples", "0"],
        &["render", &scene, "--bounces", "1001"],
        &["render", &scene, "-o", "a.gif"],
        &["render", &scene, "--camera", "nobody"],
        &["render", &scene, "--tonemap", "film"],
        &["check", "bad.kdl"],
        &["shapes", "spere"],
        &["frobnicate"],
    ] {
        let output = pathmarch(wrong, directory.path());
        assert_eq!(code(&output), 2, "{wrong:?}: {}", stderr(&output));
        assert!(stderr(&output).len() > 20, "{wrong:?} says what is wrong");
    }
    let output = pathmarch(&["render", &scene, "-o", "no/such/directory/a.png"], directory.path());
    assert_eq!(code(&output), 1, "{}", stderr(&output));
}

#[test]
fn check_devices_and_shapes_answer() {
    let directory = tempfile::tempdir().expect("a directory");
    assert_eq!(code(&pathmarch(&["check", &scene("solids.kdl"), &scene("open-room.kdl")], directory.path())), 0);
    let field = pathmarch(&["check", "--field", &scene("combinations.kdl")], directory.path());
    assert_eq!(code(&field), 0);
    let text = String::from_utf8_lossy(&field.stdout).into_owned();
    assert!(text.matches(": safe; slope up to ").count() > 3 && !text.contains("NOT SAFE"), "{text}");
    let devices = pathmarch(&["devices"], directory.path());
    assert!(code(&devices) == 0 && String::from_utf8_lossy(&devices.stdout).contains("CPU"));
    let shapes = pathmarch(&["shapes"], directory.path());
    assert!(String::from_utf8_lossy(&shapes.stdout).contains("torus major minor"));
    let wgsl = pathmarch(&["shapes", "torus", "--wgsl"], directory.path());
    assert!(
        String::from_utf8_lossy(&wgsl.stdout).contains("fn torus_distance(p: vec3f, major: f32, minor: f32) -> f32")
    );
}

#[test]
fn help_answers_for_commands_and_words() {
    let directory = tempfile::tempdir().expect("a directory");
    let stdout = |arguments: &[&str]| {
        let output = pathmarch(arguments, directory.path());
        assert_eq!(code(&output), 0, "{arguments:?}: {}", stderr(&output));
        String::from_utf8_lossy(&output.stdout).into_owned()
    };
    assert!(stdout(&["help"]).contains("Commands:"));
    assert!(stdout(&["help", "export"]).contains("--resolution"));
    let both = stdout(&["help", "render"]);
    assert!(both.contains("--samples") && both.contains("node `render`"), "{both}");
    assert!(stdout(&["help", "roughness"]).contains("`roughness` of material `metal`"));
    assert!(stdout(&["help", "wood"]).contains("texture `wood`"));
    assert!(stdout(&["help", "torus"]).contains("shape `torus`"));
    assert!(stdout(&["help", "fog"]).contains("node `fog`"));
    assert!(stdout(&["help", "hair"]).contains("Not supported yet"));
    for (word, help) in [("spere", "did you mean \"sphere\"?"), ("qqqqqqqq", "there is no command and no word")] {
        let output = pathmarch(&["help", word], directory.path());
        assert!(code(&output) == 2 && stderr(&output).contains(help), "{}", stderr(&output));
    }
    let texture = pathmarch(&["shapes", "wood"], directory.path());
    assert!(stderr(&texture).contains("`pathmarch help wood`"), "{}", stderr(&texture));
}

const STEEP: &str = "pathmarch 1
camera { position 0 1 4; target 0 0 0 }
sky 1
material \"lamp\" { emit 8 }
field \"steep\" { bounds 2 2 2; wgsl \"fn distance(p: vec3f) -> f32 { return 3.0 * (length(p) - 0.5); }\" }
object \"ball\" { steep }
object \"lamps\" material=\"lamp\" { sphere 0.1 { at 2 0 0 }; sphere 0.1 { at -2 0 0 } }
";

#[test]
fn check_counts_lamps_and_warns_of_steep_fields() {
    let directory = tempfile::tempdir().expect("a directory");
    std::fs::write(directory.path().join("steep.kdl"), STEEP).expect("written");
    let output = pathmarch(&["check", "steep.kdl"], directory.path());
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert_eq!(code(&output), 0, "{text}");
    assert!(text.contains("OK: 3 shapes in 2 objects, 2 materials, 2 lights (2 shapes emitting), 1 camera"), "{text}");
    assert!(text.contains("field `steep` is 3.00 times as steep"), "{text}");
}

const SOLIDS: &str = "pathmarch 1
camera { position 0 1 4; target 0 0 0 }
sky 1
object \"ball\" { sphere 0.5 }
object \"block\" { box 1 { at 2 0 0 } }
object \"card\" { rect 1 1 { at 4 0 0 } }
object \"floor\" { plane { at 0 -2 0 } }
";

#[test]
fn export_writes_meshes() {
    let directory = tempfile::tempdir().expect("a directory");
    std::fs::write(directory.path().join("solids.kdl"), SOLIDS).expect("written");
    let export = |more: &[&str]| pathmarch(&[&["export", "solids.kdl"], more].concat(), directory.path());
    for extension in ["stl", "ply", "obj", "glb", "GLB"] {
        let name = format!("a.{extension}");
        let output = export(&["--object", "ball", "--object", "block", "--resolution", "40", "-o", &name]);
        assert_eq!(code(&output), 0, "{}", stderr(&output));
        assert!(directory.path().join(&name).metadata().expect("written").len() > 10_000);
        let text = stderr(&output);
        assert!(text.contains("\"ball\", \"block\", 40 cells") && text.contains(&format!("wrote {name}: ")), "{text}");
        let number = |unit: &str| {
            let before = text.split(unit).next().and_then(|text| text.split_whitespace().last());
            before.and_then(|number| number.parse::<f64>().ok()).expect("a number")
        };
        // STL is in millimetres, and its volume reported in cubic centimetres.
        let (unit, per_metre, size) = if extension == "stl" { ("cm", 100.0, "mm") } else { ("m", 1.0, "m") };
        let volume = number(&format!(" {unit}³")) / f64::powi(per_metre, 3);
        let area = number(&format!(" {unit}² in")) / f64::powi(per_metre, 2);
        assert!((volume / (1.0 + std::f64::consts::PI / 6.0) - 1.0).abs() < 0.01, "{text}");
        assert!((area / (6.0 + std::f64::consts::PI) - 1.0).abs() < 0.01, "{text}");
        assert!(text.contains(&format!(" {size}, ")), "its size: {text}");
    }
    let output = export(&["--object", "block", "--unit", "inch", "-o", "a.obj"]);
    assert!(code(&output) == 0 && stderr(&output).contains("39.37 x 39.37 x 39.37 in, "), "{}", stderr(&output));
    let output = export(&["--object", "block", "--unit", "mm", "-o", "a.glb"]);
    assert!(
        code(&output) == 2 && stderr(&output).contains(".glb files are in m: leave --unit out"),
        "{}",
        stderr(&output)
    );
    // A block of one centimetre.
    let text = SOLIDS.replacen("pathmarch 1", "pathmarch 1\nunit \"cm\"", 1);
    std::fs::write(directory.path().join("centimetres.kdl"), text).expect("written");
    for (name, size) in [
        ("b.stl", "10.00 x 10.00 x 10.00 mm"),
        ("b.obj", "1.000 x 1.000 x 1.000 cm"),
        ("b.glb", "0.01000 x 0.01000 x 0.01000 m"),
    ] {
        let output = pathmarch(&["export", "centimetres.kdl", "--object", "block", "-o", name], directory.path());
        let text = stderr(&output);
        assert!(code(&output) == 0 && text.contains(size), "{text}");
        assert_eq!(text.contains("thinnest wall 10.00 mm; nothing overhangs"), name == "b.stl", "{text}");
        std::fs::remove_file(directory.path().join(name)).expect("written");
    }
    let output = export(&["--skip-infinite", "--resolution", "20", "-o", "finite.ply"]);
    assert!(code(&output) == 0 && stderr(&output).contains("infinite objects: \"floor\""), "{}", stderr(&output));
    // All solids, clipped; sheets are named and left out.
    let output = export(&["--bounds", "-1 -2.5 -1 3 1 1", "--cell", "0.1", "-o", "all.stl"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert!(stderr(&output).contains("left out") && stderr(&output).contains("\"card\""), "{}", stderr(&output));
    assert_eq!(directory.path().read_dir().expect("a directory").count(), 9, "nothing else is left behind");
}

#[test]
fn an_exported_volume_can_be_placed_where_it_was() {
    let directory = tempfile::tempdir().expect("a directory");
    std::fs::write(directory.path().join("solids.kdl"), SOLIDS).expect("written");
    let export = |arguments: &[&str]| {
        let output = pathmarch(&[&["export"], arguments].concat(), directory.path());
        assert_eq!(code(&output), 0, "{}", stderr(&output));
        stderr(&output)
    };
    let text = export(&["solids.kdl", "--object", "block", "--cell", "0.02", "-o", "block.npy"]);
    let node = text.lines().find_map(|line| line.strip_prefix("in a scene: ")).expect("a node");
    let start = "pathmarch 1\ncamera { position 0 1 4; target 0 0 0 }\nsky 1\n";
    std::fs::write(directory.path().join("volume.kdl"), format!("{start}object \"block\" {{ {node} }}"))
        .expect("written");
    let scene = Scene::load(directory.path().join("volume.kdl")).expect("a scene");
    // Outside the grid a volume gives a lower bound.
    for (x, y, z, expected, below) in [
        (2.0, 0.0, 0.0, -0.5, 0.02),
        (2.0, 0.0, -0.4, -0.1, 0.02),
        (2.51, 0.1, 0.2, 0.01, 0.002),
        (2.8, 0.1, 0.2, 0.3, 0.05),
        (2.1, -0.9, 0.0, 0.4, 0.05),
    ] {
        let distance = scene.field.distance(Vec3::new(x, y, z));
        assert!(
            (expected - below..expected + 0.01).contains(&distance),
            "{x} {y} {z}: {distance} instead of {expected}"
        );
    }
    export(&["solids.kdl", "--object", "ball", "--resolution", "10", "-o", "ball.npz"]);
    let archive = std::fs::read(directory.path().join("ball.npz")).expect("an archive");
    for name in ["origin.npy", "cell.npy", "distance.npy"] {
        assert!(archive.windows(name.len()).any(|bytes| bytes == name.as_bytes()), "{name}");
    }
    let millimetres =
        pathmarch(&["export", "solids.kdl", "--object", "ball", "--unit", "mm", "-o", "a.npy"], directory.path());
    assert!(
        code(&millimetres) == 2 && stderr(&millimetres).contains("in the unit of the scene, m"),
        "{}",
        stderr(&millimetres)
    );
}

#[test]
fn what_cannot_be_exported_is_refused() {
    let directory = tempfile::tempdir().expect("a directory");
    std::fs::write(directory.path().join("solids.kdl"), SOLIDS).expect("written");
    for (wrong, expected, words) in [
        (&["-o", "a.stl"][..], 2, &["\"floor\"", "--object", "--bounds"][..]),
        (&["-o", "a.stl", "--skip-infinite", "--object", "floor"], 2, &["\"floor\"", "--bounds"]),
        (&["-o", "a.fbx", "--object", "ball"], 2, &[".stl, .ply, .obj, .glb, .3mf, .usda or .usdz"]),
        (&["-o", "a.stl", "--object", "bal"], 2, &["did you mean \"ball\"", "\"block\""]),
        (&["-o", "a.stl", "--object", "card"], 2, &["\"card\"", "no inside"]),
        (&["-o", "a.stl", "--object", "ball", "--resolution", "100000"], 2, &["larger cells"]),
        (&["-o", "a.stl", "--object", "ball", "--cell", "1e-9"], 2, &["larger cells"]),
        (&["-o", "a.stl", "--object", "ball", "--cell", "0"], 2, &["above 0"]),
        (&["-o", "a.stl", "--object", "ball", "--cell", "0.1", "--resolution", "9"], 2, &["--resolution"]),
        (&["-o", "a.stl", "--bounds", "1 1 1 0 0 0"], 2, &["smaller corner"]),
        (&["-o", "a.stl", "--object", "ball", "--bounds", "5 5 5 6 6 6"], 2, &["no inside"]),
        (&["-o", "no/such/a.stl", "--object", "ball"], 1, &["no/such"]),
        (&["--object", "ball"], 2, &["--output"]),
    ] {
        let output = pathmarch(&[&["export", "solids.kdl"], wrong].concat(), directory.path());
        assert_eq!(code(&output), expected, "{wrong:?}: {}", stderr(&output));
        for word in words {
            assert!(stderr(&output).contains(word), "{wrong:?}: {}", stderr(&output));
        }
    }
    assert_eq!(directory.path().read_dir().expect("a directory").count(), 1, "nothing is written");
}

/// Interrupts the program after its first line, which appears once Ctrl-C is handled. Returns that line, the others,
/// and the exit code.
#[cfg(unix)]
fn interrupted(arguments: &[&str], directory: &Path) -> (String, Vec<String>, Option<i32>) {
    let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_pathmarch"))
        .args(arguments)
        .current_dir(directory)
        .stderr(std::process::Stdio::piped())
        .spawn()
        .expect("the program starts");
    let mut lines = std::io::BufRead::lines(std::io::BufReader::new(child.stderr.take().expect("piped")));
    let first = lines.next().expect("a line").expect("text");
    let killed =
        std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("kill is there");
    assert!(killed.success());
    let rest = lines.map(|line| line.expect("text")).collect();
    (first, rest, child.wait().expect("it ends").code())
}

#[cfg(unix)]
#[test]
fn an_interrupted_export_leaves_nothing() {
    let directory = tempfile::tempdir().expect("a directory");
    std::fs::write(directory.path().join("solids.kdl"), SOLIDS).expect("written");
    let arguments = ["export", "solids.kdl", "--object", "ball", "--resolution", "1000", "-o", "a.stl"];
    let (first, rest, code) = interrupted(&arguments, directory.path());
    assert!(first.contains("1000 cells"), "{first}");
    assert_eq!(code, Some(130), "{rest:?}");
    assert!(rest.iter().any(|line| line.contains("nothing was written")), "{rest:?}");
    assert_eq!(directory.path().read_dir().expect("a directory").count(), 1, "nothing is left behind");
}

#[cfg(unix)]
#[test]
fn an_interrupted_render_writes_what_is_done() {
    let directory = tempfile::tempdir().expect("a directory");
    let solids = scene("solids.kdl");
    let arguments = ["render", &solids, "--backend", "cpu", "--size", "64x36", "--samples", "1000000"];
    let (first, rest, code) = interrupted(&arguments, directory.path());
    assert!(first.contains("on CPU"), "{first}");
    assert_eq!(code, Some(130));
    assert!(rest.iter().any(|line| line.contains("interrupted: wrote solids.png")), "{rest:?}");
    assert!(directory.path().join("solids.png").is_file());
}

/// Options that take numbers, each with a command and the expected error.
const NUMBERS: &[(&[&str], &str, &str)] = &[
    (&["render", "a.kdl"], "--exposure", "must be a number from -100 to 100"),
    (&["render", "a.kdl"], "--samples", "must be a whole number from 1 to 1000000"),
    (&["render", "a.kdl"], "--seed", "must be a whole number from 0 to 4294967295"),
    (&["render", "a.kdl"], "--first-sample", "must be a whole number from 0 to 2000000000"),
    (&["render", "a.kdl"], "--bounces", "must be a whole number from 0 to 1000"),
    (&["render", "a.kdl"], "--splitting", "must be a whole number from 1 to 8"),
    (&["render", "a.kdl"], "--seconds", "must be a number of seconds above 0, at most 86400"),
    (&["render", "a.kdl"], "--time", "must be a number of seconds from 0 to 1000000000"),
    (&["render", "a.kdl"], "--clamp", "must be a finite number above 0"),
    (&["render", "a.kdl"], "--detail", "must be a number from 0.001 to 10"),
    (&["render", "a.kdl"], "--fps", "must be a number above 0 and at most 1000"),
    (&["render", "a.kdl"], "--shutter", "must be a number from 0 to 1"),
    (&["render", "a.kdl"], "--size", "expected WIDTHxHEIGHT in pixels, such as 1280x720"),
    (&["render", "a.kdl"], "--frames", "a range such as 1-120"),
    (&["export", "a.kdl", "-o", "a.stl"], "--resolution", "must be a whole number from 1 to 100000"),
    (&["export", "a.kdl", "-o", "a.stl"], "--cell", "expected a length above 0, such as 0.01"),
    (&["export", "a.kdl", "-o", "a.stl"], "--bounds", "expected the smaller corner and the larger one"),
    (&["compare", "a.exr", "b.exr"], "--max-relmse", "must be a finite number, 0 or more"),
];

#[test]
fn numbers_that_an_option_cannot_be_are_refused_with_what_it_can_be() {
    let directory = tempfile::tempdir().expect("a directory");
    for (command, option, words) in NUMBERS {
        for value in ["nan", "-inf", "inf", "-1e9", "1e999", "-1e999", "one", ""] {
            let output = pathmarch(&[*command, &[*option, value]].concat(), directory.path());
            let message = stderr(&output);
            assert_eq!(code(&output), 2, "{option} {value}: {message}");
            assert!(
                message.contains(&format!("invalid value '{value}' for '{option} <")),
                "{option} {value}: {message}"
            );
            assert!(message.contains(words), "{option} {value}: {message}");
        }
    }
    assert_eq!(directory.path().read_dir().expect("a directory").count(), 0, "nothing is written");
}

#[test]
fn what_is_just_past_a_range_is_refused_as_well() {
    let directory = tempfile::tempdir().expect("a directory");
    for (option, value, words) in [
        ("--exposure", "1e9", "must be a number from -100 to 100"),
        ("--exposure", "-100.01", "must be a number from -100 to 100"),
        ("--seed", "-1", "must be a whole number from 0 to 4294967295"),
        ("--seed", "4294967296", "must be a whole number from 0 to 4294967295"),
        ("--size", "99999999999x1", "each side must be from 1 to 16384"),
        ("--size", "-5x10", "each side must be from 1 to 16384"),
        ("--size", "16385x1", "each side must be from 1 to 16384"),
        ("--frames", "4294967296", "the last frame is 4294967295"),
        ("--fps", "0", "must be a number above 0 and at most 1000"),
        ("--clamp", "1e-60", "must be a finite number above 0"),
        ("--detail", "0.0009", "must be a number from 0.001 to 10"),
    ] {
        let output = pathmarch(&["render", "a.kdl", option, value], directory.path());
        let message = stderr(&output);
        assert_eq!(code(&output), 2, "{message}");
        assert!(message.starts_with(&format!("error: invalid value '{value}' for '{option} <")), "{message}");
        assert!(message.contains(words) && !message.contains("unexpected argument"), "{message}");
    }
    // The limits of a range are valid, and a value may begin with a hyphen.
    let scene = scene("diffuse-sphere.kdl");
    let small = ["render", &scene, "--backend", "cpu", "--size", "8x4", "--samples", "1", "-o", "a.png"];
    for (option, value) in [("--exposure", "-100"), ("--exposure", "100"), ("--seed", "4294967295"), ("--fps", "1e-40")]
    {
        let output = pathmarch(&[&small[..], &[option, value]].concat(), directory.path());
        assert_eq!(code(&output), 0, "{option} {value}: {}", stderr(&output));
    }
}

#[test]
fn the_language_and_the_command_line_allow_the_same_exposure() {
    let directory = tempfile::tempdir().expect("a directory");
    let check = |exposure: &str| {
        let text = format!(
            "pathmarch 1\ncamera {{ position 0 0 4; target 0 0 0; exposure {exposure} }}\nobject \"a\" {{ sphere }}\n"
        );
        std::fs::write(directory.path().join("a.kdl"), text).expect("written");
        pathmarch(&["check", "a.kdl"], directory.path())
    };
    for wrong in ["100.1", "-100.1", "1e9", "#inf", "#nan"] {
        let output = check(wrong);
        assert_eq!(code(&output), 2, "{wrong}: {}", stderr(&output));
        let output = pathmarch(&["render", "a.kdl", "--exposure", wrong.trim_start_matches('#')], directory.path());
        assert_eq!(code(&output), 2, "{wrong}: {}", stderr(&output));
        assert!(stderr(&output).contains("from -100 to 100"), "{}", stderr(&output));
    }
    assert!(stderr(&check("1e9")).contains("from -100 to 100"));
    for right in ["100", "-100", "0.5"] {
        assert_eq!(code(&check(right)), 0, "{right}");
    }
}

#[test]
fn more_threads_than_cores_are_not_started() {
    let directory = tempfile::tempdir().expect("a directory");
    let scene = scene("diffuse-sphere.kdl");
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let all = format!("({cores} threads)");
    for (asked, threads, is_noted) in [
        ("100000", all.as_str(), true),
        ("99999999999999999999999", &all, true),
        ("1", "(1 threads)", false),
        ("0", &all, false),
        ("many", &all, false),
    ] {
        let name = format!("{asked}.png");
        let output = std::process::Command::new(env!("CARGO_BIN_EXE_pathmarch"))
            .args(["render", &scene, "--backend", "cpu", "--size", "64x36", "--samples", "2", "-o", &name])
            .current_dir(directory.path())
            .env("RAYON_NUM_THREADS", asked)
            .output()
            .expect("the program starts");
        let message = stderr(&output);
        assert_eq!(code(&output), 0, "{message}");
        assert!(message.contains(&format!("on CPU {threads}")), "{asked}: {message}");
        assert_eq!(
            message.contains(&format!("note: RAYON_NUM_THREADS asks for {asked} threads")),
            is_noted,
            "{message}"
        );
        assert!(directory.path().join(&name).metadata().expect("written").len() > 100);
    }
}

#[test]
fn shaders_become_scenes_whose_steps_are_safe_but_for_a_fractal() {
    let directory = tempfile::tempdir().expect("a directory");
    let folder: PathBuf = [env!("CARGO_MANIFEST_DIR"), "../pathmarch-field/tests/glsl"].iter().collect();
    let (mut shaders, mut rough) = (0, 0);
    for entry in folder.read_dir().expect("shaders").map(|entry| entry.expect("a file").path()) {
        if entry.extension().is_none_or(|extension| extension != "frag") {
            continue;
        }
        let output = pathmarch(&["import", &entry.to_string_lossy(), "-o", "shader.kdl"], directory.path());
        assert_eq!(code(&output), 0, "{}: {}", entry.display(), stderr(&output));
        let is_rough = stderr(&output).contains("usual for fractals");
        let text = std::fs::read_to_string(directory.path().join("shader.kdl")).expect("written");
        assert!(text.contains(std::fs::read_to_string(&entry).expect("a shader").trim_end()), "the code is as it was");
        let output = pathmarch(&["check", "shader.kdl", "--field"], directory.path());
        let report = String::from_utf8_lossy(&output.stdout);
        assert!(is_rough || report.contains("-field: safe"), "{}: {report}", entry.display());
        shaders += 1;
        rough += u32::from(is_rough);
    }
    assert!(shaders >= 10 && rough <= 1, "{rough} of {shaders}");
}

#[test]
fn a_preset_is_the_camera_and_bounds_are_measured() {
    let directory = tempfile::tempdir().expect("a directory");
    let ball = "uniform float R; slider[0.1,0.7,2]\nfloat DE(vec3 p) { return length(p) - R; }\n#preset Default\nFOV = 0.5\n\
                Eye = 1,2,3\nTarget = 0,0.1,0\n#endpreset\n";
    std::fs::write(directory.path().join("Small Ball.frag"), ball).expect("written");
    let output = pathmarch(&["import", "Small Ball.frag", "-o", "ball.kdl"], directory.path());
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let text = std::fs::read_to_string(directory.path().join("ball.kdl")).expect("written");
    for part in
        ["position 1 2 3; target 0 0.1 0; fov 53.1", "lipschitz 1\n", "bounds 1.58\n", "object \"small-ball-field\""]
    {
        assert!(text.contains(part), "{part}: {text}");
    }
}

/// Other programs write comments in Latin-1, and names with several hyphens.
#[test]
fn shaders_of_any_name_and_encoding_are_imported() {
    let directory = tempfile::tempdir().expect("a directory");
    let text = b"// Knighty's poly\xe8dre\rfloat DE(vec3 p) { return length(p) - 1.0; }\r\n";
    let name = "Mandelbox - Dual Numbers DE - with a very long name 2.frag";
    std::fs::write(directory.path().join(name), text).expect("written");
    let output = pathmarch(&["import", name, "-o", "a.kdl"], directory.path());
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert!(stderr(&output).contains("Latin-1"), "{}", stderr(&output));
    let text = std::fs::read_to_string(directory.path().join("a.kdl")).expect("written");
    assert!(text.contains("poly\u{e8}dre\nfloat DE"), "{text}");
    assert!(text.contains("field \"mandelbox-dual-numbers-de-with-field\""), "{text}");
}

#[test]
fn what_a_shader_cannot_be_imported_for_is_reported_at_its_line() {
    let directory = tempfile::tempdir().expect("a directory");
    for (text, parts) in [
        (
            "float map(vec3 p) {\n  return length(p) - texture(iChannel0, p.xy).x;\n}\n",
            &["bad.frag:2:", "iChannel0"][..],
        ),
        ("float map(vec3 p) {\n  return length(q) - 1.0;\n}\n", &["bad.frag:2:", "q"]),
        ("void mainImage(out vec4 c, in vec2 f) { c = vec4(1.0); }\n", &["bad.frag", "distance"]),
    ] {
        std::fs::write(directory.path().join("bad.frag"), text).expect("written");
        let output = pathmarch(&["import", "bad.frag", "-o", "bad.kdl"], directory.path());
        let message = stderr(&output);
        assert_eq!(code(&output), 2, "{message}");
        assert!(parts.iter().all(|part| message.contains(part)), "{parts:?}: {message}");
        assert!(!directory.path().join("bad.kdl").exists());
    }
    let output = pathmarch(&["import", "mesh.obj", "--entry", "map", "-o", "bad.kdl"], directory.path());
    assert_eq!(code(&output), 2, "{}", stderr(&output));
}

const COMMANDS: [&str; 16] = [
    "view",
    "render",
    "merge",
    "video",
    "export",
    "import",
    "check",
    "fmt",
    "lsp",
    "compare",
    "devices",
    "shapes",
    "reference",
    "help",
    "completions",
    "man",
];

#[test]
fn completions_and_man_pages_know_every_command() {
    let directory = tempfile::tempdir().expect("a directory");
    let stdout = |arguments: &[&str]| {
        let output = pathmarch(arguments, directory.path());
        assert_eq!(code(&output), 0, "{arguments:?}: {}", stderr(&output));
        String::from_utf8_lossy(&output.stdout).into_owned()
    };
    // `COMMANDS` matches the program.
    let help = stdout(&["--help"]);
    let listed: Vec<_> = help.split("Commands:").nth(1).expect("commands").lines().skip(1).collect();
    let listed =
        listed.into_iter().take_while(|line| !line.is_empty()).filter_map(|line| line.split_whitespace().next());
    assert_eq!(listed.collect::<Vec<_>>(), COMMANDS);
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let script = stdout(&["completions", shell]);
        for command in COMMANDS {
            assert!(script.contains(command), "{command} for {shell}");
        }
        assert!(script.contains("max-relmse"), "options of commands for {shell}");
    }
    let pages = stdout(&["man"]);
    for command in COMMANDS {
        assert!(pages.contains(&format!(".TH pathmarch-{command} ")), "{command} has a page: {pages}");
    }
    assert_eq!(pages.matches(".TH ").count(), 1 + COMMANDS.len());
    assert!(pages.contains(r"\-\-max\-relmse"), "options of commands");
    let output = pathmarch(&["completions", "cmd"], directory.path());
    assert_eq!(code(&output), 2);
    assert!(stderr(&output).contains("bash"), "{}", stderr(&output));
}

/// A program built without a window says so.
#[cfg(not(feature = "window"))]
#[test]
fn without_a_window_view_says_what_to_do() {
    let directory = tempfile::tempdir().expect("a directory");
    for arguments in [&[][..], &["view"], &["view", "scene.kdl", "--timings", "--drawing", "cpu"]] {
        let output = pathmarch(arguments, directory.path());
        assert_eq!(code(&output), 2, "{arguments:?}");
        let message = stderr(&output);
        assert!(
            message.contains("without a window") && message.contains("--no-default-features"),
            "{arguments:?}: {message}"
        );
        assert_eq!(message.contains("Commands:"), arguments.is_empty(), "{arguments:?}: {message}");
    }
}
