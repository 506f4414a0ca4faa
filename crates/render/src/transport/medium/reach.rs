//! How far nodes of a density are from the nearest that are not of a kind.

use super::density::Density;
use snowgrain_math::DVec3;

/// Of each node of a kind its distance from the nearest other, in nodes along the axis along which it is largest, up to 255; 0 of
/// the others themselves.
#[derive(Clone, Debug)]
pub(super) struct Reach {
    distances: Vec<u8>,
}

impl Reach {
    /// From a mark of each node, which tells whether it is of the kind.
    pub(super) fn new(density: &Density, marks: impl Iterator<Item = bool>) -> Self {
        let mut distances: Vec<u8> = marks.map(|mark| if mark { u8::MAX } else { 0 }).collect();
        density.measure_reach(&mut distances);
        Self { distances }
    }

    /// Whether each node is of the kind.
    pub(super) fn marks(&self) -> impl Iterator<Item = bool> + '_ {
        self.distances.iter().map(|&distance| distance > 0)
    }

    /// Whether each node is farther from others, in nodes.
    pub(super) fn farther_than(&self, far: f64) -> impl Iterator<Item = bool> + '_ {
        self.distances.iter().map(move |&distance| f64::from(distance) > far)
    }

    /// Whether a place, told in cells, is nearest to a node of the kind.
    #[inline]
    pub(super) fn holds(&self, density: &Density, at: DVec3) -> bool {
        self.distances[density.nearest(at)] > 0
    }

    /// How far around a place, told in cells, all is of the kind, in cells along each axis: half a cell farther, where grains are
    /// that are met within, and the nodes that weigh there. Negative where that is not so at the place.
    #[inline(always)]
    pub(super) fn room(&self, density: &Density, at: DVec3) -> f64 {
        f64::from(self.distances[density.nearest(at)]) - 3.0
    }

    /// How far around a place, told in cells, all places are nearer to nodes of the kind than to others, in cells along each axis.
    pub(super) fn near(&self, density: &Density, at: DVec3) -> f64 {
        f64::from(self.distances[density.nearest(at)]) - 2.0
    }

    /// The largest distance of all.
    pub(super) fn most(&self) -> f64 {
        f64::from(self.distances.iter().copied().max().unwrap_or(0))
    }

    /// Memory, bytes.
    pub(super) fn memory_bytes(&self) -> u64 {
        size_of_val(self.distances.as_slice()) as u64
    }
}

impl Density {
    /// Turns the greatest distance of each node of a kind into its own, by Rosenfeld and Pfaltz's two passes, twice where
    /// the nodes repeat.
    fn measure_reach(&self, reach: &mut [u8]) {
        let passes = if self.repeats.contains(&true) { 2 } else { 1 };
        for _ in 0..passes {
            self.pass_reach(reach, false);
            self.pass_reach(reach, true);
        }
    }

    /// One pass over all nodes, each by those that came before.
    fn pass_reach(&self, reach: &mut [u8], backwards: bool) {
        let [nx, ny, _] = self.nodes;
        let before: [[isize; 3]; 13] = std::array::from_fn(|index| {
            let offset = [index % 3, index / 3 % 3, index / 9].map(|part| part.cast_signed() - 1);
            if backwards { offset.map(|part| -part) } else { offset }
        });
        for order in 0..reach.len() {
            let number = if backwards { reach.len() - 1 - order } else { order };
            if reach[number] == 0 {
                continue;
            }
            let node = [number % nx, number / nx % ny, number / (nx * ny)];
            for offset in before {
                let nearest = self.beside(node, offset).map_or(0, |beside| reach[beside]);
                reach[number] = reach[number].min(nearest.saturating_add(1));
            }
        }
    }

    /// The number of a node beside another, if there is one.
    fn beside(&self, node: [usize; 3], offset: [isize; 3]) -> Option<usize> {
        let mut beside = [0; 3];
        for axis in 0..3 {
            let (count, index) = (self.nodes[axis], node[axis].checked_add_signed(offset[axis]));
            beside[axis] = match (index, self.repeats[axis]) {
                (Some(index), _) if index < count => index,
                (Some(_), true) => 0,
                (None, true) => count - 1,
                _ => return None,
            };
        }
        Some(self.number(beside))
    }
}
