//! What grains fall on besides grains; in quanta.

use crate::GrainsError;
use snowgrain_accel::{GrainStacks, GrainStacksError, PlanRectangle, SphereContact, Surfaces};
use snowgrain_geometry::Quantisation;
use snowgrain_math::{Aabb, DVec3, Ray};

/// The closed set of grounds.
#[derive(Clone, Copy, Debug)]
pub(super) enum Ground<'a> {
    /// The surfaces of a scene.
    Surfaces { surfaces: &'a Surfaces, quantisation: Quantisation },
    /// The plane y = 0 over a plan of `counts` cells of `side` quanta that repeats.
    LevelFloor { counts: [u16; 2], side: u16 },
}

/// A contact with the ground.
#[derive(Clone, Copy, Debug)]
pub(super) struct GroundContact {
    /// Height of the ray's hit, or of the sphere's centre at its contact, quanta.
    pub(super) height: f64,
    /// Unit normal towards the falling grain.
    pub(super) normal: DVec3,
}

impl<'a> Ground<'a> {
    pub(super) fn level_floor(
        quantisation: &Quantisation,
        widths: [f64; 2],
    ) -> Result<Self, GrainsError> {
        let least = 2.0 * f64::from(Quantisation::MAX_RADIUS_QUANTA);
        let widest = f64::from(Quantisation::MAX_COORDINATE);
        let [x, z] = widths.map(|width| width / quantisation.quantum());
        for width in [x, z] {
            if !(width >= 2.0 * least && width <= widest) {
                return Err(GrainsError::setting(
                    "area",
                    "a periodic floor must be finite and at least four largest radii wide",
                ));
            }
        }
        // One side for both directions; the second period is rounded to it.
        let side = (x / (x / least).floor()).round();
        let counts = [x, z].map(|width| (width / side).round().max(1.0) as u16);
        Ok(Self::LevelFloor { counts, side: side as u16 })
    }

    pub(super) fn period(&self) -> Option<[i32; 2]> {
        match self {
            Self::Surfaces { .. } => None,
            Self::LevelFloor { counts, side } => {
                Some(counts.map(|count| i32::from(count) * i32::from(*side)))
            }
        }
    }

    /// Box of the finite surfaces, metres.
    pub(super) fn bounds(&self) -> Aabb {
        match self {
            Self::Surfaces { surfaces, .. } => surfaces.bounds(),
            Self::LevelFloor { .. } => Aabb::EMPTY,
        }
    }

    /// Stacks over `plan`, with cells of `side`; a periodic plan has its own.
    pub(super) fn new_stacks(
        &self,
        plan: PlanRectangle,
        side: u16,
    ) -> Result<GrainStacks, GrainStacksError> {
        match self {
            Self::Surfaces { .. } => GrainStacks::new(plan, side),
            Self::LevelFloor { counts, side } => GrainStacks::periodic([0, 0], *counts, *side),
        }
    }

    /// Where a vertical ray from above meets the ground above height `down_to`.
    pub(super) fn ray_down(&self, x: f64, z: f64, down_to: f64) -> Option<GroundContact> {
        match self {
            Self::LevelFloor { .. } => {
                (down_to < 0.0).then_some(GroundContact { height: 0.0, normal: DVec3::Y })
            }
            Self::Surfaces { surfaces, quantisation } => {
                let quantum = quantisation.quantum();
                // As high as a grain can lie; a search that ends above what is already found
                // leaves most of the surfaces out.
                let top = f64::from(Quantisation::MAX_COORDINATE);
                let origin = quantisation.origin() + DVec3::new(x, top, z) * quantum;
                let reach = (top - down_to) * quantum;
                let hit = surfaces.intersect(&Ray::new(origin, DVec3::NEG_Y), reach, None)?;
                Some(GroundContact { height: top - hit.t / quantum, normal: hit.normal })
            }
        }
    }

    /// First contact of a sphere that falls from `from` (or from above everything) with the
    /// ground, above height `down_to` of its centre.
    pub(super) fn drop_sphere(
        &self,
        x: f64,
        z: f64,
        radius: f64,
        [from, down_to]: [f64; 2],
    ) -> Option<GroundContact> {
        let contact = match self {
            Self::LevelFloor { .. } => GroundContact { height: radius, normal: DVec3::Y },
            Self::Surfaces { surfaces, quantisation } => {
                let (quantum, origin) = (quantisation.quantum(), quantisation.origin());
                let start = from.min(f64::from(Quantisation::MAX_COORDINATE));
                let contact = surfaces.drop_sphere(
                    origin.x + x * quantum,
                    origin.z + z * quantum,
                    radius * quantum,
                    origin.y + start * quantum,
                )?;
                let height = (contact.center_y - origin.y) / quantum;
                GroundContact { height, normal: contact.normal }
            }
        };
        (contact.height > down_to).then_some(contact)
    }

    /// Whether a solid surface (not the level floor) comes within `reach` of `center`; `scratch`
    /// is overwritten.
    pub(super) fn surface_within(
        &self,
        center: DVec3,
        reach: f64,
        scratch: &mut Vec<SphereContact>,
    ) -> bool {
        match self {
            Self::LevelFloor { .. } => false,
            Self::Surfaces { surfaces, quantisation } => {
                let quantum = quantisation.quantum();
                scratch.clear();
                surfaces.near(quantisation.origin() + center * quantum, reach * quantum, scratch);
                !scratch.is_empty()
            }
        }
    }

    /// Height of the level floor, where there is one.
    pub(super) fn floor(&self) -> Option<f64> {
        matches!(self, Self::LevelFloor { .. }).then_some(0.0)
    }
}
