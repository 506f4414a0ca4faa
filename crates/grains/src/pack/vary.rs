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
/// Depth below the faces, in largest radii, in which grains stay where they are, so that all variants are the same where grains
/// reach beyond a face: to half of it.
const FRAME: f64 = 2.0;
/// What tells the random numbers of the ways by which variants are moved from others.
const MOVED: u64 = 0x7a11_ed01;

/// Of the spheres from number `first` on, those that still overlap others: one of each pair.
fn crowded(spheres: &Spheres, first: usize) -> Vec<bool> {
    let near = spheres.neighbours(0.0);
    let mut crowded = vec![false; spheres.centers.len()];
    for (a, near) in near.iter().enumerate().skip(first) {
        crowded[a] = near.iter().map(|&other| other as usize).any(|b| {
            let depth = spheres.radii[a] + spheres.radii[b] - spheres.distance(a, b);
            depth > 2.0 * GAP && (b < first || (b < a && !crowded[b]))
        });
    }
    crowded.split_off(first)
}

impl PeriodicPack {
    /// The grains of the pack and of its variants; in each, those of the frame come first. Packs that are too dense for
    /// their parts to be joined without new overlaps have no other variants.
    #[must_use]
    pub fn variants(&self, seed: u64) -> Vec<Vec<QuantisedGrain>> {
        let grains = self.field.grains();
        let depth = self.frame();
        let (frame, inner): (Vec<_>, Vec<_>) =
            grains.iter().partition(|grain| !self.is_below(depth, grain.center.map(i64::from)));
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
                self.is_below(depth, at).then_some(grain)
            });
            variants.push(self.joined(&frame, moved.collect()));
        }
        variants
    }

    fn frame(&self) -> i64 {
        (FRAME * f64::from(self.field.largest_radius_quanta())).ceil() as i64
    }

    /// Whether a place lies farther than a depth from all faces.
    fn is_below(&self, depth: i64, center: [i64; 3]) -> bool {
        (0..3).all(|axis| (depth..self.period[axis] - depth).contains(&center[axis]))
    }

    /// A frame and what lies in it, pushed apart.
    fn joined(&self, frame: &[QuantisedGrain], inner: Vec<QuantisedGrain>) -> Vec<QuantisedGrain> {
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
        spheres.relax(&moves, TOLERANCE);
        spheres.attach(TOUCH, frame.len());
        let is_crowded = crowded(&spheres, frame.len());
        let placed = |(grain, center): (&QuantisedGrain, &DVec3)| {
            let center = center.to_array().map(|c| c.round() as i64);
            let center: [i64; 3] =
                std::array::from_fn(|axis| center[axis].rem_euclid(self.period[axis]));
            QuantisedGrain { center: center.map(|c| c as i32), ..*grain }
        };
        // The few that were pushed into the frame would differ there between the variants.
        let frame_of_all = self.frame() / 2 + 2;
        let stays = |(grain, crowded): &(&QuantisedGrain, bool)| {
            !crowded && self.is_below(frame_of_all, grain.center.map(i64::from))
        };
        let placed = all().zip(&spheres.centers).map(placed).collect::<Vec<_>>();
        let (outer, inner) = placed.split_at(frame.len());
        let inner = inner.iter().zip(is_crowded).filter(stays).map(|(grain, _)| grain);
        outer.iter().chain(inner).copied().collect()
    }
}
