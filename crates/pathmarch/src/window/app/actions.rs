//! Table of actions, from which menus, shortcuts and the help window are generated.

use egui::{Key, KeyboardShortcut, Modifiers};

/// A command of the menus and shortcuts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Action {
    New,
    Open,
    Gallery,
    Import,
    Save,
    SaveAs,
    AllowFiles,
    SavePicture,
    Render,
    Quit,
    Undo,
    Redo,
    Duplicate,
    Delete,
    Group,
    Ungroup,
    Unite,
    Subtract,
    Intersect,
    ToGround,
    SnapToSurfaces,
    Mirror,
    AlignX,
    AlignY,
    AlignZ,
    Hide,
    HideOthers,
    ShowAll,
    Lock,
    Turntable,
    SetKey,
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
    Materials,
    PictureOnly,
    Recover,
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
const fn shift(key: Key) -> Option<KeyboardShortcut> {
    Some(KeyboardShortcut::new(Modifiers::SHIFT, key))
}
const fn alt(key: Key) -> Option<KeyboardShortcut> {
    Some(KeyboardShortcut::new(Modifiers::ALT, key))
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
    always(entry(Action::New, Menu::File, "New scene", "Start from a sphere on a floor.", ctrl(Key::N))),
    always(entry(Action::Open, Menu::File, "Open…", "Open a scene file. You can also drop one onto the window.", ctrl(Key::O))),
    always(entry(Action::Gallery, Menu::File, "Gallery", "Open one of the example scenes.", ctrl_shift(Key::G))),
    entry(Action::Import, Menu::File, "Import a mesh…", "Add the objects, lights and cameras of a mesh file. A dropped mesh is put on the ground.", ctrl(Key::I)),
    entry(Action::Save, Menu::File, "Save", "Save the scene to its file; comments and order are kept.", ctrl(Key::S)),
    entry(Action::SaveAs, Menu::File, "Save as…", "Save the scene to another file.", ctrl_shift(Key::S)),
    entry(Action::AllowFiles, Menu::File, "Allow other files", "Let this scene read files outside its folder; only for scenes that you trust.", None),
    entry(Action::SavePicture, Menu::File, "Save picture…", "Save the displayed picture as PNG, JPEG or OpenEXR.", ctrl(Key::E)),
    entry(Action::Render, Menu::File, "Render…", "Render to a file with all samples, in the background.", ctrl(Key::R)),
    always(entry(Action::Recover, Menu::File, "Recover unsaved work…", "Open unsaved work of programs that ended without saving it.", None)),
    always(entry(Action::Quit, Menu::File, "Quit", "Close the window; asks about unsaved changes.", ctrl(Key::Q))),
    entry(Action::Undo, Menu::Edit, "Undo", "Undo the last change.", ctrl(Key::Z)),
    entry(Action::Redo, Menu::Edit, "Redo", "Redo the last undone change.", ctrl_shift(Key::Z)),
    entry(Action::Duplicate, Menu::Edit, "Duplicate", "Duplicate the selection, in place.", ctrl(Key::D)),
    entry(Action::Delete, Menu::Edit, "Delete", "Delete the selection.", plain(Key::Delete)),
    entry(Action::Group, Menu::Edit, "Group", "Put the selected shapes into a union operator.", ctrl(Key::G)),
    entry(Action::Ungroup, Menu::Edit, "Ungroup", "Replace the selected operator by its children.", ctrl(Key::U)),
    entry(Action::Unite, Menu::Edit, "Unite", "Combine the selected shapes and objects into one.", plain(Key::U)),
    entry(Action::Subtract, Menu::Edit, "Subtract", "Subtract the other selected shapes and objects from the one that was selected first.", plain(Key::M)),
    entry(Action::Intersect, Menu::Edit, "Intersect", "Keep what the selected shapes and objects have in common.", plain(Key::I)),
    entry(Action::ToGround, Menu::Edit, "Put on the ground", "Move the selected shapes up or down until they touch the height 0.", plain(Key::G)),
    entry(Action::SnapToSurfaces, Menu::Edit, "Snap to surfaces", "Drag shapes by their centre, and targets of spot lights, over the surfaces of others.", plain(Key::T)),
    entry(Action::Mirror, Menu::Edit, "Mirror", "Mirror the selected shapes at the plane x = 0; other axes are in the properties.", None),
    entry(Action::AlignX, Menu::Edit, "Align along x", "Move the selected shapes until their centres have the x of the one that was selected last.", None),
    entry(Action::AlignY, Menu::Edit, "Align along y", "Move the selected shapes until their centres have the y of the one that was selected last.", None),
    entry(Action::AlignZ, Menu::Edit, "Align along z", "Move the selected shapes until their centres have the z of the one that was selected last.", None),
    entry(Action::SetKey, Menu::Edit, "Set key", "Keep position, rotation and scale of the selection at this frame. Later changes set keys, too.", plain(Key::K)),
    entry(Action::Hide, Menu::Edit, "Hide / show", "Hide the selected objects and lights, or show them again. Hidden ones are not rendered.", plain(Key::H)),
    entry(Action::HideOthers, Menu::Edit, "Hide others", "Hide all objects that are not selected.", shift(Key::H)),
    entry(Action::ShowAll, Menu::Edit, "Show all", "Show all hidden objects and lights.", alt(Key::H)),
    entry(Action::Lock, Menu::Edit, "Lock / unlock", "Protect the selected objects from clicks and handles in the viewport.", plain(Key::L)),
    always(entry(Action::Deselect, Menu::Edit, "Deselect", "Close the help, show the panels again, or clear the selection.", plain(Key::Escape))),
    entry(Action::FrameSelection, Menu::Camera, "Frame selection", "Move the camera to show the selection, or the whole scene.", plain(Key::F)),
    entry(Action::ResetCamera, Menu::Camera, "Reset view", "Return to the scene's camera.", plain(Key::Home)),
    entry(Action::NextCamera, Menu::Camera, "Next camera", "Switch to the scene's next camera.", plain(Key::C)),
    entry(Action::WriteCamera, Menu::Camera, "Save view to camera", "Set the scene's camera to the current view.", ctrl(Key::K)),
    entry(Action::Turntable, Menu::Camera, "Turntable", "Animate the camera: it goes once around its target, from the current view.", None),
    entry(Action::FocusClick, Menu::Camera, "Pick focus in view", "Set the focus distance with the next click in the viewport.", plain(Key::X)),
    entry(Action::Preview, Menu::View, "Preview shading", "Switch between path tracing and the noise-free preview.", plain(Key::P)),
    entry(Action::Play, Menu::View, "Play / pause", "Play or pause a scene that is animated by formulas of t.", plain(Key::Space)),
    entry(Action::NextFrame, Menu::View, "Next frame", "Go to the next frame.", plain(Key::Period)),
    entry(Action::PreviousFrame, Menu::View, "Previous frame", "Go to the previous frame.", plain(Key::Comma)),
    entry(Action::KeepForComparison, Menu::View, "Store for comparison", "Store the picture as it is now, to compare later ones with it.", ctrl(Key::B)),
    entry(Action::Compare, Menu::View, "Compare", "Show or hide the stored picture, left of a line that can be dragged.", plain(Key::B)),
    entry(Action::GizmoMove, Menu::View, "Move gizmo", "Move the selection with handles in the viewport.", plain(Key::Num1)),
    entry(Action::GizmoRotate, Menu::View, "Rotate gizmo", "Rotate the selection with handles in the viewport.", plain(Key::Num2)),
    entry(Action::GizmoScale, Menu::View, "Scale gizmo", "Scale the selection with a handle in the viewport.", plain(Key::Num3)),
    entry(Action::PictureOnly, Menu::View, "Picture only", "Fill the window with the picture; Escape returns to the panels.", plain(Key::F11)),
    always(entry(Action::Tree, Menu::View, "Scene tree", "Show or hide the scene tree.", plain(Key::F2))),
    always(entry(Action::Inspector, Menu::View, "Properties", "Show or hide the properties of the selection.", plain(Key::F3))),
    entry(Action::Materials, Menu::View, "Materials", "Show or hide a palette of materials, which are dragged onto shapes.", plain(Key::F7)),
    entry(Action::Source, Menu::View, "Source", "Show or hide the editor of the scene's text.", plain(Key::F4)),
    always(entry(Action::Plots, Menu::View, "Performance plots", "Show or hide plots of frame time and sample rate.", plain(Key::F5))),
    always(entry(Action::Dark, Menu::View, "Dark / light theme", "Switch between the dark and the light theme.", plain(Key::F6))),
    always(entry(Action::Help, Menu::Help, "Keyboard and mouse", "Show or hide this help.", plain(Key::F1))),
    always(entry(Action::RestartGraphics, Menu::Help, "Restart graphics", "Reopen the graphics devices, for example after a driver problem.", ctrl_shift(Key::F12))),
];

/// Mouse and held-key controls of the viewport.
pub(crate) const POINTER: &[(&str, &str)] = &[
    ("Click", "Select the shape under the pointer."),
    ("Ctrl + click, or Shift + click", "Add the shape to the selection, or remove it."),
    ("Ctrl + drag", "Select all shapes in a box."),
    ("Double click", "Aim the camera at the clicked point and focus on it."),
    ("Drag", "Orbit around the camera's target."),
    ("Middle drag, or Shift + drag", "Pan the camera."),
    ("Right drag", "Look around without moving."),
    ("Wheel", "Move towards the target or away from it."),
    ("Drag a point of an outline", "Move it. Press on the outline to add one, right click to remove one."),
    ("W A S D", "Fly; Q and E go down and up, Shift is faster."),
    ("Ctrl + plus or minus", "Zoom the user interface; Ctrl + 0 resets it."),
    ("Alt + click", "Set the focus distance."),
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
                (shortcut.modifiers.command || !typing || function_key)
                    && !is_taken
                    && input.consume_shortcut(&shortcut)
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
    fn every_action_is_listed_once_with_a_unique_shortcut() {
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
