//! Which samples are rendered next: passes over all tiles, dealt out as tasks.
//!
//! A pass is what a stopped render can keep; a task is what a thread takes at once. The size of passes
//! follows the clock, which only groups samples: no pixel depends on it.

use std::collections::VecDeque;
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::{Duration, Instant};

/// Wanted duration of a pass once the picture has begun: half of it is what a stop loses on average.
const PASS: Duration = Duration::from_secs(1);
/// Samples in a task: long enough that taking it costs nothing, short enough that threads end
/// together (5 to 50 ms).
const TASK_SAMPLES: u64 = 2048;
/// Most tasks in a pass, so that their numbers and those of passes share a word.
const MOST_TASKS: u64 = 1 << 31;

/// Some samples of every pixel whose tile wants them.
pub(super) struct Pass {
    /// Number of the pass, from 0.
    pub(super) index: u64,
    samples: Range<u64>,
    /// Tiles that want any: the first ones of [`Passes::tiles`].
    tiles: u64,
    /// Samples of each pixel in one task.
    task_samples: u64,
    /// Of each band of wavelengths; those of a band follow one another.
    tasks: u64,
    bands: u64,
    unfinished: AtomicU64,
}

/// What to render of a tile.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Part {
    /// Of the first pass, one pixel in sixteen, so that there is an early picture.
    Coarse(Range<u64>),
    /// Of the first pass, the other pixels.
    Rest(Range<u64>),
    /// These samples of all pixels.
    Whole(Range<u64>),
}

impl Part {
    pub(super) fn samples(&self) -> &Range<u64> {
        match self {
            Self::Coarse(samples) | Self::Rest(samples) | Self::Whole(samples) => samples,
        }
    }
}

/// A part of a pass over one tile.
pub(super) struct Task {
    pub(super) pass: Arc<Pass>,
    pub(super) tile: usize,
    pub(super) part: Part,
    /// Band of wavelengths, 0 where light is not parted.
    pub(super) band: usize,
}

/// A tile, and the sample after the last that it wants.
#[derive(Clone, Copy)]
struct Wanting {
    tile: usize,
    end: u64,
}

/// All passes.
pub(super) struct Passes {
    samples: Range<u64>,
    /// Those that want most come first.
    tiles: Vec<Wanting>,
    tile_pixels: u64,
    /// Bands of wavelengths that light is parted into, at least 1.
    bands: u64,
    /// The next task: number of the pass in the upper half, of the task in the lower one, which runs
    /// past the number of tasks until another pass is opened. The one word that all threads write,
    /// once a task.
    next: Counter,
    state: Mutex<State>,
    /// Number of passes that are complete, with all before them.
    complete: Counter,
}

/// A counter on cache lines of its own.
#[repr(align(128))]
#[derive(Default)]
struct Counter(AtomicU64);

struct State {
    /// Passes that are not complete, or have one before them that is not.
    open: VecDeque<Arc<Pass>>,
    /// Passes that were opened, and when the last was.
    opened: u64,
    last_opened: Option<Instant>,
    /// First sample that is in no pass.
    next_sample: u64,
    /// Samples of each pixel in the next pass.
    pass_samples: u64,
    /// Sample after the last of those that are complete.
    complete_to: u64,
}

impl Passes {
    /// Passes over `samples` of tiles of at most `tile_pixels` pixels, each of which wants those below
    /// its own `end`; each task is of one of so many bands of wavelengths.
    pub(super) fn new(
        samples: Range<u64>,
        ends: impl Iterator<Item = u64>,
        (tile_pixels, bands): (u64, usize),
    ) -> Self {
        let mut tiles: Vec<_> = ends
            .enumerate()
            .map(|(tile, end)| Wanting { tile, end: end.min(samples.end) })
            .collect();
        // Stable, so that neighbours stay together.
        tiles.sort_by_key(|wanting| std::cmp::Reverse(wanting.end));
        let end = tiles.first().map_or(samples.start, |most| most.end.max(samples.start));
        let samples = samples.start..end;
        let state = State {
            open: VecDeque::new(),
            opened: 0,
            last_opened: None,
            next_sample: samples.start,
            pass_samples: 1,
            complete_to: samples.start,
        };
        let passes = Self {
            samples,
            tiles,
            tile_pixels,
            bands: bands as u64,
            next: Counter::default(),
            state: Mutex::new(state),
            complete: Counter::default(),
        };
        passes.open(&mut passes.lock());
        passes
    }

    /// The next task; `pass` is the one of the caller's last task. `None` when there are no more.
    pub(super) fn take(&self, pass: &mut Option<Arc<Pass>>) -> Option<Task> {
        loop {
            let ticket = self.next.0.fetch_add(1, Ordering::Relaxed);
            let (index, number) = (ticket >> 32, ticket & u64::from(u32::MAX));
            if pass.as_ref().is_none_or(|pass| pass.index != index) {
                let state = self.lock();
                *pass = state.open.iter().find(|pass| pass.index == index).cloned();
            }
            // A pass that is gone has no task left, whatever the ticket says.
            if let Some(pass) = pass.as_ref().filter(|pass| number < pass.tasks * pass.bands) {
                return Some(self.task(pass, number));
            }
            let mut state = self.lock();
            if state.opened <= index + 1 && !self.open(&mut state) {
                return None;
            }
        }
    }

    fn task(&self, pass: &Arc<Pass>, number: u64) -> Task {
        let (band, number) = (number / pass.tasks, number % pass.tasks);
        let (part, place) = (number / pass.tiles, number % pass.tiles);
        let Wanting { tile, end } = self.tiles[place as usize];
        let wanted = |samples: Range<u64>| samples.start..samples.end.min(end).max(samples.start);
        let part = match (pass.index, part) {
            (0, 0) => Part::Coarse(wanted(pass.samples.clone())),
            (0, _) => Part::Rest(wanted(pass.samples.clone())),
            _ => {
                let start = pass.samples.start + part * pass.task_samples;
                Part::Whole(wanted(start..pass.samples.end.min(start + pass.task_samples)))
            }
        };
        Task { pass: Arc::clone(pass), tile, part, band: band as usize }
    }

    /// Opens another pass, if there are samples left.
    fn open(&self, state: &mut State) -> bool {
        if let Some(took) = state.last_opened.map(|last| last.elapsed()) {
            // While a path of an earlier pass is still under way each tile keeps sums for every pass since: few, large ones.
            if took * 2 < PASS || state.open.len() > 1 {
                state.pass_samples = state.pass_samples.saturating_mul(2);
            } else if took > PASS * 2 {
                state.pass_samples = (state.pass_samples / 2).max(1);
            }
        }
        let start = state.next_sample;
        let end = self.samples.end.min(start.saturating_add(state.pass_samples));
        let tiles = self.tiles.partition_point(|wanting| wanting.end > start) as u64;
        if start >= end || tiles == 0 {
            return false;
        }
        let count = end - start;
        let fewest = (u128::from(count) * u128::from(tiles) * u128::from(self.bands))
            .div_ceil(u128::from(MOST_TASKS));
        let task_samples = (TASK_SAMPLES * self.bands / self.tile_pixels.max(1))
            .max(1)
            .max(u64::try_from(fewest).unwrap_or(count));
        let parts = if state.opened == 0 { 2 } else { count.div_ceil(task_samples) };
        let tasks = parts * tiles;
        state.open.push_back(Arc::new(Pass {
            index: state.opened,
            samples: start..end,
            tiles,
            task_samples,
            tasks,
            bands: self.bands,
            unfinished: AtomicU64::new(tasks * self.bands),
        }));
        state.last_opened = Some(Instant::now());
        self.next.0.store(state.opened << 32, Ordering::Relaxed);
        state.opened += 1;
        state.next_sample = end;
        true
    }

    /// To be told when all samples of a task are in their tile; gives the samples that every pixel
    /// has, or all that its tile wants, where that completes passes.
    pub(super) fn done(&self, pass: &Pass) -> Option<u64> {
        if pass.unfinished.fetch_sub(1, Ordering::AcqRel) > 1 {
            return None;
        }
        let mut state = self.lock();
        let before = state.complete_to;
        while let Some(first) = state.open.front() {
            if first.unfinished.load(Ordering::Acquire) > 0 {
                break;
            }
            self.complete.0.store(first.index + 1, Ordering::Release);
            state.complete_to = first.samples.end;
            state.open.pop_front();
        }
        (state.complete_to > before).then(|| state.complete_to - self.samples.start)
    }

    /// Number of passes that are complete, with all before them.
    pub(super) fn complete(&self) -> u64 {
        self.complete.0.load(Ordering::Acquire)
    }

    /// The same, and their samples.
    pub(super) fn complete_with_samples(&self) -> (u64, Range<u64>) {
        let state = self.lock();
        (self.complete(), self.samples.start..state.complete_to)
    }

    /// All samples that are wanted of some tile.
    pub(super) fn wanted(&self) -> Range<u64> {
        self.samples.clone()
    }

    /// The samples of those passes.
    pub(super) fn samples(&self) -> Range<u64> {
        self.samples.start..self.lock().complete_to
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().expect("no thread panics while it looks for a task")
    }
}
