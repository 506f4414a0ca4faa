//! The bounding volume hierarchy: eight children a node, boxes in `f32`, leaves numbered in order.
//!
//! Boxes are relative to a middle that the owner keeps and are rounded outwards, so that what lies
//! far from the origin loses nothing; every comparison with them is conservative, and what is found
//! is decided by the leaves' contents alone, in `f64`.

use super::beam::Beam;
use super::cuboid::{Bounds, BoxQuery};
use crate::prefetch::prefetch_all;
use fearless_simd::Simd;
use std::mem::MaybeUninit;

/// Children of a node.
pub(super) const WIDTH: usize = 8;

/// Enough for the deepest tree of [`super::build`]: 26 levels, each leaving 7 siblings.
const STACK: usize = 200;

/// A node: the boxes of its children (index 0: least corners, 1: greatest; one array an axis, one
/// lane a child) and where they lead.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(32))]
pub(super) struct Node {
    pub(super) corners: [[[f32; WIDTH]; 3]; 2],
    pub(super) children: [Child; WIDTH],
}

impl Node {
    /// No children: boxes that nothing meets.
    pub(super) const EMPTY: Self = Self {
        corners: [[[f32::INFINITY; WIDTH]; 3], [[f32::NEG_INFINITY; WIDTH]; 3]],
        children: [Child(0); WIDTH],
    };

    pub(super) fn set(&mut self, lane: usize, bounds: &Bounds, child: Child) {
        for axis in 0..3 {
            self.corners[0][axis][lane] = bounds.min[axis];
            self.corners[1][axis][lane] = bounds.max[axis];
        }
        self.children[lane] = child;
    }

    /// The children that are there, each with its box.
    pub(super) fn children(&self) -> impl Iterator<Item = (Bounds, Child)> + '_ {
        (0..WIDTH).filter(|&lane| self.corners[0][0][lane] <= self.corners[1][0][lane]).map(
            |lane| {
                let [min, max] = self.corners.map(|c| [c[0][lane], c[1][lane], c[2][lane], 0.0]);
                (Bounds { min, max }, self.children[lane])
            },
        )
    }
}

/// Where a child leads: another node, or a leaf.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Child(u32);

/// What a [`Child`] leads to.
pub(super) enum Step {
    Inner(usize),
    Leaf(usize),
}

impl Child {
    const LEAF: u32 = 1 << 31;

    pub(super) fn inner(node: usize) -> Self {
        debug_assert!(node < Self::LEAF as usize);
        Self(node as u32)
    }

    pub(super) fn leaf(leaf: usize) -> Self {
        debug_assert!(leaf < Self::LEAF as usize);
        Self(Self::LEAF | leaf as u32)
    }

    /// Where it leads once so many nodes and leaves stand before its own.
    pub(super) fn moved(self, nodes: usize, leaves: usize) -> Self {
        match self.step() {
            Step::Inner(node) => Self::inner(node + nodes),
            Step::Leaf(leaf) => Self::leaf(leaf + leaves),
        }
    }

    #[inline(always)]
    pub(super) fn step(self) -> Step {
        if self.0 & Self::LEAF == 0 {
            Step::Inner(self.0 as usize)
        } else {
            Step::Leaf((self.0 & !Self::LEAF) as usize)
        }
    }
}

/// A hierarchy over numbered leaves.
#[derive(Debug, Default)]
pub(super) struct Tree {
    pub(super) nodes: Vec<Node>,
    /// `None` where there is no leaf.
    pub(super) root: Option<Child>,
}

impl Tree {
    /// A walk over the leaves that one query asks for; `leaves` holds what they are, in order.
    #[inline(always)]
    pub(super) fn walk<'t, L>(&'t self, leaves: &'t [L], stack: &'t mut Stack) -> Walk<'t, L> {
        stack.len = 0;
        if let Some(root) = self.root {
            stack.push(f32::INFINITY, root, 0);
        }
        Walk { nodes: &self.nodes, leaves, stack }
    }

    pub(super) fn memory_bytes(&self) -> usize {
        self.nodes.capacity() * size_of::<Node>()
    }
}

/// A walk through a tree. All calls of one walk ask the same question, but the answer may narrow.
pub(super) struct Walk<'t, L> {
    nodes: &'t [Node],
    leaves: &'t [L],
    stack: &'t mut Stack,
}

impl<'t, L> Walk<'t, L> {
    /// The next leaf whose box the beam meets at `limit` or before, nearer ones first as far as
    /// the tree knows.
    #[inline(always)]
    pub(super) fn next_along<S: Simd>(
        &mut self,
        simd: S,
        beam: &Beam,
        limit: f32,
    ) -> Option<&'t L> {
        loop {
            let (key, mut child) = self.stack.pop()?;
            // Keys are negative distances; the root's is infinite.
            if -key > limit {
                continue;
            }
            loop {
                let index = match child.step() {
                    Step::Leaf(leaf) => return Some(&self.leaves[leaf]),
                    Step::Inner(index) => index,
                };
                let nodes = self.nodes;
                let node = &nodes[index];
                let (hits, starts) = beam.meet(simd, &node.corners, limit);
                if hits == 0 {
                    break;
                }
                child = self.push_but_nearest(node, hits, &starts);
            }
        }
    }

    /// Of the children met, the nearest; the others wait.
    #[inline(always)]
    fn push_but_nearest(&mut self, node: &Node, mut hits: u64, starts: &[f32; WIDTH]) -> Child {
        let first = hits.trailing_zeros() as usize;
        let (mut near, mut child) = (starts[first], node.children[first]);
        hits &= hits - 1;
        let base = self.stack.len;
        while hits != 0 {
            let lane = hits.trailing_zeros() as usize;
            hits &= hits - 1;
            let (start, other) = (starts[lane], node.children[lane]);
            let (far, waits) = if start < near {
                let far = (near, child);
                (near, child) = (start, other);
                far
            } else {
                (start, other)
            };
            self.stack.push(-far, waits, base);
            self.prefetch(waits);
        }
        child
    }

    #[inline(always)]
    fn prefetch(&self, child: Child) {
        match child.step() {
            Step::Inner(index) => prefetch_all(self.nodes, index),
            Step::Leaf(index) => prefetch_all(self.leaves, index),
        }
    }

    /// The next leaf whose box overlaps the query's (in doubt too many).
    #[inline(always)]
    pub(super) fn next_within<S: Simd>(&mut self, simd: S, query: &BoxQuery) -> Option<&'t L> {
        loop {
            let (_, child) = self.stack.pop()?;
            match child.step() {
                Step::Leaf(leaf) => return Some(&self.leaves[leaf]),
                Step::Inner(index) => {
                    let nodes = self.nodes;
                    let node = &nodes[index];
                    self.push(node, query.meet(simd, &node.corners), [0.0; WIDTH]);
                }
            }
        }
    }

    #[inline(always)]
    fn push(&mut self, node: &Node, mut hits: u64, starts: [f32; WIDTH]) {
        let base = self.stack.len;
        while hits != 0 {
            let lane = hits.trailing_zeros() as usize;
            hits &= hits - 1;
            let child = node.children[lane];
            self.stack.push(-starts[lane], child, base);
        }
    }
}

/// Children still to be visited, each with a key; the largest keys of a node come first.
pub(super) struct Stack {
    /// Those below `len` are there. (As one whole: an array of uninitialised elements is cleared.)
    entries: MaybeUninit<[Entry; STACK]>,
    len: usize,
}

type Entry = (f32, Child);

impl Stack {
    #[inline(always)]
    pub(super) fn new() -> Self {
        Self { entries: MaybeUninit::uninit(), len: 0 }
    }

    /// Adds a child, in order of the keys among those added since the stack held `base`.
    #[inline(always)]
    fn push(&mut self, key: f32, child: Child, base: usize) {
        let mut at = self.len;
        while at > base {
            let below = self.read(at - 1);
            if below.0 <= key {
                break;
            }
            self.write(at, below);
            at -= 1;
        }
        self.write(at, (key, child));
        self.len += 1;
    }

    #[inline(always)]
    fn pop(&mut self) -> Option<Entry> {
        self.len = self.len.checked_sub(1)?;
        Some(self.read(self.len))
    }

    /// The entry at `at`, which must have been written.
    #[inline(always)]
    fn read(&self, at: usize) -> Entry {
        assert!(at < STACK);
        #[expect(
            unsafe_code,
            reason = "`at` is within the array, and `push` and `pop` read only what `push` wrote: \
                      entries below `len`, which only `push` raises"
        )]
        unsafe {
            self.entries.as_ptr().cast::<Entry>().add(at).read()
        }
    }

    #[inline(always)]
    fn write(&mut self, at: usize, entry: Entry) {
        assert!(at < STACK);
        #[expect(unsafe_code, reason = "`at` is within the array")]
        unsafe {
            self.entries.as_mut_ptr().cast::<Entry>().add(at).write(entry);
        }
    }
}
