//! Pictures of tables: lines on axes, and hemispheres of directions.

mod axis;
mod canvas;
mod chart;
mod hemisphere;
mod series;

pub(in crate::command) use axis::Scale;
pub(in crate::command) use chart::{Chart, Charts};
pub(in crate::command) use hemisphere::{Hemisphere, Hemispheres};
pub(in crate::command) use series::Line;
pub(super) use series::{Keys, lines_of};

use crate::arguments::PlotFile;
use crate::failure::Failure;
use canvas::{Canvas, Fault};
use plotters::prelude::DrawingBackend;

/// Something that can be drawn on a sheet.
pub(in crate::command) trait Drawing {
    /// Width and height of the sheet, in points.
    fn size(&self) -> [f64; 2];

    /// Draws it.
    fn draw<B: DrawingBackend>(&self, canvas: &Canvas<B>) -> Result<(), Fault>;
}

/// Draws the picture and writes it, whole or not at all.
pub(in crate::command) fn write(file: &PlotFile, drawing: &impl Drawing) -> Result<(), Failure> {
    canvas::write(file, drawing)
}
