//! What a surface does to light at one point of it, for a path that arrives in one direction.
//!
//! Paths carry radiance over the square of the index of refraction where they are, which refraction
//! leaves as it is (Veach 1997, "Robust Monte Carlo Methods for Light Transport Simulation", section
//! 5.2): a path that has left a dielectric brings radiance.

use super::ggx::{lambda, normals, visible_normal, visible_normals};
use core::f64::consts::PI;
use snowgrain_math::{DVec3, frame};
use snowgrain_optics::fresnel;

/// A point of a surface, as a path arrives at it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scatterer {
    /// Unit normal on the side from which the path came.
    normal: DVec3,
    /// Unit vector against the direction of arrival: where light that the path stands for leaves.
    outgoing: DVec3,
    kind: Kind,
}

/// What happens there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kind {
    /// All directions are as bright.
    Diffuse { albedo: [f32; 3] },
    /// A metal of this reflectance at normal incidence, smooth where there is no slope of facets.
    Conductor { reflectance: [f32; 3], alpha: Option<f64> },
    /// A dielectric whose other side has this index of refraction relative to the side of the path.
    Dielectric { relative_index: f64, alpha: Option<f64> },
}

/// Where a path goes on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scattered {
    /// Unit vector.
    pub direction: DVec3,
    /// What is left of the light: bidirectional scattering times cosine over the density of the
    /// direction.
    pub weight: [f32; 3],
}

impl Scatterer {
    pub(super) fn new(normal: DVec3, arrival: DVec3, kind: Kind) -> Self {
        Self { normal, outgoing: -arrival, kind }
    }

    /// The colour by which a denoiser may tell it: albedo, reflectance at normal incidence, 1 for a
    /// dielectric.
    #[must_use]
    pub fn guide(&self) -> [f32; 3] {
        match self.kind {
            Kind::Diffuse { albedo } => albedo,
            Kind::Conductor { reflectance, .. } => reflectance,
            Kind::Dielectric { .. } => [1.0; 3],
        }
    }

    /// Whether it sends light on in single directions only, which no density describes.
    #[must_use]
    pub fn is_smooth(&self) -> bool {
        match self.kind {
            Kind::Diffuse { .. } => false,
            Kind::Conductor { alpha, .. } | Kind::Dielectric { alpha, .. } => alpha.is_none(),
        }
    }

    /// Draws where the path goes on, by two uniform numbers and a third that is asked for where it is
    /// needed; `None` where the light is lost between facets.
    #[must_use]
    pub fn sample(&self, [u, v]: [f64; 2], third: impl FnOnce() -> f64) -> Option<Scattered> {
        match self.kind {
            Kind::Diffuse { albedo } => {
                let direction = frame::cosine_hemisphere(self.normal, [u, v]);
                Some(Scattered { direction, weight: albedo })
            }
            Kind::Conductor { reflectance, alpha } => {
                let (outgoing, facet) = self.facet(alpha, [u, v]);
                let cosine = outgoing.dot(facet).clamp(0.0, 1.0);
                let local = reflected(outgoing, facet)?;
                let part = alpha.map_or(1.0, |alpha| unshadowed(alpha, outgoing, local));
                let weight = schlick(reflectance, cosine).map(|r| (f64::from(r) * part) as f32);
                Some(Scattered { direction: self.world(local), weight })
            }
            Kind::Dielectric { relative_index, alpha } => {
                let (outgoing, facet) = self.facet(alpha, [u, v]);
                let cosine = outgoing.dot(facet).clamp(0.0, 1.0);
                let local = if third() < fresnel::reflectance(cosine, relative_index) {
                    reflected(outgoing, facet)?
                } else {
                    fresnel::refract(-outgoing, facet, relative_index).filter(|d| d.z < 0.0)?
                };
                let part = alpha.map_or(1.0, |alpha| unshadowed(alpha, outgoing, local));
                Some(Scattered { direction: self.world(local), weight: [part as f32; 3] })
            }
        }
    }

    /// Density with which [`Self::sample`] gives a direction, 1/sr; 0 where it is smooth.
    #[must_use]
    pub fn density(&self, direction: DVec3) -> f64 {
        match self.kind {
            Kind::Diffuse { .. } => self.normal.dot(direction).max(0.0) / PI,
            Kind::Conductor { alpha: Some(alpha), .. } => {
                let (outgoing, incoming) = self.frame(direction);
                let Some(facet) = reflecting(outgoing, incoming) else { return 0.0 };
                visible_normals(alpha, outgoing, facet) / (4.0 * outgoing.dot(facet))
            }
            Kind::Dielectric { relative_index, alpha: Some(alpha) } => {
                let (outgoing, incoming) = self.frame(direction);
                let Some((facet, jacobian, part)) = passing(outgoing, incoming, relative_index)
                else {
                    return 0.0;
                };
                part * visible_normals(alpha, outgoing, facet) * jacobian
            }
            Kind::Conductor { alpha: None, .. } | Kind::Dielectric { alpha: None, .. } => 0.0,
        }
    }

    /// Bidirectional scattering times the cosine for light that comes from `direction`, 1/sr, as a
    /// colour and a factor; 0 where it is smooth.
    #[must_use]
    pub fn value(&self, direction: DVec3) -> ([f32; 3], f64) {
        match self.kind {
            Kind::Diffuse { albedo } => (albedo, self.normal.dot(direction).max(0.0) / PI),
            Kind::Conductor { reflectance, alpha: Some(alpha) } => {
                let (outgoing, incoming) = self.frame(direction);
                let Some(facet) = reflecting(outgoing, incoming) else { return ([0.0; 3], 0.0) };
                // Walter et al. 2007, eq. 20.
                let factor = normals(alpha, facet) * seen_both_ways(alpha, outgoing, incoming)
                    / (4.0 * outgoing.z);
                (schlick(reflectance, outgoing.dot(facet).clamp(0.0, 1.0)), factor)
            }
            Kind::Dielectric { relative_index, alpha: Some(alpha) } => {
                let (outgoing, incoming) = self.frame(direction);
                let Some((facet, jacobian, part)) = passing(outgoing, incoming, relative_index)
                else {
                    return ([0.0; 3], 0.0);
                };
                // Walter et al. 2007, eqs. 20 and 21, with both written by the density of the facets.
                let facets = normals(alpha, facet) * outgoing.dot(facet) / outgoing.z;
                ([1.0; 3], part * facets * jacobian * seen_both_ways(alpha, outgoing, incoming))
            }
            Kind::Conductor { alpha: None, .. } | Kind::Dielectric { alpha: None, .. } => {
                ([0.0; 3], 0.0)
            }
        }
    }

    /// The direction of the path and the normal of a facet that it meets, in the frame of the face.
    fn facet(&self, alpha: Option<f64>, random: [f64; 2]) -> (DVec3, DVec3) {
        let (outgoing, _) = self.frame(self.outgoing);
        let facet = alpha.map_or(DVec3::Z, |alpha| visible_normal(alpha, outgoing, random));
        (outgoing, facet)
    }

    /// Where light leaves and where it comes from, in the frame of the face.
    fn frame(&self, direction: DVec3) -> (DVec3, DVec3) {
        let (s, t) = frame::tangents(self.normal);
        let local = |d: DVec3| DVec3::new(d.dot(s), d.dot(t), d.dot(self.normal));
        let outgoing = local(self.outgoing);
        // Along the face itself rounding decides the side.
        let outgoing = DVec3::new(outgoing.x, outgoing.y, outgoing.z.max(1e-9));
        (outgoing, local(direction))
    }

    fn world(&self, local: DVec3) -> DVec3 {
        let (s, t) = frame::tangents(self.normal);
        (s * local.x + t * local.y + self.normal * local.z).normalize()
    }
}

/// The direction that a facet mirrors, `None` below the face.
fn reflected(outgoing: DVec3, facet: DVec3) -> Option<DVec3> {
    Some(facet * (2.0 * outgoing.dot(facet)) - outgoing).filter(|direction| direction.z > 0.0)
}

/// The normal of the facets that mirror one direction into another on the same side.
fn reflecting(outgoing: DVec3, incoming: DVec3) -> Option<DVec3> {
    if incoming.z <= 0.0 {
        return None;
    }
    (outgoing + incoming).try_normalize().filter(|facet| outgoing.dot(*facet) > 0.0)
}

/// The normal of the facets of a dielectric that send light from one direction into the other, the
/// density of directions over that of normals, and the part of the light that goes this way.
fn passing(outgoing: DVec3, incoming: DVec3, relative_index: f64) -> Option<(DVec3, f64, f64)> {
    if incoming.z > 0.0 {
        let facet = reflecting(outgoing, incoming)?;
        let cosine = outgoing.dot(facet);
        let part = fresnel::reflectance(cosine.min(1.0), relative_index);
        return Some((facet, 0.25 / cosine, part));
    }
    // Walter et al. 2007, eqs. 16 and 17.
    let facet = (outgoing + incoming * relative_index).try_normalize()?;
    let facet = if facet.z < 0.0 { -facet } else { facet };
    let (near, far) = (outgoing.dot(facet), incoming.dot(facet));
    if near <= 0.0 || far >= 0.0 {
        return None;
    }
    let sum = near + relative_index * far;
    let jacobian = relative_index * relative_index * -far / (sum * sum);
    Some((facet, jacobian, 1.0 - fresnel::reflectance(near.min(1.0), relative_index)))
}

/// The part of the facets that is seen from both directions over that seen from `outgoing` alone.
fn unshadowed(alpha: f64, outgoing: DVec3, incoming: DVec3) -> f64 {
    seen_both_ways(alpha, outgoing, incoming) * (1.0 + lambda(alpha, outgoing))
}

/// The part of the facets that is seen from both directions: heights are the same for both where light
/// is mirrored (Heitz 2014, eq. 99), apart where it passes through (Walter et al. 2007, eq. 23).
fn seen_both_ways(alpha: f64, outgoing: DVec3, incoming: DVec3) -> f64 {
    let (out, into) = (lambda(alpha, outgoing), lambda(alpha, incoming));
    if incoming.z > 0.0 { 1.0 / (1.0 + out + into) } else { 1.0 / ((1.0 + out) * (1.0 + into)) }
}

/// Reflectance of a metal at an angle of incidence, by that at normal incidence (Schlick 1994, "An
/// Inexpensive BRDF Model for Physically-based Rendering", eq. 15).
fn schlick(normal: [f32; 3], cosine: f64) -> [f32; 3] {
    let x = (1.0 - cosine) as f32;
    let fifth = (x * x) * (x * x) * x;
    normal.map(|r| r + (1.0 - r) * fifth)
}
