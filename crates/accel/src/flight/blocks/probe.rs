//! Straight rays through the pores: is anything in the way, and what?
//!
//! They are tested as the paths of a flight are, sixteen grains a round and sixteen rays a step, but
//! end at the first grain.

use super::BlockFlight;
use super::paths::{GROUP, get, set};
use super::test::test_group;
use super::update::{ProbedSets, probe_group};
use crate::flight::{FlightEvent, LANES, MetGrain, Probe, ProbeAnswer};
use crate::grain_grid::{GridPosition, MEETS_SURFACE, OVERLAPS, RADIUS_MASK};
use crate::{GrainGrid, SimdLevel, Surfaces};
use fearless_simd::{Level, Simd, dispatch};

/// Straight rays in flight, up to [`LANES`].
#[derive(Debug)]
pub(in super::super) struct BlockProbes<'a> {
    flight: BlockFlight<'a>,
    level: Level,
    answers: Vec<(usize, ProbeAnswer)>,
}

impl<'a> BlockProbes<'a> {
    /// None in flight. `surfaces` are not looked at.
    ///
    /// # Panics
    /// If the machine does not have `level`.
    pub(in super::super) fn new(
        grid: &'a GrainGrid,
        surfaces: &'a Surfaces,
        level: SimdLevel,
    ) -> Self {
        Self {
            flight: BlockFlight::new(grid, surfaces, 1.0),
            level: level.token().expect("the SIMD level was checked when it was chosen"),
            answers: Vec::with_capacity(LANES),
        }
    }

    /// Follows all `probes`; `answer` is told the index and the answer of each, in no order.
    pub(in super::super) fn follow(
        &mut self,
        probes: &[Probe],
        mut answer: impl FnMut(usize, ProbeAnswer),
    ) {
        let mut next = 0;
        let mut of_lane = [0; LANES];
        let lanes = probes.len().min(LANES);
        self.flight.use_lanes(lanes);
        while next < lanes {
            of_lane[next] = next;
            self.launch(next, &probes[next]);
            next += 1;
        }
        loop {
            let Self { flight, answers, level } = self;
            dispatch!(*level, simd => run(simd, flight, answers));
            if answers.is_empty() {
                return;
            }
            for index in 0..self.answers.len() {
                let (lane, found) = self.answers[index];
                answer(of_lane[lane], found);
                if let Some(probe) = probes.get(next) {
                    of_lane[lane] = next;
                    self.launch(lane, probe);
                    next += 1;
                }
            }
            self.answers.clear();
        }
    }

    fn launch(&mut self, lane: usize, probe: &Probe) {
        let entry = self.flight.grid.fetchable_entry(probe.start.cell);
        let (group, at) = self.flight.lane_mut(lane);
        group.pause(at);
        set(&mut group.position, at, probe.start.local);
        set(&mut group.cell, at, probe.start.cell);
        set(&mut group.direction, at, probe.direction);
        group.air_length[at] = 0.0;
        group.chord[at] = probe.length;
        group.grain_radius[at] = 0;
        match probe.leaves {
            Some(center) => {
                set(&mut group.grain, at, center);
                group.ice |= 1 << at;
            }
            None => group.air |= 1 << at,
        }
        group.set_entry(at, entry);
    }
}

/// Rounds until a probe has its answer or none is in flight.
#[inline(always)]
fn run<S: Simd>(simd: S, flight: &mut BlockFlight<'_>, answers: &mut Vec<(usize, ProbeAnswer)>) {
    let groups = flight.groups_in_use;
    while answers.is_empty() && flight.groups[..groups].iter().any(|g| g.flying() != 0) {
        for index in 0..groups {
            let group = &mut flight.groups[index];
            test_group(simd, (flight.grid.blocks(), flight.grid.strata()), group);
            let ProbedSets { met, covered, ended, beyond } =
                probe_group(simd, &flight.shape, group);
            for at in lanes_of(met) {
                let (group, lane) = (&flight.groups[index], index * GROUP + at);
                let bits = group.found_radius[at];
                let grain = MetGrain {
                    center: GridPosition {
                        cell: get(&group.cell, at),
                        local: get(&group.found_grain, at).map(f32::from),
                    },
                    radius: f32::from(bits & RADIUS_MASK),
                    stratum: group.found_stratum[at],
                    overlaps: bits & OVERLAPS != 0,
                    meets_surface: bits & MEETS_SURFACE != 0,
                };
                let distance = group.air_length[at] + group.found[at];
                answers.push((lane, ProbeAnswer::Met { distance, grain }));
            }
            let told = |set: u32, answer| lanes_of(set).map(move |at| (index * GROUP + at, answer));
            answers.extend(told(covered, ProbeAnswer::Covered));
            answers.extend(told(ended, ProbeAnswer::Clear));
            flight.look_closer(index, beyond);
            let left = flight.events.drain(..);
            answers.extend(left.map(|(lane, event)| {
                debug_assert_eq!(event, FlightEvent::Left, "probes meet nothing else");
                (lane, ProbeAnswer::Clear)
            }));
            flight.prefetch_entries(index);
            if index > 0 {
                flight.fetch_entries(index - 1);
            }
        }
        flight.fetch_entries(groups - 1);
    }
}

/// The numbers of the bits that are set.
fn lanes_of(mut set: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let at = set.trailing_zeros() as usize & (GROUP - 1);
        let any = set != 0;
        set &= set.wrapping_sub(1);
        any.then_some(at)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Packing;
    use snowgrain_geometry::{Grain, Quantisation};
    use snowgrain_math::sampler::{PathKey, numbers};
    use snowgrain_math::{DVec3, Ray, frame};

    const RADIUS: f64 = 0.5;

    fn random(index: u64, event: u32) -> DVec3 {
        DVec3::from_array(numbers(PathKey::new(9, index, 0), event).map(f64::from))
    }

    /// Grains in a box of 8 m, half of which overlap others.
    fn grains(quantisation: &Quantisation) -> Vec<snowgrain_geometry::QuantisedGrain> {
        let grain = |index| {
            let radius = RADIUS * (0.4 + 0.6 * random(index, 1).x);
            quantisation.round(random(index, 0) * 8.0, radius).unwrap()
        };
        (0..400).map(grain).collect()
    }

    /// Distance of the first grain that the ray enters, metres; `None` where it starts within one.
    fn first(grains: &[Grain], ray: &Ray, own: Option<usize>) -> Option<f64> {
        let mut nearest = f64::INFINITY;
        for (index, grain) in grains.iter().enumerate() {
            if own == Some(index) {
                continue;
            }
            let to_center = grain.center - ray.origin;
            if to_center.length() < grain.radius {
                return None;
            }
            let middle = to_center.dot(ray.direction);
            let foot = to_center - middle * ray.direction;
            let half2 = grain.radius * grain.radius - foot.length_squared();
            if middle > 0.0 && half2 > 0.0 {
                nearest = nearest.min(middle - half2.sqrt());
            }
        }
        Some(nearest)
    }

    #[test]
    fn probes_find_what_a_search_of_all_grains_finds() {
        let quantisation = Quantisation::for_grains(DVec3::splat(4.0), RADIUS);
        let stored = grains(&quantisation);
        let surfaces = Surfaces::default();
        let grid = GrainGrid::build(quantisation, &stored, &surfaces, Packing::Fast).unwrap();
        let grains: Vec<Grain> = stored.iter().map(|&grain| quantisation.grain(grain)).collect();
        let quantum = grid.quantum();
        let mut probes = Vec::new();
        let mut expected = Vec::new();
        for (index, grain) in (0..).zip(&grains) {
            for turn in 0..20u32 {
                let [u, v] = [random(index, 2 + turn).x, random(index, 2 + turn).y];
                let normal = frame::cosine_hemisphere(DVec3::Y, [u, v]);
                let normal = if turn % 2 == 0 { normal } else { -normal };
                let [u, v] = [random(index, 50 + turn).x, random(index, 50 + turn).y];
                let direction = frame::cosine_hemisphere(normal, [u, v]);
                let ray = Ray::new(grain.center + normal * grain.radius, direction);
                let length = 6.0 * random(index, 50 + turn).z;
                let at = grid.locate(grain.center);
                let at = GridPosition { local: at.local.map(f32::round), ..at };
                let stored = (at, (grain.radius / quantum) as f32);
                let length_quanta = (length / quantum) as f32;
                let probe = Probe::leaving(&grid, stored, normal, direction, length_quanta);
                probes.push(probe.unwrap());
                expected.push((first(&grains, &ray, Some(index as usize)), length));
            }
        }
        for level in SimdLevel::available() {
            let mut counts = [0; 3];
            let mut seen = vec![false; probes.len()];
            BlockProbes::new(&grid, &surfaces, level).follow(&probes, |index, answer| {
                assert!(!std::mem::replace(&mut seen[index], true), "one answer each");
                let (nearest, length) = expected[index];
                let near = |a: f64, b: f64| (a - b).abs() < 1e-3;
                match (answer, nearest) {
                    (ProbeAnswer::Covered, None) => counts[0] += 1,
                    (ProbeAnswer::Met { distance, grain }, Some(nearest)) => {
                        counts[1] += 1;
                        let distance = f64::from(distance) * quantum;
                        assert!(near(distance, nearest), "{index}: {distance} {nearest}");
                        let (center, radius) = (grid.world(grain.center), f64::from(grain.radius));
                        let other = |other: &&Grain| (other.center - center).length() >= 1e-6;
                        let met = grains.iter().find(|grain| !other(grain)).unwrap();
                        assert!(near(met.radius, radius * quantum), "{index}: {center}");
                        let touches = |other: &Grain| {
                            (other.center - center).length() < other.radius + met.radius
                        };
                        let overlaps = grains.iter().filter(other).any(touches);
                        assert_eq!(grain.overlaps, overlaps, "{index}: {center}");
                    }
                    (ProbeAnswer::Clear, Some(nearest)) => {
                        counts[2] += 1;
                        assert!(nearest > length - 1e-3, "{index}: {nearest} {length}");
                    }
                    (answer, nearest) => panic!("{index}: {answer:?}, expected {nearest:?}"),
                }
            });
            assert!(seen.iter().all(|&seen| seen) && counts.iter().all(|&n| n > 500), "{counts:?}");
        }
    }
}
