//! A body of snow lit from all around.

use super::{Estimate, Moments, in_tasks};
use crate::World;
use crate::transport::{NewPath, PathEnd, PathResult, PathSource, trace};
use snowgrain_accel::SimdLevel;
use snowgrain_math::sampler::{PathKey, numbers};
use snowgrain_math::{Aabb, DVec3, Ray, frame};

/// What a body lit from all around does to light.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BodyMeasure {
    /// Paths traced, those that miss every grain included.
    pub paths: u64,
    /// Arrivals at grains a path: (total grain surface) / (4 x mean projected area of the hull),
    /// whatever the index of refraction, where grains do not overlap.
    pub grain_visits: Estimate,
    /// Fresnel decisions a path.
    pub interface_events: Estimate,
    /// Length in ice a path, metres.
    pub ice_path: Estimate,
    /// Fraction of paths that leave upwards.
    pub upward: Estimate,
    /// Paths that met no grain.
    pub missed: u64,
    /// Paths that the guard against endless circling in ice let out.
    pub trapped_paths: u64,
}

/// Lights the box `hull`, which must enclose all grains, from all around: entry points uniform over
/// its surface, directions cosine-distributed inwards.
#[must_use]
pub fn measure_body(
    world: &World,
    hull: &Aabb,
    paths: u64,
    seed: u64,
    level: SimdLevel,
) -> BodyMeasure {
    let parts = in_tasks(paths, |first, count| {
        let mut source =
            BodySource { hull, seed, next: first, end: first + count, sums: Sums::default() };
        trace(world, level, &mut source);
        source.sums
    });
    let mut total = Sums::default();
    for part in &parts {
        total.visits.merge(&part.visits);
        total.events.merge(&part.events);
        total.ice.merge(&part.ice);
        total.upward.merge(&part.upward);
        total.missed += part.missed;
        total.trapped += part.trapped;
    }
    BodyMeasure {
        paths,
        grain_visits: total.visits.estimate(paths),
        interface_events: total.events.estimate(paths),
        ice_path: total.ice.estimate(paths),
        upward: total.upward.estimate(paths),
        missed: total.missed,
        trapped_paths: total.trapped,
    }
}

#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    visits: Moments,
    events: Moments,
    ice: Moments,
    upward: Moments,
    missed: u64,
    trapped: u64,
}

struct BodySource<'a> {
    hull: &'a Aabb,
    seed: u64,
    next: u64,
    end: u64,
    sums: Sums,
}

impl PathSource for BodySource<'_> {
    type Tag = ();

    fn next_path(&mut self) -> Option<NewPath<()>> {
        if self.next == self.end {
            return None;
        }
        let key = PathKey::new(self.seed, self.next, 0);
        self.next += 1;
        let (origin, inward) = surface_point(self.hull, numbers(key, 0).map(f64::from));
        let [_, u, v] = numbers(key, 1);
        let direction = frame::cosine_hemisphere(inward, [f64::from(u), f64::from(v)]);
        Some(NewPath { tag: (), ray: Ray::new(origin, direction), key, event: 2 })
    }

    fn finish(&mut self, (): (), path: &PathResult) {
        let sums = &mut self.sums;
        sums.visits.add(f64::from(path.grain_visits));
        sums.events.add(f64::from(path.interface_events));
        sums.ice.add(path.ice_length);
        let up = matches!(path.end, PathEnd::Escaped(ray) if ray.direction.y > 0.0);
        sums.upward.add(f64::from(u8::from(up)));
        sums.missed += u64::from(path.grain_visits == 0);
        sums.trapped += u64::from(path.releases > 0);
    }
}

/// A uniform point on the surface of a box, and the inward normal there.
fn surface_point(hull: &Aabb, [pick, u, v]: [f64; 3]) -> (DVec3, DVec3) {
    let size = hull.size();
    let areas = [size.y * size.z, size.z * size.x, size.x * size.y];
    let mut left = pick * 2.0 * (areas[0] + areas[1] + areas[2]);
    let mut face = 0;
    while face < 5 && left >= areas[face / 2] {
        left -= areas[face / 2];
        face += 1;
    }
    let axis = face / 2;
    let upper = face % 2 == 1;
    let mut point = hull.min;
    point[(axis + 1) % 3] += size[(axis + 1) % 3] * u;
    point[(axis + 2) % 3] += size[(axis + 2) % 3] * v;
    let mut inward = DVec3::ZERO;
    inward[axis] = if upper { -1.0 } else { 1.0 };
    if upper {
        point[axis] = hull.max[axis];
    }
    (point, inward)
}
