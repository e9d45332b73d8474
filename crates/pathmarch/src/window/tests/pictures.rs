//! Pictures of the documentation: windows at work.
//!
//! `PATHMARCH_PICTURES=docs/images cargo test --release -p pathmarch --bin pathmarch -- --ignored picture_of` makes them
//! again; without the variable, a directory of the workspace, none is kept. Those of a small window are only to be looked
//! at.

use super::*;
use image::codecs::jpeg::JpegEncoder;

/// Largest size of a picture, bytes.
const LARGEST: usize = 150_000;
/// Quality of the JPEG files.
const QUALITY: u8 = 82;

/// A scene of the gallery.
fn example(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../../scenes/{name}.kdl"))
}

fn at_example(name: &str) -> Person {
    let start = Start { scene: Some(example(name)), ..Start::new() };
    let mut person = start.drawn(true).size(1000.0, 620.0).go();
    person.wait(4);
    person
}

impl Person {
    /// Writes the window to a file, with few samples: the picture is not what it shows. One sample is enough for a window that
    /// is not kept.
    #[track_caller]
    fn shown_in(&mut self, name: &str) {
        self.app_mut().toasts.clear();
        let directory = std::env::var_os("PATHMARCH_PICTURES");
        let enough = if directory.is_some() { 24 } else { 1 };
        let sharp = |person: &Self| {
            let [shown, all] = person.app().material_balls.counts();
            let samples = person.app().live.picture().map_or(0.0, |picture| picture.samples);
            let size = person.open().view.picture.as_ref().map(|(_, _, size)| *size);
            shown == all
                && samples >= f64::from(person.scene().render.samples.min(enough))
                && size == Some(person.open().view.picture_size(person.scene()))
        };
        self.until("the picture has samples", sharp);
        self.wait(2);
        let rendered = image::DynamicImage::ImageRgba8(self.harness.render().expect("drawn")).to_rgb8();
        let mut bytes = Vec::new();
        JpegEncoder::new_with_quality(&mut bytes, QUALITY).encode_image(&rendered).expect("encoded");
        if let Some(directory) = directory {
            assert!(bytes.len() <= LARGEST, "{name}: {} bytes", bytes.len());
            let workspace = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
            std::fs::write(workspace.join(directory).join(name), bytes).expect("written");
        }
    }
}

#[test]
#[ignore = "makes pictures of the documentation, and draws with a GPU adapter"]
fn picture_of_a_profile() {
    let mut person = at_example("candle-light");
    person.select("curve");
    person.key(Key::F);
    person.shown_in("window-profile.jpg");
}

#[test]
#[ignore = "makes pictures of the documentation, and draws with a GPU adapter"]
fn picture_of_a_sun() {
    let mut person = at_example("day");
    person.select("sky");
    person.shown_in("window-sun.jpg");
}

#[test]
#[ignore = "makes pictures of the documentation, and draws with a GPU adapter"]
fn picture_of_a_ramp_and_of_the_palette() {
    let mut person = at_example("textures");
    person.select("voronoi");
    person.shown_in("window-ramp.jpg");
    person.key(Key::F7);
    person.shown_in("window-palette.jpg");
}

#[test]
#[ignore = "makes pictures of the documentation, and draws with a GPU adapter"]
fn picture_of_a_spot_light() {
    let spot = "spot { at -1.2 2.2 1.2; target -0.2 0.3 0.4; intensity 30; cone 40 }\nsun {";
    let mut person = Start::with(&super::looks::STILL.replace("sun {", spot)).drawn(true).size(1000.0, 620.0).go();
    person.select("spot");
    person.shown_in("window-spot.jpg");
}

#[test]
#[ignore = "writes files to PATHMARCH_PICTURES, and draws with a GPU adapter"]
fn picture_of_a_small_window() {
    if std::env::var_os("PATHMARCH_PICTURES").is_none() {
        return;
    }
    let text = format!("{}sky \"day\"\n", super::looks::STILL.replace("sky 0.22 0.3 0.45\n", ""));
    let mut person = Start::with(&text).drawn(true).size(420.0, 320.0).go();
    person.select("sky");
    person.shown_in("small-sun.jpg");
    person.key(Key::F7);
    person.wait(4);
    person.shown_in("small-palette.jpg");
    person.key(Key::F2);
    person.wait(4);
    person.shown_in("small-no-tree.jpg");
    person.click("Properties");
    person.shown_in("small-properties.jpg");
    person.key(Key::F1);
    person.shown_in("small-help.jpg");
}
