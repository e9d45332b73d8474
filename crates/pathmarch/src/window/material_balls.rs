//! Balls that show materials, rendered on a thread of their own.

use super::waker::Waker;
use egui::{ColorImage, Context, TextureHandle, TextureOptions};
use pathmarch_render::pathmarch_scene::document::Preset;
use pathmarch_render::pathmarch_scene::{Material, Scene};
use pathmarch_render::tonemap::Display;
use pathmarch_render::{Backend, Renderer, Settings};
use std::collections::HashMap;
use std::sync::mpsc::{Receiver, Sender, channel};

/// Side of a picture, pixels.
const SIDE: u32 = 96;
/// Scene of a ball, without the material.
const STUDIO: &str = r#"pathmarch 1
camera { position 0 0.55 4.2; target 0 -0.02 0; fov 31 }
render { samples 48; bounces 8; clamp 6 }
sky "gradient" { zenith 0.55 0.6 0.7; horizon 0.35; ground 0.15 }
object "lamp" material="lamp" { sphere 0.9 { at -2.6 3.4 2.6 } }
object "ball" material="ball" { sphere 1 }
object "floor" material="floor" { plane { at 0 -1 0 } }
material "floor" { diffuse { checker size=0.45 { colour 0.12; colour 0.5 } } }
material "lamp" { emit 9 }
"#;

/// A material to show.
#[derive(Clone, Debug)]
pub(crate) enum Shown {
    /// A material of the scene.
    Scene(Box<Material>),
    Preset(&'static Preset),
}

/// Request for a ball: its place, the text that it is of, and the material.
type Order = (String, String, Shown);
/// Place, text and picture of a ball.
type Done = (String, String, Vec<u8>);

/// A ball of the window.
#[derive(Default)]
struct Ball {
    /// Text of the material that was asked for last.
    asked: String,
    /// Text of the material that is shown.
    shown: String,
    picture: Option<TextureHandle>,
}

/// Balls by their place: a name of the scene or of a preset.
#[derive(Default)]
pub(crate) struct MaterialBalls {
    balls: HashMap<String, Ball>,
    worker: Option<(Sender<Order>, Receiver<Done>)>,
}

impl MaterialBalls {
    /// Picture of a material; that of an earlier text of it until the new one is rendered. `text` is unlike that of every other
    /// material of this place.
    pub(crate) fn get(
        &mut self,
        ctx: &Context,
        waker: &Waker,
        place: &str,
        text: &str,
        material: impl FnOnce() -> Shown,
    ) -> Option<TextureHandle> {
        let (orders, done) = self.worker.get_or_insert_with(|| start(waker.clone()));
        for (place, text, codes) in done.try_iter() {
            let image = ColorImage::from_rgba_premultiplied([SIDE as usize; 2], &codes);
            let ball = self.balls.entry(place).or_default();
            ball.shown = text;
            match &mut ball.picture {
                Some(picture) => picture.set(image, TextureOptions::LINEAR),
                slot => *slot = Some(ctx.load_texture("material", image, TextureOptions::LINEAR)),
            }
        }
        let ball = self.balls.entry(place.to_owned()).or_default();
        if ball.asked != text {
            text.clone_into(&mut ball.asked);
            // Without a thread there are no balls, but everything else works.
            let _ = orders.send((place.to_owned(), text.to_owned(), material()));
        }
        ball.picture.clone()
    }
}

#[cfg(test)]
impl MaterialBalls {
    /// Number of balls that show the material that was asked for last, and of all.
    pub(crate) fn counts(&self) -> [usize; 2] {
        [self.balls.values().filter(|ball| ball.shown == ball.asked).count(), self.balls.len()]
    }
}

/// Starts the thread. It ends with the window, after the ball at hand.
fn start(waker: Waker) -> (Sender<Order>, Receiver<Done>) {
    let ((orders, inbox), (outbox, done)) = (channel::<Order>(), channel());
    let work = move || {
        let mut waiting: Vec<Order> = Vec::new();
        loop {
            if waiting.is_empty() {
                let Ok(order) = inbox.recv() else { return };
                waiting.push(order);
            }
            for order in inbox.try_iter() {
                // A slider that is dragged asks for many balls of one material.
                waiting.retain(|(place, ..)| *place != order.0);
                waiting.push(order);
            }
            let (place, text, material) = waiting.remove(0);
            let Some(codes) = render(&material) else { continue };
            if outbox.send((place, text, codes)).is_err() {
                return;
            }
            waker();
        }
    };
    drop(std::thread::Builder::new().name("materials".to_owned()).spawn(work));
    (orders, done)
}

/// Scene of a ball of a material; `None` if that needs more than a ball has.
fn scene(material: &Shown) -> Option<Scene> {
    let braces = match material {
        Shown::Scene(_) => "diffuse 1",
        Shown::Preset(preset) => preset.text(),
    };
    let mut scene = Scene::parse("ball", &format!("{STUDIO}material \"ball\" {{ {braces} }}\n")).ok()?;
    if let Shown::Scene(material) = material {
        let ball = scene.materials.iter_mut().find(|material| material.name == "ball")?;
        *ball = Material { name: "ball".to_owned(), ..(**material).clone() };
    }
    Some(scene)
}

/// Picture of a ball: red, green, blue and 255 for each pixel.
fn render(material: &Shown) -> Option<Vec<u8>> {
    let scene = scene(material)?;
    let settings = Settings { size: [SIDE; 2], ..Settings::of(&scene) };
    let film = Renderer::open(Backend::Cpu, None).ok()?.render(&scene, &settings).ok()?;
    Some(Display::default().encode_rgba(&film.mean().pixels))
}

#[cfg(test)]
mod tests {
    use super::*;
    use pathmarch_render::pathmarch_scene::document::PRESETS;

    #[test]
    fn every_preset_has_a_ball_that_differs_from_the_others() {
        let balls: Vec<Vec<u8>> =
            PRESETS.iter().map(|preset| render(&Shown::Preset(preset)).expect(preset.name)).collect();
        for (index, ball) in balls.iter().enumerate() {
            let differs = |other: &Vec<u8>| {
                let sum: u64 = ball.iter().zip(other).map(|(a, b)| u64::from(a.abs_diff(*b))).sum();
                sum / ball.len() as u64
            };
            for (other, picture) in balls.iter().enumerate().filter(|(other, _)| *other != index) {
                assert!(differs(picture) > 0, "{} is like {}", PRESETS[index].name, PRESETS[other].name);
            }
        }
    }

    #[test]
    fn a_material_of_a_scene_has_the_ball_of_its_text() {
        let gold = PRESETS.iter().find(|preset| preset.name == "gold").expect("gold");
        let text = format!(
            "pathmarch 1\ncamera {{ position 0 0 5; target 0 0 0 }}\nmaterial \"ring\" {{ {} }}\n\
                            object \"a\" material=\"ring\" {{ sphere }}",
            gold.text()
        );
        let material = Scene::parse("a.kdl", &text).expect("a scene").materials[0].clone();
        assert!(render(&Shown::Scene(Box::new(material))) == render(&Shown::Preset(gold)));
    }
}
