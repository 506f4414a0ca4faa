//! Light at a grain that a path strikes at a random place.

use super::gains::Class;
use super::shadow::{Beginning, Brings, Condition, Wanted};
use super::{LastArrival, PathState, Seeker, product, scaled, search_key};
use crate::transport::Contribution;
use crate::transport::ice::IceLength;
use snowgrain_accel::{ArrivalFrom, GrainVisit, Probe};
use snowgrain_math::sampler::numbers;
use snowgrain_math::{DVec3, Ray, frame, trig};
use snowgrain_optics::scatter::Way;

/// Density of scattering, 1/sr, above which every light that was drawn gets its shadow ray; below it one
/// in so many, which stands for the others. That of a grain that scatters evenly is .08: a tenth of the
/// shadow rays are saved for a hundredth more variance.
const ALWAYS: f64 = 0.1;

impl Seeker<'_> {
    /// Draws a light and a way through the grain towards it.
    pub(super) fn at_random_place(
        &mut self,
        visit: &GrainVisit,
        last: &LastArrival,
        (order, seen_along): (u32, DVec3),
        state: &PathState,
    ) {
        let search = self.search;
        let key = search_key(state.key);
        let [light, u, v] = numbers(key, 2 * visit.event).map(f64::from);
        let Some(sample) = search.sought_at(order).sample(last.center, [light, u, v]) else {
            return;
        };
        let [survival, which, place] = numbers(key, 2 * visit.event + 1).map(f64::from);
        let table = search.table(visit.from, last.prototype);
        let cosine = last.direction.dot(sample.direction);
        let density = table.density(cosine);
        let chance = (density / ALWAYS).min(1.0);
        if survival >= chance {
            return;
        }
        let Some(way) = table.way(cosine, [which, place]) else { return };
        let normal = |angle| turned(last.direction, sample.direction, cosine, angle);
        let ways = [last.direction, sample.direction];
        let gain = search.gains.gain(&Class::new((visit.from, order), seen_along, ways));
        // The balance heuristic; nothing meets a point by chance.
        let rivals = if sample.is_point { 0.0 } else { density };
        let weight = gain * density / (chance * (sample.pdf + rivals));
        let ice = state.ice_before + self.ice_of(visit, &way);
        let brings = Brings::Light(Contribution {
            slot: sample.slot,
            glint: false,
            event: visit.event,
            weight: scaled(product(state.throughput, sample.radiance), weight),
            ice_length: ice.all,
            ice_in_strata: ice.in_strata,
        });
        let towards = (sample.direction, sample.distance, sample.surface.map(|id| id.object));
        let begins = |origin| Beginning {
            grain: (visit.center, visit.radius),
            direction: last.direction,
            normal: normal(way.entry),
            origin,
            key,
            event: visit.event,
        };
        let condition = last.origin.map_or(Condition::Nothing, |at| Condition::Begins(begins(at)));
        self.want(visit, (normal(way.exit), visit.radius), towards, brings, condition);
    }

    /// Sends a shadow ray from the grain, from so many quanta off its centre along a unit vector, in a direction
    /// over a distance to a lamp.
    pub(super) fn want(
        &mut self,
        visit: &GrainVisit,
        (along, reach): (DVec3, f32),
        (direction, distance, lamp): (DVec3, f64, Option<u32>),
        brings: Brings,
        condition: Condition,
    ) {
        let grid = &self.world.grid;
        let length = self.quanta(distance);
        if let Some(probe) = Probe::leaving(grid, (visit.center, reach), along, direction, length) {
            let ray = Ray::new(grid.world(probe.start), direction);
            self.rays.push(probe);
            let lane = visit.lane;
            self.wanted.push(Wanted { lane, brings, ray, distance, lamp, condition });
        }
    }

    /// Length in ice of a path that takes a way through the grain, and that in grains of each stratum.
    fn ice_of(&self, visit: &GrainVisit, way: &Way) -> IceLength {
        let quantum = self.world.grid.quantum();
        let in_grain = way.length * f64::from(visit.radius);
        let in_grain = match visit.from {
            ArrivalFrom::Air => in_grain,
            ArrivalFrom::Ice => (in_grain + f64::from(visit.to_middle)).max(0.0),
        };
        let mut in_strata = visit.ice_in_strata.map(|length| f64::from(length) * quantum);
        if let Some(stratum) = usize::from(visit.stratum).checked_sub(1) {
            in_strata[stratum] += in_grain * quantum;
        }
        IceLength { all: (f64::from(visit.ice_length) + in_grain) * quantum, in_strata }
    }
}

/// The unit vector at an angle from `from` towards `to`, of cosine `cosine` between them.
pub(super) fn turned(from: DVec3, to: DVec3, cosine: f64, angle: f64) -> DVec3 {
    let across = (to - from * cosine).try_normalize().unwrap_or_else(|| frame::tangents(from).0);
    let (sin, cos) = trig::sin_cos(angle);
    (from * cos + across * sin).normalize()
}
