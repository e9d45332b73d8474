//! State of the modal dialogs: which one is open, and the settings of the render dialog.

use super::requests::PendingAction;
use crate::frames::{self, FrameRange};
use crate::window::background_render::FrameSequence;
use crate::window::files::recovery::RecoveredWork;
use crate::window::open_scene::OpenScene;
use pathmarch_render::Settings;
use pathmarch_render::image::ImageFormat;
use std::path::{Path, PathBuf};

/// The open modal dialog.
pub(crate) enum Dialog {
    /// Unsaved work would be lost.
    Unsaved(PendingAction),
    /// Another program changed the file while there are unsaved changes here.
    Conflict,
    /// Unsaved work of crashed sessions was found.
    Recovered(Vec<RecoveredWork>),
    /// Settings of a final render.
    Render(RenderDialog),
    /// Quit was requested while renders are running.
    Busy,
}

/// Placeholder for the digits of the frame number in a file name.
const DIGITS: &str = "-####";

/// Settings of a final render.
pub(crate) struct RenderDialog {
    pub(crate) output: String,
    pub(crate) size: [u32; 2],
    pub(crate) samples: u32,
    pub(crate) bounces: u32,
    pub(crate) layers: bool,
    /// Render from the current view, not from the scene's camera.
    pub(crate) own_viewpoint: bool,
    pub(crate) may_choose_viewpoint: bool,
    /// First and last frame of an animated scene; `all_frames` renders this range, otherwise only the frame shown.
    pub(crate) frames: Option<[u32; 2]>,
    pub(crate) all_frames: bool,
    pub(crate) skip_existing: bool,
}

impl RenderDialog {
    pub(crate) fn new(open: &OpenScene) -> Option<Self> {
        let scene = open.document.last_good()?;
        let settings = Settings::of(scene);
        let path = open.path.clone().unwrap_or_else(|| PathBuf::from("picture.kdl"));
        let output = std::path::absolute(path.with_extension("png")).unwrap_or(path);
        Some(Self {
            output: output.display().to_string(),
            size: settings.size,
            samples: open.view.mode.samples(settings.samples),
            bounces: settings.bounces,
            layers: false,
            own_viewpoint: open.view.is_camera_modified(),
            may_choose_viewpoint: open.view.is_camera_modified(),
            frames: scene.animated.then_some([0, open.playback.last]),
            all_frames: false,
            skip_existing: false,
        })
    }

    /// Creates the dialog as [`Self::new`] does, for all frames.
    pub(crate) fn of_frames(open: &OpenScene) -> Option<Self> {
        let mut dialog = Self::new(open)?;
        dialog.render_frames(true);
        Some(dialog)
    }

    /// Switches between all frames and the frame shown; adapts the file name.
    pub(crate) fn render_frames(&mut self, all: bool) {
        self.all_frames = all;
        let path = Path::new(&self.output);
        let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let named = match (all, stem.strip_suffix(DIGITS)) {
            (true, None) if !stem.contains('#') => format!("{stem}{DIGITS}"),
            (false, Some(without)) => without.to_owned(),
            _ => return,
        };
        let extension = path.extension().unwrap_or_default().to_string_lossy();
        self.output = path.with_file_name(format!("{named}.{extension}")).display().to_string();
    }

    /// Frames to render; `None` for a single picture.
    pub(crate) fn sequence(&self) -> Option<FrameSequence> {
        let [first, last] = self.frames.filter(|_| self.all_frames)?;
        Some(FrameSequence { frames: FrameRange::from_to(first, last), skip_existing: self.skip_existing })
    }

    /// Problem with the settings, in words.
    pub(crate) fn problem(&self) -> Option<String> {
        let Some(sequence) = self.sequence() else { return self.format().err() };
        self.format().err().or_else(|| frames::check_pattern(Path::new(&self.output), sequence.frames).err())
    }

    pub(crate) fn format(&self) -> Result<ImageFormat, String> {
        ImageFormat::from_path(Path::new(&self.output)).map_err(|error| error.to_string())
    }
}

/// Answer to a modal dialog.
pub(crate) enum Answer {
    None,
    Close,
    Save(PendingAction),
    Discard(PendingAction),
    KeepMine,
    TakeTheirs,
    SaveMineAs,
    Recover(usize),
    DiscardRecovered(usize),
    AskLater,
    StartRender,
    ChooseOutput,
    /// Cancel running renders and quit.
    CancelRendersAndQuit,
}
