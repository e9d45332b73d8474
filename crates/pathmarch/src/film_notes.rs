//! What a film file notes beside its samples, so that a picture can be made of it without the scene.

use pathmarch_render::exposure::suitable_stops;
use pathmarch_render::film::Film;
use pathmarch_render::image::Provenance;
use pathmarch_render::parts::FilmHeader;
use pathmarch_render::pathmarch_scene::settings::AUTO;
use pathmarch_render::pathmarch_scene::{Scene, Tonemap};
use pathmarch_render::tonemap::Display;
use pathmarch_render::{Mode, Settings, scene_hash};
use std::collections::BTreeMap;
use std::path::Path;

/// True for the name of a film.
pub fn is_film(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("film"))
}

/// Notes of a film. An automatic exposure is that of the whole picture, so that it is not known yet.
pub fn notes(display: Display, auto_exposure: bool, settings: &Settings, scene: &Scene) -> BTreeMap<String, String> {
    let notes = [
        ("tonemap", display.tonemap.name().to_owned()),
        ("exposure", if auto_exposure { AUTO.to_owned() } else { display.exposure_stops.to_string() }),
        ("mode", settings.mode.name().to_owned()),
        ("scene hash", scene_hash(scene)),
        ("seed", settings.seed.to_string()),
        ("bounces", settings.bounces.to_string()),
    ];
    notes.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()
}

fn number<T: std::str::FromStr + Default>(header: &FilmHeader, name: &str) -> T {
    header.notes.get(name).and_then(|text| text.parse().ok()).unwrap_or_default()
}

/// Quantity that a film shows.
pub fn mode(header: &FilmHeader) -> Mode {
    header.notes.get("mode").and_then(|name| Mode::from_name(name)).unwrap_or_default()
}

/// Tone curve and exposure of a film, which `film` has the samples of.
pub fn display(header: &FilmHeader, film: &Film) -> Display {
    let tonemap = header.notes.get("tonemap").and_then(|name| Tonemap::from_name(name)).unwrap_or_default();
    let is_auto = header.notes.get("exposure").is_some_and(|text| text == AUTO);
    let suitable = if is_auto { suitable_stops(film) } else { None };
    Display { tonemap, exposure_stops: suitable.unwrap_or_else(|| number(header, "exposure")) }
}

/// Provenance of a picture of a film.
pub fn provenance(header: &FilmHeader, samples: u32) -> Provenance {
    let engines = header.engines.join(" + ");
    let (backend, adapter) = engines.split_once(": ").unwrap_or((&engines, ""));
    Provenance {
        scene_hash: header.notes.get("scene hash").cloned().unwrap_or_default(),
        samples,
        first_sample: header.samples[0],
        seed: number(header, "seed"),
        bounces: number(header, "bounces"),
        mode: mode(header).name().to_owned(),
        adapter: adapter.to_owned(),
        backend: backend.to_owned(),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        denoiser: None,
    }
}
