//! Equally likely passages of light through a sphere: what it does to a path, in one look-up.

use super::{LEAST_LIGHT, turn_from_air};
use crate::Dielectric;
use crate::sphere::Impact;
use snowgrain_math::trig;

/// Rings of the disc over which the energy of an order is summed.
const RINGS: u32 = 1 << 12;
/// Binary logarithm of the number of passages.
const BITS: u32 = 12;

/// Passages of light that falls evenly on the disc of a sphere, each with the same part of the energy.
///
/// Of each order they are spread over the disc as its energy is, so that means over all are those of the sphere but for a few parts in
/// 10 000. A way and its reversal are one passage: uniform light stays uniform.
#[derive(Clone, Debug)]
pub struct PassageTable {
    passages: Vec<SpherePassage>,
}

/// One way through a sphere, in the plane of the direction of arrival and of the place of arrival: of each vector the part
/// along the direction, and the part aside, towards the place. Lengths in radii.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SpherePassage {
    /// Outward unit normal where it enters.
    pub entry: [f32; 2],
    /// From where it enters to where it leaves.
    pub displacement: [f32; 2],
    /// Unit direction in which it leaves.
    pub direction: [f32; 2],
    /// Length in the sphere.
    pub length: f32,
}

impl PassageTable {
    /// Of a sphere that is met from air (or from what surrounds it).
    #[must_use]
    pub fn for_air(medium: Dielectric) -> Self {
        let fraction = |ring: u32| (f64::from(ring) + 0.5) / f64::from(RINGS);
        let impacts: Vec<Impact> =
            (0..RINGS).map(|ring| Impact::at_disc_fraction(medium, fraction(ring))).collect();
        let mut cumulative = Vec::new();
        let (mut sum, mut left) = (0.0, f64::from(RINGS));
        while left > LEAST_LIGHT * f64::from(RINGS) {
            let order = (cumulative.len() / impacts.len()) as u32;
            for impact in &impacts {
                let energy = impact.energy(order);
                (sum, left) = (sum + energy, left - energy);
                cumulative.push(sum);
            }
        }
        let each = sum / f64::from(1u32 << BITS);
        let passage = |number: u32| {
            let wanted = (f64::from(number) + 0.5) * each;
            let at = cumulative.partition_point(|&sum| sum <= wanted);
            let before = at.checked_sub(1).map_or(0.0, |before| cumulative[before]);
            let part = (wanted - before) / (cumulative[at] - before);
            let ring = (at % impacts.len()) as f64;
            let place = (ring + part) / f64::from(RINGS);
            let impact = Impact::at_disc_fraction(medium, place);
            SpherePassage::of(&impact, (at / impacts.len()) as u32)
        };
        Self { passages: (0..1 << BITS).map(passage).collect() }
    }

    /// One of the passages, by a uniform number, and what is left of that.
    #[inline]
    #[must_use]
    pub fn draw(&self, random: f64) -> (&SpherePassage, f64) {
        let place = random * self.passages.len() as f64;
        let index = place as usize;
        (&self.passages[index], place - index as f64)
    }
}

impl SpherePassage {
    fn of(impact: &Impact, order: u32) -> Self {
        let turn = turn_from_air(impact, order);
        let vector = |angle: f64| {
            let (sin, cos) = trig::sin_cos(angle);
            [cos as f32, sin as f32]
        };
        let [entry, exit] = [vector(turn.entry), vector(turn.exit)];
        Self {
            entry,
            displacement: [exit[0] - entry[0], exit[1] - entry[1]],
            // It is turned away from the side on which it arrived.
            direction: vector(-turn.deflection),
            length: turn.length as f32,
        }
    }

    /// The way straight through from the same entry, of light that is not turned.
    #[inline]
    #[must_use]
    pub fn straight(&self) -> Self {
        let displacement = [-2.0 * self.entry[0], 0.0];
        Self { displacement, direction: [1.0, 0.0], ..*self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sphere;

    /// Means over all passages are those of the closed form.
    #[test]
    fn passages_scatter_and_absorb_as_the_sphere() {
        let ice = Dielectric { eta: 1.31 };
        let table = PassageTable::for_air(ice);
        let mean = |value: fn(&SpherePassage) -> f32| {
            let all = table.passages.iter().map(|passage| f64::from(value(passage)));
            all.sum::<f64>() / table.passages.len() as f64
        };
        let cases = [
            ("cosine", mean(|p| p.direction[0]), sphere::asymmetry(ice)),
            ("length", mean(|p| p.length), 4.0 / 3.0 * sphere::absorption_enhancement(ice)),
            (
                "reflected",
                mean(|p| if p.length == 0.0 { 1.0 } else { 0.0 }),
                sphere::energy(ice, 0),
            ),
            ("entry", mean(|p| p.entry[0]), -2.0 / 3.0),
        ];
        for (what, found, expected) in cases {
            assert!((found - expected).abs() < 1e-3, "{what}: {found} instead of {expected}");
        }
    }

    /// A passage leaves the sphere outwards, and light that goes back enters where it left.
    #[test]
    fn passages_can_be_reversed() {
        let table = PassageTable::for_air(Dielectric { eta: 1.31 });
        let dot = |a: [f32; 2], b: [f32; 2]| a[0] * b[0] + a[1] * b[1];
        for passage in &table.passages {
            let exit = [0, 1].map(|part| passage.entry[part] + passage.displacement[part]);
            assert!((dot(exit, exit) - 1.0).abs() < 1e-5, "{passage:?}");
            assert!((dot(exit, passage.direction) + passage.entry[0]).abs() < 1e-5, "{passage:?}");
        }
    }
}
