//! Rays and bodies between parallel faces ([`Slabs`](crate::grain_grid::Slabs)), eight rays at a time, in
//! double precision: each in its own body's space and in radii.
//!
//! What `body` does with one ray and the planes of one body, by the same arithmetic; a pair of faces shares its
//! products.

use crate::grain_grid::{AXES, COS_30, ROUND, Slabs};
use fearless_simd::prelude::*;
use fearless_simd::{f64x8, mask64x8};

/// Rays handled at once.
pub(super) const WIDTH: usize = 8;

pub(super) type D<S> = f64x8<S>;
pub(super) type Truth<S> = mask64x8<S>;

/// One vector a ray.
#[derive(Clone, Copy)]
pub(super) struct Vectors<S: Simd>(pub(super) D<S>, pub(super) D<S>, pub(super) D<S>);

impl<S: Simd> Vectors<S> {
    #[inline(always)]
    pub(super) fn load<const N: usize>(simd: S, axes: &[[f64; N]; 3], at: usize) -> Self {
        let part = |axis: usize| D::<S>::from_slice(simd, &axes[axis][at..at + WIDTH]);
        Self(part(0), part(1), part(2))
    }

    #[inline(always)]
    pub(super) fn store<const N: usize>(self, axes: &mut [[f64; N]; 3], at: usize) {
        self.0.store_slice(&mut axes[0][at..at + WIDTH]);
        self.1.store_slice(&mut axes[1][at..at + WIDTH]);
        self.2.store_slice(&mut axes[2][at..at + WIDTH]);
    }

    #[inline(always)]
    pub(super) fn dot(self, other: Self) -> D<S> {
        self.0 * other.0 + self.1 * other.1 + self.2 * other.2
    }

    #[inline(always)]
    pub(super) fn scaled(self, factor: D<S>) -> Self {
        Self(self.0 * factor, self.1 * factor, self.2 * factor)
    }

    #[inline(always)]
    pub(super) fn plus(self, other: Self, factor: D<S>) -> Self {
        Self(self.0 + other.0 * factor, self.1 + other.1 * factor, self.2 + other.2 * factor)
    }

    #[inline(always)]
    pub(super) fn minus(self, other: Self) -> Self {
        Self(self.0 - other.0, self.1 - other.1, self.2 - other.2)
    }

    #[inline(always)]
    pub(super) fn choose(truth: Truth<S>, yes: Self, no: Self) -> Self {
        Self(truth.select(yes.0, no.0), truth.select(yes.1, no.1), truth.select(yes.2, no.2))
    }

    /// Of nearly unit length, brought closer to it by one step of Newton's method.
    #[inline(always)]
    pub(super) fn straightened(self, simd: S) -> Self {
        let half = D::<S>::splat(simd, 0.5);
        self.scaled(D::<S>::splat(simd, 1.5) - half * self.dot(self))
    }

    /// Components along the axes of faces.
    #[inline(always)]
    fn along_axes(self, simd: S) -> [D<S>; AXES] {
        let (across, half) = (D::<S>::splat(simd, COS_30), D::<S>::splat(simd, 0.5));
        let (x, z) = (self.0 * across, self.2 * half);
        [self.1, z + x, self.2, z - x, self.0]
    }
}

/// Vectors in the world that are given in spaces of these axes.
#[inline(always)]
pub(super) fn turned<S: Simd>([x, y, z]: [Vectors<S>; 3], v: Vectors<S>) -> Vectors<S> {
    x.scaled(v.0).plus(y, v.1).plus(z, v.2)
}

/// Vectors in the spaces of these axes.
#[inline(always)]
pub(super) fn turned_back<S: Simd>([x, y, z]: [Vectors<S>; 3], v: Vectors<S>) -> Vectors<S> {
    Vectors(x.dot(v), y.dot(v), z.dot(v))
}

/// The bodies of eight rays.
#[derive(Clone, Copy)]
pub(super) struct Bodies<S: Simd> {
    pub(super) half: [D<S>; AXES],
    /// Across the c axis and along it.
    pub(super) shrink: [D<S>; 2],
    /// Whether any has faces along x, and whether any is round.
    pub(super) has_x: bool,
    pub(super) has_round: bool,
}

impl<S: Simd> Bodies<S> {
    #[inline(always)]
    pub(super) fn load<const N: usize>(
        simd: S,
        (half, shrink): (&[[f64; N]; AXES], &[[f64; N]; 2]),
        at: usize,
        (has_x, has_round): (bool, bool),
    ) -> Self {
        let load = |row: &[f64; N]| D::<S>::from_slice(simd, &row[at..at + WIDTH]);
        Self {
            half: [load(&half[0]), load(&half[1]), load(&half[2]), load(&half[3]), load(&half[4])],
            shrink: [load(&shrink[0]), load(&shrink[1])],
            has_x,
            has_round,
        }
    }

    /// Eight bodies that are alike.
    #[inline(always)]
    pub(super) fn alike(simd: S, slabs: &Slabs, (has_x, has_round): (bool, bool)) -> Self {
        let splat = |x: f64| D::<S>::splat(simd, x);
        let ([a, b, c, d, e], [across, along]) = (slabs.half, slabs.shrink);
        Self {
            half: [splat(a), splat(b), splat(c), splat(d), splat(e)],
            shrink: [splat(across), splat(along)],
            has_x,
            has_round,
        }
    }

    /// What makes unit spheres of the ellipsoids, done to vectors.
    #[inline(always)]
    fn shrunk(&self, v: Vectors<S>) -> Vectors<S> {
        let [across, along] = self.shrink;
        Vectors(v.0 * across, v.1 * along, v.2 * across)
    }

    /// Axes along which any of the bodies has faces.
    #[inline(always)]
    fn axes(&self) -> usize {
        if self.has_x { AXES } else { AXES - 1 }
    }
}

/// How a ray lies to a pair of faces: its slope along the way that it goes, and how far along it is.
struct Way<S: Simd> {
    upwards: Truth<S>,
    slope: D<S>,
    along: D<S>,
}

impl<S: Simd> Way<S> {
    #[inline(always)]
    fn of(simd: S, slope: D<S>, above: D<S>) -> Self {
        let zero = D::<S>::splat(simd, 0.0);
        let upwards = slope.simd_gt(zero);
        Self {
            upwards,
            slope: upwards.select(slope, zero - slope),
            along: upwards.select(above, zero - above),
        }
    }
}

/// What of eight lines lies within their bodies.
pub(super) struct Within<S: Simd> {
    /// `enter < leave` where anything does.
    pub(super) enter: D<S>,
    pub(super) leave: D<S>,
    /// The face by which it enters.
    pub(super) by: D<S>,
}

/// The interval of eight lines, as [`super::body::interval`] tells it of one.
#[inline(always)]
pub(super) fn within<S: Simd>(
    simd: S,
    bodies: &Bodies<S>,
    origin: Vectors<S>,
    direction: Vectors<S>,
) -> Within<S> {
    let splat = |x: f64| D::<S>::splat(simd, x);
    let (zero, one) = (splat(0.0), splat(1.0));
    let (none, all) = (splat(f64::NEG_INFINITY), splat(f64::INFINITY));
    let (above, slopes) = (origin.along_axes(simd), direction.along_axes(simd));
    let (mut enter, mut leave, mut by) = (none, all, zero);
    for axis in 0..bodies.axes() {
        let way = Way::of(simd, slopes[axis], above[axis]);
        let half = bodies.half[axis];
        let crosses = way.slope.simd_gt(zero);
        let outside = above[axis].abs().simd_gt(half);
        let inverse = one / way.slope;
        let near = crosses.select((zero - half - way.along) * inverse, none);
        let beside = outside.select(none, all);
        let far = crosses.select((half - way.along) * inverse, beside);
        let later = near.simd_gt(enter);
        let number = splat(axis as f64 + 1.0);
        by = later.select(way.upwards.select(zero - number, number), by);
        enter = later.select(near, enter);
        leave = far.simd_lt(leave).select(far, leave);
    }
    if bodies.has_round {
        let is_round = bodies.shrink[0].simd_gt(zero);
        let Chords { middle, half, met } = Chords::of(simd, bodies, origin, direction);
        let (near, far) = (middle - half, middle + half);
        let later = is_round & near.simd_gt(enter);
        by = later.select(splat(ROUND), by);
        enter = later.select(near, enter);
        leave = (is_round & far.simd_lt(leave)).select(far, leave);
        leave = (is_round & !met).select(none, leave);
    }
    Within { enter, leave, by }
}

/// Where eight rays inside leave, that stand on the faces `on`: how far, and by which face; as
/// [`super::body::left`].
#[inline(always)]
pub(super) fn left<S: Simd>(
    simd: S,
    bodies: &Bodies<S>,
    (origin, direction): (Vectors<S>, Vectors<S>),
    on: D<S>,
) -> (D<S>, D<S>) {
    let splat = |x: f64| D::<S>::splat(simd, x);
    let zero = splat(0.0);
    let (above, slopes) = (origin.along_axes(simd), direction.along_axes(simd));
    let (mut best, mut by) = (splat(f64::INFINITY), zero);
    for axis in 0..bodies.axes() {
        let way = Way::of(simd, slopes[axis], above[axis]);
        let number = splat(axis as f64 + 1.0);
        let face = way.upwards.select(number, zero - number);
        let far = (bodies.half[axis] - way.along) / way.slope;
        let sooner = way.slope.simd_gt(zero) & far.simd_lt(best) & !face.simd_eq(on);
        by = sooner.select(face, by);
        best = sooner.select(far, best);
    }
    if bodies.has_round {
        let round = splat(ROUND);
        let Chords { middle, half, met } = Chords::of(simd, bodies, origin, direction);
        let far = met.select(middle + half, middle);
        let far = on.simd_eq(round).select(middle + middle, far);
        let sooner = bodies.shrink[0].simd_gt(zero) & far.simd_lt(best);
        by = sooner.select(round, by);
        best = sooner.select(far, best);
    }
    (best.simd_gt(zero).select(best, zero), by)
}

/// Outward unit normals at points of the faces `on`.
#[inline(always)]
pub(super) fn normals<S: Simd>(
    simd: S,
    bodies: &Bodies<S>,
    on: D<S>,
    point: Vectors<S>,
) -> Vectors<S> {
    let splat = |x: f64| D::<S>::splat(simd, x);
    let (zero, one) = (splat(0.0), splat(1.0));
    let side = on.simd_lt(zero).select(zero - one, one);
    let axis = on * side;
    let is = |number: f64| axis.simd_eq(splat(number));
    let along_y = is(1.0).select(side, zero);
    let x =
        is(2.0).select(splat(COS_30), is(4.0).select(splat(-COS_30), is(5.0).select(one, zero)));
    let z = (is(2.0) | is(4.0)).select(splat(0.5), is(3.0).select(one, zero));
    let flat = Vectors(x * side, along_y, z * side);
    if !bodies.has_round {
        return flat;
    }
    let gradient = bodies.shrunk(bodies.shrunk(point));
    let round = gradient.scaled(one / gradient.dot(gradient).sqrt());
    Vectors::choose(is(ROUND), round, flat)
}

/// Chords of eight lines in ellipsoids.
struct Chords<S: Simd> {
    middle: D<S>,
    half: D<S>,
    met: Truth<S>,
}

impl<S: Simd> Chords<S> {
    #[inline(always)]
    fn of(simd: S, bodies: &Bodies<S>, origin: Vectors<S>, direction: Vectors<S>) -> Self {
        let (zero, one) = (D::<S>::splat(simd, 0.0), D::<S>::splat(simd, 1.0));
        let (o, d) = (bodies.shrunk(origin), bodies.shrunk(direction));
        let inverse = one / d.dot(d);
        let middle = (zero - o.dot(d)) * inverse;
        let foot = o.plus(d, middle);
        let inside = (one - foot.dot(foot)) * inverse;
        let met = inside.simd_gt(zero);
        Self { middle, half: met.select(inside, zero).sqrt(), met }
    }
}

/// Eight interfaces, as [`super::interface::Interface`] is one.
pub(super) struct Interfaces<S: Simd> {
    /// Whether light passes.
    pub(super) pass: Truth<S>,
    /// Its direction then, if not that of what is reflected.
    pub(super) turned: Vectors<S>,
}

impl<S: Simd> Interfaces<S> {
    /// Of light along `direction` at normals `facing` where it comes from, the index there over that beyond being
    /// `ratio`, by random numbers in `[0, 1)`.
    #[inline(always)]
    pub(super) fn new(
        simd: S,
        (direction, facing): (Vectors<S>, Vectors<S>),
        ratio: f64,
        random: D<S>,
    ) -> Self {
        let splat = |x: f64| D::<S>::splat(simd, x);
        let (zero, one) = (splat(0.0), splat(1.0));
        let cosine = zero - direction.dot(facing);
        let cosine = cosine.simd_gt(zero).select(cosine, zero);
        let cosine = cosine.simd_lt(one).select(cosine, one);
        let beyond2 = one - splat(ratio * ratio) * (one - cosine * cosine);
        let is_refracted = beyond2.simd_gt(zero);
        let beyond = is_refracted.select(beyond2, zero).sqrt();
        let bent = splat(ratio) * cosine;
        let (a, b) = (bent + beyond, cosine + splat(ratio) * beyond);
        let (a2, b2) = (a * a, b * b);
        let passes = splat(2.0 * ratio) * (cosine * beyond) * (a2 + b2);
        let pass = is_refracted & (random * (a2 * b2)).simd_lt(passes);
        let along = direction.scaled(pass.select(splat(ratio), one));
        let turned = along.plus(facing, pass.select(bent - beyond, cosine + cosine));
        Self { pass, turned: turned.straightened(simd) }
    }
}

#[cfg(test)]
mod tests {
    use super::super::body::{self, ELLIPSOID, LocalRay};
    use super::super::candidates::part_of;
    use super::*;
    use crate::SimdLevel;
    use crate::grain_grid::{Part, Prototype};
    use fearless_simd::dispatch;
    use snowgrain_geometry::{Shape, ShapeKind};
    use snowgrain_math::DVec3;
    use snowgrain_math::sampler::{PathKey, numbers};

    /// Of eight rays of one body what the vectors and what `body` say.
    fn compare<S: Simd>(simd: S, (part, slabs): (&Part, &Slabs), rays: &[LocalRay; WIDTH]) {
        let axes = |vector: fn(&LocalRay) -> DVec3| {
            std::array::from_fn(|axis| rays.each_ref().map(|ray| vector(ray)[axis]))
        };
        let (half, shrink) =
            (slabs.half.map(|half| [half; WIDTH]), slabs.shrink.map(|shrink| [shrink; WIDTH]));
        let bodies = Bodies::load(simd, (&half, &shrink), 0, (true, true));
        let load = |axes: [[f64; WIDTH]; 3]| Vectors::load(simd, &axes, 0);
        let (origin, direction) = (load(axes(|ray| ray.origin)), load(axes(|ray| ray.direction)));
        let Within { enter, leave, by } = within(simd, &bodies, origin, direction);
        let place = origin.plus(direction, enter);
        let (length, through) = left(simd, &bodies, (place, direction), by);
        let normal = normals(simd, &bodies, through, place.plus(direction, length));
        for (i, ray) in rays.iter().enumerate() {
            let expected = body::interval(part, ray);
            assert_eq!(enter[i] < leave[i], expected.is_some(), "{ray:?}");
            let Some([near, far]) = expected else { continue };
            assert!((enter[i] - near).abs() < 1e-12 && (leave[i] - far).abs() < 1e-12);
            let on = body::entered(part, ray, near);
            assert_eq!(part_of(slabs, by[i]), on);
            let inside = LocalRay { origin: ray.origin + ray.direction * near, ..*ray };
            let (chord, out) = body::left(part, &inside, on);
            assert_eq!(part_of(slabs, through[i]), out);
            assert!((length[i] - chord).abs() < 1e-11);
            let end = inside.origin + ray.direction * chord;
            let expected = body::normal(part, out, end);
            let found = DVec3::new(normal.0[i], normal.1[i], normal.2[i]);
            assert!((found - expected).length() < 1e-10, "{found} {expected}");
            assert!(out != ELLIPSOID || part.ellipsoid.is_some());
        }
    }

    #[test]
    fn eight_rays_are_told_what_one_is() {
        for kind in [
            ShapeKind::Cube { rounding: 0.0 },
            ShapeKind::Cube { rounding: 0.6 },
            ShapeKind::HexagonalPrism { aspect: 0.1, rounding: 0.0 },
            ShapeKind::HexagonalPrism { aspect: 2.0, rounding: 0.3 },
            ShapeKind::Spheroid { aspect: 0.5 },
        ] {
            let prototype = Prototype::new(&Shape::new(kind).expect("the shape is legal"));
            let slabs = prototype.slabs.as_ref().expect("it lies between parallel faces");
            for level in SimdLevel::available() {
                let level = level.token().expect("the level is there");
                for index in 0..300 {
                    let ray = |at: usize| {
                        let key = PathKey::new(1, index * WIDTH as u64 + at as u64, 0);
                        let vector =
                            |event| DVec3::from_array(numbers(key, event).map(f64::from)) - 0.5;
                        LocalRay { origin: vector(0) * 6.0, direction: vector(1).normalize() }
                    };
                    let rays = std::array::from_fn(ray);
                    dispatch!(level, simd => compare(simd, (&prototype.parts[0], slabs), &rays));
                }
            }
        }
    }
}
