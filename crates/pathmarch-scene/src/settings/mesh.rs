//! Properties of `mesh`.

use super::{Setting, SettingKind, setting};

/// Names of the forms of a mesh, the default first.
pub(crate) const FORMS: [&str; 3] = ["triangles", "field", "lit-by-field"];

/// Properties of a `mesh`.
pub const MESH: &[Setting] = &[
    setting(
        "as",
        SettingKind::Choice { noun: "form of a mesh", names: || FORMS.to_vec() },
        "",
        "as=\"field\"",
        "Exact triangles, as an object of its own; a distance field, for operators; or triangles for camera rays and the field for all others.",
    ),
    setting(
        "resolution",
        SettingKind::Whole { range: (16, 1024), default: 192 },
        "",
        "resolution=192",
        "Voxels of a field along its longest edge.",
    ),
    setting(
        "node",
        SettingKind::Whole { range: (0, 1_000_000), default: 0 },
        "",
        "node=2",
        "One node of a glTF file, counted from 1 among those with a mesh; 0 is all of them.",
    ),
];
