//! The light of a picture in layers that add up to it, kept so that lights can be mixed after the render.
//!
//! Every light of a scene belongs to a named group, and each group has a layer. A layer named
//! [`GLINTS`] may hold, of all light, what small lights send by way of at most two grains; that is
//! then in no other layer. So the layers are a partition: in the sums, exactly, they add up to the radiance
//! of [`crate::PixelSums`].
//!
//! A layer takes three sums of 16 bytes a pixel, 48 bytes, in the quanta of radiance (2^-64).

use crate::FilmError;
use crate::exact::{power_of_two, to_fixed};

/// The layer of glints.
pub const GLINTS: &str = "glints";

/// Most layers of a film.
pub const MOST_LAYERS: usize = 32;

/// Longest name of a layer, in bytes: names of channels in EXR files stay under 32.
const LONGEST_NAME: usize = 22;

/// Fractional bits of the sums.
const FRACTION_BITS: i32 = 64;

/// Bytes of a layer's sums of one pixel.
pub(crate) const LAYER_BYTES: u64 = 48;

/// What the layers of a sample may be off the sample's radiance, relative to their magnitudes.
const TOLERANCE: f64 = 1e-5;

/// Exact sums of red, green and blue radiance of one layer and pixel, in quanta of 2^-64.
pub type LayerSums = [i128; 3];

/// What the layers of a film are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LightLayerNames {
    names: Vec<String>,
    layer_of_slot: Vec<u32>,
}

impl LightLayerNames {
    /// Layers of these names, each 1 to 22 letters, digits, `-` and `_`, and all different. `layer_of_slot`
    /// says to which layer the light of each slot (a pair of a layer and a spectrum: an entry of
    /// [`snowgrain_optics::Grade::lights`]) belongs.
    ///
    /// # Errors
    /// [`FilmError::BadLightLayers`].
    pub fn new(names: Vec<String>, layer_of_slot: Vec<u32>) -> Result<Self, FilmError> {
        let bad = |what: String| Err(FilmError::BadLightLayers { what });
        if names.is_empty() || names.len() > MOST_LAYERS {
            return bad(format!("there are {}, not 1 to {MOST_LAYERS}", names.len()));
        }
        for (at, name) in names.iter().enumerate() {
            let plain = |c: u8| c.is_ascii_alphanumeric() || c == b'-' || c == b'_';
            if name.is_empty() || name.len() > LONGEST_NAME || !name.bytes().all(plain) {
                return bad(format!(
                    "{name:?} is no name of 1 to {LONGEST_NAME} letters, digits, - and _"
                ));
            }
            if names[..at].contains(name) {
                return bad(format!("{name:?} is there twice"));
            }
        }
        if let Some(layer) = layer_of_slot.iter().find(|&&layer| layer as usize >= names.len()) {
            return bad(format!("light belongs to layer {layer} of {}", names.len()));
        }
        Ok(Self { names, layer_of_slot })
    }

    /// Their names.
    #[must_use]
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The layer of each slot.
    #[must_use]
    pub fn layer_of_slot(&self) -> &[u32] {
        &self.layer_of_slot
    }

    /// Number of layers.
    #[must_use]
    pub fn count(&self) -> usize {
        self.names.len()
    }

    /// Bytes of one pixel.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.names.len() as u64 * LAYER_BYTES
    }

    /// The index of a layer.
    #[must_use]
    pub fn position(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|known| known == name)
    }
}

/// The light of every pixel of a film in layers.
#[derive(Clone, Debug, PartialEq)]
pub struct LightLayers {
    layers: LightLayerNames,
    sums: Vec<LayerSums>,
}

impl LightLayers {
    /// Of so many pixels, empty.
    ///
    /// # Errors
    /// More than memory.
    pub(crate) fn new(layers: LightLayerNames, pixels: usize) -> Result<Self, FilmError> {
        let sums = empty_sums(layers.count(), pixels)?;
        Ok(Self { layers, sums })
    }

    /// What they are.
    #[must_use]
    pub fn layers(&self) -> &LightLayerNames {
        &self.layers
    }

    /// The sums of all pixels: of each pixel, those of each layer.
    #[must_use]
    pub fn sums(&self) -> &[LayerSums] {
        &self.sums
    }

    /// The same, to be filled.
    pub fn sums_mut(&mut self) -> &mut [LayerSums] {
        &mut self.sums
    }

    /// Mean radiance of each layer over the `samples` of a pixel, in the primaries of the film.
    pub fn light(&self, pixel: usize, samples: u64) -> impl Iterator<Item = [f64; 3]> + '_ {
        let scale = power_of_two(-FRACTION_BITS);
        let count = samples.max(1) as f64;
        let sums = &self.sums[pixel * self.layers.count()..][..self.layers.count()];
        sums.iter().map(move |sums| sums.map(|sum| sum as f64 * scale / count))
    }
}

/// Empty sums of so many layers and pixels.
pub(crate) fn empty_sums(layers: usize, pixels: usize) -> Result<Vec<LayerSums>, FilmError> {
    let mut sums = Vec::new();
    let count = pixels.saturating_mul(layers);
    sums.try_reserve_exact(count).map_err(|_| FilmError::TooLarge {
        pixels: pixels as u64,
        bytes: count as u128 * u128::from(LAYER_BYTES),
    })?;
    sums.resize(count, [0; 3]);
    Ok(sums)
}

/// Why light is not added to layers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Refused {
    /// A sum would leave its range, or a radiance is out of that of samples.
    Overflow,
    /// The layers do not add up to the radiance.
    NotTheWhole,
}

impl Refused {
    /// The same, said of a pixel.
    pub(crate) fn of(self, x: u32, y: u32) -> FilmError {
        match self {
            Self::Overflow => FilmError::Overflow { x, y },
            Self::NotTheWhole => FilmError::LayersNotTheWhole { x, y },
        }
    }
}

/// Adds a sample's radiance, parted into `layers`, to the sums of a pixel; on an error nothing is added.
///
/// The layers add up to the radiance but for what rounding in single precision leaves. That goes
/// to the largest of them, so that the sums add up exactly.
pub(crate) fn add(
    sums: &mut [LayerSums],
    radiance: [f32; 3],
    layers: &[[f32; 3]],
) -> Result<(), Refused> {
    if layers.len() != sums.len() {
        return Err(Refused::NotTheWhole);
    }
    let mut total = [[0i128; 3]; MOST_LAYERS];
    for channel in 0..3 {
        let (mut rest, mut magnitude, mut largest) = (fixed(radiance[channel])?, 0.0, 0);
        for (layer, light) in layers.iter().enumerate() {
            let added = fixed(light[channel])?;
            rest -= added;
            total[layer][channel] = added;
            magnitude += f64::from(light[channel].abs());
            if light[channel].abs() > layers[largest][channel].abs() {
                largest = layer;
            }
        }
        // Each value was rounded to a quantum.
        let quanta = 1.0 + layers.len() as f64;
        let allowed = TOLERANCE * magnitude * power_of_two(FRACTION_BITS) + quanta;
        if (rest as f64).abs() > allowed {
            return Err(Refused::NotTheWhole);
        }
        total[largest][channel] += rest;
    }
    for (sum, added) in sums.iter().zip(&mut total) {
        for (sum, added) in sum.iter().zip(added) {
            *added = sum.checked_add(*added).ok_or(Refused::Overflow)?;
        }
    }
    sums.copy_from_slice(&total[..sums.len()]);
    Ok(())
}

/// A radiance in quanta, where it is in the range of samples: small enough that no number of layers leaves
/// that of the sums.
pub(crate) fn fixed(x: f32) -> Result<i128, Refused> {
    let limit = power_of_two(48);
    let magnitude = f64::from(x.abs());
    let fits = magnitude < limit;
    let quanta = to_fixed(if fits { magnitude } else { 0.0 }, FRACTION_BITS);
    let quanta = quanta.filter(|_| fits).ok_or(Refused::Overflow)?.cast_signed();
    Ok(if x < 0.0 { -quanta } else { quanta })
}

/// The first index at which the total of the sums would leave its range.
pub(crate) fn overflow_of<const N: usize>(
    sums: &[[i128; N]],
    added: &[[i128; N]],
) -> Option<usize> {
    let fits = |(sum, added): (&[i128; N], &[i128; N])| {
        sum.iter().zip(added).all(|(sum, added)| sum.checked_add(*added).is_some())
    };
    sums.iter().zip(added).position(|pair| !fits(pair))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn names_that_files_could_not_hold_are_refused() {
        let new = |names: &[&str], slots: &[u32]| {
            let names = names.iter().map(|&name| name.to_owned()).collect();
            LightLayerNames::new(names, slots.to_vec()).map_err(|error| error.to_string())
        };
        let layers = new(&["sun", "north-sky_2", GLINTS], &[0, 0, 1]).unwrap();
        assert_eq!((layers.position("glints"), layers.position("moon")), (Some(2), None));
        assert_eq!((layers.count(), layers.bytes()), (3, 144));
        for (names, slots, what) in [
            (&[][..], &[][..], "there are 0"),
            (&["a", "a"], &[], "twice"),
            (&["two words"], &[], "letters"),
            (&[""], &[], "letters"),
            (&["a-name-that-is-far-too-long"], &[], "letters"),
            (&["a"], &[1], "layer 1 of 1"),
        ] {
            let error = new(names, slots).unwrap_err();
            assert!(error.contains(what), "{error}");
        }
        let many: Vec<String> = (0..33).map(|i| format!("g{i}")).collect();
        assert!(LightLayerNames::new(many, Vec::new()).is_err());
    }

    #[test]
    fn light_that_is_not_the_whole_or_out_of_range_is_refused_and_nothing_is_added() {
        let mut sums = [[1, i128::MAX - 5, 0], [0; 3]];
        let before = sums;
        let mut refused = |radiance, layers: [[f32; 3]; 2]| add(&mut sums, radiance, &layers);
        let half = [[0.25; 3]; 2];
        assert_eq!(refused([0.6, 0.5, 0.5], half), Err(Refused::NotTheWhole));
        assert_eq!(refused([0.5; 3], half), Err(Refused::Overflow));
        assert_eq!(refused([f32::NAN; 3], half), Err(Refused::Overflow));
        assert_eq!(refused([1e15; 3], [[1e15; 3], [0.0; 3]]), Err(Refused::Overflow));
        assert_eq!(sums, before);
    }

    /// A bright light and many small ones of another layer, summed in double precision as the renderer does;
    /// in single precision the whole would have lost the small ones, and is refused.
    #[test]
    fn small_light_beside_bright_light_is_not_lost() {
        let (bright, small) = (100.0f32, 3e-6f32);
        let many = (0..50_000).fold(0.0, |sum, _| sum + f64::from(small));
        let layers = [[bright; 3], [many as f32; 3]];
        let whole = (f64::from(bright) + many) as f32;
        let mut sums = [[0; 3]; 2];
        assert_eq!(add(&mut sums, [whole; 3], &layers), Ok(()));
        let lossy = (0..50_000).fold(bright, |sum, _| sum + small);
        assert_eq!(add(&mut sums, [lossy; 3], &layers), Err(Refused::NotTheWhole));
        let tiny = 3e-20f32;
        assert_eq!(add(&mut sums, [2.0 * tiny; 3], &[[tiny; 3]; 2]), Ok(()));
    }

    proptest! {
        /// Layers whose sum in single precision rounds.
        #[test]
        fn layers_add_up_to_the_whole_exactly(
            lights in prop::collection::vec(prop::array::uniform3(-1e3..1e6f32), 1..6),
        ) {
            let radiance = lights.iter().fold([0.0f32; 3], |sum, light| {
                std::array::from_fn(|c| sum[c] + light[c])
            });
            let mut sums = vec![[0; 3]; lights.len()];
            prop_assert_eq!(add(&mut sums, radiance, &lights), Ok(()));
            for (c, whole) in radiance.into_iter().enumerate() {
                let total: i128 = sums.iter().map(|sum| sum[c]).sum();
                prop_assert_eq!(Ok(total), fixed(whole));
            }
        }
    }
}
