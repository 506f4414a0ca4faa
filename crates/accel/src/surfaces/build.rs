//! Builds the hierarchy: binned surface area heuristic (Wald 2007, "On fast Construction of SAH-based
//! Bounding Volume Hierarchies"), eight children at a time. The order of the input decides nothing
//! but ties, and one thread does it all, so the same triangles give the same tree.

use super::bvh::{Bvh, Child, Corners, Node, WIDTH, round_down, round_up};
use super::triangle::Triangle;
use snowgrain_math::{Aabb, DVec3};
use std::ops::Range;

const BINS: usize = 16;
const LEAF_SIZE: usize = 4;

/// Below this depth ranges are halved by count, which bounds the depth by 10 more levels.
const HEURISTIC_DEPTH: usize = 16;

/// A triangle as the builder sees it.
#[derive(Clone, Copy)]
struct Item {
    bounds: Bounds,
    triangle: u32,
}

/// A box in the hierarchy's own space.
#[derive(Clone, Copy)]
struct Bounds {
    min: [f32; 3],
    max: [f32; 3],
}

impl Bounds {
    const EMPTY: Self = Self { min: [f32::INFINITY; 3], max: [f32::NEG_INFINITY; 3] };

    fn union(&self, other: &Self) -> Self {
        Self {
            min: std::array::from_fn(|i| self.min[i].min(other.min[i])),
            max: std::array::from_fn(|i| self.max[i].max(other.max[i])),
        }
    }

    fn half_area(&self) -> f64 {
        let [x, y, z] = std::array::from_fn(|i| f64::from(self.max[i]) - f64::from(self.min[i]));
        x * y + y * z + z * x
    }

    /// Twice the middle along an axis.
    fn middle(&self, axis: usize) -> f32 {
        self.min[axis] + self.max[axis]
    }
}

/// Part of the items with the box around it.
struct Part {
    range: Range<usize>,
    bounds: Bounds,
}

impl Bvh {
    /// The hierarchy over these triangles, which must have an area.
    ///
    /// # Panics
    /// Beyond 2^28 triangles.
    pub(super) fn new(triangles: Vec<Triangle>) -> Self {
        assert!(triangles.len() <= Child::CAPACITY, "more than 2^28 triangles");
        let bounds = triangles.iter().fold(Aabb::EMPTY, |all, t| all.union(&t.bounds()));
        if triangles.is_empty() {
            return Self { center: DVec3::ZERO, bounds, nodes: Vec::new(), triangles };
        }
        let center = bounds.center();
        let items = triangles
            .iter()
            .zip(0u32..)
            .map(|(triangle, index)| {
                let b = triangle.bounds();
                let bounds = Bounds {
                    min: (b.min - center).to_array().map(round_down),
                    max: (b.max - center).to_array().map(round_up),
                };
                Item { bounds, triangle: index }
            })
            .collect();
        let mut builder = Builder { items, nodes: Vec::new() };
        let all = builder.part(0..triangles.len());
        builder.node(all, 0);
        let sorted = builder.items.iter().map(|item| triangles[item.triangle as usize]).collect();
        builder.nodes.shrink_to_fit();
        Self { center, bounds, nodes: builder.nodes, triangles: sorted }
    }
}

struct Builder {
    items: Vec<Item>,
    nodes: Vec<Node>,
}

impl Builder {
    fn part(&self, range: Range<usize>) -> Part {
        let bounds =
            self.items[range.clone()].iter().fold(Bounds::EMPTY, |all, i| all.union(&i.bounds));
        Part { range, bounds }
    }

    /// Adds the node over `part` and everything below; returns its index.
    fn node(&mut self, part: Part, depth: usize) -> usize {
        let index = self.nodes.len();
        self.nodes.push(Node::EMPTY);
        let parts = self.split_to_children(part, depth);
        let mut node = Node::EMPTY;
        for (lane, part) in parts.into_iter().enumerate() {
            let Part { range, bounds } = &part;
            let [min, max]: &mut [Corners; 2] = &mut node.corners;
            for axis in 0..3 {
                min[axis][lane] = bounds.min[axis];
                max[axis][lane] = bounds.max[axis];
            }
            node.children[lane] = if range.len() <= LEAF_SIZE {
                Child::leaf(range.start, range.len())
            } else {
                Child::inner(self.node(part, depth + 1))
            };
        }
        self.nodes[index] = node;
        index
    }

    /// Splits the largest part, again and again, until there are eight or all are leaves.
    fn split_to_children(&mut self, part: Part, depth: usize) -> Vec<Part> {
        let by_count = depth >= HEURISTIC_DEPTH;
        let mut parts = vec![part];
        while parts.len() < WIDTH {
            let size = |part: &Part| {
                if by_count { part.range.len() as f64 } else { part.bounds.half_area() }
            };
            let largest = (0..parts.len())
                .filter(|&i| parts[i].range.len() > LEAF_SIZE)
                .max_by(|&i, &j| size(&parts[i]).total_cmp(&size(&parts[j])));
            let Some(largest) = largest else { break };
            let range = parts[largest].range.clone();
            let half = range.start + range.len() / 2;
            let middle = if by_count { half } else { self.split(&range).unwrap_or(half) };
            parts[largest] = self.part(range.start..middle);
            parts.push(self.part(middle..range.end));
        }
        parts
    }

    /// Sorts the range into two halves that are cheap to visit; returns where the second begins,
    /// `None` where all middles coincide.
    fn split(&mut self, range: &Range<usize>) -> Option<usize> {
        let items = &mut self.items[range.clone()];
        let (axis, binning, last) = (0..3)
            .filter_map(|axis| {
                let binning = Binning::new(items, axis)?;
                let (cost, last) = binning.best_split(items, axis);
                Some((cost, axis, binning, last))
            })
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .map(|(_, axis, binning, last)| (axis, binning, last))?;
        let mut left = 0;
        for i in 0..items.len() {
            if binning.bin(items[i].bounds.middle(axis)) <= last {
                items.swap(left, i);
                left += 1;
            }
        }
        (left > 0 && left < items.len()).then_some(range.start + left)
    }
}

/// Equal slices of an axis between the outermost middles.
struct Binning {
    start: f64,
    scale: f64,
}

impl Binning {
    fn new(items: &[Item], axis: usize) -> Option<Self> {
        let (min, max) = items.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(lo, hi), i| {
            let m = i.bounds.middle(axis);
            (lo.min(m), hi.max(m))
        });
        let extent = f64::from(max) - f64::from(min);
        (extent > 0.0)
            .then(|| Self { start: f64::from(min), scale: BINS as f64 * (1.0 - 1e-9) / extent })
    }

    fn bin(&self, middle: f32) -> usize {
        (((f64::from(middle) - self.start) * self.scale) as usize).min(BINS - 1)
    }

    /// The least cost of a split and the last bin on its left.
    fn best_split(&self, items: &[Item], axis: usize) -> (f64, usize) {
        let mut bins = [(Bounds::EMPTY, 0usize); BINS];
        for item in items {
            let bin = &mut bins[self.bin(item.bounds.middle(axis))];
            *bin = (bin.0.union(&item.bounds), bin.1 + 1);
        }
        let mut right = [0.0; BINS];
        let mut side = (Bounds::EMPTY, 0);
        for i in (1..BINS).rev() {
            side = (side.0.union(&bins[i].0), side.1 + bins[i].1);
            right[i] = cost(&side);
        }
        let mut best = (f64::INFINITY, 0);
        let mut side = (Bounds::EMPTY, 0);
        for i in 0..BINS - 1 {
            side = (side.0.union(&bins[i].0), side.1 + bins[i].1);
            let total = cost(&side) + right[i + 1];
            if total < best.0 {
                best = (total, i);
            }
        }
        best
    }
}

fn cost((bounds, count): &(Bounds, usize)) -> f64 {
    if *count == 0 { 0.0 } else { bounds.half_area() * *count as f64 }
}
