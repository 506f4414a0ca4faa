//! Which grains overlap others.

use crate::grain_grid::block::RADIUS_MASK;
use crate::grain_grid::hull::{Hull, Placed};
use crate::grain_grid::{Block, GRAINS_PER_BLOCK, ReachedFaces, ShapeWord};
use fearless_simd::Simd;
use snowgrain_math::DVec3;

/// Grains whose surfaces interpenetrate by less than this many quanta only touch: rounding to the
/// lattice moves two grains by at most 1.74 quanta against each other.
const TOUCH: u16 = 3;

/// Whether two grains interpenetrate by more than rounding explains.
#[inline(always)]
pub(crate) fn overlaps(a: [i32; 3], radius_a: u16, b: [i32; 3], radius_b: u16) -> bool {
    // Of the smallest grains a few quanta are a large part.
    let touch = TOUCH.min(radius_a.min(radius_b) / 16);
    let sum = u32::from(radius_a) + u32::from(radius_b) - u32::from(touch);
    // Two radii are at most 15 bits: what is cut off there cannot overlap, and squares fit.
    let far = u32::from(2 * RADIUS_MASK + 1);
    let square = |axis: usize| {
        let d = a[axis].abs_diff(b[axis]).min(far);
        d * d
    };
    square(0) + square(1) + square(2) < sum * sum
}

/// Grains of a cell, as the test of its overlaps wants them.
pub(super) struct ListedGrains<'a> {
    pub(super) blocks: &'a [Block],
    /// The grain of each slot, among those of `overlapping`.
    pub(super) owners: &'a [[u32; GRAINS_PER_BLOCK]],
    /// Grains listed.
    pub(super) count: usize,
}

/// Marks the grains of a cell that overlap another one of it.
#[inline(always)]
pub(super) fn mark_overlapping<S: Simd>(_: S, cell: &ListedGrains<'_>, overlapping: &mut [bool]) {
    for own in 0..cell.count {
        let (at, slot) = (own / GRAINS_PER_BLOCK, own % GRAINS_PER_BLOCK);
        let owner = cell.owners[at][slot] as usize;
        if overlapping[owner] {
            continue;
        }
        let block = &cell.blocks[at];
        let center = [block.x[slot], block.y[slot], block.z[slot]];
        let radius = block.radius[slot];
        overlapping[owner] = cell.blocks.iter().enumerate().any(|(other, block)| {
            let but = if other == at { slot } else { GRAINS_PER_BLOCK };
            overlaps_any(block, center, radius, but)
        });
    }
}

/// Whether a grain overlaps one of the block but that in slot `but`. Without a branch a slot, so
/// that the compiler makes vectors of it.
#[inline(always)]
fn overlaps_any(block: &Block, center: [u16; 3], radius: u16, but: usize) -> bool {
    let mut hits = [0u16; GRAINS_PER_BLOCK];
    for (slot, hit) in hits.iter_mut().enumerate() {
        let other = block.radius[slot];
        let touch = TOUCH.min(radius.min(other) / 16);
        let sum = radius + other - touch;
        let far = 2 * RADIUS_MASK + 1;
        let square = |a: u16, b: u16| {
            let d = u32::from(a.abs_diff(b).min(far));
            d * d
        };
        let distance2 = square(block.x[slot], center[0])
            + square(block.y[slot], center[1])
            + square(block.z[slot], center[2]);
        let sum2 = u32::from(sum) * u32::from(sum);
        *hit = u16::from((distance2 < sum2) & (other > 0));
    }
    if but < GRAINS_PER_BLOCK {
        hits[but] = 0;
    }
    hits.iter().fold(0, |any, &hit| any | hit) != 0
}

/// What there is to know of grains of shapes.
pub(super) struct Shaped<'a> {
    /// Of each prototype.
    pub(super) hulls: &'a [Hull],
    /// The shape of a grain, by its owner's number.
    pub(super) words: &'a dyn Fn(u32) -> u64,
    /// Of a cell, in cell quanta: its low faces and its edges.
    pub(super) margin: i32,
    pub(super) side: [i32; 3],
}

/// One grain of a cell.
#[derive(Clone, Copy)]
struct Listed {
    owner: u32,
    center: [u16; 3],
    radius: u16,
}

impl Shaped<'_> {
    /// Marks the grains of a cell that may overlap another one of it, and their faces that this may reach, where the cell is
    /// the one that answers for both.
    pub(super) fn mark_overlapping(
        &self,
        cell: &ListedGrains<'_>,
        overlapping: &mut [bool],
        reached: &mut [ReachedFaces],
    ) {
        for one in 0..cell.count {
            let a = cell.grain(one);
            for b in (one + 1..cell.count).map(|other| cell.grain(other)) {
                let owners = [a.owner as usize, b.owner as usize];
                let is_known =
                    |owner: usize| overlapping[owner] && reached[owner] == ReachedFaces::ALL;
                if owners.into_iter().all(is_known) || !self.answers_for(&a, &b) {
                    continue;
                }
                let Some(faces) = self.faces_reached(&a, &b) else { continue };
                for (owner, faces) in owners.into_iter().zip(faces) {
                    overlapping[owner] = true;
                    reached[owner] = reached[owner].with(faces);
                }
            }
        }
    }

    /// Whether the balls of two grains meet and their lens has its middle in the cell: it lies in both, so exactly
    /// one of the cells that list both answers.
    fn answers_for(&self, a: &Listed, b: &Listed) -> bool {
        let between: [i32; 3] =
            std::array::from_fn(|axis| i32::from(b.center[axis]) - i32::from(a.center[axis]));
        let distance2: i64 = between.iter().map(|&d| i64::from(d) * i64::from(d)).sum();
        let (ra, rb) = (i64::from(a.radius), i64::from(b.radius));
        if distance2 >= (ra + rb) * (ra + rb) {
            return false;
        }
        // Of balls one within the other, the centre of the smaller.
        let along = (distance2 + ra * ra - rb * rb) as f64 / (2 * distance2.max(1)) as f64;
        let along = along.clamp(0.0, 1.0);
        (0..3).all(|axis| {
            let step = (f64::from(between[axis]) * along).round() as i32;
            let middle = i32::from(a.center[axis]) + step - self.margin;
            (0..self.side[axis]).contains(&middle)
        })
    }

    /// The faces of each of two grains that the other may reach; `None` where they are apart.
    fn faces_reached(&self, a: &Listed, b: &Listed) -> Option<[ReachedFaces; 2]> {
        let placed = |grain: &Listed| {
            let shape = ShapeWord::of_slot((self.words)(grain.owner)).shape();
            self.hulls[shape.prototype()].placed(shape, grain.radius)
        };
        let (one, other) = (placed(a), placed(b));
        if one.is_ball() && other.is_ball() {
            let radius = |grain: &Placed<'_>| grain.placement.radius as u16;
            let center = |grain: &Listed| grain.center.map(i32::from);
            return overlaps(center(a), radius(&one), center(b), radius(&other))
                .then_some([ReachedFaces::NOT_FLAT; 2]);
        }
        let center = |grain: &Listed| DVec3::from_array(grain.center.map(f64::from));
        let between = center(b) - center(a);
        let faces =
            || [one.faces_reached_by(&other, between), other.faces_reached_by(&one, -between)];
        (!one.is_apart_from(&other, between)).then(faces)
    }
}

impl ListedGrains<'_> {
    fn grain(&self, number: usize) -> Listed {
        let (at, slot) = (number / GRAINS_PER_BLOCK, number % GRAINS_PER_BLOCK);
        let block = &self.blocks[at];
        Listed {
            owner: self.owners[at][slot],
            center: [block.x[slot], block.y[slot], block.z[slot]],
            radius: block.radius[slot],
        }
    }
}
