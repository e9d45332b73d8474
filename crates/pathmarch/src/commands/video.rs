//! `pathmarch video`: makes a video of pictures.
//!
//! GIF and APNG are written here; everything else by ffmpeg, if it is installed.

use crate::video::{self, Encoder};
use pathmarch_cli::{DONE, Failure, catch_interrupts, check_output, note, value_parsers};
use pathmarch_render::pathmarch_scene::settings;
use std::path::PathBuf;
use std::sync::atomic::Ordering;

#[derive(clap::Args)]
pub struct Arguments {
    /// Pictures in their order: .png, .jpg or .exr, all of one size
    #[arg(required = true)]
    pictures: Vec<PathBuf>,
    /// Video to write: .mp4, .webm, .mov or .mkv through ffmpeg; .gif or .apng
    #[arg(short, long, value_name = "FILE", required = true)]
    output: PathBuf,
    /// Frames per second
    #[arg(long, value_name = "N", default_value_t = 24.0, value_parser = value_parsers::number(settings::FPS), allow_hyphen_values = true)]
    fps: f32,
    /// Exposure of .exr pictures in stops, -100 to 100
    #[arg(long, value_name = "EV", default_value_t = 0.0, value_parser = value_parsers::number(settings::EXPOSURE), allow_hyphen_values = true)]
    exposure: f32,
}

pub fn run(arguments: &Arguments) -> Result<u8, Failure> {
    check_output(&arguments.output)?;
    video::Format::of(&arguments.output)?;
    let interrupted = catch_interrupts()?;
    let mut encoder: Option<Encoder> = None;
    for path in &arguments.pictures {
        if interrupted.load(Ordering::SeqCst) {
            return Err(Failure::Interrupted);
        }
        let frame = video::Frame::load(path, arguments.exposure)?;
        let encoder = match &mut encoder {
            Some(encoder) => encoder,
            none => {
                none.insert(Encoder::start(&arguments.output, frame.size, arguments.fps, arguments.pictures.len())?)
            }
        };
        encoder.add(&frame)?;
    }
    if let Some(encoder) = encoder {
        encoder.finish()?;
    }
    note!("wrote {} of {} pictures", arguments.output.display(), arguments.pictures.len());
    Ok(DONE)
}
