//! The surface of an object in its place.

use super::scatterer::{Kind, Scatterer};
use super::{Surface, slope};
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
}

/// Where an object stands.
#[derive(Clone, Debug)]
struct Place {
    shape: SurfaceShape,
    /// World to own space.
    to_own: DAffine3,
}

impl Material {
    /// An object of this shape, placed by `transform`, among air or water of index `surroundings`.
    #[must_use]
    pub fn new(
        surface: Surface,
        (shape, transform): &(SurfaceShape, DAffine3),
        surroundings: f64,
    ) -> Self {
        let place = || Place { shape: shape.clone(), to_own: transform.inverse() };
        let place = match surface {
            Surface::Diffuse { .. } | Surface::Conductor { .. } => None,
            Surface::Dielectric { .. } => Some(place()),
        };
        Self { surface, surroundings, place }
    }

    /// A diffuse surface of one colour, wherever it is.
    #[must_use]
    pub fn diffuse(albedo: [f32; 3]) -> Self {
        Self { surface: Surface::diffuse(albedo), surroundings: 1.0, place: None }
    }

    /// What it does to a path that arrives along the unit vector `arrival` at `position` (metres) of the
    /// piece that was hit.
    #[must_use]
    pub fn scatterer(&self, hit: &SurfaceHit, position: DVec3, arrival: DVec3) -> Scatterer {
        let kind = match self.surface {
            Surface::Diffuse { albedo } => Kind::Diffuse { albedo },
            Surface::Conductor { reflectance, roughness } => {
                Kind::Conductor { reflectance, alpha: slope(roughness) }
            }
            Surface::Dielectric { ior, roughness } => {
                let index = ior / self.surroundings;
                let enters = self.place.as_ref().is_none_or(|place| {
                    place.outwards(hit.id.piece, position).dot(hit.normal) > 0.0
                });
                let relative_index = if enters { index } else { 1.0 / index };
                // Facets between equal media turn nothing.
                let alpha = slope(roughness).filter(|_| (index - 1.0).abs() > 1e-9);
                Kind::Dielectric { relative_index, alpha }
            }
        };
        Scatterer::new(hit.normal, arrival, kind)
    }
}

impl Place {
    /// A vector to the outside of the piece at a point of it, of any length.
    fn outwards(&self, piece: u32, position: DVec3) -> DVec3 {
        let own = match &self.shape {
            SurfaceShape::Sphere => self.to_own.transform_point3(position),
            SurfaceShape::Box => {
                let axis = [DVec3::X, DVec3::Y, DVec3::Z][(piece / 2).min(2) as usize];
                if piece % 2 == 0 { -axis } else { axis }
            }
            SurfaceShape::Plane => DVec3::Y,
            SurfaceShape::Mesh(mesh) => {
                let [a, b, c] = mesh.corners(piece as usize);
                (b - a).cross(c - a)
            }
        };
        // Normals move by the inverse of the transpose, whichever way the object is mirrored.
        self.to_own.matrix3.transpose() * own
    }
}
