//! The other figures of the thesis that its program rendered, again: chapters 1 to 5, without diagrams.

use super::picture_grid::{Panel, save as save_grid};
use super::table::Table;
use super::{Study, example};
use pathmarch_cli::Failure;
use pathmarch_render::image::Picture;
use pathmarch_render::metrics::relmse;
use pathmarch_render::pathmarch_scene::{DirectLighting, Light, Moment, Sampler, Scene};
use pathmarch_render::reconstruct::{ReconstructOptions, Sequence};
use pathmarch_render::tonemap::Display;
use pathmarch_render::{Mode, PreviewStep, PreviewSteps, Settings};
use std::sync::Arc;

/// One panel of a figure.
struct Shot {
    scene: &'static str,
    change: fn(&mut Settings),
    /// Samples; `None` for the time of the page's pictures.
    samples: Option<u32>,
}

/// A figure: number, page, caption, panels.
struct Figure {
    number: &'static str,
    page: u32,
    caption: &'static str,
    columns: u32,
    shots: &'static [Shot],
}

const fn shot(scene: &'static str) -> Shot {
    Shot { scene, change: |_| {}, samples: None }
}

const fn samples(scene: &'static str, samples: u32) -> Shot {
    Shot { scene, change: plain_paths, samples: Some(samples) }
}

/// Paths as in the thesis: each has a camera ray of its own, and shares nothing.
fn plain_paths(settings: &mut Settings) {
    (settings.splitting, settings.path_reuse) = (Some(1), Some(false));
}

/// Preview with the first steps in the order of the thesis.
fn first_steps(settings: &mut Settings, count: usize) {
    settings.mode = Mode::Preview;
    settings.preview_steps =
        PreviewStep::ALL[count..].iter().fold(PreviewSteps::default(), |steps, step| steps.without(*step));
}

macro_rules! steps {
    ($count:literal) => {
        Shot { scene: "solids", change: |settings| first_steps(settings, $count), samples: Some(4) }
    };
}

static FIGURES: &[Figure] = &[
    Figure {
        number: "1.2",
        page: 18,
        caption: "A colourful mandelbulb: orbit traps.",
        columns: 1,
        shots: &[shot("mandelbulb")],
    },
    Figure {
        number: "2.6",
        page: 27,
        caption: "Two cubes, diffuse and specular.",
        columns: 1,
        shots: &[shot("two-cubes")],
    },
    Figure {
        number: "2.8",
        page: 29,
        caption: "1, 4 and 16 samples. The thesis shows Cycles here; these are ours.",
        columns: 3,
        shots: &[samples("open-room", 1), samples("open-room", 4), samples("open-room", 16)],
    },
    Figure {
        number: "2.11",
        page: 32,
        caption: "Repetition without end of a cube, and a fractal; which one the thesis shows is not said.",
        columns: 2,
        shots: &[shot("cubes"), shot("cream-julia")],
    },
    Figure {
        number: "3.6",
        page: 39,
        caption: "Marched shading step by step: albedo, diffuse light, specular highlights.",
        columns: 3,
        shots: &[steps!(1), steps!(2), steps!(3)],
    },
    Figure {
        number: "3.7",
        page: 40,
        caption: "The next steps: soft shadows, ambient occlusion, one reflection.",
        columns: 3,
        shots: &[steps!(4), steps!(5), steps!(6)],
    },
    Figure {
        number: "4.5",
        page: 47,
        caption: "1, 8 and 16 samples of one scene.",
        columns: 3,
        shots: &[
            samples("metal-room-rough-50", 1),
            samples("metal-room-rough-50", 8),
            samples("metal-room-rough-50", 16),
        ],
    },
    Figure { number: "4.6", page: 48, caption: "Solids.", columns: 1, shots: &[shot("solids")] },
    Figure {
        number: "4.7",
        page: 49,
        caption: "Combinations of a box and a sphere.",
        columns: 1,
        shots: &[shot("combinations")],
    },
    Figure {
        number: "4.8",
        page: 50,
        caption: "3 against 8 hits: light gathers. (The caption in the thesis says samples, its text bounces.)",
        columns: 2,
        shots: &[
            Shot { scene: "open-room", change: |settings| settings.bounces = 2, samples: None },
            Shot { scene: "open-room", change: |settings| settings.bounces = 7, samples: None },
        ],
    },
    Figure {
        number: "4.9",
        page: 50,
        caption: "One sample of independent random numbers, and of ours: Sobol' points whose error is blue noise.",
        columns: 2,
        shots: &[
            Shot {
                scene: "diffuse-sphere",
                change: |settings| {
                    settings.sampler = Sampler::Independent;
                    plain_paths(settings);
                },
                samples: Some(1),
            },
            samples("diffuse-sphere", 1),
        ],
    },
    Figure {
        number: "4.11",
        page: 52,
        caption: "One frame, and 20 accumulated.",
        columns: 2,
        shots: &[samples("three-spheres", 1), samples("three-spheres", 20)],
    },
    Figure { number: "4.13", page: 53, caption: "An emissive green sphere.", columns: 1, shots: &[shot("green-lamp")] },
    Figure {
        number: "4.14",
        page: 54,
        caption: "16 samples: the lamp met by chance alone, and next-event estimation.",
        columns: 2,
        shots: &[
            Shot {
                scene: "green-lamp",
                change: |settings| settings.direct_lighting = DirectLighting::BsdfSampling,
                samples: Some(16),
            },
            Shot { scene: "green-lamp", change: |_| {}, samples: Some(16) },
        ],
    },
    Figure {
        number: "4.15",
        page: 55,
        caption: "One sample with next-event estimation: what the light reaches is nearly clean.",
        columns: 1,
        shots: &[samples("metal-room-rough-50", 1)],
    },
    Figure {
        number: "5.4",
        page: 60,
        caption: "Fractals.",
        columns: 3,
        shots: &[shot("mandelbulb-landscape"), shot("inside-mandelbox"), shot("cream-julia")],
    },
    Figure { number: "5.17", page: 70, caption: "Orbit traps.", columns: 1, shots: &[shot("orbit-traps")] },
];

/// Panels of a figure in a common size.
fn panel(study: &mut Study, shot: &Shot, columns: u32) -> Result<Panel, Failure> {
    let scene = example(shot.scene)?;
    let mut settings = Settings { size: study.plan.size, ..Settings::of(&scene) };
    (shot.change)(&mut settings);
    let picture = study.render(&scene, &settings, shot.samples)?;
    let display = Display { tonemap: scene.render.tonemap, exposure_stops: settings.camera_of(&scene).exposure };
    Ok(Panel::of(&picture, &display).reduced(columns))
}

/// Figure 4.12: a ball that moves, after 20 frames of one sample: their mean, the blend of a fixed weight, ours, and the
/// converged picture.
fn moving(study: &mut Study) -> Result<String, Failure> {
    const FRAMES: u32 = 20;
    let size = study.plan.error_size;
    let mut animation = pathmarch_render::pathmarch_scene::Animation::new("moving.kdl", MOVING.to_owned());
    let mut sequence = Sequence::new(&study.renderers[0], ReconstructOptions::default());
    let mut mean = Picture::new(size[0], size[1]);
    let mut last = None;
    for number in 0..FRAMES {
        study.interrupt.check()?;
        let scene = Arc::new(animation.at(Moment::of_frame(number, 24.0))?);
        let settings = Settings { size, samples: 1, seed: number, ..Settings::of(&scene) };
        let frame = sequence.render(&scene, &settings).map_err(Failure::other)?;
        for (sum, value) in mean.pixels.iter_mut().zip(&frame.noisy.pixels) {
            *sum = std::array::from_fn(|k| sum[k] + value[k] / FRAMES as f32);
        }
        last = Some((scene, settings, frame));
    }
    let Some((scene, settings, frame)) = last else { return Ok(String::new()) };
    let reference = study.render(&scene, &Settings { seed: 1000, ..settings }, None)?;
    let display = Display { tonemap: scene.render.tonemap, exposure_stops: scene.cameras[0].exposure };
    let pictures = [&mean, &frame.reconstructed, &reference];
    let panels = pictures.map(|picture| Panel::of(picture, &display));
    save_grid(&study.directory.join("figure-4-12.jpg"), &panels, 3)?;
    let error = |picture: &Picture| relmse(picture, &reference).map_err(Failure::other);
    Ok(format!(
        "**Figure 4.12** (page 52). A moving ball after {FRAMES} frames of one sample: their mean, as the thesis accumulates \
         (relMSE {:.1e}); our reconstruction ({:.1e}); the converged picture.\n\n![Figure 4.12](figure-4-12.jpg)\n\n",
        error(&mean)?,
        error(&frame.reconstructed)?
    ))
}

const MOVING: &str = r#"pathmarch 1
camera { position 0 1.6 4; target 0 0.4 0 }
render { bounces 3 }
sky "gradient" { zenith 0.3 0.45 0.7; horizon 0.8 0.85 0.9 }
sun { direction 1 2 1; irradiance 2; angle 3 }
material "checker" { diffuse { checker size=0.4 { colour 0.1; colour 0.8 } } }
material "red" { diffuse 0.7 0.15 0.1 }
object "ground" material="checker" { plane }
object "ball" material="red" { sphere 0.5 { at "1.6*t - 0.9" 0.5 0 } }
"#;

/// Figure 5.7: soft shadows by near misses, with their cost on each backend.
fn soft_shadows(study: &mut Study) -> Result<String, Failure> {
    let soft = example("soft-shadows")?;
    let harden = |light: &Light| match *light {
        Light::Sun { direction, irradiance, angle, .. } => Light::Sun { direction, irradiance, angle, penumbra: None },
        Light::Point { at, intensity, .. } => Light::Point { at, intensity, penumbra: None },
        spot @ Light::Spot { .. } => spot,
    };
    let hard = Scene { lights: soft.lights.iter().map(harden).collect(), ..soft.clone() };
    let mut panels = Vec::new();
    let mut times = Vec::new();
    for scene in [&hard, &soft] {
        let settings = Settings { size: study.plan.size, ..Settings::of(scene) };
        times.push(study.time_view(scene, &settings, super::tables::BOUNCES)?);
        let picture = study.render(scene, &settings, None)?;
        let display = Display { tonemap: scene.render.tonemap, exposure_stops: scene.cameras[0].exposure };
        panels.push(Panel::of(&picture, &display).reduced(2));
    }
    save_grid(&study.directory.join("figure-5-7.jpg"), &panels, 2)?;
    let mut table = Table::new(["backend", "hard, ms/sample", "soft, ms/sample", "cost"]);
    for ((backend, hard), soft) in study.backends().into_iter().zip(&times[0]).zip(&times[1]) {
        let cost =
            hard.zip(*soft).map_or("-".to_owned(), |(hard, soft)| format!("{:+.0} %", 100.0 * (soft / hard - 1.0)));
        table.push([backend, super::table::milliseconds(*hard), super::table::milliseconds(*soft), cost]);
    }
    table.save(study.directory, "soft-shadows")?;
    Ok(format!(
        "**Figure 5.7** (page 63). A point light with hard shadows, and with `penumbra`: soft shadows by the near misses of \
         the march, which cost 12 % in the thesis. Here they cost more, because their shadow rays march, and hard ones \
         intersect the solids in closed form.\n\n![Figure 5.7](figure-5-7.jpg)\n\n{}\n",
        table.markdown()
    ))
}

pub fn study(study: &mut Study) -> Result<String, Failure> {
    let mut text = "## Figures\n\nEvery other figure that the thesis's program rendered, by ours.\n\n".to_owned();
    let few = study.plan.few_rows;
    for (index, figure) in FIGURES.iter().enumerate().filter(|(index, _)| !few || index % 5 == 0) {
        study.log(&format!("figures: {} ({}/{})", figure.number, index + 1, FIGURES.len()));
        let panels: Vec<Panel> =
            figure.shots.iter().map(|shot| panel(study, shot, figure.columns)).collect::<Result<_, _>>()?;
        let name = format!("figure-{}.jpg", figure.number.replace('.', "-"));
        save_grid(&study.directory.join(&name), &panels, figure.columns)?;
        let Figure { number, page, caption, .. } = figure;
        text += &format!("**Figure {number}** (page {page}). {caption}\n\n![Figure {number}]({name})\n\n");
    }
    study.log("figures: 4.12");
    text += &moving(study)?;
    study.log("figures: 5.7");
    text += &soft_shadows(study)?;
    let conditions = study.conditions(&format!("pictures of {} s unless said otherwise", study.plan.picture_seconds));
    Ok(text + &conditions)
}
