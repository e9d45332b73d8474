//! The first page: example scenes to start from.
//!
//! Scenes and their pictures are part of the program, so that it needs no other file. A scene is opened as a copy without
//! a file of its own: saving asks for one.

use super::app::App;
use super::files::After;
use super::places::Places;
use super::saving::write_atomically;
use egui::{ColorImage, Image, RichText, TextureHandle, TextureOptions, Ui, Vec2};
use std::path::{Path, PathBuf};

/// An example.
pub(super) struct Example {
    /// Its file's name without extension.
    pub(super) name: &'static str,
    /// One line for people.
    pub(super) doc: &'static str,
    file: &'static str,
    pub(super) text: &'static str,
    picture: &'static [u8],
}

macro_rules! examples {
    ($($folder:literal $name:literal $extension:literal $doc:literal;)*) => {
        &[$(Example {
            name: $name,
            doc: $doc,
            file: concat!($folder, $name, ".kdl"),
            text: include_str!(concat!("../../../../scenes/", $folder, $name, ".kdl")),
            picture: include_bytes!(concat!("../../../../docs/images/", $name, ".", $extension)),
        }),*]
    };
}

/// Every example, in the order of the page.
pub(super) static EXAMPLES: &[Example] = examples! {
    "fractals/" "mandelbulb" "jpg" "The mandelbulb, coloured by its orbits.";
    "fractals/" "kleinian" "jpg" "Halls of a pseudo-Kleinian group.";
    "fractals/" "julia" "jpg" "A slice of a quaternion Julia set.";
    "thesis/" "cream-julia" "jpg" "A Julia set in cream and green.";
    "fractals/" "mandelbox" "jpg" "The mandelbox.";
    "thesis/" "inside-mandelbox" "jpg" "Inside a mandelbox.";
    "fractals/" "coral" "jpg" "A coral: an iterated function system.";
    "thesis/" "mandelbulb-landscape" "jpg" "A land on a mandelbulb.";
    "fractals/" "apollonian" "jpg" "Spheres within spheres.";
    "fractals/" "sponge" "jpg" "Menger's sponge as a lantern.";
    "fractals/" "sierpinski" "jpg" "Sierpinski's tetrahedron.";
    "fractals/" "cubes" "jpg" "Cubes to the horizon.";
    "" "gyroid" "jpg" "A lantern of a gyroid, declared by the scene.";
    "" "nautilus" "jpg" "A shell around a spiral, declared by the scene.";
    "" "columns" "jpg" "Twisted columns, brought over from GLSL.";
    "" "clay" "jpg" "Cracked mud, crazed glaze, hammered copper.";
    "" "textures" "jpg" "Every texture, as colours and as a relief.";
    "" "operators" "jpg" "Twisted, bent, repeated, hollow and round.";
    "" "lathe" "jpg" "Profiles, turned on a lathe and drawn out.";
    "" "letters" "jpg" "Letters of a font, in low light.";
    "" "seams" "jpg" "Soft, round, chamfered and stepped seams.";
    "" "molten" "jpg" "Coloured clay, melted together.";
    "" "rotunda" "jpg" "A round temple in still water.";
    "" "hall" "jpg" "A flooded hall of columns without end.";
    "" "gears" "jpg" "Gears that turn, by formulas; with motion blur.";
    "" "glass-still-life" "jpg" "Clear and coloured glass on a table.";
    "" "day" "jpg" "The sky of a clear day, and its sun.";
    "" "material-grid" "jpg" "Every kind of material, smooth to rough.";
    "" "cornell" "jpg" "The box that every path tracer renders.";
    "" "depth-of-field" "jpg" "A lens: what is near and far blurs.";
    "" "many-lights" "jpg" "Sixty-four lamps.";
    "" "environment" "jpg" "Lit by a picture of the sky.";
    "" "ten-lines" "png" "A whole scene in ten lines of text.";
    "thesis/" "twisted-cube" "jpg" "A cube, twisted about its axis.";
    "thesis/" "combinations" "jpg" "Union, subtraction and intersection, sharp and smooth.";
    "thesis/" "solids" "jpg" "The solids.";
    "thesis/" "grey-mandelbulb" "jpg" "The mandelbulb of the thesis.";
    "thesis/" "glass-prism" "jpg" "A prism of glass.";
    "thesis/" "refractive-prisms" "jpg" "Prisms that refract.";
    "thesis/" "specular-prisms" "jpg" "Prisms that mirror.";
    "thesis/" "emitting-spheres" "jpg" "Balls that shine.";
    "thesis/" "three-spheres" "jpg" "Diffuse, mirroring and refracting balls.";
    "thesis/" "metal-light" "jpg" "A metal ball and a light.";
    "thesis/" "metal-room-rough-05" "jpg" "Metal in a room, nearly a mirror.";
    "thesis/" "metal-room-rough-50" "jpg" "Metal in a room, half rough.";
    "thesis/" "metal-room-rough-90" "jpg" "Metal in a room, rough.";
    "thesis/" "open-room" "jpg" "A room without a roof, with a light.";
    "thesis/" "open-room-sky" "jpg" "The same, lit by the sky.";
    "thesis/" "caustics" "jpg" "Light gathered by glass.";
    "thesis/" "caustics-fast" "jpg" "The same, simplified: free of noise.";
    "thesis/" "diffuse-sphere" "png" "The simplest: a ball and a floor.";
};

/// Every example as its file's path in the folder of scenes, and its text.
pub(crate) fn examples() -> impl Iterator<Item = (&'static str, &'static str)> {
    EXAMPLES.iter().map(|example| (example.file, example.text))
}

/// Pictures of the sky that examples need.
static ASSETS: &[(&str, &[u8])] = &[("environment.exr", include_bytes!("../../../../scenes/environment.exr"))];

/// Points of an example's picture.
const CARD: Vec2 = Vec2::new(240.0, 135.0);

#[derive(Default)]
pub(super) struct Gallery {
    /// Where the pictures that scenes need are.
    home: Option<PathBuf>,
    /// Pictures of the examples, as far as they are unpacked.
    textures: Vec<TextureHandle>,
}

impl Gallery {
    /// The name and text of an example.
    pub(super) fn scene(&mut self, index: usize) -> Option<(String, String)> {
        let example = EXAMPLES.get(index)?;
        let home = self.home().join(example.file);
        Some((home.display().to_string(), example.text.to_owned()))
    }

    /// Unpacks a few more pictures, so that the page is there at once.
    fn unpack(&mut self, ctx: &egui::Context) {
        const AT_ONCE: usize = 3;
        let next = self.textures.len();
        for example in EXAMPLES.iter().skip(next).take(AT_ONCE) {
            let image = image::load_from_memory(example.picture).map(|picture| {
                let (width, height) = (2.0 * CARD.x, 2.0 * CARD.y);
                let small = picture.resize_to_fill(width as u32, height as u32, image::imageops::FilterType::Triangle);
                let size = [small.width() as usize, small.height() as usize];
                ColorImage::from_rgba_unmultiplied(size, &small.to_rgba8())
            });
            // The pictures are part of the program, and a test opens each.
            let image = image.unwrap_or_else(|_| ColorImage::filled([2, 2], egui::Color32::BLACK));
            self.textures.push(ctx.load_texture(example.name, image, TextureOptions::LINEAR));
        }
        if self.textures.len() < EXAMPLES.len() {
            ctx.request_repaint();
        }
    }

    /// The folder of the scenes where they are at hand, else one with what they need.
    fn home(&mut self) -> PathBuf {
        self.home.get_or_insert_with(find_home).clone()
    }
}

fn find_home() -> PathBuf {
    let sources = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    if sources.is_dir() {
        return sources.canonicalize().unwrap_or(sources);
    }
    let home = Places::of_user().map_or_else(std::env::temp_dir, |places| places.recovery).with_file_name("gallery");
    // Without them a scene says which picture it misses.
    if std::fs::create_dir_all(&home).is_ok() {
        for (name, bytes) in ASSETS {
            let path = home.join(name);
            if std::fs::metadata(&path).map(|meta| meta.len()).ok() != Some(bytes.len() as u64) {
                drop(write_atomically(&path, bytes));
            }
        }
    }
    home
}

impl App {
    pub(super) fn gallery_page(&mut self, ui: &mut Ui) {
        self.gallery.unpack(ui.ctx());
        let mut chosen = None;
        egui::CentralPanel::default().show(ui, |ui| {
            egui::ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
                ui.add_space(14.0);
                ui.vertical_centered(|ui| {
                    ui.label(RichText::new("pathmarch").size(34.0).strong());
                    ui.label("Distance fields, path-traced. Choose a scene to start from.");
                    ui.add_space(8.0);
                    ui.horizontal(|ui| {
                        let width = 250.0;
                        ui.add_space((ui.available_width() - width).max(0.0) * 0.5);
                        if ui.button("New scene").on_hover_text("A ball on a floor.").clicked() {
                            chosen = Some(After::New);
                        }
                        if ui.button("Open a file…").on_hover_text("A .kdl file.").clicked() {
                            chosen = Some(After::Open);
                        }
                        if let Some(path) = self.preferences.recent.first() {
                            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
                            let words = path.display().to_string();
                            if ui.button(format!("Go on with {name}")).on_hover_text(words).clicked() {
                                chosen = Some(After::OpenFile(path.clone()));
                            }
                        }
                    });
                });
                ui.add_space(14.0);
                let columns = ((ui.available_width() + 10.0) / (CARD.x + 22.0)).floor().max(1.0) as usize;
                let margin = 0.5 * (ui.available_width() - columns as f32 * (CARD.x + 22.0)).max(0.0);
                for (row, examples) in EXAMPLES.chunks(columns).enumerate() {
                    ui.horizontal_top(|ui| {
                        ui.add_space(margin);
                        for (column, example) in examples.iter().enumerate() {
                            let index = row * columns + column;
                            if card(ui, example, self.gallery.textures.get(index)) {
                                chosen = Some(After::Example(index));
                            }
                        }
                    });
                    ui.add_space(6.0);
                }
            });
        });
        if let Some(after) = chosen {
            self.proceed(after);
        }
    }
}

/// An example's picture, name and line; whether it was chosen.
fn card(ui: &mut Ui, example: &'static Example, picture: Option<&TextureHandle>) -> bool {
    let size = Vec2::new(CARD.x + 12.0, CARD.y + 48.0);
    let card = ui.allocate_ui(size, |ui| {
        ui.vertical(|ui| {
            let clicked = match picture {
                Some(texture) => {
                    let image = Image::new((texture.id(), CARD)).corner_radius(4.0).alt_text(example.name);
                    ui.add(egui::Button::image(image).frame(false)).on_hover_text(example.doc).clicked()
                }
                None => ui.add_sized(CARD, egui::Button::new(example.name)).clicked(),
            };
            ui.strong(example.name);
            ui.add(egui::Label::new(example.doc).wrap());
            clicked
        })
        .inner
    });
    card.inner
}

#[cfg(test)]
mod tests {
    use super::*;
    use pathmarch_render::pathmarch_scene::Scene;

    /// Every scene of the repository stands on the page, and opens.
    #[test]
    fn the_gallery_is_all_scenes() {
        let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
        let mut files = Vec::new();
        for folder in ["", "thesis/", "fractals/"] {
            for entry in std::fs::read_dir(scenes.join(folder)).expect("the scenes are there") {
                let name = entry.expect("a file").file_name().to_string_lossy().into_owned();
                if name.ends_with(".kdl") {
                    files.push(format!("{folder}{name}"));
                }
            }
        }
        let mut listed: Vec<_> = EXAMPLES.iter().map(|example| example.file.to_owned()).collect();
        files.sort();
        listed.sort();
        assert_eq!(files, listed);
        let mut gallery = Gallery::default();
        for (index, example) in EXAMPLES.iter().enumerate() {
            let (name, text) = gallery.scene(index).expect("an example");
            Scene::parse(&name, &text).expect("a scene");
            image::load_from_memory(example.picture).expect("a picture");
        }
    }
}
