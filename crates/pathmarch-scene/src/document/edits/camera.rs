//! Cameras, written into the text.

use super::additions::add_top;
use super::naming::{free_name, title};
use super::transaction::Transaction;
use super::write::check::{check, keeping_formulas};
use crate::document::control::Value;
use crate::document::error::EditError;
use crate::document::text::literals::quoted;
use crate::document::tree::outline::ItemKind;
use crate::document::tree::path::Path;
use crate::scene::Camera;
use crate::settings::AUTO;

/// The parameters of a camera.
fn camera_values(camera: &Camera) -> [(&'static str, Value); 7] {
    [
        ("position", Value::Triple(camera.position)),
        ("target", Value::Triple(camera.target)),
        ("up", Value::Triple(camera.up)),
        ("fov", Value::Number(camera.fov)),
        ("lens.radius", Value::Number(camera.lens_radius)),
        ("lens.focus", camera.focus.map_or(Value::None, Value::Number)),
        ("exposure", if camera.auto_exposure { Value::Text(AUTO.to_owned()) } else { Value::Number(camera.exposure) }),
    ]
}

/// Writes a camera into a node, or as a new one.
pub(crate) fn write_camera(
    transaction: &mut Transaction,
    camera: &Camera,
    into: Option<&Path>,
) -> Result<Path, EditError> {
    let path = match into {
        Some(path) => path.clone(),
        None => {
            let name = free_name(transaction, "camera", if camera.name.is_empty() { "camera" } else { &camera.name });
            let template = format!("camera {} {{\n\tposition 0 0 0\n\ttarget 0 0 0\n}}", quoted(&name));
            add_top(transaction, "camera", &template)?
        }
    };
    let found = transaction.find(&path)?;
    if found.kind != ItemKind::Camera {
        return Err(EditError::NotHere(format!("`{}` is no camera.", title(found.node, found.kind))));
    }
    for (key, value) in camera_values(camera) {
        let parameter = transaction.parameter(&path, key)?;
        let writer = transaction.writer(transaction.find(&path)?);
        // A direction is of length one in a camera, and of any length in the text.
        let same = match (&value, &parameter.control.present) {
            (Value::Triple(new), Value::Triple(now)) if key == "up" => {
                let now = glam::DVec3::from_array(now.map(f64::from)).normalize_or_zero();
                now.as_vec3().to_array() == *new
            }
            (new, _) => *new == parameter.control.present,
        };
        let patches = match &value {
            _ if same => continue,
            Value::None => writer.erase(&parameter)?,
            // The control of an exposure is a number or "auto", as the text gives it.
            value if key == "exposure" => writer.write(&parameter, value)?,
            value => {
                check(&parameter, value)?;
                writer.write(&parameter, &keeping_formulas(&parameter, value.clone())?)?
            }
        };
        transaction.then(patches)?;
    }
    Ok(path)
}
