//! Pictures of all roads side by side.

use super::case::SIZE;
use anyhow::Result;
use snowgrain_film::develop::{Development, to_8_bit};
use snowgrain_film::{Film, Layer, Picture, PixelRect};
use std::path::Path;

/// Pixels of the sheet to one of a picture, and between pictures.
const ZOOM: u32 = 3;
const GAP: u32 = 4;

/// Rows of pictures; an empty place where a road does not know a light.
#[derive(Default)]
pub(super) struct Sheet {
    rows: Vec<Vec<Option<Vec<[f64; 3]>>>>,
}

impl Sheet {
    pub(super) fn begin_row(&mut self) {
        self.rows.push(Vec::new());
    }

    pub(super) fn add(&mut self, film: Option<&Film>) {
        let colours =
            film.map(|film| film.pixels().iter().map(|pixel| pixel.mean_radiance()).collect());
        if let Some(row) = self.rows.last_mut() {
            row.push(colours);
        }
    }

    /// Each row as bright as makes its first picture's brightest twentieth white.
    pub(super) fn write(&self, file: &Path) -> Result<()> {
        let columns = self.rows.iter().map(Vec::len).max().unwrap_or(0) as u32;
        let step = SIZE * ZOOM + GAP;
        let (width, height) = (columns * step, self.rows.len() as u32 * step);
        let mut layers = vec![vec![1.0f32; (width * height) as usize]; 3];
        for (row, pictures) in self.rows.iter().enumerate() {
            let white = pictures.first().and_then(Option::as_ref).map_or(1.0, |first| {
                let mut greens: Vec<f64> = first.iter().map(|colour| colour[1]).collect();
                greens.sort_by(f64::total_cmp);
                greens[greens.len() * 19 / 20]
            });
            for (column, picture) in pictures.iter().enumerate() {
                let Some(picture) = picture else { continue };
                let corner = [column as u32 * step, row as u32 * step];
                for y in 0..SIZE * ZOOM {
                    for x in 0..SIZE * ZOOM {
                        let colour = picture[(y / ZOOM * SIZE + x / ZOOM) as usize];
                        let at = ((corner[1] + y) * width + corner[0] + x) as usize;
                        for (layer, value) in layers.iter_mut().zip(colour) {
                            layer[at] = (0.9 * value / white) as f32;
                        }
                    }
                }
            }
        }
        let mut picture = Picture::new(width, height, PixelRect::new(0, 0, width, height))?;
        for (layer, values) in Layer::COLOUR.into_iter().zip(layers) {
            picture.set_layer(layer, values)?;
        }
        snowgrain_formats::image::write_png_8(file, &to_8_bit(&picture, &Development::default())?)?;
        Ok(())
    }
}
