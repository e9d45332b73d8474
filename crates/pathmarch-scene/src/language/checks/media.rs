//! Warnings about media.

use super::visible_nodes;
use crate::language::diagnostics::report::{Report, draft, shown};
use crate::language::keywords::FOG;
use crate::language::tree::Block;
use crate::light::Light;
use crate::scene::Scene;
use crate::settings::BOUNCES;

/// Warns of media that most likely are not intended as they are.
pub(super) fn warn(scene: &Scene, file: &Block, report: &mut Report) {
    endless_fog(scene, file, report);
    few_bounces(scene, file, report);
}

/// Warns of fog through which no light comes, or too much.
fn endless_fog(scene: &Scene, file: &Block, report: &mut Report) {
    let fog = &scene.fog;
    let Some(node) = file.nodes.iter().find(|node| node.name.value == FOG) else { return };
    let has_sun = scene.lights.iter().any(|light| matches!(light, Light::Sun { .. }));
    if (fog.scatters() || fog.absorbs()) && (!scene.sky.is_black() || has_sun) {
        let message = "This fog is infinite: no light of the sky or of a sun comes through it.";
        let help = "Use lamps, or fill an object around the camera instead: material \"mist\" { medium 0.1 }.";
        report.warn(draft("pathmarch::endless_fog", node.name.span, message).label("endless").help(help));
    }
    let clear = |channel: usize| fog.absorption[channel] + fog.scattering[channel] <= 0.0;
    if (0..3).any(|channel| fog.emission[channel] > 0.0 && clear(channel)) {
        let message = "This fog glows, is infinite and dims no light: rays that hit nothing are infinitely bright.";
        let warning = draft("pathmarch::endless_glow", node.name.span, message).label("endless");
        report.warn(warning.help("Give it `absorb`, or fill an object with a `medium` that has `glow`."));
    }
}

/// Warns of objects in which light scatters far more often than paths may.
fn few_bounces(scene: &Scene, file: &Block, report: &mut Report) {
    let bounces = scene.render.bounces as f32;
    let nodes = visible_nodes(file, &["object"]);
    for ((node, object), bounds) in nodes.zip(&scene.objects).zip(scene.field.object_bounds()) {
        let material = &scene.materials[object.material];
        let medium = material.medium();
        if !material.transmits() || !medium.scatters() || !bounds.is_finite() || bounds.is_empty() {
            continue;
        }
        let thickness = (0..3).map(|axis| bounds.max[axis] - bounds.min[axis]).fold(f32::INFINITY, f32::min);
        let events = (0..3).map(|channel| {
            events(medium.scattering[channel], medium.absorption[channel], medium.anisotropy, thickness)
        });
        let needed = events.fold(0.0, f32::max).ceil();
        if needed > 2.0 * bounces.max(1.0) {
            let name = shown(&object.name);
            let message =
                format!("Light scatters about {needed} times in the object {name}, but `bounces` is {bounces}.");
            let warning = draft("pathmarch::few_bounces", node.name.span, message).label("too dark");
            let help = match needed <= BOUNCES.1 as f32 {
                true => format!("Use `render {{ bounces {needed} }}`, or less `scatter`."),
                false => "Use less `scatter`: farther inside, the medium hardly looks different.".to_owned(),
            };
            report.warn(warning.help(help));
        }
    }
}

/// Typical number of scattering events on the way through a layer of a thickness in metres: the optical depth where light
/// goes straight, half its square where it diffuses, less where it is absorbed before.
fn events(scattering: f32, absorption: f32, anisotropy: f32, thickness: f32) -> f32 {
    let depth = scattering * thickness;
    let diffusing = depth * (1.0 + 0.5 * depth * (1.0 - anisotropy));
    let absorbed = 3.0 * (scattering + absorption) / absorption.max(1e-20);
    diffusing.min(absorbed)
}
