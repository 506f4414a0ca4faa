//! What grains fall on besides grains; in quanta.

use super::roof::Roof;
use crate::GrainsError;
use snowgrain_accel::{GrainStacks, GrainStacksError, PlanRectangle, SphereContact, Surfaces};
use snowgrain_geometry::Quantisation;
use snowgrain_math::{Aabb, DMat3, DVec3, Ray};

/// Quanta by which surfaces are asked for lower contacts than count, so that rounding loses none.
const ROUNDING: f64 = 1.0;

/// What grains fall on, seen along the direction of fall.
#[derive(Debug)]
pub(super) struct Ground<'a> {
    kind: GroundKind<'a>,
    /// Where grains do not fall straight down.
    lean: Option<Lean>,
    /// How high the surfaces reach, where grains fall straight down on surfaces.
    roof: Option<Roof>,
}

/// The closed set of grounds.
#[derive(Clone, Copy, Debug)]
enum GroundKind<'a> {
    /// The surfaces of a scene.
    Surfaces { surfaces: &'a Surfaces, quantisation: Quantisation },
    /// The plane y = 0 over a plan of `counts` cells of `side` quanta that repeats.
    LevelFloor { counts: [u16; 2], side: u16 },
}

/// A direction of fall other than straight down.
#[derive(Debug)]
struct Lean {
    drift: [f64; 2],
    /// Against the fall, unit length.
    up: DVec3,
    /// Turns `up` to the y axis.
    turn: DMat3,
    /// The surfaces, turned so.
    turned: Surfaces,
}

impl Lean {
    /// Centre and normal at the first contact of a sphere that falls from `start` by less than
    /// `length`, metres.
    fn drop_sphere(&self, start: DVec3, radius: f64, length: f64) -> Option<(DVec3, DVec3)> {
        let from = self.turn * start;
        let heights = [from.y, from.y - length];
        let contact = self.turned.drop_sphere(from.x, from.z, radius, heights)?;
        let back = self.turn.transpose();
        Some((back * DVec3::new(from.x, contact.center_y, from.z), back * contact.normal))
    }

    fn new(drift: [f64; 2], surfaces: Option<&Surfaces>) -> Self {
        let up = DVec3::new(drift[0], 1.0, drift[1]).normalize();
        let side = up.cross(DVec3::X).normalize();
        let turn = DMat3::from_cols(side.cross(up), up, side).transpose();
        let turned = surfaces.map_or_else(Surfaces::default, |surfaces| surfaces.turned(&turn));
        Self { drift, up, turn, turned }
    }
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
    pub(super) fn surfaces(surfaces: &'a Surfaces, quantisation: Quantisation) -> Self {
        Self { kind: GroundKind::Surfaces { surfaces, quantisation }, lean: None, roof: None }
    }

    /// Prepares for so many drops over `plan`, which ask for surfaces within `margin` quanta of a
    /// vertical.
    pub(super) fn prepare(&mut self, plan: PlanRectangle, margin: f64, drops: f64) {
        self.roof = match &self.kind {
            GroundKind::Surfaces { surfaces, quantisation } if !self.leans() => {
                Some(Roof::over(surfaces, quantisation, plan, margin, drops))
            }
            GroundKind::Surfaces { .. } | GroundKind::LevelFloor { .. } => None,
        };
    }

    /// Whether no surface passes above `height` within `reach` of the vertical at `x, z`.
    #[inline]
    fn is_below(&self, x: f64, z: f64, reach: f64, height: f64) -> bool {
        self.roof.as_ref().is_some_and(|roof| roof.is_below([x, z], reach, height))
    }

    /// Sees everything along the fall with this drift from now on.
    pub(super) fn turn(&mut self, drift: [f64; 2]) {
        if self.lean.as_ref().map_or([0.0; 2], |lean| lean.drift) == drift {
            return;
        }
        let surfaces = match self.kind {
            GroundKind::Surfaces { surfaces, .. } => Some(surfaces),
            GroundKind::LevelFloor { .. } => None,
        };
        self.lean = (drift != [0.0; 2]).then(|| Lean::new(drift, surfaces));
    }

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
        // One side for both directions; the second period is rounded to it. Even numbers of cells,
        // so that stacks may have cells twice as wide.
        let even = |cells: f64| 2.0 * cells.max(1.0);
        let side = (x / even((x / (2.0 * least)).floor())).round();
        let counts = [x, z].map(|width| even((width / (2.0 * side)).round()) as u16);
        let kind = GroundKind::LevelFloor { counts, side: side as u16 };
        Ok(Self { kind, lean: None, roof: None })
    }

    pub(super) fn period(&self) -> Option<[i32; 2]> {
        match &self.kind {
            GroundKind::Surfaces { .. } => None,
            GroundKind::LevelFloor { counts, side } => {
                Some(counts.map(|count| i32::from(count) * i32::from(*side)))
            }
        }
    }

    /// Box of the finite surfaces, metres.
    pub(super) fn bounds(&self) -> Aabb {
        match &self.kind {
            GroundKind::Surfaces { surfaces, .. } => surfaces.bounds(),
            GroundKind::LevelFloor { .. } => Aabb::EMPTY,
        }
    }

    /// Stacks over `plan`, with cells of `side`. Those of a periodic plan are as near to that as
    /// equal parts of its own cells, or pairs of these along each axis, allow, and at least as wide
    /// where its cells or pairs are.
    pub(super) fn new_stacks(
        &self,
        plan: PlanRectangle,
        side: u16,
        drift: [f64; 2],
    ) -> Result<GrainStacks, GrainStacksError> {
        match &self.kind {
            GroundKind::Surfaces { .. } => GrainStacks::new(plan, side, drift),
            GroundKind::LevelFloor { counts, side: whole } => {
                if side > *whole {
                    let pairs = counts.map(|count| u32::from(count / 2));
                    return GrainStacks::periodic([0, 0], pairs, 2 * whole, drift);
                }
                let most = (whole / side.max(1)).max(1);
                let divides = |parts: &u16| whole.is_multiple_of(*parts);
                let parts = (1..=most).rev().find(divides).unwrap_or(1);
                let counts = counts.map(|count| u32::from(count) * u32::from(parts));
                GrainStacks::periodic([0, 0], counts, whole / parts, drift)
            }
        }
    }

    /// The point at height `y` of the line of fall that crosses y = 0 at `x, z`; quanta.
    fn point(&self, x: f64, z: f64, y: f64) -> DVec3 {
        let [drift_x, drift_z] = self.lean.as_ref().map_or([0.0; 2], |lean| lean.drift);
        DVec3::new(x + y * drift_x, y, z + y * drift_z)
    }

    /// Where a line of fall from above meets the ground above height `down_to`.
    pub(super) fn ray_down(&self, x: f64, z: f64, down_to: f64) -> Option<GroundContact> {
        if self.is_below(x, z, 0.0, down_to) {
            return None;
        }
        match &self.kind {
            GroundKind::LevelFloor { .. } => {
                (down_to < 0.0).then_some(GroundContact { height: 0.0, normal: DVec3::Y })
            }
            GroundKind::Surfaces { surfaces, quantisation } => {
                let quantum = quantisation.quantum();
                // As high as a grain can lie; a search that ends above what is already found
                // leaves most of the surfaces out.
                let top = f64::from(Quantisation::MAX_COORDINATE);
                let origin = quantisation.origin() + self.point(x, z, top) * quantum;
                let up = self.lean.as_ref().map_or(DVec3::Y, |lean| lean.up);
                let reach = (top - down_to) * quantum / up.y;
                let hit = surfaces.intersect(&Ray::new(origin, -up), reach, None)?;
                Some(GroundContact { height: top - hit.t * up.y / quantum, normal: hit.normal })
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
        let (GroundKind::Surfaces { quantisation, .. }, Some(lean)) = (&self.kind, &self.lean)
        else {
            return self.drop_straight(x, z, radius, [from, down_to]);
        };
        let (quantum, origin) = (quantisation.quantum(), quantisation.origin());
        let start = from.min(f64::from(Quantisation::MAX_COORDINATE));
        let length = (start - down_to + ROUNDING) * quantum / lean.up.y;
        let start = origin + self.point(x, z, start) * quantum;
        let (center, normal) = lean.drop_sphere(start, radius * quantum, length)?;
        let height = (center.y - origin.y) / quantum;
        (height > down_to).then_some(GroundContact { height, normal })
    }

    /// The same for one that falls straight down at `x, z`.
    pub(super) fn drop_straight(
        &self,
        x: f64,
        z: f64,
        radius: f64,
        [from, down_to]: [f64; 2],
    ) -> Option<GroundContact> {
        if self.is_below(x, z, radius, down_to - radius) {
            return None;
        }
        let contact = match &self.kind {
            GroundKind::LevelFloor { .. } => GroundContact { height: radius, normal: DVec3::Y },
            GroundKind::Surfaces { surfaces, quantisation } => {
                let (quantum, origin) = (quantisation.quantum(), quantisation.origin());
                let start = from.min(f64::from(Quantisation::MAX_COORDINATE));
                let heights = [start, down_to - ROUNDING].map(|y| origin.y + y * quantum);
                let [x, z] = [origin.x + x * quantum, origin.z + z * quantum];
                let contact = surfaces.drop_sphere(x, z, radius * quantum, heights)?;
                let height = (contact.center_y - origin.y) / quantum;
                GroundContact { height, normal: contact.normal }
            }
        };
        (contact.height > down_to).then_some(contact)
    }

    /// Whether grains fall otherwise than straight down.
    pub(super) fn leans(&self) -> bool {
        self.lean.is_some()
    }

    /// Height below which there is no ground, quanta; a plane has none, but stops what falls.
    pub(super) fn lowest(&self) -> f64 {
        match &self.kind {
            GroundKind::LevelFloor { .. } => 0.0,
            GroundKind::Surfaces { surfaces, quantisation } => {
                (surfaces.bounds().min.y - quantisation.origin().y) / quantisation.quantum()
            }
        }
    }

    /// Whether a solid surface (not the level floor) comes within `reach` of `center`; `scratch`
    /// is overwritten.
    pub(super) fn surface_within(
        &self,
        center: DVec3,
        reach: f64,
        scratch: &mut Vec<SphereContact>,
    ) -> bool {
        if self.is_below(center.x, center.z, reach, center.y - reach) {
            return false;
        }
        match &self.kind {
            GroundKind::LevelFloor { .. } => false,
            GroundKind::Surfaces { surfaces, quantisation } => {
                let quantum = quantisation.quantum();
                scratch.clear();
                surfaces.near(quantisation.origin() + center * quantum, reach * quantum, scratch);
                !scratch.is_empty()
            }
        }
    }

    /// Height of the level floor, where there is one.
    pub(super) fn floor(&self) -> Option<f64> {
        matches!(self.kind, GroundKind::LevelFloor { .. }).then_some(0.0)
    }
}
