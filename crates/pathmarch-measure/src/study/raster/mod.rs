//! Rasterisation beside marching: the same field as a mesh, with Phong shading, as in Figures 2.2 to 2.4 of the thesis.

mod rasteriser;

use super::picture_grid::{Panel, save as save_grid};
use super::table::{Table, milliseconds};
use super::{Study, example};
use pathmarch_cli::Failure;
use pathmarch_render::mesh_file;
use pathmarch_render::pathmarch_field::mesh::Fineness;
use pathmarch_render::pathmarch_field::{Aabb, Mesh};
use pathmarch_render::pathmarch_scene::Scene;
use pathmarch_render::tonemap::Display;
use pathmarch_render::{Mode, Settings};
use rasteriser::Rasteriser;
use std::ops::ControlFlow;
use std::time::Instant;

/// Scenes and the figures that they stand for.
const SCENES: [(&str, &str); 2] =
    [("twisted-cube", "Figure 2.2 (page 23)"), ("solids", "Figures 2.3 and 2.4 (pages 24 and 25)")];
/// Half the edge of the box that cuts what has no end, metres.
const CUT: f32 = 8.0;

/// The mesh of a whole scene; what has no end is cut.
fn mesh_of(scene: &Scene, resolution: u32) -> Result<(Mesh, f64), Failure> {
    let began = Instant::now();
    let mut all = Mesh::default();
    for object in &scene.objects {
        // Each object has a mesh of its own, so that a floor does not make those on it coarse.
        let cut = Aabb { min: [-CUT; 3], max: [CUT; 3] };
        let progress = &|_| ControlFlow::Continue(());
        let mesh = mesh_file::mesh(scene, &[object], Fineness::Resolution(resolution), None, progress)
            .or_else(|_| mesh_file::mesh(scene, &[object], Fineness::Resolution(resolution), Some(cut), progress))
            .map_err(Failure::other)?;
        let first = all.positions.len() as u32;
        all.positions.extend(mesh.positions);
        all.normals.extend(mesh.normals);
        all.colours.extend(mesh.colours);
        all.triangles.extend(mesh.triangles.iter().map(|corners| corners.map(|corner| first + corner)));
    }
    Ok((all, began.elapsed().as_secs_f64()))
}

pub fn study(study: &mut Study) -> Result<String, Failure> {
    let size = study.plan.size;
    let mut table =
        Table::new(["scene", "triangles", "mesh, s", "raster, ms", "preview, ms", "path tracing, ms/sample", "device"]);
    let mut pictures = String::new();
    for (name, figures) in SCENES {
        study.log(&format!("raster: {name}"));
        let scene = example(name)?;
        let settings = Settings { size, ..Settings::of(&scene) };
        let (mesh, mesh_seconds) = mesh_of(&scene, study.plan.mesh_resolution)?;
        let display = Display { tonemap: scene.render.tonemap, exposure_stops: settings.camera_of(&scene).exposure };
        let mut panels = Vec::new();
        let (mut raster, mut device) = (None, "-".to_owned());
        match Rasteriser::open(size) {
            Ok(rasteriser) => {
                let frames = 4 * study.plan.rounds;
                for terms in 1..=3 {
                    let (picture, milliseconds) = rasteriser.draw(&mesh, &scene, &settings, terms, frames)?;
                    panels.push(Panel::of(&picture, &display).reduced(3));
                    raster = Some(milliseconds);
                }
                rasteriser.device.clone_into(&mut device);
            }
            Err(reason) => pathmarch_cli::note!("raster: {reason}"),
        }
        let preview_settings = Settings { mode: Mode::Preview, samples: 1, ..settings.clone() };
        let previews = study.time_view(&scene, &preview_settings, settings.bounces)?;
        let paths = study.time_view(&scene, &settings, super::tables::BOUNCES)?;
        let best = |times: &[Option<f64>]| times.iter().flatten().copied().min_by(f64::total_cmp);
        for (settings, samples) in [(&preview_settings, Some(4)), (&settings, None)] {
            panels.push(Panel::of(&study.render(&scene, settings, samples)?, &display).reduced(3));
        }
        save_grid(&study.directory.join(format!("raster-{name}.jpg")), &panels, panels.len() as u32)?;
        table.push([
            name.to_owned(),
            mesh.triangles.len().to_string(),
            format!("{mesh_seconds:.1}"),
            milliseconds(raster),
            milliseconds(best(&previews)),
            milliseconds(best(&paths)),
            device,
        ]);
        pictures += &format!("{figures}:\n\n![{name}](raster-{name}.jpg)\n\n");
    }
    table.save(study.directory, "raster")?;
    let [width, height] = size;
    let conditions = study.conditions(&format!(
        "{width}x{height}; mesh of {} cells along the longest side of each object; medians",
        study.plan.mesh_resolution
    ));
    Ok(format!(
        "## Rasterisation beside marching\n\nThe thesis left this comparison out. The same fields as triangle meshes through a \
         rasteriser, with the Phong shading of Figure 2.2: ambient light, then diffuse light, then highlights. Beside them \
         the preview, which marches and has shadows, occlusion and a reflection, and the path-traced picture. A mesh has to be \
         made first, and again after every edit; a field does not.\n\n{}\n{pictures}From the left: ambient light, \
         diffuse light, highlights, preview, path tracing.\n\n{conditions}",
        table.markdown()
    ))
}
