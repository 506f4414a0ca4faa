//! How much of grains that reach into each other is counted twice: by straight lines through some of them.

use core::f64::consts::{PI, TAU};
use snowgrain_accel::{GrainGrid, GridGrain};
use snowgrain_geometry::{GrainShape, Shape, ShapeKind};
use snowgrain_math::sampler::{PathKey, numbers};
use snowgrain_math::{DMat3, DVec3, frame, trig};

/// Lines through grains, about: what is found has a standard error of .002 where much overlaps.
const LINES: u64 = 1 << 16;
/// Seed of the lines.
const SEED: u64 = 0x00e7_1a95;
/// How far outside of a grain is asked whether its surface is bare, in radii.
const OUTSIDE: f64 = 2e-4;
/// Grains that are told apart at one place.
const MOST: usize = 16;

/// What of the grains of a world is not in others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in super::super) struct Overlap {
    /// Bare surface over the surfaces of all grains.
    pub(in super::super) surface: f64,
    /// Volume of the ice over the volumes of all grains.
    pub(in super::super) volume: f64,
}

impl Overlap {
    /// Of a grid of so many grains, which have the shapes of these prototypes, if any. Lines of an even field meet the surface of a grain
    /// evenly, and its volume too.
    pub(super) fn of(grid: &GrainGrid, prototypes: &[Shape], grains: u64) -> Self {
        let ball = Shape::new(ShapeKind::Sphere).expect("a sphere has no number out of range");
        let (every, lines) = (grains.div_ceil(LINES), LINES.div_ceil(grains.max(1)));
        let (mut sums, mut number) = (Sums::default(), 0);
        grid.for_each_grain(|grain| {
            number += 1;
            if number % every != 0 {
                return;
            }
            let shape = grain.shape.map_or(&ball, |of| &prototypes[of.prototype()]);
            for line in 0..lines {
                sums.add(grid, (&grain, shape), PathKey::new(SEED, number, line));
            }
        });
        sums.overlap()
    }
}

#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    /// Ends of lines, each as often as it stands for surface, and those of them that are bare.
    ends: f64,
    bare: f64,
    /// Lengths of lines, as often as they stand for volume, and each divided among the grains at a place on it.
    lengths: f64,
    shared: f64,
}

impl Sums {
    /// Sends a line through a grain, whose numbers are those of the key.
    fn add(&mut self, grid: &GrainGrid, (grain, shape): (&GridGrain, &Shape), key: PathKey) {
        let [height, turn, away] = numbers(key, 0).map(f64::from);
        let [aside, place, _] = numbers(key, 1).map(f64::from);
        let y = 1.0 - 2.0 * height;
        let (sin, cos) = trig::sin_cos(TAU * turn);
        let across = (1.0 - y * y).max(0.0).sqrt();
        let direction = DVec3::new(across * cos, y, across * sin).normalize();
        let (s, t) = frame::tangents(direction);
        let (sin, cos) = trig::sin_cos(TAU * aside);
        let reach = shape.bounding_radius();
        let origin = (s * cos + t * sin) * (reach * away.sqrt());
        let Some([enters, leaves]) = shape.extent(origin, direction) else { return };
        let turned = grain.shape.map_or(DMat3::IDENTITY, GrainShape::rotation);
        let grains_at = |t: f64| {
            let place = grain.center + turned * (origin + direction * t) * grain.radius;
            grid.grains_at(place, MOST)
        };
        let area = PI * (reach * grain.radius) * (reach * grain.radius);
        for end in [enters - OUTSIDE, leaves + OUTSIDE] {
            self.ends += area;
            self.bare += if grains_at(end) == 0 { area } else { 0.0 };
        }
        let volume = area * (leaves - enters) * grain.radius;
        // A place on the very edge may be found in none.
        let there = grains_at(enters + place * (leaves - enters)).max(1);
        self.lengths += volume;
        self.shared += volume / there as f64;
    }

    fn overlap(&self) -> Overlap {
        let part = |of: f64, all: f64| if all > 0.0 { of / all } else { 1.0 };
        Overlap { surface: part(self.bare, self.ends), volume: part(self.shared, self.lengths) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use snowgrain_accel::{Packing, Surfaces};
    use snowgrain_geometry::Quantisation;

    /// Two balls one radius apart: each has a quarter of its surface in the other, and both share a lens of 5/32 of their volumes.
    #[test]
    fn two_balls_share_what_geometry_says() {
        let quantisation = Quantisation::for_grains(DVec3::ZERO, 1.0);
        let at = |x: f64| quantisation.round(DVec3::new(x, 0.0, 0.0), 1.0).unwrap();
        let found = |apart: f64| {
            let grains = [at(0.0), at(apart)];
            let surfaces = Surfaces::default();
            let grid = GrainGrid::build(quantisation, &grains[..], &surfaces, Packing::Fast);
            Overlap::of(&grid.unwrap(), &[], 2)
        };
        let Overlap { surface, volume } = found(1.0);
        // Five standard errors.
        assert!((surface - 0.75).abs() < 0.007, "{surface}");
        assert!((volume - (1.0 - 5.0 / 32.0)).abs() < 0.007, "{volume}");
        assert_eq!(found(2.5), Overlap { surface: 1.0, volume: 1.0 });
    }
}
