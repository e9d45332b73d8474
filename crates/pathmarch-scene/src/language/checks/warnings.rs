//! Warnings: what is allowed, but most likely not intended.

use super::{media, visible_nodes};
use crate::language::diagnostics::report::{Report, draft, shown};
use crate::language::keywords::UNIT;
use crate::language::tree::Block;
use crate::light::Light;
use crate::medium::Medium;
use crate::scene::{Camera, Object, Scene};
use crate::settings::Caustics;
use glam::Vec3;
use pathmarch_field::{Aabb, number};

/// Warns of what is most likely not intended.
pub(crate) fn warn(scene: &Scene, file: &Block, report: &mut Report) {
    let Some(first) = file.nodes.first() else { return };
    let emits = |tag: u32| scene.materials[tag as usize].emits();
    let glows = |tag: u32| scene.materials[tag as usize].medium().emits();
    if scene.objects.is_empty() && scene.fog == Medium::VACUUM {
        let warning = draft("pathmarch::no_objects", first.name.span, "The scene has no objects.");
        report.warn(warning.label("in this file"));
    }
    let bright = |colour: [f32; 3]| colour.iter().any(|&v| v > 0.0);
    let lit = !scene.sky.is_black()
        || scene.fog.emits()
        || scene.field.leaves().iter().any(|leaf| emits(leaf.tag) || glows(leaf.tag))
        || scene.lights.iter().any(|light| bright(light.power()));
    if !lit {
        let warning =
            draft("pathmarch::no_light", first.name.span, "Nothing lights the scene: the picture will be black.");
        let help = "Add a `sky`, a `sun`, a `point` or `spot` light, or an object whose material emits.";
        report.warn(warning.label("in this file").help(help));
    }
    let mut emitting = vec![false; scene.objects.len()];
    for leaf in scene.field.leaves() {
        emitting[leaf.object as usize] |= emits(leaf.tag);
    }
    // Without mistakes every visible object node has become an object, and every object a part of the field.
    let objects = visible_nodes(file, &["object"]);
    let bounds = scene.field.object_bounds().iter();
    let endless = objects.zip(bounds.zip(emitting)).filter(|(_, (bounds, emitting))| *emitting && !bounds.is_finite());
    for (node, _) in endless {
        let warning = draft("pathmarch::endless_light", node.name.span, "This object emits light and is infinite.");
        let help = "It is not sampled as a light, only found by chance; make it finite, or use `sky`.";
        report.warn(warning.label("infinite").help(help));
    }
    lost_light(scene, file, report);
    clear_sheets(scene, file, report);
    let hiding = hiding_objects(scene);
    hidden_points(scene, &hiding, file, report);
    hidden_cameras(scene, &hiding, file, report);
    large_numbers(scene, file, report);
    media::warn(scene, file, report);
}

/// Warns of lights without size in scenes with clear glass: no path finds them through it, so that its shadow is dark.
fn lost_light(scene: &Scene, file: &Block, report: &mut Report) {
    let materials = scene.field.leaves().iter().map(|leaf| &scene.materials[leaf.tag as usize]);
    let clear = materials.clone().any(|material| material.transmits() && material.kind.has_surface);
    if !clear || scene.render.caustics != Caustics::default() {
        return;
    }
    let suns = scene.lights.iter().filter(|light| matches!(light, Light::Sun { .. }));
    let parallel = visible_nodes(file, &["sun"]).zip(suns);
    let parallel = parallel.filter(|(_, light)| matches!(light, Light::Sun { angle: 0.0, .. }));
    let points = visible_nodes(file, &["point"]).map(|node| (node, "point light"));
    let spots = visible_nodes(file, &["spot"]).map(|node| (node, "spot light"));
    let lights = parallel.map(|(node, _)| (node, "sun")).chain(points).chain(spots);
    for (node, what) in lights.take(3) {
        let message = format!("Light of this {what} does not pass the clear materials of the scene: it has no size.");
        let warning = draft("pathmarch::lost_light", node.name.span, message).label("no path finds it through glass");
        let help = "Give `render` the line `caustics \"traced\"`, or `caustics \"fast\"`, which does not focus light.";
        report.warn(warning.help(help));
    }
}

/// Warns of cameras inside opaque solids without a lamp, whose pictures are black.
fn hidden_cameras(scene: &Scene, hiding: &[bool], file: &Block, report: &mut Report) {
    // Those of the file come first; cameras of included files are left out.
    let nodes = file.nodes.iter().filter(|node| node.name.value == "camera");
    for (node, camera) in nodes.zip(&scene.cameras) {
        let Some(object) = hiding_object_around(scene, hiding, camera.position) else { continue };
        let (camera, object) = (shown(&camera.name), shown(&object.name));
        let message =
            format!("The camera {camera} is inside the object {object}, which is opaque: it sees only its inside.");
        let warning = draft("pathmarch::hidden_camera", node.name.span, message).label("inside a solid");
        report.warn(
            warning.help(
                "Move the camera out, put a lamp inside as well, hollow the object with `shell`, or make it glass.",
            ),
        );
    }
}

/// Distances from camera to target that are usual in millimetres or centimetres, and rare in metres.
const LARGE_VIEW: std::ops::Range<f32> = 100.0..5000.0;

/// Warns of a scene without a unit whose lengths look like millimetres or centimetres.
fn large_numbers(scene: &Scene, file: &Block, report: &mut Report) {
    if file.nodes.iter().any(|node| node.name.value == UNIT) {
        return;
    }
    let nodes = file.nodes.iter().filter(|node| node.name.value == "camera");
    let distance = |camera: &Camera| Vec3::from(camera.position).distance(Vec3::from(camera.target));
    let Some((node, camera)) = nodes.zip(&scene.cameras).next() else { return };
    if LARGE_VIEW.contains(&distance(camera)) {
        let message = format!("The camera {} is {:.0} m from its target.", shown(&camera.name), distance(camera));
        let warning = draft("pathmarch::large_numbers", node.name.span, message).label("are these metres?");
        let help =
            "If lengths are centimetres, write `unit \"cm\"` below `pathmarch 1`; `unit \"m\"` if they are metres.";
        report.warn(warning.help(help));
    }
}

/// Number of lamps that are looked for in solids, so that the time for it is bounded: of very many, the first.
fn tested_lamps(scene: &Scene) -> usize {
    const EVALUATIONS: usize = 10_000_000;
    EVALUATIONS / scene.field.leaves().len().max(1)
}

/// For each object, whether it hides what is inside: an opaque solid that is no room, which has a camera and a lamp inside.
fn hiding_objects(scene: &Scene) -> Vec<bool> {
    let transmits = |material: usize| scene.materials[material].transmits();
    let mut hiding: Vec<bool> = scene.objects.iter().map(|object| !transmits(object.material)).collect();
    let mut emitting = vec![false; scene.objects.len()];
    for leaf in scene.field.leaves() {
        hiding[leaf.object as usize] &= !transmits(leaf.tag as usize);
        emitting[leaf.object as usize] |= scene.materials[leaf.tag as usize].emits();
    }
    let middle = |bounds: &Aabb| std::array::from_fn(|k| 0.5 * (bounds.min[k] + bounds.max[k]));
    let emitters = scene.field.object_bounds().iter().zip(emitting).filter(|(_, emits)| *emits);
    let lamps: Vec<[f32; 3]> =
        emitters.map(|(bounds, _)| middle(bounds)).chain(scene.lights.iter().filter_map(Light::position)).collect();
    let lamps = &lamps[..lamps.len().min(tested_lamps(scene))];
    for (index, hides) in hiding.iter_mut().enumerate().filter(|(_, hides)| **hides) {
        let is_inside = |[x, y, z]: [f32; 3]| scene.field.contains(index, number::Vec3 { x, y, z });
        let is_room =
            scene.cameras.iter().any(|camera| is_inside(camera.position)) && lamps.iter().any(|lamp| is_inside(*lamp));
        *hides = !is_room;
    }
    hiding
}

/// First object around this point that hides it.
fn hiding_object_around<'s>(scene: &'s Scene, hiding: &[bool], [x, y, z]: [f32; 3]) -> Option<&'s Object> {
    let mut hiding = scene.objects.iter().zip(hiding).enumerate().filter(|(_, (_, hides))| **hides);
    hiding.find(|(index, _)| scene.field.contains(*index, number::Vec3 { x, y, z })).map(|(_, (object, _))| object)
}

/// Warns of glass on surfaces that have no inside.
fn clear_sheets(scene: &Scene, file: &Block, report: &mut Report) {
    let mut clear = vec![false; scene.objects.len()];
    for leaf in scene.field.leaves() {
        let material = &scene.materials[leaf.tag as usize];
        clear[leaf.object as usize] |=
            leaf.shape.info().sheet && material.transmits() && !material.dielectric().is_thin;
    }
    let objects = visible_nodes(file, &["object"]);
    for (node, _) in objects.zip(clear).filter(|(_, clear)| *clear) {
        let message = "This object is of a clear material and has no inside: light that enters it never leaves.";
        let warning = draft("pathmarch::clear_sheet", node.name.span, message).label("a rect or a disc");
        report.warn(warning.help("Add `thin #true` to the glass, or use a thin `box` or `cylinder`."));
    }
}

/// Warns of point and spot lights inside solids, as far as the time for it is bounded: for the first of very many points.
fn hidden_points(scene: &Scene, hiding: &[bool], file: &Block, report: &mut Report) {
    let points = scene.lights.iter().filter_map(Light::position);
    // Without mistakes every such node has become a light.
    let nodes = visible_nodes(file, &["point", "spot"]);
    for (node, position) in nodes.zip(points).take(tested_lamps(scene)) {
        if let Some(object) = hiding_object_around(scene, hiding, position) {
            let message =
                format!("This {} light is inside the object {}, which hides it.", node.name.value, shown(&object.name));
            let warning = draft("pathmarch::hidden_light", node.name.span, message).label("shines nowhere");
            report.warn(warning.help("Move it out, or make the object emit."));
        }
    }
}
