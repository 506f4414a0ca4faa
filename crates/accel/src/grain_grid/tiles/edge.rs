//! Bricks at the edge of the snow and near surfaces, and everything that is kept once.

use super::brick::{Contents, Reaching, TileBricks, contents};
use super::{Extent, Filling, Layout};
use crate::grain_grid::build::PAD;
use crate::grain_grid::packed_cells::{BRICK, CELLS_PER_BRICK};
use crate::grain_grid::{Block, CellEntry, GridError, MEETS_SURFACE, RADIUS_MASK};
use snowgrain_math::{Aabb, DVec3};
use std::collections::HashMap;
use std::hash::{DefaultHasher, Hasher as _};

/// Entries and blocks of all bricks that differ. Brick 0 and block 0 hold nothing; those of the tiles come first.
pub(super) struct Shared {
    entries: Vec<CellEntry>,
    blocks: Vec<Block>,
    /// Blocks of the tiles.
    of_tiles: usize,
    /// Grains of each brick of the tiles, from brick 1 on.
    grains: Vec<u64>,
    /// By a digest of what they show, other bricks, and the number of their first own block.
    known: HashMap<u64, Vec<(u32, usize)>>,
}

impl Shared {
    pub(super) fn new() -> Self {
        Self {
            entries: vec![CellEntry::EMPTY_BRICK; CELLS_PER_BRICK],
            blocks: vec![Block::EMPTY],
            of_tiles: 1,
            grains: Vec::new(),
            known: HashMap::new(),
        }
    }

    /// Adds a brick of a tile, whose blocks are numbered from 1 on.
    pub(super) fn add_of_tile(&mut self, contents: &Contents) {
        let shift = self.blocks.len() - 1;
        self.entries.extend(contents.entries.iter().map(|&entry| shifted(entry, 1, shift)));
        self.blocks.extend_from_slice(&contents.blocks);
        self.grains.push(contents.grains);
        self.of_tiles = self.blocks.len();
    }

    /// The number of a brick that shows this, of which blocks from `of_tiles` on are its own; it is added where there
    /// is none.
    ///
    /// # Errors
    /// More blocks than can be numbered.
    pub(super) fn number_of(&mut self, contents: Contents) -> Result<u32, GridError> {
        let digest = digest(&contents);
        let known = self.known.get(&digest).map_or(&[][..], Vec::as_slice);
        if let Some(&(number, _)) = known.iter().find(|&&like| self.is(like, &contents)) {
            return Ok(number);
        }
        let number = (self.entries.len() / CELLS_PER_BRICK) as u32;
        let first = self.blocks.len();
        let needed = first + contents.blocks.len();
        if needed > CellEntry::MAX_BLOCKS {
            return Err(GridError::TooManyBlocks { blocks: needed, most: CellEntry::MAX_BLOCKS });
        }
        let (from, shift) = (self.of_tiles, first - self.of_tiles);
        self.entries.extend(contents.entries.iter().map(|&entry| shifted(entry, from, shift)));
        self.blocks.extend_from_slice(&contents.blocks);
        self.known.entry(digest).or_default().push((number, first));
        Ok(number)
    }

    /// Whether a brick shows this.
    fn is(&self, (number, first): (u32, usize), contents: &Contents) -> bool {
        let (from, shift) = (self.of_tiles, first - self.of_tiles);
        let same =
            |(mine, &theirs): (&CellEntry, &CellEntry)| *mine == shifted(theirs, from, shift);
        self.blocks[first..].starts_with(&contents.blocks)
            && self.brick(number).iter().zip(&contents.entries).all(same)
    }

    fn brick(&self, number: u32) -> &[CellEntry] {
        let first = number as usize * CELLS_PER_BRICK;
        &self.entries[first..first + CELLS_PER_BRICK]
    }

    /// Takes the blocks of the tile's brick for cells that show the same.
    fn share(&self, of_tile: u32, contents: Contents) -> Contents {
        let (first, mut blocks) = (self.of_tiles, Vec::new());
        let entry = |(mine, theirs): (CellEntry, &CellEntry)| {
            let own = &contents.blocks[own_range(mine, first)];
            if own == &self.blocks[range(*theirs)] {
                return CellEntry(theirs.0 | mine.0 & CellEntry::SURFACE);
            }
            let number = if own.is_empty() { 0 } else { first + blocks.len() };
            blocks.extend_from_slice(own);
            CellEntry::new(number, own.len(), mine.has_surface())
        };
        let entries =
            contents.entries.iter().copied().zip(self.brick(of_tile)).map(entry).collect();
        Contents { entries, blocks, grains: contents.grains }
    }

    /// Entries and blocks.
    pub(super) fn into_parts(mut self) -> (Vec<CellEntry>, Vec<Block>) {
        self.entries.shrink_to_fit();
        self.blocks.shrink_to_fit();
        (self.entries, self.blocks)
    }
}

/// An entry whose blocks from number `from` on are numbered so much higher.
fn shifted(entry: CellEntry, from: usize, shift: usize) -> CellEntry {
    let is_own = entry.first_block() >= from;
    CellEntry(entry.0 + if is_own { shift as u32 } else { 0 })
}

/// The blocks of a cell; none where it holds nothing.
fn range(entry: CellEntry) -> std::ops::Range<usize> {
    if entry.first_block() == 0 { 0..0 } else { entry.blocks() }
}

/// The same among blocks that are numbered from `first` on.
fn own_range(entry: CellEntry, first: usize) -> std::ops::Range<usize> {
    let range = range(entry);
    if range.is_empty() { range } else { range.start - first..range.end - first }
}

fn digest(contents: &Contents) -> u64 {
    let mut hasher = DefaultHasher::new();
    for entry in &contents.entries {
        hasher.write_u32(entry.0);
    }
    hasher.write(bytemuck::cast_slice(&contents.blocks));
    hasher.finish()
}

/// What a brick of the snow shows, told by its place from the corner of tile (0, 0, 0).
///
/// # Errors
/// More grains in a cell than it can list.
pub(super) fn filling(
    layout: &Layout<'_>,
    tiles: &[TileBricks],
    shared: &Shared,
    brick: [i64; 3],
) -> Result<Filling, GridError> {
    let tiled = layout.tiled;
    let corner: [i64; 3] =
        std::array::from_fn(|axis| tiled.corner[axis] + brick[axis] * layout.edge(axis));
    let reach = layout.largest + i64::from(PAD);
    let centers = std::array::from_fn(|axis| {
        [corner[axis] - reach, corner[axis] + layout.edge(axis) + reach]
    });
    let extent = (tiled.extent)(centers);
    let crossing = Crossing { layout, corner };
    let is_near_surface = crossing.is_near();
    if extent == Extent::Empty && !is_near_surface {
        return Ok(Filling::Empty);
    }
    let tile = std::array::from_fn(|axis| brick[axis].div_euclid(layout.bricks[axis]));
    let (variant, in_tile) = ((tiled.variant_of)(tile), layout.number_in_tile(brick));
    let of_tile = 1 + variant * layout.bricks_of_tile() + in_tile;
    if extent == Extent::Whole && !is_near_surface {
        return Ok(Filling::Tile(of_tile as u32, shared.grains[of_tile - 1]));
    }
    let is_there = |grain: &&Reaching| {
        extent == Extent::Whole
            || (tiled.holds)(std::array::from_fn(|a| corner[a] + i64::from(grain.center[a])))
    };
    let marked = |grain: &Reaching| {
        let meets = if is_near_surface && crossing.meets(grain) { MEETS_SURFACE } else { 0 };
        Reaching { radius: grain.radius | meets, ..*grain }
    };
    let grains: Vec<Reaching> = match extent {
        Extent::Empty => Vec::new(),
        Extent::Whole | Extent::Part => {
            tiles[variant].reaching[in_tile].iter().filter(is_there).map(marked).collect()
        }
    };
    let crosses = is_near_surface && crossing.crosses([0; 3], [BRICK; 3]);
    let has_surface = |cell: [i32; 3]| crosses && crossing.crosses(cell, cell.map(|c| c + 1));
    let own = contents(layout, &grains, shared.of_tiles, has_surface)?;
    let shows = own.entries.iter().any(|&entry| entry != CellEntry::EMPTY);
    Ok(if shows { Filling::Own(shared.share(of_tile as u32, own)) } else { Filling::Empty })
}

/// Asks the surfaces about a brick.
struct Crossing<'a> {
    layout: &'a Layout<'a>,
    corner: [i64; 3],
}

impl Crossing<'_> {
    /// Whether a surface may cross the brick or a grain that reaches into it.
    fn is_near(&self) -> bool {
        let pad = 2 * self.layout.largest + i64::from(PAD);
        self.may_cross([0, 1, 2].map(|a| [-pad, self.layout.edge(a) + pad]))
    }

    /// Whether one may cross the cells `from..to`.
    fn crosses(&self, from: [i32; 3], to: [i32; 3]) -> bool {
        self.may_cross([0, 1, 2].map(|axis| {
            let at = |cell: i32| i64::from(cell) * i64::from(self.layout.side[axis]);
            [at(from[axis]) - i64::from(PAD), at(to[axis]) + i64::from(PAD)]
        }))
    }

    /// Whether one may cross a grain.
    fn meets(&self, grain: &Reaching) -> bool {
        let reach = i64::from(grain.radius & RADIUS_MASK) + i64::from(PAD);
        self.may_cross(grain.center.map(|at| [i64::from(at) - reach, i64::from(at) + reach]))
    }

    fn may_cross(&self, from_corner: [[i64; 2]; 3]) -> bool {
        let surfaces = self.layout.surfaces;
        if surfaces.is_empty() {
            return false;
        }
        let metres = |end: usize| {
            let quanta: [f64; 3] =
                std::array::from_fn(|axis| (self.corner[axis] + from_corner[axis][end]) as f64);
            let quantisation = self.layout.quantisation;
            quantisation.origin() + DVec3::from_array(quanta) * quantisation.quantum()
        };
        surfaces.may_cross(&Aabb::new(metres(0), metres(1)))
    }
}
