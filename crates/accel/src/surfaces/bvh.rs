//! The bounding volume hierarchy over all triangles: eight children a node, boxes in `f32`.
//!
//! Boxes are relative to the middle of all triangles and rounded outwards, so that a scene far from
//! the origin loses nothing; every comparison with them is conservative, and what is found is
//! decided by the triangles alone, in `f64`.

use super::triangle::{ROUNDING, Triangle};
use snowgrain_math::{Aabb, DVec3};
use std::ops::ControlFlow;

/// Children of a node.
pub(super) const WIDTH: usize = 8;

/// Enough for the deepest tree of [`super::build`]: 26 levels, each leaving 7 siblings.
const STACK: usize = 200;

/// A box corner in the hierarchy's own space, one array an axis, one lane a child.
pub(super) type Corners = [[f32; WIDTH]; 3];

/// A node: the boxes of its children (index 0: least corners, 1: greatest) and where they lead.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(super) struct Node {
    pub(super) corners: [Corners; 2],
    pub(super) children: [Child; WIDTH],
}

impl Node {
    /// No children: boxes that nothing meets.
    pub(super) const EMPTY: Self = Self {
        corners: [[[f32::INFINITY; WIDTH]; 3], [[f32::NEG_INFINITY; WIDTH]; 3]],
        children: [Child(0); WIDTH],
    };
}

/// Where a child leads: another node, or a run of up to 8 triangles.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Child(u32);

/// What a [`Child`] leads to.
pub(super) enum Step {
    Inner(usize),
    Leaf(std::ops::Range<usize>),
}

impl Child {
    const LEAF: u32 = 1 << 31;
    const FIRST_BITS: u32 = 28;
    /// One more than the largest index of a triangle.
    pub(super) const CAPACITY: usize = 1 << Self::FIRST_BITS;

    pub(super) fn inner(node: usize) -> Self {
        Self(node as u32)
    }

    pub(super) fn leaf(first: usize, count: usize) -> Self {
        debug_assert!((1..=8).contains(&count) && first < Self::CAPACITY);
        Self(Self::LEAF | ((count as u32 - 1) << Self::FIRST_BITS) | first as u32)
    }

    #[inline(always)]
    pub(super) fn step(self) -> Step {
        if self.0 & Self::LEAF == 0 {
            return Step::Inner(self.0 as usize);
        }
        let first = (self.0 as usize) & (Self::CAPACITY - 1);
        let count = ((self.0 >> Self::FIRST_BITS) & 7) as usize + 1;
        Step::Leaf(first..first + count)
    }
}

/// Children still to be visited, each with a key; the largest keys of a node come first.
pub(super) struct Stack {
    entries: [(f32, Child); STACK],
    len: usize,
}

impl Stack {
    pub(super) fn new() -> Self {
        let mut stack = Self { entries: [(0.0, Child(0)); STACK], len: 0 };
        stack.push(f32::INFINITY, Child::inner(0), 0);
        stack
    }

    /// Adds a child, in order of the keys among those added since the stack held `base`.
    #[inline(always)]
    pub(super) fn push(&mut self, key: f32, child: Child, base: usize) {
        let mut at = self.len;
        while at > base && self.entries[at - 1].0 > key {
            self.entries[at] = self.entries[at - 1];
            at -= 1;
        }
        self.entries[at] = (key, child);
        self.len += 1;
    }

    #[inline(always)]
    pub(super) fn pop(&mut self) -> Option<(f32, Child)> {
        self.len = self.len.checked_sub(1)?;
        Some(self.entries[self.len])
    }

    #[inline(always)]
    pub(super) fn len(&self) -> usize {
        self.len
    }
}

/// The hierarchy.
#[derive(Debug)]
pub(super) struct Bvh {
    /// Origin of the boxes, metres.
    pub(super) center: DVec3,
    /// Box around all triangles, metres.
    pub(super) bounds: Aabb,
    /// Root first; empty where there are no triangles.
    pub(super) nodes: Vec<Node>,
    /// In the order of the leaves.
    pub(super) triangles: Vec<Triangle>,
}

/// A box in the hierarchy's own space, rounded outwards.
pub(super) struct BoxQuery {
    min: [f32; 3],
    max: [f32; 3],
    center: DVec3,
}

impl BoxQuery {
    /// Gives up everything lower than `y`, metres in world space.
    pub(super) fn raise(&mut self, y: f64) {
        self.min[1] = self.min[1].max(round_down(y - self.center.y));
    }
}

impl Bvh {
    /// Visits every triangle whose box overlaps `query` (in doubt too many), higher ones first as
    /// far as the tree knows.
    pub(super) fn visit(
        &self,
        query: &Aabb,
        mut visitor: impl FnMut(&Triangle, &mut BoxQuery) -> ControlFlow<()>,
    ) {
        if self.nodes.is_empty() {
            return;
        }
        let doubt = (self.center.abs() + self.bounds.size()).max_element() * ROUNDING;
        let mut query = BoxQuery {
            // Finite, so that no query reaches the boxes of absent children.
            min: (query.min - doubt - self.center).to_array().map(|x| round_down(x).max(f32::MIN)),
            max: (query.max + doubt - self.center).to_array().map(|x| round_up(x).min(f32::MAX)),
            center: self.center,
        };
        let mut stack = Stack::new();
        while let Some((top, child)) = stack.pop() {
            if top < query.min[1] {
                continue;
            }
            match child.step() {
                Step::Leaf(range) => {
                    for triangle in &self.triangles[range] {
                        if visitor(triangle, &mut query).is_break() {
                            return;
                        }
                    }
                }
                Step::Inner(node) => self.nodes[node].push_overlapping(&query, &mut stack),
            }
        }
    }

    /// Memory of the arrays, bytes.
    pub(super) fn memory_bytes(&self) -> usize {
        self.nodes.capacity() * size_of::<Node>()
            + self.triangles.capacity() * size_of::<Triangle>()
    }
}

impl Node {
    fn push_overlapping(&self, query: &BoxQuery, stack: &mut Stack) {
        let [min, max] = &self.corners;
        let mut overlap = [true; WIDTH];
        for axis in 0..3 {
            for lane in 0..WIDTH {
                overlap[lane] &=
                    (min[axis][lane] <= query.max[axis]) & (max[axis][lane] >= query.min[axis]);
            }
        }
        let base = stack.len();
        for lane in 0..WIDTH {
            if overlap[lane] {
                stack.push(max[1][lane], self.children[lane], base);
            }
        }
    }
}

/// The nearest `f32` not above `x`.
pub(super) fn round_down(x: f64) -> f32 {
    let nearest = x as f32;
    if f64::from(nearest) > x { nearest.next_down() } else { nearest }
}

/// The nearest `f32` not below `x`.
pub(super) fn round_up(x: f64) -> f32 {
    -round_down(-x)
}
