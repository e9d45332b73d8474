//! Videos of pictures.
//!
//! Frames are encoded as they come, so that memory does not grow with their number. The video is written under a temporary name
//! and renamed when it is complete.

use pathmarch_cli::Failure;
use pathmarch_render::image::{self, PictureKind};
use pathmarch_render::tonemap::Display;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use tempfile::NamedTempFile;

/// Kinds of videos.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// GIF: 256 colours a frame.
    Gif,
    /// APNG: without loss.
    Apng,
    /// What ffmpeg makes of the extension.
    Ffmpeg,
}

impl Format {
    /// Format of a file name.
    ///
    /// # Errors
    /// If its extension is not that of a video.
    pub fn of(path: &Path) -> Result<Self, Failure> {
        let extension = path.extension().and_then(|extension| extension.to_str()).map(str::to_ascii_lowercase);
        match extension.as_deref() {
            Some("gif") => Ok(Self::Gif),
            Some("apng") => Ok(Self::Apng),
            Some("mp4" | "webm" | "mov" | "mkv") => Ok(Self::Ffmpeg),
            _ => Err(Failure::Usage(format!(
                "{}: the extension of a video must be .mp4, .webm, .mov, .mkv, .gif or .apng",
                path.display()
            ))),
        }
    }
}

/// True for the name of a video.
pub fn is_video(path: &Path) -> bool {
    Format::of(path).is_ok()
}

/// Frame as 8-bit sRGB.
pub struct Frame {
    /// Width and height, pixels.
    pub size: [u32; 2],
    rgb: Vec<u8>,
}

impl Frame {
    /// Loads a picture; one of radiance is tone-mapped with an exposure in stops.
    ///
    /// # Errors
    /// If it cannot be read.
    pub fn load(path: &Path, exposure_stops: f32) -> Result<Self, Failure> {
        let loaded = image::load(path).map_err(Failure::other)?;
        let display = match loaded.kind {
            PictureKind::Hdr => Display { exposure_stops, ..Display::default() },
            PictureKind::Ldr => {
                Display { tonemap: pathmarch_render::pathmarch_scene::Tonemap::Srgb, exposure_stops: 0.0 }
            }
        };
        let picture = loaded.picture;
        let rgb = picture.pixels.iter().flat_map(|pixel| display.encode_8bit(*pixel)).collect();
        Ok(Self { size: [picture.width, picture.height], rgb })
    }
}

/// Video being written.
pub struct Encoder {
    output: PathBuf,
    temporary: NamedTempFile,
    size: [u32; 2],
    kind: Kind,
}

enum Kind {
    Gif(Box<gif::Encoder<BufWriter<File>>>, u16),
    Apng(Box<png::Writer<BufWriter<File>>>),
    Ffmpeg(Child),
}

impl Encoder {
    /// Starts a video of `frames` frames.
    ///
    /// # Errors
    /// If the file cannot be created, or ffmpeg is needed and missing.
    pub fn start(output: &Path, size: [u32; 2], fps: f32, frames: usize) -> Result<Self, Failure> {
        let directory = output.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let extension = output.extension().unwrap_or_default().to_string_lossy().into_owned();
        let failed = |error: &dyn std::fmt::Display| Failure::Other(format!("{}: {error}", output.display()));
        let temporary = tempfile::Builder::new()
            .prefix(".pathmarch-video.")
            .suffix(&format!(".part.{extension}"))
            .tempfile_in(directory)
            .map_err(|error| failed(&error))?;
        let file = || temporary.reopen().map(BufWriter::new).map_err(|error| failed(&error));
        let kind = match Format::of(output)? {
            Format::Gif => gif(file()?, size, fps).map_err(|error| failed(&error))?,
            Format::Apng => apng(file()?, size, fps, frames).map_err(|error| failed(&error))?,
            Format::Ffmpeg => Kind::Ffmpeg(ffmpeg(temporary.path(), size, fps)?),
        };
        Ok(Self { output: output.to_owned(), temporary, size, kind })
    }

    /// Adds a frame.
    ///
    /// # Errors
    /// If it has another size, or cannot be written.
    pub fn add(&mut self, frame: &Frame) -> Result<(), Failure> {
        if frame.size != self.size {
            let ([w, h], [fw, fh]) = (self.size, frame.size);
            return Err(Failure::Usage(format!(
                "a frame is {fw}x{fh} and those before are {w}x{h}; a video has one size"
            )));
        }
        let [width, height] = self.size;
        let added = match &mut self.kind {
            Kind::Gif(encoder, delay) => {
                // A picture has at most 16,384 pixels a side.
                let mut picture = gif::Frame::from_rgb_speed(width as u16, height as u16, &frame.rgb, 10);
                picture.delay = *delay;
                encoder.write_frame(&picture).map_err(|error| error.to_string())
            }
            Kind::Apng(writer) => writer.write_image_data(&frame.rgb).map_err(|error| error.to_string()),
            Kind::Ffmpeg(child) => match &mut child.stdin {
                Some(pipe) => pipe.write_all(&frame.rgb).map_err(|error| error.to_string()),
                None => Ok(()),
            },
        };
        match added {
            Ok(()) => Ok(()),
            Err(error) => Err(self.failure(&error)),
        }
    }

    /// Failure with what ffmpeg has said.
    fn failure(&mut self, error: &str) -> Failure {
        let said = match &mut self.kind {
            Kind::Ffmpeg(child) => {
                drop(child.stdin.take());
                let mut said = String::new();
                let _ = child.stderr.take().map(|mut pipe| std::io::Read::read_to_string(&mut pipe, &mut said));
                let _ = child.wait();
                said
            }
            _ => String::new(),
        };
        let said = if said.trim().is_empty() { String::new() } else { format!("; ffmpeg: {}", said.trim()) };
        Failure::Other(format!("{}: {error}{said}", self.output.display()))
    }

    /// Completes the video.
    ///
    /// # Errors
    /// If it cannot be written, or ffmpeg fails.
    pub fn finish(mut self) -> Result<(), Failure> {
        if let Kind::Ffmpeg(child) = &mut self.kind {
            drop(child.stdin.take());
            match child.wait() {
                Ok(status) if status.success() => {}
                Ok(status) => return Err(self.failure(&status.to_string())),
                Err(error) => return Err(self.failure(&error.to_string())),
            }
        }
        let Self { output, temporary, kind, .. } = self;
        let failed = |error: &dyn std::fmt::Display| Failure::Other(format!("{}: {error}", output.display()));
        match kind {
            Kind::Gif(encoder, _) => {
                let mut file = encoder.into_inner().map_err(|error| failed(&error))?;
                file.flush().map_err(|error| failed(&error))?;
            }
            Kind::Apng(writer) => writer.finish().map_err(|error| failed(&error))?,
            Kind::Ffmpeg(_) => {}
        }
        // ffmpeg replaces the file that it is given.
        let file = File::open(temporary.path()).map_err(|error| failed(&error))?;
        file.sync_all().map_err(|error| failed(&error))?;
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            let mode = std::fs::metadata(&output).map_or(0o644, |old| old.permissions().mode());
            let _ = file.set_permissions(std::fs::Permissions::from_mode(mode));
        }
        temporary.persist(&output).map_err(|error| failed(&error.error))?;
        Ok(())
    }
}

fn gif(file: BufWriter<File>, [width, height]: [u32; 2], fps: f32) -> Result<Kind, gif::EncodingError> {
    let mut encoder = gif::Encoder::new(file, width as u16, height as u16, &[])?;
    encoder.set_repeat(gif::Repeat::Infinite)?;
    // Hundredths of a second; viewers show shorter ones as ten.
    let delay = (100.0 / fps).round().clamp(2.0, 65_535.0) as u16;
    Ok(Kind::Gif(Box::new(encoder), delay))
}

fn apng(file: BufWriter<File>, [width, height]: [u32; 2], fps: f32, frames: usize) -> Result<Kind, png::EncodingError> {
    let mut encoder = png::Encoder::new(file, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    encoder.set_animated(frames as u32, 0)?;
    encoder.set_frame_delay((1000.0 / fps).round().clamp(1.0, 65_535.0) as u16, 1000)?;
    Ok(Kind::Apng(Box::new(encoder.write_header()?)))
}

/// Environment variable that names the program ffmpeg.
const FFMPEG: &str = "PATHMARCH_FFMPEG";

/// Fails if ffmpeg is needed for a video and missing.
///
/// # Errors
/// The same as of [`Encoder::start`].
pub fn check(output: &Path) -> Result<(), Failure> {
    if Format::of(output)? != Format::Ffmpeg {
        return Ok(());
    }
    let found = Command::new(program()).arg("-version").stdout(Stdio::null()).stderr(Stdio::null()).status();
    found.map(drop).map_err(|error| missing(&error))
}

fn program() -> std::ffi::OsString {
    std::env::var_os(FFMPEG).filter(|name| !name.is_empty()).unwrap_or_else(|| "ffmpeg".into())
}

fn missing(error: &std::io::Error) -> Failure {
    Failure::Other(format!(
        "ffmpeg was not found ({error}); install it (Debian: apt install ffmpeg), set {FFMPEG} to its path, or write a .gif or .apng"
    ))
}

fn ffmpeg(output: &Path, [width, height]: [u32; 2], fps: f32) -> Result<Child, Failure> {
    let mut command = Command::new(program());
    command.args(["-hide_banner", "-loglevel", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgb24"]);
    command.args(["-s", &format!("{width}x{height}"), "-r", &fps.to_string(), "-i", "-"]);
    // Players need 4:2:0, which has even sides.
    command.args(["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-pix_fmt", "yuv420p"]);
    match output.extension().and_then(|extension| extension.to_str()) {
        Some("webm") => command.args(["-c:v", "libvpx-vp9", "-crf", "24", "-b:v", "0"]),
        _ => command.args(["-c:v", "libx264", "-crf", "16", "-movflags", "+faststart"]),
    };
    command.arg(output).stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped());
    // Ctrl-C is for the program, which then ends ffmpeg by closing its input.
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(&mut command, 0);
    command.spawn().map_err(|error| missing(&error))
}
