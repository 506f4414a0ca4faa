//! How much ice lies where, smoothed: the density of which a metaball is made of every grain.
//!
//! Each grain adds to the eight nodes around its centre, in proportion to its nearness along each axis, and between nodes
//! the density is trilinear. So every grain is a smooth ball two cells wide, as in Nishita et al. 1997 ("A Modeling and
//! Rendering Method for Snow by Using Metaballs", Computer Graphics Forum 16(3)), and the sum over all
//! space is the grains' own. What a ball would put into a solid object is given back to the snow before
//! it: a node's density counts by the part of its ball that is open.

use super::composition::{Composition, Overlap};
use crate::surface::Place;
use core::f64::consts::PI;
use snowgrain_accel::{GrainGrid, GridGrain, Surfaces};
use snowgrain_math::{Aabb, DVec3, Ray};

/// Edge of a cell in mean radii: about as many grains as neighbours of one, so that the density is even
/// where the snow is.
const CELL_IN_RADII: f64 = 4.0;
/// Most nodes; where there would be more they are farther apart.
const MOST_NODES: f64 = (1u64 << 25) as f64;
/// Places along each edge of a cell that a surface crosses at which is asked what is open.
const PLACES: usize = 4;
/// Least part of a ball that counts as open.
const LEAST_OPEN: f64 = 0.05;

/// What there is at a place, smoothed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Matter {
    /// Area of the grains' shadows by volume, 1/m: mean over all directions.
    pub(super) area: f64,
    /// Volume of the grains by volume.
    pub(super) solid: f64,
    /// Mean radius of the grains around, each by its area, metres; smoother than the others, for that light which goes back
    /// finds the same.
    pub(super) radius: f64,
}

impl Matter {
    fn of([area, solid, radius]: [f32; 3]) -> Self {
        Self { area: area.into(), solid: solid.into(), radius: radius.into() }
    }
}

/// The smoothed density of the grains of a grid.
#[derive(Clone, Debug)]
pub(super) struct Density {
    /// Place of the first node, and from node to node, metres.
    low: DVec3,
    pub(super) edges: DVec3,
    /// One over the edges.
    per_edge: DVec3,
    pub(super) nodes: [usize; 3],
    pub(super) repeats: [bool; 3],
    /// Area, volume and radius at each node, x fastest.
    pub(super) values: Vec<[f32; 3]>,
    /// Of each node the parts of the area that grains of each kind have, of 255; empty where there is one kind.
    parts: Vec<u8>,
    kinds: usize,
    /// Around all that is not empty; infinite along axes that repeat.
    pub(super) bounds: Aabb,
}

impl Density {
    /// Of all grains among these surfaces, whose places are in the order of the objects; `None` where there are
    /// no grains.
    pub(super) fn new(
        grid: &GrainGrid,
        composition: &Composition,
        (surfaces, places): (&Surfaces, &[Place]),
    ) -> Option<Self> {
        let [mut squares, mut cubes] = [0.0, 0.0];
        let mut around = Aabb::EMPTY;
        grid.for_each_grain(|GridGrain { center, radius, .. }| {
            squares += radius * radius;
            cubes += radius * radius * radius;
            around = around.including(center);
        });
        if squares <= 0.0 {
            return None;
        }
        let mut density = Self::empty(grid, around, CELL_IN_RADII * cubes / squares);
        density.kinds = composition.kinds();
        let per_volume = 1.0 / density.edges.to_array().iter().product::<f64>();
        let mut sums = vec![[0.0f64; 3]; density.values.len()];
        let is_mixed = density.kinds > 1;
        let mut areas = vec![0.0f32; if is_mixed { density.kinds * sums.len() } else { 0 }];
        grid.for_each_grain(|grain| {
            let kind = composition.kind(&grain);
            let GridGrain { center, radius, .. } = grain;
            let squares = radius * radius * per_volume;
            let area = composition.shadow(kind) * squares;
            for (node, weight) in density.around(center) {
                sums[node][0] += weight * area;
                sums[node][1] += weight * squares * radius * (4.0 / 3.0 * PI);
                sums[node][2] += weight * squares;
                if is_mixed {
                    areas[node * density.kinds + kind] += (weight * area) as f32;
                }
            }
        });
        if !surfaces.is_empty() {
            density.open_up(&mut sums, surfaces, places);
        }
        let Overlap { surface, volume } = composition.overlap();
        let radii = density.radii(&sums, cubes / squares);
        let value = |([area, solid, _], radius): (&[f64; 3], f32)| {
            // Where grains reach into each other, light meets fewer of them, and goes farther in each.
            let farther = (volume / surface) as f32;
            [(surface * area) as f32, (volume * solid) as f32, farther * radius]
        };
        density.values = sums.iter().zip(radii).map(value).collect();
        density.parts = density.parts_of(&areas);
        Some(density)
    }

    /// Of each node the mean radius around it, by volume over area; where there are no grains around that of all.
    fn radii(&self, sums: &[[f64; 3]], all: f64) -> Vec<f32> {
        let volumes: Vec<[f32; 2]> =
            sums.iter().map(|[_, solid, squares]| [*solid as f32, *squares as f32]).collect();
        let radius = |[solid, squares]: [f32; 2]| match squares > 0.0 {
            true => solid / squares * (0.75 / PI) as f32,
            false => all as f32,
        };
        self.means_around(volumes).into_iter().map(radius).collect()
    }

    /// Of each node the parts of the kinds around it, by their areas at each node.
    fn parts_of(&self, areas: &[f32]) -> Vec<u8> {
        let mut parts = vec![0; areas.len()];
        let mut means = vec![0.0f32; areas.len()];
        for kind in 0..self.kinds {
            let of_kind: Vec<[f32; 1]> =
                areas.iter().skip(kind).step_by(self.kinds).map(|&area| [area]).collect();
            if of_kind.is_empty() {
                return parts;
            }
            for (node, [mean]) in self.means_around(of_kind).into_iter().enumerate() {
                means[node * self.kinds + kind] = mean;
            }
        }
        for (parts, means) in parts.chunks_mut(self.kinds).zip(means.chunks(self.kinds)) {
            let all: f32 = means.iter().sum();
            for (part, mean) in parts.iter_mut().zip(means) {
                *part = if all > 0.0 { (255.0 * mean / all).round() as u8 } else { 1 };
            }
        }
        parts
    }

    fn empty(grid: &GrainGrid, around: Aabb, cell: f64) -> Self {
        let (period, repeats) = (grid.first_period(), grid.repeats());
        let mut cell = cell;
        loop {
            let (mut low, mut edges, mut nodes) = (DVec3::ZERO, DVec3::ZERO, [0; 3]);
            let mut bounds = around.expanded(cell);
            for axis in 0..3 {
                if repeats[axis] {
                    let length = period.max[axis] - period.min[axis];
                    let count = (length / cell).round().max(1.0);
                    (low[axis], edges[axis]) = (period.min[axis], length / count);
                    nodes[axis] = count as usize;
                    (bounds.min[axis], bounds.max[axis]) = (f64::NEG_INFINITY, f64::INFINITY);
                } else {
                    let length = around.max[axis] - around.min[axis];
                    (low[axis], edges[axis]) = (around.min[axis] - cell, cell);
                    nodes[axis] = (length / cell).ceil() as usize + 3;
                }
            }
            let count = nodes.iter().map(|&n| n as f64).product::<f64>();
            if count <= MOST_NODES {
                let values = vec![[0.0; 3]; nodes.iter().product()];
                let (per_edge, parts, kinds) = (edges.recip(), Vec::new(), 1);
                return Self { low, edges, per_edge, nodes, repeats, values, parts, kinds, bounds };
            }
            cell *= 2.0;
        }
    }

    /// A point in cells from the first node; of the nearest point within the nodes, or within the first period.
    #[inline]
    pub(super) fn coordinates(&self, point: DVec3) -> DVec3 {
        let mut at = (point - self.low) * self.per_edge;
        for axis in 0..3 {
            let count = self.nodes[axis] as f64;
            if !self.repeats[axis] {
                at[axis] = at[axis].clamp(0.0, count - 1.0);
            } else if !(0.0..count).contains(&at[axis]) {
                let within = at[axis] - count * (at[axis] / count).floor();
                at[axis] = within.clamp(0.0, count.next_down());
            }
        }
        at
    }

    /// The eight nodes around a point, and their weights.
    #[inline]
    fn around(&self, point: DVec3) -> [(usize, f64); 8] {
        let at = self.coordinates(point);
        let mut ends = [[0; 2]; 3];
        let mut parts = [[0.0; 2]; 3];
        for axis in 0..3 {
            let floor = at[axis] as usize;
            ends[axis] = [self.wrapped(floor, axis), self.wrapped(floor + 1, axis)];
            let part = at[axis] - floor as f64;
            parts[axis] = [1.0 - part, part];
        }
        let mut around = [(0, 0.0); 8];
        for (corner, (node, weight)) in around.iter_mut().enumerate() {
            let [i, j, k] = [corner & 1, corner >> 1 & 1, corner >> 2];
            *node = self.number([ends[0][i], ends[1][j], ends[2][k]]);
            *weight = parts[0][i] * parts[1][j] * parts[2][k];
        }
        around
    }

    /// The number of a node by its place in the grid.
    #[inline]
    pub(super) fn number(&self, [x, y, z]: [usize; 3]) -> usize {
        (z * self.nodes[1] + y) * self.nodes[0] + x
    }

    /// What there is at a point within the bounds.
    pub(super) fn at(&self, point: DVec3) -> Matter {
        let mut matter = Matter::default();
        for (node, weight) in self.around(point) {
            let [area, solid, radius] = self.values[node].map(f64::from);
            matter.area += weight * area;
            matter.solid += weight * solid;
            matter.radius += weight * radius;
        }
        matter
    }

    /// The parts of the area that grains of each kind have around a point, of about 255 in all; empty where there is one kind.
    pub(super) fn parts_near(&self, point: DVec3) -> &[u8] {
        if self.parts.is_empty() {
            return &[];
        }
        self.parts_at(self.nearest(self.coordinates(point)))
    }

    /// The same at a node.
    pub(super) fn parts_at(&self, node: usize) -> &[u8] {
        self.parts.get(node * self.kinds..(node + 1) * self.kinds).unwrap_or(&[])
    }

    /// What there is at one of the eight nodes around a point near the bounds, drawn as likely as its weight; a uniform number,
    /// of which eight bits serve each axis.
    pub(super) fn near(&self, point: DVec3, random: f64) -> Matter {
        let bits = (random * f64::from(1u32 << 24)) as u32;
        let at = self.coordinates(point);
        let mut node = [0; 3];
        for axis in 0..3 {
            let part = (f64::from(bits >> (8 * axis) & 0xff) + 0.5) / 256.0;
            node[axis] = self.wrapped((at[axis] + part) as usize, axis);
        }
        Matter::of(self.values[self.number(node)])
    }

    /// A node's number along an axis: within the grid.
    #[inline]
    fn wrapped(&self, index: usize, axis: usize) -> usize {
        let count = self.nodes[axis];
        match self.repeats[axis] {
            true if index >= count => index % count,
            true => index,
            false => index.min(count - 1),
        }
    }

    /// The number of the node nearest to a place in cells from the first.
    #[inline]
    pub(super) fn nearest(&self, at: DVec3) -> usize {
        let near = |axis: usize| self.wrapped((at[axis] + 0.5) as usize, axis);
        self.number([near(0), near(1), near(2)])
    }

    /// The numbers along an axis of the nodes that weigh in a block of them, or within a cell of it.
    pub(super) fn nodes_around(&self, axis: usize, block: usize, shift: u32) -> Vec<usize> {
        let (first, last) = (block << shift, ((block + 1) << shift).min(self.nodes[axis]));
        let count = self.nodes[axis].cast_signed();
        let index = |index: isize| match self.repeats[axis] {
            true => index.rem_euclid(count),
            false => index.clamp(0, count - 1),
        };
        (first.cast_signed() - 1..=last.cast_signed() + 1).map(|at| index(at) as usize).collect()
    }

    /// Places of all nodes, metres.
    pub(super) fn places(&self) -> impl Iterator<Item = DVec3> + '_ {
        let [nx, ny, nz] = self.nodes;
        let nodes =
            (0..nz).flat_map(move |z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])));
        nodes.map(|node| self.low + DVec3::from_array(node.map(|at| at as f64)) * self.edges)
    }

    /// The steepest way out of the snow at a point, by differences over half a cell; not of unit length.
    pub(super) fn outwards(&self, point: DVec3) -> DVec3 {
        let slope = |axis: usize| {
            let mut step = DVec3::ZERO;
            step[axis] = 0.5 * self.edges[axis];
            let [ahead, behind] = [point + step, point - step].map(|place| self.at(place).area);
            (behind - ahead) / self.edges[axis]
        };
        DVec3::from_array(std::array::from_fn(slope))
    }

    /// All that nodes hold.
    pub(super) fn nodes(&self) -> impl Iterator<Item = Matter> + '_ {
        self.values.iter().copied().map(Matter::of)
    }

    /// The shortest edge of a cell, metres.
    pub(super) fn shortest_edge(&self) -> f64 {
        self.edges.min_element()
    }

    /// What all nodes hold in the mean, each as often as its area.
    pub(super) fn mean(&self) -> Matter {
        let (mut sum, mut weight) = (Matter::default(), 0.0);
        for matter in self.nodes() {
            sum.area += matter.area * matter.area;
            sum.solid += matter.area * matter.solid;
            sum.radius += matter.area * matter.radius;
            weight += matter.area;
        }
        let [area, solid, radius] = [sum.area, sum.solid, sum.radius].map(|sum| sum / weight);
        Matter { area, solid, radius }
    }

    /// The corners of each cell, with the area there; of the cells between the first nodes and the last.
    pub(super) fn cells(&self) -> impl Iterator<Item = [(DVec3, f64); 8]> + '_ {
        let [nx, ny, nz] = self.nodes;
        let cells = (0..nz - 1)
            .flat_map(move |z| (0..ny - 1).flat_map(move |y| (0..nx - 1).map(move |x| [x, y, z])));
        cells.map(move |cell| {
            std::array::from_fn(|corner| {
                let node: [usize; 3] =
                    std::array::from_fn(|axis| cell[axis] + (corner >> axis & 1));
                let [x, y, z] = node;
                let place = DVec3::from_array(node.map(|index| index as f64));
                let area = self.values[(z * ny + y) * nx + x][0];
                (self.low + place * self.edges, f64::from(area))
            })
        })
    }

    /// Volume of a cell, cubic metres.
    #[cfg(test)]
    pub(super) fn volume_of_cell(&self) -> f64 {
        self.edges.to_array().iter().product()
    }

    /// Memory, bytes.
    pub(super) fn memory_bytes(&self) -> u64 {
        (size_of_val(self.values.as_slice()) + self.parts.len()) as u64
    }

    /// Divides each sum by the part of its ball that is not within solid objects.
    fn open_up(&self, sums: &mut [[f64; 3]], surfaces: &Surfaces, places: &[Place]) {
        let mut closed = vec![0.0f32; sums.len()];
        let cells = |axis: usize| self.nodes[axis] - usize::from(!self.repeats[axis]);
        for z in 0..cells(2) {
            for y in 0..cells(1) {
                for x in 0..cells(0) {
                    let low = self.low + DVec3::new(x as f64, y as f64, z as f64) * self.edges;
                    let middle = low + 0.5 * self.edges;
                    if self.around(middle).iter().all(|&(node, _)| sums[node] == [0.0; 3]) {
                        continue;
                    }
                    self.close(&mut closed, low, (surfaces, places));
                }
            }
        }
        for (sum, closed) in sums.iter_mut().zip(closed) {
            let open = (1.0 - f64::from(closed)).max(LEAST_OPEN);
            *sum = sum.map(|value| value / open);
        }
    }

    /// Adds to each node around a cell the part of its ball that is in the cell and within solid objects.
    fn close(&self, closed: &mut [f32], low: DVec3, (surfaces, places): (&Surfaces, &[Place])) {
        let crossed = surfaces.may_cross(&Aabb::new(low, low + self.edges));
        let count = if crossed { PLACES } else { 1 };
        let each = 1.0 / (count * count * count) as f64;
        for index in 0..count * count * count {
            let part = [index % count, index / count % count, index / (count * count)]
                .map(|place| (place as f64 + 0.5) / count as f64);
            let point = low + DVec3::from_array(part) * self.edges;
            if !is_within_solid(point, surfaces, places) {
                continue;
            }
            for (node, weight) in self.around(point) {
                closed[node] += (weight * each) as f32;
            }
        }
    }
}

/// Whether a point lies within a solid object, or below a surface that is open: what is first met straight
/// above is met from within.
pub(super) fn is_within_solid(point: DVec3, surfaces: &Surfaces, places: &[Place]) -> bool {
    let up = Ray::new(point, DVec3::Y);
    surfaces.intersect(&up, f64::INFINITY, None).is_some_and(|hit| {
        let place = &places[hit.id.object as usize];
        place.outwards(hit.id.piece, up.at(hit.t)).y > 0.0
    })
}
