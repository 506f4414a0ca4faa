//! Where the snow is the same all around: levelled out, so that paths go through it without looking where they are.
//!
//! Nodes four radii apart hold few grains, so their density varies by chance. Where the mean around a node is about that of most of the
//! snow, the snow's is put in its place. The mean is that of 125 nodes, the nearer the more: beside open air it is a third less, where half a cell is snow half.

use super::density::{Density, Matter};
use super::reach::Reach;

/// By how much means around nodes may differ from the snow's: of the area of shadows, of the radius, and of the part of the area that each
/// kind of grains has.
const SAME_AREA: f64 = 0.4;
const SAME_RADIUS: f64 = 0.05;
const SAME_PART: u8 = 26;

/// Nodes of snow that is everywhere the same.
#[derive(Clone, Debug)]
pub(super) struct Uniform {
    /// What each holds.
    pub(super) matter: Matter,
    /// The parts of the area that grains of each kind have, of about 255; empty where there is one kind.
    pub(super) parts: Vec<u8>,
    /// How far others are.
    pub(super) reach: Reach,
}

impl Uniform {
    /// Levels out the snow of which most of a density is made; `None` where it is nowhere the same.
    pub(super) fn level_out(density: &mut Density) -> Option<Self> {
        let areas = density.values.iter().map(|&[area, ..]| [area]).collect();
        let around = density.means_around(areas);
        let (most, parts) = most_of(density, &around)?;
        let is_same = |(node, &[area]): (usize, &[f32; 1])| {
            let radius = f64::from(density.values[node][2]);
            let [area, radius] =
                [f64::from(area) / most.area, radius / most.radius].map(|of| (of - 1.0).abs());
            let mut kinds = density.parts_at(node).iter().zip(&parts);
            area <= SAME_AREA
                && radius <= SAME_RADIUS
                && kinds.all(|(here, most)| here.abs_diff(*most) <= SAME_PART)
        };
        let reach = Reach::new(density, around.iter().enumerate().map(is_same));
        let (mut sum, mut count) = (Matter::default(), 0u64);
        for (matter, _) in density.nodes().zip(reach.marks()).filter(|(_, same)| *same) {
            sum.area += matter.area;
            sum.solid += matter.solid;
            sum.radius += matter.radius;
            count += 1;
        }
        if count == 0 {
            return None;
        }
        let mean = [sum.area, sum.solid, sum.radius].map(|sum| (sum / count as f64) as f32);
        let uniform = density.values.iter_mut().zip(reach.marks()).filter(|(_, same)| *same);
        uniform.for_each(|(value, _)| *value = mean);
        let [area, solid, radius] = mean.map(f64::from);
        Some(Self { matter: Matter { area, solid, radius }, parts, reach })
    }
}

/// What nodes hold of which half of the grains lie in fuller ones, by the means of areas around them, and of which kinds; `None` where
/// there is nothing.
fn most_of(density: &Density, areas: &[[f32; 1]]) -> Option<(Matter, Vec<u8>)> {
    let mut full: Vec<(usize, f32)> = areas.iter().map(|&[area]| area).enumerate().collect();
    full.retain(|&(_, area)| area > 0.0);
    full.sort_unstable_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
    let mut left = 0.5 * full.iter().map(|&(_, area)| f64::from(area)).sum::<f64>();
    let &(node, area) = full.iter().find(|&&(_, area)| {
        left -= f64::from(area);
        left <= 0.0
    })?;
    let [_, solid, radius] = density.values[node].map(f64::from);
    let parts = density.parts_at(node).to_vec();
    Some((Matter { area: area.into(), solid, radius }, parts))
}

impl Density {
    /// Of each node the mean of what it and those around it have, by 3, 2 and 1 along each axis; beyond the ends there is nothing.
    pub(super) fn means_around<const N: usize>(&self, of: Vec<[f32; N]>) -> Vec<[f32; N]> {
        let mut means = of;
        for axis in [0, 1, 2, 0, 1, 2] {
            self.mean_along(axis, &mut means);
        }
        means
    }

    /// Puts in place of each node the mean of it and of both beside it along an axis.
    fn mean_along<const N: usize>(&self, axis: usize, means: &mut [[f32; N]]) {
        let stride = [1, self.nodes[0], self.nodes[0] * self.nodes[1]][axis];
        let count = self.nodes[axis];
        let mut line = Vec::new();
        for start in (0..means.len()).filter(|start| (start / stride).is_multiple_of(count)) {
            line.clear();
            line.extend((0..count).map(|index| means[start + index * stride]));
            // What is beyond the ends, or at the others.
            let (first, last) = match self.repeats[axis] {
                true => (line[count - 1], line[0]),
                false => ([0.0; N], [0.0; N]),
            };
            for index in 0..count {
                let below = if index > 0 { line[index - 1] } else { first };
                let above = line.get(index + 1).copied().unwrap_or(last);
                means[start + index * stride] = std::array::from_fn(|what| {
                    (below[what] + line[index][what] + above[what]) * (1.0 / 3.0)
                });
            }
        }
    }
}
