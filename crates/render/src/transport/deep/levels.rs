//! Cells of several sizes: small ones where many paths arrived, wide ones where few did.
//!
//! What light brings depends on its depth far more than on the place along the surface. So cells grow along x and z
//! alone, and are told apart by height and by a class of their distance from open air and surfaces.

use super::outcome::Outcome;
use super::samples::Samples;
use rustc_hash::FxHashMap;
use snowgrain_accel::Interior;
use snowgrain_math::DVec3;

/// Arrivals from which a cell is told apart from its neighbours: a wider one takes the place of those with fewer.
const FEWEST: usize = 256;

/// A coarse cell of the interior.
pub(super) type Cell = [i32; 3];

/// What a cell of a level is found by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
struct Key {
    cell: Cell,
    depth_class: u8,
}

/// The learnt cells of all levels; those of level `n` are `2^n` coarse cells wide along x and z.
#[derive(Clone, Debug, Default)]
pub(super) struct Levels {
    /// The least coarse cell where anything was learnt, along x and z, from which cells are joined: so that at some
    /// level all are one.
    origin: Cell,
    /// Of each level, its cells and the numbers of their outcomes.
    cells: Vec<FxHashMap<Key, u32>>,
    /// Those of the last level in their order, for places where nothing was learnt.
    last: Vec<(Key, u32)>,
    slots: usize,
    outcomes: Vec<Outcome>,
}

impl Levels {
    /// Means over the arrivals in each cell, from the smallest cells on until every arrival is in one.
    pub(super) fn of(samples: &Samples, interior: &Interior) -> Self {
        let least = |axis: usize| samples.cells().iter().map(|cell| cell[axis]).min().unwrap_or(0);
        let origin = [least(0), 0, least(2)];
        let mut levels = Self { origin, slots: samples.slots(), ..Self::default() };
        let mut is_covered = vec![false; samples.len()];
        while is_covered.contains(&false) {
            let level = levels.cells.len() as u32;
            let keys: Vec<Key> =
                samples.cells().iter().map(|&cell| levels.key(interior, level, cell)).collect();
            let mut order: Vec<u32> = (0u32..).take(keys.len()).collect();
            order.sort_unstable_by_key(|&index| (keys[index as usize], index));
            // Where all is one cell, none is wider.
            let widest = keys.iter().all(|key| key.cell[0] == keys[0].cell[0])
                && keys.iter().all(|key| key.cell[2] == keys[0].cell[2]);
            levels.cells.push(FxHashMap::default());
            for group in order.chunk_by(|&a, &b| keys[a as usize] == keys[b as usize]) {
                let is_needed = group.iter().any(|&index| !is_covered[index as usize]);
                if is_needed && (group.len() >= FEWEST || widest) {
                    group.iter().for_each(|&index| is_covered[index as usize] = true);
                    let key = keys[group[0] as usize];
                    levels.add(key, samples.means(group));
                }
            }
        }
        levels
    }

    fn add(&mut self, key: Key, means: impl Iterator<Item = Outcome>) {
        let number = (self.outcomes.len() / self.slots.max(1)) as u32;
        self.outcomes.extend(means);
        if let Some(cells) = self.cells.last_mut() {
            cells.insert(key, number);
        }
    }

    /// Once all is learnt.
    pub(super) fn finished(mut self) -> Self {
        let last = self.cells.last().into_iter().flatten();
        self.last = last.map(|(&key, &number)| (key, number)).collect();
        self.last.sort_unstable();
        self
    }

    /// Number of cells.
    pub(super) fn len(&self) -> usize {
        self.cells.iter().map(FxHashMap::len).sum()
    }

    pub(super) fn memory_bytes(&self) -> u64 {
        let cell = size_of::<(Key, u32)>() + 1;
        let capacity: usize = self.cells.iter().map(FxHashMap::capacity).sum();
        (capacity * cell + size_of_val(self.outcomes.as_slice())) as u64
    }

    /// The outcomes of all slots at the cell of a number.
    pub(super) fn outcomes(&self, number: u32) -> &[Outcome] {
        &self.outcomes[number as usize * self.slots..][..self.slots]
    }

    /// The cells about a place, in coarse cells, and their weights, which sum to 1: of the finest level that knows it.
    pub(super) fn around(&self, interior: &Interior, place: DVec3) -> Around {
        let at = place.floor().as_ivec3().to_array();
        let knows = |(level, cells): &(u32, &FxHashMap<Key, u32>)| {
            cells.contains_key(&self.key(interior, *level, at))
        };
        match (0..).zip(&self.cells).find(knows) {
            Some((level, cells)) => self.interpolated(interior, (level, cells), (place, at)),
            None => self.nearest(self.key(interior, self.cells.len() as u32 - 1, at)),
        }
    }

    /// The cell of the last level that is nearest in height and depth, where no path came by.
    fn nearest(&self, key: Key) -> Around {
        let distance = |&(near, number): &(Key, u32)| {
            let depths = near.depth_class.abs_diff(key.depth_class);
            (near.cell[1].abs_diff(key.cell[1]), depths, number)
        };
        let number = self.last.iter().min_by_key(|near| distance(near)).map(|&(_, number)| number);
        let mut around = Around::default();
        number.into_iter().for_each(|number| around.push(number, 1.0));
        around
    }

    /// Linear between the middles of the cells of a level, of those that are known.
    fn interpolated(
        &self,
        interior: &Interior,
        (level, cells): (u32, &FxHashMap<Key, u32>),
        (place, at): (DVec3, Cell),
    ) -> Around {
        let wide = f64::from(1 << level);
        let from_origin = place - DVec3::from_array(self.origin.map(f64::from));
        let corner = from_origin / DVec3::new(wide, 1.0, wide) - DVec3::splat(0.5);
        let (low, part) = (corner.floor(), corner - corner.floor());
        let classes: [u8; 2] = [0, 1].map(|upper| {
            let height = low.y as i32 + upper;
            if level == 0 { 0 } else { interior.depth_class([at[0], height, at[2]]) }
        });
        let mut around = Around::default();
        for index in 0..8 {
            let upper = [0, 1, 2].map(|axis: usize| index >> axis & 1 == 1);
            let cell = std::array::from_fn(|axis| low[axis] as i32 + i32::from(upper[axis]));
            let along = |axis: usize| if upper[axis] { part[axis] } else { 1.0 - part[axis] };
            let key = Key { cell, depth_class: classes[usize::from(upper[1])] };
            if let Some(&number) = cells.get(&key) {
                around.push(number, (along(0) * along(1) * along(2)) as f32);
            }
        }
        around.normalised()
    }

    /// The cell of a level around a coarse cell. The smallest cells have one depth each.
    fn key(&self, interior: &Interior, level: u32, cell: Cell) -> Key {
        let depth_class = if level == 0 { 0 } else { interior.depth_class(cell) };
        let [x, y, z] = std::array::from_fn(|axis| cell[axis] - self.origin[axis]);
        Key { cell: [x >> level, y, z >> level], depth_class }
    }
}

/// Numbers of cells with their weights.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Around {
    cells: [(u32, f32); 8],
    count: usize,
}

impl Around {
    fn push(&mut self, number: u32, weight: f32) {
        self.cells[self.count] = (number, weight);
        self.count += 1;
    }

    fn normalised(mut self) -> Self {
        let sum: f32 = self.range().iter().map(|cell| cell.1).sum();
        self.cells.iter_mut().for_each(|cell| cell.1 /= sum);
        self
    }

    fn range(&self) -> &[(u32, f32)] {
        &self.cells[..self.count]
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = (u32, f32)> + '_ {
        self.range().iter().copied()
    }
}
