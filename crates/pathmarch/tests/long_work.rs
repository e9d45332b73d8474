//! Tests of long work: checkpoints, parts, and outputs that cannot be written.

mod program;

use pathmarch_render::image::load;
use program::{code, pathmarch, stderr};
use std::path::Path;
use std::process::{Command, Output, Stdio};

/// A room with diffuse light, glass and a sky, so that samples differ in every pixel.
const ROOM: &str = "pathmarch 1
camera { position 0 1 4; target 0 1 0 }
render { size 40 30; samples 64; bounces 3 }
sky 0.8
material \"white\" { diffuse 0.7 }
material \"lamp\" { emit 12 }
material \"glass\" { glass }
object \"floor\" material=\"white\" { plane }
object \"lamp\" material=\"lamp\" { sphere 0.3 { at 1 2 0 } }
object \"ball\" material=\"glass\" { sphere 0.7 { at -0.5 0.7 0 } }
";

/// The same with a ball that moves while the shutter is open.
fn moving() -> String {
    ROOM.replace("at -0.5 0.7 0", "at \"t - 0.5\" 0.7 0").replace("bounces 3", "bounces 3; shutter 0.5; fps 2")
}

struct Place(tempfile::TempDir);

impl Place {
    fn new(scene: &str) -> Self {
        let directory = tempfile::tempdir().expect("a directory");
        std::fs::write(directory.path().join("room.kdl"), scene).expect("written");
        Self(directory)
    }
    fn path(&self) -> &Path {
        self.0.path()
    }
    fn run(&self, arguments: &[&str]) -> Output {
        pathmarch(arguments, self.path())
    }
    fn done(&self, arguments: &[&str]) -> String {
        let output = self.run(arguments);
        assert_eq!(code(&output), 0, "{arguments:?}: {}", stderr(&output));
        stderr(&output)
    }
    fn pixels(&self, name: &str) -> Vec<[u32; 3]> {
        let picture = load(&self.path().join(name)).expect("a picture").picture;
        picture.pixels.into_iter().map(|pixel| pixel.map(f32::to_bits)).collect()
    }
    fn files(&self) -> Vec<String> {
        let files = self.path().read_dir().expect("a directory").flatten();
        let mut names: Vec<_> = files.map(|file| file.file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }
}

/// Backends of this machine, with their arguments.
fn backends() -> Vec<[&'static str; 2]> {
    let place = Place::new(ROOM);
    let mut backends = vec![["--backend", "cpu"]];
    let gpu = place.run(&["render", "room.kdl", "--backend", "gpu", "--samples", "1", "--size", "8x8", "-o", "a.png"]);
    if code(&gpu) == 0 {
        backends.push(["--backend", "gpu"]);
    } else {
        assert!(std::env::var_os("PATHMARCH_REQUIRE_GPU").is_none(), "a GPU is required: {}", stderr(&gpu));
    }
    backends
}

#[test]
fn seven_uneven_parts_merge_to_the_whole() {
    let cuts = [0, 5, 17, 18, 31, 48, 61, 64];
    for scene in [ROOM.to_owned(), moving()] {
        for backend in backends() {
            for splitting in ["1", "3", "4"] {
                let place = Place::new(&scene);
                let render = |more: &[&str]| {
                    place.done(&[&["render", "room.kdl", "--splitting", splitting], &backend[..], more].concat())
                };
                render(&["-o", "whole.exr"]);
                let names: Vec<String> = (0..7).map(|part| format!("{part}.film")).collect();
                for (pair, name) in cuts.windows(2).zip(&names) {
                    render(&["--samples", &format!("{}..{}", pair[0], pair[1]), "-o", name]);
                }
                let [a, b, c, d, e, f, g] = [0, 1, 2, 3, 4, 5, 6].map(|part: usize| names[part].as_str());
                // In any order, and in groups.
                place.done(&["merge", e, b, g, a, d, f, c, "-o", "merged.exr"]);
                place.done(&["merge", f, b, "-o", "x.film"]);
                place.done(&["merge", a, d, "-o", "y.film"]);
                place.done(&["merge", "x.film", g, c, "-o", "z.film"]);
                place.done(&["merge", "z.film", e, "y.film", "-o", "grouped.exr"]);
                let whole = place.pixels("whole.exr");
                assert!(whole == place.pixels("merged.exr"), "{backend:?} {splitting}");
                assert!(whole == place.pixels("grouped.exr"), "{backend:?} {splitting}");
            }
        }
    }
}

#[test]
fn tiles_merge_to_the_whole() {
    for backend in backends() {
        let place = Place::new(ROOM);
        let render = |more: &[&str]| place.done(&[&["render", "room.kdl"], &backend[..], more].concat());
        render(&["-o", "whole.exr", "--samples", "24"]);
        let tiles = ["17x11+0+0", "23x11+17+0", "40x9+0+11", "9x10+0+20", "31x10+9+20"];
        let mut films: Vec<String> = Vec::new();
        for (number, tile) in tiles.iter().enumerate() {
            // One of the tiles in two ranges of samples.
            let ranges: &[&str] = if number == 2 { &["0..7/24", "7..24/24"] } else { &["0..24/24"] };
            for range in ranges {
                films.push(format!("{}.film", films.len()));
                render(&["--samples", range, "--crop", tile, "-o", &films[films.len() - 1]]);
            }
        }
        films.reverse();
        let films: Vec<&str> = films.iter().map(String::as_str).collect();
        place.done(&[&["merge", "-o", "merged.exr"], &films[..]].concat());
        assert!(place.pixels("whole.exr") == place.pixels("merged.exr"), "{backend:?}");
        // A picture of the crop alone.
        render(&["--crop", tiles[4], "--samples", "24", "-o", "crop.exr"]);
        let whole = place.pixels("whole.exr");
        let expected: Vec<[u32; 3]> = (20..30).flat_map(|y| whole[y * 40 + 9..y * 40 + 40].to_vec()).collect();
        assert!(place.pixels("crop.exr") == expected);
    }
}

#[test]
fn gaps_and_overlaps_are_named() {
    let place = Place::new(ROOM);
    let render = |samples: &str, name: &str, more: &[&str]| {
        let fixed = ["render", "room.kdl", "--backend", "cpu", "--samples", samples, "-o", name];
        place.done(&[&fixed[..], more].concat());
    };
    render("0..20", "a.film", &[]);
    render("18..64", "b.film", &[]);
    render("20..50", "c.film", &[]);
    render("50..64", "seed.film", &["--seed", "7"]);
    render("50..64", "tile.film", &["--crop", "10x30+0+0"]);
    let refused = |films: &[&str], expected: &[&str]| {
        let output = place.run(&[&["merge", "-o", "m.exr"], films].concat());
        let message = stderr(&output);
        assert!(code(&output) == 2 && expected.iter().all(|words| message.contains(words)), "{message}");
    };
    refused(&["a.film", "b.film"], &["a.film and b.film overlap", "the samples 18..20", "40x30+0+0"]);
    refused(&["a.film", "c.film"], &["the samples 50..64 of the pixels 40x30+0+0 are missing"]);
    refused(&["a.film", "c.film", "tile.film"], &["the samples 50..64 of the pixels 30x30+10+0 are missing"]);
    refused(
        &["a.film", "c.film", "seed.film"],
        &["a.film and seed.film are not parts of one picture", "seed is 0 there and 7 here"],
    );
    assert!(!place.files().iter().any(|name| name.starts_with("m.")), "{:?}", place.files());
    // Damage is found wherever it is.
    let bytes = std::fs::read(place.path().join("a.film")).expect("a film");
    for at in (0..bytes.len()).step_by(bytes.len() / 60) {
        for torn in [bytes[..at].to_vec(), [&bytes[..at], &[bytes[at] ^ 1], &bytes[at + 1..]].concat()] {
            std::fs::write(place.path().join("torn.film"), torn).expect("written");
            let output = place.run(&["merge", "torn.film", "c.film", "-o", "m.film"]);
            assert!(code(&output) == 1 && stderr(&output).contains("torn.film"), "{at}: {}", stderr(&output));
        }
    }
}

#[test]
fn an_interrupted_render_goes_on_to_the_same_picture() {
    let ways: [&[&str]; 3] = [&[], &["--denoise"], &["--noise", "0.1", "--samples", "128", "--denoise"]];
    for (scene, more) in ways.into_iter().flat_map(|way| [(ROOM.to_owned(), way), (moving(), way)]) {
        for backend in backends() {
            let place = Place::new(&scene);
            let fixed = [&["render", "room.kdl"], &backend[..], more].concat();
            place.done(&[&fixed[..], &["-o", "whole.exr"]].concat());
            let limited = [&fixed[..], &["-o", "a.exr", "--seconds", "0.000001"]].concat();
            let message = place.done(&limited);
            assert!(message.contains("continue with --resume"), "{message}");
            // Each run adds a sample or more.
            let mut runs = 1;
            while place.path().join("a.exr.checkpoint").exists() {
                if runs == 12 {
                    place.done(&[&fixed[..], &["-o", "a.exr", "--resume"]].concat());
                } else {
                    place.done(&[&limited[..], &["--resume"]].concat());
                }
                runs += 1;
            }
            assert!(runs > 3, "{runs}");
            assert!(place.pixels("whole.exr") == place.pixels("a.exr"), "{backend:?}, {more:?}, {runs} runs");
            assert_eq!(place.files(), ["a.exr", "room.kdl", "whole.exr"]);
        }
    }
}

#[test]
fn checkpoints_of_other_pictures_are_refused_and_damaged_ones_reported() {
    let place = Place::new(ROOM);
    let fixed = ["render", "room.kdl", "--backend", "cpu", "-o", "a.exr"];
    let run = |more: &[&str]| place.run(&[&fixed[..], more].concat());
    let short = ["--seconds", "0.000001"];
    assert_eq!(code(&run(&short)), 0);
    for (arguments, expected) in [
        (&["--bounces", "2"][..], "bounces is 3 there and 2 here"),
        (&["--seed", "5"], "seed is 0 there and 5 here"),
        (&["--size", "41x30"], "size is 40x30 there and 41x30 here"),
        (&["--crop", "10x10+0+0"], "the crop differs"),
        (&["--denoise"], "--denoise is missing there and given here"),
        (&["--first-sample", "1"], "which are not the first of 1..65"),
    ] {
        let output = run(&[&["--resume"], arguments].concat());
        assert!(code(&output) == 2 && stderr(&output).contains(expected), "{}", stderr(&output));
    }
    std::fs::write(place.path().join("room.kdl"), ROOM.replace("0.7 }", "0.71 }")).expect("written");
    let output = run(&["--resume"]);
    assert!(code(&output) == 2 && stderr(&output).contains("scene is "), "{}", stderr(&output));
    std::fs::write(place.path().join("room.kdl"), ROOM).expect("written");
    // A second one; the first is kept as the previous.
    assert_eq!(code(&run(&[&["--resume"], &short[..]].concat())), 0);
    assert!(place.path().join("a.exr.checkpoint.previous").exists());
    let last = std::fs::read(place.path().join("a.exr.checkpoint")).expect("a checkpoint");
    std::fs::write(place.path().join("a.exr.checkpoint"), &last[..last.len() / 2]).expect("written");
    let output = run(&["--resume"]);
    assert!(code(&output) == 0 && stderr(&output).contains("is damaged"), "{}", stderr(&output));
    place.done(&["render", "room.kdl", "--backend", "cpu", "-o", "whole.exr"]);
    assert!(place.pixels("whole.exr") == place.pixels("a.exr"));
}

#[test]
fn progress_is_lines_of_json() {
    let place = Place::new(ROOM);
    let output = place.run(&[
        "render",
        "room.kdl",
        "--backend",
        "cpu",
        "--size",
        "400x300",
        "--samples",
        "100000",
        "--seconds",
        "3",
        "--json",
        "-o",
        "a.png",
    ]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let text = String::from_utf8(output.stdout).expect("text");
    let lines: Vec<serde_json::Value> = text.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect();
    let events: Vec<&str> = lines.iter().filter_map(|line| line["event"].as_str()).collect();
    assert_eq!(events.first(), Some(&"preparing"));
    assert_eq!(events.get(1), Some(&"start"));
    assert_eq!(events.last(), Some(&"done"));
    let progress: Vec<_> = lines.iter().filter(|line| line["event"] == "progress").collect();
    assert!(!progress.is_empty(), "{text}");
    for line in progress {
        assert!(line["samples"].as_f64() > Some(0.0) && line["seconds_left"].as_f64() < Some(4.0), "{line}");
    }
}

#[cfg(unix)]
#[test]
fn outputs_follow_links_and_refuse_what_is_no_file() {
    use std::os::unix::fs::{PermissionsExt, symlink};
    let place = Place::new(ROOM);
    let file = |name: &str| place.path().join(name);
    let fixed = ["render", "room.kdl", "--backend", "cpu", "--samples", "1", "--size", "8x8"];
    let render = |output: &str| place.run(&[&fixed[..], &["-o", output]].concat());
    std::fs::write(file("real.png"), "old").expect("written");
    std::fs::set_permissions(file("real.png"), std::fs::Permissions::from_mode(0o600)).expect("a mode");
    symlink("real.png", file("link.png")).expect("a link");
    assert_eq!(code(&render("link.png")), 0);
    assert!(std::fs::symlink_metadata(file("link.png")).expect("there").is_symlink());
    assert_eq!(std::fs::metadata(file("real.png")).expect("there").permissions().mode() & 0o777, 0o600);
    assert!(load(&file("real.png")).is_ok());
    assert!(Command::new("mkfifo").arg(file("pipe.png")).status().expect("mkfifo runs").success());
    let output = render("pipe.png");
    assert!(code(&output) == 1 && stderr(&output).contains("not a file"), "{}", stderr(&output));
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_device_behind_the_output_is_no_panic() {
    let place = Place::new(ROOM);
    let full = || Stdio::from(std::fs::OpenOptions::new().write(true).open("/dev/full").expect("it is there"));
    let run = |arguments: &[&str], out: Stdio, error: Stdio| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_pathmarch"));
        command.args(arguments).current_dir(place.path()).stdout(out).stderr(error);
        command.output().expect("it starts")
    };
    for arguments in
        [&["devices"][..], &["shapes"], &["shapes", "sphere"], &["check", "room.kdl"], &["--help"], &["man"]]
    {
        let output = run(arguments, full(), Stdio::piped());
        let message = stderr(&output);
        assert!(!message.contains("panicked"), "{arguments:?}: {message}");
        assert_ne!(code(&output), 101);
        assert_ne!(code(&run(arguments, full(), full())), 101);
    }
    let render = ["render", "room.kdl", "--backend", "cpu", "--samples", "1", "--size", "8x8", "-o", "a.png"];
    assert_eq!(code(&run(&render, Stdio::null(), full())), 0);
    assert!(load(&place.path().join("a.png")).is_ok());
    assert_eq!(code(&run(&["render", "missing.kdl"], Stdio::null(), full())), 2);
    let output = run(&[&render[..9], &["-"]].concat(), full(), Stdio::piped());
    assert!(code(&output) == 1 && !stderr(&output).contains("panicked"), "{}", stderr(&output));
}

#[test]
fn pictures_record_what_they_are_of() {
    let place = Place::new(ROOM);
    place.done(&["render", "room.kdl", "--backend", "cpu", "--samples", "3", "--denoise", "-o", "a.png"]);
    let bytes = std::fs::read(place.path().join("a.png")).expect("written");
    let has = |words: &str| bytes.windows(words.len()).any(|window| window == words.as_bytes());
    assert!(
        has("pathmarch:samples\u{0}3") && has("pathmarch:denoiser\u{0}regression") && has("Software\u{0}pathmarch ")
    );
    assert!(load(&place.path().join("a.png")).is_ok(), "its sums of check are right");
}

#[test]
fn scenes_come_from_files_the_gallery_and_standard_input() {
    use std::io::Write;
    let place = Place::new(ROOM);
    std::fs::write(place.path().join("other.kdl"), ROOM).expect("written");
    std::fs::create_dir(place.path().join("out")).expect("created");
    let small = ["--backend", "cpu", "--samples", "1", "--size", "8x8"];
    place.done(&[&["render", "room.kdl", "other.kdl", "mandelbulb", "environment", "-o", "out"], &small[..]].concat());
    for name in ["room", "other", "mandelbulb", "environment"] {
        assert!(load(&place.path().join(format!("out/{name}.png"))).is_ok(), "{name}");
    }
    let output = place.run(&[&["render", "room.kdl", "room.kdl"], &small[..]].concat());
    assert_eq!(code(&output), 2);
    let mut command = Command::new(env!("CARGO_BIN_EXE_pathmarch"));
    command.args(["render", "-", "-o", "-"]).args(small).current_dir(place.path());
    let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().expect("it starts");
    child.stdin.take().expect("a pipe").write_all(ROOM.as_bytes()).expect("written");
    let output = child.wait_with_output().expect("it ends");
    place.done(&[&["render", "room.kdl", "-o", "a.png"], &small[..]].concat());
    std::fs::write(place.path().join("b.png"), output.stdout).expect("written");
    assert!(place.pixels("a.png") == place.pixels("b.png"));
}

#[test]
fn videos_are_made_of_frames() {
    let place = Place::new(&moving());
    let fixed = ["render", "room.kdl", "--backend", "cpu", "--samples", "1", "--size", "33x21", "--frames", "1-4"];
    for name in ["a.gif", "a.apng"] {
        place.done(&[&fixed[..], &["-o", name]].concat());
    }
    place.done(&[&fixed[..], &["-o", "f-#.png"]].concat());
    place.done(&["video", "f-1.png", "f-2.png", "f-3.png", "f-4.png", "--fps", "2", "-o", "b.apng"]);
    let bytes = |name: &str| std::fs::read(place.path().join(name)).expect("written");
    assert!(bytes("a.apng") == bytes("b.apng"), "both ways write the same");
    let gif = gif::DecodeOptions::new().read_info(std::io::Cursor::new(bytes("a.gif"))).expect("a GIF");
    let frames: Vec<_> = gif.into_iter().map(|frame| frame.expect("a frame")).collect();
    assert!(frames.len() == 4 && frames.iter().all(|frame| (frame.width, frame.height, frame.delay) == (33, 21, 50)));
    let png = png::Decoder::new(std::io::Cursor::new(bytes("a.apng"))).read_info().expect("a PNG");
    assert_eq!(png.info().animation_control.map(|control| control.num_frames), Some(4));
    assert!(!place.files().iter().any(|name| name.contains("frames") || name.contains("part")), "{:?}", place.files());
    // Without ffmpeg there is a reason, before any work.
    let mut command = Command::new(env!("CARGO_BIN_EXE_pathmarch"));
    command.args(fixed).args(["-o", "a.mp4"]).current_dir(place.path()).env("PATHMARCH_FFMPEG", "/missing/ffmpeg");
    let output = command.output().expect("it starts");
    assert!(code(&output) == 1 && stderr(&output).contains("ffmpeg was not found"), "{}", stderr(&output));
    let output = place.run(&["render", "room.kdl", "-o", "a.mp4"]);
    assert!(code(&output) == 2 && stderr(&output).contains("a video needs --frames"), "{}", stderr(&output));
    if Command::new("ffmpeg").arg("-version").output().is_ok() {
        for name in ["a.mp4", "a.webm"] {
            place.done(&[&fixed[..], &["-o", name]].concat());
            assert!(bytes(name).len() > 500, "{name}");
        }
    }
}

#[test]
fn scenes_read_no_file_outside_their_folder_unless_asked() {
    let place = Place::new(ROOM);
    let folder = place.path().join("strange");
    std::fs::create_dir(&folder).expect("created");
    std::fs::write(place.path().join("parts.kdl"), "pathmarch 1\nobject \"secret\" { sphere }\n").expect("written");
    std::fs::copy(concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/images/gyroid.jpg"), place.path().join("a.jpg"))
        .expect("copied");
    let texture = "material \"p\" { diffuse { picture \"../a.jpg\" } }";
    for (node, name) in [("include \"../parts.kdl\"", "include"), (texture, "texture")] {
        std::fs::write(folder.join("scene.kdl"), format!("{ROOM}{node}\n")).expect("written");
        for command in ["check", "render", "export"] {
            let more: &[&str] = match command {
                "check" => &[],
                "render" => &["--backend", "cpu", "--samples", "1", "--size", "8x8", "-o", "a.png"],
                _ => &["-o", "a.stl", "--resolution", "16", "--object", "ball"],
            };
            let run = |allow: &[&str]| place.run(&[&[command, "strange/scene.kdl"], more, allow].concat());
            let output = run(&[]);
            let message = stderr(&output);
            assert!(
                code(&output) == 2 && message.contains("outside the folder of the scene"),
                "{name} {command}: {message}"
            );
            let output = run(&["--allow-files"]);
            assert_eq!(code(&output), 0, "{name} {command}: {}", stderr(&output));
        }
    }
    // A scene may read its own folder, whatever it is called.
    std::fs::write(folder.join("scene.kdl"), format!("{ROOM}include \"../strange/own.kdl\"\n")).expect("written");
    std::fs::write(folder.join("own.kdl"), "pathmarch 1\nobject \"own\" { sphere }\n").expect("written");
    place.done(&["check", "strange/scene.kdl"]);
}
