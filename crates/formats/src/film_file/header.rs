//! The head of a film file: everything of fixed length, and what lengths it says the rest has.

use super::{MAGIC, MEND, array, is_film};
use crate::error::Fault;
use snowgrain_film::light_layers::MOST_LAYERS;
use snowgrain_film::{Film, FilmIdentity, IcePathLayout, IcePaths, PixelRect, PixelSums};
use std::io::{self, Read, Write};

const VERSION: u32 = 4;
/// Bytes of the head.
const BYTES: u64 = 8 + 4 + 6 * 4 + 32 + 8 + 4 + 4 + 4 + 8 + 4 + 4 + 4 + 4 + 4 + 32;
/// Spectra of lights are few.
const MOST_LIGHTS: u32 = 64;
const RANGE_BYTES: u64 = 16;
/// Bytes of the relative error that counts of samples were chosen for, and of each count.
const COUNTS_TARGET_BYTES: u64 = 8;
const COUNT_BYTES: u64 = 4;
const HASH_BYTES: u64 = 32;
/// Bytes of the sums of a layer of light in one pixel.
const LAYER_BYTES: u64 = 48;
/// Bytes of what shadow catchers show in one pixel.
const SHADOW_BYTES: u64 = 112;
/// Bytes of what is known of learnt light in one pixel.
const LEARNT_BYTES: u64 = 32;
/// Bits that say what else is kept.
const KEEPS_SHADOWS: u32 = 1;
const KEEPS_LEARNT: u32 = 2;

/// The head of a film file.
pub(super) struct Header {
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) crop: PixelRect,
    pub(super) identity: FilmIdentity,
    pub(super) ranges: u32,
    pub(super) ice_paths: Option<IcePathLayout>,
    pub(super) vertical_fov_degrees: Option<f64>,
    pub(super) light_layers: u32,
    pub(super) grade_bytes: u32,
    pub(super) layers_bytes: u32,
    /// Blocks that have counts of samples.
    pub(super) block_counts: u32,
    pub(super) shadow_catcher: bool,
    pub(super) learnt_light: bool,
    pub(super) recipe: Option<[u8; 32]>,
}

impl Header {
    /// Of a film whose grade and layers are so long as TOML.
    pub(super) fn of(film: &Film, grade: &str, layers: &str) -> io::Result<Self> {
        let length = |count: usize| u32::try_from(count).map_err(io::Error::other);
        Ok(Self {
            width: film.width(),
            height: film.height(),
            crop: film.crop(),
            identity: film.identity(),
            ranges: length(film.samples().as_slice().len())?,
            ice_paths: film.ice_paths().map(IcePaths::layout),
            vertical_fov_degrees: film.vertical_fov_degrees,
            light_layers: length(film.kept().light_layers)?,
            grade_bytes: length(grade.len())?,
            layers_bytes: length(layers.len())?,
            block_counts: length(film.block_counts().map_or(0, |counts| counts.counts().len()))?,
            shadow_catcher: film.kept().shadow_catcher,
            learnt_light: film.kept().learnt_light,
            recipe: film.recipe,
        })
    }

    pub(super) fn write(&self, writer: &mut impl Write) -> io::Result<()> {
        writer.write_all(MAGIC)?;
        let crop = self.crop;
        let numbers = [VERSION, self.width, self.height, crop.x0, crop.y0, crop.x1, crop.y1];
        numbers.iter().try_for_each(|number| writer.write_all(&number.to_le_bytes()))?;
        writer.write_all(&self.identity.scene_hash)?;
        writer.write_all(&self.identity.seed.to_le_bytes())?;
        writer.write_all(&self.ranges.to_le_bytes())?;
        let layout = self.ice_paths;
        let (lights, scale) = layout.map_or((0, 0), |l| (l.lights, l.scale_exponent));
        writer.write_all(&lights.to_le_bytes())?;
        writer.write_all(&scale.to_le_bytes())?;
        writer.write_all(&self.vertical_fov_degrees.unwrap_or(0.0).to_le_bytes())?;
        let Self { light_layers, grade_bytes, layers_bytes, block_counts, .. } = *self;
        let bit = |is_kept: bool, bit: u32| if is_kept { bit } else { 0 };
        let kept = bit(self.shadow_catcher, KEEPS_SHADOWS) | bit(self.learnt_light, KEEPS_LEARNT);
        let lengths = [light_layers, grade_bytes, layers_bytes, block_counts, kept];
        lengths.iter().try_for_each(|number| writer.write_all(&number.to_le_bytes()))?;
        writer.write_all(&self.recipe.unwrap_or_default())
    }

    /// Reads it and compares what it claims with the length of the file, before memory is taken.
    pub(super) fn read(reader: &mut impl Read, length: u64) -> Result<Self, Fault> {
        if !is_film(&array::<8>(reader)?) {
            return Err(Fault::whole("this is not a film of Snowgrain", "name a .film file"));
        }
        let version = u32::from_le_bytes(array(reader)?);
        if version != VERSION {
            let what =
                format!("version {version} of film files is not read (this reads {VERSION})");
            return Err(Fault::whole(what, "render it again, or use the Snowgrain that wrote it"));
        }
        let mut number = || array(reader).map(u32::from_le_bytes);
        let (width, height) = (number()?, number()?);
        let crop = PixelRect::new(number()?, number()?, number()?, number()?);
        let identity =
            FilmIdentity { scene_hash: array(reader)?, seed: u64::from_le_bytes(array(reader)?) };
        let ranges = u32::from_le_bytes(array(reader)?);
        let lights = u32::from_le_bytes(array(reader)?);
        let scale_exponent = i32::from_le_bytes(array(reader)?);
        let vertical_fov = f64::from_le_bytes(array(reader)?);
        let mut number = || array(reader).map(u32::from_le_bytes);
        let mut header = Self {
            width,
            height,
            crop,
            identity,
            ranges,
            ice_paths: (lights > 0)
                .then_some(IcePathLayout { lights: lights.min(MOST_LIGHTS), scale_exponent }),
            vertical_fov_degrees: (vertical_fov > 0.0 && vertical_fov < 180.0)
                .then_some(vertical_fov),
            light_layers: number()?.min(MOST_LAYERS as u32),
            grade_bytes: number()?,
            layers_bytes: number()?,
            block_counts: number()?,
            shadow_catcher: false,
            learnt_light: false,
            recipe: None,
        };
        let kept = number()?;
        header.shadow_catcher = kept & KEEPS_SHADOWS != 0;
        header.learnt_light = kept & KEEPS_LEARNT != 0;
        header.recipe = Some(array(reader)?).filter(|recipe| *recipe != [0; 32]);
        header.check_length(length)?;
        Ok(header)
    }

    fn check_length(&self, length: u64) -> Result<(), Fault> {
        let texts = u64::from(self.grade_bytes) + u64::from(self.layers_bytes);
        let counts = match self.block_counts {
            0 => 0,
            counts => COUNTS_TARGET_BYTES + u64::from(counts) * COUNT_BYTES,
        };
        let fixed = BYTES + texts + u64::from(self.ranges) * RANGE_BYTES + counts + HASH_BYTES;
        let pixel_bytes = PixelSums::BYTES as u64
            + self.ice_paths.map_or(0, IcePathLayout::bytes)
            + u64::from(self.light_layers) * LAYER_BYTES
            + u64::from(self.shadow_catcher) * SHADOW_BYTES
            + u64::from(self.learnt_light) * LEARNT_BYTES;
        let area = self.crop.area();
        let expected = u128::from(fixed) + u128::from(area) * u128::from(pixel_bytes);
        if expected == u128::from(length) {
            return Ok(());
        }
        let what = format!("a film of {area} pixels has {expected} bytes, not {length}");
        Err(Fault::whole(what, MEND))
    }
}
