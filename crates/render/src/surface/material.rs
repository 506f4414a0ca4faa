//! The surface of an object in its place.

use super::place::Place;
use super::scatterer::{Kind, Scatterer};
use super::{Reflectance, Surface, slope};
use crate::description::DirectView;
use snowgrain_accel::{SurfaceHit, SurfaceShape};
use snowgrain_math::{DAffine3, DVec3};

/// The surface of an object in its place.
#[derive(Clone, Debug)]
pub struct Material {
    surface: Surface,
    /// Index of refraction around objects.
    surroundings: f64,
    /// Where it matters which point of the object is met.
    place: Option<Place>,
    direct_view: DirectView,
}

impl Material {
    /// An object of this shape, placed by `transform`, among air or water of index `surroundings`.
    #[must_use]
    pub fn new(surface: Surface, object: &(SurfaceShape, DAffine3), surroundings: f64) -> Self {
        let place = match &surface {
            Surface::Diffuse { albedo: Reflectance::Colour(_) }
            | Surface::Conductor { reflectance: Reflectance::Colour(_), .. } => None,
            Surface::Diffuse { albedo: Reflectance::Texture(_) }
            | Surface::Conductor { reflectance: Reflectance::Texture(_), .. }
            | Surface::Dielectric { .. } => Some(Place::new(object)),
        };
        Self { surface, surroundings, place, direct_view: DirectView::Seen }
    }

    /// A diffuse surface of one colour, wherever it is.
    #[must_use]
    pub fn diffuse(albedo: [f32; 3]) -> Self {
        Self {
            surface: Surface::diffuse(albedo),
            surroundings: 1.0,
            place: None,
            direct_view: DirectView::Seen,
        }
    }

    /// The same, of which the camera sees this directly.
    #[must_use]
    pub fn seen_as(self, direct_view: DirectView) -> Self {
        Self { direct_view, ..self }
    }

    /// What the camera sees of it directly.
    #[must_use]
    pub fn direct_view(&self) -> DirectView {
        self.direct_view
    }

    /// What it does to a path that arrives along the unit vector `arrival` at `position` (metres) of the
    /// piece that was hit.
    #[must_use]
    pub fn scatterer(&self, hit: &SurfaceHit, position: DVec3, arrival: DVec3) -> Scatterer {
        let kind = match &self.surface {
            Surface::Diffuse { albedo } => {
                Kind::Diffuse { albedo: self.part(albedo, hit.id.piece, position) }
            }
            Surface::Conductor { reflectance, edge, roughness } => Kind::Conductor {
                edge: *edge,
                reflectance: self.part(reflectance, hit.id.piece, position),
                alpha: slope(*roughness),
            },
            Surface::Dielectric { ior, roughness } => {
                let index = ior / self.surroundings;
                let enters = self.place.as_ref().is_none_or(|place| {
                    place.outwards(hit.id.piece, position).dot(hit.normal) > 0.0
                });
                let relative_index = if enters { index } else { 1.0 / index };
                // Facets between equal media turn nothing.
                let alpha = slope(*roughness).filter(|_| (index - 1.0).abs() > 1e-9);
                Kind::Dielectric { relative_index, alpha }
            }
        };
        Scatterer::new(hit.normal, arrival, kind)
    }

    /// A reflectance at a point of a piece.
    fn part(&self, of: &Reflectance, piece: u32, position: DVec3) -> [f32; 3] {
        match (of, &self.place) {
            (Reflectance::Colour(colour), _) => *colour,
            (Reflectance::Texture(map), Some(place)) => {
                let colour = map.texture.at(place.coordinates(piece, position, map.metres));
                std::array::from_fn(|i| colour[i] * map.factor[i])
            }
            (Reflectance::Texture(map), None) => map.factor,
        }
    }
}
