//! Aggregates of grains, as snowflakes are: made by ballistic cluster-cluster aggregation (Meakin 1991,
//! "Fractal aggregates in geophysics", Rev. Geophys. 29, 317), where two aggregates of about half the
//! size, turned at random, meet on a random line. Their dimension is about 2, so the larger they are
//! the thinner the snow that they make.

use super::rules::{Drop, nearest};
use core::f64::consts::TAU;
use snowgrain_geometry::QuantisedGrain;
use snowgrain_math::sampler::{PathKey, pcg3d};
use snowgrain_math::{DMat3, DVec3, trig};

/// Gap, quanta, that two grains are given where they meet: rounding to whole quanta moves each by up to
/// half a quantum along every axis, so that hardly any overlap by one, and all touch within
/// [`TOUCH_TOLERANCE_QUANTA`](crate::measures::TOUCH_TOLERANCE_QUANTA).
const GAP: f64 = 1.0;
/// First event of the random numbers of an aggregate: those before belong to its fall.
const FIRST_EVENT: u32 = 2;

/// A sphere of an aggregate, quanta.
#[derive(Clone, Copy, Debug)]
struct Member {
    center: DVec3,
    radius: f64,
}

/// The random numbers of one aggregate, in their order.
struct Numbers {
    key: PathKey,
    event: u32,
}

impl Numbers {
    fn words(&mut self) -> [u32; 3] {
        self.event += 1;
        pcg3d(self.key.lo, self.key.hi, self.event - 1)
    }

    fn units(&mut self) -> [f64; 3] {
        self.words().map(|word| (f64::from(word) + 0.5) / 4_294_967_296.0)
    }

    /// A rotation, uniform over all (Shoemake 1992, "Uniform random rotations", Graphics Gems III).
    fn rotation(&mut self) -> DMat3 {
        let [a, b, c] = self.units();
        let (low, high) = ((1.0 - a).sqrt(), a.sqrt());
        let ((s1, c1), (s2, c2)) = (trig::sin_cos(TAU * b), trig::sin_cos(TAU * c));
        let [x, y, z, w] = [low * s1, low * c1, high * s2, high * c2];
        DMat3::from_cols(
            DVec3::new(1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + z * w), 2.0 * (x * z - y * w)),
            DVec3::new(2.0 * (x * y - z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + x * w)),
            DVec3::new(2.0 * (x * z + y * w), 2.0 * (y * z - x * w), 1.0 - 2.0 * (x * x + y * y)),
        )
    }
}

/// Number of grains of drop `index`, whose mean is `mean`.
pub(super) fn size(drop: &Drop<'_>, mean: f64, index: u64) -> u64 {
    let key = PathKey::new(drop.seed, index, drop.snowfall);
    let unit = f64::from(pcg3d(key.lo, key.hi, 1)[0]) / 4_294_967_296.0;
    let whole = mean.floor();
    whole as u64 + u64::from(unit < mean - whole)
}

/// The grains of drop `index` about their common centre, `count` of them, in `out`.
pub(super) fn shape(drop: &Drop<'_>, count: u64, index: u64, out: &mut Vec<QuantisedGrain>) {
    let key = PathKey::new(drop.seed, index, drop.snowfall);
    let mut numbers = Numbers { key, event: FIRST_EVENT };
    let members = aggregate(count.max(1), &mut numbers, &|word| drop.radius(word));
    let turn = numbers.rotation();
    out.clear();
    out.extend(members.iter().map(|member| QuantisedGrain {
        center: (turn * member.center).to_array().map(nearest),
        radius: member.radius as u16,
    }));
}

/// `count` grains that hang together, their mean place at 0.
fn aggregate(count: u64, numbers: &mut Numbers, radius: &dyn Fn(u32) -> u16) -> Vec<Member> {
    if count == 1 {
        let radius = f64::from(radius(numbers.words()[0]));
        return vec![Member { center: DVec3::ZERO, radius }];
    }
    let mut first = aggregate(count.div_ceil(2), numbers, radius);
    let mut second = aggregate(count / 2, numbers, radius);
    let turn = numbers.rotation();
    second.iter_mut().for_each(|member| member.center = turn * member.center);
    let reach = extent(&first) + extent(&second);
    let shift = loop {
        let [a, b, _] = numbers.units();
        let (sin, cos) = trig::sin_cos(TAU * a);
        let aside = DVec3::new(cos, 0.0, sin) * (reach * b.sqrt());
        if let Some(height) = meeting(&first, &second, aside) {
            break aside + DVec3::Y * height;
        }
    };
    first.extend(second.iter().map(|m| Member { center: m.center + shift, ..*m }));
    let middle = first.iter().map(|member| member.center).sum::<DVec3>() / first.len() as f64;
    first.iter_mut().for_each(|member| member.center -= middle);
    first
}

/// Radius about 0 of the ball that holds all members.
fn extent(members: &[Member]) -> f64 {
    members.iter().map(|member| member.center.length() + member.radius).fold(0.0, f64::max)
}

/// How high over `first` the aggregate `second`, which falls `aside` of it, first meets it.
fn meeting(first: &[Member], second: &[Member], aside: DVec3) -> Option<f64> {
    let mut highest: Option<f64> = None;
    for b in second {
        let at = b.center + aside;
        for a in first {
            let reach = a.radius + b.radius + GAP;
            let (x, z) = (at.x - a.center.x, at.z - a.center.z);
            let square = reach * reach - x * x - z * z;
            if square > 0.0 {
                let height = a.center.y - at.y + square.sqrt();
                highest = Some(highest.map_or(height, |known| known.max(height)));
            }
        }
    }
    highest
}

#[cfg(test)]
mod tests {
    use super::*;

    fn made(count: u64, seed: u64) -> Vec<Member> {
        let mut numbers = Numbers { key: PathKey::new(seed, 0, 0), event: FIRST_EVENT };
        aggregate(count, &mut numbers, &|_| 100)
    }

    #[test]
    fn aggregates_hang_together_without_overlap() {
        for (count, seed) in [(1, 0), (2, 1), (7, 2), (64, 3), (301, 4)] {
            let members = made(count, seed);
            assert_eq!(members.len() as u64, count);
            let mut reached = vec![0];
            for at in 0..members.len() {
                let Some(&from) = reached.get(at) else { panic!("{count}: {at} hang together") };
                for (index, other) in members.iter().enumerate() {
                    let gap = (other.center - members[from].center).length() - 200.0;
                    assert!(index == from || gap > 0.999 * GAP, "{gap}");
                    if gap < 1.001 * GAP && !reached.contains(&index) {
                        reached.push(index);
                    }
                }
            }
        }
    }

    #[test]
    fn their_dimension_is_that_of_ballistic_cluster_cluster_aggregation() {
        // Radii of gyration of 16 and of 256 grains; Meakin gives D = 1.95 for aggregates of sizes
        // beyond these.
        let gyration = |count: u64| {
            let squares = (0..40).map(|seed| {
                let members = made(count, seed);
                members.iter().map(|m| m.center.length_squared()).sum::<f64>() / count as f64
            });
            (squares.sum::<f64>() / 40.0).sqrt()
        };
        let dimension = trig::ln(16.0) / trig::ln(gyration(256) / gyration(16));
        assert!((1.8..2.2).contains(&dimension), "{dimension}");
    }

    #[test]
    fn rotations_are_rotations_without_a_preferred_direction() {
        let mut numbers = Numbers { key: PathKey::new(5, 0, 0), event: 0 };
        let mut mean = DVec3::ZERO;
        for _ in 0..4000 {
            let turn = numbers.rotation();
            assert!((turn.determinant() - 1.0).abs() < 1e-9);
            assert!(
                (turn * turn.transpose() - DMat3::IDENTITY)
                    .to_cols_array()
                    .iter()
                    .all(|x| x.abs() < 1e-9)
            );
            mean += turn * DVec3::X / 4000.0;
        }
        // Each component has a standard deviation of .009: a false alarm once in 10^4.
        assert!(mean.abs().max_element() < 0.036, "{mean}");
    }
}
