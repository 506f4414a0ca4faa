//! Up to eight triangles of a mesh in rounded coordinates: tells quickly which of them may matter.
//!
//! A query looks at a block through linear functions of the place, rows: the world's axes, or the
//! two directions across a ray. Each comes with a bound of its error, and what is turned away is
//! turned away beyond it; the rest is tested in `f64` on the mesh's own vertices.

use super::cuboid::round_down;
use fearless_simd::{Simd, f32x8, prelude::*};
use snowgrain_geometry::TriangleMesh;
use snowgrain_math::{Aabb, DVec3};

/// Triangles in a block.
pub(super) const BLOCK: usize = 8;

/// Largest rounded coordinate.
const LARGEST: f64 = u16::MAX as f64;

/// More than the roundings of a row in `f32`, relative to the largest term.
const ROW_ROUNDING: f32 = 1.0 / (1 << 21) as f32;

/// Triangles that lie together, their corners rounded to a lattice of their own.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub(super) struct Block {
    /// Corner of the lattice, relative to the middle of the mesh.
    origin: [f32; 3],
    /// Binary logarithms of the lattice's steps.
    exponents: [i8; 3],
    count: u8,
    /// Corner, axis, triangle.
    corners: [[[u16; BLOCK]; 3]; 3],
    /// Indices of the triangles in the mesh.
    pieces: [u32; BLOCK],
    /// Index in the mesh of the first of their vertices, and how much farther each corner's is; a
    /// block whose vertices lie too far apart in the mesh has [`Self::FAR_APART`].
    first_vertex: u32,
    vertices: [[u16; 3]; BLOCK],
}

/// A linear function of the place, relative to the middle of the mesh.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row {
    pub(super) gradient: DVec3,
    pub(super) offset: f64,
    /// Bound of the error of `offset` and of what is compared with the row.
    pub(super) doubt: f64,
}

/// A row at the corners of a block's triangles.
pub(super) struct Seen<S: Simd> {
    corners: [f32x8<S>; 3],
    /// Bound of their errors.
    error: f32,
    /// Bound of their sizes.
    size: f32,
}

/// The corners of a block's triangles, in steps of its lattice.
type Steps<S> = [[f32x8<S>; 3]; 3];

/// A falling sphere, as blocks see it.
pub(super) struct Falling {
    /// Across the fall, from its line, and up along it.
    pub(super) across: [Row; 2],
    pub(super) along: Row,
    pub(super) radius: f64,
    /// The first contact so far: height of the centre, normal.
    pub(super) contact: Option<(f64, DVec3)>,
}

impl Block {
    /// Stands for vertices that are found through the mesh's triangles only.
    const FAR_APART: u32 = u32::MAX;

    /// The block of these triangles of the mesh, at most [`BLOCK`].
    pub(super) fn new(
        mesh: &TriangleMesh,
        center: DVec3,
        pieces: impl Fn(usize) -> u32,
        count: usize,
    ) -> Self {
        let mut triangles = [[DVec3::ZERO; 3]; BLOCK];
        for (lane, corners) in triangles[..count].iter_mut().enumerate() {
            *corners = mesh.corners(pieces(lane) as usize).map(|p| p - center);
        }
        let triangles = &triangles[..count];
        let bounds = triangles.iter().flatten().fold(Aabb::EMPTY, |bounds, &p| bounds.including(p));
        let origin = bounds.min.to_array().map(round_down);
        let exponents = std::array::from_fn(|axis| {
            exponent_of((bounds.max[axis] - f64::from(origin[axis])) / LARGEST)
        });
        let mut block = Self {
            origin,
            exponents,
            count: count as u8,
            corners: [[[0; BLOCK]; 3]; 3],
            pieces: [0; BLOCK],
            first_vertex: Self::FAR_APART,
            vertices: [[0; 3]; BLOCK],
        };
        let step = block.step();
        for (lane, corners) in triangles.iter().enumerate() {
            for (corner, axis) in (0..9).map(|i| (i / 3, i % 3)) {
                let steps = (corners[corner][axis] - f64::from(origin[axis])) / step[axis];
                block.corners[corner][axis][lane] = (steps + 0.5).min(LARGEST) as u16;
            }
            block.pieces[lane] = pieces(lane);
        }
        block.set_vertices(mesh);
        block
    }

    fn set_vertices(&mut self, mesh: &TriangleMesh) {
        let vertices = |piece: &u32| mesh.triangles[*piece as usize];
        let first = self.pieces().iter().flat_map(vertices).min().unwrap_or(0);
        let last = self.pieces().iter().flat_map(vertices).max().unwrap_or(0);
        if last - first > u32::from(u16::MAX) {
            return;
        }
        self.first_vertex = first;
        for lane in 0..usize::from(self.count) {
            self.vertices[lane] = vertices(&self.pieces[lane]).map(|v| (v - first) as u16);
        }
    }

    /// Corners of one of its triangles, as the mesh has them.
    #[inline(always)]
    pub(super) fn corners_in(&self, mesh: &TriangleMesh, lane: usize) -> [DVec3; 3] {
        let [a, b, c] = if self.first_vertex == Self::FAR_APART {
            mesh.triangles[self.pieces[lane] as usize]
        } else {
            let [a, b, c] = self.vertices[lane];
            let at = |v: u16| self.first_vertex + u32::from(v);
            [at(a), at(b), at(c)]
        };
        let positions = &mesh.positions;
        [positions[a as usize], positions[b as usize], positions[c as usize]]
    }

    /// Index in the mesh of one of its triangles.
    #[inline(always)]
    pub(super) fn piece(&self, lane: usize) -> u32 {
        self.pieces[lane]
    }

    /// Indices in the mesh of its triangles.
    pub(super) fn pieces(&self) -> &[u32] {
        &self.pieces[..usize::from(self.count)]
    }

    #[inline(always)]
    fn step(&self) -> DVec3 {
        let [x, y, z] = self.exponents;
        DVec3::new(power_of_two(x), power_of_two(y), power_of_two(z))
    }

    #[inline(always)]
    fn origin(&self) -> DVec3 {
        let [x, y, z] = self.origin;
        DVec3::new(f64::from(x), f64::from(y), f64::from(z))
    }

    /// A bit for each triangle that is there.
    #[inline(always)]
    fn present(&self) -> u64 {
        (1 << self.count) - 1
    }

    /// The triangles that a ray may meet; the rows look across it.
    #[inline(always)]
    pub(super) fn along<S: Simd>(&self, simd: S, across: &[Row; 2]) -> u64 {
        let steps = self.steps(simd);
        let x = self.seen(simd, &steps, &across[0]);
        let y = self.seen(simd, &steps, &across[1]);
        let [ax, bx, cx] = x.corners;
        let [ay, by, cy] = y.corners;
        let u = cx * by - cy * bx;
        let v = ax * cy - ay * cx;
        let w = bx * ay - by * ax;
        // Each is a difference of two products of numbers that are off by up to their errors.
        let error = 2.5 * (x.size * y.error + y.size * x.error);
        let low = u.min(v).min(w).simd_lt(f32x8::splat(simd, -error)).to_bitmask();
        let high = u.max(v).max(w).simd_gt(f32x8::splat(simd, error)).to_bitmask();
        self.present() & !(low & high)
    }

    /// The triangles that may come within `half` of where all three rows are 0, along each row.
    #[inline(always)]
    pub(super) fn within<S: Simd>(&self, simd: S, rows: &[Row; 3], half: DVec3) -> u64 {
        let steps = self.steps(simd);
        let mut near = self.present();
        for axis in 0..3 {
            near &= self.seen(simd, &steps, &rows[axis]).within(simd, half[axis]);
        }
        near
    }

    /// The triangles that the falling sphere may touch at the height of its contact or before.
    #[inline(always)]
    pub(super) fn below<S: Simd>(&self, simd: S, falling: &Falling) -> u64 {
        let steps = self.steps(simd);
        let base = falling.along.gradient.dot(self.origin()) + falling.along.offset;
        let along = Row { offset: falling.along.offset - base, ..falling.along };
        let x = self.seen(simd, &steps, &falling.across[0]);
        let y = self.seen(simd, &steps, &along);
        let z = self.seen(simd, &steps, &falling.across[1]);
        let near = x.within(simd, falling.radius) & z.within(simd, falling.radius);
        let near = near & self.present();
        let Some((height, normal)) = falling.contact else { return near };
        if near == 0 {
            return 0;
        }
        let seen = [x, y, z];
        let center = DVec3::Y * (height - base);
        let bottom = center - normal * falling.radius;
        near & !Seen::under_plane(simd, &seen, bottom, normal)
            & !Seen::clear_of(simd, &seen, center.y as f32, falling.radius as f32)
    }

    // In the kernels below arrays are filled by loops: closures over them are not always inlined,
    // and SIMD outside its level's function is slow.

    #[inline(always)]
    fn steps<S: Simd>(&self, simd: S) -> Steps<S> {
        let mut steps = [[f32x8::splat(simd, 0.0); 3]; 3];
        for (steps, corners) in steps.iter_mut().zip(&self.corners) {
            for (steps, rounded) in steps.iter_mut().zip(corners) {
                let mut lanes = [0.0; BLOCK];
                for lane in 0..BLOCK {
                    lanes[lane] = f32::from(rounded[lane]);
                }
                *steps = f32x8::from_slice(simd, &lanes);
            }
        }
        steps
    }

    #[inline(always)]
    fn seen<S: Simd>(&self, simd: S, steps: &Steps<S>, row: &Row) -> Seen<S> {
        let base = (row.gradient.dot(self.origin()) + row.offset) as f32;
        let slope = (row.gradient * self.step()).as_vec3();
        let [mx, my, mz] = splat3(simd, slope.x, slope.y, slope.z);
        let base_lanes = f32x8::splat(simd, base);
        let mut corners = [base_lanes; 3];
        for corner in 0..3 {
            let [x, y, z] = steps[corner];
            corners[corner] = x * mx + y * my + z * mz + base_lanes;
        }
        // Each coordinate is off by up to half a step.
        let step = slope.x.abs() + slope.y.abs() + slope.z.abs();
        let size = base.abs() + step * LARGEST as f32;
        Seen { corners, error: 0.5 * step + size * ROW_ROUNDING + row.doubt as f32, size }
    }
}

#[inline(always)]
fn splat3<S: Simd>(simd: S, x: f32, y: f32, z: f32) -> [f32x8<S>; 3] {
    [f32x8::splat(simd, x), f32x8::splat(simd, y), f32x8::splat(simd, z)]
}

impl<S: Simd> Seen<S> {
    #[inline(always)]
    fn within(&self, simd: S, half: f64) -> u64 {
        let [a, b, c] = self.corners;
        let half = half as f32 * (1.0 + ROW_ROUNDING) + self.error;
        let below = a.min(b).min(c).simd_le(f32x8::splat(simd, half)).to_bitmask();
        below & a.max(b).max(c).simd_ge(f32x8::splat(simd, -half)).to_bitmask()
    }

    /// The triangles under a plane that touches the sphere from below: it does not meet them
    /// higher up.
    #[inline(always)]
    fn under_plane(simd: S, seen: &[Self; 3], point: DVec3, normal: DVec3) -> u64 {
        if normal.y <= 0.0 {
            return 0;
        }
        let [nx, ny, nz] = splat3(simd, normal.x as f32, normal.y as f32, normal.z as f32);
        let [x, y, z] = seen;
        let mut highest = f32x8::splat(simd, f32::NEG_INFINITY);
        for corner in 0..3 {
            let height = x.corners[corner] * nx + y.corners[corner] * ny + z.corners[corner] * nz;
            highest = highest.max(height);
        }
        let level = normal.dot(point);
        let size = x.size + y.size + z.size + point.abs().element_sum() as f32;
        let error = x.error + y.error + z.error + size * ROW_ROUNDING;
        highest.simd_lt(f32x8::splat(simd, level as f32 - error)).to_bitmask()
    }

    /// The triangles whose own plane, or whose top, the sphere clears when its centre is at
    /// `height`: it falls on for longer than that.
    #[inline(always)]
    fn clear_of(simd: S, seen: &[Self; 3], height: f32, radius: f32) -> u64 {
        let [x, y, z] = seen;
        let (ax, ay, az) = (x.corners[0], y.corners[0], z.corners[0]);
        let error = x.error + y.error + z.error;
        let reach = radius * (1.0 + ROW_ROUNDING) + error;
        let height_lanes = f32x8::splat(simd, height);
        let top = ay.max(y.corners[1]).max(y.corners[2])
            + f32x8::splat(simd, reach + height.abs() * ROW_ROUNDING);
        let above_top = top.simd_lt(height_lanes).to_bitmask();
        let e = [x.corners[1] - ax, y.corners[1] - ay, z.corners[1] - az];
        let f = [x.corners[2] - ax, y.corners[2] - ay, z.corners[2] - az];
        let nx = e[1] * f[2] - e[2] * f[1];
        let ny = e[2] * f[0] - e[0] * f[2];
        let nz = e[0] * f[1] - e[1] * f[0];
        let rise = height_lanes - ay;
        let above = rise * ny - ax * nx - az * nz;
        let length = (nx * nx + ny * ny + nz * nz).sqrt();
        // A component of the normal is a difference of products of edges, each off by two errors.
        let edges = size1(e) + size1(f) + f32x8::splat(simd, error);
        let tilt = edges * f32x8::splat(simd, 4.0 * error);
        let away = size1([ax, rise, az]) + f32x8::splat(simd, 2.0 * reach);
        let clear = length * f32x8::splat(simd, reach) + tilt * away;
        let upward = ny.simd_gt(tilt) & above.simd_gt(clear);
        let downward = ny.simd_lt(-tilt) & (-above).simd_gt(clear);
        above_top | (upward | downward).to_bitmask()
    }
}

/// Sum of the components' sizes.
#[inline(always)]
fn size1<S: Simd>([x, y, z]: [f32x8<S>; 3]) -> f32x8<S> {
    x.abs() + y.abs() + z.abs()
}

/// The least exponent whose power of two is not below `x`, of those that an `f32` has.
fn exponent_of(x: f64) -> i8 {
    let floor = (x.to_bits() >> 52) as i32 - 1023;
    let is_power = x.to_bits().trailing_zeros() >= 52;
    (floor + i32::from(!is_power)).clamp(-126, 127) as i8
}

#[inline(always)]
fn power_of_two(exponent: i8) -> f64 {
    f64::from_bits((i64::from(exponent) + 1023).cast_unsigned() << 52)
}
