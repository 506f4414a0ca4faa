//! The opening of a lens.

use snowgrain_math::{DVec2, trig};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, TAU};

/// The opening of a lens of radius 1: x runs to the right in the picture, y upwards.
#[derive(Clone, Debug, PartialEq)]
pub enum Aperture {
    /// The whole disc.
    Round,
    /// A regular polygon with its corners on the circle, as blades leave it.
    Polygon(Vec<DVec2>),
}

impl Aperture {
    /// The opening that `blades` leave (0: round; else at least 3), of which one corner lies straight
    /// up, turned counter-clockwise by `rotation_degrees`.
    #[must_use]
    pub fn new(blades: u32, rotation_degrees: f64) -> Self {
        if blades < 3 {
            return Self::Round;
        }
        let corner = |blade: u32| {
            let turn = TAU * f64::from(blade) / f64::from(blades);
            let (sin, cos) = trig::sin_cos(turn + rotation_degrees.to_radians());
            DVec2::new(-sin, cos)
        };
        Self::Polygon((0..blades).map(corner).collect())
    }

    /// A point of the opening, uniform over its area for uniform numbers in [0, 1).
    #[must_use]
    pub fn sample(&self, numbers: [f64; 2]) -> DVec2 {
        match self {
            Self::Round => concentric(numbers),
            Self::Polygon(corners) => in_polygon(corners, numbers),
        }
    }
}

/// The square on the disc by rings and sectors, which keeps areas and neighbours (Shirley and Chiu
/// 1997, "A Low Distortion Map Between Disk and Square", J. Graphics Tools 2(3), section 2).
fn concentric(numbers: [f64; 2]) -> DVec2 {
    let [a, b] = numbers.map(|number| 2.0 * number - 1.0);
    if a == 0.0 && b == 0.0 {
        return DVec2::ZERO;
    }
    let (radius, angle) = if a.abs() > b.abs() {
        (a, FRAC_PI_4 * (b / a))
    } else {
        (b, FRAC_PI_2 - FRAC_PI_4 * (a / b))
    };
    let (sin, cos) = trig::sin_cos(angle);
    DVec2::new(cos, sin) * radius
}

/// The first number chooses one of the equal triangles between the middle and two corners and then a
/// distance from the middle, the second a place between those corners (Turk 1990, "Generating Random
/// Points in Triangles", Graphics Gems, method 1).
fn in_polygon(corners: &[DVec2], [first, second]: [f64; 2]) -> DVec2 {
    let sector = first * corners.len() as f64;
    let index = (sector as usize).min(corners.len() - 1);
    let outwards = (sector - index as f64).sqrt();
    let (a, b) = (corners[index], corners[(index + 1) % corners.len()]);
    (a * (1.0 - second) + b * second) * outwards
}

#[cfg(test)]
mod tests {
    use super::*;
    use snowgrain_math::sampler::{PathKey, numbers};

    /// Chi-square of points over a grid of `BINS` squared cells of the square around the opening,
    /// where `share` says how much of the opening lies in a cell, and its degrees of freedom.
    fn chi_square(aperture: &Aperture, inside: impl Fn(DVec2) -> bool) -> (f64, usize) {
        const BINS: usize = 8;
        const POINTS: u64 = 200_000;
        const FINE: usize = 200;
        let mut expected = [0.0; BINS * BINS];
        for i in 0..BINS * FINE {
            for j in 0..BINS * FINE {
                let at = |k: usize| 2.0 * (k as f64 + 0.5) / (BINS * FINE) as f64 - 1.0;
                expected[i / FINE * BINS + j / FINE] +=
                    f64::from(u8::from(inside(DVec2::new(at(i), at(j)))));
            }
        }
        let all: f64 = expected.iter().sum();
        let mut found = [0u32; BINS * BINS];
        for index in 0..POINTS {
            let [u, v, _] = numbers(PathKey::new(5, index, 0), 1);
            let point = aperture.sample([f64::from(u), f64::from(v)]);
            assert!(point.length() < 1.0 + 1e-12);
            let cell = |x: f64| (((x + 1.0) * 0.5 * BINS as f64) as usize).min(BINS - 1);
            found[cell(point.x) * BINS + cell(point.y)] += 1;
        }
        let (mut sum, mut cells) = (0.0, 0);
        for (&expected, &found) in expected.iter().zip(&found) {
            let expected = expected / all * POINTS as f64;
            if expected < 20.0 {
                // Too few for the statistic; none must lie where there is no opening.
                assert!(f64::from(found) < expected + 40.0);
                continue;
            }
            let difference = f64::from(found) - expected;
            sum += difference * difference / expected;
            cells += 1;
        }
        (sum, cells - 1)
    }

    /// The limits below are passed by chance with probability 10^-5 each (Wilson and Hilferty's
    /// quantile): a false alarm in 25 000 seeds.
    fn assert_uniform(name: &str, (sum, freedom): (f64, usize)) {
        let k = freedom as f64;
        let spread = 2.0 / (9.0 * k);
        let root = 1.0 - spread + 4.265 * spread.sqrt();
        let limit = k * root * root * root;
        assert!(sum < limit, "{name}: {sum} of {limit} with {freedom} degrees of freedom");
    }

    #[test]
    fn a_round_opening_is_covered_evenly_by_chi_square() {
        let round = Aperture::new(0, 0.0);
        assert_uniform("round", chi_square(&round, |p| p.length_squared() < 1.0));
    }

    #[test]
    fn openings_of_blades_are_covered_evenly_by_chi_square() {
        for (blades, rotation) in [(3, 0.0), (5, 17.0), (6, 90.0)] {
            let aperture = Aperture::new(blades, rotation);
            let Aperture::Polygon(corners) = &aperture else { panic!("blades make a polygon") };
            let inside = |p: DVec2| {
                (0..corners.len()).all(|i| {
                    let (a, b) = (corners[i], corners[(i + 1) % corners.len()]);
                    (b - a).perp_dot(p - a) > 0.0
                })
            };
            assert_uniform(&format!("{blades} blades"), chi_square(&aperture, inside));
        }
    }

    #[test]
    fn the_first_corner_is_up_and_turns_counter_clockwise() {
        let corner = |rotation| match Aperture::new(6, rotation) {
            Aperture::Polygon(corners) => corners[0],
            Aperture::Round => panic!("six blades"),
        };
        assert!((corner(0.0) - DVec2::Y).length() < 1e-15);
        assert!((corner(90.0) - DVec2::NEG_X).length() < 1e-15);
    }

    #[test]
    fn the_map_keeps_the_middle_and_the_edges() {
        let round = Aperture::Round;
        assert_eq!(round.sample([0.5, 0.5]), DVec2::ZERO);
        for edge in [[0.0, 0.3], [0.8, 0.0], [0.0, 0.0]] {
            assert!((round.sample(edge).length() - 1.0).abs() < 1e-15);
        }
    }
}
