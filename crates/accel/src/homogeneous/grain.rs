//! Sixteen spheres that are met, by their closed form.

use crate::flight::vector::{F, W};
use fearless_simd::prelude::*;
use snowgrain_optics::sphere::Polarisation;

/// How a path comes through a sphere, in the plane of the path and the centre.
pub(super) struct Passage<S: Simd> {
    /// Cosine of the angle by which it is turned.
    pub(super) cos: F<S>,
    /// Sine of it, positive towards the side on which the centre lies.
    pub(super) sin: F<S>,
    /// Length in ice, radii.
    pub(super) chords: F<S>,
    /// From where it entered to where it leaves along its first direction, radii.
    pub(super) along: F<S>,
    /// The same across, towards the side on which the centre lies.
    pub(super) across: F<S>,
}

/// A sphere that a path has met: angles and reflectance are the same at all its interfaces.
pub(super) struct Grain<S: Simd> {
    sin2_i: F<S>,
    cos_i: F<S>,
    sin_t: F<S>,
    cos_t: F<S>,
    reflectance: F<S>,
}

impl<S: Simd> Grain<S> {
    /// Where the sine of the angle of incidence has the square `u`, uniform over the disc.
    #[inline(always)]
    pub(super) fn met(
        simd: S,
        (eta, polarisation): (f32, Polarisation),
        u: F<S>,
        bits: W<S>,
    ) -> Self {
        let splat = |v: f32| F::<S>::splat(simd, v);
        let one = splat(1.0);
        let cos_i = (one - u).sqrt();
        let sin2_t = u * splat(1.0 / (eta * eta));
        let eta = splat(eta);
        let cos_t = (one - sin2_t).sqrt();
        let across = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
        let along = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
        let (s, p) = (across * across, along * along);
        let reflectance = match polarisation {
            Polarisation::Redrawn => (s + p) * splat(0.5),
            Polarisation::Tracked => {
                let bit = W::<S>::splat(simd, 1 << 23);
                (bits & bit).simd_eq(bit).select(s, p)
            }
        };
        Self { sin2_i: u, cos_i, sin_t: sin2_t.sqrt(), cos_t, reflectance }
    }

    /// The way through the grain for a number in [0, 1).
    #[inline(always)]
    pub(super) fn pass(&self, simd: S, v: F<S>) -> Passage<S> {
        let splat = |v: f32| F::<S>::splat(simd, v);
        let (zero, one) = (splat(0.0), splat(1.0));
        let (ci, ct, st) = (self.cos_i, self.cos_t, self.sin_t);
        let si = self.sin2_i.sqrt();
        // Refracted in and out: 2 (theta_i - theta_t); the first chord is turned by half of that.
        let (c, s) = (ci * ct + si * st, si * ct - ci * st);
        let (mut cos, mut sin) = (c * c - s * s, splat(2.0) * s * c);
        // Each reflection inside: pi - 2 theta_t more.
        let (cos_more, sin_more) = (st * st - ct * ct, splat(2.0) * st * ct);
        let enters = v.simd_ge(self.reflectance);
        let chord = ct + ct;
        let mut chords = chord;
        let (mut along, mut across) = (chord * c, chord * s);
        let (mut chord_cos, mut chord_sin) = (c, s);
        // What is left of [0, 1) above `v` is cut at R, R^2, ... of it: as many reflections.
        let mut left = enters.select(one - v, one);
        let mut limit = (one - self.reflectance) * self.reflectance;
        loop {
            let again = left.simd_le(limit) & limit.simd_gt(zero);
            if again.to_bitmask() == 0 {
                break;
            }
            let next = cos * cos_more - sin * sin_more;
            sin = again.select(sin * cos_more + cos * sin_more, sin);
            cos = again.select(next, cos);
            let next = chord_cos * cos_more - chord_sin * sin_more;
            chord_sin = chord_sin * cos_more + chord_cos * sin_more;
            chord_cos = next;
            chords += again.select(chord, zero);
            along += again.select(chord * chord_cos, zero);
            across += again.select(chord * chord_sin, zero);
            limit = again.select(limit * self.reflectance, zero);
            left = again.select(left, one);
        }
        // Outside it is mirrored away from the axis, by pi - 2 theta_i.
        let mirrored = self.sin2_i + self.sin2_i - one;
        let aside = splat(-2.0) * si * ci;
        Passage {
            cos: enters.select(cos, mirrored),
            sin: enters.select(sin, aside),
            chords: enters.select(chords, zero),
            along: enters.select(along, zero),
            across: enters.select(across, zero),
        }
    }
}
