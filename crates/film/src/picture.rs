//! A film read off: scene-linear layers of `f32`.

use crate::{
    CaughtLight, Film, FilmError, LearntLight, LightLayers, PixelRect, PixelSums, ShadowSums,
    SpectralLayer,
};
use snowgrain_optics::Primaries;

/// The closed set of layers, named as OpenEXR users name them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Layer {
    /// Mean red radiance.
    R,
    /// Mean green radiance.
    G,
    /// Mean blue radiance.
    B,
    /// 1 - the fraction of samples that saw only the backdrop.
    A,
    /// Mean red albedo of the first surface.
    AlbedoR,
    /// Mean green albedo of the first surface.
    AlbedoG,
    /// Mean blue albedo of the first surface.
    AlbedoB,
    /// Mean normal of the first surface, x.
    NormalX,
    /// Mean normal of the first surface, y.
    NormalY,
    /// Mean normal of the first surface, z.
    NormalZ,
    /// Mean distance of the first surface, metres; infinite where there is none.
    Depth,
    /// Unbiased variance of the mean in `R`; infinite with fewer than two samples.
    VarianceR,
    /// Unbiased variance of the mean in `G`.
    VarianceG,
    /// Unbiased variance of the mean in `B`.
    VarianceB,
    /// Number of samples (exact to 2^24).
    SampleCount,
}

impl Layer {
    /// Every layer, in the order of a [`Picture`].
    pub const ALL: [Self; 15] = [
        Self::R,
        Self::G,
        Self::B,
        Self::A,
        Self::AlbedoR,
        Self::AlbedoG,
        Self::AlbedoB,
        Self::NormalX,
        Self::NormalY,
        Self::NormalZ,
        Self::Depth,
        Self::VarianceR,
        Self::VarianceG,
        Self::VarianceB,
        Self::SampleCount,
    ];

    /// The colour layers.
    pub const COLOUR: [Self; 3] = [Self::R, Self::G, Self::B];

    /// The variance layers, in the order of [`Layer::COLOUR`].
    pub const VARIANCE: [Self; 3] = [Self::VarianceR, Self::VarianceG, Self::VarianceB];

    /// Channel name in an EXR file.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::R => "R",
            Self::G => "G",
            Self::B => "B",
            Self::A => "A",
            Self::AlbedoR => "Albedo.R",
            Self::AlbedoG => "Albedo.G",
            Self::AlbedoB => "Albedo.B",
            Self::NormalX => "N.X",
            Self::NormalY => "N.Y",
            Self::NormalZ => "N.Z",
            Self::Depth => "Z",
            Self::VarianceR => "Variance.R",
            Self::VarianceG => "Variance.G",
            Self::VarianceB => "Variance.B",
            Self::SampleCount => "SampleCount",
        }
    }

    /// The layer of that name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|layer| layer.name() == name)
    }

    /// The values of [`Layer::ALL`] in a pixel.
    fn all_of(sums: &PixelSums) -> [f64; 15] {
        let [r, g, b] = sums.mean_radiance();
        let [albedo_r, albedo_g, albedo_b] = sums.mean_albedo();
        let [x, y, z] = sums.mean_normal();
        let [variance_r, variance_g, variance_b] = sums.variance_of_mean();
        [
            r,
            g,
            b,
            sums.mean_alpha(),
            albedo_r,
            albedo_g,
            albedo_b,
            x,
            y,
            z,
            sums.mean_depth(),
            variance_r,
            variance_g,
            variance_b,
            sums.samples() as f64,
        ]
    }
}

/// Where a picture comes from: the same for every run that makes the same samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Provenance {
    /// Hash of the resolved scene.
    pub scene_hash: [u8; 32],
    /// Seed of the sampler.
    pub seed: u64,
    /// Samples per pixel.
    pub samples_per_pixel: u64,
}

/// The part of the light of a picture that a group of lights sends.
#[derive(Clone, Debug, PartialEq)]
pub struct LightLayer {
    /// Name of the group, or [`crate::light_layers::GLINTS`].
    pub name: String,
    /// Mean red, green and blue radiance over the window in row-major order, in the primaries of the
    /// picture.
    pub values: [Vec<f32>; 3],
}

/// Scene-linear layers over the pixels of a window of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    width: u32,
    height: u32,
    window: PixelRect,
    layers: Vec<(Layer, Vec<f32>)>,
    /// Radiance at single wavelengths, if known.
    pub spectrum: Vec<SpectralLayer>,
    /// The light in layers that add up to the colour layers (before a denoiser), if known.
    pub light_layers: Vec<LightLayer>,
    /// Where the film has shadow catchers, what they show (`lit`) and would show alone (`unoccluded`).
    pub shadow_layers: Vec<LightLayer>,
    /// Where light was learnt, of each pixel how much ([`LearntLight`]).
    pub learnt: Vec<LearntLight>,
    /// Vertical field of view of the whole picture, degrees, if known.
    pub vertical_fov_degrees: Option<f64>,
    /// What the colour layers are amounts of (albedos are of sRGB always).
    pub primaries: Primaries,
    /// Exposure at which it is meant to be shown, stops; the layers do not hold it.
    pub exposure_stops: f64,
    /// Where it comes from, if known.
    pub provenance: Option<Provenance>,
    /// Whether its colours are a denoiser's guess, which is no measurement.
    pub denoised: bool,
}

impl Picture {
    /// A picture of `width` x `height` pixels without layers, of which `window` is known.
    ///
    /// # Errors
    /// A window that is empty or leaves the picture.
    pub fn new(width: u32, height: u32, window: PixelRect) -> Result<Self, FilmError> {
        if window.is_empty() || !PixelRect::new(0, 0, width, height).encloses(&window) {
            return Err(FilmError::BadCrop { crop: window, width, height });
        }
        Ok(Self {
            width,
            height,
            window,
            layers: Vec::new(),
            spectrum: Vec::new(),
            light_layers: Vec::new(),
            shadow_layers: Vec::new(),
            learnt: Vec::new(),
            vertical_fov_degrees: None,
            primaries: Primaries::default(),
            exposure_stops: 0.0,
            provenance: None,
            denoised: false,
        })
    }

    /// All layers of a film. Shadow catchers give way to the plate ([`CaughtLight::over_plate`]).
    ///
    /// # Errors
    /// More layers than memory.
    pub fn from_film(film: &Film) -> Result<Self, FilmError> {
        let mut picture = Self::new(film.width(), film.height(), film.crop())?;
        let mut layers = [const { Vec::<f32>::new() }; Layer::ALL.len()];
        for values in &mut layers {
            values.try_reserve_exact(film.pixels().len()).map_err(|_| FilmError::TooLarge {
                pixels: film.crop().area(),
                bytes: u128::from(film.crop().area()) * 60,
            })?;
        }
        let shadows = film.shadow_sums();
        for (index, sums) in film.pixels().iter().enumerate() {
            let mut pixel = Layer::all_of(sums);
            if let Some(shadows) = shadows {
                let caught = CaughtLight::of(&shadows[index], sums.samples());
                let [r, g, b, alpha, ..] = pixel;
                let ([r, g, b], alpha) = caught.over_plate([r, g, b], alpha);
                pixel[..4].copy_from_slice(&[r, g, b, alpha]);
            }
            layers.iter_mut().zip(pixel).for_each(|(values, value)| values.push(value as f32));
        }
        for (layer, values) in Layer::ALL.into_iter().zip(layers) {
            picture.set_layer(layer, values)?;
        }
        if let Some(light) = film.light_layers() {
            picture.light_layers = read_layers(film, light)?;
        }
        if let Some(shadows) = shadows {
            picture.shadow_layers = read_shadows(film, shadows)?;
        }
        if let Some(learnt) = film.learnt_sums() {
            let of = |(sums, pixel): (_, &PixelSums)| LearntLight::of(sums, pixel.samples());
            picture.learnt = learnt.iter().zip(film.pixels()).map(of).collect();
        }
        picture.vertical_fov_degrees = film.vertical_fov_degrees;
        picture.primaries = film.grade.primaries;
        picture.exposure_stops = film.grade.exposure_stops;
        picture.provenance = Some(Provenance {
            scene_hash: film.identity().scene_hash,
            seed: film.identity().seed,
            samples_per_pixel: film.samples().total(),
        });
        Ok(picture)
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

    /// The pixels that the layers cover.
    #[must_use]
    pub fn window(&self) -> PixelRect {
        self.window
    }

    /// The layers there are, in the order of [`Layer::ALL`].
    pub fn layers(&self) -> impl Iterator<Item = (Layer, &[f32])> {
        self.layers.iter().map(|(layer, values)| (*layer, values.as_slice()))
    }

    /// Values of a layer over the window in row-major order, if the picture has it.
    #[must_use]
    pub fn layer(&self, layer: Layer) -> Option<&[f32]> {
        self.layers().find_map(|(held, values)| (held == layer).then_some(values))
    }

    /// Adds or replaces a layer; values over the window in row-major order.
    ///
    /// # Errors
    /// Not one value per pixel of the window.
    pub fn set_layer(&mut self, layer: Layer, values: Vec<f32>) -> Result<(), FilmError> {
        let pixels = self.window.area();
        if values.len() as u64 != pixels {
            let (layer, values) = (layer.name(), values.len());
            return Err(FilmError::LayerSize { layer, values, pixels });
        }
        match self.layers.binary_search_by_key(&layer, |(held, _)| *held) {
            Ok(at) => self.layers[at].1 = values,
            Err(at) => self.layers.insert(at, (layer, values)),
        }
        Ok(())
    }

    /// Leaves out the layers of variance, for colours of which they would say nothing.
    pub fn remove_variance(&mut self) {
        self.layers.retain(|(layer, _)| !Layer::VARIANCE.contains(layer));
    }

    /// The layers R, G and B.
    ///
    /// # Errors
    /// One of them is missing.
    pub fn colour(&self) -> Result<[&[f32]; 3], FilmError> {
        self.all_of(Layer::COLOUR).map_err(|layer| FilmError::NoColour { layer: layer.name() })
    }

    /// The variance layers, if the picture has all three.
    #[must_use]
    pub fn variance(&self) -> Option<[&[f32]; 3]> {
        self.all_of(Layer::VARIANCE).ok()
    }

    fn all_of(&self, layers: [Layer; 3]) -> Result<[&[f32]; 3], Layer> {
        let [first, second, third] = layers.map(|layer| self.layer(layer).ok_or(layer));
        Ok([first?, second?, third?])
    }

    /// Mean of R, G and B over the window.
    ///
    /// # Errors
    /// One of them is missing.
    pub fn mean_radiance(&self) -> Result<[f64; 3], FilmError> {
        Ok(self
            .colour()?
            .map(|values| values.iter().map(|&x| f64::from(x)).sum::<f64>() / values.len() as f64))
    }
}

/// The layers of a film's light.
fn read_layers(film: &Film, light: &LightLayers) -> Result<Vec<LightLayer>, FilmError> {
    let mut layers = empty_layers(film, light.layers().names())?;
    for (pixel, sums) in film.pixels().iter().enumerate() {
        for (layer, colour) in layers.iter_mut().zip(light.light(pixel, sums.samples())) {
            layer.values.iter_mut().zip(colour).for_each(|(values, x)| values.push(x as f32));
        }
    }
    Ok(layers)
}

/// What the shadow catchers of a film show, and would show alone.
fn read_shadows(film: &Film, shadows: &[ShadowSums]) -> Result<Vec<LightLayer>, FilmError> {
    let mut layers = empty_layers(film, &["lit".to_owned(), "unoccluded".to_owned()])?;
    for (pixel, sums) in film.pixels().iter().zip(shadows) {
        let caught = CaughtLight::of(sums, pixel.samples());
        for (layer, colour) in layers.iter_mut().zip([caught.lit, caught.unoccluded]) {
            layer.values.iter_mut().zip(colour).for_each(|(values, x)| values.push(x as f32));
        }
    }
    Ok(layers)
}

/// Layers of these names, with room for the pixels of a film.
pub(crate) fn empty_layers(film: &Film, names: &[String]) -> Result<Vec<LightLayer>, FilmError> {
    let layer = |name: &String| {
        let mut values = [const { Vec::<f32>::new() }; 3];
        for values in &mut values {
            values.try_reserve_exact(film.pixels().len()).map_err(|_| FilmError::TooLarge {
                pixels: film.crop().area(),
                bytes: u128::from(film.crop().area()) * 12 * names.len() as u128,
            })?;
        }
        Ok(LightLayer { name: name.clone(), values })
    };
    names.iter().map(layer).collect()
}
