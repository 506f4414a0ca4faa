//! Ways through one sphere and then another, from the rays of a [`Pencil`] into a given direction.
//!
//! There is no closed form for two spheres: where light of given orders leaves the second one is a smooth map of
//! the two numbers that tell the rays of the pencil apart, which Newton's steps invert. The map and its
//! derivatives ("ray differentials", Igehy 1999) follow from the closed form of one sphere: with n the outward
//! normal where a ray of direction d arrives, c and c_t the cosines of its angles to the normal outside and inside,
//! b = c - eta c_t and u = d + b n,
//!
//! - the reflected direction is d + 2 c n;
//! - a chord leads from n to n' = n + (2 c_t/eta) u;
//! - there light leaves along u + b n', or is reflected, u' = u - 2 eta c_t n'.

use super::dual::{Dual, DualVector};
use crate::{Dielectric, fresnel};
use snowgrain_math::{DVec3, frame};

/// Newton's steps of a search, and the times that each is halved at most.
const MOST_STEPS: u32 = 16;
const MOST_HALVINGS: u32 = 2;
/// A search ends where the next step is this part of its reach.
const TOLERANCE: f64 = 1e-9;

/// Rays that two numbers tell apart: their origins, and their directions (of any length), are affine in them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pencil {
    /// Where the ray of (0, 0) starts.
    pub origin: DVec3,
    /// Its direction.
    pub direction: DVec3,
    /// Derivatives of the origin.
    pub origin_by: [DVec3; 2],
    /// Derivatives of the direction.
    pub direction_by: [DVec3; 2],
}

/// A sphere in the way, and by how many chords light passes it: 0 is reflection outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphereVisit {
    /// Its centre.
    pub center: DVec3,
    /// Its radius, in the unit of the pencil's origins.
    pub radius: f64,
    /// Number of chords.
    pub order: u32,
}

/// Light that visits one sphere and then another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpherePair {
    /// What the spheres are made of.
    pub medium: Dielectric,
    /// In the order of the visits.
    pub visits: [SphereVisit; 2],
}

/// A ray as it passes a sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Passed {
    /// Cosine of the angle of incidence.
    pub cosine: f64,
    /// Outward unit normal where it leaves.
    pub exit: DVec3,
    /// Unit direction in which it leaves.
    pub direction: DVec3,
}

/// A ray through both spheres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairPath {
    /// The two numbers of the ray.
    pub at: [f64; 2],
    /// How it passes each sphere.
    pub passed: [Passed; 2],
    /// Derivatives of the direction in which it leaves the second.
    leaves_by: [DVec3; 2],
}

/// A ray of a pencil behind the first of two spheres.
#[derive(Clone, Copy)]
pub struct Between {
    ray: Ray<0>,
    /// How it passed that.
    pub passed: Passed,
}

/// A ray with its derivatives by the numbers of the pencil, or without.
#[derive(Clone, Copy)]
struct Ray<const N: usize> {
    origin: DualVector<N>,
    direction: DualVector<N>,
}

impl Pencil {
    /// Where the ray of two numbers starts, and its unit direction.
    #[must_use]
    pub fn ray(&self, at: [f64; 2]) -> (DVec3, DVec3) {
        let Ray { origin, direction } = self.with_derivatives(at, [], []);
        (origin.value, direction.value)
    }

    fn with_derivatives<const N: usize>(
        &self,
        [x, y]: [f64; 2],
        origin_by: [DVec3; N],
        direction_by: [DVec3; N],
    ) -> Ray<N> {
        let affine = |value: DVec3, by: [DVec3; 2]| value + by[0] * x + by[1] * y;
        let origin = affine(self.origin, self.origin_by);
        let direction = affine(self.direction, self.direction_by);
        Ray {
            origin: DualVector { value: origin, by: origin_by },
            direction: DualVector { value: direction, by: direction_by }.normalized(),
        }
    }
}

impl SphereVisit {
    /// The ray that leaves; `None` where this one does not meet the sphere from outside, or is reflected
    /// totally.
    #[inline]
    fn pass<const N: usize>(&self, ray: Ray<N>, eta: f64) -> Option<(Ray<N>, Passed)> {
        let from_center = ray.origin + -self.center;
        let along = from_center.dot(ray.direction);
        let foot = from_center - ray.direction * along;
        let half2 = Dual::constant(self.radius * self.radius) - foot.dot(foot);
        if half2.value <= 0.0 || along.value + half2.value.sqrt() >= 0.0 {
            return None;
        }
        let half = half2.sqrt();
        let cosine = half * self.radius.recip();
        let mut normal = (foot - ray.direction * half) * self.radius.recip();
        let direction = if self.order == 0 {
            ray.direction + normal * (cosine * 2.0)
        } else {
            let one = Dual::constant(1.0);
            let inside2 = one - (one - cosine * cosine) * (eta * eta).recip();
            if inside2.value <= 0.0 {
                return None;
            }
            let inside = inside2.sqrt();
            let bend = cosine - inside * eta;
            let mut u = ray.direction + normal * bend;
            for chord in 1..=self.order {
                if chord > 1 {
                    u = u - normal * (inside * (2.0 * eta));
                }
                normal = normal + u * (inside * (2.0 / eta));
            }
            u + normal * bend
        };
        let passed =
            Passed { cosine: cosine.value, exit: normal.value, direction: direction.value };
        Some((Ray { origin: normal * self.radius + self.center, direction }, passed))
    }
}

impl SpherePair {
    /// How a ray of the pencil passes both spheres; `None` where it does not, or is reflected totally.
    #[must_use]
    pub fn pass(&self, pencil: &Pencil, at: [f64; 2]) -> Option<[Passed; 2]> {
        self.pass_second(&self.pass_first(pencil, at)?)
    }

    /// How a ray of the pencil passes the first sphere, whatever it does then.
    #[must_use]
    pub fn pass_first(&self, pencil: &Pencil, at: [f64; 2]) -> Option<Between> {
        let ray = pencil.with_derivatives(at, [], []);
        let (ray, passed) = self.visits[0].pass(ray, self.medium.eta)?;
        Some(Between { ray, passed })
    }

    /// How such a ray passes both.
    #[must_use]
    pub fn pass_second(&self, between: &Between) -> Option<[Passed; 2]> {
        let (_, second) = self.visits[1].pass(between.ray, self.medium.eta)?;
        Some([between.passed, second])
    }

    /// The same, with how neighbouring rays leave.
    #[must_use]
    pub fn follow(&self, pencil: &Pencil, at: [f64; 2]) -> Option<PairPath> {
        let (path, _) = self.follow_differential(pencil, at)?;
        Some(path)
    }

    fn follow_differential(
        &self,
        pencil: &Pencil,
        at: [f64; 2],
    ) -> Option<(PairPath, DualVector<2>)> {
        let ray = pencil.with_derivatives(at, pencil.origin_by, pencil.direction_by);
        let (leaves, passed) = self.pass_both(ray)?;
        Some((PairPath { at, passed, leaves_by: leaves.by }, leaves))
    }

    /// The direction in which a ray leaves, and how it passes.
    fn pass_both<const N: usize>(&self, ray: Ray<N>) -> Option<(DualVector<N>, [Passed; 2])> {
        let (between, first) = self.visits[0].pass(ray, self.medium.eta)?;
        let (leaves, second) = self.visits[1].pass(between, self.medium.eta)?;
        Some((leaves.direction, [first, second]))
    }

    /// Part of the light that passes a sphere as a ray does, and the length in it.
    #[must_use]
    pub fn part(&self, sphere: usize, passed: &Passed) -> (f64, f64) {
        let SphereVisit { order, radius, .. } = self.visits[sphere];
        let reflectance = self.medium.reflectance_from_outside(passed.cosine);
        let inside = fresnel::cos_refracted(passed.cosine, self.medium.eta).unwrap_or(0.0);
        let reflected = (1..order).fold(1.0, |part, _| part * reflectance);
        let part = match order {
            0 => reflectance,
            _ => (1.0 - reflectance) * (1.0 - reflectance) * reflected,
        };
        (part, f64::from(order) * 2.0 * inside * radius)
    }

    /// The ray of the pencil that leaves along the unit vector `wanted`, by Newton's steps from `start` that never
    /// go farther from it than `reach` in either number: the same start leads to the same ray. `None` where they
    /// lead to none.
    #[must_use]
    pub fn solve(
        &self,
        pencil: &Pencil,
        (start, reach): ([f64; 2], f64),
        wanted: DVec3,
    ) -> Option<PairPath> {
        let axes = frame::tangents(wanted);
        let (mut path, leaves) = self.follow_differential(pencil, start)?;
        let mut off = offset(leaves, wanted, axes)?;
        for _ in 0..MOST_STEPS {
            let step = newton_step(off)?;
            if step.iter().all(|step| step.abs() < TOLERANCE * reach) {
                return Some(path);
            }
            let mut part = 1.0;
            let mut next = None;
            for _ in 0..=MOST_HALVINGS {
                let at = [0, 1].map(|axis: usize| path.at[axis] + part * step[axis]);
                if (0..2).any(|axis| (at[axis] - start[axis]).abs() > reach) {
                    return None;
                }
                next = self.follow_differential(pencil, at).and_then(|(path, leaves)| {
                    let nearer = offset(leaves, wanted, axes)?;
                    (square(nearer) < square(off)).then_some((path, nearer))
                });
                if next.is_some() {
                    break;
                }
                part *= 0.5;
            }
            (path, off) = next?;
        }
        None
    }
}

impl PairPath {
    /// Solid angle into which the pencil's rays leave, by their two numbers, sr.
    #[must_use]
    pub fn solid_angle(&self) -> f64 {
        self.passed[1].direction.dot(self.leaves_by[0].cross(self.leaves_by[1])).abs()
    }
}

/// How far a direction is off the wanted one, along two axes across that: on a stereographic map, where all
/// directions but the opposite one have a place. `None` of the latter.
fn offset(leaves: DualVector<2>, wanted: DVec3, axes: (DVec3, DVec3)) -> Option<[Dual<2>; 2]> {
    let below = Dual::constant(1.0) + leaves.along(wanted);
    let scale = Dual::constant(2.0) / below;
    let off = [leaves.along(axes.0) * scale, leaves.along(axes.1) * scale];
    (below.value > 0.0).then_some(off)
}

fn square([a, b]: [Dual<2>; 2]) -> f64 {
    a.value * a.value + b.value * b.value
}

/// The step to where both numbers vanish, were they affine.
fn newton_step([a, b]: [Dual<2>; 2]) -> Option<[f64; 2]> {
    let determinant = a.by[0] * b.by[1] - a.by[1] * b.by[0];
    let step = [
        (b.value * a.by[1] - a.value * b.by[1]) / determinant,
        (a.value * b.by[0] - b.value * a.by[0]) / determinant,
    ];
    step.iter().all(|step| step.is_finite()).then_some(step)
}

#[cfg(test)]
mod tests;
