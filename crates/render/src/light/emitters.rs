//! Which surfaces of a scene shine.

use super::description::{LightDescription, LightKind};
use snowgrain_accel::SurfaceShape;
use snowgrain_geometry::TriangleMesh;
use snowgrain_math::{DAffine3, DMat3, DVec3};
use std::sync::Arc;

/// A surface that shines. It is black: light that meets it ends there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Emitter {
    /// Index of the light.
    pub light: usize,
    /// The side that shines, by its normal; both where there is none.
    pub front: Option<DVec3>,
    /// Whether camera rays that meet nothing before see it, or pass through it.
    pub visible_to_camera: bool,
}

impl Emitter {
    /// Whether it shines into a direction.
    #[must_use]
    pub fn shines_towards(&self, direction: DVec3) -> bool {
        self.front.is_none_or(|front| direction.dot(front) > 0.0)
    }
}

/// A light that is a surface.
#[derive(Clone, Debug)]
pub(super) struct SurfaceLight {
    pub(super) shape: SurfaceShape,
    pub(super) transform: DAffine3,
    pub(super) emitter: Emitter,
    /// Index among all surfaces.
    pub(super) object: u32,
}

/// The surfaces of a scene with those of its lights.
#[derive(Clone, Debug, Default)]
pub struct LitSurfaces {
    /// Objects in their order, then the spheres and quads among the lights in theirs.
    pub shapes: Vec<(SurfaceShape, DAffine3)>,
    /// Of each of them whether it shines; empty where none does.
    pub emitters: Vec<Option<Emitter>>,
}

impl LitSurfaces {
    /// Objects of these shapes, and the lights.
    #[must_use]
    pub fn new(objects: Vec<(SurfaceShape, DAffine3)>, lights: &[LightDescription]) -> Self {
        let mut shapes = objects;
        let mut found = Vec::new();
        for (light, description) in lights.iter().enumerate() {
            let (object, front) = match description.kind {
                LightKind::Object { object } => (object, None),
                LightKind::Sphere { center, radius } => {
                    let scale = DMat3::from_diagonal(DVec3::splat(radius));
                    let place = DAffine3::from_mat3_translation(scale, center);
                    shapes.push((SurfaceShape::Sphere, place));
                    (shapes.len() - 1, None)
                }
                LightKind::Quad { corner, edges: [u, v] } => {
                    shapes.push((
                        SurfaceShape::Mesh(Arc::new(quad(corner, u, v))),
                        DAffine3::IDENTITY,
                    ));
                    (shapes.len() - 1, Some(u.cross(v).normalize()))
                }
                LightKind::Sky
                | LightKind::Uniform
                | LightKind::Overcast
                | LightKind::ClearSky { .. }
                | LightKind::Sun { .. }
                | LightKind::Environment { .. }
                | LightKind::Point { .. }
                | LightKind::Spot { .. } => continue,
            };
            let visible_to_camera = description.visible_to_camera;
            found.push((object, Emitter { light, front, visible_to_camera }));
        }
        let mut emitters = Vec::new();
        if !found.is_empty() {
            emitters.resize(shapes.len(), None);
        }
        for (object, emitter) in found {
            if let Some(place) = emitters.get_mut(object) {
                *place = Some(emitter);
            }
        }
        Self { shapes, emitters }
    }

    /// The surface of a light, if it is one.
    pub(super) fn of_light(&self, light: usize) -> Option<SurfaceLight> {
        let is_it = |emitter: &Option<Emitter>| emitter.is_some_and(|it| it.light == light);
        let object = self.emitters.iter().position(is_it)?;
        let (shape, transform) = self.shapes[object].clone();
        let emitter = self.emitters[object]?;
        Some(SurfaceLight { shape, transform, emitter, object: object as u32 })
    }
}

/// A parallelogram.
fn quad(corner: DVec3, u: DVec3, v: DVec3) -> TriangleMesh {
    TriangleMesh {
        positions: vec![corner, corner + u, corner + u + v, corner + v],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        coordinates: Vec::new(),
    }
}
