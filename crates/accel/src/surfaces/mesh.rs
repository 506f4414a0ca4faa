//! The triangles of one mesh in its own space, with the hierarchy that finds them.

use super::block::{BLOCK, Block};
use super::build::{Item, Plan};
use super::cuboid::Bounds;
use super::tree::{Child, Step, Tree};
use super::triangle::has_area;
use rayon::prelude::*;
use snowgrain_geometry::TriangleMesh;
use snowgrain_math::{Aabb, DAffine3, DVec3};
use std::sync::Arc;

/// A mesh, however often it is placed.
#[derive(Debug)]
pub(super) struct MeshTree {
    pub(super) mesh: Arc<TriangleMesh>,
    pub(super) tree: Tree,
    /// One a leaf.
    pub(super) blocks: Vec<Block>,
    /// What the hierarchy's boxes are relative to.
    pub(super) center: DVec3,
    /// Box of the triangles that have an area.
    pub(super) bounds: Aabb,
}

impl MeshTree {
    /// The hierarchy over the triangles that have an area. Of triangles with the same three corners
    /// the first is kept.
    ///
    /// # Panics
    /// Beyond 2^30 triangles.
    pub(super) fn new(mesh: Arc<TriangleMesh>) -> Self {
        assert!(mesh.triangles.len() <= Item::CAPACITY, "more than 2^30 triangles");
        let solid = |corners: &[u32; 3]| {
            let corners = corners.map(|v| mesh.positions[v as usize]);
            has_area(&corners).then_some(corners)
        };
        let bounds = mesh
            .triangles
            .par_iter()
            .with_min_len(1 << 12)
            .filter_map(solid)
            .map(|corners| corners.into_iter().fold(Aabb::EMPTY, |b, p| b.including(p)))
            .reduce(|| Aabb::EMPTY, |a, b| a.union(&b));
        let center = if bounds.is_empty() { DVec3::ZERO } else { bounds.center() };
        let mut items: Vec<Item> = mesh
            .triangles
            .par_iter()
            .zip(0u32..mesh.triangles.len() as u32)
            .with_min_len(1 << 12)
            .map(|(corners, index)| {
                let around = solid(corners).map_or(Bounds::EMPTY, |corners| {
                    let b = corners.into_iter().fold(Aabb::EMPTY, |b, p| b.including(p));
                    Bounds::around(&b, center)
                });
                Item::new(around, index)
            })
            .collect();
        items.retain(|item| !item.is_empty());
        let same = |a: u32, b: u32| corner_bits(&mesh, a).cmp(&corner_bits(&mesh, b));
        let built = Plan { leaf_size: BLOCK, same: Some(&same) }.build(items);
        let blocks = built
            .leaves
            .par_iter()
            .with_min_len(1 << 8)
            .map(|leaf| {
                let items = &built.items[leaf.clone()];
                Block::new(&mesh, center, |lane| items[lane].number(), items.len())
            })
            .collect();
        Self { tree: built.tree, blocks, center, bounds, mesh }
    }

    /// Half the size of the box around everything.
    #[inline(always)]
    pub(super) fn half(&self) -> DVec3 {
        // The middle is rounded, so the box is not quite symmetric about it.
        (self.bounds.max - self.center).max(self.center - self.bounds.min)
    }

    /// The largest coordinate along `axis` of all triangles once they are placed, or with `sign`
    /// -1 the largest of its negative: as if all were looked at.
    pub(super) fn reach(&self, transform: &DAffine3, axis: usize, sign: f64, doubt: f64) -> f64 {
        let gradient = transform.matrix3.row(axis) * sign;
        let middle = transform.transform_point3(self.center)[axis] * sign + doubt;
        let mut open: Vec<(f64, Child)> = Vec::new();
        open.extend(self.tree.root.map(|root| (f64::INFINITY, root)));
        let mut best = f64::NEG_INFINITY;
        while let Some((bound, child)) = open.pop() {
            if bound < best {
                continue;
            }
            match child.step() {
                Step::Leaf(leaf) => {
                    for &piece in self.blocks[leaf].pieces() {
                        for p in self.mesh.corners(piece as usize) {
                            best = best.max(transform.transform_point3(p)[axis] * sign);
                        }
                    }
                }
                Step::Inner(node) => {
                    let base = open.len();
                    open.extend(self.tree.nodes[node].children().map(|(bounds, child)| {
                        let [min, max] = bounds.corners().map(|c| DVec3::from(c.map(f64::from)));
                        let bound = (gradient * min).max(gradient * max).element_sum() + middle;
                        (bound, child)
                    }));
                    open[base..].sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
                }
            }
        }
        best
    }

    /// Memory held, bytes, with that of the mesh itself.
    pub(super) fn memory_bytes(&self) -> usize {
        self.tree.memory_bytes()
            + self.blocks.capacity() * size_of::<Block>()
            + self.mesh.positions.capacity() * size_of::<DVec3>()
            + self.mesh.triangles.capacity() * size_of::<[u32; 3]>()
            + self.mesh.coordinates.capacity() * size_of::<[[f32; 2]; 3]>()
    }
}

/// What tells a triangle from others: its corners, in a fixed order.
fn corner_bits(mesh: &TriangleMesh, triangle: u32) -> [[u64; 3]; 3] {
    // Adding 0 makes both zeros one.
    let bits = |p: DVec3| (p + 0.0).to_array().map(f64::to_bits);
    let mut corners = mesh.corners(triangle as usize).map(bits);
    corners.sort_unstable();
    corners
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_triangle_that_is_there_twice_is_kept_once() {
        let positions = vec![DVec3::ZERO, DVec3::X, DVec3::Z, DVec3::X, DVec3::Y];
        let twins = [[0, 1, 2], [2, 3, 0], [1, 0, 2]];
        let mut triangles: Vec<[u32; 3]> = twins.iter().copied().cycle().take(1000).collect();
        triangles.push([0, 1, 4]);
        for count in [2, 5, 1001] {
            let chosen = triangles[1001 - count..].to_vec();
            let mesh = TriangleMesh::new(positions.clone(), chosen).unwrap();
            let tree = MeshTree::new(Arc::new(mesh));
            let mut kept: Vec<u32> = tree.blocks.iter().flat_map(|b| b.pieces().to_vec()).collect();
            kept.sort_unstable();
            assert_eq!(kept, [0, count as u32 - 1]);
        }
    }
}
