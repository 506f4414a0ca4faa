//! What objects are made of, and what their surfaces do to light.
//!
//! - *Diffuse*: Lambert's surface.
//! - *Conductor*: a metal. Its facets reflect by Schlick's form of Fresnel's equations, mended towards
//!   grazing light.
//! - *Dielectric*: a clear solid, as glass. Its facets reflect and refract by Fresnel's equations; it
//!   absorbs nothing.
//!
//! Both of these are smooth, or rough with microfacets (`ggx`) whose light is followed through one
//! facet: what facets send into other facets is lost. At normal incidence that is 1 % of the light of a
//! white conductor of roughness .3, 8 % at .5, 30 % at .7 and 69 % at 1.

mod ggx;
mod material;
mod place;
mod scatterer;
#[cfg(test)]
mod tests;
mod texture;

pub use material::Material;
pub(crate) use place::Place;
pub use scatterer::{Scattered, Scatterer};
pub use texture::{LARGEST_TEXTURE, Reflectance, Texture, TextureMap, check_texture_size};

/// Roughness below which a surface is smooth: the spread of its reflections, `roughness^2` radians, is
/// under a third of the sun's half degree.
pub const LEAST_ROUGHNESS: f64 = 0.05;

/// What an object is made of.
#[derive(Clone, Debug, PartialEq)]
pub enum Surface {
    /// It reflects light evenly.
    Diffuse {
        /// Part of the light that it reflects.
        albedo: Reflectance,
    },
    /// A metal.
    Conductor {
        /// Part of the light that it reflects at normal incidence.
        reflectance: Reflectance,
        /// What it is less than Schlick's form of it towards grazing light, by channel
        /// (`snowgrain_optics::Metal::edge`), at least 0; 0 where that is not known.
        edge: [f32; 3],
        /// In [0, 1]; the slope of its facets is the square, and below [`LEAST_ROUGHNESS`] it is smooth.
        roughness: f64,
    },
    /// A clear solid. Its boundary must be closed (a plane bounds the half-space below it), its
    /// triangles wound counterclockwise seen from outside.
    Dielectric {
        /// Index of refraction, in [1, 4].
        ior: f64,
        /// As that of a conductor.
        roughness: f64,
    },
}

impl Surface {
    /// A diffuse surface of one colour.
    #[must_use]
    pub fn diffuse(albedo: [f32; 3]) -> Self {
        Self::Diffuse { albedo: Reflectance::Colour(albedo) }
    }

    /// The picture on it, if there is one.
    #[must_use]
    pub fn texture(&self) -> Option<&TextureMap> {
        match self {
            Self::Diffuse { albedo: Reflectance::Texture(map) }
            | Self::Conductor { reflectance: Reflectance::Texture(map), .. } => Some(map),
            Self::Diffuse { albedo: Reflectance::Colour(_) }
            | Self::Conductor { reflectance: Reflectance::Colour(_), .. }
            | Self::Dielectric { .. } => None,
        }
    }
}

/// The slope of the facets of a surface, `None` for a smooth one.
fn slope(roughness: f64) -> Option<f64> {
    (roughness >= LEAST_ROUGHNESS).then_some(roughness * roughness)
}
