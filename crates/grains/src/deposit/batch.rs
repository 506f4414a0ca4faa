//! Many drops at a time, on all threads, with the result of one after another.
//!
//! The drops of a batch are sorted into square regions of the plan, each followed by one thread in
//! the order of their numbers. A drop that needs cells of two regions, or cells that an earlier
//! drop claimed while it waits, waits too (see `snowgrain_accel::StackRegion::claim`). Those that
//! wait are followed on regions shifted by half their edge, and the few that are left one by one.
//! So whenever two drops need one cell they keep their order, and no thread, region or size of
//! batch shows in the grains. Sorting also keeps the stacks that a thread needs in its cache: it
//! pays on one thread as well.

use super::pile::Lying;
use super::roll::Roller;
use super::rules::{Drop, Fate, Start};
use super::{DepositReport, Falling, speculate};
use crate::{GrainsError, Settling};
use rayon::prelude::*;
use snowgrain_accel::{GrainStacks, GrainStacksError, Quad, RegionEdge, RegionLayout, StackRegion};
use snowgrain_geometry::QuantisedGrain;

/// Drops of a batch for each cell that they fall on: few enough that few of them wait.
const DROPS_PER_CELL: f64 = 1.0;
/// Most drops of a batch: progress is told between batches.
const MOST_DROPS: u64 = 1 << 20;
/// Fewer drops are followed one by one.
const FEW_DROPS: usize = 256;
/// Drops that are sorted at a time.
const CHUNK: usize = 1 << 14;
/// Drops by which blocks are asked for ahead of their use.
const AHEAD: usize = 6;

/// Edges of the regions of such stacks: short where there are few cells, so that threads find work.
pub(super) fn region_edge(stacks: &GrainStacks) -> RegionEdge {
    let [columns, rows] = stacks.counts();
    let few = u64::from(columns) * u64::from(rows) < 1 << 16;
    if few { RegionEdge::Short } else { RegionEdge::Long }
}

/// A numbered drop of a batch.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    number: u32,
    pub(super) start: Start,
}

impl Entry {
    #[inline(always)]
    pub(super) fn quad(&self, region: &StackRegion<'_>, reach: f64) -> Quad {
        region.quad(self.start.x.into(), self.start.z.into(), reach)
    }
}

/// A way to follow drops on all of the plan.
type FollowAll = fn(&Drop<'_>, &mut GrainStacks, &[&GrainStacks], &[Entry], &mut Tally);

/// What became of some drops.
#[derive(Default)]
pub(super) struct Tally {
    report: DepositReport,
    /// One more than the number of the last that lies.
    after_success: u32,
    waiting: Vec<Entry>,
    error: Option<(u32, GrainsError)>,
}

impl Tally {
    fn add(&mut self, other: Self) {
        self.report.accepted += other.report.accepted;
        self.report.discarded += other.report.discarded;
        self.report.missed += other.report.missed;
        self.report.unsettled += other.report.unsettled;
        self.after_success = self.after_success.max(other.after_success);
        self.waiting.extend(other.waiting);
        let number = |error: &Option<(u32, GrainsError)>| error.as_ref().map_or(u32::MAX, |e| e.0);
        if number(&other.error) < number(&self.error) {
            self.error = other.error;
        }
    }
}

/// Drops sorted by the regions that they touch.
struct Sorted {
    entries: Vec<Entry>,
    /// Where the entries of each region end.
    ends: Vec<u32>,
}

impl Sorted {
    /// In the order of `entries` within each region.
    fn new(layout: &RegionLayout, reach: f64, entries: impl Iterator<Item = Entry>) -> Self {
        let mut ends = vec![0u32; layout.len()];
        let mut touching: Vec<(u32, Entry)> = Vec::with_capacity(CHUNK + CHUNK / 4);
        let mut buffer = Vec::new();
        for entry in entries {
            let line = [entry.start.x.into(), entry.start.z.into(), reach];
            layout.each_touched(line, &mut buffer, |region| {
                ends[region as usize] += 1;
                touching.push((region, entry));
            });
        }
        let mut next = 0;
        for end in &mut ends {
            (*end, next) = (next, next + *end);
        }
        let Some(&(_, any)) = touching.first() else { return Self { entries: Vec::new(), ends } };
        let mut entries = vec![any; touching.len()];
        for (region, entry) in touching {
            let at = &mut ends[region as usize];
            entries[*at as usize] = entry;
            *at += 1;
        }
        Self { entries, ends }
    }

    fn of_region(&self, region: usize) -> &[Entry] {
        let from = if region == 0 { 0 } else { self.ends[region - 1] };
        &self.entries[from as usize..self.ends[region] as usize]
    }
}

impl Falling<'_> {
    /// Follows up to `most` drops; as many grains lie afterwards as in any other division.
    pub(super) fn batch(&mut self, most: u64) -> Result<(), GrainsError> {
        if let Settling::Aggregates { grains } = self.drop.settling {
            return self.batch_of_aggregates(grains, most);
        }
        let layout = self.stacks.layout(self.edge, false);
        let drops = most.min(self.batch_size(&layout));
        let first = self.drops;
        let drop = &self.drop;
        let entry =
            |number: u64| Entry { number: number as u32, start: drop.start(first + number) };
        let follow_all: Option<FollowAll> =
            if self.sequential || layout.len() < 2 || (drops as usize) < FEW_DROPS {
                Some(one_by_one)
            } else if !drop.is_local() {
                let alone = rayon::current_num_threads() == 1;
                Some(if alone { one_by_one } else { speculate::follow_all })
            } else {
                None
            };
        let mut tally = if let Some(follow_all) = follow_all {
            let mut tally = Tally::default();
            let entries: Vec<Entry> = (0..drops).map(entry).collect();
            follow_all(drop, self.stacks, &self.others, &entries, &mut tally);
            tally
        } else {
            let chunks: Vec<u64> = (0..drops).step_by(CHUNK).collect();
            let reach = drop.reach(self.stacks);
            let sorted: Vec<Sorted> = chunks
                .into_par_iter()
                .map(|from| {
                    let until = (from + CHUNK as u64).min(drops);
                    Sorted::new(&layout, reach, (from..until).map(entry))
                })
                .collect();
            let mut tally = in_regions(drop, self.stacks, &self.others, &layout, &sorted);
            self.follow_waiting(&mut tally);
            tally
        };
        let since = &mut self.drops_since_success;
        *since = if tally.after_success > 0 {
            drops - u64::from(tally.after_success)
        } else {
            *since + drops
        };
        self.drops += drops;
        self.report.accepted += tally.report.accepted;
        self.report.discarded += tally.report.discarded;
        self.report.missed += tally.report.missed;
        self.report.unsettled += tally.report.unsettled;
        tally.error.take().map_or(Ok(()), |(_, error)| Err(error))
    }

    fn batch_size(&self, layout: &RegionLayout) -> u64 {
        if layout.len() < 2 {
            return CHUNK as u64;
        }
        let cells = self.drop.area_in_cells(self.stacks.side());
        ((cells * DROPS_PER_CELL) as u64).clamp(FEW_DROPS as u64, MOST_DROPS)
    }

    /// Follows those that wait, first on shifted regions.
    fn follow_waiting(&mut self, tally: &mut Tally) {
        let drop = &self.drop;
        let mut waiting = std::mem::take(&mut tally.waiting);
        waiting.sort_unstable_by_key(|entry| entry.number);
        if waiting.len() >= FEW_DROPS {
            let layout = self.stacks.layout(self.edge, true);
            let reach = drop.reach(self.stacks);
            let sorted: Vec<Sorted> = waiting
                .par_chunks(CHUNK)
                .map(|entries| Sorted::new(&layout, reach, entries.iter().copied()))
                .collect();
            tally.add(in_regions(drop, self.stacks, &self.others, &layout, &sorted));
            waiting = std::mem::take(&mut tally.waiting);
            waiting.sort_unstable_by_key(|entry| entry.number);
        }
        one_by_one(drop, self.stacks, &self.others, &waiting, tally);
    }
}

/// Follows the drops of every region, regions side by side.
fn in_regions(
    drop: &Drop<'_>,
    stacks: &mut GrainStacks,
    others: &[&GrainStacks],
    layout: &RegionLayout,
    sorted: &[Sorted],
) -> Tally {
    let reach = drop.reach(stacks);
    let mut sum = Tally::default();
    let tallies: Vec<Tally> = stacks
        .regions(layout)
        .into_par_iter()
        .enumerate()
        .map(|(index, mut region)| {
            let mut entries: Vec<Entry> = Vec::new();
            sorted.iter().for_each(|part| entries.extend_from_slice(part.of_region(index)));
            let mut tally = Tally::default();
            let mut roller = Roller::new(drop);
            let mut ahead = Ahead::new(&region, &entries, reach);
            for entry in &entries {
                let quad = ahead.next(&region, &entries);
                let (x, z) = (f64::from(entry.start.x), f64::from(entry.start.z));
                if region.claim(&quad) {
                    let fate = drop.fall(
                        &Lying { region: &region, others },
                        &mut roller,
                        entry.start,
                        &quad,
                    );
                    commit(&mut region, entry, fate, &mut tally);
                } else if layout.home(x, z) == Some(index) {
                    tally.waiting.push(*entry);
                }
            }
            tally
        })
        .collect();
    tallies.into_iter().for_each(|tally| sum.add(tally));
    sum
}

/// Looks up the cells of drops some time before they fall, and asks for the memory they will need.
pub(super) struct Ahead {
    quads: [Quad; AHEAD],
    at: usize,
    reach: f64,
}

impl Ahead {
    /// Before the first of `entries`, which are not none.
    pub(super) fn new(region: &StackRegion<'_>, entries: &[Entry], reach: f64) -> Self {
        let quads = std::array::from_fn(|at| match entries.get(at) {
            Some(entry) => entry.quad(region, reach),
            None => region.quad(0.0, 0.0, reach),
        });
        quads.iter().for_each(|quad| region.prefetch(quad));
        Self { quads, at: 0, reach }
    }

    /// The cells of the next of `entries`.
    #[inline(always)]
    pub(super) fn next(&mut self, region: &StackRegion<'_>, entries: &[Entry]) -> Quad {
        let slot = self.at % AHEAD;
        let quad = self.quads[slot];
        if let Some(entry) = entries.get(self.at + AHEAD) {
            self.quads[slot] = entry.quad(region, self.reach);
            region.prefetch(&self.quads[slot]);
        }
        self.at += 1;
        quad
    }
}

/// Follows drops in their order on all of the plan, which grows where they leave it.
fn one_by_one(
    drop: &Drop<'_>,
    stacks: &mut GrainStacks,
    others: &[&GrainStacks],
    entries: &[Entry],
    tally: &mut Tally,
) {
    let reach = drop.reach(stacks);
    let mut roller = Roller::new(drop);
    let mut at = 0;
    while at < entries.len() {
        let mut region = stacks.whole();
        let mut outside = None;
        let start = at;
        let mut ahead = Ahead::new(&region, &entries[start..], reach);
        while at < entries.len() && outside.is_none() {
            let quad = ahead.next(&region, &entries[start..]);
            let lying = Lying { region: &region, others };
            let fate = drop.fall(&lying, &mut roller, entries[at].start, &quad);
            outside = commit(&mut region, &entries[at], fate, tally);
            at += 1;
        }
        if let Some(grain) = outside {
            store_outside(stacks, grain, &entries[at - 1], tally);
        }
    }
}

/// Stores a grain that rolled out of the plan: the plan grows by as much again.
pub(super) fn store_outside(
    stacks: &mut GrainStacks,
    grain: QuantisedGrain,
    entry: &Entry,
    tally: &mut Tally,
) {
    let grown = stacks.cover_grain(grain, 32 * i32::from(grain.radius.max(1)));
    if let Err(error) = grown.and_then(|()| stacks.push(grain)) {
        tally.add(Tally { error: Some((entry.number, error.into())), ..Tally::default() });
    }
}

/// Lets a drop come to its end; gives its grain back where it lies off the plan.
#[inline]
pub(super) fn commit(
    region: &mut StackRegion<'_>,
    entry: &Entry,
    fate: Result<Fate, GrainsError>,
    tally: &mut Tally,
) -> Option<QuantisedGrain> {
    let fail = |error| Tally { error: Some((entry.number, error)), ..Tally::default() };
    let grain = match fate {
        Ok(Fate::Rests(grain)) => grain,
        Ok(Fate::Unsettled(grain)) => {
            tally.report.unsettled += 1;
            grain
        }
        Ok(Fate::TooSteep) => {
            tally.report.discarded += 1;
            return None;
        }
        Ok(Fate::Missed) => {
            tally.report.missed += 1;
            return None;
        }
        Err(error) => {
            tally.add(fail(error));
            return None;
        }
    };
    tally.report.accepted += 1;
    tally.after_success = tally.after_success.max(entry.number + 1);
    match region.push(grain) {
        Ok(_) => None,
        Err(GrainStacksError::OutsideArea) => Some(grain),
        Err(error) => {
            tally.add(fail(error.into()));
            None
        }
    }
}
