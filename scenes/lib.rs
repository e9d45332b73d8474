//! Example scenes of [pathmarch](https://docs.rs/pathmarch), each with its text and a rendered picture.
//!
//! This folder is for people to browse, and it is a crate, so that programs include the scenes without copies of the files:
//! the window's gallery and the measurement program. [`EXAMPLES`] lists all scenes but those of `benchmarks/`.
//!
//! ```
//! let scene = pathmarch_gallery::EXAMPLES.iter().find(|example| example.name == "ten-lines").expect("listed");
//! assert_eq!(scene.file, "ten-lines.kdl");
//! assert!(scene.text.starts_with("pathmarch 1\n"));
//! ```

use std::path::Path;

/// Example scene.
pub struct Example {
    /// Name of the file, without extension.
    pub name: &'static str,
    /// Description, one line.
    pub doc: &'static str,
    /// Path of the file, relative to [`folder`].
    pub file: &'static str,
    /// Text of the scene.
    pub text: &'static str,
    /// Rendered picture, as the bytes of a PNG or JPEG file.
    pub picture: &'static [u8],
}

macro_rules! examples {
    ($($folder:literal $name:literal $extension:literal $doc:literal;)*) => {
        &[$(Example {
            name: $name,
            doc: $doc,
            file: concat!($folder, $name, ".kdl"),
            text: include_str!(concat!($folder, $name, ".kdl")),
            picture: include_bytes!(concat!("images/", $name, ".", $extension)),
        }),*]
    };
}

/// All examples, in the order of the gallery.
pub static EXAMPLES: &[Example] = examples! {
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
    "" "candle-light" "jpg" "A wine glass in five points, and a candle.";
    "" "letters" "jpg" "Letters of a font, in low light.";
    "" "seams" "jpg" "Soft, round, chamfered and stepped seams.";
    "" "molten" "jpg" "Coloured clay, melted together.";
    "" "melting" "jpg" "Meshes: textured, of glass, and melting into each other.";
    "" "flight-helmet" "jpg" "A helmet in a studio: a mesh of 95,000 triangles.";
    "" "paperweight" "jpg" "A golden monkey in a block of glass.";
    "" "statue" "jpg" "A marble cow in the room of the thesis.";
    "" "rotunda" "jpg" "A round temple in still water.";
    "" "hall" "jpg" "A flooded hall of columns without end.";
    "" "gears" "jpg" "Gears that turn, by formulas; with motion blur.";
    "" "glass-still-life" "jpg" "Clear and coloured glass on a table.";
    "" "pool" "jpg" "Sunlight through the waves of a pool.";
    "" "newton" "jpg" "Newton's prism throws a spectrum on the wall.";
    "" "tumbler" "jpg" "Water, ice and bubbles in a tumbler.";
    "" "lantern" "jpg" "A lantern in fog, which shows its light.";
    "" "candles" "jpg" "Candles: light inside wax, flames that emit.";
    "" "day" "jpg" "The sky of a clear day, and its sun.";
    "" "material-grid" "jpg" "Every kind of material, smooth to rough.";
    "" "cornell" "jpg" "The box that every path tracer renders.";
    "" "depth-of-field" "jpg" "A lens: what is near and far blurs.";
    "" "many-lights" "jpg" "Sixty-four lamps.";
    "" "ballroom" "jpg" "A room of two hundred lamps.";
    "" "lamp-hall" "jpg" "A hall of ten thousand lamps.";
    "" "bear" "jpg" "A toy bear on a turntable.";
    "" "bracket" "jpg" "A part for printing, in millimetres.";
    "" "bottle" "jpg" "A product shot with a logo.";
    "" "tea" "jpg" "One picture as decals on a tin, a carton and a cup.";
    "" "environment" "jpg" "Lit by a picture of the sky.";
    "" "ten-lines" "png" "A whole scene in ten lines of text.";
    "thesis/" "orbit-traps" "jpg" "Three fractals, three orbit traps.";
    "thesis/" "twisted-cube" "jpg" "A cube, twisted about its axis.";
    "thesis/" "combinations" "jpg" "Union, subtraction and intersection.";
    "thesis/" "solids" "jpg" "The solids.";
    "thesis/" "grey-mandelbulb" "jpg" "The mandelbulb of the thesis.";
    "thesis/" "glass-prism" "jpg" "A prism of glass.";
    "" "refractive-prisms" "jpg" "Prisms that refract.";
    "" "spectrum" "jpg" "Prisms that spread white light into colours.";
    "" "specular-prisms" "jpg" "Prisms that mirror.";
    "thesis/" "two-cubes" "jpg" "Two cubes, diffuse and specular.";
    "thesis/" "green-lamp" "jpg" "A green lamp.";
    "thesis/" "soft-shadows" "jpg" "Shadows that soften with the distance.";
    "thesis/" "emitting-spheres" "jpg" "Balls that shine.";
    "thesis/" "three-spheres" "jpg" "Three balls of rough metal.";
    "" "metal-light" "jpg" "A metal ball and a light.";
    "thesis/" "metal-room-rough-05" "jpg" "Metal in a room, nearly a mirror.";
    "thesis/" "metal-room-rough-50" "jpg" "Metal in a room, half rough.";
    "thesis/" "metal-room-rough-90" "jpg" "Metal in a room, rough.";
    "thesis/" "open-room" "jpg" "A room without a roof, with a light.";
    "thesis/" "open-room-sky" "jpg" "The same, lit by the sky.";
    "thesis/" "open-room-lamp" "jpg" "The same, lit by a lamp of a size.";
    "thesis/" "caustics" "jpg" "Light gathered by glass.";
    "thesis/" "caustics-fast" "jpg" "The same, simplified: free of noise.";
    "thesis/" "diffuse-sphere" "png" "The simplest: a ball and a floor.";
};

/// Other files that examples read, by their names in [`folder`]: environment maps, meshes and their textures.
pub static ASSETS: &[(&str, &[u8])] = &[
    ("environment.exr", include_bytes!("environment.exr")),
    ("flight-helmet.glb", include_bytes!("flight-helmet.glb")),
    ("logo.png", include_bytes!("logo.png")),
    ("spot.obj", include_bytes!("spot.obj")),
    ("spot.png", include_bytes!("spot.png")),
    ("suzanne.glb", include_bytes!("suzanne.glb")),
];

/// Folder of the scenes on the machine that built this crate. It may not exist on another machine.
pub fn folder() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use pathmarch_scene::Scene;

    /// Every scene of the repository is listed and valid, and its picture can be read.
    #[test]
    fn the_gallery_lists_all_scenes() {
        let mut files = Vec::new();
        for folder in ["", "thesis/", "fractals/"] {
            for entry in std::fs::read_dir(super::folder().join(folder)).expect("the folder of scenes") {
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
        for example in EXAMPLES {
            let path = super::folder().join(example.file);
            Scene::parse(&path.display().to_string(), example.text).expect("a scene");
            image::load_from_memory(example.picture).expect("a picture");
        }
    }
}
