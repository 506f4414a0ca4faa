//! Light in a perfect lattice: as many paths at once as the SIMD level has lanes, no memory.
//!
//! A round takes every path across one face of the Voronoi cell that it is in, and through the whole
//! visit to the grain of the next cell if it meets it. A path therefore never tests a grain that it
//! cannot meet: the one that it leaves is behind it, and no other reaches into the cell.

mod round;

use super::random::{prepared, unprepared};
use super::sphere::Ice;
use super::{FirstGrain, FlightEvent, Travelled};
use crate::grain_grid::{GridPosition, LatticeSites};
use fearless_simd::{Level, dispatch};
use snowgrain_math::DVec3;
use snowgrain_math::sampler::PathKey;

/// Paths of one group, which are loaded together.
const GROUP: usize = 16;
/// Groups in flight.
const GROUPS: usize = 4;

/// "Yes" of a lane of a mask; "no" is 0.
const YES: i32 = -1;

/// Sixteen paths. Lengths in quanta, positions relative to the site of the path's cell.
#[derive(Clone, Debug, Default)]
#[repr(C, align(64))]
struct Group {
    position: [[f32; GROUP]; 3],
    direction: [[f32; GROUP]; 3],
    /// Site coordinates, whole numbers.
    site: [[f32; GROUP]; 3],
    /// Cosine, in air, of the angle at which the present grain was met.
    cos_outside: [f32; GROUP],
    ice_length: [f32; GROUP],
    air_length: [f32; GROUP],
    /// Key and next event as the hash wants them (`random`).
    key: [[u32; GROUP]; 2],
    event: [u32; GROUP],
    visits: [u32; GROUP],
    /// Whether there is a path.
    flies: [i32; GROUP],
    /// Whether the path is done with the grain of its cell.
    crosses: [i32; GROUP],
    /// Whether the path is inside that grain.
    inside: [i32; GROUP],
}

/// The first grains that the paths of a group met; written once a path.
#[derive(Clone, Debug, Default)]
#[repr(C, align(64))]
struct FirstGrains {
    normal: [[f32; GROUP]; 3],
    site: [[f32; GROUP]; 3],
}

/// Paths in flight in one crystal.
#[derive(Debug)]
pub(super) struct CrystalFlight<'a> {
    sites: &'a LatticeSites,
    ice: Ice,
    groups: Box<[Group; GROUPS]>,
    first: Box<[FirstGrains; GROUPS]>,
    in_use: usize,
}

impl<'a> CrystalFlight<'a> {
    pub(super) fn new(sites: &'a LatticeSites, eta: f64) -> Self {
        Self {
            sites,
            ice: Ice::new(eta),
            groups: Box::default(),
            first: Box::default(),
            in_use: GROUP * GROUPS,
        }
    }

    pub(super) fn launch(&mut self, lane: usize, key: PathKey, event: u32) {
        let (group, at) = self.lane_mut(lane);
        group.key[0][at] = prepared(key.lo);
        group.key[1][at] = prepared(key.hi);
        group.event[at] = prepared(event);
        group.ice_length[at] = 0.0;
        group.air_length[at] = 0.0;
        group.visits[at] = 0;
        group.flies[at] = 0;
    }

    pub(super) fn enter(&mut self, lane: usize, place: GridPosition, direction: DVec3) {
        let (group, at) = self.lane_mut(lane);
        for axis in 0..3 {
            group.position[axis][at] = place.local[axis];
            group.site[axis][at] = place.cell[axis] as f32;
            group.direction[axis][at] = direction[axis] as f32;
        }
        group.flies[at] = YES;
        group.crosses[at] = 0;
        group.inside[at] = 0;
    }

    pub(super) fn set_event(&mut self, lane: usize, event: u32) {
        let (group, at) = self.lane_mut(lane);
        group.event[at] = prepared(event);
    }

    pub(super) fn retire(&mut self, lane: usize) {
        let (group, at) = self.lane_mut(lane);
        group.flies[at] = 0;
    }

    pub(super) fn relocate(&mut self, from: usize, to: usize) {
        let (source, first) = (self.groups[from / GROUP].clone(), self.first[from / GROUP].clone());
        let i = from % GROUP;
        let (group, j) = self.lane_mut(to);
        for axis in 0..3 {
            group.position[axis][j] = source.position[axis][i];
            group.direction[axis][j] = source.direction[axis][i];
            group.site[axis][j] = source.site[axis][i];
        }
        group.ice_length[j] = source.ice_length[i];
        group.air_length[j] = source.air_length[i];
        group.key[0][j] = source.key[0][i];
        group.key[1][j] = source.key[1][i];
        group.event[j] = source.event[i];
        group.visits[j] = source.visits[i];
        group.flies[j] = source.flies[i];
        group.crosses[j] = source.crosses[i];
        group.inside[j] = source.inside[i];
        group.cos_outside[j] = source.cos_outside[i];
        let target = &mut self.first[to / GROUP];
        for axis in 0..3 {
            target.normal[axis][j] = first.normal[axis][i];
            target.site[axis][j] = first.site[axis][i];
        }
        self.retire(from);
    }

    pub(super) fn use_lanes(&mut self, lanes: usize) {
        self.in_use = lanes.min(GROUP * GROUPS);
    }

    /// Lets all paths travel until at least one has left the crystal.
    pub(super) fn advance(&mut self, level: Level, events: &mut Vec<(usize, FlightEvent)>) {
        dispatch!(level, simd => round::run(simd, self, events));
    }

    pub(super) fn place(&self, lane: usize) -> GridPosition {
        let (group, at) = self.lane(lane);
        GridPosition {
            cell: group.site.map(|site| site[at] as i32),
            local: group.position.map(|position| position[at]),
        }
    }

    /// How far the place of the path of `lane` is from that in the first period, quanta.
    pub(super) fn beyond_first_period(&self, lane: usize) -> DVec3 {
        self.sites.beyond_first_period(self.place(lane).cell)
    }

    pub(super) fn direction(&self, lane: usize) -> [f32; 3] {
        let (group, at) = self.lane(lane);
        group.direction.map(|direction| direction[at])
    }

    pub(super) fn travelled(&self, lane: usize, quantum: f64) -> Travelled {
        let (group, at) = self.lane(lane);
        Travelled {
            ice_length: f64::from(group.ice_length[at]) * quantum,
            air_length: f64::from(group.air_length[at]) * quantum,
            grain_visits: group.visits[at],
            event: unprepared(group.event[at]),
        }
    }

    /// The first grain met, if one was.
    pub(super) fn first_grain(
        &self,
        lane: usize,
        world: impl Fn(GridPosition) -> DVec3,
    ) -> Option<FirstGrain> {
        let (group, at) = self.lane(lane);
        (group.visits[at] > 0).then(|| {
            let first = &self.first[lane / GROUP];
            let normal = first.normal.map(|normal| normal[at]);
            let place = GridPosition {
                cell: first.site.map(|site| site[at] as i32),
                local: normal.map(|n| n * self.sites.radius),
            };
            FirstGrain {
                position: world(place),
                normal: DVec3::from_array(normal.map(f64::from)).normalize(),
            }
        })
    }

    fn lane(&self, lane: usize) -> (&Group, usize) {
        (&self.groups[lane / GROUP], lane % GROUP)
    }

    fn lane_mut(&mut self, lane: usize) -> (&mut Group, usize) {
        (&mut self.groups[lane / GROUP], lane % GROUP)
    }
}
