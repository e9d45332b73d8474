//! Light that media in front of the first surface scatter or emit, recorded apart with the guide of the path.
//!
//! **Idea.** Such light does not move with the surface behind it. It is that of the first segment of the path, and all that
//! comes after a scattering event there. Its distance is that of the scattering events from the camera, weighted by their
//! luminance.

use super::reflected_light::ReflectedLight;
use crate::scene::light::luminance;
use crate::wgsl::shared_constants;
use glam::Vec3;
use pathmarch_field::number::Real;

shared_constants! {
    /// Alpha of light that media scatter, in place of that of facets.
    pub(crate) const MEDIUM_ALPHA: f32 = 1.0;
    /// Distance from the camera whose depth in a medium is a half, in the far ends of all rays: half of the size of the scene.
    const MEDIUM_SCALE: f32 = 2.5e-4;
    /// Difference between the depths of surfaces in a medium at which they share no light of it.
    pub(crate) const MEDIUM_REACH: f32 = 0.03;
}

/// Depth of a medium at a distance from the camera, 0 to 1.
pub(crate) fn depth_in_medium(distance: f32, far: f32) -> f32 {
    distance / (distance + MEDIUM_SCALE * far)
}

/// Inverse of [`depth_in_medium`].
pub(crate) fn distance_in_medium<N: Real>(depth: N, far: f32) -> N {
    N::constant(MEDIUM_SCALE * far) * depth / (N::one() - depth)
}

/// Light being recorded, one for each path; empty in scenes without media.
pub(super) struct MediumLightRecorder {
    slots: Vec<Option<MediumLight>>,
}

/// Light of the media on the first segments of a path.
#[derive(Clone, Copy, Default)]
struct MediumLight {
    radiance: Vec3,
    /// Sum of its luminance, and of the distances from the camera times that, metres.
    weight: f32,
    weighted_distance: f32,
    /// Distance of the last light sample.
    sampled_distance: f32,
    /// Distance of the scattering event that ends the segment, and the radiance before it.
    event: Option<(f32, Vec3)>,
}

impl MediumLight {
    fn add(&mut self, light: Vec3, distance: f32) {
        let weight = luminance(light.into()).max(0.0);
        self.radiance += light;
        self.weight += weight;
        self.weighted_distance += weight * distance;
    }
}

impl MediumLightRecorder {
    pub(super) fn new(paths: usize) -> Self {
        Self { slots: vec![None; paths] }
    }

    /// True if the path in a slot has passed through a medium that scatters or emits light.
    pub(super) fn has_passed(&self, slot: usize) -> bool {
        self.slots.get(slot).is_some_and(Option::is_some)
    }

    /// Records that a path passes through a medium, which emits this light at a distance from the camera.
    pub(super) fn pass(&mut self, slot: usize, emitted: Vec3, distance: f32) {
        self.slots[slot].get_or_insert_default().add(emitted, distance);
    }

    /// Records the distance from the camera at which light is sampled.
    pub(super) fn sample_light(&mut self, slot: usize, distance: f32) {
        if let Some(light) = &mut self.slots[slot] {
            light.sampled_distance = distance;
        }
    }

    /// Adds light that a sampled light contributed.
    pub(super) fn add_sampled(&mut self, slot: usize, light: Vec3) {
        if let Some(recorded) = &mut self.slots[slot] {
            recorded.add(light, recorded.sampled_distance);
        }
    }

    /// Records the scattering event of a path at a distance from the camera, which has this radiance before.
    pub(super) fn scatter(&mut self, slot: usize, distance: f32, radiance: Vec3) {
        if let Some(light) = &mut self.slots[slot] {
            light.event = Some((distance, radiance));
        }
    }

    /// Lights of all paths that have passed through media, and whose radiances these are.
    pub(super) fn into_lights(self, radiance: &[Vec3], far: f32) -> impl Iterator<Item = (usize, ReflectedLight)> {
        let of = move |(slot, light): (usize, Option<MediumLight>)| {
            let mut light = light?;
            if let Some((distance, before)) = light.event {
                light.add(radiance[slot] - before, distance);
            }
            let depth = depth_in_medium(light.weighted_distance / light.weight.max(f32::MIN_POSITIVE), far);
            let radiance = light.radiance;
            Some((slot, ReflectedLight { radiance, square: 0.0, depth, alpha: MEDIUM_ALPHA, is_coloured: false }))
        };
        self.slots.into_iter().enumerate().filter_map(of)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::backend::RenderInput;
    use crate::integrator::guides::Guide;
    use crate::settings::Settings;
    use pathmarch_scene::Scene;

    /// Radiances and guides of a sample of each pixel.
    fn sampled(text: &str) -> (RenderInput, Vec<(Vec3, Guide)>) {
        let scene = Scene::parse("test.kdl", &format!("pathmarch 1\n{text}")).expect("a scene");
        let input = RenderInput::new(&scene, &Settings { size: [24, 24], ..Settings::of(&scene) });
        let pixels: Vec<(u32, u32)> = (0..576).map(|index| (index % 24, index / 24)).collect();
        let (radiance, guides) = input.sample_with_guides(&input.context(None), &pixels, 0);
        (input, radiance.into_iter().zip(guides).collect())
    }

    #[test]
    fn depths_are_those_of_distances() {
        for distance in [0.01, 0.5, 3.0, 200.0] {
            let depth = depth_in_medium(distance, 4e4);
            assert!((0.0..1.0).contains(&depth) && (distance_in_medium(depth, 4e4) / distance - 1.0).abs() < 1e-3);
        }
    }

    #[test]
    fn light_of_fog_before_a_black_wall_is_all_its_own() {
        let (input, samples) = sampled(
            "camera { position 0 0 5; target 0 0 0; fov 20 }\nsky 0\nfog { scatter 0.2 }\n\
             point { at 0 3 2; intensity 9 }\nmaterial \"black\" { diffuse 0 }\n\
             object \"wall\" material=\"black\" { rect 9 { normal 0 0 1 } }",
        );
        let lit = samples.iter().filter(|(radiance, _)| radiance.max_element() > 0.0);
        let mut count = 0;
        for (radiance, guide) in lit {
            assert!(guide.has_medium() && !guide.has_facets());
            assert!((guide.reflected.radiance - radiance).length() <= 1e-5 * radiance.length(), "{guide:?}");
            let distance = distance_in_medium(guide.reflected.depth, input.frame.far);
            assert!(distance > 0.0 && distance < 5.2, "{distance}");
            count += 1;
        }
        assert!(count > 500, "{count}");
    }

    #[test]
    fn light_of_a_wall_behind_a_cloud_is_not_its_own() {
        let (_, samples) = sampled(
            "camera { position 0 0 5; target 0 0 0; fov 20 }\nsky 1\nmaterial \"cloud\" { medium 0; absorb 1 }\n\
             object \"wall\" { rect 9 { normal 0 0 1 } }\nobject \"cloud\" material=\"cloud\" { sphere 0.4 { at 0 0 2 } }",
        );
        // It absorbs, and neither scatters nor emits.
        assert!(samples.iter().all(|(_, guide)| !guide.has_medium() && guide.reflected.radiance == Vec3::ZERO));
        // The wall is where it is, behind the boundary as well.
        assert!(samples.iter().all(|(_, guide)| guide.position.z.abs() < 1e-3), "{:?}", samples[300].1);
    }

    #[test]
    fn surfaces_behind_smoke_are_known() {
        let (_, samples) = sampled(
            "camera { position 0 0 5; target 0 0 0; fov 5 }\nsky 1\nmaterial \"smoke\" { medium 2 }\n\
             object \"wall\" { rect 9 { normal 0 0 1 } }\nobject \"near\" material=\"smoke\" { sphere 0.5 { at 0 0 3 } }\n\
             object \"far\" material=\"smoke\" { sphere 0.5 { at 0 0 1 } }",
        );
        let scattered = samples.iter().filter(|(radiance, guide)| guide.reflected.radiance == *radiance).count();
        assert!((100..570).contains(&scattered), "{scattered}");
        assert!(samples.iter().all(|(_, guide)| guide.has_medium() && guide.position.z.abs() < 1e-3));
    }
}
