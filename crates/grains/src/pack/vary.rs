//! Variants of a pack that fit each other at all faces, so that tiles need not repeat in rows.
//!
//! Near its faces a variant is the pack; further in it is the pack moved by some way along each axis, which is as good
//! a pack as any. Where the two meet, overlaps are pushed apart, and pieces that float are moved until they touch, as at the seam
//! of the pack itself.

use super::relax::Spheres;
use super::{GAP, PackMethod, PeriodicPack, SEAM, TOLERANCE, TOUCH};
use snowgrain_geometry::QuantisedGrain;
use snowgrain_math::DVec3;
use snowgrain_math::sampler::{PathKey, numbers};

/// Variants of a pack, with itself.
pub const VARIANTS: usize = 4;
/// Depth below the faces, in largest radii, in which all variants are the same: a grain that reaches beyond a face
/// and whatever it may overlap.
const FRAME: f64 = 4.0;
/// What tells the random numbers of the ways by which variants are moved from others.
const MOVED: u64 = 0x7a11_ed01;

impl PeriodicPack {
    /// The grains of the pack and of its variants; in each, those of the frame come first. Packs that are too dense for
    /// their parts to be joined without new overlaps have no other variants.
    #[must_use]
    pub fn variants(&self, seed: u64) -> Vec<Vec<QuantisedGrain>> {
        let grains = self.field.grains();
        let (frame, inner): (Vec<_>, Vec<_>) =
            grains.iter().partition(|grain| !self.is_inner(grain.center.map(i64::from)));
        let mut variants = vec![[frame.as_slice(), inner.as_slice()].concat()];
        if !matches!(self.method, PackMethod::Fallen(_)) {
            return variants;
        }
        for number in 1..VARIANTS {
            let moved = numbers(PathKey::new(seed, number as u64, MOVED), 0);
            let way: [i64; 3] = std::array::from_fn(|axis| {
                let part = 0.25 + 0.5 * f64::from(moved[axis]);
                (part * self.period[axis] as f64) as i64
            });
            let moved = grains.iter().filter_map(|grain| {
                let at: [i64; 3] = std::array::from_fn(|axis| {
                    (i64::from(grain.center[axis]) + way[axis]).rem_euclid(self.period[axis])
                });
                let grain = QuantisedGrain { center: at.map(|c| c as i32), ..*grain };
                self.is_inner(at).then_some(grain)
            });
            variants.extend(self.joined(&frame, moved.collect()));
        }
        variants
    }

    fn frame(&self) -> i64 {
        (FRAME * f64::from(self.field.largest_radius_quanta())).ceil() as i64
    }

    fn is_inner(&self, center: [i64; 3]) -> bool {
        let frame = self.frame();
        (0..3).all(|axis| (frame..self.period[axis] - frame).contains(&center[axis]))
    }

    /// A frame and what lies in it, pushed apart; `None` where overlaps are left.
    fn joined(
        &self,
        frame: &[QuantisedGrain],
        inner: Vec<QuantisedGrain>,
    ) -> Option<Vec<QuantisedGrain>> {
        let all = || frame.iter().chain(&inner);
        let mut spheres = Spheres {
            centers: all().map(|g| DVec3::from_array(g.center.map(f64::from))).collect(),
            radii: all().map(|g| f64::from(g.radius) + 0.5 * GAP).collect(),
            period: DVec3::from_array(self.period.map(|edge| edge as f64)),
        };
        let reach = (FRAME + SEAM) * f64::from(self.field.largest_radius_quanta());
        let is_near = |at: &DVec3| {
            (0..3).any(|axis| at[axis] < reach || at[axis] > spheres.period[axis] - reach)
        };
        let mut moves: Vec<bool> = spheres.centers.iter().map(is_near).collect();
        moves[..frame.len()].fill(false);
        let left = spheres.relax(&moves, TOLERANCE);
        spheres.attach(TOUCH, frame.len());
        if left > 2.0 * GAP {
            return None;
        }
        let placed = |(grain, center): (&QuantisedGrain, &DVec3)| {
            let center = center.to_array().map(|c| c.round() as i64);
            let center: [i64; 3] =
                std::array::from_fn(|axis| center[axis].rem_euclid(self.period[axis]));
            QuantisedGrain { center: center.map(|c| c as i32), ..*grain }
        };
        let joined: Vec<QuantisedGrain> = all().zip(&spheres.centers).map(placed).collect();
        // What was pushed into the frame would differ there between the variants.
        let stays = joined[frame.len()..].iter().all(|g| {
            let frame = self.frame() / 4 * 3;
            (0..3).all(|axis| {
                (frame..self.period[axis] - frame).contains(&i64::from(g.center[axis]))
            })
        });
        stays.then_some(joined)
    }
}
