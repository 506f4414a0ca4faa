//! What touches what.

use super::bodies::Body;
use super::buckets::Buckets;
use super::meeting::meet;
use crate::{GrainField, PeriodicPack};
use snowgrain_geometry::Grain;
use snowgrain_math::DVec3;

/// Two grains touch where the gap or overlap between them is at most this many quanta (2.2e-4 of
/// the largest radius of the scene): what rounding makes of grains that touch. Deeper is overlap.
pub const TOUCH_TOLERANCE_QUANTA: f64 = 3.0;

/// What touches what in a pack.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Connections {
    /// Mean number of grains that a grain touches, within [`TOUCH_TOLERANCE_QUANTA`].
    pub contacts_per_grain: f64,
    /// Mean number of grains that a grain overlaps by more than that.
    pub overlaps_per_grain: f64,
    /// Mean depth of the overlaps, metres: of grains that are no spheres, the length in both along the line through
    /// their centres.
    pub mean_overlap_depth: f64,
    /// Greatest depth of an overlap or, where there is none, of a contact, metres; 0 at least.
    pub greatest_overlap_depth: f64,
    /// Part of the grains' volume that hangs together, through contacts and overlaps, with the
    /// ground, or, where no grain touches the ground, in the largest cluster.
    pub connected_fraction: f64,
    /// Whether any grain touches the ground.
    pub reaches_ground: bool,
}

/// Looks at every pair of neighbours of `field`, which repeats with `period` (metres along x and z)
/// where that is given; `touches_ground` says which grains the ground carries.
#[must_use]
pub fn connections(
    field: &GrainField,
    period: Option<[f64; 2]>,
    touches_ground: &dyn Fn(&Grain) -> bool,
) -> Connections {
    in_buckets(field, &Buckets::new(field, period), touches_ground)
}

/// The same of a pack that repeats along all axes, and that nothing carries.
#[must_use]
pub fn connections_of_pack(pack: &PeriodicPack) -> Connections {
    in_buckets(&pack.field, &Buckets::repeating(&pack.field, pack.period), &|_| false)
}

fn in_buckets(
    field: &GrainField,
    buckets: &Buckets,
    touches_ground: &dyn Fn(&Grain) -> bool,
) -> Connections {
    let grains = buckets.grains();
    let mut clusters = Clusters::new(grains.len());
    let mut touching = Touching::default();
    let spheres = buckets.are_spheres();
    for (i, grain) in grains.iter().enumerate() {
        let [x, y, z] = grain.center.map(f64::from);
        let (center, radius) = (DVec3::new(x, y, z), f64::from(grain.radius));
        buckets.around(center, |j, other, other_radius| {
            let offset = other - center;
            if i == j && offset == DVec3::ZERO {
                return;
            }
            let joined = if spheres {
                touching.spheres(radius + other_radius - offset.length())
            } else {
                // Each pair once: it is seen from both, but for images of one grain, each of which is a pair.
                let times = if i == j { 1 } else { 2 };
                i <= j && touching.bodies(&buckets.body(i, center), &buckets.body(j, other), times)
            };
            if joined {
                clusters.join(i, j);
            }
        });
    }
    let Touching { contacts, overlaps, depths, greatest } = touching;
    let quantum = field.quantisation.quantum();
    let per_grain = |count: u64| count as f64 / (grains.len() as f64).max(1.0);
    let (connected_fraction, reaches_ground) =
        connected_fraction(field, buckets, &mut clusters, touches_ground);
    Connections {
        contacts_per_grain: per_grain(contacts),
        overlaps_per_grain: per_grain(overlaps),
        mean_overlap_depth: quantum * depths / (overlaps as f64).max(1.0),
        greatest_overlap_depth: quantum * greatest,
        connected_fraction,
        reaches_ground,
    }
}

/// Sums over all pairs, each counted from both sides; lengths in quanta.
#[derive(Default)]
struct Touching {
    contacts: u64,
    overlaps: u64,
    depths: f64,
    greatest: f64,
}

impl Touching {
    /// Books two spheres that overlap by `depth`; whether they touch.
    fn spheres(&mut self, depth: f64) -> bool {
        if depth < -TOUCH_TOLERANCE_QUANTA {
            return false;
        }
        self.greatest = self.greatest.max(depth);
        if depth > TOUCH_TOLERANCE_QUANTA {
            self.overlaps += 1;
            self.depths += depth;
        } else {
            self.contacts += 1;
        }
        true
    }

    /// Books two grains of any shapes; whether they touch.
    fn bodies(&mut self, one: &Body<'_>, other: &Body<'_>, times: u64) -> bool {
        let widest = one.reach() + other.reach() + TOUCH_TOLERANCE_QUANTA;
        if (one.center - other.center).length_squared() > widest * widest {
            return false;
        }
        let depth = one.depth_in(other);
        let half = 0.5 * TOUCH_TOLERANCE_QUANTA;
        if depth > TOUCH_TOLERANCE_QUANTA || meet(one, other, -half) {
            self.overlaps += times;
            self.depths += times as f64 * depth;
            self.greatest = self.greatest.max(depth);
            return true;
        }
        let touch = meet(one, other, half);
        self.contacts += if touch { times } else { 0 };
        touch
    }
}

/// The part that hangs together, and whether it does with the ground.
fn connected_fraction(
    field: &GrainField,
    buckets: &Buckets,
    clusters: &mut Clusters,
    touches_ground: &dyn Fn(&Grain) -> bool,
) -> (f64, bool) {
    let mut volumes = vec![0.0f64; buckets.grains().len()];
    let mut grounded = vec![false; volumes.len()];
    for (i, &grain) in buckets.grains().iter().enumerate() {
        let root = clusters.root(i);
        let radius = f64::from(grain.radius);
        volumes[root] += radius * radius * radius;
        grounded[root] |= touches_ground(&field.quantisation.grain(grain));
    }
    let all: f64 = volumes.iter().sum();
    let on_ground: f64 = volumes.iter().zip(&grounded).filter(|g| *g.1).map(|g| g.0).sum();
    let largest = volumes.iter().copied().fold(0.0, f64::max);
    let connected = if on_ground > 0.0 { on_ground } else { largest };
    (if all > 0.0 { connected / all } else { 0.0 }, on_ground > 0.0)
}

/// Disjoint sets with path halving; the least index is a set's root.
struct Clusters {
    parents: Vec<u32>,
}

impl Clusters {
    fn new(count: usize) -> Self {
        Self { parents: (0..count as u32).collect() }
    }

    fn root(&mut self, index: usize) -> usize {
        let mut at = index;
        while self.parents[at] as usize != at {
            self.parents[at] = self.parents[self.parents[at] as usize];
            at = self.parents[at] as usize;
        }
        at
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        self.parents[a.max(b)] = a.min(b) as u32;
    }
}
