//! Passages of light through grains of one shape in all orientations alike: a grain at random has turned the plane in which a way
//! lies about the direction in which light comes in any way.

use super::super::scattering::Passage;
use super::{ShapePassage, ways};
use core::f64::consts::TAU;
use snowgrain_geometry::Shape;
use snowgrain_math::DVec3;

/// Ways that are followed, and kept twice. The mean length in ice is off by a part in 400.
const WAYS: usize = 1 << 16;
/// Passages that make up one step of the phase function.
const STEP: usize = 128;

/// Equally likely passages.
#[derive(Clone, Debug)]
pub(super) struct TurnedPassages {
    /// In rising order of the cosine by which light is turned; those that go straight on last.
    passages: Vec<ShapePassage>,
    /// Those that are turned.
    turned: usize,
    /// Cosines between which lie [`STEP`] passages, or what is left of them, in rising order.
    edges: Vec<f64>,
}

impl TurnedPassages {
    /// Of a shape of this refractive index.
    pub(super) fn new(shape: &Shape, eta: f64) -> Self {
        let mut passages: Vec<ShapePassage> =
            ways(shape, eta, WAYS).map(|way| ShapePassage::of(&way)).collect();
        passages.sort_by(|a, b| a.turn[0].total_cmp(&b.turn[0]));
        let turned = passages.partition_point(|passage| passage.turn[0] < 1.0);
        let cosine = |index: usize| f64::from(passages[index].turn[0]);
        let between = |index: usize| 0.5 * (cosine(index - 1) + cosine(index));
        let mut edges = vec![-1.0];
        edges.extend((STEP..turned).step_by(STEP).map(between));
        edges.push(1.0);
        Self { passages, turned, edges }
    }

    /// Memory, bytes.
    pub(super) fn memory_bytes(&self) -> u64 {
        (size_of_val(self.passages.as_slice()) + size_of_val(self.edges.as_slice())) as u64
    }

    /// One of the passages of light that arrives along a direction, aside of which is a unit vector; and whether it goes straight on.
    /// A uniform number.
    #[inline]
    pub(super) fn draw(&self, direction: DVec3, aside: DVec3, random: f64) -> (Passage, bool) {
        let index = (random * self.passages.len() as f64) as usize;
        (self.passages[index].along(direction, aside), index >= self.turned)
    }

    /// The same where it is let straight through.
    #[inline]
    pub(super) fn draw_straight(&self, direction: DVec3, aside: DVec3, random: f64) -> Passage {
        let index = (random * self.passages.len() as f64) as usize;
        self.passages[index].straight_along(direction, aside)
    }

    /// Density of light from one direction into another, 1/sr, of light that is turned, and one of the passages that make it up; a uniform
    /// number. `None` where there is none.
    pub(super) fn towards(
        &self,
        direction: DVec3,
        wanted: DVec3,
        random: f64,
    ) -> Option<(f64, Passage)> {
        let cosine = direction.dot(wanted).clamp(-1.0, 1.0);
        let above = self.edges.partition_point(|&edge| edge <= cosine);
        let step = above.clamp(1, self.edges.len() - 1) - 1;
        let first = step * STEP;
        let count = (self.turned.saturating_sub(first)).min(STEP);
        let width = self.edges[step + 1] - self.edges[step];
        if count == 0 || width <= 0.0 {
            return None;
        }
        let density = count as f64 / (self.turned as f64 * TAU * width);
        let index = first + (random * count as f64) as usize;
        Some((density, self.passages[index].turned_towards(direction, wanted)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use snowgrain_geometry::ShapeKind;
    use snowgrain_optics::scatter::ScatterTable;
    use snowgrain_optics::{Dielectric, sphere};

    fn mean(passages: &TurnedPassages, of: impl Fn(&ShapePassage) -> f64) -> f64 {
        passages.passages.iter().map(of).sum::<f64>() / passages.passages.len() as f64
    }

    /// A ball of samples scatters as the closed form does.
    #[test]
    fn a_ball_scatters_and_absorbs_as_the_sphere() {
        let ice = Dielectric { eta: 1.31 };
        let ball = TurnedPassages::new(&Shape::new(ShapeKind::Sphere).unwrap(), ice.eta);
        assert_eq!(ball.turned, ball.passages.len());
        let cosine = mean(&ball, |passage| passage.turn[0].into());
        assert!((cosine - sphere::asymmetry(ice)).abs() < 4e-3, "{cosine}");
        let length = mean(&ball, |passage| passage.length.into());
        let expected = 4.0 / 3.0 * sphere::absorption_enhancement(ice);
        assert!((length / expected - 1.0).abs() < 1e-2, "{length} {expected}");
        // Averaged over steps of a tenth: the density changes fast where light is turned little.
        let table = ScatterTable::for_air(ice);
        let averages = |density: &dyn Fn(f64) -> f64, from: f64| {
            (0..200).map(|at| density(from + (f64::from(at) + 0.5) * 5e-4)).sum::<f64>() / 200.0
        };
        for tenth in 0..20 {
            let from = -1.0 + 0.1 * f64::from(tenth);
            let wanted = |cosine: f64| DVec3::new(cosine, (1.0 - cosine * cosine).sqrt(), 0.0);
            let sampled = |cosine: f64| {
                ball.towards(DVec3::X, wanted(cosine), 0.3).map_or(0.0, |(density, _)| density)
            };
            let found = averages(&sampled, from);
            let expected = averages(&|cosine| table.density(cosine), from);
            // Five standard errors of the samples and a step of the density.
            let samples = expected * TAU * 0.1 * WAYS as f64;
            let allowed = expected * (5.0 / samples.sqrt() + STEP as f64 / (2.0 * samples)) + 1e-4;
            assert!((found - expected).abs() < allowed, "{from}: {found} {expected}");
        }
    }

    /// Light that a plate lets straight through is told apart, and the density of what is turned integrates to 1.
    #[test]
    fn a_plate_lets_some_light_straight_through() {
        let plate = ShapeKind::HexagonalPrism { aspect: 0.2, rounding: 0.0 };
        let plate = TurnedPassages::new(&Shape::new(plate).unwrap(), 1.31);
        let straight = 1.0 - plate.turned as f64 / plate.passages.len() as f64;
        assert!((0.1..0.9).contains(&straight), "{straight}");
        let steps = plate.edges.windows(2).map(|edges| {
            let cosine = 0.5 * (edges[0] + edges[1]);
            let wanted = DVec3::new(cosine, (1.0 - cosine * cosine).sqrt(), 0.0);
            let found = plate.towards(DVec3::X, wanted, 0.5);
            found.map_or(0.0, |(density, _)| density * TAU * (edges[1] - edges[0]))
        });
        let turned: f64 = steps.sum();
        assert!((turned - 1.0).abs() < 1e-6, "{turned}");
        let (passage, goes_on) = plate.draw(DVec3::Y, DVec3::X, 0.999_999);
        assert!(goes_on && passage.direction == DVec3::Y && passage.length > 0.0, "{passage:?}");
    }
}
