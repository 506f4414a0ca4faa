//! One falling grain under each rule.

use super::ground::Ground;
use super::pile::Lying;
use super::roll::{Roller, RollingSphere};
use crate::{DepositSettings, GrainsError, Radii, Settling};
use snowgrain_accel::{Fall, GrainStacks, PlanRectangle, Quad};
use snowgrain_geometry::{GeometryError, Quantisation, QuantisedGrain};
use snowgrain_math::sampler::{PathKey, pcg3d};
use snowgrain_math::{DVec3, trig};

/// What becomes of a falling grain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Fate {
    /// It lies here.
    Rests(QuantisedGrain),
    /// It was left here without a stable support.
    Unsettled(QuantisedGrain),
    /// Its contact was too steep.
    TooSteep,
    /// It met nothing.
    Missed,
}

/// Where a drop falls: where its line crosses y = 0, and its radius; quanta.
#[derive(Clone, Copy, Debug)]
pub(super) struct Start {
    pub(super) x: i32,
    pub(super) z: i32,
    pub(super) radius: u16,
    /// The low word of its number.
    index: u32,
}

/// Everything about the drops of one snowfall that does not change.
pub(super) struct Drop<'a> {
    pub(super) settling: Settling,
    quantisation: Quantisation,
    pub(super) ground: &'a Ground<'a>,
    pub(super) area: PlanRectangle,
    /// Height below which a fall meets nothing but planes, quanta.
    pub(super) lowest: f64,
    /// Least y of an accepted contact normal.
    pub(super) least_cosine: f64,
    /// Radii in quanta.
    pub(super) radii: Radii,
    pub(super) seed: u64,
    pub(super) snowfall: u64,
}

impl<'a> Drop<'a> {
    pub(super) fn new(
        settings: &DepositSettings,
        settling: Settling,
        quantisation: &Quantisation,
        ground: &'a Ground<'a>,
        (area, lowest): (PlanRectangle, f64),
        snowfall: u64,
    ) -> Self {
        let slope = settings.max_slope_degrees;
        let least_cosine = if slope >= 90.0 { 0.0 } else { trig::sin_cos(slope.to_radians()).1 };
        Self {
            settling,
            quantisation: *quantisation,
            ground,
            area,
            lowest,
            least_cosine,
            radii: settings.radii.in_units_of(quantisation.quantum()),
            seed: settings.seed,
            snowfall,
        }
    }

    /// Whether a grain comes to rest near the line along which it falls: it rolls nowhere.
    pub(super) fn is_local(&self) -> bool {
        match self.settling {
            Settling::Ray | Settling::Stick | Settling::Aggregates { .. } => true,
            Settling::Roll | Settling::StickOrRoll { .. } | Settling::Sinter { .. } => false,
        }
    }

    /// How far from its line of fall a drop asks and stores, quanta.
    pub(super) fn reach(&self, stacks: &GrainStacks) -> f64 {
        self.settling.reach(stacks.largest_radius().into())
    }

    /// Cells of this side that the area would fill.
    pub(super) fn area_in_cells(&self, side: u16) -> f64 {
        let PlanRectangle { min, max } = self.area;
        let edge = |axis: usize| (f64::from(max[axis]) - f64::from(min[axis])) / f64::from(side);
        edge(0) * edge(1)
    }

    /// Where drop number `index` falls, and its radius.
    #[inline]
    pub(super) fn start(&self, index: u64) -> Start {
        let key = PathKey::new(self.seed, index, self.snowfall);
        let [a, b, c] = pcg3d(key.lo, key.hi, 0);
        let PlanRectangle { min, max } = self.area;
        let (x, z) = (uniform_below(a, min[0], max[0]), uniform_below(b, min[1], max[1]));
        Start { x, z, radius: self.radius(c), index: index as u32 }
    }

    /// Lets a drop fall on what lies; `quad` are the cells of its line.
    #[inline]
    pub(super) fn fall(
        &self,
        lying: &Lying<'_, '_>,
        roller: &mut Roller<'_>,
        start: Start,
        quad: &Quad,
    ) -> Result<Fate, GrainsError> {
        let Start { x, z, radius, index } = start;
        let [x, z] = [x, z].map(f64::from);
        let mut roll = |touch: f64, roll: f64| {
            let full = f64::from(radius);
            let key = PathKey::new(self.seed, index.into(), self.snowfall);
            let sphere = RollingSphere { to_ground: full, to_grains: touch * full, roll, key };
            let rest = roller.settle(lying, [x, z], sphere);
            rest.fate(|center| self.rounded(center, radius))
        };
        match self.settling {
            Settling::Ray => self.ray(lying, quad, [x, z], radius),
            Settling::Stick | Settling::Aggregates { .. } => {
                self.stick(lying, quad, [x, z], radius)
            }
            Settling::Roll => roll(1.0, 1.0),
            Settling::StickOrRoll { roll: probability } => roll(1.0, probability),
            Settling::Sinter { touch } => roll(touch, 1.0),
        }
    }

    /// The radius for a random word, at least one quantum.
    pub(super) fn radius(&self, word: u32) -> u16 {
        let unit = (f64::from(word) + 0.5) / 4_294_967_296.0;
        nearest(self.radii.quantile(unit)).clamp(1, Quantisation::MAX_RADIUS_QUANTA.into()) as u16
    }

    /// The paper's rule.
    #[inline]
    fn ray(
        &self,
        lying: &Lying<'_, '_>,
        quad: &Quad,
        [x, z]: [f64; 2],
        radius: u16,
    ) -> Result<Fate, GrainsError> {
        let hit = lying.first_contact_at(quad, &Fall::from_above(x, z, 0.0));
        let down_to = hit.map_or(f64::NEG_INFINITY, |hit| hit.height);
        let (at, normal) = match (self.ground.ray_down(x, z, down_to), hit) {
            (Some(ground), _) => (lying.region.point(x, z, ground.height), ground.normal),
            (None, Some(hit)) => {
                let at = lying.region.point(x, z, hit.height);
                (at, (at - center(hit.grain)) / f64::from(hit.grain.radius))
            }
            (None, None) => return Ok(Fate::Missed),
        };
        if normal.y < self.least_cosine {
            return Ok(Fate::TooSteep);
        }
        let center = at + normal * f64::from(radius);
        Ok(Fate::Rests(self.rounded(center, radius)?))
    }

    /// The first contact of the sphere itself. Where it falls along a vertical, that goes through a
    /// lattice point, so rounding its height up leaves no overlap at all.
    #[inline]
    fn stick(
        &self,
        lying: &Lying<'_, '_>,
        quad: &Quad,
        [x, z]: [f64; 2],
        radius: u16,
    ) -> Result<Fate, GrainsError> {
        let falling = f64::from(radius);
        let hit = lying.first_contact_at(quad, &Fall::from_above(x, z, falling));
        let down_to = hit.map_or(f64::NEG_INFINITY, |hit| hit.height);
        let ground = self.ground.drop_sphere(x, z, falling, [f64::INFINITY, down_to]);
        let (height, normal) = match (ground, hit) {
            (Some(ground), _) => (ground.height, ground.normal),
            (None, Some(hit)) => {
                let reach = falling + f64::from(hit.grain.radius);
                let at = lying.region.point(x, z, hit.height);
                (hit.height, (at - center(hit.grain)) / reach)
            }
            (None, None) => return Ok(Fate::Missed),
        };
        if normal.y < self.least_cosine {
            return Ok(Fate::TooSteep);
        }
        let at = lying.region.point(x, z, height.ceil());
        Ok(Fate::Rests(self.rounded(at, radius)?))
    }

    /// The grain at the nearest whole quanta, if the lattice reaches that far.
    pub(super) fn rounded(&self, at: DVec3, radius: u16) -> Result<QuantisedGrain, GrainsError> {
        let reach = f64::from(Quantisation::MAX_COORDINATE);
        if !at.is_finite() || at.abs().max_element() > reach {
            let quantum = self.quantisation.quantum();
            let DVec3 { x, y, z } = self.quantisation.origin() + at * quantum;
            let reach = reach * quantum;
            return Err(GeometryError::OutOfLattice { x, y, z, reach }.into());
        }
        Ok(QuantisedGrain { center: at.to_array().map(nearest), radius })
    }
}

/// The nearest whole number, ties away from zero; `x` lies well within its range.
#[inline(always)]
pub(super) fn nearest(x: f64) -> i32 {
    let towards_zero = x as i32;
    let rest = x - f64::from(towards_zero);
    towards_zero + i32::from(rest >= 0.5) - i32::from(rest <= -0.5)
}

/// Centre of a grain, quanta.
pub(super) fn center(grain: QuantisedGrain) -> DVec3 {
    let [x, y, z] = grain.center.map(f64::from);
    DVec3::new(x, y, z)
}

/// A whole number of `[low, high)` from a random word.
fn uniform_below(word: u32, low: i32, high: i32) -> i32 {
    let width = i64::from(high) - i64::from(low);
    (i64::from(low) + ((i64::from(word) * width) >> 32)) as i32
}
