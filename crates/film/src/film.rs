//! The film: exact sums of every pixel, and what they are sums of.

use crate::tile::Sums;
use crate::{
    BlockCounts, FilmError, FilmTile, FilmTileMut, IcePathLayout, IcePaths, Kept, LearntSums,
    LightLayerNames, LightLayers, PixelRect, PixelSums, SampleRanges, ShadowSums, learnt_light,
    shadow_catcher,
};
use snowgrain_optics::Grade;
use std::ops::Range;

/// What decides the samples of a film, together with their indices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FilmIdentity {
    /// Hash of the resolved scene.
    pub scene_hash: [u8; 32],
    /// Seed of the sampler.
    pub seed: u64,
}

/// Exact sums over the samples of a picture; 208 bytes per pixel of the crop, and those of
/// [`IcePathLayout::bytes`] where ice paths and of [`LightLayerNames::bytes`] where layers of light are
/// kept; 112 more where it has shadow catchers, 32 where light is learnt.
///
/// Films of the same picture and of different samples merge in any order to the same bytes.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    width: u32,
    height: u32,
    crop: PixelRect,
    identity: FilmIdentity,
    samples: SampleRanges,
    block_counts: Option<BlockCounts>,
    pixels: Vec<PixelSums>,
    /// What turned lengths in ice into the colours of the sums.
    pub grade: Grade,
    /// Vertical field of view of the whole picture, degrees, if known.
    pub vertical_fov_degrees: Option<f64>,
    /// Digest of what was asked for, which is known before anything of the scene is made: its description
    /// and the version of the program.
    pub recipe: Option<[u8; 32]>,
    ice_paths: Option<IcePaths>,
    light_layers: Option<LightLayers>,
    /// Of each pixel, where there are shadow catchers.
    shadow_sums: Option<Vec<ShadowSums>>,
    /// Of each pixel, where light is learnt.
    learnt_sums: Option<Vec<LearntSums>>,
}

impl Film {
    /// An empty film of a picture of `width` x `height` pixels, of which only `crop` is kept.
    ///
    /// # Errors
    /// A crop that is empty or leaves the picture; more pixels than memory.
    pub fn new(
        width: u32,
        height: u32,
        crop: PixelRect,
        identity: FilmIdentity,
    ) -> Result<Self, FilmError> {
        if crop.is_empty() || !PixelRect::new(0, 0, width, height).encloses(&crop) {
            return Err(FilmError::BadCrop { crop, width, height });
        }
        let pixels = pixels_for(crop)?;
        Ok(Self {
            width,
            height,
            crop,
            identity,
            samples: SampleRanges::default(),
            block_counts: None,
            pixels,
            grade: Grade::default(),
            vertical_fov_degrees: None,
            recipe: None,
            ice_paths: None,
            light_layers: None,
            shadow_sums: None,
            learnt_sums: None,
        })
    }

    /// The same film, empty of samples, whose pixels are to hold only samples below the counts of their
    /// blocks.
    ///
    /// # Errors
    /// Counts of another crop.
    pub fn with_block_counts(mut self, counts: BlockCounts) -> Result<Self, FilmError> {
        if counts.crop() != self.crop {
            let (tile, crop) = (counts.crop(), self.crop);
            return Err(FilmError::TileOutsideFilm { tile, crop });
        }
        self.block_counts = Some(counts);
        Ok(self)
    }

    /// How many samples the pixels of each block are to have, where blocks differ.
    #[must_use]
    pub fn block_counts(&self) -> Option<&BlockCounts> {
        self.block_counts.as_ref()
    }

    /// The same film, empty of ice paths, that keeps them from now on.
    ///
    /// # Errors
    /// More than memory.
    pub fn keeping_ice_paths(mut self, layout: IcePathLayout) -> Result<Self, FilmError> {
        self.ice_paths = Some(IcePaths::new(layout, self.pixels.len())?);
        Ok(self)
    }

    /// The same film, empty of layers of light, that keeps them from now on.
    ///
    /// # Errors
    /// More than memory.
    pub fn keeping_light_layers(mut self, layers: LightLayerNames) -> Result<Self, FilmError> {
        self.light_layers = Some(LightLayers::new(layers, self.pixels.len())?);
        Ok(self)
    }

    /// The same film, empty of what shadow catchers show, that keeps it from now on.
    ///
    /// # Errors
    /// More than memory.
    pub fn keeping_shadow_catcher(mut self) -> Result<Self, FilmError> {
        self.shadow_sums = Some(shadow_catcher::empty_sums(self.pixels.len())?);
        Ok(self)
    }

    /// The same film, empty of what is known of learnt light, that keeps it from now on.
    ///
    /// # Errors
    /// More than memory.
    pub fn keeping_learnt_light(mut self) -> Result<Self, FilmError> {
        self.learnt_sums = Some(learnt_light::empty_sums(self.pixels.len())?);
        Ok(self)
    }

    /// A film of the same picture that keeps the same, without samples.
    ///
    /// # Errors
    /// More than memory.
    pub fn empty_copy(&self) -> Result<Self, FilmError> {
        let mut film = self.empty_copy_of(self.crop)?;
        film.block_counts = self.block_counts.clone();
        Ok(film)
    }

    /// The same of another crop, without counts of samples by block.
    pub(crate) fn empty_copy_of(&self, crop: PixelRect) -> Result<Self, FilmError> {
        let mut film = Self::new(self.width, self.height, crop, self.identity)?;
        film.grade = self.grade.clone();
        film.vertical_fov_degrees = self.vertical_fov_degrees;
        film.recipe = self.recipe;
        if let Some(paths) = &self.ice_paths {
            film = film.keeping_ice_paths(paths.layout())?;
        }
        if let Some(light) = &self.light_layers {
            film = film.keeping_light_layers(light.layers().clone())?;
        }
        if self.shadow_sums.is_some() {
            film = film.keeping_shadow_catcher()?;
        }
        if self.learnt_sums.is_some() {
            film = film.keeping_learnt_light()?;
        }
        Ok(film)
    }

    /// Its light in layers, if it keeps that.
    #[must_use]
    pub fn light_layers(&self) -> Option<&LightLayers> {
        self.light_layers.as_ref()
    }

    /// The same, to be filled by a reader of film files.
    pub fn light_layers_mut(&mut self) -> Option<&mut LightLayers> {
        self.light_layers.as_mut()
    }

    /// What shadow catchers show in each pixel, if it keeps that.
    #[must_use]
    pub fn shadow_sums(&self) -> Option<&[ShadowSums]> {
        self.shadow_sums.as_deref()
    }

    /// The same, to be filled by a reader of film files.
    pub fn shadow_sums_mut(&mut self) -> Option<&mut [ShadowSums]> {
        self.shadow_sums.as_deref_mut()
    }

    /// How much light of each pixel was learnt, if it keeps that.
    #[must_use]
    pub fn learnt_sums(&self) -> Option<&[LearntSums]> {
        self.learnt_sums.as_deref()
    }

    /// The same, to be filled by a reader of film files.
    pub fn learnt_sums_mut(&mut self) -> Option<&mut [LearntSums]> {
        self.learnt_sums.as_deref_mut()
    }

    /// What it keeps beside the sums of its pixels.
    #[must_use]
    pub fn kept(&self) -> Kept {
        Kept {
            ice_paths: self.ice_paths.as_ref().map(IcePaths::layout),
            light_layers: self.light_layers.as_ref().map_or(0, |light| light.layers().count()),
            shadow_catcher: self.shadow_sums.is_some(),
            learnt_light: self.learnt_sums.is_some(),
        }
    }

    /// Its light by length in ice, if it keeps that.
    #[must_use]
    pub fn ice_paths(&self) -> Option<&IcePaths> {
        self.ice_paths.as_ref()
    }

    /// The same, to be filled by a reader of film files.
    pub fn ice_paths_mut(&mut self) -> Option<&mut IcePaths> {
        self.ice_paths.as_mut()
    }

    /// Pixels across of the whole picture.
    #[must_use]
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Pixels down of the whole picture.
    #[must_use]
    pub fn height(&self) -> u32 {
        self.height
    }

    /// The pixels that are kept.
    #[must_use]
    pub fn crop(&self) -> PixelRect {
        self.crop
    }

    /// What decides its samples.
    #[must_use]
    pub fn identity(&self) -> FilmIdentity {
        self.identity
    }

    /// The samples that every pixel has; where blocks have counts, those below the count of its block.
    #[must_use]
    pub fn samples(&self) -> &SampleRanges {
        &self.samples
    }

    /// Sums of the pixels of the crop in row-major order.
    #[must_use]
    pub fn pixels(&self) -> &[PixelSums] {
        &self.pixels
    }

    /// The same, to be filled by a reader of film files.
    pub fn pixels_mut(&mut self) -> &mut [PixelSums] {
        &mut self.pixels
    }

    /// Adds the sums of a tile; on an error nothing is added.
    ///
    /// # Errors
    /// A tile that leaves the crop; sums that leave their range.
    pub fn merge_tile(&mut self, tile: &FilmTile) -> Result<(), FilmError> {
        let rect = tile.rect();
        if rect.is_empty() {
            return Ok(());
        }
        if !self.crop.encloses(&rect) {
            return Err(FilmError::TileOutsideFilm { tile: rect, crop: self.crop });
        }
        self.part_mut(rect).merge(tile)
    }

    /// Notes that every pixel now holds these samples: to be called when all tiles of a pass over
    /// the crop are merged. Samples in the pixels that are not noted make a film that cannot be
    /// continued without counting them twice.
    ///
    /// # Errors
    /// An empty range, or samples that were noted already.
    pub fn record_samples(&mut self, range: Range<u64>) -> Result<(), FilmError> {
        self.samples.insert(range)
    }

    /// Adds the samples of another film of the same picture; on an error nothing is added.
    ///
    /// # Errors
    /// Films of different size, crop, scene or seed; samples that are in both; sums that leave
    /// their range.
    pub fn merge(&mut self, other: &Self) -> Result<(), FilmError> {
        self.check_same_but_crop(other)?;
        if self.crop != other.crop {
            let (ours, theirs) = (self.crop.to_string(), other.crop.to_string());
            return Err(FilmError::FilmsDiffer { what: "crop", ours, theirs });
        }
        let mut samples = self.samples.clone();
        samples.insert_all(&other.samples)?;
        self.part_mut(other.crop).add_sums(&other.sums())?;
        self.samples = samples;
        self.recipe = self.recipe.filter(|_| self.recipe == other.recipe);
        Ok(())
    }

    /// Puts a film of a part of the crop into its place, where nothing is yet, and takes over its samples.
    pub(crate) fn place(&mut self, part: &Self) -> Result<(), FilmError> {
        self.part_mut(part.crop).add_sums(&part.sums())?;
        self.samples = part.samples.clone();
        self.recipe = self.recipe.filter(|_| self.recipe == part.recipe);
        Ok(())
    }

    /// All its sums.
    fn sums(&self) -> Sums<'_> {
        Sums {
            pixels: &self.pixels,
            ice: self.ice_paths.as_ref().map_or(&[][..], IcePaths::sums),
            layers: self.light_layers.as_ref().map_or(&[][..], LightLayers::sums),
            shadows: self.shadow_sums.as_deref().unwrap_or_default(),
            learnt: self.learnt_sums.as_deref().unwrap_or_default(),
        }
    }

    pub(crate) fn check_same_but_crop(&self, other: &Self) -> Result<(), FilmError> {
        let differ = |what, ours: String, theirs: String| {
            if ours == theirs { Ok(()) } else { Err(FilmError::FilmsDiffer { what, ours, theirs }) }
        };
        let size = |film: &Self| format!("{}x{}", film.width, film.height);
        differ("size", size(self), size(other))?;
        let hash = |film: &Self| hexadecimal(&film.identity.scene_hash);
        differ("scene", hash(self), hash(other))?;
        differ("seed", self.identity.seed.to_string(), other.identity.seed.to_string())?;
        let counts = |film: &Self| match &film.block_counts {
            None => "the same everywhere".to_owned(),
            Some(counts) => format!(
                "{} in all for a relative error of {}",
                counts.total(),
                counts.relative_error()
            ),
        };
        differ("samples by block", counts(self), counts(other))?;
        let kept = |film: &Self| match film.ice_paths.as_ref().map(IcePaths::layout) {
            None => "not kept".to_owned(),
            Some(IcePathLayout { lights, scale_exponent }) => {
                format!("of {lights} lights, scale 2^{scale_exponent}")
            }
        };
        differ("ice paths", kept(self), kept(other))?;
        let kept = |film: &Self| match film.light_layers.as_ref().map(LightLayers::layers) {
            None => "not kept".to_owned(),
            Some(layers) => {
                format!("{} of slots {:?}", layers.names().join(", "), layers.layer_of_slot())
            }
        };
        differ("layers of light", kept(self), kept(other))?;
        let kept = |film: &Self| film.shadow_sums.is_some().to_string();
        differ("shadow catchers", kept(self), kept(other))?;
        let kept = |film: &Self| film.learnt_sums.is_some().to_string();
        differ("learnt light", kept(self), kept(other))
    }

    /// The pixels of the crop as tiles of at most `side` x `side`, as [`PixelRect::tiles`] orders them,
    /// to be filled by several threads in place.
    pub fn tiles_mut(&mut self, side: u32) -> Vec<FilmTileMut<'_>> {
        let side = side.max(1);
        let kept = self.kept();
        let mut tiles: Vec<_> =
            self.crop.tiles(side).map(|rect| FilmTileMut::without_rows(rect, kept)).collect();
        let grid = TileGrid { crop: self.crop, side };
        grid.deal(&mut self.pixels, 1, &mut tiles, |tile, piece| tile.rows.push(piece));
        if let Some(ice) = &mut self.ice_paths {
            let stride = ice.layout().sums();
            grid.deal(ice.sums_mut(), stride, &mut tiles, |tile, piece| tile.ice_rows.push(piece));
        }
        if let Some(light) = &mut self.light_layers {
            let stride = light.layers().count();
            grid.deal(light.sums_mut(), stride, &mut tiles, |tile, piece| {
                tile.layer_rows.push(piece);
            });
        }
        if let Some(shadows) = &mut self.shadow_sums {
            grid.deal(shadows, 1, &mut tiles, |tile, piece| tile.shadow_rows.push(piece));
        }
        if let Some(learnt) = &mut self.learnt_sums {
            grid.deal(learnt, 1, &mut tiles, |tile, piece| tile.learnt_rows.push(piece));
        }
        tiles
    }

    /// The pixels of `rect`, which lies inside the crop.
    fn part_mut(&mut self, rect: PixelRect) -> FilmTileMut<'_> {
        let mut part = FilmTileMut::without_rows(rect, self.kept());
        let crop = self.crop;
        part.rows.extend(rows_of(&mut self.pixels, 1, crop, rect));
        if let Some(ice) = &mut self.ice_paths {
            let stride = ice.layout().sums();
            part.ice_rows.extend(rows_of(ice.sums_mut(), stride, crop, rect));
        }
        if let Some(light) = &mut self.light_layers {
            let stride = light.layers().count();
            part.layer_rows.extend(rows_of(light.sums_mut(), stride, crop, rect));
        }
        if let Some(shadows) = &mut self.shadow_sums {
            part.shadow_rows.extend(rows_of(shadows, 1, crop, rect));
        }
        if let Some(learnt) = &mut self.learnt_sums {
            part.learnt_rows.extend(rows_of(learnt, 1, crop, rect));
        }
        part
    }
}

/// How the pixels of a crop lie in tiles of `side` x `side` that are aligned with the picture.
#[derive(Clone, Copy)]
struct TileGrid {
    crop: PixelRect,
    side: u32,
}

impl TileGrid {
    /// Gives each tile the pieces of its rows of `sums`, of which each pixel has `stride`.
    fn deal<'a, T>(
        self,
        sums: &'a mut [T],
        stride: usize,
        tiles: &mut [FilmTileMut<'a>],
        give: impl Fn(&mut FilmTileMut<'a>, &'a mut [T]),
    ) {
        let Self { crop, side } = self;
        let across = (crop.x1.div_ceil(side) - crop.x0 / side) as usize;
        for (y, mut rest) in (crop.y0..).zip(sums.chunks_mut(crop.width() as usize * stride)) {
            let above = (y / side - crop.y0 / side) as usize;
            for tile in &mut tiles[above * across..][..across] {
                let (piece, tail) = rest.split_at_mut(tile.rect().width() as usize * stride);
                give(tile, piece);
                rest = tail;
            }
        }
    }
}

/// The rows of `rect` of the sums of a crop, of which each pixel has `stride`.
fn rows_of<T>(
    sums: &mut [T],
    stride: usize,
    crop: PixelRect,
    rect: PixelRect,
) -> impl Iterator<Item = &mut [T]> {
    let (first, count) = ((rect.y0 - crop.y0) as usize, rect.height() as usize);
    let columns = (rect.x0 - crop.x0) as usize * stride..(rect.x1 - crop.x0) as usize * stride;
    let rows = sums.chunks_mut(crop.width() as usize * stride).skip(first).take(count);
    rows.map(move |row| &mut row[columns.clone()])
}

/// Empty sums for every pixel of `rect`.
pub(crate) fn pixels_for(rect: PixelRect) -> Result<Vec<PixelSums>, FilmError> {
    let too_large = || FilmError::TooLarge {
        pixels: rect.area(),
        bytes: u128::from(rect.area()) * size_of::<PixelSums>() as u128,
    };
    let count = usize::try_from(rect.area()).map_err(|_| too_large())?;
    let mut pixels = Vec::new();
    pixels.try_reserve_exact(count).map_err(|_| too_large())?;
    pixels.resize(count, PixelSums::default());
    Ok(pixels)
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
