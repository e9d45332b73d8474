//! What can be done from menus and keys: one table, from which the menus, the shortcuts and the help page are made.

use egui::{Key, KeyboardShortcut, Modifiers};

/// A command of the menus and shortcuts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Action {
    New,
    Open,
    Gallery,
    Save,
    SaveAs,
    SavePicture,
    Render,
    Quit,
    Undo,
    Redo,
    Duplicate,
    Delete,
    Group,
    Ungroup,
    Deselect,
    FrameSelection,
    ResetCamera,
    NextCamera,
    WriteCamera,
    FocusClick,
    GizmoMove,
    GizmoRotate,
    GizmoScale,
    Preview,
    Play,
    NextFrame,
    PreviousFrame,
    KeepForComparison,
    Compare,
    Source,
    Plots,
    Tree,
    Inspector,
    Help,
    RestartGraphics,
    Dark,
}

/// A menu.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Menu {
    File,
    Edit,
    Camera,
    View,
    Help,
}

impl Menu {
    pub(crate) const ALL: [Self; 5] = [Self::File, Self::Edit, Self::Camera, Self::View, Self::Help];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::File => "File",
            Self::Edit => "Edit",
            Self::Camera => "Camera",
            Self::View => "View",
            Self::Help => "Help",
        }
    }
}

/// An action as the menus and the help window show it.
pub(crate) struct Entry {
    pub(crate) action: Action,
    pub(crate) menu: Menu,
    pub(crate) name: &'static str,
    pub(crate) doc: &'static str,
    pub(crate) shortcut: Option<KeyboardShortcut>,
    /// Enabled only while a scene is open.
    pub(crate) needs_scene: bool,
}

const fn ctrl(key: Key) -> Option<KeyboardShortcut> {
    Some(KeyboardShortcut::new(Modifiers::COMMAND, key))
}
const fn ctrl_shift(key: Key) -> Option<KeyboardShortcut> {
    Some(KeyboardShortcut::new(Modifiers::COMMAND.plus(Modifiers::SHIFT), key))
}
const fn plain(key: Key) -> Option<KeyboardShortcut> {
    Some(KeyboardShortcut::new(Modifiers::NONE, key))
}

const fn entry(
    action: Action,
    menu: Menu,
    name: &'static str,
    doc: &'static str,
    shortcut: Option<KeyboardShortcut>,
) -> Entry {
    Entry { action, menu, name, doc, shortcut, needs_scene: true }
}

const fn always(entry: Entry) -> Entry {
    Entry { needs_scene: false, ..entry }
}

/// All actions, in menu order.
#[rustfmt::skip]
pub(crate) const ACTIONS: &[Entry] = &[
    always(entry(Action::New, Menu::File, "New scene", "Start from a ball on a floor.", ctrl(Key::N))),
    always(entry(Action::Open, Menu::File, "Open…", "Open a scene file; one can also be dragged into the window.", ctrl(Key::O))),
    always(entry(Action::Gallery, Menu::File, "Gallery", "Choose one of the example scenes.", ctrl_shift(Key::G))),
    entry(Action::Save, Menu::File, "Save", "Write the scene to its file; comments and order stay.", ctrl(Key::S)),
    entry(Action::SaveAs, Menu::File, "Save as…", "Write the scene to another file.", ctrl_shift(Key::S)),
    entry(Action::SavePicture, Menu::File, "Save picture…", "Write what is shown as PNG, JPEG or OpenEXR.", ctrl(Key::E)),
    entry(Action::Render, Menu::File, "Render…", "Render the picture with all its samples to a file, in the background.", ctrl(Key::R)),
    always(entry(Action::Quit, Menu::File, "Quit", "Close the window; what is not saved is asked about.", ctrl(Key::Q))),
    entry(Action::Undo, Menu::Edit, "Undo", "Take back the last change.", ctrl(Key::Z)),
    entry(Action::Redo, Menu::Edit, "Redo", "Make the change again that was taken back.", ctrl_shift(Key::Z)),
    entry(Action::Duplicate, Menu::Edit, "Duplicate", "Another of what is selected.", ctrl(Key::D)),
    entry(Action::Delete, Menu::Edit, "Delete", "Remove what is selected.", plain(Key::Delete)),
    entry(Action::Group, Menu::Edit, "Group", "Put the selected shape into a union.", ctrl(Key::G)),
    entry(Action::Ungroup, Menu::Edit, "Ungroup", "Put the shapes of the selected operator in its place.", ctrl(Key::U)),
    entry(Action::Deselect, Menu::Edit, "Deselect", "Select nothing.", plain(Key::Escape)),
    entry(Action::FrameSelection, Menu::Camera, "Frame selection", "Bring what is selected, or everything, into the picture.", plain(Key::F)),
    entry(Action::ResetCamera, Menu::Camera, "Reset", "Back to the camera of the scene.", plain(Key::Home)),
    entry(Action::NextCamera, Menu::Camera, "Next camera", "The scene's next camera.", plain(Key::C)),
    entry(Action::WriteCamera, Menu::Camera, "Write to the scene", "Make the scene's camera the one that is shown.", ctrl(Key::K)),
    entry(Action::FocusClick, Menu::Camera, "Focus by click", "The next click in the picture sets the distance that is sharp.", plain(Key::X)),
    entry(Action::Preview, Menu::View, "Preview shading", "Plain ray marching without noise, for moving about; again for path tracing.", plain(Key::P)),
    entry(Action::Play, Menu::View, "Play or pause", "Let the time of a scene with formulas of t go on, or stop it.", plain(Key::Space)),
    entry(Action::NextFrame, Menu::View, "Next frame", "One frame later.", plain(Key::Period)),
    entry(Action::PreviousFrame, Menu::View, "Frame before", "One frame earlier.", plain(Key::Comma)),
    entry(Action::KeepForComparison, Menu::View, "Keep for comparison", "Keep the picture as it is now, to compare later ones with.", ctrl(Key::B)),
    entry(Action::Compare, Menu::View, "Compare", "Show the kept picture left of a line that can be dragged.", plain(Key::B)),
    entry(Action::GizmoMove, Menu::View, "Handles: move", "Handles in the picture move what is selected.", plain(Key::Num1)),
    entry(Action::GizmoRotate, Menu::View, "Handles: turn", "Handles in the picture turn what is selected.", plain(Key::Num2)),
    entry(Action::GizmoScale, Menu::View, "Handles: scale", "Handles in the picture scale what is selected.", plain(Key::Num3)),
    always(entry(Action::Tree, Menu::View, "Scene tree", "Show or hide the tree of the scene.", plain(Key::F2))),
    always(entry(Action::Inspector, Menu::View, "Controls", "Show or hide the controls of what is selected.", plain(Key::F3))),
    entry(Action::Source, Menu::View, "Source", "Show or hide the text of the scene, which can be edited.", plain(Key::F4)),
    always(entry(Action::Plots, Menu::View, "Plots", "Show or hide times of frames and samples per second.", plain(Key::F5))),
    always(entry(Action::Dark, Menu::View, "Dark or light", "Change the colours of the window.", plain(Key::F6))),
    always(entry(Action::Help, Menu::Help, "Keys and mouse", "Show or hide this page.", plain(Key::F1))),
    always(entry(Action::RestartGraphics, Menu::Help, "Restart graphics", "Open the graphics devices anew, where a driver misbehaves.", ctrl_shift(Key::F12))),
];

/// Mouse and held-key controls of the viewport.
pub(crate) const POINTER: &[(&str, &str)] = &[
    ("Click", "Select the shape that is pointed at."),
    ("Double click", "Look at the point that is clicked, and focus on it."),
    ("Drag", "Turn around what the camera looks at."),
    ("Middle drag, or Shift and drag", "Move along the picture."),
    ("Right drag", "Look around from where the camera stands."),
    ("Wheel", "Nearer or farther."),
    ("W A S D", "Fly; faster where surfaces are far. Q and E go down and up, Shift is faster."),
    ("Ctrl with + and -", "Larger and smaller text; Ctrl with 0 as it was."),
    ("Alt and click", "Set the distance that is sharp."),
];

/// Returns the action whose shortcut was pressed in this frame. Shortcuts without Ctrl are ignored while a text field
/// or a popup has the keyboard. `typed`: a text field had the focus before this frame; Escape has removed that focus by
/// now, and belongs to the field.
pub(crate) fn pressed(ctx: &egui::Context, has_scene: bool, typed: bool) -> Option<Action> {
    let typing = typed || ctx.text_edit_focused() || egui::Popup::is_any_open(ctx);
    // The space bar presses a focused button.
    let has_focus = ctx.memory(|memory| memory.focused().is_some());
    // Test longer chords first: a test that ignores Shift takes Ctrl+Shift+Z for Ctrl+Z.
    let mut entries: Vec<&Entry> = ACTIONS.iter().filter(|entry| has_scene || !entry.needs_scene).collect();
    entries.sort_by_key(|entry| {
        entry.shortcut.map_or(0, |s| -(i32::from(s.modifiers.shift) + i32::from(s.modifiers.any())))
    });
    let redo = KeyboardShortcut::new(Modifiers::COMMAND, Key::Y);
    ctx.input_mut(|input| {
        let found = entries.iter().find(|entry| {
            entry.shortcut.is_some_and(|shortcut| {
                let function_key =
                    shortcut.logical_key.name().starts_with('F') && shortcut.logical_key.name().len() > 1;
                let is_taken = has_focus && shortcut.logical_key == Key::Space;
                (shortcut.modifiers.any() || !typing || function_key) && !is_taken && input.consume_shortcut(&shortcut)
            })
        });
        match found {
            Some(entry) => Some(entry.action),
            None => (has_scene && input.consume_shortcut(&redo)).then_some(Action::Redo),
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn every_action_stands_once_with_a_shortcut_of_its_own() {
        let actions: HashSet<_> = ACTIONS.iter().map(|entry| entry.action).collect();
        assert_eq!(actions.len(), ACTIONS.len());
        let shortcuts: Vec<_> = ACTIONS.iter().filter_map(|entry| entry.shortcut).collect();
        for (k, shortcut) in shortcuts.iter().enumerate() {
            assert!(!shortcuts[..k].contains(shortcut), "{shortcut:?} twice");
        }
        for entry in ACTIONS {
            assert!(entry.doc.ends_with('.'), "{}", entry.name);
        }
    }
}
