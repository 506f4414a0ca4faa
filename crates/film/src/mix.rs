//! Lights of a film at other strengths and colours.

use crate::{Film, FilmError, LightLayers};

/// A factor for each layer of a film's light.
#[derive(Clone, Debug, PartialEq)]
pub struct LightMix {
    factors: Vec<[f64; 3]>,
}

impl LightMix {
    /// The layers of a film, each by its factor of red, green and blue (linear sRGB, at least 0); a layer
    /// that is not named stays, the last factor of one that is named again counts.
    ///
    /// # Errors
    /// A film without layers of light; a name that it does not have.
    pub fn new(film: &Film, factors: &[(String, [f64; 3])]) -> Result<Self, FilmError> {
        let layers =
            film.light_layers().map(LightLayers::layers).ok_or(FilmError::NoLightLayers)?;
        let mut mix = Self { factors: vec![[1.0; 3]; layers.count()] };
        for (name, factor) in factors {
            let layer = layers.position(name).ok_or_else(|| FilmError::UnknownLightLayer {
                name: name.clone(),
                known: layers.names().join(", "),
            })?;
            mix.factors[layer] = *factor;
        }
        Ok(mix)
    }

    /// The factor of each layer.
    #[must_use]
    pub fn factors(&self) -> &[[f64; 3]] {
        &self.factors
    }

    /// Whether it changes nothing.
    #[must_use]
    pub fn is_neutral(&self) -> bool {
        self.factors.iter().all(|&factor| factor == [1.0; 3])
    }
}
