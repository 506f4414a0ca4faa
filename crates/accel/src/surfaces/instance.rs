//! A mesh placed in the world.
//!
//! The hierarchy of the mesh is searched in the mesh's own space, generously; what is found is
//! decided in the world, on the placed corners of the triangles. So an instance is the same, bit
//! for bit, as a copy of its triangles, watertight too, and a mesh costs its triangles once.

use super::beam::Beam;
use super::block::{Block, Falling, Row};
use super::contact::{Drop, Touch};
use super::cuboid::BoxQuery;
use super::mesh::MeshTree;
use super::nearest::Nearest;
use super::tree::Stack;
use super::triangle::{ROUNDING, ShearedRay, Triangle};
use super::{SphereContact, SurfaceId, keep_higher};
use fearless_simd::Simd;
use snowgrain_math::{Aabb, DAffine3, DMat3, DVec3, Ray};

/// Largest product of the sizes of a transform and its inverse with which a mesh is placed; beyond
/// it roundings in the mesh's own space would let every box be searched.
const LARGEST_CONDITION: f64 = 1e6;

/// A placed mesh.
#[derive(Clone, Debug)]
pub(super) struct Instance {
    pub(super) object: u32,
    /// Index of the mesh.
    pub(super) mesh: usize,
    transform: DAffine3,
    inverse: DMat3,
    /// Bound of the world coordinates of all corners.
    size: f64,
}

/// Whether a placement can be undone without losing more than a few digits.
pub(super) fn is_well_conditioned(matrix: &DMat3) -> bool {
    let size = |m: &DMat3| m.to_cols_array().into_iter().fold(0.0, |size, x| x.abs().max(size));
    let condition = size(matrix) * size(&matrix.inverse());
    // False for what is not a number.
    condition <= LARGEST_CONDITION
}

impl Instance {
    /// The mesh placed by a transform that [`is_well_conditioned`].
    pub(super) fn new(object: u32, mesh: usize, tree: &MeshTree, transform: &DAffine3) -> Self {
        let corner = tree.center.abs() + tree.half();
        let size = absolute(&transform.matrix3) * corner + transform.translation.abs();
        let inverse = transform.matrix3.inverse();
        Self { object, mesh, transform: *transform, inverse, size: size.max_element() }
    }

    /// The same mesh, its place turned about the origin.
    pub(super) fn turned(&self, tree: &MeshTree, turn: &DMat3) -> Self {
        let turned = DAffine3 { matrix3: *turn, translation: DVec3::ZERO };
        Self::new(self.object, self.mesh, tree, &(turned * self.transform))
    }

    /// Box around the placed corners, the same as if all were looked at.
    pub(super) fn bounds(&self, tree: &MeshTree) -> Aabb {
        if tree.bounds.is_empty() {
            return Aabb::EMPTY;
        }
        let rows = self.transform.matrix3.transpose();
        let is_straight = [rows.x_axis, rows.y_axis, rows.z_axis]
            .iter()
            .all(|row| row.to_array().iter().filter(|&&x| x != 0.0).count() <= 1);
        if is_straight {
            // Each world coordinate follows one of the mesh's, and rounding keeps the order.
            let [a, b] =
                [tree.bounds.min, tree.bounds.max].map(|p| self.transform.transform_point3(p));
            return Aabb::new(a.min(b), a.max(b));
        }
        let doubt = self.size * ROUNDING;
        let reach = |sign: f64| {
            DVec3::from([0, 1, 2].map(|axis| tree.reach(&self.transform, axis, sign, doubt)))
        };
        Aabb::new(-reach(-1.0), reach(1.0))
    }

    /// A triangle in the world.
    #[inline(always)]
    fn triangle(&self, tree: &MeshTree, block: &Block, lane: usize) -> Triangle {
        let [a, b, c] = block.corners_in(&tree.mesh, lane);
        let place = |p| self.transform.transform_point3(p);
        Triangle {
            corners: [place(a), place(b), place(c)],
            id: SurfaceId { object: self.object, piece: block.piece(lane) },
        }
    }

    /// A point in the hierarchy's space.
    #[inline(always)]
    fn local(&self, tree: &MeshTree, p: DVec3) -> DVec3 {
        self.inverse * (p - self.transform.translation) - tree.center
    }

    /// Bound of what roundings move in the hierarchy's space, where the world's coordinates go up
    /// to `size`.
    #[inline(always)]
    fn slack(&self, size: f64) -> DVec3 {
        let m = absolute(&self.inverse);
        (m.x_axis + m.y_axis + m.z_axis) * ((self.size + size) * ROUNDING)
    }

    /// Offers to `nearest` what the ray meets.
    #[inline(always)]
    pub(super) fn intersect<S: Simd>(
        &self,
        simd: S,
        tree: &MeshTree,
        (ray, sheared): (&Ray, &ShearedRay),
        exclude: Option<SurfaceId>,
        nearest: &mut Nearest,
    ) {
        let origin_size = ray.origin.abs().max_element();
        let origin = self.local(tree, ray.origin);
        let direction = self.inverse * ray.direction;
        let spread = self.slack(origin_size);
        let Some(beam) = Beam::new(tree.half(), origin, direction, spread, nearest.limit()) else {
            return;
        };
        let doubt = (self.size + origin_size) * ROUNDING;
        let across =
            [self.row_across(tree, sheared, 0, doubt), self.row_across(tree, sheared, 1, doubt)];
        let mut limit = beam.limit(nearest.limit());
        let mut stack = Stack::new();
        let mut walk = tree.tree.walk(&tree.blocks, &mut stack);
        while let Some(block) = walk.next_along(simd, &beam, limit) {
            let mut lanes = block.along(simd, &across);
            while lanes != 0 {
                let triangle = self.triangle(tree, block, lanes.trailing_zeros() as usize);
                lanes &= lanes - 1;
                if let Some(t) = triangle.intersect(sheared)
                    && Some(triangle.id) != exclude
                    && nearest.is_met_before(t, triangle.id)
                    && triangle.has_area()
                {
                    nearest.keep_triangle(t, &triangle);
                    limit = beam.limit(t);
                }
            }
        }
    }

    /// One of the two directions across a ray, sheared as the ray is.
    #[inline(always)]
    fn row_across(&self, tree: &MeshTree, ray: &ShearedRay, i: usize, doubt: f64) -> Row {
        let (axis, main) = (ray.axes[i], ray.axes[2]);
        let rows = self.transform.matrix3.transpose();
        let rows = [rows.x_axis, rows.y_axis, rows.z_axis];
        let from = self.transform.transform_point3(tree.center) - ray.origin;
        Row {
            gradient: rows[axis] - rows[main] * ray.shear[i],
            offset: from[axis] - from[main] * ray.shear[i],
            doubt,
        }
    }

    /// The world's axes, from `origin`.
    #[inline(always)]
    fn rows(&self, tree: &MeshTree, origin: DVec3, size: f64) -> [Row; 3] {
        let rows = self.transform.matrix3.transpose();
        let offset = self.transform.transform_point3(tree.center) - origin;
        let doubt = (self.size + size) * ROUNDING;
        [
            Row { gradient: rows.x_axis, offset: offset.x, doubt },
            Row { gradient: rows.y_axis, offset: offset.y, doubt },
            Row { gradient: rows.z_axis, offset: offset.z, doubt },
        ]
    }

    /// Whether a triangle has a point in the box.
    #[inline(always)]
    pub(super) fn may_cross<S: Simd>(&self, simd: S, tree: &MeshTree, bounds: &Aabb) -> bool {
        let (center, half) = (bounds.center(), bounds.size() * 0.5);
        let size = bounds.min.abs().max(bounds.max.abs()).max_element();
        let reach = absolute(&self.inverse) * half + self.slack(size);
        let query = BoxQuery::new(self.local(tree, center), reach);
        let rows = self.rows(tree, center, size);
        let mut stack = Stack::new();
        let mut walk = tree.tree.walk(&tree.blocks, &mut stack);
        while let Some(block) = walk.next_within(simd, &query) {
            let mut lanes = block.within(simd, &rows, half);
            while lanes != 0 {
                let triangle = self.triangle(tree, block, lanes.trailing_zeros() as usize);
                lanes &= lanes - 1;
                if triangle.overlaps(bounds) && triangle.has_area() {
                    return true;
                }
            }
        }
        false
    }

    /// Calls `found` with the triangles that may be nearer to `center` than `reach`.
    #[inline(always)]
    pub(super) fn near<S: Simd>(
        &self,
        simd: S,
        tree: &MeshTree,
        (center, reach): (DVec3, f64),
        mut found: impl FnMut(f64, Touch, SurfaceId),
    ) {
        let size = center.abs().max_element();
        let half = self.row_lengths() * reach + self.slack(size);
        let query = BoxQuery::new(self.local(tree, center), half);
        let rows = self.rows(tree, center, size);
        let mut stack = Stack::new();
        let mut walk = tree.tree.walk(&tree.blocks, &mut stack);
        while let Some(block) = walk.next_within(simd, &query) {
            let mut lanes = block.within(simd, &rows, DVec3::splat(reach));
            while lanes != 0 {
                let triangle = self.triangle(tree, block, lanes.trailing_zeros() as usize);
                lanes &= lanes - 1;
                if triangle.has_area() {
                    let (touch, distance) = triangle.touch(center);
                    found(distance, touch, triangle.id);
                }
            }
        }
    }

    /// Keeps in `first` what the falling sphere touches before.
    #[inline(always)]
    pub(super) fn drop_sphere<S: Simd>(
        &self,
        simd: S,
        tree: &MeshTree,
        drop: &Drop,
        first: &mut Option<SphereContact>,
    ) {
        let start = drop.start();
        let size = start.abs().max_element() + drop.radius;
        let origin = self.local(tree, start);
        let direction = self.inverse * DVec3::NEG_Y;
        let spread = self.row_lengths() * drop.radius + self.slack(size);
        let depth = |first: &Option<SphereContact>| drop.start_y - drop.floor(first.as_ref());
        let Some(beam) = Beam::new(tree.half(), origin, direction, spread, depth(first)) else {
            return;
        };
        let [x, y, z] = self.rows(tree, DVec3::new(drop.x, 0.0, drop.z), size);
        let mut falling = Falling { across: [x, z], along: y, radius: drop.radius, contact: None };
        let touched = |held: &SphereContact| (held.center_y, held.normal);
        falling.contact = first.as_ref().map(touched);
        let mut stack = Stack::new();
        let mut walk = tree.tree.walk(&tree.blocks, &mut stack);
        let mut limit = beam.limit(depth(first));
        while let Some(block) = walk.next_along(simd, &beam, limit) {
            let mut lanes = block.below(simd, &falling);
            while lanes != 0 {
                let triangle = self.triangle(tree, block, lanes.trailing_zeros() as usize);
                lanes &= lanes - 1;
                let least = drop.floor(first.as_ref());
                if triangle.is_beside(drop, least) || !triangle.has_area() {
                    continue;
                }
                let Some((y, touch)) = triangle.drop_sphere(drop) else { continue };
                if keep_higher(first, SphereContact::new(y, touch, triangle.id)) {
                    falling.contact = first.as_ref().map(touched);
                    limit = beam.limit(depth(first));
                    lanes &= block.below(simd, &falling);
                }
            }
        }
    }

    /// How far a world's unit reaches along each axis of the mesh's space.
    #[inline(always)]
    fn row_lengths(&self) -> DVec3 {
        let m = &self.inverse;
        let squares = m.x_axis * m.x_axis + m.y_axis * m.y_axis + m.z_axis * m.z_axis;
        DVec3::new(squares.x.sqrt(), squares.y.sqrt(), squares.z.sqrt())
    }
}

#[inline(always)]
fn absolute(m: &DMat3) -> DMat3 {
    DMat3::from_cols(m.x_axis.abs(), m.y_axis.abs(), m.z_axis.abs())
}
