//! Grains that repeat along x and z, each coated with a film of water of the same thickness: what a ray
//! meets next. Films that touch are one body of water.

use snowgrain_geometry::Grain;
use snowgrain_math::{DVec3, Ray};

/// Rounding of distances, in radii of a grain: what is met nearer than this before a point counts as met
/// there.
const ROUNDING: f64 = 1e-11;

/// The pack.
#[derive(Debug)]
pub(super) struct Coated {
    /// Centres of the grains, x and z in [0, period), metres.
    centers: Vec<DVec3>,
    /// Of all grains, metres.
    radius: f64,
    /// Of the film, metres; 0: the grains are dry.
    pub(super) film: f64,
    period: [f64; 2],
    /// Lowest and highest water or ice, metres.
    pub(super) heights: [f64; 2],
    /// Edges of the cells, and their number along each axis.
    side: DVec3,
    cells: [i64; 3],
    /// Of each cell, where its list begins; one more at the end.
    starts: Vec<u32>,
    /// Grains whose film reaches into a cell, at the place of their image nearest to it.
    lists: Vec<(u32, DVec3)>,
}

/// A ray's way through a sphere: where it enters and leaves it.
#[derive(Clone, Copy)]
struct Interval {
    grain: u32,
    enters: f64,
    leaves: f64,
}

/// What a ray in water meets.
pub(super) enum InWater {
    /// A grain, at this distance.
    Grain(Meeting),
    /// The air, through the film of a grain.
    Air(Meeting),
}

/// A meeting with the surface of a grain or of its film.
#[derive(Clone, Copy, Debug)]
pub(super) struct Meeting {
    /// Distance along the ray.
    pub(super) distance: f64,
    /// Number of the grain.
    pub(super) grain: u32,
    /// Outward unit normal there.
    pub(super) normal: DVec3,
}

impl Coated {
    /// `grains` of one radius, none of which overlaps another; `periods` along x and z, metres.
    pub(super) fn new(grains: &[Grain], periods: [f64; 2], film: f64) -> Self {
        let radius = grains.iter().map(|grain| grain.radius).fold(0.0, f64::max);
        let wrap = |center: DVec3| {
            DVec3::new(center.x.rem_euclid(periods[0]), center.y, center.z.rem_euclid(periods[1]))
        };
        let centers: Vec<DVec3> = grains.iter().map(|grain| wrap(grain.center)).collect();
        let reach = radius + film;
        let heights = centers.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], c| {
            [low.min(c.y - reach), high.max(c.y + reach)]
        });
        let extent = DVec3::new(periods[0], heights[1] - heights[0], periods[1]);
        let cells = (extent / (1.5 * reach)).floor().max(DVec3::ONE);
        let mut pack = Self {
            centers,
            radius,
            film,
            period: periods,
            heights,
            side: extent / cells,
            cells: cells.to_array().map(|count| count as i64),
            starts: Vec::new(),
            lists: Vec::new(),
        };
        pack.list();
        pack
    }

    /// Lists the grains of every cell.
    fn list(&mut self) {
        let reach = self.radius + self.film;
        let mut entries = Vec::new();
        for (grain, &center) in (0u32..).zip(&self.centers) {
            let [low, high] =
                [-reach, reach].map(|offset| self.cell_of(center + DVec3::splat(offset)));
            for z in low[2]..=high[2] {
                for y in low[1].max(0)..=high[1].min(self.cells[1] - 1) {
                    for x in low[0]..=high[0] {
                        let (index, shift) = self.wrapped([x, y, z]);
                        entries.push((index, grain, center - shift));
                    }
                }
            }
        }
        entries.sort_by_key(|&(index, grain, _)| (index, grain));
        let count = self.cells.iter().product::<i64>() as usize;
        self.starts = vec![0; count + 1];
        entries.iter().for_each(|(index, ..)| self.starts[index + 1] += 1);
        for index in 0..count {
            self.starts[index + 1] += self.starts[index];
        }
        self.lists = entries.into_iter().map(|(_, grain, center)| (grain, center)).collect();
    }

    /// The cell of a point, which may lie in another period.
    fn cell_of(&self, point: DVec3) -> [i64; 3] {
        let place = (point - DVec3::Y * self.heights[0]) / self.side;
        place.floor().to_array().map(|place| place as i64)
    }

    /// The number of a cell in the first period, and what moves that one here.
    fn wrapped(&self, [x, y, z]: [i64; 3]) -> (usize, DVec3) {
        let periods = |at: i64, axis: usize| at.div_euclid(self.cells[axis]);
        let [i, k] = [periods(x, 0), periods(z, 2)];
        let (x, z) = (x - i * self.cells[0], z - k * self.cells[2]);
        let shift = DVec3::new(i as f64 * self.period[0], 0.0, k as f64 * self.period[1]);
        (((z * self.cells[1] + y) * self.cells[0] + x) as usize, shift)
    }

    /// The grains of a cell and where they are.
    fn grains_in(&self, cell: [i64; 3]) -> impl Iterator<Item = (u32, DVec3)> + '_ {
        let (index, shift) = self.wrapped(cell);
        let list = self.starts[index] as usize..self.starts[index + 1] as usize;
        self.lists[list].iter().map(move |&(grain, center)| (grain, center + shift))
    }

    /// Where a ray enters and leaves the sphere of `radius` around `center`.
    fn interval(ray: &Ray, grain: u32, center: DVec3, radius: f64) -> Option<Interval> {
        let to_center = center - ray.origin;
        let middle = to_center.dot(ray.direction);
        let foot = to_center - ray.direction * middle;
        let half2 = radius * radius - foot.length_squared();
        let half = (half2 > 0.0).then(|| half2.sqrt())?;
        Some(Interval { grain, enters: middle - half, leaves: middle + half })
    }

    fn meeting(&self, ray: &Ray, distance: f64, grain: u32, radius: f64) -> Meeting {
        let point = ray.at(distance);
        let center = self.image_near(grain, point);
        Meeting { distance, grain, normal: ((point - center) / radius).normalize() }
    }

    /// The centre of the image of a grain that is nearest to a point.
    fn image_near(&self, grain: u32, point: DVec3) -> DVec3 {
        let center = self.centers[grain as usize];
        let turns = |from: f64, to: f64, period: f64| ((to - from) / period).round() * period;
        let x = turns(center.x, point.x, self.period[0]);
        let z = turns(center.z, point.z, self.period[1]);
        center + DVec3::new(x, 0.0, z)
    }

    /// From air: the first film (or dry grain) that is entered, other than that of `left`, which the ray
    /// leaves and cannot meet again.
    pub(super) fn meet_in_air(&self, ray: &Ray, left: Option<u32>) -> Option<Meeting> {
        let radius = self.radius + self.film;
        let mut nearest: Option<(f64, u32)> = None;
        let mut walk = CellWalk::new(self, ray)?;
        loop {
            nearest = self.nearer(ray, walk.cell, (radius, left), nearest);
            match nearest {
                Some((distance, grain)) if distance <= walk.leaves => {
                    return Some(self.meeting(ray, distance.max(0.0), grain, radius));
                }
                _ => walk.step(self, ray)?,
            }
        }
    }

    /// The nearest of what is known and the spheres of `radius` around the grains of a cell that the ray
    /// enters, other than that of `left` on which it starts: distance and grain.
    fn nearer(
        &self,
        ray: &Ray,
        cell: [i64; 3],
        (radius, left): (f64, Option<u32>),
        known: Option<(f64, u32)>,
    ) -> Option<(f64, u32)> {
        let mut nearest = known;
        for (grain, center) in self.grains_in(cell) {
            if Some(grain) == left && self.is_image_of_start(ray, center, radius) {
                continue;
            }
            let Some(way) = Self::interval(ray, grain, center, radius) else { continue };
            let ahead = way.enters + way.leaves > 0.0;
            if ahead && nearest.is_none_or(|(distance, _)| way.enters < distance) {
                nearest = Some((way.enters, grain));
            }
        }
        nearest
    }

    /// Whether a ray starts on the surface of the sphere around `center`: other images of the grain that
    /// it left may be met.
    fn is_image_of_start(&self, ray: &Ray, center: DVec3, radius: f64) -> bool {
        (ray.origin.distance(center) - radius).abs() < 1e-6 * self.radius
    }

    /// From a point in the film of `within`: the first grain, other than `left`, or the air.
    pub(super) fn meet_in_water(&self, ray: &Ray, within: u32, left: Option<u32>) -> InWater {
        let (radius, outer) = (self.radius, self.radius + self.film);
        let rounding = ROUNDING * radius;
        let mut films: Vec<Interval> = Vec::new();
        let center = self.image_near(within, ray.origin);
        let mut until = Self::interval(ray, within, center, outer).map_or(0.0, |way| way.leaves);
        let mut last = within;
        let mut nearest: Option<(f64, u32)> = None;
        let Some(mut walk) = CellWalk::new(self, ray) else {
            return InWater::Air(self.meeting(ray, until.max(0.0), last, outer));
        };
        loop {
            let grains = self.grains_in(walk.cell);
            films.extend(grains.filter_map(|(grain, at)| Self::interval(ray, grain, at, outer)));
            nearest = self.nearer(ray, walk.cell, (radius, left), nearest);
            while let Some(on) = films
                .iter()
                .find(|way| way.enters <= until + rounding && way.leaves > until + rounding)
            {
                (until, last) = (on.leaves, on.grain);
            }
            let known = until.min(walk.leaves);
            if let Some((distance, grain)) = nearest
                && distance <= known + rounding
            {
                return InWater::Grain(self.meeting(ray, distance.max(0.0), grain, radius));
            }
            if until <= walk.leaves || walk.step(self, ray).is_none() {
                return InWater::Air(self.meeting(ray, until.max(0.0), last, outer));
            }
        }
    }

    /// From a point on or in a grain: where the ray leaves it.
    pub(super) fn meet_in_ice(&self, ray: &Ray, grain: u32) -> Meeting {
        let center = self.image_near(grain, ray.origin);
        let leaves = Self::interval(ray, grain, center, self.radius).map_or(0.0, |way| way.leaves);
        self.meeting(ray, leaves.max(0.0), grain, self.radius)
    }

    /// Distance of a point from the nearest grain, metres, 0 within one; `None` where that is more than
    /// the film.
    pub(super) fn distance_from_grains(&self, point: DVec3) -> Option<f64> {
        let nearest = self
            .grains_in(self.cell_of(point))
            .map(|(_, center)| point.distance(center) - self.radius)
            .fold(f64::INFINITY, f64::min);
        (nearest <= self.film).then_some(nearest.max(0.0))
    }
}

/// The cells along a ray, between the lowest and the highest.
struct CellWalk {
    cell: [i64; 3],
    /// Distance at which the ray leaves the cell.
    leaves: f64,
    /// Distances to the next face along each axis, and between faces.
    next: [f64; 3],
    between: [f64; 3],
}

impl CellWalk {
    /// From where the ray enters the layer; `None` where it does not.
    fn new(pack: &Coated, ray: &Ray) -> Option<Self> {
        let [low, high] = pack.heights;
        let (y, slope) = (ray.origin.y, ray.direction.y);
        let start = match y {
            y if y > high => (high - y) / slope,
            y if y < low => (low - y) / slope,
            _ => 0.0,
        };
        if !(start >= 0.0 && start.is_finite()) {
            return None;
        }
        let from = ray.at(start);
        let mut cell = pack.cell_of(from);
        cell[1] = cell[1].clamp(0, pack.cells[1] - 1);
        let origin = from - DVec3::Y * low;
        let (mut next, mut between) = ([f64::INFINITY; 3], [f64::INFINITY; 3]);
        for axis in 0..3 {
            let along = ray.direction[axis];
            if along != 0.0 {
                let face = cell[axis] + i64::from(along > 0.0);
                next[axis] = start + (face as f64 * pack.side[axis] - origin[axis]) / along;
                between[axis] = pack.side[axis] / along.abs();
            }
        }
        let leaves = next.into_iter().fold(f64::INFINITY, f64::min);
        Some(Self { cell, leaves, next, between })
    }

    /// On to the next cell; `None` out of the layer.
    fn step(&mut self, pack: &Coated, ray: &Ray) -> Option<()> {
        let axis = (0..3).min_by(|&a, &b| self.next[a].total_cmp(&self.next[b]))?;
        self.cell[axis] += if ray.direction[axis] > 0.0 { 1 } else { -1 };
        self.next[axis] += self.between[axis];
        self.leaves = self.next.into_iter().fold(f64::INFINITY, f64::min);
        (0..pack.cells[1]).contains(&self.cell[1]).then_some(())
    }
}
