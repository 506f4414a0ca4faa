//! Rolling grains on all threads, with the result of one after another.
//!
//! A grain that rolls may end anywhere, so no thread can own the cells that it will need. Instead a
//! batch of drops is followed side by side on what lay before it, each with a record of where it
//! looked. Then the drops are taken in their order: one that looked nowhere where an earlier drop of
//! the batch came to rest found what it would have found in its turn; any other is followed again.

use super::batch::{Ahead, Entry, Tally, commit, store_outside};
use super::looks::{Look, Rest, Space};
use super::pile::Lying;
use super::roll::Roller;
use super::rules::{Drop, Fate};
use crate::GrainsError;
use rayon::prelude::*;
use snowgrain_accel::GrainStacks;
use snowgrain_geometry::QuantisedGrain;

/// Cells of the area for each drop of a batch: about one in ten drops is then followed again.
const CELLS_PER_DROP: f64 = 16.0;
/// Fewest and most drops of a batch.
const DROPS: [usize; 2] = [32, 4096];
/// Drops that a thread follows at a time.
const SHARE: usize = 32;

/// Follows `entries` in batches.
pub(super) fn follow_all(
    drop: &Drop<'_>,
    stacks: &mut GrainStacks,
    others: &[&GrainStacks],
    entries: &[Entry],
    tally: &mut Tally,
) {
    let cells = drop.area_in_cells(stacks.side());
    let size = ((cells / CELLS_PER_DROP) as usize).clamp(DROPS[0], DROPS[1]);
    for entries in entries.chunks(size) {
        let space = Space::of(stacks);
        let tries = try_all(drop, stacks, others, entries);
        let doubts = doubts(&space, &tries);
        settle_in_order(drop, stacks, others, (entries, tries, doubts), tally);
    }
}

/// What became of a drop, as long as it overlooked nothing.
struct Try {
    fate: Result<Fate, GrainsError>,
    looks: Vec<Look>,
}

impl Try {
    fn grain(&self) -> Option<QuantisedGrain> {
        match self.fate {
            Ok(Fate::Rests(grain) | Fate::Unsettled(grain)) => Some(grain),
            Ok(Fate::TooSteep | Fate::Missed) | Err(_) => None,
        }
    }
}

fn try_all(
    drop: &Drop<'_>,
    stacks: &mut GrainStacks,
    others: &[&GrainStacks],
    entries: &[Entry],
) -> Vec<Try> {
    let reach = drop.reach(stacks);
    let region = &stacks.whole();
    let lying = Lying { region, others };
    let share = |entries: &[Entry]| {
        let mut roller = Roller::new(drop);
        let mut ahead = Ahead::new(region, entries, reach);
        let each = |entry: &Entry| {
            let quad = ahead.next(region, entries);
            let fate = drop.fall(&lying, &mut roller, entry.start, &quad);
            Try { fate, looks: roller.take_looks() }
        };
        entries.iter().map(each).collect::<Vec<Try>>()
    };
    entries.par_chunks(SHARE).flat_map_iter(share).collect()
}

/// Whether each drop looked where an earlier one came to rest.
fn doubts(space: &Space, tries: &[Try]) -> Vec<bool> {
    let resting = tries.iter().enumerate();
    let mut rests: Vec<(usize, Rest)> =
        resting.filter_map(|(drop, tried)| Some((drop, space.rest(tried.grain()?)))).collect();
    rests.sort_unstable_by(|(_, a), (_, b)| a.place[0].total_cmp(&b.place[0]));
    let doubt = |(drop, tried): (usize, &Try)| {
        let shadow = space.shadow_of(&tried.looks);
        space.images_along_x([shadow.low[0], shadow.high[0]]).any(|[low, high]| {
            let from = rests.partition_point(|(_, rest)| rest.place[0] < low);
            let near = rests[from..].iter().take_while(|(_, rest)| rest.place[0] <= high);
            near.filter(|(earlier, _)| *earlier < drop)
                .any(|(_, rest)| space.is_seen(&shadow, &tried.looks, rest))
        })
    };
    tries.par_iter().enumerate().with_min_len(SHARE).map(doubt).collect()
}

/// Lets the drops come to rest one after another; those in doubt are followed again.
fn settle_in_order(
    drop: &Drop<'_>,
    stacks: &mut GrainStacks,
    others: &[&GrainStacks],
    (entries, tries, doubts): (&[Entry], Vec<Try>, Vec<bool>),
    tally: &mut Tally,
) {
    let space = Space::of(stacks);
    let mut roller = Roller::new(drop);
    // Grains that came to rest elsewhere than at the first try.
    let mut moved: Vec<Rest> = Vec::new();
    let reach = drop.reach(stacks);
    let mut region = stacks.whole();
    for ((entry, tried), doubt) in entries.iter().zip(tries).zip(doubts) {
        let sees_moved = || {
            let shadow = space.shadow_of(&tried.looks);
            moved.iter().any(|rest| space.is_seen(&shadow, &tried.looks, rest))
        };
        let outside = if doubt || sees_moved() {
            let quad = entry.quad(&region, reach);
            let again =
                drop.fall(&Lying { region: &region, others }, &mut roller, entry.start, &quad);
            let again = Try { fate: again, looks: Vec::new() };
            if again.grain() != tried.grain() {
                moved.extend(again.grain().map(|grain| space.rest(grain)));
            }
            commit(&mut region, entry, again.fate, tally)
        } else {
            commit(&mut region, entry, tried.fate, tally)
        };
        if let Some(grain) = outside {
            std::mem::drop(region);
            store_outside(stacks, grain, entry, tally);
            region = stacks.whole();
        }
    }
}
