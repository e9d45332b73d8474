//! Marching with fixed steps against sphere tracing: Figures 2.9 and 2.10 of the thesis, measured.

use super::picture_grid::{Panel, save as save_grid};
use super::table::Table;
use super::{Study, example};
use pathmarch_cli::Failure;
use pathmarch_render::image::Picture;
use pathmarch_render::pathmarch_field::Field;
use pathmarch_render::pathmarch_field::number::Vec3 as FieldVec3;
use pathmarch_render::pathmarch_scene::Camera;
use pathmarch_render::tonemap::Display;

/// Distance at which a ray has hit, metres.
const EPSILON: f32 = 1e-3;
/// Distance beyond which a ray is lost, metres.
const FAR: f32 = 40.0;
/// Most evaluations of a ray by sphere tracing.
const MAX_STEPS: u32 = 2048;
const SCENE: &str = "solids";

/// How far a ray goes between evaluations.
#[derive(Clone, Copy)]
enum Step {
    /// The same distance each time, metres.
    Fixed(f32),
    /// The distance to the nearest surface.
    Sphere,
}

/// A ray that was marched.
#[derive(Clone, Copy)]
struct Marched {
    t: Option<f32>,
    evaluations: u32,
}

fn distance(field: &Field, p: [f32; 3]) -> f32 {
    field.distance(FieldVec3::new(p[0], p[1], p[2]))
}

fn march(field: &Field, origin: [f32; 3], direction: [f32; 3], step: Step) -> Marched {
    let mut t = 0.0;
    for evaluations in 1..=MAX_STEPS {
        let near = distance(field, std::array::from_fn(|k| origin[k] + t * direction[k]));
        if near < EPSILON {
            return Marched { t: Some(t), evaluations };
        }
        t += match step {
            Step::Fixed(length) => length,
            Step::Sphere => near,
        };
        if t > FAR {
            return Marched { t: None, evaluations };
        }
    }
    Marched { t: None, evaluations: MAX_STEPS }
}

/// Directions through the centres of pixels, the top row first.
fn directions(camera: &Camera, [width, height]: [u32; 2]) -> Vec<[f32; 3]> {
    let unit = |v: [f32; 3]| {
        let length = v.iter().map(|v| v * v).sum::<f32>().sqrt();
        v.map(|v| v / length)
    };
    let cross =
        |a: [f32; 3], b: [f32; 3]| [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let front = unit(std::array::from_fn(|k| camera.target[k] - camera.position[k]));
    let right = unit(cross(front, camera.up));
    let up = cross(right, front);
    let scale = (camera.fov.to_radians() / 2.0).tan() * 2.0 / height as f32;
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    pixels
        .map(|(x, y)| {
            let (a, b) =
                (scale * (x as f32 + 0.5 - width as f32 / 2.0), scale * (height as f32 / 2.0 - y as f32 - 0.5));
            unit(std::array::from_fn(|k| front[k] + a * right[k] + b * up[k]))
        })
        .collect()
}

/// Light from above and the left on the surface that each ray found; black where none was found.
fn lit(field: &Field, origin: [f32; 3], rays: &[([f32; 3], Marched)], [width, height]: [u32; 2]) -> Picture {
    let shade = |(direction, marched): &([f32; 3], Marched)| {
        let Some(t) = marched.t else { return [0.0; 3] };
        let p: [f32; 3] = std::array::from_fn(|k| origin[k] + t * direction[k]);
        let slope: [f32; 3] = std::array::from_fn(|axis| {
            let shifted = |sign: f32| std::array::from_fn(|k| p[k] + if k == axis { sign * 1e-3 } else { 0.0 });
            distance(field, shifted(1.0)) - distance(field, shifted(-1.0))
        });
        let length = slope.iter().map(|v| v * v).sum::<f32>().sqrt().max(1e-9);
        let cosine = (slope[0] * -0.45 + slope[1] * 0.8 + slope[2] * 0.4) / length;
        [0.15 + 0.75 * cosine.max(0.0); 3]
    };
    Picture { width, height, pixels: rays.iter().map(shade).collect() }
}

pub fn study(study: &mut Study) -> Result<String, Failure> {
    let scene = example(SCENE)?;
    let size = study.plan.marching_size;
    let camera = &scene.cameras[0];
    let directions = directions(camera, size);
    let trace = |step: Step| -> Vec<([f32; 3], Marched)> {
        directions
            .iter()
            .map(|direction| (*direction, march(&scene.field, camera.position, *direction, step)))
            .collect()
    };
    study.log("marching: sphere tracing");
    let truth = trace(Step::Sphere);
    let steps: &[(&str, Step)] = &[
        ("fixed steps of 0.8 m", Step::Fixed(0.8)),
        ("fixed steps of 0.2 m", Step::Fixed(0.2)),
        ("fixed steps of 0.05 m", Step::Fixed(0.05)),
        ("sphere tracing", Step::Sphere),
    ];
    let mut table = Table::new(["march", "evaluations a ray", "hits lost", "mean error of the depth, m"]);
    let mut panels = Vec::new();
    for (name, step) in steps {
        study.interrupt.check()?;
        study.log(&format!("marching: {name}"));
        let rays = trace(*step);
        let evaluations: f64 = rays.iter().map(|(_, ray)| f64::from(ray.evaluations)).sum::<f64>() / rays.len() as f64;
        let (mut hits, mut lost, mut errors) = (0u32, 0u32, Vec::new());
        for ((_, ray), (_, truth)) in rays.iter().zip(&truth) {
            let Some(expected) = truth.t else { continue };
            hits += 1;
            // A ray that went through a solid and hit another one behind it has lost the first.
            match ray.t {
                Some(t) if (t - expected).abs() < 1.0 => errors.push(f64::from((t - expected).abs())),
                _ => lost += 1,
            }
        }
        let mean = errors.iter().sum::<f64>() / errors.len().max(1) as f64;
        table.push([
            (*name).to_owned(),
            format!("{evaluations:.1}"),
            format!("{:.1} %", 100.0 * f64::from(lost) / f64::from(hits.max(1))),
            format!("{mean:.3}"),
        ]);
        panels.push(Panel::of(&lit(&scene.field, camera.position, &rays, size), &Display::default()));
    }
    save_grid(&study.directory.join("marching.jpg"), &panels, 2)?;
    table.save(study.directory, "marching")?;
    let [width, height] = size;
    Ok(format!(
        "## Fixed steps against sphere tracing\n\nFigures 2.9 and 2.10 (pages 30 and 31) draw why a march of fixed steps fails: \
         short steps waste evaluations, and long ones pass through what is thin. Measured on the camera rays of `{SCENE}`, \
         {width}x{height}; a ray hits within 1 mm of a surface, or inside it.\n\n{}\nFrom the left and the top: steps of \
         0.8, 0.2 and 0.05 m, and sphere tracing.\n\n![Fixed steps and sphere tracing](marching.jpg)\n",
        table.markdown()
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use pathmarch_render::pathmarch_scene::Scene;

    #[test]
    fn fixed_steps_pass_through_thin_walls_and_sphere_tracing_does_not() {
        let text = "pathmarch 1\ncamera { position 0 0 5; target 0 0 0 }\nsky 1\nobject \"wall\" { box 2 2 0.01 }";
        let scene = Scene::parse("test.kdl", text).expect("a scene");
        let ray = |step| march(&scene.field, [0.0, 0.0, 5.0], [0.0, 0.0, -1.0], step);
        assert!(ray(Step::Fixed(0.3)).t.is_none());
        let hit = ray(Step::Sphere);
        assert!(hit.t.is_some_and(|t| (t - 4.995).abs() < 2e-3) && hit.evaluations < 12);
    }

    #[test]
    fn the_middle_ray_goes_to_the_target() {
        let text = "pathmarch 1\ncamera { position 1 2 3; target 0 0.5 0 }\nsky 1\nobject \"ball\" { sphere }";
        let scene = Scene::parse("test.kdl", text).expect("a scene");
        let middle = directions(&scene.cameras[0], [3, 3])[4];
        let expected: [f32; 3] = [-1.0, -1.5, -3.0];
        let length = expected.iter().map(|v| v * v).sum::<f32>().sqrt();
        assert!((0..3).all(|k| (middle[k] - expected[k] / length).abs() < 1e-6));
    }
}
