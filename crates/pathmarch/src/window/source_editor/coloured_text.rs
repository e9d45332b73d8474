//! Syntax colours. The laid-out text is kept until the text or the theme changes.

use egui::text::{LayoutJob, TextFormat};
use egui::{Color32, Galley, Ui};
use pathmarch_render::pathmarch_scene::language_service::{TokenKind, highlight};
use std::sync::Arc;

/// A text with its layout.
#[derive(Default)]
pub(crate) struct ColouredText {
    text: String,
    /// Theme and pixels of a point of the layout.
    look: (bool, f32),
    galley: Option<Arc<Galley>>,
    /// Line numbers, right-aligned.
    pub(crate) numbers: Option<Arc<Galley>>,
}

impl ColouredText {
    /// Lays out a text unless it is the same as before.
    pub(crate) fn update(&mut self, ui: &Ui, text: &str) {
        let look = (ui.visuals().dark_mode, ui.ctx().pixels_per_point());
        if self.galley.is_none() || self.text != text || self.look != look {
            let font = egui::TextStyle::Monospace.resolve(ui.style());
            let job = coloured(text, font.clone(), ui);
            let lines: Vec<String> = (1..=text.split('\n').count()).map(|line| format!("{line:>4}")).collect();
            let weak = ui.visuals().weak_text_color();
            let (galley, numbers) =
                ui.fonts_mut(|fonts| (fonts.layout_job(job), fonts.layout_no_wrap(lines.join("\n"), font, weak)));
            *self = Self { text: text.to_owned(), look, galley: Some(galley), numbers: Some(numbers) };
        }
    }

    /// The layout of a text.
    pub(crate) fn galley(&mut self, ui: &Ui, text: &str) -> Arc<Galley> {
        self.update(ui, text);
        self.galley.clone().unwrap_or_else(|| ui.fonts_mut(|fonts| fonts.layout_job(LayoutJob::default())))
    }
}

/// Lines do not wrap, so that they stay beside their numbers.
fn coloured(text: &str, font: egui::FontId, ui: &Ui) -> LayoutJob {
    let plain = ui.visuals().widgets.inactive.text_color();
    let mut job = LayoutJob { break_on_newline: true, ..LayoutJob::default() };
    job.wrap.max_width = f32::INFINITY;
    let mut at = 0;
    let mut append = |range: std::ops::Range<usize>, colour: Color32| {
        if !range.is_empty() {
            job.append(&text[range], 0.0, TextFormat::simple(font.clone(), colour));
        }
    };
    for token in highlight(text) {
        append(at..token.range.start, plain);
        append(token.range.clone(), colour(token.kind, ui, plain));
        at = token.range.end;
    }
    append(at..text.len(), plain);
    job
}

fn colour(kind: TokenKind, ui: &Ui, plain: Color32) -> Color32 {
    let (dark, light) = match kind {
        TokenKind::Node => ([122, 178, 255], [20, 80, 170]),
        TokenKind::Property => ([126, 206, 200], [0, 105, 105]),
        TokenKind::Number => ([222, 176, 110], [150, 80, 0]),
        TokenKind::String => ([160, 205, 130], [40, 115, 30]),
        TokenKind::Keyword => ([210, 150, 220], [130, 40, 140]),
        TokenKind::Comment => return ui.visuals().weak_text_color(),
        TokenKind::Word => return plain,
    };
    let [r, g, b] = if ui.visuals().dark_mode { dark } else { light };
    Color32::from_rgb(r, g, b)
}
