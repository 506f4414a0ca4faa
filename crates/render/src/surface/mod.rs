//! What objects are made of, and what their surfaces do to light.
//!
//! - *Diffuse*: Lambert's surface.
//! - *Conductor*: a metal. Its facets reflect by Schlick's form of Fresnel's equations.
//! - *Dielectric*: a clear solid, as glass. Its facets reflect and refract by Fresnel's equations; it
//!   absorbs nothing.
//!
//! Both of these are smooth, or rough with microfacets ([`ggx`]) whose light is followed through one
//! facet: what facets send into other facets is lost. At normal incidence that is 1 % of the light of a
//! white conductor of roughness .3, 8 % at .5, 30 % at .7 and 69 % at 1.

mod ggx;
mod material;
mod scatterer;
#[cfg(test)]
mod tests;

pub use material::Material;
pub use scatterer::{Scattered, Scatterer};

/// Roughness below which a surface is smooth: the spread of its reflections, `roughness^2` radians, is
/// under a third of the sun's half degree.
pub const LEAST_ROUGHNESS: f64 = 0.05;

/// What an object is made of.
#[derive(Clone, Debug, PartialEq)]
pub enum Surface {
    /// It reflects light evenly.
    Diffuse {
        /// Part of the light that it reflects, linear RGB, each in [0, 1].
        albedo: [f32; 3],
    },
    /// A metal.
    Conductor {
        /// Part of the light that it reflects at normal incidence, linear RGB, each in [0, 1].
        reflectance: [f32; 3],
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
        Self::Diffuse { albedo }
    }
}

/// The slope of the facets of a surface, `None` for a smooth one.
fn slope(roughness: f64) -> Option<f64> {
    (roughness >= LEAST_ROUGHNESS).then(|| roughness * roughness)
}
