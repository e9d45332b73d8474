//! Playback state of an animated scene.

/// State of playback.
pub(crate) struct Playback {
    /// Last frame; playback continues with frame 0.
    pub(crate) last: u32,
    /// Start time of playback, seconds, and first frame played.
    pub(crate) playing: Option<(f64, u32)>,
}

impl Default for Playback {
    fn default() -> Self {
        Self { last: 119, playing: None }
    }
}

/// Largest frame number.
pub(crate) const LAST_FRAME: u32 = 999_999;

impl Playback {
    pub(crate) fn is_playing(&self) -> bool {
        self.playing.is_some()
    }

    /// Frame that is due at time `now` (seconds), and seconds until the next one; `None` while paused.
    pub(crate) fn due(&self, now: f64, fps: f32) -> Option<(u32, f64)> {
        let (since, first) = self.playing?;
        let frames = (now - since).max(0.0) * f64::from(fps);
        let frame = (u64::from(first) + frames as u64) % (u64::from(self.last) + 1);
        Some((frame as u32, (1.0 - frames.fract()) / f64::from(fps)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_due_when_their_time_has_come() {
        let playback = Playback { last: 9, playing: Some((100.0, 4)) };
        assert_eq!(playback.due(100.0, 25.0).map(|(frame, _)| frame), Some(4));
        let (frame, left) = playback.due(100.05, 25.0).expect("it plays");
        assert!(frame == 5 && (left - 0.03).abs() < 1e-9, "{frame} {left}");
        // Frame 0 follows frame 9.
        assert_eq!(playback.due(100.21, 25.0).map(|(frame, _)| frame), Some(9));
        assert_eq!(playback.due(100.25, 25.0).map(|(frame, _)| frame), Some(0));
        assert_eq!(Playback::default().due(5.0, 25.0), None);
    }
}
