//! Where the snow is the same all around: levelled out, so that paths go through it without looking where they are.
//!
//! Nodes four radii apart hold few grains, so their density varies by chance. Where the mean around a node is about that of most of the
//! snow, the snow's is put in its place. The mean is that of 125 nodes, the nearer the more: beside open air it is a third less, where half a cell is snow half.

use super::density::{Density, Matter};
use super::reach::Reach;

/// By how much means around nodes may differ from the snow's: of the area of discs and of the radius.
const SAME_AREA: f64 = 0.4;
const SAME_RADIUS: f64 = 0.05;

/// Nodes of snow that is everywhere the same.
#[derive(Clone, Debug)]
pub(super) struct Uniform {
    /// What each holds.
    pub(super) matter: Matter,
    /// How far others are.
    pub(super) reach: Reach,
}

impl Uniform {
    /// Levels out the snow of which most of a density is made; `None` where it is nowhere the same.
    pub(super) fn level_out(density: &mut Density) -> Option<Self> {
        let around = density.means_around();
        let most = most_of(&around);
        let is_same = |&[area, solid]: &[f32; 2]| {
            let matter = Matter { area: f64::from(area), solid: f64::from(solid) };
            let [area, radius] = [matter.area / most.area, matter.radius() / most.radius()]
                .map(|of| (of - 1.0).abs());
            area <= SAME_AREA && radius <= SAME_RADIUS
        };
        let reach = Reach::new(density, around.iter().map(is_same));
        let (mut sum, mut count) = (Matter::default(), 0u64);
        for (matter, _) in density.nodes().zip(reach.marks()).filter(|(_, same)| *same) {
            sum.area += matter.area;
            sum.solid += matter.solid;
            count += 1;
        }
        if count == 0 {
            return None;
        }
        let mean = [sum.area, sum.solid].map(|sum| (sum / count as f64) as f32);
        let uniform = density.values.iter_mut().zip(reach.marks()).filter(|(_, same)| *same);
        uniform.for_each(|(value, _)| *value = mean);
        let [area, solid] = mean.map(f64::from);
        Some(Self { matter: Matter { area, solid }, reach })
    }
}

/// What nodes hold of which half of the grains lie in fuller ones.
fn most_of(nodes: &[[f32; 2]]) -> Matter {
    let mut full: Vec<[f32; 2]> = nodes.iter().copied().filter(|node| node[0] > 0.0).collect();
    full.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let mut left = 0.5 * full.iter().map(|node| f64::from(node[0])).sum::<f64>();
    let middle = full.iter().find(|node| {
        left -= f64::from(node[0]);
        left <= 0.0
    });
    middle.map_or(Matter::default(), |&[area, solid]| Matter {
        area: f64::from(area),
        solid: f64::from(solid),
    })
}

impl Density {
    /// Of each node the mean of it and of those around it, by 3, 2 and 1 along each axis; beyond the ends there is nothing.
    fn means_around(&self) -> Vec<[f32; 2]> {
        let mut means = self.values.clone();
        for axis in [0, 1, 2, 0, 1, 2] {
            self.mean_along(axis, &mut means);
        }
        means
    }

    /// Puts in place of each node the mean of it and of both beside it along an axis.
    fn mean_along(&self, axis: usize, means: &mut [[f32; 2]]) {
        let stride = [1, self.nodes[0], self.nodes[0] * self.nodes[1]][axis];
        let count = self.nodes[axis];
        let mut line = Vec::new();
        for start in (0..means.len()).filter(|start| (start / stride).is_multiple_of(count)) {
            line.clear();
            line.extend((0..count).map(|index| means[start + index * stride]));
            // What is beyond the ends, or at the others.
            let (first, last) = match self.repeats[axis] {
                true => (line[count - 1], line[0]),
                false => ([0.0; 2], [0.0; 2]),
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
