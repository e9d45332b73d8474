//! Path reuse: pixels share the light that their paths find at second surfaces (Bekaert, Sbert and Halton 2002,
//! "Accelerating Path Tracing by Re-Using Paths").
//!
//! **Idea.** Where the second surface of a path is Lambertian, the radiance that leaves it is the same in all directions.
//! So the camera hits of other pixels can be connected with it, at the price of a shadow ray each. A path is one of
//! those of a group of pixels in a tile of 8 by 8. Let pₘ be the density over area with which pixel m samples the second
//! surface of a path, zero if it is not visible, and fⱼ the BSDF of pixel j times both cosines over the square of the
//! distance. By the balance heuristic, pixel j receives of this path radiance x fⱼ / Σₘ pₘ. As its own density is in the
//! sum, no weight is larger than without sharing. Between Lambertian surfaces, fⱼ is albedoⱼ x pⱼ: the radiance is
//! distributed.
//!
//! **Groups.** A tile has four groups of sixteen pixels, one of each in every block of 2 by 2. So a pixel has other paths than its
//! neighbours, and the noise that a group has in common is fine and without a pattern. Random numbers are those of a picture
//! whose tiles have their pixels in another order ([`place_by_group`](crate::sampling::sobol::place_by_group)), so that a group
//! and its samples are one net of Sobol' points. With other groups in every sample the error would fall only as that of
//! independent samples.
//! [`path_reuse_choice`](super::path_reuse_choice) decides whether pixels share.

use super::path_state::Path;
use crate::intersect::march::march;
use crate::intersect::ray::{Ray, RaySegment};
use crate::sampling::basis::{basis, local_viewer};
use crate::sampling::sobol::interleaved_group;
use crate::scene::TraceContext;
use crate::scene::material::{DELTA, GLOWS, LAMBERTIAN, TRANSMITS};
use crate::shading::surface_interaction::SurfaceInteraction;
use crate::shading::textured_point::TexturedPoint;
use crate::wgsl::shared_constants;
use glam::{Mat3, Vec3};
use pathmarch_scene::materials::{Bsdf, BsdfParameters};
use std::collections::BTreeMap;
use std::ops::Range;

shared_constants! {
    /// Edge length of the tiles that groups are in, pixels.
    pub(super) const REUSE_TILE: u32 = 8;
    /// Pixels of a group: one of each block of 2 by 2 in a tile.
    const GROUP: u32 = 16;
}

/// Largest number of paths that share a camera ray in a kernel: the memory of a workgroup, 16 KiB, holds their second surfaces.
pub(crate) const MAX_SPLITTING: u32 = 4;

/// Camera hit of a pixel on an opaque surface that is no mirror.
#[derive(Clone, Copy)]
struct FirstSurface {
    p: Vec3,
    /// Origin of rays that leave the surface.
    origin: Vec3,
    bsdf: &'static Bsdf,
    parameters: BsdfParameters,
    /// Rotation from world space to the frame of the BSDF.
    local_from_world: Mat3,
    /// Unit vector to the camera in this frame.
    wo: Vec3,
    /// True if it is seen from the inside of the solid.
    inside: bool,
    /// Length of the path, metres.
    length: f32,
}

/// Connection of a camera hit with the second surface of a path.
#[derive(Clone, Copy, Default)]
struct Connection {
    /// Density over area with which the camera hit samples the second surface, 1/m².
    density: f32,
    /// BSDF times both cosines over the square of the distance, 1/m².
    value: Vec3,
}

/// Second surface of a path, Lambertian too.
#[derive(Clone, Copy)]
struct SecondSurface {
    p: Vec3,
    /// Origin of rays that leave the surface.
    origin: Vec3,
    /// Unit normal on the side of the first surface.
    normal: Vec3,
    /// Radiance of the path without that which leaves this surface.
    radiance: Vec3,
}

/// Pixels that share their paths.
#[derive(Default)]
struct Group {
    /// Pixels with a first surface.
    pixels: Vec<usize>,
    /// Paths of these pixels with a second surface.
    paths: Vec<usize>,
}

/// Surfaces of the paths of a set of pixels, being recorded.
pub(super) struct PathReuse<'a> {
    pixels: &'a [(u32, u32)],
    /// Paths of a pixel.
    samples: usize,
    /// For each pixel.
    first: Vec<Option<FirstSurface>>,
    /// For each path.
    second: Vec<Option<SecondSurface>>,
}

impl<'a> PathReuse<'a> {
    pub(super) fn new(pixels: &'a [(u32, u32)], samples: u32) -> Self {
        let paths = pixels.len() * samples as usize;
        Self { pixels, samples: samples as usize, first: vec![None; pixels.len()], second: vec![None; paths] }
    }

    /// Records the first or second surface of a path with this radiance before it is shaded. Returns true at the second one, from
    /// where on the path has the radiance that leaves this surface.
    pub(super) fn record(
        &mut self,
        ctx: &TraceContext,
        path: &Path,
        interaction: &SurfaceInteraction,
        surface_index: u32,
        radiance: Vec3,
    ) -> bool {
        let leaf = &ctx.scene.leaves[interaction.leaf];
        let material = &ctx.scene.materials[leaf.material as usize];
        if surface_index > ctx.frame.bounces {
            return false;
        }
        let &SurfaceInteraction { p, normal, normal_offset, inside, .. } = interaction;
        let origin = p + normal_offset;
        let pixel = path.slot / self.samples;
        if surface_index > 0 {
            let is_shared = self.first[pixel].is_some() && material.has(LAMBERTIAN) && !material.has(GLOWS);
            if is_shared {
                self.second[path.slot] = Some(SecondSurface { p, origin, normal, radiance });
            }
            return is_shared;
        }
        let Some(bsdf) = ctx.scene.bsdfs[leaf.material as usize] else { return false };
        let is_rough = !material.has(DELTA) && !material.has(TRANSMITS);
        if is_rough && path.medium.absorption == Vec3::ZERO && self.first[pixel].is_none() {
            let textured = TexturedPoint::new(ctx, interaction, path.length);
            let textured = textured.map(|textured| textured.parameters(&material.parameters));
            let local_from_world = basis(normal).transpose();
            self.first[pixel] = Some(FirstSurface {
                p,
                origin,
                bsdf,
                parameters: textured.unwrap_or(material.parameters),
                local_from_world,
                wo: local_viewer(local_from_world, -path.ray.direction),
                inside,
                length: path.length,
            });
        }
        false
    }

    /// Groups of pixels, with the paths that they share.
    fn groups(&self) -> Vec<Group> {
        let mut groups: BTreeMap<[u32; 4], Group> = BTreeMap::new();
        for (pixel, &(x, y)) in self.pixels.iter().enumerate().filter(|(pixel, _)| self.first[*pixel].is_some()) {
            let group = groups.entry(group_of(x, y)).or_default();
            group.pixels.push(pixel);
            group.paths.extend(self.paths_of(pixel).filter(|path| self.second[*path].is_some()));
        }
        groups.into_values().collect()
    }

    /// Shares the radiance that leaves the second surfaces among the paths of each group. Returns what each path has of it.
    pub(super) fn share(&self, ctx: &TraceContext, radiance: &mut [Vec3]) -> Vec<Vec3> {
        let groups = self.groups();
        // Of each pixel with the paths of its group, without visibility.
        let mut connections = Vec::new();
        let mut segments = Vec::new();
        for Group { pixels, paths } in &groups {
            for &pixel in pixels {
                let Some(first) = &self.first[pixel] else { continue };
                for &path in paths {
                    let Some(second) = &self.second[path] else { continue };
                    let connection = connection(first, second);
                    if connection.density > 0.0 && !self.paths_of(pixel).contains(&path) {
                        let offset = second.origin - first.origin;
                        let distance = offset.length();
                        let ray = Ray { origin: first.origin, direction: offset / distance };
                        segments.push(RaySegment { ray, path_length: first.length, limit: distance });
                    }
                    connections.push(connection);
                }
            }
        }
        let mut hits = march(ctx, &segments).into_iter();
        let mut connections = connections.into_iter();
        let mut shared_radiance = vec![Vec3::ZERO; radiance.len()];
        for Group { pixels, paths } in &groups {
            let mut seen = Vec::with_capacity(pixels.len() * paths.len());
            for &pixel in pixels {
                for path in paths {
                    let connection = connections.next().unwrap_or_default();
                    // A path sees its own second surface.
                    let is_seen = connection.density > 0.0
                        && (self.paths_of(pixel).contains(path) || hits.next().is_some_and(|hit| hit.is_none()));
                    seen.push(if is_seen { connection } else { Connection::default() });
                }
            }
            let mut shared = vec![Vec3::ZERO; pixels.len()];
            for (k, &path) in paths.iter().enumerate() {
                let column = || seen[k..].iter().step_by(paths.len());
                let total: f32 = column().map(|connection| connection.density).sum();
                if total > 0.0 {
                    for (sum, connection) in shared.iter_mut().zip(column()) {
                        *sum += radiance[path] * (connection.value / total);
                    }
                }
            }
            for (&pixel, shared) in pixels.iter().zip(shared) {
                let (shared, paths) = (shared / self.samples as f32, self.paths_of(pixel));
                shared_radiance[paths.clone()].fill(shared);
                for (radiance, second) in radiance[paths.clone()].iter_mut().zip(&self.second[paths]) {
                    *radiance = second.map_or(*radiance, |second| second.radiance) + shared;
                }
            }
        }
        shared_radiance
    }

    /// Paths of a pixel.
    fn paths_of(&self, pixel: usize) -> Range<usize> {
        pixel * self.samples..(pixel + 1) * self.samples
    }
}

/// Connection of a camera hit with a second surface that it sees.
fn connection(first: &FirstSurface, second: &SecondSurface) -> Connection {
    let offset = second.p - first.p;
    let square = offset.length_squared();
    let direction = offset / square.sqrt();
    let wi = first.local_from_world * direction;
    let cosine = -direction.dot(second.normal);
    if square == 0.0 || wi.z <= 0.0 || cosine <= 0.0 {
        return Connection::default();
    }
    let evaluated = (first.bsdf.eval)(&first.parameters, first.wo, wi, first.inside);
    let solid_angle_per_area = cosine / square;
    Connection { density: evaluated.pdf * solid_angle_per_area, value: evaluated.value * solid_angle_per_area }
}

/// Tile of a pixel, and its group in the tile.
fn group_of(x: u32, y: u32) -> [u32; 4] {
    let [group_x, group_y] = interleaved_group(x, y);
    [x / REUSE_TILE, y / REUSE_TILE, group_x, group_y]
}
