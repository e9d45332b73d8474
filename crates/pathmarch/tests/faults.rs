//! Tests of what goes wrong around the program: full disks, folders that are read-only or gone, signals, closed pipes, no home, wrong
//! clocks, and scenes of strangers with hostile WGSL.
#![cfg(target_os = "linux")]

mod program;

use pathmarch_render::image::load;
use program::{code, pathmarch, stderr};
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, SystemTime};

const ROOM: &str = "pathmarch 1
camera { position 0 1 4; target 0 1 0 }
render { size 64 48; samples 32; bounces 3 }
sky 0.8
material \"white\" { diffuse 0.7 }
object \"floor\" material=\"white\" { plane }
object \"ball\" { sphere 0.7 { at \"0.1 * t\" 0.7 0 } }
";
const RENDER: [&str; 4] = ["render", "room.kdl", "--backend", "cpu"];

fn place() -> tempfile::TempDir {
    let directory = tempfile::tempdir().expect("a directory");
    std::fs::write(directory.path().join("room.kdl"), ROOM).expect("written");
    directory
}

fn render(more: &[&str], directory: &Path) -> Output {
    pathmarch(&[&RENDER[..], more].concat(), directory)
}

#[track_caller]
fn done(output: &Output) {
    assert_eq!(code(output), 0, "{}", stderr(output));
}

/// Runs the program where no file may be larger than some blocks of 512 or 1,024 bytes.
fn on_full_disk(blocks: u32, arguments: &[&str], directory: &Path) -> Output {
    let mut command = Command::new("sh");
    command.args(["-c", &format!("ulimit -f {blocks}; exec \"$0\" \"$@\""), env!("CARGO_BIN_EXE_pathmarch")]);
    command.args(arguments).current_dir(directory).env("PATHMARCH_HOME", directory.join("home"));
    command.output().expect("it starts")
}

fn files(directory: &Path) -> Vec<String> {
    let names = directory.read_dir().expect("a directory").flatten();
    let mut names: Vec<_> = names.map(|file| file.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// A render that goes on until it is stopped, with checkpoints all the time; returns after the first checkpoint.
fn long_render(output: &str, directory: &Path) -> Child {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pathmarch"));
    command.args(RENDER).args(["--samples", "100000", "-o", output]).current_dir(directory);
    command.env("PATHMARCH_CHECKPOINT_SECONDS", "0.05").env("TMPDIR", directory);
    let child = command.stderr(Stdio::piped()).stdout(Stdio::null()).spawn().expect("it starts");
    let checkpoint = directory.join(format!("{output}.checkpoint"));
    while !checkpoint.exists() {
        std::thread::sleep(Duration::from_millis(20));
    }
    child
}

/// Ends it by a signal; returns what it printed, and its exit code.
fn ended(mut child: Child, signal: &str) -> (String, Option<i32>) {
    let killed = Command::new("kill").args([signal, &child.id().to_string()]).status().expect("kill is there");
    assert!(killed.success());
    let lines = BufReader::new(child.stderr.take().expect("piped")).lines();
    let text: Vec<String> = lines.map(|line| line.expect("text")).collect();
    (text.join("\n"), child.wait().expect("it ends").code())
}

#[test]
fn a_full_disk_is_reported_and_old_files_stay() {
    let directory = place();
    let at = directory.path();
    done(&render(&["-o", "whole.exr"], at));
    for name in ["1.film", "2.film"] {
        let samples = if name == "1.film" { "0..16" } else { "16..32" };
        done(&render(&["--samples", samples, "-o", name], at));
    }
    std::fs::write(at.join("solid.kdl"), ROOM.replace("object \"floor\" material=\"white\" { plane }\n", ""))
        .expect("written");
    let cases: [(&str, Vec<&str>); 4] = [
        ("a.exr", [&RENDER[..], &["-o", "a.exr"]].concat()),
        ("a.film", vec!["merge", "1.film", "2.film", "-o", "a.film"]),
        ("a.stl", vec!["export", "solid.kdl", "-o", "a.stl", "--resolution", "64"]),
        ("a.apng", vec!["video", "whole.exr", "whole.exr", "whole.exr", "-o", "a.apng"]),
    ];
    for (name, arguments) in cases {
        for old in [false, true] {
            let _ = std::fs::remove_file(at.join(name));
            if old {
                std::fs::write(at.join(name), "old").expect("written");
            }
            let output = on_full_disk(4, &arguments, at);
            let message = stderr(&output);
            assert!(code(&output) == 1 && message.contains(name) && !message.contains("panicked"), "{name}: {message}");
            assert_eq!(std::fs::read(at.join(name)).ok(), old.then(|| b"old".to_vec()), "{name}");
        }
        let output = pathmarch(&arguments, at);
        done(&output);
        let left: Vec<String> = files(at).into_iter().filter(|file| file.contains(".part")).collect();
        assert!(left.is_empty(), "{left:?}");
    }
    assert_eq!(
        load(&at.join("a.exr")).expect("whole").picture.pixels,
        load(&at.join("whole.exr")).expect("whole").picture.pixels
    );
    // Frames: those that could be written are kept, and a second run completes them.
    let frames = ["--frames", "1-4", "--parallel", "2", "--samples", "2", "-o", "f-#.exr"];
    assert_eq!(code(&on_full_disk(4, &[&RENDER[..], &frames].concat(), at)), 1);
    done(&render(&[&frames[..], &["--skip-existing"]].concat(), at));
    assert!((1..=4).all(|frame| load(&at.join(format!("f-{frame}.exr"))).is_ok()));
}

#[test]
fn frames_in_parallel_are_those_one_after_the_other() {
    let directory = place();
    let at = directory.path();
    let frames = |more: &[&str]| render(&[&["--frames", "1-6", "--samples", "5"], more].concat(), at);
    done(&frames(&["-o", "one-#.exr"]));
    done(&frames(&["-o", "many-#.exr", "--parallel", "4"]));
    let pixels = |name: String| load(&at.join(name)).expect("a picture").picture.pixels;
    for frame in 1..=6 {
        assert!(pixels(format!("one-{frame}.exr")) == pixels(format!("many-{frame}.exr")), "{frame}");
    }
    // Torn and missing frames are rendered, and whole ones are not.
    let torn = std::fs::read(at.join("many-3.exr")).expect("read");
    std::fs::write(at.join("many-3.exr"), &torn[..torn.len() / 2]).expect("written");
    std::fs::remove_file(at.join("many-5.exr")).expect("removed");
    let output = frames(&["-o", "many-#.exr", "--parallel", "3", "--skip-existing"]);
    done(&output);
    let message = stderr(&output);
    assert!(message.contains("many-3.exr is damaged") && message.contains("wrote 2 frames"), "{message}");
    assert!((1..=6).all(|frame| pixels(format!("one-{frame}.exr")) == pixels(format!("many-{frame}.exr"))));
    assert_eq!(code(&frames(&["-o", "x-#.exr", "--parallel", "0"])), 2);
}

#[test]
fn folders_that_cannot_be_written_are_refused_before_the_work() {
    let directory = place();
    let at = directory.path();
    done(&render(&["--samples", "0..16/16", "-o", "1.film"], at));
    // Even root cannot write there.
    for (folder, arguments) in [
        ("/proc", [&RENDER[..], &["--samples", "100000", "-o", "/proc/a.exr"]].concat()),
        ("/proc", vec!["merge", "1.film", "-o", "/proc/a.film"]),
        ("missing", [&RENDER[..], &["--samples", "100000", "-o", "missing/a.exr"]].concat()),
    ] {
        let output = pathmarch(&arguments, at);
        let message = stderr(&output);
        assert!(code(&output) != 0 && message.contains(folder), "{arguments:?}: {message}");
    }
}

#[test]
fn samples_are_kept_if_the_folder_is_gone() {
    let directory = place();
    let at = directory.path();
    std::fs::create_dir(at.join("network")).expect("created");
    let child = long_render("network/a.exr", at);
    std::fs::rename(at.join("network"), at.join("gone")).expect("moved");
    let (message, code) = ended(child, "-TERM");
    assert!(code == Some(1) && message.contains("network/a.exr"), "{code:?}: {message}");
    let kept = files(at).into_iter().find(|file| file.starts_with("pathmarch-")).unwrap_or_else(|| panic!("{message}"));
    assert!(message.contains(&kept) && message.contains("--resume"), "{message}");
    // As the message says.
    std::fs::create_dir(at.join("network")).expect("created");
    std::fs::rename(at.join(kept), at.join("network/a.exr.checkpoint")).expect("moved");
    done(&render(&["--samples", "100000", "-o", "network/a.exr", "--resume", "--seconds", "0.001"], at));
    assert!(load(&at.join("network/a.exr")).is_ok());
}

#[test]
fn a_terminated_render_goes_on() {
    let directory = place();
    let at = directory.path();
    let (message, code) = ended(long_render("a.exr", at), "-TERM");
    assert!(code == Some(130) && message.contains("continue with --resume"), "{code:?}: {message}");
    // A clock that was wrong when the files were written changes nothing.
    let later = SystemTime::now() + Duration::from_secs(100_000_000);
    for name in ["a.exr.checkpoint", "a.exr", "room.kdl"] {
        std::fs::File::options()
            .write(true)
            .open(at.join(name))
            .and_then(|file| file.set_modified(later))
            .expect("set");
    }
    let output = render(&["--samples", "100000", "-o", "a.exr", "--resume", "--seconds", "0.001"], at);
    done(&output);
    assert!(!stderr(&output).contains("there is no checkpoint"), "{}", stderr(&output));
}

#[test]
fn closed_pipes_end_a_render_without_a_panic() {
    let directory = place();
    for more in [&["--json", "-o", "a.png"][..], &["-o", "-"]] {
        let mut command = Command::new(env!("CARGO_BIN_EXE_pathmarch"));
        command.args(RENDER).args(more).current_dir(directory.path()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().expect("it starts");
        drop(child.stdout.take());
        drop(child.stderr.take());
        assert_ne!(child.wait().expect("it ends").code(), Some(101));
    }
    let output = render(&["-o", "a.png"], directory.path());
    done(&output);
}

#[test]
fn no_home_is_needed() {
    let directory = place();
    for home in [None, Some("/proc/nowhere")] {
        for arguments in [[&RENDER[..], &["-o", "a.png"]].concat(), vec!["check", "room.kdl"]] {
            let mut command = Command::new(env!("CARGO_BIN_EXE_pathmarch"));
            command.args(&arguments).current_dir(directory.path()).env_clear().envs(home.map(|home| ("HOME", home)));
            done(&command.output().expect("it starts"));
        }
    }
}

/// Codes that try to hang the program, to read outside, or to use its memory up; true if they are accepted.
fn hostile() -> Vec<(&'static str, String, bool)> {
    let body = |code: &str| format!("fn distance(p: vec3f) -> f32 {{ {code} }}");
    let nested = |open: &str, inner: &str, close: &str, count: usize| open.repeat(count) + inner + &close.repeat(count);
    let each = |count: usize, line: &dyn Fn(usize) -> String| (0..count).map(line).collect::<String>();
    let loops = "fn f(p: vec3f) -> f32 { var n = 0.0; loop { n += sin(p.x + n); if n > 1e30 { break; } } return n; }\n";
    vec![
        ("endless loop", body("loop { }"), false),
        ("while true", body("var n = 0.0; while true { n += p.x; } return n;"), true),
        (
            "loops in loops",
            body(&format!(
                "var n = 0.0; {} return n;",
                nested("for (var i = 0; i < 2000000000; i++) {", "n += 1.0;", "}", 8)
            )),
            true,
        ),
        ("loops in calls", format!("{loops}{}", body(&format!("return {};", ["f(p)"; 100].join("+")))), false),
        (
            "index",
            body("var a: array<f32, 4>; a[i32(p.x * 1e9)] = 1.0; return a[i32(p.y * -1e9)] + a[u32(p.z * 1e9)];"),
            true,
        ),
        (
            "index of vectors",
            body(
                "var v = p; v[i32(p.x * 1e9)] = 7.0; var m = mat3x3f(p, p, p); m[i32(p.y * 1e9)][2] = 3.0; return v[u32(p.y * 1e9)] + m[i32(p.x * -1e9)][2];",
            ),
            true,
        ),
        (
            "index of a constant",
            format!("const T = array<f32, 3>(1.0, 2.0, 3.0);\n{}", body("return T[i32(p.x * 1e9)];")),
            true,
        ),
        (
            "index behind a pointer",
            format!(
                "fn f(a: ptr<function, array<f32, 8>>, k: i32) -> f32 {{ (*a)[k] = 2.0; return (*a)[k + 1000000]; }}\n{}",
                body("var a: array<f32, 8>; return f(&a, i32(p.x * 1e9));")
            ),
            true,
        ),
        ("constant index", body("var a: array<f32, 4>; return a[4];"), false),
        ("negative index", body("var a: array<f32, 4>; return a[-1];"), false),
        ("recursion", format!("fn f(x: f32) -> f32 {{ return f(x + 1.0); }}\n{}", body("return f(p.x);")), false),
        (
            "mutual recursion",
            format!(
                "fn f(x: f32) -> f32 {{ return g(x); }}\nfn g(x: f32) -> f32 {{ return f(x); }}\n{}",
                body("return f(p.x);")
            ),
            false,
        ),
        ("huge array", body("var a: array<f32, 1000000000>; return a[u32(p.x)];"), false),
        (
            "huge arrays of arrays",
            body("var a: array<array<array<f32, 65535>, 65535>, 65535>; return a[0][0][0];"),
            false,
        ),
        ("huge constant", format!("const A = array<array<f32, 65536>, 65536>();\n{}", body("return A[0][0];")), false),
        (
            "structures of structures",
            format!(
                "struct S0 {{ a: vec4f }}\n{}{}",
                each(60, &|k| format!("struct S{} {{ a: S{k}, b: S{k} }}\n", k + 1)),
                body("var s: S60; return p.x;")
            ),
            false,
        ),
        ("brackets", body(&format!("return {};", nested("(", "p.x", ")", 4000))), false),
        ("calls in calls", body(&format!("return {};", nested("sin(", "p.x", ")", 4000))), false),
        ("signs", body(&format!("return {}p.x;", "- ".repeat(4000))), true),
        ("sum", body(&format!("return p.x{};", "+1.0".repeat(10_000))), false),
        ("blocks", body(&format!("{} return p.x;", nested("{", "", "}", 4000))), false),
        ("branches", body(&format!("{} return p.x;", nested("if p.x > 0.0 {", "", "}", 3000))), false),
        ("types", body(&format!("var a: {}; return p.x;", nested("array<", "f32", ",2>", 2000))), false),
        (
            "calls without end",
            format!(
                "fn f0(x: f32) -> f32 {{ return sin(x); }}\n{}{}",
                each(63, &|k| format!("fn f{}(x: f32) -> f32 {{ return f{k}(f{k}(x)); }}\n", k + 1)),
                body("return f63(p.x);")
            ),
            false,
        ),
        (
            "cases",
            body(&format!(
                "switch i32(p.x) {{ {} default: {{ return 0.0; }} }}",
                each(1800, &|k| format!("case {k}: {{ return 1.0; }} "))
            )),
            false,
        ),
        (
            "division",
            body(
                "let a = i32(p.x); return f32((-2147483647 - 1 - a) / (a - 1)) + f32(7 % a) + f32(1u << u32(p.x * 100.0));",
            ),
            true,
        ),
        ("constant division", body("return f32(1 / 0);"), false),
        ("not a number", body("return sqrt(-1.0 - p.x * p.x) + p.x / (p.y - p.y);"), true),
        ("comments", body(&format!("return p.x; {}", "/*".repeat(20_000))), false),
        (
            "storage",
            format!(
                "@group(0) @binding(0) var<storage, read_write> data: array<u32>;\n{}",
                body("return f32(data[u32(p.x * 1e9)]);")
            ),
            false,
        ),
        (
            "entry point",
            format!("@compute @workgroup_size(1) fn main() {{ loop {{}} }}\n{}", body("return p.x;")),
            false,
        ),
        (
            "names of the kernel",
            format!("fn field(p: vec3f) -> f32 {{ return 1.0; }}\nfn main() {{}}\n{}", body("return field(p);")),
            true,
        ),
    ]
}

#[test]
fn hostile_wgsl_neither_hangs_nor_crashes() {
    let directory = place();
    let at = directory.path();
    let required = std::env::var_os("PATHMARCH_REQUIRE_GPU").is_some();
    for (name, wgsl, accepted) in hostile() {
        let field = format!(
            "field \"evil\" {{\n bounds 2 2 2\n wgsl #\"\"\"\n{wgsl}\n\"\"\"#\n}}\nobject \"evil\" {{ evil }}\n"
        );
        std::fs::write(at.join("evil.kdl"), format!("{ROOM}{field}")).expect("written");
        let run = |more: &[&str]| {
            pathmarch(&[&["render", "evil.kdl", "--size", "8x8", "--samples", "1", "-o", "a.exr"], more].concat(), at)
        };
        let output = run(&["--backend", "cpu"]);
        let message = stderr(&output);
        if !accepted {
            assert!(code(&output) == 2 && message.contains("evil.kdl:"), "{name}: {message}");
            assert!(message.lines().all(|line| line.len() < 1000), "{name}: a long line");
            continue;
        }
        done(&output);
        let pixels = |name: &str| load(&at.join(name)).expect("a picture").picture.pixels;
        assert!(pixels("a.exr").iter().flatten().all(|v| v.is_finite()), "{name}");
        let output = run(&["--backend", "gpu"]);
        if code(&output) != 0 {
            assert!(!required && stderr(&output).contains("adapter"), "{name}: {}", stderr(&output));
            continue;
        }
        assert!(pixels("a.exr").iter().flatten().all(|v| v.is_finite()), "{name}");
    }
}
