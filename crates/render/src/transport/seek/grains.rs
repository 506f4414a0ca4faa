//! Light at a grain that a path strikes at a random place.

use super::{PathState, Seeker, Wanted, product, scaled, search_key};
use crate::transport::Contribution;
use snowgrain_accel::{ArrivalFrom, GrainVisit, Probe};
use snowgrain_math::sampler::numbers;
use snowgrain_math::{DVec3, Ray, frame, trig};

/// Density of scattering, 1/sr, above which every light that was drawn gets its shadow ray; below it one
/// in so many, which stands for the others. Half of that of a grain that scatters evenly.
const ALWAYS: f64 = 0.04;

impl Seeker<'_> {
    /// Draws a light and a way through the grain towards it.
    pub(super) fn at_random_place(
        &mut self,
        visit: &GrainVisit,
        direction: DVec3,
        state: &PathState,
    ) {
        let key = search_key(state.key);
        let [light, u, v] = numbers(key, 2 * visit.event).map(f64::from);
        let [survival, order, place] = numbers(key, 2 * visit.event + 1).map(f64::from);
        let grid = &self.world.grid;
        let center = grid.world(visit.center);
        let Some(sample) = self.search.sought.sample(center, [light, u, v]) else { return };
        let table = match visit.from {
            ArrivalFrom::Air => &self.search.from_air,
            ArrivalFrom::Ice => &self.search.from_ice,
        };
        let cosine = direction.dot(sample.direction);
        let density = table.density(cosine);
        let chance = (density / ALWAYS).min(1.0);
        if survival >= chance {
            return;
        }
        let Some(way) = table.way(cosine, [order, place]) else { return };
        let normal = turned(direction, sample.direction, cosine, way.exit);
        let stored = (visit.center, visit.radius);
        let length = self.quanta(sample.distance);
        let Some(probe) = Probe::leaving(grid, stored, normal, sample.direction, length) else {
            return;
        };
        // The balance heuristic: sample.pdf / (sample.pdf + density).
        let weight = density / (chance * (sample.pdf + density));
        let in_grain = match visit.from {
            ArrivalFrom::Air => way.length * f64::from(visit.radius),
            ArrivalFrom::Ice => {
                (way.length * f64::from(visit.radius) + f64::from(visit.to_middle)).max(0.0)
            }
        };
        let quantum = grid.quantum();
        let mut ice_in_strata = visit.ice_in_strata.map(|length| f64::from(length) * quantum);
        if let Some(stratum) = usize::from(visit.stratum).checked_sub(1) {
            ice_in_strata[stratum] += in_grain * quantum;
        }
        let contribution = Contribution {
            slot: sample.slot,
            glint: false,
            weight: scaled(product(state.throughput, sample.radiance), weight),
            ice_length: (f64::from(visit.ice_length) + in_grain) * quantum,
            ice_in_strata,
        };
        let ray = Ray::new(grid.world(probe.start), sample.direction);
        self.rays.push(probe);
        self.wanted.push(Wanted { lane: visit.lane, contribution, ray, distance: sample.distance });
    }
}

/// The unit vector at an angle from `from` towards `to`, of cosine `cosine` between them.
pub(super) fn turned(from: DVec3, to: DVec3, cosine: f64, angle: f64) -> DVec3 {
    let across = (to - from * cosine).try_normalize().unwrap_or_else(|| frame::tangents(from).0);
    let (sin, cos) = trig::sin_cos(angle);
    (from * cos + across * sin).normalize()
}
