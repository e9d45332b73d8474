//! Software rasterizer for egui's triangles.
//!
//! Pixels are `0x00RRGGBB`. Blending is egui's: of sRGB-encoded values, premultiplied by alpha (`epaint::Color32`).
//! Vertices are snapped to 1/256 of a pixel, and pixels are covered by centre and top-left rule, as on a GPU: triangles
//! that share an edge leave no gap and draw no pixel twice. Textures are clamped to their edge; the window uses no
//! other mode.

use crate::window::painter::Textures;
use egui::epaint::{ImageData, ImageDelta, Primitive, Vertex};
use egui::{ClippedPrimitive, Color32, Rect, TextureFilter};
use std::ops::Range;

/// Subpixel steps per pixel.
const GRID: i64 = 256;
/// Vertices are clamped to this distance, pixels.
const FARTHEST: f32 = 1e6;
/// Fraction bits of a fixed-point texture coordinate.
const FRACTION: u32 = 16;

/// Pixel buffer, row by row.
pub(super) struct Canvas<'a> {
    pub(super) pixels: &'a mut [u32],
    pub(super) width: usize,
}

impl Canvas<'_> {
    fn height(&self) -> usize {
        self.pixels.len() / self.width.max(1)
    }

    /// Draws the meshes of a frame.
    pub(super) fn paint(&mut self, primitives: &[ClippedPrimitive], pixels_per_point: f32, textures: &Textures) {
        for ClippedPrimitive { clip_rect, primitive } in primitives {
            let Primitive::Mesh(mesh) = primitive else { continue };
            let Some(texture) = textures.0.get(&mesh.texture_id).and_then(Texture::new) else { continue };
            let clip = self.clip(*clip_rect, pixels_per_point);
            if clip.columns.is_empty() || clip.rows.is_empty() {
                continue;
            }
            for corners in mesh.indices.chunks_exact(3) {
                let corner = |index: usize| corners.get(index).and_then(|&at| mesh.vertices.get(at as usize));
                if let (Some(a), Some(b), Some(c)) = (corner(0), corner(1), corner(2)) {
                    self.triangle([a, b, c], pixels_per_point, &clip, &texture);
                }
            }
        }
    }

    fn clip(&self, rect: Rect, pixels_per_point: f32) -> Clip {
        let range = |min: f32, max: f32, size: usize| {
            let side = |at: f32| ((at * pixels_per_point).round().max(0.0) as usize).min(size) as i64;
            side(min)..side(max)
        };
        Clip { columns: range(rect.min.x, rect.max.x, self.width), rows: range(rect.min.y, rect.max.y, self.height()) }
    }

    fn triangle(&mut self, mut corners: [&Vertex; 3], pixels_per_point: f32, clip: &Clip, texture: &Texture) {
        let texel_position = |vertex: &Vertex| {
            [vertex.pos.x, vertex.pos.y]
                .map(|at| ((at * pixels_per_point).clamp(-FARTHEST, FARTHEST) * GRID as f32).round() as i64)
        };
        let mut positions = corners.map(texel_position);
        let mut area = twice_area(positions);
        if area < 0 {
            corners.swap(1, 2);
            positions.swap(1, 2);
            area = -area;
        }
        let [a, b, c] = positions;
        let (top, bottom) = (a[1].min(b[1]).min(c[1]), a[1].max(b[1]).max(c[1]));
        let rows = first_centre(top).max(clip.rows.start)..first_centre(bottom + 1).min(clip.rows.end);
        if area == 0 || rows.is_empty() {
            return;
        }
        let edges = [Edge::new(a, b), Edge::new(b, c), Edge::new(c, a)];
        let paint = Paint::of(corners, positions, area, texture);
        for row in rows {
            let mut span = clip.columns.clone();
            edges.iter().for_each(|edge| edge.cut(row, &mut span));
            if span.is_empty() {
                continue;
            }
            let start = row as usize * self.width;
            let pixels = &mut self.pixels[start + span.start as usize..start + span.end as usize];
            paint.fill(pixels, span.start, row);
        }
    }
}

/// Clip rectangle, pixels.
struct Clip {
    columns: Range<i64>,
    rows: Range<i64>,
}

/// Twice the signed area of a triangle; negative if its vertices are counter-clockwise.
fn twice_area([a, b, c]: [[i64; 2]; 3]) -> i64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// First pixel whose centre is at or after a subpixel position.
fn first_centre(at: i64) -> i64 {
    (at - GRID / 2 + GRID - 1).div_euclid(GRID)
}

/// A directed edge; the inside of the triangle is on its right.
struct Edge {
    from: [i64; 2],
    along: [i64; 2],
    /// Top-left rule: -1 if pixel centres on the edge belong to the neighbour.
    bias: i64,
}

impl Edge {
    fn new(from: [i64; 2], to: [i64; 2]) -> Self {
        let along = [to[0] - from[0], to[1] - from[1]];
        let is_top_or_left = along[1] < 0 || (along[1] == 0 && along[0] > 0);
        Self { from, along, bias: if is_top_or_left { 0 } else { -1 } }
    }

    /// Restricts a row's span to the inside of the edge.
    fn cut(&self, row: i64, span: &mut Range<i64>) {
        let [dx, dy] = self.along;
        let reach = dx * (row * GRID + GRID / 2 - self.from[1]) + self.bias;
        match dy {
            0 => {
                if reach < 0 {
                    span.end = span.start;
                }
            }
            1.. => {
                let last = self.from[0] + reach.div_euclid(dy);
                span.end = span.end.min(first_centre(last + 1));
            }
            _ => {
                let first = self.from[0] - reach.div_euclid(-dy);
                span.start = span.start.max(first_centre(first));
            }
        }
    }
}

/// Attribute that is linear in screen space: its value at the centre of pixel (0, 0), and its derivatives.
#[derive(Clone, Copy)]
struct Linear {
    origin: f64,
    right: f64,
    down: f64,
}

impl Linear {
    fn new(values: [f32; 3], [a, b, c]: [[i64; 2]; 3], area: i64) -> Self {
        let [first, second, third] = values.map(f64::from);
        let (second, third) = (second - first, third - first);
        let slope = |k: usize| {
            let at = |corner: [i64; 2]| (corner[k] - a[k]) as f64;
            GRID as f64 * (second * at(c) - third * at(b)) / area as f64
        };
        let (right, down) = (slope(1), -slope(0));
        let centre = |k: usize| 0.5 - a[k] as f64 / GRID as f64;
        Self { origin: first + right * centre(0) + down * centre(1), right, down }
    }

    fn at(&self, column: i64, row: i64) -> f64 {
        self.origin + self.right * column as f64 + self.down * row as f64
    }
}

/// Shading of a triangle.
enum Paint<'a> {
    /// One colour.
    Solid(u32),
    /// Interpolated vertex colours.
    Gradient([Linear; 4]),
    /// A texture, multiplied by a tint.
    Textured { texture: &'a Texture<'a>, texel_position: [Linear; 2], tint: Tint },
}

enum Tint {
    None,
    One(Color32),
    Gradient([Linear; 4]),
}

impl<'a> Paint<'a> {
    fn of(corners: [&Vertex; 3], positions: [[i64; 2]; 3], area: i64, texture: &'a Texture<'a>) -> Self {
        let [a, b, c] = corners;
        let one_colour = a.color == b.color && b.color == c.color;
        let blend = |texel: Color32| {
            let colours = corners.map(|corner| times(corner.color, texel).to_array());
            [0, 1, 2, 3].map(|k| Linear::new(colours.map(|colour| f32::from(colour[k])), positions, area))
        };
        if a.uv == b.uv && b.uv == c.uv {
            let texel = texture.at(a.uv.x, a.uv.y);
            return match one_colour {
                true => Self::Solid(code(times(a.color, texel))),
                false => Self::Gradient(blend(texel)),
            };
        }
        let tint = match one_colour {
            true if a.color == Color32::WHITE => Tint::None,
            true => Tint::One(a.color),
            false => Tint::Gradient(blend(Color32::WHITE)),
        };
        let [width, height] = texture.size.map(|side| side as f32);
        let texel_position = [
            Linear::new(corners.map(|corner| corner.uv.x * width), positions, area),
            Linear::new(corners.map(|corner| corner.uv.y * height), positions, area),
        ];
        Self::Textured { texture, texel_position, tint }
    }

    /// Draws a span of pixels that begins at `column`.
    fn fill(&self, pixels: &mut [u32], column: i64, row: i64) {
        match self {
            Self::Solid(colour) if colour >> 24 == 255 => pixels.fill(colour & 0xff_ff_ff),
            Self::Solid(0) => {}
            Self::Solid(colour) => pixels.iter_mut().for_each(|pixel| *pixel = over(*colour, *pixel)),
            Self::Gradient(channels) => {
                let mut colours = Colours::new(channels, column, row);
                pixels.iter_mut().for_each(|pixel| *pixel = over(code(colours.next()), *pixel));
            }
            Self::Textured { texture, texel_position, tint } => {
                let texels = texture.row(texel_position, column, row);
                match tint {
                    Tint::None => texels.draw(pixels, |texel| texel),
                    Tint::One(colour) => texels.draw(pixels, |texel| times(texel, *colour)),
                    Tint::Gradient(channels) => {
                        let mut colours = Colours::new(channels, column, row);
                        texels.draw(pixels, |texel| times(texel, colours.next()));
                    }
                }
            }
        }
    }
}

/// Iterator over the colours of a span.
struct Colours {
    now: [f32; 4],
    step: [f32; 4],
}

impl Colours {
    fn new(channels: &[Linear; 4], column: i64, row: i64) -> Self {
        Self {
            // Half a step more, so that truncation rounds.
            now: channels.map(|channel| channel.at(column, row) as f32 + 0.5),
            step: channels.map(|channel| channel.right as f32),
        }
    }

    fn next(&mut self) -> Color32 {
        let [r, g, b, a] = self.now.map(|value| value as u8);
        for (now, step) in self.now.iter_mut().zip(self.step) {
            *now += step;
        }
        Color32::from_rgba_premultiplied(r, g, b, a)
    }
}

struct Texture<'a> {
    pixels: &'a [Color32],
    size: [usize; 2],
    delta: &'a ImageDelta,
}

impl<'a> Texture<'a> {
    /// `None` for a texture without pixels.
    fn new(delta: &'a ImageDelta) -> Option<Self> {
        let ImageData::Color(image) = &delta.image;
        let whole = image.pixels.len() == image.size[0] * image.size[1] && !image.pixels.is_empty();
        whole.then_some(Self { pixels: &image.pixels, size: image.size, delta })
    }

    /// Bilinear sample at texture coordinates from 0 to 1.
    fn at(&self, u: f32, v: f32) -> Color32 {
        let [width, height] = self.size.map(|side| side as f32);
        let texels = Texels {
            texture: self,
            now: [fixed(f64::from(u * width) - 0.5), fixed(f64::from(v * height) - 0.5)],
            step: [0, 0],
        };
        texels.between(texels.now)
    }

    /// Texels along a span; `texel_position` is in texels.
    fn row(&self, texel_position: &[Linear; 2], column: i64, row: i64) -> Texels<'_> {
        let step = texel_position.map(|axis| fixed(axis.right));
        let magnified = texel_position.iter().all(|axis| axis.right.abs().max(axis.down.abs()) <= 1.0);
        let filter = if magnified { self.delta.options.magnification } else { self.delta.options.minification };
        let mut now = texel_position.map(|axis| fixed(axis.at(column, row) - 0.5));
        if filter == TextureFilter::Nearest {
            now = now.map(|at| (at + (1 << (FRACTION - 1))) & !((1 << FRACTION) - 1));
        }
        Texels { texture: self, now, step }
    }

    /// A row of texels, clamped to the edge.
    fn line(&self, row: i64) -> &[Color32] {
        let row = row.clamp(0, self.size[1] as i64 - 1) as usize;
        &self.pixels[row * self.size[0]..(row + 1) * self.size[0]]
    }
}

/// Texture positions along a span; centres of texels are integers.
struct Texels<'a> {
    texture: &'a Texture<'a>,
    now: [i64; 2],
    step: [i64; 2],
}

impl Texels<'_> {
    fn draw(&self, pixels: &mut [u32], mut tint: impl FnMut(Color32) -> Color32) {
        let [x, y] = self.now;
        let whole = 1 << FRACTION;
        // Fast path: one texel per pixel, up to rounding.
        let near = |at: i64| (at + whole / 2).rem_euclid(whole).abs_diff(whole / 2) <= whole as u64 / 512;
        let drift = (self.step[0] - whole).unsigned_abs() * pixels.len() as u64;
        let first = (x + whole / 2) >> FRACTION;
        let last = first + pixels.len() as i64;
        if self.step[1] == 0
            && near(x)
            && near(y)
            && drift <= whole as u64 / 512
            && first >= 0
            && last <= self.texture.size[0] as i64
        {
            let line = &self.texture.line((y + whole / 2) >> FRACTION)[first as usize..last as usize];
            for (pixel, texel) in pixels.iter_mut().zip(line) {
                *pixel = over(code(tint(*texel)), *pixel);
            }
            return;
        }
        let mut now = self.now;
        for pixel in pixels {
            *pixel = over(code(tint(self.between(now))), *pixel);
            now = [now[0] + self.step[0], now[1] + self.step[1]];
        }
    }

    /// Bilinear interpolation of four texels.
    fn between(&self, [x, y]: [i64; 2]) -> Color32 {
        let (column, row) = (x >> FRACTION, y >> FRACTION);
        let part = |at: i64| (at >> (FRACTION - 8)) as u32 & 255;
        let (upper, lower) = (self.texture.line(row), self.texture.line(row + 1));
        let last = self.texture.size[0] as i64 - 1;
        let (left, right) = (column.clamp(0, last) as usize, (column + 1).clamp(0, last) as usize);
        let word = |colour: Color32| u32::from_ne_bytes(colour.to_array());
        let upper = mix(word(upper[left]), word(upper[right]), part(x));
        let lower = mix(word(lower[left]), word(lower[right]), part(x));
        let [r, g, b, a] = mix(upper, lower, part(y)).to_ne_bytes();
        Color32::from_rgba_premultiplied(r, g, b, a)
    }
}

/// Converts to fixed point with [`FRACTION`] bits.
fn fixed(at: f64) -> i64 {
    (at * f64::from(1 << FRACTION)).round() as i64
}

/// Mask of every other byte.
const BYTES: u32 = 0x00_ff_00_ff;

/// Interpolates two colours per channel; `part` is the weight of `b`, of 256.
fn mix(a: u32, b: u32, part: u32) -> u32 {
    let two = |a: u32, b: u32| ((a & BYTES) * (256 - part) + (b & BYTES) * part + 0x80_00_80) >> 8 & BYTES;
    two(a, b) | two(a >> 8, b >> 8) << 8
}

/// Product of two colours per channel.
fn times(a: Color32, b: Color32) -> Color32 {
    if b == Color32::WHITE {
        return a;
    }
    let (a, b) = (a.to_array(), b.to_array());
    let [r, g, b, a] = [0, 1, 2, 3].map(|k| {
        let product = u32::from(a[k]) * u32::from(b[k]) + 128;
        ((product + (product >> 8)) >> 8) as u8
    });
    Color32::from_rgba_premultiplied(r, g, b, a)
}

/// Packs a colour as `0xAARRGGBB`.
fn code(colour: Color32) -> u32 {
    let [r, g, b, a] = colour.to_array();
    u32::from_be_bytes([a, r, g, b])
}

/// Blends a premultiplied colour over a pixel. Colours brighter than their alpha add light, up to white.
fn over(colour: u32, pixel: u32) -> u32 {
    let rest = 255 - (colour >> 24);
    let two = |colour: u32, pixel: u32| {
        let kept = (pixel & BYTES) * rest + 0x80_00_80;
        let kept = (kept + (kept >> 8 & BYTES)) >> 8 & BYTES;
        let sum = (colour & BYTES) + kept;
        let above = sum & 0x1_00_01_00;
        (sum | (above - (above >> 8))) & BYTES
    };
    two(colour, pixel) | (two(colour >> 8 & 0xff, pixel >> 8 & 0xff) << 8)
}

#[cfg(test)]
mod tests;
