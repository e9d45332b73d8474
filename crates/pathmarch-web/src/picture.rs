//! Picture that the page adds samples to.

use pathmarch_render::exposure::suitable_stops_of;
use pathmarch_render::image::{self, ImageFormat, Provenance};
use pathmarch_render::pathmarch_scene::Tonemap;
use pathmarch_render::tonemap::Display;
use std::path::Path;
use wasm_bindgen::prelude::*;

/// Sums of samples, shown with an exposure and a tone curve. Rows may have different numbers of samples.
#[wasm_bindgen]
pub struct Picture {
    width: u32,
    height: u32,
    sums: Vec<[f32; 3]>,
    /// Number of samples of each row.
    samples: Vec<u32>,
    display: Display,
    /// True if the exposure is the one that suits the picture.
    auto_exposure: bool,
    provenance: Provenance,
}

#[wasm_bindgen]
impl Picture {
    /// Black picture. `tonemap` is a name of the scene language, `exposure` in stops, or absent for the one that suits the
    /// picture; views have the curve `srgb` and no exposure.
    ///
    /// # Errors
    /// If there is no such tone curve, or a side is 0.
    #[wasm_bindgen(constructor)]
    pub fn new(
        width: u32,
        height: u32,
        tonemap: &str,
        exposure: Option<f32>,
        scene_hash: String,
    ) -> Result<Self, JsError> {
        if width == 0 || height == 0 {
            return Err(JsError::new("a picture has at least one pixel"));
        }
        let curve = Tonemap::from_name(tonemap).ok_or_else(|| JsError::new(&format!("no tone curve `{tonemap}`")))?;
        let sums = vec![[0.0; 3]; width as usize * height as usize];
        let display = Display { tonemap: curve, exposure_stops: exposure.unwrap_or(0.0) };
        let version = env!("CARGO_PKG_VERSION").to_owned();
        let provenance = Provenance {
            scene_hash,
            version,
            mode: "path".to_owned(),
            backend: "web".to_owned(),
            ..Provenance::default()
        };
        Ok(Self {
            width,
            height,
            sums,
            samples: vec![0; height as usize],
            display,
            auto_exposure: exposure.is_none(),
            provenance,
        })
    }

    /// Adds sums of samples to rows.
    ///
    /// # Errors
    /// If the rows are not within the picture, or the sums are not theirs.
    pub fn add(&mut self, first_row: u32, sums: &[f32], samples: u32) -> Result<(), JsError> {
        let row = self.width as usize;
        let start = first_row as usize * row;
        let (pixels, rest) = sums.as_chunks::<3>();
        let rows = pixels.len() / row;
        if !rest.is_empty() || rows * row != pixels.len() || start + pixels.len() > self.sums.len() {
            return Err(JsError::new("these samples are of another picture"));
        }
        for (sum, more) in self.sums[start..].iter_mut().zip(pixels) {
            for channel in 0..3 {
                sum[channel] += more[channel];
            }
        }
        for count in &mut self.samples[first_row as usize..][..rows] {
            *count += samples;
        }
        Ok(())
    }

    /// Replaces all sums by those of `samples` samples.
    ///
    /// # Errors
    /// If the sums are those of another picture.
    pub fn replace(&mut self, sums: &[f32], samples: u32) -> Result<(), JsError> {
        self.sums.fill([0.0; 3]);
        self.samples.fill(0);
        self.add(0, sums, samples)
    }

    /// Smallest number of samples of a pixel.
    pub fn samples(&self) -> u32 {
        self.samples.iter().copied().min().unwrap_or(0)
    }

    /// Red, green, blue and 255 of each pixel, 8 bits.
    pub fn rgba(&self) -> Vec<u8> {
        let means = self.means();
        self.display_of(&means).encode_rgba(&means)
    }

    /// Bytes of a PNG file, as shown.
    ///
    /// # Errors
    /// If it cannot be encoded.
    pub fn png(&self) -> Result<Vec<u8>, JsError> {
        self.encode("picture.png", ImageFormat::Png)
    }

    /// Bytes of an OpenEXR file: linear radiance, without exposure.
    ///
    /// # Errors
    /// If it cannot be encoded.
    pub fn exr(&self) -> Result<Vec<u8>, JsError> {
        self.encode("picture.exr", ImageFormat::Exr)
    }
}

impl Picture {
    fn means(&self) -> Vec<[f32; 3]> {
        let rows = self.sums.chunks(self.width as usize).zip(&self.samples);
        let mean = |sum: &[f32; 3], count: u32| sum.map(|channel| channel / count.max(1) as f32);
        rows.flat_map(|(row, count)| row.iter().map(move |sum| mean(sum, *count))).collect()
    }

    /// Tone curve and exposure of these means.
    fn display_of(&self, means: &[[f32; 3]]) -> Display {
        let suitable = if self.auto_exposure { suitable_stops_of(self.width as usize, means) } else { None };
        Display { exposure_stops: suitable.unwrap_or(self.display.exposure_stops), ..self.display }
    }

    fn encode(&self, name: &str, format: ImageFormat) -> Result<Vec<u8>, JsError> {
        let picture = image::Picture { width: self.width, height: self.height, pixels: self.means() };
        let display = self.display_of(&picture.pixels);
        let provenance = Provenance { samples: self.samples(), ..self.provenance.clone() };
        Ok(image::encode(Path::new(name), format, &picture, Vec::new(), &display, &provenance)?)
    }
}
