//! Which balls are near: all of them, or those of a uniform list of cells.

use crate::ball::Ball;
use snowgrain_geometry::Grain;
use snowgrain_math::{Aabb, DVec3, IVec3};

/// How the oracle looks for grains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Search {
    /// Every grain is tested every time: for tiny scenes, and to check the cells.
    Brute,
    /// A uniform list of cells.
    Cells,
    /// A uniform list of cells; the grains repeat along x and z with these periods.
    Periodic {
        /// Period along x and along z.
        period: [f64; 2],
    },
}

/// Answers of the search about the balls along a ray.
pub(crate) struct GrainSearch {
    grains: Vec<Grain>,
    cells: Option<Cells>,
}

impl GrainSearch {
    pub(crate) fn new(grains: &[Grain], search: Search) -> Self {
        let cells = match search {
            Search::Brute => None,
            Search::Cells => Some(Cells::new(grains, None)),
            Search::Periodic { period } => Some(Cells::new(grains, Some(period))),
        };
        Self { grains: grains.to_vec(), cells }
    }

    /// The periods of the snow.
    pub(crate) fn period(&self) -> Option<[f64; 2]> {
        self.cells.as_ref().and_then(|cells| cells.period)
    }

    /// The ball entered first from air, at a distance of at most `limit`.
    pub(crate) fn first_entry(
        &self,
        origin: DVec3,
        direction: DVec3,
        limit: f64,
    ) -> Option<(f64, Ball)> {
        let mut best: Option<(f64, Ball)> = None;
        let mut test = |ball: Ball| {
            if let Some(t) = ball.entry(origin, direction)
                && t <= best.map_or(limit, |(nearest, _)| nearest)
            {
                best = Some((t, ball));
            }
            best.map_or(limit, |(nearest, _)| nearest)
        };
        match &self.cells {
            None => {
                for ball in self.all() {
                    test(ball);
                }
            }
            Some(cells) => cells.along(&self.grains, origin, direction, limit, test),
        }
        best
    }

    /// Among the balls that hold the point at `t` along the ray (its start included, its end not),
    /// other than `current`, the one whose interval ends farthest, with that end.
    pub(crate) fn farthest_cover(
        &self,
        origin: DVec3,
        direction: DVec3,
        t: f64,
        current: &Ball,
    ) -> Option<(f64, Ball)> {
        let mut best: Option<(f64, Ball)> = None;
        let mut test = |ball: Ball| {
            if ball != *current
                && let Some((t0, t1)) = ball.interval(origin, direction)
                && t0 <= t
                && t < t1
                && best.is_none_or(|(farthest, _)| t1 > farthest)
            {
                best = Some((t1, ball));
            }
        };
        match &self.cells {
            None => self.all().for_each(&mut test),
            Some(cells) => cells.at(&self.grains, origin + direction * t, test),
        }
        best
    }

    /// A ball that holds `point` strictly inside.
    pub(crate) fn holding(&self, point: DVec3) -> Option<Ball> {
        let mut found = None;
        let mut test = |ball: Ball| {
            if (point - ball.center).length_squared() < ball.radius * ball.radius {
                found = Some(ball);
            }
        };
        match &self.cells {
            None => self.all().for_each(&mut test),
            Some(cells) => cells.at(&self.grains, point, test),
        }
        found
    }

    fn all(&self) -> impl Iterator<Item = Ball> + '_ {
        self.grains.iter().enumerate().map(|(grain, g)| Ball {
            grain,
            center: g.center,
            radius: g.radius,
        })
    }
}

/// A grain that reaches into a cell, `laps` periods away from where it is stored.
#[derive(Clone, Copy)]
struct Entry {
    grain: u32,
    laps: [i32; 2],
}

/// Cubic (in a period: nearly cubic) cells, each with every ball that reaches into it.
struct Cells {
    origin: DVec3,
    side: DVec3,
    counts: IVec3,
    period: Option<[f64; 2]>,
    lists: Vec<Vec<Entry>>,
}

impl Cells {
    /// Share of a cell's side by which balls are grown when they are listed, so that the rounding
    /// of a walk along a cell's face never hides one.
    const MARGIN: f64 = 1e-6;

    fn new(grains: &[Grain], period: Option<[f64; 2]>) -> Self {
        let bounds = grains.iter().fold(Aabb::EMPTY, |b, g| {
            b.union(&Aabb::new(g.center - g.radius, g.center + g.radius))
        });
        let bounds = if grains.is_empty() { Aabb::new(DVec3::ZERO, DVec3::ONE) } else { bounds };
        let largest = grains.iter().fold(0.0f64, |r, g| r.max(g.radius));
        let volume = bounds.size().max(DVec3::splat(1e-9)).element_product();
        let sparse = snowgrain_math::trig::cbrt(volume / (grains.len() + 1) as f64);
        let target = (2.5 * largest).max(sparse);
        let mut origin = bounds.min - 0.1 * target;
        let mut side = DVec3::splat(target);
        let mut counts = ((bounds.max + 0.1 * target - origin) / side).ceil().as_ivec3();
        if let Some(period) = period {
            for (axis, length) in [(0, period[0]), (2, period[1])] {
                origin[axis] = 0.0;
                counts[axis] = ((length / target).floor() as i32).max(1);
                side[axis] = length / f64::from(counts[axis]);
            }
        }
        let mut cells = Self { origin, side, counts, period, lists: Vec::new() };
        cells.lists = vec![Vec::new(); counts.to_array().map(|n| n as usize).iter().product()];
        for (index, grain) in grains.iter().enumerate() {
            cells.list(index as u32, grain);
        }
        cells
    }

    fn list(&mut self, grain: u32, ball: &Grain) {
        let reach = DVec3::splat(ball.radius) + self.side * Self::MARGIN;
        let low = ((ball.center - reach - self.origin) / self.side).floor().as_ivec3();
        let high = ((ball.center + reach - self.origin) / self.side).floor().as_ivec3();
        for z in low.z..=high.z {
            for y in low.y..=high.y {
                for x in low.x..=high.x {
                    if let Some((cell, laps)) = self.locate(IVec3::new(x, y, z)) {
                        self.lists[cell].push(Entry { grain, laps: [-laps[0], -laps[1]] });
                    }
                }
            }
        }
    }

    /// The list of a cell and the periods between the cell and its stored twin; `None` outside.
    fn locate(&self, cell: IVec3) -> Option<(usize, [i32; 2])> {
        let mut stored = cell;
        let mut laps = [0, 0];
        if self.period.is_some() {
            laps = [cell.x.div_euclid(self.counts.x), cell.z.div_euclid(self.counts.z)];
            stored.x = cell.x.rem_euclid(self.counts.x);
            stored.z = cell.z.rem_euclid(self.counts.z);
        }
        let inside = stored.cmpge(IVec3::ZERO).all() && stored.cmplt(self.counts).all();
        inside.then(|| {
            let index = (stored.z * self.counts.y + stored.y) * self.counts.x + stored.x;
            (index as usize, laps)
        })
    }

    /// Shows `visit` every ball that reaches into `cell`; whether the cell exists.
    fn visit(&self, grains: &[Grain], cell: IVec3, mut visit: impl FnMut(Ball)) -> bool {
        let Some((list, laps)) = self.locate(cell) else { return false };
        let period = self.period.unwrap_or([0.0, 0.0]);
        for entry in &self.lists[list] {
            let grain = entry.grain as usize;
            let shift = DVec3::new(
                f64::from(laps[0] + entry.laps[0]) * period[0],
                0.0,
                f64::from(laps[1] + entry.laps[1]) * period[1],
            );
            let Grain { center, radius } = grains[grain];
            visit(Ball { grain, center: center + shift, radius });
        }
        true
    }

    fn cell_of(&self, point: DVec3) -> IVec3 {
        ((point - self.origin) / self.side).floor().as_ivec3()
    }

    /// Shows `visit` every ball of the cell that holds `point`.
    fn at(&self, grains: &[Grain], point: DVec3, visit: impl FnMut(Ball)) {
        self.visit(grains, self.cell_of(point), visit);
    }

    /// Shows `test` the balls of every cell along the ray, in order, until a cell ends beyond
    /// `limit` or the distance that `test` last returned.
    fn along(
        &self,
        grains: &[Grain],
        origin: DVec3,
        direction: DVec3,
        limit: f64,
        mut test: impl FnMut(Ball) -> f64,
    ) {
        let Some(start) = self.distance_to_cells(origin, direction) else { return };
        let first = origin + direction * start;
        let mut cell = self.clamped(self.cell_of(first));
        let mut reached = limit;
        loop {
            let (axis, leaves) = self.way_out(cell, origin, direction);
            if !self.visit(grains, cell, |ball| reached = test(ball)) || leaves > reached {
                return;
            }
            cell[axis] += if direction[axis] > 0.0 { 1 } else { -1 };
        }
    }

    /// The axis along which the ray leaves the cell, and the distance at which it does.
    fn way_out(&self, cell: IVec3, origin: DVec3, direction: DVec3) -> (usize, f64) {
        let mut nearest = (0, f64::INFINITY);
        for axis in 0..3 {
            if direction[axis] == 0.0 {
                continue;
            }
            let face = f64::from(cell[axis] + i32::from(direction[axis] > 0.0));
            let plane = self.origin[axis] + face * self.side[axis];
            let t = (plane - origin[axis]) / direction[axis];
            if t < nearest.1 {
                nearest = (axis, t);
            }
        }
        nearest
    }

    /// Distance at which the ray first meets the box of all cells (endless along periods).
    fn distance_to_cells(&self, origin: DVec3, direction: DVec3) -> Option<f64> {
        let (mut t0, mut t1) = (0.0f64, f64::INFINITY);
        for axis in (0..3).filter(|&axis| axis == 1 || self.period.is_none()) {
            let low = self.origin[axis] - origin[axis];
            let high = low + f64::from(self.counts[axis]) * self.side[axis];
            if direction[axis] == 0.0 {
                if low > 0.0 || high < 0.0 {
                    return None;
                }
                continue;
            }
            let (a, b) = (low / direction[axis], high / direction[axis]);
            t0 = t0.max(a.min(b));
            t1 = t1.min(a.max(b));
        }
        (t0 <= t1).then_some(t0)
    }

    /// The cell, moved to the border of the box that rounding took it across.
    fn clamped(&self, cell: IVec3) -> IVec3 {
        let inside = cell.clamp(IVec3::ZERO, self.counts - 1);
        if self.period.is_some() { IVec3::new(cell.x, inside.y, cell.z) } else { inside }
    }
}
