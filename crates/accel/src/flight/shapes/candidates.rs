//! Grains whose bounding spheres paths in air have come to: eight at a time, where they lie between parallel faces.

use super::ShapeFlight;
use super::body::ELLIPSOID;
use super::lane::{BodyPart, Entry, Lane};
use super::slabs::{Bodies, D, Vectors, WIDTH, Within, within};
use crate::grain_grid::{AXES, ROUND, ShapeWord, Slabs};
use fearless_simd::prelude::*;
use snowgrain_math::DVec3;

/// A grain that a path may meet.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate {
    lane: usize,
    /// Centre of the grain from the corner of the lane's home cell.
    center: DVec3,
    word: u64,
    block: usize,
    slot: usize,
}

/// Eight candidates as the vectors want them.
struct Eight {
    /// From the grain to the origin of the stretch.
    origin: [[f64; WIDTH]; 3],
    direction: [[f64; WIDTH]; 3],
    quaternion: [[f64; WIDTH]; 4],
    radius: [f64; WIDTH],
    half: [[f64; WIDTH]; AXES],
    shrink: [[f64; WIDTH]; 2],
    has_x: bool,
    has_round: bool,
}

impl Eight {
    const NONE: Self = Self {
        origin: [[0.0; WIDTH]; 3],
        direction: [[0.0; WIDTH]; 3],
        quaternion: [[0.0; WIDTH]; 4],
        radius: [1.0; WIDTH],
        half: [[1.0; WIDTH]; AXES],
        shrink: [[0.0; WIDTH]; 2],
        has_x: false,
        has_round: false,
    };

    #[inline(always)]
    fn set(&mut self, at: usize, lane: &Lane, center: DVec3, (word, slabs): (ShapeWord, &Slabs)) {
        let origin = lane.origin - center;
        for axis in 0..3 {
            self.origin[axis][at] = origin[axis];
            self.direction[axis][at] = lane.direction[axis];
        }
        let quaternion = word.shape().quaternion();
        for (row, component) in self.quaternion.iter_mut().zip(quaternion) {
            row[at] = component;
        }
        self.radius[at] = word.radius();
        for (row, half) in self.half.iter_mut().zip(slabs.half) {
            row[at] = half;
        }
        self.shrink[0][at] = slabs.shrink[0];
        self.shrink[1][at] = slabs.shrink[1];
        self.has_x |= slabs.half[AXES - 1] < f64::INFINITY;
        self.has_round |= slabs.shrink[0] > 0.0;
    }

    /// What of the lines lies within the grains, in radii; each as the placement of one grain would say.
    #[inline(always)]
    fn within<S: Simd>(&self, simd: S) -> Within<S> {
        let axes = self.axes(simd);
        let inverse = D::<S>::splat(simd, 1.0) / D::<S>::from_slice(simd, &self.radius);
        let origin = turned_back(axes, Vectors::load(simd, &self.origin, 0)).scaled(inverse);
        let direction = turned_back(axes, Vectors::load(simd, &self.direction, 0));
        let flags = (self.has_x, self.has_round);
        let bodies = Bodies::load(simd, (&self.half, &self.shrink), 0, flags);
        within(simd, &bodies, origin, direction)
    }

    /// Axes of the grains in the world, as [`snowgrain_geometry::GrainShape::rotation`] decodes them.
    #[inline(always)]
    fn axes<S: Simd>(&self, simd: S) -> [Vectors<S>; 3] {
        let one = D::<S>::splat(simd, 1.0);
        let [qx, qy, qz, qw] = &self.quaternion;
        let (x, y) = (D::<S>::from_slice(simd, qx), D::<S>::from_slice(simd, qy));
        let (z, w) = (D::<S>::from_slice(simd, qz), D::<S>::from_slice(simd, qw));
        let (x2, y2, z2) = (x + x, y + y, z + z);
        let (xx, yy, zz) = (x * x2, y * y2, z * z2);
        let (xy, xz, yz) = (x * y2, x * z2, y * z2);
        let (wx, wy, wz) = (w * x2, w * y2, w * z2);
        [
            Vectors(one - (yy + zz), xy + wz, xz - wy),
            Vectors(xy - wz, one - (xx + zz), yz + wx),
            Vectors(xz + wy, yz - wx, one - (xx + yy)),
        ]
    }
}

/// Vectors in the spaces of the grains whose axes are given.
#[inline(always)]
fn turned_back<S: Simd>([x, y, z]: [Vectors<S>; 3], v: Vectors<S>) -> Vectors<S> {
    Vectors(x.dot(v), y.dot(v), z.dot(v))
}

impl ShapeFlight<'_> {
    /// Notes the grains that a path in air may meet before `limit`, where it leaves the cell, and looks at once at those
    /// of other shapes.
    #[inline(always)]
    pub(super) fn gather<S: Simd>(
        &mut self,
        simd: S,
        (index, limit): (usize, f64),
        candidates: &mut Vec<Candidate>,
    ) {
        let lane = &self.lanes[index];
        let mut nearest = lane.nearest;
        self.for_each_near(simd, lane, limit, |block, slot| {
            let word = self.shapes.blocks[block][slot];
            let prototype = ShapeWord::of_slot(word).shape().prototype();
            if self.shapes.prototypes[prototype].slabs.is_none() {
                nearest = self.nearer(lane, (block, slot), nearest);
            } else {
                let center = self.center(lane, block, slot);
                if lane.leaving != Some(BodyPart { center, word, part: 0 }) {
                    candidates.push(Candidate { lane: index, center, word, block, slot });
                }
            }
            nearest
        });
        self.lanes[index].nearest = nearest;
    }

    /// Looks at candidates: of each path the nearest that it enters, the first of two that it enters in one point.
    #[inline(always)]
    pub(super) fn meet<S: Simd>(&mut self, simd: S, candidates: &[Candidate]) {
        let mut eight = Eight::NONE;
        for some in candidates.chunks(WIDTH) {
            (eight.has_x, eight.has_round) = (false, false);
            for (at, candidate) in some.iter().enumerate() {
                let word = ShapeWord::of_slot(candidate.word);
                let Some(slabs) = &self.shapes.prototypes[word.shape().prototype()].slabs else {
                    continue;
                };
                eight.set(at, &self.lanes[candidate.lane], candidate.center, (word, slabs));
            }
            let Within { enter, leave, by } = eight.within(simd);
            let radius = D::<S>::from_slice(simd, &eight.radius);
            let (at, gone) = (enter * radius, leave * radius);
            let met = enter.simd_lt(leave).to_bitmask();
            let (at, gone, enter, by) =
                (at.as_slice(), gone.as_slice(), enter.as_slice(), by.as_slice());
            for (i, candidate) in some.iter().enumerate() {
                let lane = &mut self.lanes[candidate.lane];
                let is_nearest = lane.nearest.is_none_or(|nearest| at[i] < nearest.at);
                if (met >> i & 1 != 0) & (gone[i] > lane.travelled) & is_nearest {
                    let Candidate { center, word, block, slot, .. } = *candidate;
                    let body = BodyPart { center, word, part: 0 };
                    let face = Some(by[i]);
                    lane.nearest =
                        Some(Entry { at: at[i], at_radii: enter[i], body, block, slot, face });
                }
            }
        }
    }
}

/// The part of the surface of a body that a face is.
#[inline(always)]
pub(super) fn part_of(slabs: &Slabs, face: f64) -> u16 {
    if face == ROUND { ELLIPSOID } else { slabs.face(face) }
}
