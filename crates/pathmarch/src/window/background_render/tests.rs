//! Tests of background renders.

use super::*;
use crate::window::tests::timeout;
use pathmarch_render::image;
use std::process::Command;
use std::sync::mpsc::channel;
use std::time::Duration;

fn scene_path() -> PathBuf {
    [env!("CARGO_MANIFEST_DIR"), "../../scenes/thesis/diffuse-sphere.kdl"].iter().collect()
}

fn task(output: PathBuf) -> RenderRequest {
    let scene = Scene::load(scene_path()).expect("a scene");
    let settings = Settings { size: [48, 27], samples: 3, seed: 5, ..Settings::of(&scene) };
    let display = Display { tonemap: scene.render.tonemap, exposure_stops: settings.camera_of(&scene).exposure };
    let layers = Vec::new();
    RenderRequest {
        scene: Arc::new(scene),
        settings,
        display,
        layers,
        output,
        backend: Backend::Cpu,
        adapter: None,
        frames: None,
        confined: true,
    }
}

/// Compares picture, layers and provenance of two files. Attributes of an OpenEXR file come in any order, so only the
/// length of the headers is compared; the rest must be equal byte for byte.
fn same(one: &Path, two: &Path) -> bool {
    let bytes = [one, two].map(|path| std::fs::read(path).expect("written"));
    let loaded = [one, two].map(|path| image::load(path).expect("a picture"));
    let header = if loaded[0].provenance.is_some() { 1500 } else { 0 };
    assert!(bytes[0].len() > 2 * header, "there is more than a header");
    bytes[0].len() == bytes[1].len() && bytes[0][header..] == bytes[1][header..] && loaded[0] == loaded[1]
}

/// Waits for the end.
fn end(export: &BackgroundRender, woken: &std::sync::mpsc::Receiver<()>) -> Result<String, String> {
    loop {
        if let Some(outcome) = export.finished() {
            return outcome;
        }
        woken.recv_timeout(timeout()).expect("it says when it is finished");
    }
}

fn run(task: RenderRequest) -> Result<String, String> {
    let (sender, woken) = channel();
    let export = BackgroundRender::start(task, move || sender.send(()).unwrap_or_default());
    end(&export, &woken)
}

/// The `pathmarch` program, beside the directory of the tests; it exists only once it has been built.
fn program() -> Option<PathBuf> {
    let tests = std::env::current_exe().ok()?;
    let program = tests.parent()?.parent()?.join(format!("pathmarch{}", std::env::consts::EXE_SUFFIX));
    program.is_file().then_some(program)
}

#[test]
fn the_file_equals_that_of_the_command_line() {
    let directory = tempfile::tempdir().expect("a directory");
    let Some(program) = program() else {
        eprintln!("not compared: the program is not built; `cargo test` builds it for the tests of the command line");
        return;
    };
    for (name, layers) in [("a.png", &[][..]), ("a.exr", &[]), ("b.exr", &[Layer::Depth, Layer::Normal])] {
        let mut task = task(directory.path().join(name));
        task.layers = layers.to_vec();
        let sentence = run(task).expect("written");
        assert!(sentence.contains(name) && sentence.contains("3 samples in"), "{sentence}");
        let reference = directory.path().join(format!("reference-{name}"));
        let mut command = Command::new(&program);
        command.arg("render").arg(scene_path()).arg("-o").arg(&reference);
        command.args(["--backend", "cpu", "--size", "48x27", "--samples", "3", "--seed", "5"]);
        if !layers.is_empty() {
            command.args(["--aov", "depth,normal"]);
        }
        assert!(command.status().expect("it starts").success());
        assert!(
            same(&directory.path().join(name), &reference),
            "{name} differs from that of {}; if that is old, build it again",
            program.display()
        );
    }
}

#[test]
fn an_existing_film_gives_the_same_file() {
    let directory = tempfile::tempdir().expect("a directory");
    for name in ["a.png", "a.exr"] {
        let task = task(directory.path().join(name));
        let renderer = Renderer::open(Backend::Cpu, None).expect("the CPU");
        let film = renderer.render(&task.scene, &task.settings).expect("a film");
        let rendered = Rendered {
            scene: &task.scene,
            settings: &task.settings,
            film: &film,
            backend: &renderer.backend(),
            denoised: None,
        };
        let second = directory.path().join(format!("film-{name}"));
        save_film(&rendered, &second, &task.display, &[]).expect("written");
        let first = task.output.clone();
        run(task).expect("written");
        assert!(same(&first, &second), "{name}");
    }
}

#[test]
fn a_cancelled_render_writes_nothing() {
    let directory = tempfile::tempdir().expect("a directory");
    let mut task = task(directory.path().join("a.png"));
    task.settings.samples = 1_000_000;
    let (sender, woken) = channel();
    let export = BackgroundRender::start(task.clone(), move || sender.send(()).unwrap_or_default());
    woken.recv_timeout(timeout()).expect("progress");
    let progress = export.progress();
    assert!(progress.samples > 0.0 && progress.of == 1_000_000.0 && progress.remaining.is_some(), "{progress:?}");
    export.cancel();
    let sentence = end(&export, &woken).expect("that is no failure");
    assert!(sentence.contains("Cancelled"), "{sentence}");
    // Dropping a render cancels it.
    let alive = Arc::new(());
    let weak = Arc::downgrade(&alive);
    drop(BackgroundRender::start(task, move || {
        let _ = &alive;
    }));
    let began = Instant::now();
    while weak.upgrade().is_some() {
        assert!(began.elapsed() < timeout(), "it goes on");
        std::thread::sleep(Duration::from_millis(5));
    }
    assert_eq!(directory.path().read_dir().expect("there").count(), 0);
}

#[test]
fn a_stopped_render_writes_its_samples() {
    let directory = tempfile::tempdir().expect("a directory");
    let mut task = task(directory.path().join("a.exr"));
    task.settings.samples = 1_000_000;
    let (sender, woken) = channel();
    let export = BackgroundRender::start(task, move || sender.send(()).unwrap_or_default());
    export.stop_and_keep();
    let sentence = end(&export, &woken).expect("written");
    assert!(sentence.contains("of 1000000 samples"), "{sentence}");
    let loaded = image::load(export.output()).expect("a picture");
    assert!(loaded.provenance.expect("where it comes from").samples >= 1);
}

#[test]
fn an_unwritable_output_is_reported_at_once() {
    let directory = tempfile::tempdir().expect("a directory");
    for (name, layers, words) in [
        ("no/a.png", &[][..], "no does not exist"),
        ("a.gif", &[], ".png"),
        ("a.png", &Layer::ALL, ".exr"),
        ("", &[], "extension of an image"),
    ] {
        let mut task = task(directory.path().join(name));
        task.settings.samples = 1_000_000;
        task.layers = layers.to_vec();
        let message = run(task).expect_err("it cannot be written");
        assert!(message.contains(words), "{name}: {message}");
    }
    let mut task = task(directory.path().join("a.png"));
    task.settings.samples = 0;
    assert!(run(task).expect_err("there is nothing to render").contains("samples"));
    assert_eq!(directory.path().read_dir().expect("there").count(), 0);
}

/// An animated scene, and the frames to render.
fn sequence(directory: &Path, radius: &str, first: u32, last: u32) -> RenderRequest {
    let text = format!(
        "pathmarch 1\ncamera {{ position 0 0 4; target 0 0 0 }}\nrender {{ size 24 16; samples 2; bounces 1; shutter 0.5 }}\n\
         sky 1\nobject \"ball\" {{ sphere \"{radius}\" {{ at \"t\" 0 0 }} }}"
    );
    let scene = Scene::parse("scene.kdl", &text).expect("a scene");
    let frames = Some(FrameSequence { frames: FrameRange::from_to(first, last), skip_existing: true });
    RenderRequest {
        settings: Settings::of(&scene),
        scene: Arc::new(scene),
        output: directory.join("a-##.exr"),
        frames,
        ..task(PathBuf::new())
    }
}

#[test]
fn frames_equal_those_of_the_command_line_and_existing_ones_stay() {
    let directory = tempfile::tempdir().expect("a directory");
    let mine = sequence(directory.path(), "0.1", 3, 3);
    run(mine).expect("written");
    let kept = std::fs::read(directory.path().join("a-03.exr")).expect("there");
    // A torn frame is rendered again.
    std::fs::write(directory.path().join("a-04.exr"), "torn").expect("written");
    let task = sequence(directory.path(), "0.5", 2, 4);
    let scene = directory.path().join("scene.kdl");
    std::fs::write(&scene, &task.scene.source_text).expect("written");
    let sentence = run(task).expect("written");
    assert!(sentence.starts_with("Wrote 2 frames") && sentence.ends_with("1 existed already"), "{sentence}");
    let file = |name: &str| directory.path().join(name);
    assert_eq!(std::fs::read(file("a-03.exr")).expect("there"), kept);
    let Some(program) = program() else { return };
    let mut command = Command::new(&program);
    command.arg("render").arg(&scene).arg("-o").arg(file("b-##.exr")).args(["--frames", "2-4x2", "--backend", "cpu"]);
    assert!(command.status().expect("it starts").success());
    for frame in ["02", "04"] {
        let [one, two] = ["a", "b"].map(|name| image::load(&file(&format!("{name}-{frame}.exr"))).expect("a picture"));
        assert!(one.picture == two.picture, "frame {frame}");
    }
    let [one, two] = ["02", "04"].map(|frame| image::load(&file(&format!("a-{frame}.exr"))).expect("a picture"));
    assert!(one.picture != two.picture, "it moves");
}

#[test]
fn a_frame_with_an_error_is_reported_and_earlier_ones_are_kept() {
    let directory = tempfile::tempdir().expect("a directory");
    let error = run(sequence(directory.path(), "0.5 - frame/4", 0, 9)).expect_err("a radius of zero");
    assert!(error.starts_with("frame 2: ") && error.ends_with("frames written before it are kept"), "{error}");
    assert!(directory.path().join("a-01.exr").exists() && !directory.path().join("a-02.exr").exists());
}
