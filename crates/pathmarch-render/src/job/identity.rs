//! Identity of the films of a job.

use super::{Job, Shutter};
use crate::output::parts::Identity;
use crate::scene_hash;
use pathmarch_scene::textures::Pattern;
use pathmarch_scene::{Material, Scene};
use sha2::{Digest, Sha256};

/// Hash of all that a scene has read: its text, included files, objects as they are at its moment, and pictures.
fn contents_hash(scene: &Scene) -> String {
    let mut hash = Sha256::new();
    hash.update(scene_hash(scene).as_bytes());
    scene.includes.iter().filter_map(|file| std::fs::read(file).ok()).for_each(|bytes| hash.update(bytes));
    hash.update(format!("{:?}{:?}", scene.objects, scene.lights).as_bytes());
    for material in &scene.materials {
        let Material { name, kind, values, orbit_trap, textured, decals, bump, normal_map, emission_texture } =
            material;
        hash.update(format!("{name:?}{}{values:?}{orbit_trap:?}{textured:?}{bump:?}", kind.name).as_bytes());
        hash.update(format!("{normal_map:?}{emission_texture:?}{decals:?}").as_bytes());
    }
    let decals = scene.materials.iter().flat_map(|material| &material.decals);
    decals.for_each(|decal| hash.update(bytemuck::cast_slice(&decal.picture.texels)));
    let textures = scene.materials.iter().flat_map(|material| &material.textured).map(|textured| &textured.texture);
    let bumps = scene.materials.iter().filter_map(|material| material.bump.as_ref()).map(|bump| &bump.texture);
    let normal_maps =
        scene.materials.iter().filter_map(|material| material.normal_map.as_ref()).map(|map| &map.texture);
    let emissions = scene.materials.iter().filter_map(|material| material.emission_texture.as_ref());
    for texture in textures.chain(bumps).chain(normal_maps).chain(emissions) {
        if let Pattern::Picture { picture, .. } | Pattern::UvPicture { picture, .. } = &texture.pattern {
            hash.update(bytemuck::cast_slice(&picture.texels));
        }
    }
    for mesh in scene.field.leaves().iter().filter(|leaf| leaf.slot == 0).filter_map(|leaf| leaf.shape.mesh()) {
        let mesh = mesh.surface().mesh();
        mesh.positions.iter().for_each(|p| hash.update(bytemuck::cast_slice(&p.to_array())));
        hash.update(bytemuck::cast_slice(mesh.triangles.as_flattened()));
    }
    hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}

impl Job {
    /// What its film shows: two films with the same identity have samples of the same picture.
    pub fn identity(&self, scene: &Scene, shutter: Shutter) -> Identity {
        let settings = &self.settings;
        let [width, height] = settings.size;
        let shutter = if shutter.blurs(scene, settings) { shutter.seconds } else { 0.0 };
        Identity::new([
            ("version", env!("CARGO_PKG_VERSION").to_owned()),
            ("scene", contents_hash(scene)),
            ("time", format!("{:?}", scene.moment)),
            ("shutter", shutter.to_string()),
            ("camera", format!("{:?}", settings.camera_of(scene))),
            ("size", format!("{width}x{height}")),
            ("mode", settings.mode.name().to_owned()),
            ("preview steps", format!("{:?}", settings.preview_steps)),
            ("bounces", settings.bounces.to_string()),
            ("seed", settings.seed.to_string()),
            ("sampler", format!("{:?}", settings.sampler)),
            ("caustics", format!("{:?}", settings.caustics)),
            ("clamp", format!("{:?}", settings.clamp)),
            ("detail", settings.detail.to_string()),
            ("direct lighting", format!("{:?}", settings.direct_lighting)),
            ("splitting", self.splitting().to_string()),
            ("path reuse", self.reuses_paths().to_string()),
        ])
    }

    /// Backend and adapter, as films record them; on the CPU, the instructions that the program was built for.
    pub fn engine(&self) -> String {
        let backend = self.backend();
        if backend.name != "CPU" {
            return format!("{}: {}", backend.name, backend.adapter);
        }
        let features = [
            ("avx", cfg!(target_feature = "avx")),
            ("avx2", cfg!(target_feature = "avx2")),
            ("fma", cfg!(target_feature = "fma")),
            ("avx512", cfg!(target_feature = "avx512f")),
        ];
        let names: Vec<&str> = features.iter().filter(|(_, built)| *built).map(|(name, _)| *name).collect();
        format!("CPU: {} {} {}", std::env::consts::OS, std::env::consts::ARCH, names.join(" ")).trim_end().to_owned()
    }
}
