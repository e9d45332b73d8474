//! End-to-end tests of `bench` and `study` at tiny sizes. Measurements vary from run to run; the tests check their
//! form.

use pathmarch_render::image::{self, Provenance};
use pathmarch_render::pathmarch_scene::{Scene, Tonemap};
use pathmarch_render::tonemap::Display;
use pathmarch_render::{Backend, Renderer, Settings};
use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};

/// Runs the program in a directory that also contains its caches.
fn measure(arguments: &[&str], directory: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_pathmarch-measure"))
        .args(arguments)
        .current_dir(directory)
        .env("PATHMARCH_HOME", directory.join("home"))
        .output()
        .expect("the program starts")
}

fn code(output: &Output) -> i32 {
    output.status.code().expect("it ended by itself")
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn stdout(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

const SMALL: [&str; 8] = ["bench", "--backend", "cpu", "--size", "32x18", "--rounds", "3", "--bounces=2"];

fn parsed(path: &Path) -> Value {
    serde_json::from_str(&std::fs::read_to_string(path).expect("written")).expect("JSON")
}

#[test]
fn figures_are_printed_and_kept() {
    let directory = tempfile::tempdir().expect("a directory");
    let bench = |more: &[&str]| measure(&[&SMALL[..], more].concat(), directory.path());
    let output = bench(&["diffuse-sphere", "union-100", "--json", "a.json"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let table = stdout(&output);
    let rows: Vec<_> = table.lines().filter(|line| line.contains("CPU (")).collect();
    assert_eq!(rows.len(), 2, "{table}");
    assert!(rows[0].starts_with("diffuse-sphere ") && rows[1].starts_with("union-100 "), "{table}");
    assert!(!table.contains("relMSE"), "errors are measured when asked for");
    assert!(stderr(&output).contains("[2/2] union-100"), "{}", stderr(&output));

    let figures = parsed(&directory.path().join("a.json"));
    assert_eq!(figures["size"], serde_json::json!([32, 18]));
    assert_eq!((&figures["bounces"], &figures["rounds"], &figures["samples"]), (&2.into(), &3.into(), &1.into()));
    let entries = figures["entries"].as_array().expect("a list");
    assert_eq!(entries.len(), 2);
    for entry in entries {
        let number = |value: &Value| value.as_f64().expect("a number");
        let spread = &entry["ms_per_sample"];
        let [least, median, most] = ["min", "median", "max"].map(|name| number(&spread[name]));
        assert!(0.0 < least && least <= median && median <= most);
        assert!(number(&entry["rays_per_pixel"]) >= 1.0);
        assert_eq!(entry["rounds"], 3);
        assert!(entry["gpu_ms_per_sample"].is_null() && entry["quality"].is_null());
        if cfg!(target_os = "linux") {
            assert!(number(&entry["peak_mib"]) > 1.0);
        }
    }
    // Spheres and planes are not sphere-traced; the union is.
    assert_eq!(entries[0]["evaluations_per_pixel"], 0.0);
    assert!(entries[1]["steps_per_marched_ray"].as_f64().expect("a number") > 1.0);

    // Compare the results with themselves.
    let output = bench(&["--from", "a.json", "--compare", "a.json"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert!(stdout(&output).contains("1.000  geometric mean"), "{}", stdout(&output));
}

#[test]
fn errors_are_measured_against_references_that_are_kept() {
    let directory = tempfile::tempdir().expect("a directory");
    let bench = |more: &[&str]| {
        let arguments = ["cornell-box", "--error", "0.01", "--error-size", "16x9", "--json", "e.json"];
        measure(&[&SMALL[..], &arguments[..], more].concat(), directory.path())
    };
    let quality = || parsed(&directory.path().join("e.json"))["entries"][0]["quality"].clone();
    let output = bench(&[]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert!(stdout(&output).contains("s x relMSE"), "{}", stdout(&output));
    let first = quality();
    assert!(first["samples"].as_u64().expect("a number") >= 1);
    assert_eq!(first["bounces"], 8, "the scene's own");
    assert!(first["reference_relmse"].as_f64().expect("known") > 0.0);
    // Both halves are cached and used again.
    let kept = directory.path().join("home/references");
    assert_eq!(kept.read_dir().expect("made").count(), 2);
    assert_eq!(code(&bench(&[])), 0);
    assert_eq!(quality()["reference_samples"], first["reference_samples"]);

    // A reference file of the user, with unknown noise.
    std::fs::create_dir(directory.path().join("own")).expect("made");
    let text = include_str!("../../../scenes/benchmarks/cornell-box.kdl");
    let scene = Scene::parse("cornell.kdl", text).expect("a scene");
    let render_own = |size| {
        let settings = Settings { size, samples: 3, ..Settings::of(&scene) };
        let renderer = Renderer::open(Backend::Cpu, None).expect("the CPU is there");
        let film = renderer.render(&scene, &settings).expect("renders");
        let provenance = Provenance { samples: film.samples, ..Provenance::default() };
        let display = Display { tonemap: Tonemap::Srgb, exposure_stops: 0.0 };
        let file = directory.path().join("own/cornell-box.exr");
        image::save(&file, &film.mean(), &display, &provenance).expect("written");
    };
    render_own([16, 9]);
    let output = bench(&["--references", "own"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert_eq!((&quality()["reference_samples"], &quality()["reference_relmse"]), (&3.into(), &Value::Null));
    // A reference of another size is rejected, and the scene skipped.
    render_own([8, 8]);
    let output = bench(&["--references", "own"]);
    assert_eq!(code(&output), 1);
    assert!(stderr(&output).contains("8x8") && stderr(&output).contains("skipped"), "{}", stderr(&output));
}

#[test]
fn wrong_arguments_of_bench_are_reported() {
    let directory = tempfile::tempdir().expect("a directory");
    std::fs::create_dir(directory.path().join("empty")).expect("made");
    std::fs::write(directory.path().join("not.json"), "{}").expect("written");
    std::fs::write(directory.path().join("bad.kdl"), "pathmarch 1\nspere").expect("written");
    for (arguments, code_expected, message) in [
        (&["cornel-box"][..], 2, "did you mean cornell-box?"),
        (&["nothing/like.kdl"], 2, "no such file, directory"),
        (&["empty"], 2, "contains no scenes (.kdl)"),
        (&["bad.kdl"], 2, "spere"),
        (&["--json", "missing/a.json"], 1, "no directory missing"),
        (&["--error", "0"], 2, "above 0"),
        (&["--references", "empty"], 2, "--error"),
        (&["--error", "1", "--references", "not.json"], 1, "not.json: "),
        (&["--compare", "missing.json"], 2, "missing.json"),
        (&["--from", "not.json"], 2, "not a file of `bench --json`"),
        (&["--from", "not.json", "cornell-box"], 2, "cannot be used with"),
    ] {
        let output = measure(&[&SMALL[..], arguments].concat(), directory.path());
        assert_eq!(code(&output), code_expected, "{arguments:?}: {}", stderr(&output));
        assert!(stderr(&output).contains(message), "{arguments:?}: {}", stderr(&output));
    }
}

/// Scenes that take too long are skipped; the others are measured.
#[test]
fn what_takes_too_long_is_left_out() {
    let directory = tempfile::tempdir().expect("a directory");
    std::fs::create_dir(directory.path().join("two")).expect("made");
    for (name, count) in [("a", 1), ("b", 1)] {
        let text = format!(
            "pathmarch 1\ncamera {{ position 0 0 4; target 0 0 0 }}\nsky 1\nobject \"ball\" {{ sphere {count} }}\n"
        );
        std::fs::write(directory.path().join("two").join(format!("{name}.kdl")), text).expect("written");
    }
    let output = measure(&[&SMALL[..], &["two", "--limit", "1e-9"]].concat(), directory.path());
    assert_eq!(code(&output), 1, "nothing was measured: {}", stderr(&output));
    assert!(stderr(&output).contains("above --limit"), "{}", stderr(&output));
    let output = measure(&[&SMALL[..], &["two"]].concat(), directory.path());
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert_eq!(stdout(&output).lines().filter(|line| line.contains("CPU (")).count(), 2);
}

const QUICK: [&str; 7] = ["--quick", "--backend", "cpu", "--size", "16x9", "--error-size", "16x9"];

#[test]
fn a_study_is_a_page_of_tables_plots_and_pictures() {
    let directory = tempfile::tempdir().expect("a directory");
    let page = directory.path().join("page");
    std::fs::create_dir(&page).expect("made");
    std::fs::write(page.join("notes.txt"), "mine").expect("written");
    let output = measure(&[&["study", "-o", "page"], &QUICK[..]].concat(), directory.path());
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert_eq!(std::fs::read_to_string(page.join("notes.txt")).expect("it stays"), "mine");

    let text = std::fs::read_to_string(page.join("README.md")).expect("written");
    let parts =
        ["machine", "tables", "realtime", "bounces", "accumulation", "features", "marching", "raster", "figures"];
    for part in parts.into_iter().chain(["comparison"]) {
        let alone = std::fs::read_to_string(page.join(format!("{part}.md"))).expect("written");
        assert!(text.contains(&alone), "{part} is on the page");
    }
    for part in &parts[..parts.len() - 1] {
        let mut table = csv::Reader::from_path(page.join(format!("{part}.csv"))).expect("written");
        let heads = table.headers().expect("heads").len();
        let rows: Vec<_> = table.records().map(|row| row.expect("as long as its head")).collect();
        assert!(heads >= 3 && rows.len() >= 2, "{part}: {heads} by {}", rows.len());
    }
    for plot in ["tables", "bounces", "accumulation"] {
        let svg = std::fs::read_to_string(page.join(format!("{plot}.svg"))).expect("written");
        assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"));
        let png = ::image::open(page.join(format!("{plot}.png"))).expect("a picture").into_rgb8();
        assert!(png.pixels().any(|pixel| pixel.0 == [0, 114, 178]), "{plot}: something is drawn in the first colour");
    }
    assert!(text.contains("on CPU (") && text.contains("pathmarch-measure study -o page --quick"), "{text}");
    // All files of the page exist, and all rows of a table have as many cells as its header.
    let shown: Vec<_> = text.split("](").skip(1).filter_map(|rest| rest.split(')').next()).collect();
    let is_picture = |target: &&str| target.ends_with(".jpg") || target.ends_with(".png");
    let files: Vec<_> = shown.into_iter().filter(is_picture).collect();
    assert!(files.len() > 10, "{files:?}");
    for file in files {
        ::image::open(page.join(file)).unwrap_or_else(|error| panic!("{file}: {error}"));
    }
    let mut cells = None;
    for line in text.lines() {
        let count = line.starts_with('|').then(|| line.matches('|').count());
        assert!(cells.is_none() || count.is_none() || cells == count, "{line}");
        cells = count;
    }

    // A part replaces only its own files; the others stay on the page.
    let output = measure(&[&["study", "features", "-o", "page"], &QUICK[..]].concat(), directory.path());
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let again = std::fs::read_to_string(page.join("README.md")).expect("written");
    assert_eq!(text, again);
}

#[test]
fn wrong_arguments_of_study_are_reported() {
    let directory = tempfile::tempdir().expect("a directory");
    std::fs::write(directory.path().join("file"), "mine").expect("written");
    for (arguments, code_expected, message) in [
        (&["study"][..], 2, "--output"),
        (&["study", "speed", "-o", "page"], 2, "accumulation"),
        (&["study", "-o", "missing/page"], 1, "missing/page"),
        (&["study", "-o", "file"], 1, "name an output directory"),
        (&["study", "-o", "page", "--samples", "1"], 2, "1"),
    ] {
        let output = measure(arguments, directory.path());
        assert_eq!(code(&output), code_expected, "{arguments:?}: {}", stderr(&output));
        assert!(stderr(&output).contains(message), "{arguments:?}: {}", stderr(&output));
    }
    assert_eq!(std::fs::read_to_string(directory.path().join("file")).expect("text"), "mine");
}

/// Options that take numbers, each with a command and the expected error.
const NUMBERS: &[(&[&str], &str, &str)] = &[
    (&["bench", "a.kdl"], "--size", "expected WIDTHxHEIGHT in pixels, such as 1280x720"),
    (&["bench", "a.kdl"], "--error-size", "expected WIDTHxHEIGHT in pixels, such as 1280x720"),
    (&["bench", "a.kdl"], "--bounces", "must be a whole number from 0 to 1000"),
    (&["bench", "a.kdl"], "--rounds", "must be a whole number from 1 to 1000"),
    (&["bench", "a.kdl"], "--samples", "must be a whole number from 1 to 1000"),
    (&["bench", "a.kdl"], "--limit", "must be a number of seconds above 0, at most 86400"),
    (&["bench", "a.kdl"], "--error", "must be a number of seconds above 0, at most 86400"),
    (&["study", "-o", "out"], "--size", "expected WIDTHxHEIGHT in pixels, such as 1280x720"),
    (&["study", "-o", "out"], "--error-size", "expected WIDTHxHEIGHT in pixels, such as 1280x720"),
    (&["study", "-o", "out"], "--rounds", "must be a whole number from 1 to 1000"),
    (&["study", "-o", "out"], "--samples", "must be a whole number from 2 to 65536"),
    (&["study", "-o", "out"], "--picture-seconds", "must be a number of seconds above 0, at most 86400"),
    (&["study", "-o", "out"], "--reference-seconds", "must be a number of seconds above 0, at most 86400"),
];

#[test]
fn numbers_that_an_option_cannot_be_are_refused_with_what_it_can_be() {
    let directory = tempfile::tempdir().expect("a directory");
    for (command, option, words) in NUMBERS {
        for value in ["nan", "-inf", "inf", "-1e9", "1e99", "one", ""] {
            let output = measure(&[*command, &[*option, value]].concat(), directory.path());
            let message = stderr(&output);
            assert_eq!(code(&output), 2, "{option} {value}: {message}");
            assert!(message.contains(words), "{option} {value}: {message}");
        }
    }
}

#[test]
fn denoised_pictures_are_measured() {
    let directory = tempfile::tempdir().expect("a directory");
    std::fs::create_dir(directory.path().join("references")).expect("created");
    std::fs::create_dir(directory.path().join("pictures")).expect("created");
    let size = ["--size", "32x18", "--samples", "4", "--backend", "cpu"];
    let files = ["--references", "references", "--reference-seconds", "0.2", "-o", "pictures"];
    let output = measure(&[&["denoise", "cornell"], &size[..], &files[..]].concat(), directory.path());
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let table = stdout(&output);
    assert!(table.lines().any(|line| line.starts_with("cornell ") && line.contains(" -> ")), "{table}");
    for part in ["before", "after", "reference"] {
        assert!(directory.path().join(format!("pictures/cornell-{part}.png")).is_file());
    }
}
