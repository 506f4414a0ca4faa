//! Passages through grains of several kinds.

use super::super::composition::Lying;
use super::super::scattering::{Azimuths, Passage, drawn_of};
use super::ShapePassages;
use snowgrain_geometry::Shape;
use snowgrain_math::DVec3;
use std::sync::Arc;

/// Passages through grains of each kind.
#[derive(Clone, Debug)]
pub(in super::super) struct ShapeKinds {
    passages: Vec<Arc<ShapePassages>>,
    /// Whether some do not lie in all orientations alike.
    lie: bool,
}

impl ShapeKinds {
    /// Of these shapes and this index, as their grains lie. What is followed for one shape in all orientations alike serves all its kinds.
    pub(in super::super) fn new(kinds: &[(&Shape, Option<&Lying>)], eta: f64) -> Self {
        let mut passages: Vec<Arc<ShapePassages>> = Vec::new();
        for (number, &(shape, lying)) in kinds.iter().enumerate() {
            let before = kinds[..number].iter().position(|before| *before == (shape, lying));
            let known = before.map(|before| Arc::clone(&passages[before]));
            passages.push(known.unwrap_or_else(|| Arc::new(ShapePassages::new(shape, lying, eta))));
        }
        Self { passages, lie: kinds.iter().any(|(_, lying)| lying.is_some()) }
    }

    /// Memory, bytes.
    pub(in super::super) fn memory_bytes(&self) -> u64 {
        self.passages.iter().map(|kind| kind.memory_bytes()).sum()
    }

    /// Whether some do not lie in all orientations alike.
    pub(in super::super) fn lie(&self) -> bool {
        self.lie
    }

    /// Area of the shadows that light of a direction meets, over the mean of all directions, of grains that have these parts of that.
    #[inline]
    pub(in super::super) fn shadow(&self, direction: DVec3, parts: &[u8]) -> f64 {
        if !self.lie {
            return 1.0;
        }
        let (mut sum, mut all) = (0.0, 0.0);
        for (part, passages) in parts.iter().map(|&part| f64::from(part)).zip(&self.passages) {
            sum += part * passages.shadow(direction);
            all += part;
        }
        if all > 0.0 { sum / all } else { self.passages[0].shadow(direction) }
    }

    /// The largest of these.
    pub(in super::super) fn largest_shadow(&self) -> f64 {
        self.passages.iter().map(|kind| kind.largest_shadow()).fold(0.0, f64::max)
    }

    /// What one of the grains that have these parts does to light, as it is or if it lets it straight through; and whether that goes
    /// straight on. Two uniform numbers.
    #[inline]
    pub(in super::super) fn draw(
        &self,
        direction: DVec3,
        azimuths: &Azimuths,
        (parts, [way, turn]): (&[u8], [f64; 2]),
        passes: bool,
    ) -> (Passage, bool) {
        let (kind, way) = match self.lie {
            false => drawn_of(parts, way, |_| 1.0),
            true => drawn_of(parts, way, |kind| self.passages[kind].shadow(direction)),
        };
        let passages = &self.passages[kind];
        let (passage, is_straight) = match passes {
            true => (passages.draw_straight(direction, azimuths, [way, turn]), true),
            false => passages.draw(direction, azimuths, [way, turn]),
        };
        (Passage { kind, ..passage }, is_straight)
    }

    /// Density of light that a grain of a kind turns from one direction into another, 1/sr, and one way of those that make it up; a
    /// uniform number. `None` where there is none.
    pub(in super::super) fn towards(
        &self,
        direction: DVec3,
        wanted: DVec3,
        (kind, random): (usize, f64),
    ) -> Option<(f64, Passage)> {
        self.passages[kind].towards(direction, wanted, random)
    }
}
