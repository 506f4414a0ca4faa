//! A sheet of points that becomes an SVG or a PNG.

use super::Drawing;
use crate::arguments::{PlotFile, PlotFormat};
use crate::failure::{Failure, exit};
use crate::output;
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{FontStyle, register_font};
use snowgrain_film::PixelRect;
use snowgrain_film::develop::Developed;
use snowgrain_formats::image::write_png_8;

/// Pixels a point: a PNG is sharp on fine screens, the whole numbers of an SVG are fine enough.
const PIXELS_OF_PNG: f64 = 2.0;
const UNITS_OF_SVG: f64 = 8.0;

/// Why a picture cannot be drawn.
#[derive(Debug)]
pub(in crate::command) struct Fault(String);

impl<E: std::error::Error + Send + Sync> From<DrawingAreaErrorKind<E>> for Fault {
    fn from(error: DrawingAreaErrorKind<E>) -> Self {
        Self(error.to_string())
    }
}

impl From<Fault> for Failure {
    fn from(fault: Fault) -> Self {
        Self::new(exit::BUG, format!("--plot: the picture cannot be drawn: {}", fault.0))
    }
}

/// Where a text stands about its point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Anchor {
    /// It begins there, half above.
    Left,
    /// It ends there, half above.
    Right,
    /// It is centred above the point.
    Above,
    /// It is centred below the point.
    Below,
    /// It is read upwards, centred on the point.
    Upwards,
}

/// A sheet, in points from its upper left corner.
pub(in crate::command) struct Canvas<B: DrawingBackend> {
    area: DrawingArea<B, Shift>,
    scale: f64,
}

impl<B: DrawingBackend> Canvas<B> {
    fn new(backend: B, scale: f64) -> Result<Self, Fault> {
        let area = backend.into_drawing_area();
        area.fill(&WHITE)?;
        Ok(Self { area, scale })
    }

    fn pixel(&self, [x, y]: [f64; 2]) -> (i32, i32) {
        ((x * self.scale).round() as i32, (y * self.scale).round() as i32)
    }

    /// A line through points.
    pub(super) fn line(
        &self,
        points: &[[f64; 2]],
        colour: RGBColor,
        width: f64,
    ) -> Result<(), Fault> {
        let pixels: Vec<(i32, i32)> = points.iter().map(|&point| self.pixel(point)).collect();
        let width = (width * self.scale).round().max(1.0) as u32;
        self.area.draw(&PathElement::new(pixels, colour.stroke_width(width)))?;
        Ok(())
    }

    /// The same in dashes, so long as the gaps between them.
    pub(super) fn dashes(
        &self,
        points: &[[f64; 2]],
        colour: RGBColor,
        (width, dash): (f64, f64),
    ) -> Result<(), Fault> {
        let mut gone = 0.0;
        for ends in points.windows(2) {
            let ([x0, y0], [x1, y1]) = (ends[0], ends[1]);
            let length = ((x1 - x0) * (x1 - x0) + (y1 - y0) * (y1 - y0)).sqrt();
            let at = |t: f64| [x0 + (x1 - x0) * t / length, y0 + (y1 - y0) * t / length];
            let mut from = 0.0;
            while from < length {
                let phase = (gone + from) % (2.0 * dash);
                let rest = if phase < dash { dash - phase } else { 2.0 * dash - phase };
                let to = (from + rest.max(1e-3)).min(length);
                if phase < dash {
                    self.line(&[at(from), at(to)], colour, width)?;
                }
                from = to;
            }
            gone += length;
        }
        Ok(())
    }

    /// An area within points.
    pub(super) fn area(&self, points: &[[f64; 2]], colour: RGBColor) -> Result<(), Fault> {
        let pixels: Vec<(i32, i32)> = points.iter().map(|&point| self.pixel(point)).collect();
        self.area.draw(&Polygon::new(pixels, colour.filled()))?;
        Ok(())
    }

    /// A round dot.
    pub(super) fn dot(&self, at: [f64; 2], radius: f64, colour: RGBColor) -> Result<(), Fault> {
        let radius = (radius * self.scale).round() as i32;
        self.area.draw(&Circle::new(self.pixel(at), radius, colour.filled()))?;
        Ok(())
    }

    /// A text of this height.
    pub(super) fn text(
        &self,
        text: &str,
        at: [f64; 2],
        size: f64,
        anchor: Anchor,
    ) -> Result<(), Fault> {
        self.coloured_text(text, at, (size, BLACK), anchor)
    }

    /// The same in a colour.
    pub(super) fn coloured_text(
        &self,
        text: &str,
        at: [f64; 2],
        (size, colour): (f64, RGBColor),
        anchor: Anchor,
    ) -> Result<(), Fault> {
        let (horizontal, vertical) = match anchor {
            Anchor::Left => (HPos::Left, VPos::Center),
            Anchor::Right => (HPos::Right, VPos::Center),
            Anchor::Above | Anchor::Upwards => (HPos::Center, VPos::Bottom),
            Anchor::Below => (HPos::Center, VPos::Top),
        };
        let font = ("sans-serif", size * self.scale).into_font();
        let font = match anchor {
            Anchor::Upwards => font.transform(FontTransform::Rotate270),
            _ => font,
        };
        let style = font.color(&colour).pos(Pos::new(horizontal, vertical));
        self.area.draw(&Text::new(text.to_owned(), self.pixel(at), style))?;
        Ok(())
    }
}

/// Draws the picture and writes it.
pub(super) fn write(file: &PlotFile, drawing: &impl Drawing) -> Result<(), Failure> {
    // The font that measures texts, and draws them in a PNG; an SVG names the reader's own.
    register_font("sans-serif", FontStyle::Normal, dejavu::sans::regular())
        .map_err(|_| Failure::from(Fault("its font is damaged".into())))?;
    let pixels = |scale: f64| drawing.size().map(|side| (side * scale).round() as u32);
    match file.format {
        PlotFormat::Svg => {
            let ([width, height], mut text) = (pixels(UNITS_OF_SVG), String::new());
            let canvas =
                Canvas::new(SVGBackend::with_string(&mut text, (width, height)), UNITS_OF_SVG)?;
            drawing.draw(&canvas)?;
            drop(canvas);
            let [points, units] = [drawing.size(), [width.into(), height.into()]];
            let head = |[w, h]: [f64; 2]| format!("<svg width=\"{w}\" height=\"{h}\"");
            output::write_text(&file.path, &text.replacen(&head(units), &head(points), 1))
        }
        PlotFormat::Png => {
            let [width, height] = pixels(PIXELS_OF_PNG);
            let mut values = vec![0; 3 * width as usize * height as usize];
            let backend = BitMapBackend::with_buffer(&mut values, (width, height));
            let canvas = Canvas::new(backend, PIXELS_OF_PNG)?;
            drawing.draw(&canvas)?;
            drop(canvas);
            let window = PixelRect::new(0, 0, width, height);
            Ok(write_png_8(&file.path, &Developed { window, values })?)
        }
    }
}
