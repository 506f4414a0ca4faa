//! Pictures without noise.

use crate::{DenoiseError, Denoiser};
use snowgrain_film::{Layer, Picture};

const ALBEDO: [Layer; 3] = [Layer::AlbedoR, Layer::AlbedoG, Layer::AlbedoB];
const NORMAL: [Layer; 3] = [Layer::NormalX, Layer::NormalY, Layer::NormalZ];

impl Denoiser {
    /// The same picture with denoised colours and without layers of variance, which say nothing of them;
    /// all other layers, spectral ones too, stay as they are.
    ///
    /// `apart` is light that the colours hold and that is no noise though it looks like it (glints):
    /// three layers over the picture's window, taken away before and added again afterwards. Colours
    /// below 0 (out of the gamut of the picture's primaries) become 0.
    ///
    /// # Errors
    /// A picture without colour, albedo or normals; `apart` of another size; what the library refuses.
    pub fn denoise_picture(
        &self,
        picture: &Picture,
        apart: Option<[&[f32]; 3]>,
    ) -> Result<Picture, DenoiseError> {
        let window = picture.window();
        let mut colour = interleaved(picture.colour()?);
        if let Some(apart) = apart {
            let apart = checked(apart, colour.len())?;
            add(&mut colour, apart, -1.0);
        }
        let (albedo, normal) = (guide(picture, ALBEDO)?, guide(picture, NORMAL)?);
        let size = [window.width() as usize, window.height() as usize];
        let mut clean = self.denoise(size, &colour, &albedo, &normal)?;
        if let Some(apart) = apart {
            add(&mut clean, apart, 1.0);
        }
        let mut denoised = picture.clone();
        for (channel, layer) in Layer::COLOUR.into_iter().enumerate() {
            denoised.set_layer(layer, clean.iter().map(|pixel| pixel[channel]).collect())?;
        }
        denoised.remove_variance();
        denoised.denoised = true;
        Ok(denoised)
    }
}

fn guide(picture: &Picture, layers: [Layer; 3]) -> Result<Vec<[f32; 3]>, DenoiseError> {
    let [x, y, z] =
        layers.map(|layer| picture.layer(layer).ok_or(DenoiseError::NoGuide(layer.name())));
    Ok(interleaved([x?, y?, z?]))
}

fn interleaved([x, y, z]: [&[f32]; 3]) -> Vec<[f32; 3]> {
    x.iter().zip(y).zip(z).map(|((&x, &y), &z)| [x, y, z]).collect()
}

fn checked(layers: [&[f32]; 3], pixels: usize) -> Result<[&[f32]; 3], DenoiseError> {
    match layers.iter().find(|layer| layer.len() != pixels) {
        Some(layer) => Err(DenoiseError::Size { values: layer.len(), pixels }),
        None => Ok(layers),
    }
}

fn add(colour: &mut [[f32; 3]], added: [&[f32]; 3], sign: f32) {
    for (channel, layer) in added.into_iter().enumerate() {
        colour.iter_mut().zip(layer).for_each(|(pixel, value)| pixel[channel] += sign * value);
    }
}
