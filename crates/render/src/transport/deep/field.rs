//! The field of outcomes: coarse cells, and what paths bring from each.

use super::DeepSettings;
use super::learn::Sums;
use super::outcome::Outcome;
use crate::light::Lights;
use crate::transport::Contribution;
use crate::world::World;
use rustc_hash::{FxHashMap, FxHashSet};
use snowgrain_accel::{ArrivalFrom, GrainVisit, Interior};
use snowgrain_math::DVec3;

/// Transport length over the mean distance between grains along a straight line, 1 / (1 - g_eff), for spheres of ice (11.6 mm
/// at 275 kg/m^3 and r = .5 mm).
pub(in super::super) const TRANSPORT_LENGTH: f64 = 5.2;

/// How far ahead of an arrival what it brings is booked, in the same mean distances: a transport length less
/// about one, since the next grain is met at once. By it the error after four grains at half a transport length is least: 0 %,
/// against -.5 % at 4.7, -.9 % at 5.2 and +.1 % at 3.9 (overcast sky on 10 cm of snow of 275 kg/m^3).
const AHEAD: f64 = 4.05;

/// Arrivals from which a cell counts as learnt.
const FEWEST: u64 = 16;

/// A coarse cell of the field.
pub(super) type Cell = [i32; 3];

/// What paths bring from each place deep in the snow on. See the module's page.
#[derive(Clone, Debug)]
pub struct OutcomeField {
    pub(super) interior: Interior,
    pub(super) after_grains: u32,
    /// How far ahead of an arrival it counts, in coarse cells along each axis.
    ahead: DVec3,
    /// Unit of lengths in ice, metres.
    pub(super) unit: f64,
    pub(super) slots: usize,
    pub(super) has_strata: bool,
    pub(super) lights: Lights,
    /// Number of each learnt cell, and the outcomes of its slots.
    numbers: FxHashMap<Cell, u32>,
    outcomes: Vec<Outcome>,
}

impl OutcomeField {
    /// Nothing is learnt yet; `None` where no snow is deep.
    pub(super) fn unlearnt(
        world: &World,
        lights: &Lights,
        settings: &DeepSettings,
    ) -> Option<Self> {
        let extinction = world.grid.extinction();
        if extinction <= 0.0 {
            return None;
        }
        let unit = TRANSPORT_LENGTH / extinction;
        let rings = (settings.depth / settings.cell).ceil() as u32;
        let interior = world.grid.interior(settings.cell * unit, rings);
        let any = interior.deep_cells().next().is_some();
        any.then(|| Self {
            ahead: DVec3::splat(AHEAD / extinction) / interior.edges(),
            interior,
            after_grains: settings.after_grains,
            unit,
            slots: lights.slots().len(),
            has_strata: world.grid.has_strata(),
            lights: lights.clone(),
            numbers: FxHashMap::default(),
            outcomes: Vec::new(),
        })
    }

    /// The same with what paths brought: where too few arrived, no snow counts as deep.
    pub(super) fn learnt(mut self, sums: &Sums) -> Self {
        self.interior.retain(|cell| sums.arrivals(cell) >= FEWEST);
        let mut outcomes = sums.smoothed(FEWEST);
        fill(&mut outcomes, needed(&self.interior, self.ahead), self.slots);
        let mut cells: Vec<_> = outcomes.into_iter().collect();
        cells.sort_unstable_by_key(|&(cell, _)| cell);
        self.numbers = cells.iter().zip(0..).map(|(&(cell, _), number)| (cell, number)).collect();
        self.outcomes = cells.into_iter().flat_map(|(_, outcomes)| outcomes).collect();
        self
    }

    /// Whether an arrival is deep in the snow.
    pub(super) fn is_deep(&self, visit: &GrainVisit) -> bool {
        visit.from == ArrivalFrom::Air
            && visit.grain_visits > self.after_grains
            && self.interior.is_deep(visit.center.cell)
    }

    /// Where an arrival counts, in coarse cells.
    pub(super) fn place(&self, visit: &GrainVisit) -> DVec3 {
        let direction = DVec3::from_array(visit.direction.map(f64::from));
        self.interior.coordinates(visit.center) + direction * self.ahead
    }

    /// What a path of this throughput that ends at an arrival deep in the snow brings.
    pub(crate) fn outcome(
        &self,
        visit: &GrainVisit,
        throughput: [f32; 3],
        quantum: f64,
        found: &mut Vec<Contribution>,
    ) {
        let corner = self.place(visit) - DVec3::splat(0.5);
        let (low, part) = (corner.floor(), corner - corner.floor());
        let mut around = [(0, 0.0); 8];
        for (index, (number, weight)) in around.iter_mut().enumerate() {
            let upper = [0, 1, 2].map(|axis: usize| index >> axis & 1 == 1);
            let cell: Cell = std::array::from_fn(|axis| low[axis] as i32 + i32::from(upper[axis]));
            let along = |axis: usize| if upper[axis] { part[axis] } else { 1.0 - part[axis] };
            *number = self.numbers[&cell] as usize;
            *weight = along(0) * along(1) * along(2);
        }
        let length = f64::from(visit.ice_length) * quantum;
        let in_strata = visit.ice_in_strata.map(|length| f64::from(length) * quantum);
        for slot in 0..self.slots {
            let mut outcome = Outcome::default();
            for (number, weight) in around {
                outcome.add(&self.outcomes[number * self.slots + slot], weight as f32);
            }
            let about = (slot, visit.event, self.unit);
            found.extend(outcome.contributions(about, throughput, (length, in_strata)));
        }
    }

    /// Number of cells that are learnt.
    #[must_use]
    pub fn cells(&self) -> usize {
        self.numbers.len()
    }

    /// Memory, bytes.
    #[must_use]
    pub fn memory_bytes(&self) -> u64 {
        let numbers = self.numbers.capacity() * (size_of::<Cell>() + size_of::<u32>() + 1);
        (numbers + size_of_val(self.outcomes.as_slice())) as u64 + self.interior.memory_bytes()
    }
}

/// All cells that places of arrivals in deep cells have around them.
fn needed(interior: &Interior, ahead: DVec3) -> Vec<Cell> {
    // From a corner of the cell, and to the farther of the two cells whose middles are on either side.
    let farthest = ahead + interior.overhang() + DVec3::splat(0.5);
    let reach = farthest.to_array().map(|cells| cells.ceil() as i32 + 1);
    let mut needed = FxHashSet::default();
    for cell in interior.deep_cells() {
        for z in -reach[2]..=reach[2] {
            for y in -reach[1]..=reach[1] {
                for x in -reach[0]..=reach[0] {
                    needed.insert([cell[0] + x, cell[1] + y, cell[2] + z]);
                }
            }
        }
    }
    let mut needed: Vec<_> = needed.into_iter().collect();
    needed.sort_unstable();
    needed
}

/// Gives each needed cell of which nothing is known the mean of its neighbours that are, ring by ring.
fn fill(known: &mut FxHashMap<Cell, Vec<Outcome>>, needed: Vec<Cell>, slots: usize) {
    let mut missing: Vec<_> = needed.into_iter().filter(|cell| !known.contains_key(cell)).collect();
    while !missing.is_empty() {
        let before = missing.len();
        let mut found = Vec::new();
        missing.retain(|&cell| {
            let mut sum = vec![Outcome::default(); slots];
            let mut count = 0.0;
            for neighbour in neighbours(cell) {
                let Some(theirs) = known.get(&neighbour) else { continue };
                sum.iter_mut().zip(theirs).for_each(|(sum, theirs)| sum.add(theirs, 1.0));
                count += 1.0;
            }
            if count == 0.0 {
                return true;
            }
            let mut mean = vec![Outcome::default(); slots];
            mean.iter_mut().zip(&sum).for_each(|(mean, sum)| mean.add(sum, 1.0 / count));
            found.push((cell, mean));
            false
        });
        known.extend(found);
        if missing.len() == before {
            // Nothing at all is known.
            known.extend(missing.drain(..).map(|cell| (cell, vec![Outcome::default(); slots])));
        }
    }
}

/// A cell and all that touch it.
pub(super) fn neighbours(cell: Cell) -> impl Iterator<Item = Cell> {
    (0..27).map(move |index| {
        [cell[0] + index % 3 - 1, cell[1] + index / 3 % 3 - 1, cell[2] + index / 9 - 1]
    })
}
