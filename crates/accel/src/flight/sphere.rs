//! Light at the surface of a sphere and inside it, in closed form, many paths at a time.
//!
//! Everything happens in the plane of the direction `d` and the outward normal `n`. With c and c_t
//! the cosines of the angles to the normal outside and inside,
//!
//! - the reflected direction is d + 2 c n;
//! - the refracted direction is u/eta with u = d + (c - eta c_t) n;
//! - the chord measures 2 r c_t and ends at the normal n' = n + (2 c_t/eta) u;
//! - there light leaves along u + (c - eta c_t) n', or is reflected, u' = u - 2 eta c_t n'.
//!
//! All angles inside one sphere are the same, so c and c_t serve until the light is out; nothing is
//! divided and no angle is computed twice.

use super::random::{NEXT_EVENT, uniform_24_bits};
use super::vector::{F, M, Vector, W};
use fearless_simd::prelude::*;

/// Optical constants of the grains, rounded once.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ice {
    pub(super) eta: f32,
    pub(super) inverse_eta: f32,
}

impl Ice {
    pub(super) fn new(eta: f64) -> Self {
        Self { eta: eta as f32, inverse_eta: (1.0 / eta) as f32 }
    }
}

/// The angles at an interface.
#[derive(Clone, Copy)]
pub(super) struct Angles<S: Simd> {
    /// Cosine in air, or what lies between the grains.
    pub(super) outside: F<S>,
    /// Cosine in ice.
    pub(super) inside: F<S>,
}

impl<S: Simd> Angles<S> {
    /// Snell's law, from the cosine in air.
    #[inline(always)]
    pub(super) fn from_outside(simd: S, ice: Ice, outside: F<S>) -> Self {
        let (zero, one) = (F::<S>::splat(simd, 0.0), F::<S>::splat(simd, 1.0));
        let ratio = F::<S>::splat(simd, ice.inverse_eta * ice.inverse_eta);
        // Negative where all light is reflected outside, as water's is by ice at grazing angles.
        let inside2 = one - (one - outside * outside) * ratio;
        Self { outside, inside: inside2.max(zero).sqrt() }
    }

    /// Snell's law, from the cosine in ice for the paths `fresh`, from that outside for the others; the
    /// other cosine is 0 where all light is reflected.
    #[inline(always)]
    pub(super) fn at_sphere(simd: S, ice: Ice, fresh: M<S>, inside: F<S>, outside: F<S>) -> Self {
        let (zero, one) = (F::<S>::splat(simd, 0.0), F::<S>::splat(simd, 1.0));
        let ratio = fresh.select(
            F::<S>::splat(simd, ice.eta * ice.eta),
            F::<S>::splat(simd, ice.inverse_eta * ice.inverse_eta),
        );
        let known = fresh.select(inside, outside);
        let other2 = one - (one - known * known) * ratio;
        let other = other2.simd_gt(zero).select(other2, zero).sqrt();
        Self { outside: fresh.select(other, outside), inside: fresh.select(inside, other) }
    }
}

/// How likely light passes an interface, as a fraction that never has to be divided out.
#[derive(Clone, Copy)]
pub(super) struct Transmittance<S: Simd> {
    /// 2^24 times the numerator.
    passes: F<S>,
    of: F<S>,
}

impl<S: Simd> Transmittance<S> {
    /// Fresnel's equations for unpolarised light: with a = c + eta c_t and b = eta c + c_t,
    /// T = 2 eta c c_t (1/a^2 + 1/b^2), the mean of the two polarisations (Born & Wolf, "Principles
    /// of Optics", 7th ed., section 1.5.3).
    #[inline(always)]
    pub(super) fn new(simd: S, ice: Ice, angles: Angles<S>) -> Self {
        let eta = F::<S>::splat(simd, ice.eta);
        let a = angles.outside + eta * angles.inside;
        let b = eta * angles.outside + angles.inside;
        let (a2, b2) = (a * a, b * b);
        let both = F::<S>::splat(simd, 2.0 * 16_777_216.0 * ice.eta);
        Self { passes: both * (angles.outside * angles.inside) * (a2 + b2), of: a2 * b2 }
    }

    /// Whether the light of each path passes, by its random event `event`.
    #[inline(always)]
    pub(super) fn passes(&self, key: [W<S>; 2], event: W<S>) -> M<S> {
        (uniform_24_bits::<S>(key, event) * self.of).simd_lt(self.passes)
    }
}

/// Paths at spheres that touch nothing: on the way in, or inside after a reflection.
pub(super) struct Arrival<S: Simd> {
    /// Paths that arrive from outside.
    pub(super) hit: M<S>,
    /// Paths that were reflected inside in the last round.
    pub(super) inside: M<S>,
    /// Direction, of unit length; for paths inside, what [`Visit`] gave.
    pub(super) direction: Vector<S>,
    /// Outward unit normal.
    pub(super) normal: Vector<S>,
    /// Cosine of the angle in air at which the sphere was met; 0 for paths that are at none.
    pub(super) outside: F<S>,
}

/// Paths after a step through spheres.
pub(super) struct Visit<S: Simd> {
    /// Direction, of unit length; for paths inside, `u` of the module's page. As it was for paths at
    /// no sphere.
    pub(super) direction: Vector<S>,
    /// Outward normal at the end of the chord, where there is one; else as it was.
    pub(super) normal: Vector<S>,
    /// Paths that are reflected inside at that point.
    pub(super) inside: M<S>,
    /// Length of the chord, in radii; 0 where there is none.
    pub(super) chord: F<S>,
    /// Next random event.
    pub(super) event: W<S>,
}

/// In at the surface or a reflection there, then along one chord, then out or a reflection inside.
/// Six visits in a hundred go on inside; they wait for the next round, since a loop would be left at
/// a point that no processor can foresee.
#[inline(always)]
pub(super) fn visit<S: Simd>(
    simd: S,
    ice: Ice,
    at: &Arrival<S>,
    key: [W<S>; 2],
    event: W<S>,
) -> Visit<S> {
    let zero = F::<S>::splat(simd, 0.0);
    let (no, next) = (W::<S>::splat(simd, 0), W::<S>::splat(simd, NEXT_EVENT));
    let eta = F::<S>::splat(simd, ice.eta);
    let angles = Angles::from_outside(simd, ice, at.outside);
    let transmittance = Transmittance::new(simd, ice, angles);
    let entered = (at.hit & transmittance.passes(key, event)) | at.inside;

    // All cases are one chain of steps with other factors.
    let chord = angles.inside + angles.inside;
    let bend = at.outside - eta * angles.inside;
    let reflected = at.inside.select(zero - eta * chord, at.outside + at.outside);
    let refracted = at.hit & entered;
    let u = at.direction.plus(at.normal, refracted.select(bend, reflected));
    let per_u = chord * F::<S>::splat(simd, ice.inverse_eta);
    let far = at.normal.plus(u, entered.select(per_u, zero));

    let event = event + at.hit.select(next, no);
    let leaves = transmittance.passes(key, event);
    let inside = entered & !leaves;
    let out = u.plus(far, entered.select(bend, zero)).straightened(simd);
    Visit {
        direction: Vector::choose(inside, u, out),
        normal: far,
        inside,
        chord: entered.select(chord, zero),
        event: event + entered.select(next, no),
    }
}
