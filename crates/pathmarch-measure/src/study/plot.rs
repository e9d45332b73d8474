//! Plots: lines over two logarithmic axes, and bars over one; each as SVG and PNG.
//!
//! **Source.** Colours for all kinds of colour vision: Okabe and Ito 2008, "Color Universal Design".
//!
//! Text in PNG files uses the built-in font, so that none needs to be installed; in SVG files the viewer selects a
//! sans-serif font.

use image::ImageEncoder;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use pathmarch_cli::Failure;
pub use plotters::chart::SeriesLabelPosition;
use plotters::chart::{MeshStyle, SeriesLabelStyle};
use plotters::coord::ranged1d::Ranged;
use plotters::coord::{CoordTranslate, Shift};
use plotters::prelude::*;
use plotters::style::register_font;
use std::path::Path;

const FONT: &[u8] = include_bytes!("../../../pathmarch-scene/fonts/Cantarell-Regular.ttf");
const COLOURS: [RGBColor; 6] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
];
const GREY: RGBColor = RGBColor(120, 120, 120);
/// Resolution of PNG files, relative to SVG pixels.
const PNG_SCALE: u32 = 2;

/// A plot.
pub trait Plot {
    /// Width and height, SVG pixels.
    fn size(&self) -> (u32, u32);
    /// Draws the plot, scaled by a factor.
    fn draw<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>, factor: u32) -> Result<(), String>;
}

/// Writes `NAME.svg` and `NAME.png`.
pub fn save(directory: &Path, name: &str, plot: &impl Plot) -> Result<(), Failure> {
    register_font("sans-serif", FontStyle::Normal, FONT)
        .map_err(|_| Failure::Other("the font of plots cannot be read".to_owned()))?;
    let (width, height) = plot.size();
    let mut text = String::new();
    plot.draw(&SVGBackend::with_string(&mut text, (width, height)).into_drawing_area(), 1).map_err(Failure::Other)?;
    let path = directory.join(format!("{name}.svg"));
    std::fs::write(&path, text).map_err(|error| Failure::Other(format!("{}: {error}", path.display())))?;

    let (width, height) = (width * PNG_SCALE, height * PNG_SCALE);
    let mut pixels = vec![255; 3 * width as usize * height as usize];
    let area = BitMapBackend::with_buffer(&mut pixels, (width, height)).into_drawing_area();
    plot.draw(&area, PNG_SCALE).map_err(Failure::Other)?;
    drop(area);
    let path = directory.join(format!("{name}.png"));
    let mut png = Vec::new();
    PngEncoder::new_with_quality(&mut png, CompressionType::Best, FilterType::NoFilter)
        .write_image(&pixels, width, height, image::ExtendedColorType::Rgb8)
        .map_err(|error| Failure::Other(format!("{}: {error}", path.display())))?;
    std::fs::write(&path, png).map_err(|error| Failure::Other(format!("{}: {error}", path.display())))
}

/// Common style of all charts and their scale factor.
#[derive(Clone, Copy)]
struct Style(u32);

impl Style {
    fn text(self, size: u32) -> FontDesc<'static> {
        ("sans-serif", size * self.0).into_font()
    }

    /// Chart with a title; `left` is the width of the labels on the left, pixels.
    fn chart<'a, B: DrawingBackend>(
        self,
        area: &'a DrawingArea<B, Shift>,
        title: &str,
        left: u32,
    ) -> ChartBuilder<'a, 'static, B> {
        let mut chart = ChartBuilder::on(area);
        chart
            .caption(title, self.text(19))
            .margin(12 * self.0)
            .margin_right(30 * self.0)
            .x_label_area_size(46 * self.0)
            .y_label_area_size(left * self.0);
        chart
    }

    /// Grid and labels of the x axis.
    fn mesh<X, Y, B>(self, mesh: &mut MeshStyle<'_, '_, X, Y, B>, x: &str)
    where
        X: Ranged<ValueType = f64>,
        Y: Ranged,
        B: DrawingBackend,
    {
        mesh.x_desc(x)
            .axis_desc_style(self.text(15))
            .label_style(self.text(13))
            .x_label_formatter(&label)
            .bold_line_style(RGBColor(205, 205, 205).stroke_width(self.0))
            .light_line_style(RGBColor(238, 238, 238).stroke_width(self.0));
    }

    /// Legend; `sign` is the width of a series' symbol, pixels.
    fn legend<'a, B: DrawingBackend + 'a, C: CoordTranslate>(
        self,
        legend: &mut SeriesLabelStyle<'a, '_, B, C>,
        position: SeriesLabelPosition,
        sign: u32,
    ) {
        legend
            .position(position)
            .legend_area_size(sign * self.0)
            .margin(8 * self.0)
            .background_style(WHITE.mix(0.85))
            .border_style(RGBColor(190, 190, 190))
            .label_font(self.text(14));
    }
}

/// A line of a [`Lines`] plot.
pub struct Line {
    /// Name in the legend.
    pub name: String,
    /// Points; both coordinates are positive.
    pub points: Vec<(f64, f64)>,
    /// Published rather than measured: grey, without markers.
    pub is_guide: bool,
}

/// Lines over two logarithmic axes.
pub struct Lines {
    /// Title.
    pub title: String,
    /// Label of the x axis, with its unit.
    pub x: String,
    /// Label of the y axis, with its unit.
    pub y: String,
    /// Position of the legend.
    pub legend: SeriesLabelPosition,
    /// The lines.
    pub lines: Vec<Line>,
}

/// Range of all values, with a margin factor.
fn around(values: impl Iterator<Item = f64> + Clone, room: f64) -> std::ops::Range<f64> {
    let least = values.clone().fold(f64::INFINITY, f64::min);
    let most = values.fold(0.0, f64::max);
    if least > most { 0.1..10.0 } else { least / room..most * room }
}

/// Range of [`around`], extended to powers of ten: over few decades, Plotters draws no labels for other ends.
fn decades(values: impl Iterator<Item = f64> + Clone) -> std::ops::Range<f64> {
    let range = around(values, 1.1);
    10f64.powf(range.start.log10().floor())..10f64.powf(range.end.log10().ceil())
}

/// Label of a logarithmic axis.
fn label(value: &f64) -> String {
    if *value >= 0.000_99 && *value < 1e5 {
        format!("{}", (value * 1000.0).round() / 1000.0)
    } else {
        format!("{value:.0e}")
    }
}

impl Plot for Lines {
    fn size(&self) -> (u32, u32) {
        (760, 460)
    }

    fn draw<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>, factor: u32) -> Result<(), String> {
        let message = |error: DrawingAreaErrorKind<B::ErrorType>| error.to_string();
        let points = || self.lines.iter().flat_map(|line| line.points.iter());
        area.fill(&WHITE).map_err(message)?;
        let style = Style(factor);
        let mut chart = style
            .chart(area, &self.title, 74)
            .build_cartesian_2d(
                around(points().map(|point| point.0), 1.15).log_scale().base(2.0),
                decades(points().map(|point| point.1)).log_scale(),
            )
            .map_err(message)?;
        let mut mesh = chart.configure_mesh();
        style.mesh(&mut mesh, &self.x);
        mesh.y_desc(&self.y).y_label_formatter(&label).draw().map_err(message)?;
        let mut colours = COLOURS.iter().cycle();
        for line in &self.lines {
            let colour = if line.is_guide { GREY } else { *colours.next().unwrap_or(&BLACK) };
            let stroke = colour.stroke_width(if line.is_guide { factor } else { 2 * factor });
            chart
                .draw_series(LineSeries::new(line.points.iter().copied(), stroke))
                .map_err(message)?
                .label(&line.name)
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 18 * factor as i32, y)], stroke));
            if !line.is_guide {
                let mark = |point: &(f64, f64)| Circle::new(*point, 3 * factor, colour.filled());
                chart.draw_series(line.points.iter().map(mark)).map_err(message)?;
            }
        }
        let mut legend = chart.configure_series_labels();
        style.legend(&mut legend, self.legend.clone(), 26);
        legend.draw().map_err(message)?;
        area.present().map_err(message)
    }
}

/// Height of the legend, in groups of bars.
const LEGEND_HEIGHT: u32 = 3;

/// Horizontal bars over a logarithmic axis, in groups.
pub struct Bars {
    /// Title.
    pub title: String,
    /// Label of the x axis, with its unit.
    pub x: String,
    /// Names of the groups, from the top.
    pub groups: Vec<String>,
    /// Series: name, and one optional value per group. The last series is grey: published rather than measured.
    pub series: Vec<(String, Vec<Option<f64>>)>,
}

impl Plot for Bars {
    fn size(&self) -> (u32, u32) {
        (860, 110 + 30 * (self.groups.len() as u32 + LEGEND_HEIGHT))
    }

    fn draw<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>, factor: u32) -> Result<(), String> {
        let message = |error: DrawingAreaErrorKind<B::ErrorType>| error.to_string();
        let values = || self.series.iter().flat_map(|(_, values)| values.iter().flatten().copied());
        let range = decades(values());
        let (least, groups) = (range.start, self.groups.len());
        area.fill(&WHITE).map_err(message)?;
        let style = Style(factor);
        let mut chart = style
            .chart(area, &self.title, 180)
            .build_cartesian_2d(range.log_scale(), 0.0..groups as f64 + f64::from(LEGEND_HEIGHT))
            .map_err(message)?;
        // Plotters places labels at grid lines; draw the names beside the middle of their groups instead.
        let mut mesh = chart.configure_mesh();
        style.mesh(&mut mesh, &self.x);
        mesh.disable_y_mesh().y_labels(0).draw().map_err(message)?;
        let thickness = 0.8 / self.series.len().max(1) as f64;
        for (index, ((name, values), colour)) in self.series.iter().zip(COLOURS.iter().cycle()).enumerate() {
            let colour = if index + 1 == self.series.len() { &GREY } else { colour };
            let bars = values.iter().enumerate().filter_map(|(group, value)| {
                let top = (groups - group) as f64 - 0.1 - index as f64 * thickness;
                Some(Rectangle::new([(least, top - thickness), ((*value)?, top)], colour.filled()))
            });
            let swatch = 10 * factor as i32;
            chart.draw_series(bars).map_err(message)?.label(name).legend(move |(x, y)| {
                Rectangle::new([(x, y - swatch / 2), (x + swatch, y + swatch / 2)], colour.filled())
            });
        }
        for (group, name) in self.groups.iter().enumerate() {
            let (x, y) = chart.backend_coord(&(least, (groups - group) as f64 - 0.5));
            let anchor = plotters::style::text_anchor::Pos::new(
                plotters::style::text_anchor::HPos::Right,
                plotters::style::text_anchor::VPos::Center,
            );
            let text = style.text(13).color(&BLACK).pos(anchor);
            area.draw_text(name, &text, (x - 8 * factor as i32, y)).map_err(message)?;
        }
        let mut legend = chart.configure_series_labels();
        style.legend(&mut legend, SeriesLabelPosition::UpperRight, 20);
        legend.draw().map_err(message)?;
        area.present().map_err(message)
    }
}
