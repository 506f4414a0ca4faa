//! Radii of the grains of a pack.

use crate::GrainField;

/// Classes of the histogram.
const SIZE_CLASSES: usize = 20;

/// Radii of the grains of a pack, metres.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sizes {
    /// By number.
    pub mean: f64,
    /// Standard deviation, by number.
    pub deviation: f64,
    /// Radius of equal grains of the same volume and surface, overlaps left aside.
    pub effective: f64,
    /// Least and greatest.
    pub range: [f64; 2],
    /// Radius (middle of a class), and part of all grains.
    pub classes: Vec<(f64, f64)>,
}

impl Sizes {
    pub(super) fn of(field: &GrainField) -> Self {
        let radii: Vec<f64> = field.iter().map(|grain| grain.radius).collect();
        let count = radii.len() as f64;
        if radii.is_empty() {
            return Self::default();
        }
        let sum = |of: fn(f64) -> f64| radii.iter().map(|&radius| of(radius)).sum::<f64>();
        let mean = sum(|r| r) / count;
        let squares = sum(|r| r * r);
        let low = radii.iter().copied().fold(f64::INFINITY, f64::min);
        let high = radii.iter().copied().fold(0.0, f64::max);
        let width = (high - low) / SIZE_CLASSES as f64;
        let mut counts = vec![0u64; if width > 0.0 { SIZE_CLASSES } else { 1 }];
        for radius in &radii {
            let class = if width > 0.0 { ((radius - low) / width) as usize } else { 0 };
            counts[class.min(SIZE_CLASSES - 1)] += 1;
        }
        let class = |(index, &count_in): (usize, &u64)| {
            (low + (index as f64 + 0.5) * width, count_in as f64 / count)
        };
        Self {
            mean,
            deviation: (squares / count - mean * mean).max(0.0).sqrt(),
            effective: sum(|r| r * r * r) / squares,
            range: [low, high],
            classes: counts.iter().enumerate().map(class).collect(),
        }
    }
}
