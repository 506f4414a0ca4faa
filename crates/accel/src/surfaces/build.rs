//! Builds hierarchies: binned surface area heuristic (Wald 2007, "On fast Construction of SAH-based
//! Bounding Volume Hierarchies"), eight children at a time.
//!
//! Where a set of items is split depends on the set alone, neither on its order nor on who works at
//! it: bounds and counts are combined exactly, and where items coincide their numbers decide. So the
//! same items give the same tree on any number of threads.

use super::cuboid::{Bounds, greater};
use super::tree::{Child, Node, Tree, WIDTH};
use rayon::prelude::*;
use std::cmp::Ordering;
use std::ops::Range;

const BINS: usize = 16;

/// Below this depth ranges are halved by count, which bounds the depth by 10 more levels.
const HEURISTIC_DEPTH: usize = 16;

/// More items than this are worked at by several threads.
const SHARED: usize = 1 << 14;

/// Items that one thread bins at a time.
const CHUNK: usize = 1 << 13;

/// What is to be found: its box, and its number in the idle lane.
#[derive(Clone, Copy)]
pub(super) struct Item(Bounds);

impl Item {
    /// One more than the largest number: their bits are not those of a NaN.
    pub(super) const CAPACITY: usize = 1 << 30;

    pub(super) fn new(mut bounds: Bounds, number: u32) -> Self {
        bounds.min[3] = 0.0;
        bounds.max[3] = f32::from_bits(number);
        Self(bounds)
    }

    pub(super) fn number(&self) -> u32 {
        self.0.max[3].to_bits()
    }

    /// Whether there is nothing in its box.
    pub(super) fn is_empty(&self) -> bool {
        self.0.min[0] > self.0.max[0]
    }

    /// Whether both have the same box.
    fn covers(&self, other: &Self) -> bool {
        self.0.corners() == other.0.corners()
    }
}

/// What a hierarchy is built from.
pub(super) struct Plan<'a> {
    /// Most items in a leaf, 1 to 8.
    pub(super) leaf_size: usize,
    /// Total order of items by what they are: equal ones are the same thing, of which one is kept.
    pub(super) same: Option<&'a (dyn Fn(u32, u32) -> Ordering + Sync)>,
}

/// A hierarchy and the numbers of the items in each leaf, ascending.
pub(super) struct Built {
    pub(super) tree: Tree,
    pub(super) items: Vec<Item>,
    pub(super) leaves: Vec<Range<usize>>,
}

/// Part of the items with the box around it and the box around their (doubled) middles.
#[derive(Clone)]
struct Part {
    range: Range<usize>,
    bounds: Bounds,
    middles: Bounds,
    /// Whether items that are the same thing were already left out.
    distinct: bool,
}

/// A finished part: nodes and leaves numbered from 0.
#[derive(Default)]
struct Branch {
    nodes: Vec<Node>,
    leaves: Vec<Range<usize>>,
}

impl Plan<'_> {
    /// The hierarchy over these items.
    pub(super) fn build(&self, mut items: Vec<Item>) -> Built {
        if items.is_empty() {
            return Built { tree: Tree::default(), items, leaves: Vec::new() };
        }
        let sides = items
            .par_chunks(CHUNK)
            .map(|chunk| chunk.iter().fold(Side::EMPTY, |side, item| side.including(item)))
            .reduce(|| Side::EMPTY, |a, b| a.union(&b));
        let all = sides.part(0..items.len(), false);
        let mut branch = Branch::default();
        let root = if all.range.len() <= self.leaf_size {
            self.leaf(&mut items, &all, 0, &mut branch)
        } else {
            self.node(&mut items, 0, all, 0, &mut branch)
        };
        branch.nodes.shrink_to_fit();
        let tree = Tree { nodes: branch.nodes, root: Some(root) };
        Built { tree, items, leaves: branch.leaves }
    }

    /// Adds the node over `part` and everything below. `items` are those from number `base` on.
    fn node(
        &self,
        items: &mut [Item],
        base: usize,
        part: Part,
        depth: usize,
        branch: &mut Branch,
    ) -> Child {
        let shared = part.range.len() > SHARED;
        let index = branch.nodes.len();
        branch.nodes.push(Node::EMPTY);
        let mut parts = self.split_to_children(items, base, part, depth);
        parts.sort_unstable_by_key(|part| part.range.start);
        let children: Vec<Child> = if shared {
            let pieces = cut(items, base, &parts);
            let grown: Vec<_> = pieces
                .into_par_iter()
                .zip(&parts)
                .map(|(items, part)| {
                    let mut branch = Branch::default();
                    let base = part.range.start;
                    let child = self.child(items, base, part.clone(), depth, &mut branch);
                    (child, branch)
                })
                .collect();
            grown.into_iter().map(|(child, grown)| branch.graft(child, grown)).collect()
        } else {
            let grow = |part: &Part| self.child(items, base, part.clone(), depth, branch);
            parts.iter().map(grow).collect()
        };
        let node = &mut branch.nodes[index];
        for (lane, (part, child)) in parts.iter().zip(children).enumerate() {
            node.set(lane, &part.bounds, child);
        }
        Child::inner(index)
    }

    fn child(
        &self,
        items: &mut [Item],
        base: usize,
        part: Part,
        depth: usize,
        branch: &mut Branch,
    ) -> Child {
        if part.range.len() <= self.leaf_size {
            self.leaf(items, &part, base, branch)
        } else {
            self.node(items, base, part, depth + 1, branch)
        }
    }

    fn leaf(&self, items: &mut [Item], part: &Part, base: usize, branch: &mut Branch) -> Child {
        let items = &mut items[part.range.start - base..part.range.end - base];
        let kept = match self.same {
            Some(same) if !part.distinct && any_pair(items, same) => keep_distinct(items, same),
            _ => items.len(),
        };
        items[..kept].sort_unstable_by_key(Item::number);
        branch.leaves.push(part.range.start..part.range.start + kept);
        Child::leaf(branch.leaves.len() - 1)
    }

    /// Splits the largest part, again and again, until there are eight or all are leaves.
    fn split_to_children(
        &self,
        items: &mut [Item],
        base: usize,
        part: Part,
        depth: usize,
    ) -> Vec<Part> {
        let by_count = depth >= HEURISTIC_DEPTH;
        let mut parts = Vec::with_capacity(WIDTH);
        parts.push(part);
        while parts.len() < WIDTH {
            let size = |part: &Part| {
                if by_count { part.range.len() as f32 } else { part.bounds.half_area() }
            };
            let largest = (0..parts.len())
                .filter(|&i| parts[i].range.len() > self.leaf_size)
                .max_by(|&i, &j| size(&parts[i]).total_cmp(&size(&parts[j])));
            let Some(largest) = largest else { break };
            let part = &parts[largest];
            let own = &mut items[part.range.start - base..part.range.end - base];
            let halves = if by_count { None } else { self.split(own, part) };
            let halves = halves.unwrap_or_else(|| self.halve(own, part));
            let (first, second) = halves;
            parts[largest] = first;
            parts.extend(second);
        }
        parts
    }

    /// Sorts the part's items into two halves that are cheap to visit; `None` where no slice of
    /// an axis tells them apart.
    fn split(&self, items: &mut [Item], part: &Part) -> Option<(Part, Option<Part>)> {
        let binning = Binning::new(&part.middles);
        let bins = if items.len() > SHARED {
            items
                .par_chunks(CHUNK)
                .map(|chunk| Bins::new(chunk, &binning))
                .reduce(|| Bins::EMPTY, Bins::union)
        } else {
            Bins::new(items, &binning)
        };
        let (axis, last) = bins.best_split(self.leaf_size)?;
        let mut sides = [Side::EMPTY; 2];
        let mut left = 0;
        for i in 0..items.len() {
            let item = items[i];
            let right = usize::from(binning.bin(&item.0.middle(), axis) > last);
            sides[right] = sides[right].including(&item);
            // What lies between `left` and `i` belongs to the right.
            items[i] = items[left];
            items[left] = item;
            left += 1 - right;
        }
        let Range { start, end } = part.range;
        let middle = start + left;
        let [first, second] = sides;
        let second = second.part(middle..end, part.distinct);
        Some((first.part(start..middle, part.distinct), Some(second)))
    }

    /// Two halves of the same count, across the longest axis of the middles. Of items that are the
    /// same thing only the first is kept, so that there may be a single half.
    fn halve(&self, items: &mut [Item], part: &Part) -> (Part, Option<Part>) {
        let kept = match self.same {
            Some(same) if !part.distinct => keep_distinct(items, same),
            _ => items.len(),
        };
        let items = &mut items[..kept];
        let size = |axis: usize| part.middles.max[axis] - part.middles.min[axis];
        let axis = (0..3).max_by(|&i, &j| size(i).total_cmp(&size(j))).unwrap_or(0);
        let half = if kept <= self.leaf_size { kept } else { kept / 2 };
        if half < kept {
            let key = |item: &Item| item.0.middle()[axis];
            items.select_nth_unstable_by(half, |a, b| {
                key(a).total_cmp(&key(b)).then(a.number().cmp(&b.number()))
            });
        }
        let start = part.range.start;
        let side = |range: Range<usize>| {
            let side = items[range.clone()].iter().fold(Side::EMPTY, |s, item| s.including(item));
            side.part(start + range.start..start + range.end, true)
        };
        (side(0..half), (half < kept).then(|| side(half..kept)))
    }
}

/// The items of each part; parts are in order and do not overlap.
fn cut<'i>(mut items: &'i mut [Item], mut base: usize, parts: &[Part]) -> Vec<&'i mut [Item]> {
    let mut pieces = Vec::with_capacity(parts.len());
    for part in parts {
        let (_, rest) = items.split_at_mut(part.range.start - base);
        let (piece, rest) = rest.split_at_mut(part.range.len());
        pieces.push(piece);
        items = rest;
        base = part.range.end;
    }
    pieces
}

impl Branch {
    /// Takes in what grew apart; returns where its root is now.
    fn graft(&mut self, root: Child, mut grown: Self) -> Child {
        let (nodes, leaves) = (self.nodes.len(), self.leaves.len());
        for child in grown.nodes.iter_mut().flat_map(|node| &mut node.children) {
            *child = child.moved(nodes, leaves);
        }
        self.nodes.append(&mut grown.nodes);
        self.leaves.append(&mut grown.leaves);
        root.moved(nodes, leaves)
    }
}

/// Whether two items are the same thing. The same thing has the same box.
fn any_pair(items: &[Item], same: &dyn Fn(u32, u32) -> Ordering) -> bool {
    items.iter().enumerate().any(|(i, a)| {
        let twins = |b: &&Item| a.covers(b) && same(a.number(), b.number()).is_eq();
        items[..i].iter().any(|b| twins(&b))
    })
}

/// Moves the first of each thing to the front; returns how many there are.
fn keep_distinct(items: &mut [Item], same: &dyn Fn(u32, u32) -> Ordering) -> usize {
    items.sort_unstable_by(|a, b| same(a.number(), b.number()).then(a.number().cmp(&b.number())));
    let mut kept = 1;
    for i in 1..items.len() {
        if same(items[kept - 1].number(), items[i].number()).is_ne() {
            items[kept] = items[i];
            kept += 1;
        }
    }
    kept
}

/// What is around one side of a split.
#[derive(Clone, Copy)]
struct Side {
    bounds: Bounds,
    middles: Bounds,
}

impl Side {
    const EMPTY: Self = Self { bounds: Bounds::EMPTY, middles: Bounds::EMPTY };

    #[inline(always)]
    fn including(&self, item: &Item) -> Self {
        let middle = item.0.middle();
        Self {
            bounds: self.bounds.union(&item.0),
            middles: self.middles.union(&Bounds { min: middle, max: middle }),
        }
    }

    fn union(&self, other: &Self) -> Self {
        Self {
            bounds: self.bounds.union(&other.bounds),
            middles: self.middles.union(&other.middles),
        }
    }

    fn part(self, range: Range<usize>, distinct: bool) -> Part {
        Part { range, bounds: self.bounds, middles: self.middles, distinct }
    }
}

/// Equal slices of each axis between the outermost middles.
struct Binning {
    start: [f32; 4],
    scale: [f32; 4],
}

impl Binning {
    fn new(middles: &Bounds) -> Self {
        let scale = std::array::from_fn(|axis| {
            let extent = middles.max[axis] - middles.min[axis];
            if extent > 0.0 { BINS as f32 * (1.0 - 1e-6) / extent } else { 0.0 }
        });
        Self { start: middles.min, scale }
    }

    #[inline(always)]
    fn bin(&self, middle: &[f32; 4], axis: usize) -> usize {
        (((middle[axis] - self.start[axis]) * self.scale[axis]) as usize).min(BINS - 1)
    }
}

/// The boxes around what falls into each slice, and how much does.
struct Bins([[(Bounds, u32); BINS]; 3]);

impl Bins {
    const EMPTY: Self = Self([[(Bounds::EMPTY, 0); BINS]; 3]);

    fn new(items: &[Item], binning: &Binning) -> Self {
        let mut bins = Self::EMPTY;
        for item in items {
            let middle = item.0.middle();
            for axis in 0..3 {
                let (bounds, count) = &mut bins.0[axis][binning.bin(&middle, axis)];
                *bounds = bounds.union(&item.0);
                *count += 1;
            }
        }
        bins
    }

    fn union(mut self, other: Self) -> Self {
        for (bin, more) in self.0.iter_mut().flatten().zip(other.0.iter().flatten()) {
            *bin = (bin.0.union(&more.0), bin.1 + more.1);
        }
        self
    }

    /// The axis of the cheapest split and the last bin on its left; `None` where everything lies
    /// in one slice of each axis.
    fn best_split(&self, leaf_size: usize) -> Option<(usize, usize)> {
        let cost = |(bounds, count): &(Bounds, u32)| {
            bounds.half_area() * (*count).div_ceil(leaf_size as u32) as f32
        };
        let mut best = None;
        let mut least = f32::INFINITY;
        for (axis, bins) in self.0.iter().enumerate() {
            let total: u32 = bins.iter().map(|bin| bin.1).sum();
            let mut right = [0.0; BINS];
            let mut side = (Bounds::EMPTY, 0);
            for i in (1..BINS).rev() {
                side = (side.0.union(&bins[i].0), side.1 + bins[i].1);
                right[i] = if side.1 == 0 { 0.0 } else { cost(&side) };
            }
            let mut side = (Bounds::EMPTY, 0);
            for i in 0..BINS - 1 {
                side = (side.0.union(&bins[i].0), side.1 + bins[i].1);
                if side.1 == 0 || side.1 == total {
                    continue;
                }
                let both = greater(cost(&side) + right[i + 1], 0.0);
                if both < least {
                    (least, best) = (both, Some((axis, i)));
                }
            }
        }
        best
    }
}
