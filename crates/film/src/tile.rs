//! Parts of a film, each filled by one thread at a time.

use crate::film::pixels_for;
use crate::light_layers::LayerSums;
use crate::pixel::add_all;
use crate::{
    FilmError, IcePathLayout, IcePaths, LearntSums, PixelRect, PixelSums, Sample, ShadowSums,
    ice_paths, learnt_light, light_layers, shadow_catcher,
};

/// What a film or tile keeps beside the sums of its pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Kept {
    /// Light by length in ice, if that.
    pub ice_paths: Option<IcePathLayout>,
    /// Number of layers of light; 0: none are kept.
    pub light_layers: usize,
    /// What shadow catchers show, if that.
    pub shadow_catcher: bool,
    /// How much light was learnt, if that.
    pub learnt_light: bool,
}

/// Exact sums of one rectangle of pixels, filled by one thread, then merged into a film.
#[derive(Clone, Debug, PartialEq)]
pub struct FilmTile {
    rect: PixelRect,
    pixels: Vec<PixelSums>,
    ice_paths: Option<IcePaths>,
    /// Of each pixel, the sums of each layer.
    layer_sums: Vec<LayerSums>,
    /// Of each pixel, if shadow catchers are kept.
    shadow_sums: Vec<ShadowSums>,
    /// Of each pixel, if learnt light is kept.
    learnt_sums: Vec<LearntSums>,
    kept: Kept,
}

impl FilmTile {
    /// An empty tile.
    ///
    /// # Errors
    /// [`FilmError::TooLarge`].
    pub fn new(rect: PixelRect) -> Result<Self, FilmError> {
        Self::keeping(rect, Kept::default())
    }

    /// An empty tile that keeps more than the sums of its pixels.
    ///
    /// # Errors
    /// [`FilmError::TooLarge`].
    pub fn keeping(rect: PixelRect, kept: Kept) -> Result<Self, FilmError> {
        let pixels = pixels_for(rect)?;
        let count = pixels.len();
        let ice_paths = kept.ice_paths.map(|layout| IcePaths::new(layout, count)).transpose()?;
        let layer_sums = light_layers::empty_sums(kept.light_layers, count)?;
        let shadow_sums = shadow_catcher::empty_sums(if kept.shadow_catcher { count } else { 0 })?;
        let learnt_sums = learnt_light::empty_sums(if kept.learnt_light { count } else { 0 })?;
        Ok(Self { rect, pixels, ice_paths, layer_sums, shadow_sums, learnt_sums, kept })
    }

    /// Its pixels.
    #[must_use]
    pub fn rect(&self) -> PixelRect {
        self.rect
    }

    /// Sums of its pixels in row-major order.
    #[must_use]
    pub fn pixels(&self) -> &[PixelSums] {
        &self.pixels
    }

    /// Adds one sample to pixel `(x, y)` of the picture; on an error nothing is added.
    ///
    /// # Errors
    /// A pixel outside the tile, a bad sample, or sums that leave their range.
    #[inline]
    pub fn add(&mut self, x: u32, y: u32, sample: &Sample) -> Result<(), FilmError> {
        let index =
            self.rect.index(x, y).ok_or(FilmError::OutsideTile { x, y, rect: self.rect })?;
        self.pixels[index].add_sample(sample).map_err(|refusal| refusal.of(x, y))
    }

    /// Adds a sample's light to the ice paths of a pixel, where they are kept: as
    /// [`FilmTileMut::add_ice_path`].
    ///
    /// # Errors
    /// As there.
    pub fn add_ice_path(
        &mut self,
        x: u32,
        y: u32,
        length: f64,
        weights: &[[f32; 3]],
    ) -> Result<(), FilmError> {
        let rect = self.rect;
        let Some(ice) = &mut self.ice_paths else { return Ok(()) };
        let index = rect.index(x, y).ok_or(FilmError::OutsideTile { x, y, rect })?;
        let layout = ice.layout();
        let sums = &mut ice.sums_mut()[index * layout.sums()..][..layout.sums()];
        if layout.add(sums, length, weights) { Ok(()) } else { Err(FilmError::Overflow { x, y }) }
    }

    /// Adds a sample's light to the layers of a pixel, where they are kept: as
    /// [`FilmTileMut::add_light_layers`].
    ///
    /// # Errors
    /// As there.
    pub fn add_light_layers(
        &mut self,
        x: u32,
        y: u32,
        radiance: [f32; 3],
        layers: &[[f32; 3]],
    ) -> Result<(), FilmError> {
        let (rect, count) = (self.rect, self.kept.light_layers);
        if count == 0 {
            return Ok(());
        }
        let index = rect.index(x, y).ok_or(FilmError::OutsideTile { x, y, rect })?;
        let sums = &mut self.layer_sums[index * count..][..count];
        light_layers::add(sums, radiance, layers).map_err(|refused| refused.of(x, y))
    }

    /// Adds what a sample shows of a shadow catcher to a pixel, where that is kept: as
    /// [`FilmTileMut::add_caught_light`].
    ///
    /// # Errors
    /// As there.
    pub fn add_caught_light(
        &mut self,
        x: u32,
        y: u32,
        lit: [f32; 3],
        unoccluded: [f32; 3],
    ) -> Result<(), FilmError> {
        if !self.kept.shadow_catcher {
            return Ok(());
        }
        let rect = self.rect;
        let index = rect.index(x, y).ok_or(FilmError::OutsideTile { x, y, rect })?;
        shadow_catcher::add(&mut self.shadow_sums[index], lit, unoccluded)
            .map_err(|refused| refused.of(x, y))
    }

    /// Adds what a sample learnt to a pixel, where that is kept: as [`FilmTileMut::add_learnt_light`].
    ///
    /// # Errors
    /// As there.
    pub fn add_learnt_light(
        &mut self,
        x: u32,
        y: u32,
        light: f32,
        error: f32,
    ) -> Result<(), FilmError> {
        if !self.kept.learnt_light {
            return Ok(());
        }
        let rect = self.rect;
        let index = rect.index(x, y).ok_or(FilmError::OutsideTile { x, y, rect })?;
        learnt_light::add(&mut self.learnt_sums[index], light, error)
            .map_err(|refused| refused.of(x, y))
    }

    /// Forgets all samples, to be used again.
    pub fn clear(&mut self) {
        self.pixels.fill(PixelSums::default());
        self.layer_sums.fill([0; 3]);
        self.shadow_sums.fill([0; 7]);
        self.learnt_sums.fill([0; 2]);
        if let Some(ice) = &mut self.ice_paths {
            ice.sums_mut().fill(0);
        }
    }
}

/// A rectangle of a film's own pixels: see [`crate::Film::tiles_mut`].
#[derive(Debug)]
pub struct FilmTileMut<'a> {
    rect: PixelRect,
    kept: Kept,
    /// Row by row; together all pixels of the rectangle.
    pub(crate) rows: Vec<&'a mut [PixelSums]>,
    /// Their ice paths, where those are kept.
    pub(crate) ice_rows: Vec<&'a mut [i64]>,
    /// Their layers of light, where those are kept.
    pub(crate) layer_rows: Vec<&'a mut [LayerSums]>,
    /// What shadow catchers show in them, where that is kept.
    pub(crate) shadow_rows: Vec<&'a mut [ShadowSums]>,
    /// How much light was learnt in them, where that is kept.
    pub(crate) learnt_rows: Vec<&'a mut [LearntSums]>,
}

impl FilmTileMut<'_> {
    /// To be given its rows.
    pub(crate) fn without_rows(rect: PixelRect, kept: Kept) -> Self {
        let height = rect.height() as usize;
        let ice_rows = Vec::with_capacity(if kept.ice_paths.is_some() { height } else { 0 });
        let layer_rows = Vec::with_capacity(if kept.light_layers > 0 { height } else { 0 });
        let shadow_rows = Vec::with_capacity(if kept.shadow_catcher { height } else { 0 });
        let learnt_rows = Vec::with_capacity(if kept.learnt_light { height } else { 0 });
        let rows = Vec::with_capacity(height);
        Self { rect, kept, rows, ice_rows, layer_rows, shadow_rows, learnt_rows }
    }

    /// Its pixels.
    #[must_use]
    pub fn rect(&self) -> PixelRect {
        self.rect
    }

    /// An empty tile of the same pixels that keeps the same.
    ///
    /// # Errors
    /// [`FilmError::TooLarge`].
    pub fn empty_copy(&self) -> Result<FilmTile, FilmError> {
        FilmTile::keeping(self.rect, self.kept)
    }

    /// Takes over all sums of a tile of the same pixels that keeps the same.
    ///
    /// # Panics
    /// If the other tile is of other pixels or keeps something else.
    pub fn copy_from(&mut self, other: &FilmTileMut<'_>) {
        assert_eq!(self.rect, other.rect, "only tiles of the same pixels are copied");
        assert_eq!(self.kept, other.kept, "only tiles that keep the same are copied");
        copy_rows(&mut self.rows, &other.rows);
        copy_rows(&mut self.ice_rows, &other.ice_rows);
        copy_rows(&mut self.layer_rows, &other.layer_rows);
        copy_rows(&mut self.shadow_rows, &other.shadow_rows);
        copy_rows(&mut self.learnt_rows, &other.learnt_rows);
    }

    /// The sums of pixel `(x, y)` of the picture; `None` outside the tile.
    #[must_use]
    pub fn pixel(&self, x: u32, y: u32) -> Option<&PixelSums> {
        self.rect
            .contains(x, y)
            .then(|| &self.rows[(y - self.rect.y0) as usize][(x - self.rect.x0) as usize])
    }

    /// Adds one sample to pixel `(x, y)` of the picture; on an error nothing is added.
    ///
    /// # Errors
    /// A pixel outside the tile, a bad sample, or sums that leave their range.
    #[inline]
    pub fn add(&mut self, x: u32, y: u32, sample: &Sample) -> Result<(), FilmError> {
        if !self.rect.contains(x, y) {
            return Err(FilmError::OutsideTile { x, y, rect: self.rect });
        }
        let pixel = &mut self.rows[(y - self.rect.y0) as usize][(x - self.rect.x0) as usize];
        pixel.add_sample(sample).map_err(|refusal| refusal.of(x, y))
    }

    /// Adds a sample's light to the ice paths of pixel `(x, y)`, where they are kept: `weights`, for
    /// each spectrum of lights the light's radiance times the albedos met, has passed through `length`
    /// metres of ice.
    ///
    /// # Errors
    /// A pixel outside the tile; weights that are no numbers or leave the range of the sums.
    pub fn add_ice_path(
        &mut self,
        x: u32,
        y: u32,
        length: f64,
        weights: &[[f32; 3]],
    ) -> Result<(), FilmError> {
        let Some(layout) = self.kept.ice_paths else { return Ok(()) };
        if !self.rect.contains(x, y) {
            return Err(FilmError::OutsideTile { x, y, rect: self.rect });
        }
        let row = &mut self.ice_rows[(y - self.rect.y0) as usize];
        let sums = &mut row[(x - self.rect.x0) as usize * layout.sums()..][..layout.sums()];
        if layout.add(sums, length, weights) { Ok(()) } else { Err(FilmError::Overflow { x, y }) }
    }

    /// Adds a sample's light to the layers of pixel `(x, y)`, where they are kept: its `radiance`, as the
    /// sample has it, parted into one radiance for each layer. On an error nothing is added.
    ///
    /// # Errors
    /// A pixel outside the tile; layers that do not add up to the radiance but for what rounding leaves, or
    /// that leave the range of the sums.
    pub fn add_light_layers(
        &mut self,
        x: u32,
        y: u32,
        radiance: [f32; 3],
        layers: &[[f32; 3]],
    ) -> Result<(), FilmError> {
        let (rect, count) = (self.rect, self.kept.light_layers);
        if count == 0 {
            return Ok(());
        }
        if !rect.contains(x, y) {
            return Err(FilmError::OutsideTile { x, y, rect });
        }
        let row = &mut self.layer_rows[(y - rect.y0) as usize];
        let sums = &mut row[(x - rect.x0) as usize * count..][..count];
        light_layers::add(sums, radiance, layers).map_err(|refused| refused.of(x, y))
    }

    /// Adds what a sample shows of a shadow catcher to pixel `(x, y)`, where that is kept: the radiance that
    /// the catcher shows and the one that it would show alone ([`crate::shadow_catcher`]). On an error nothing is
    /// added.
    ///
    /// # Errors
    /// A pixel outside the tile; radiances that are no numbers or leave the range of the sums.
    pub fn add_caught_light(
        &mut self,
        x: u32,
        y: u32,
        lit: [f32; 3],
        unoccluded: [f32; 3],
    ) -> Result<(), FilmError> {
        let rect = self.rect;
        if !self.kept.shadow_catcher {
            return Ok(());
        }
        if !rect.contains(x, y) {
            return Err(FilmError::OutsideTile { x, y, rect });
        }
        let row = &mut self.shadow_rows[(y - rect.y0) as usize];
        shadow_catcher::add(&mut row[(x - rect.x0) as usize], lit, unoccluded)
            .map_err(|refused| refused.of(x, y))
    }

    /// Adds what a sample learnt to pixel `(x, y)`, where that is kept: how much of its radiance that is, and its standard
    /// error ([`crate::learnt_light`]). On an error nothing is added.
    ///
    /// # Errors
    /// A pixel outside the tile; numbers that are none or leave the range of the sums.
    pub fn add_learnt_light(
        &mut self,
        x: u32,
        y: u32,
        light: f32,
        error: f32,
    ) -> Result<(), FilmError> {
        let rect = self.rect;
        if !self.kept.learnt_light {
            return Ok(());
        }
        if !rect.contains(x, y) {
            return Err(FilmError::OutsideTile { x, y, rect });
        }
        let row = &mut self.learnt_rows[(y - rect.y0) as usize];
        learnt_light::add(&mut row[(x - rect.x0) as usize], light, error)
            .map_err(|refused| refused.of(x, y))
    }

    /// Adds the sums of a tile of the same pixels that keeps the same; on an error nothing is added.
    ///
    /// # Errors
    /// Sums that leave their range.
    ///
    /// # Panics
    /// If the other tile is of other pixels or keeps something else.
    pub fn merge(&mut self, other: &FilmTile) -> Result<(), FilmError> {
        assert_eq!(self.rect, other.rect, "only tiles of the same pixels are merged");
        assert_eq!(self.kept, other.kept, "only tiles that keep the same are merged");
        self.add_sums(&Sums {
            pixels: &other.pixels,
            ice: other.ice_paths.as_ref().map_or(&[][..], IcePaths::sums),
            layers: &other.layer_sums,
            shadows: &other.shadow_sums,
            learnt: &other.learnt_sums,
        })
    }

    /// Adds row-major sums of its pixels; on an error nothing is added.
    pub(crate) fn add_sums(&mut self, sums: &Sums<'_>) -> Result<(), FilmError> {
        let Sums { pixels, ice, layers, shadows, learnt } = *sums;
        let rect = self.rect;
        let overflow = |(row, column): (usize, usize)| FilmError::Overflow {
            x: rect.x0 + column as u32,
            y: rect.y0 + row as u32,
        };
        let width = rect.width().max(1) as usize;
        let ice_stride = self.kept.ice_paths.map_or(1, IcePathLayout::sums);
        let layer_stride = self.kept.light_layers.max(1);
        let added_ice = ice.chunks(width * ice_stride);
        let added_layers = layers.chunks(width * layer_stride);
        let ice_place = first_overflow(&self.ice_rows, added_ice.clone(), ice_paths::overflow)
            .map(|(row, index)| (row, index / ice_stride));
        let layer_place =
            first_overflow(&self.layer_rows, added_layers.clone(), light_layers::overflow_of)
                .map(|(row, index)| (row, index / layer_stride));
        let added_shadows = shadows.chunks(width);
        let shadow_place =
            first_overflow(&self.shadow_rows, added_shadows.clone(), light_layers::overflow_of);
        let added_learnt = learnt.chunks(width);
        let learnt_place =
            first_overflow(&self.learnt_rows, added_learnt.clone(), light_layers::overflow_of);
        let place = ice_place.or(layer_place).or(shadow_place).or(learnt_place);
        place.map_or(Ok(()), |place| Err(overflow(place)))?;
        add_rows(&mut self.rows, pixels.chunks(width)).map_err(overflow)?;
        for (row, added) in self.ice_rows.iter_mut().zip(added_ice) {
            row.iter_mut().zip(added).for_each(|(sum, added)| *sum += added);
        }
        let layers = self.layer_rows.iter_mut().zip(added_layers);
        let layers = layers.map(|(row, added)| (row.as_flattened_mut(), added.as_flattened()));
        let shadows = self.shadow_rows.iter_mut().zip(added_shadows);
        let shadows = shadows.map(|(row, added)| (row.as_flattened_mut(), added.as_flattened()));
        let learnt = self.learnt_rows.iter_mut().zip(added_learnt);
        let learnt = learnt.map(|(row, added)| (row.as_flattened_mut(), added.as_flattened()));
        for (row, added) in layers.chain(shadows).chain(learnt) {
            row.iter_mut().zip(added).for_each(|(sum, added)| *sum += added);
        }
        Ok(())
    }
}

/// Row-major sums of all pixels of a rectangle; none of what is not kept.
#[derive(Clone, Copy)]
pub(crate) struct Sums<'a> {
    pub(crate) pixels: &'a [PixelSums],
    pub(crate) ice: &'a [i64],
    pub(crate) layers: &'a [LayerSums],
    pub(crate) shadows: &'a [ShadowSums],
    pub(crate) learnt: &'a [LearntSums],
}

/// Copies rows of the same lengths.
fn copy_rows<T: Copy>(rows: &mut [&mut [T]], from: &[&mut [T]]) {
    rows.iter_mut().zip(from).for_each(|(row, from)| row.copy_from_slice(from));
}

/// The row, and the index in it, of the first sum that would leave its range.
fn first_overflow<'a, T: 'a>(
    rows: &[&mut [T]],
    added: impl Iterator<Item = &'a [T]>,
    overflow: impl Fn(&[T], &[T]) -> Option<usize>,
) -> Option<(usize, usize)> {
    let found = rows.iter().zip(added).map(|(row, added)| overflow(row, added)).enumerate();
    found.filter_map(|(row, index)| Some((row, index?))).next()
}

/// Adds rows of sums to others, or nothing where one does not fit; then says at which row and column.
pub(crate) fn add_rows<'a>(
    rows: &mut [impl AsMut<[PixelSums]>],
    added: impl Iterator<Item = &'a [PixelSums]> + Clone,
) -> Result<(), (usize, usize)> {
    let failed = rows
        .iter_mut()
        .zip(added.clone())
        .map(|(row, added)| add_all(row.as_mut(), added))
        .enumerate()
        .find_map(|(row, result)| result.err().map(|column| (row, column)));
    let Some((row, column)) = failed else { return Ok(()) };
    for (row, added) in rows.iter_mut().zip(added).take(row) {
        row.as_mut().iter_mut().zip(added).for_each(|(sum, added)| sum.withdraw(added));
    }
    Err((row, column))
}
