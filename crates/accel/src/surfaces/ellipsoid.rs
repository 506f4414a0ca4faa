//! Ellipsoids, the affine images of a sphere: nearest point, and a sphere falling onto one.

use super::contact::{Drop, Touch};
use snowgrain_math::{DMat3, DVec3};

/// More than any of the iterations below needs; each stops when its number no longer changes.
const ITERATIONS: usize = 200;

/// An ellipsoid, hollow: only its surface counts.
#[derive(Clone, Debug)]
pub(super) struct Ellipsoid {
    center: DVec3,
    /// Perpendicular semi-axes.
    axes: [DVec3; 3],
    /// Their squared lengths.
    squares: [f64; 3],
}

/// The point of the surface nearest to some point.
struct Nearest {
    point: DVec3,
    /// Unit normal there, outwards.
    outwards: DVec3,
    /// Distance, negative inside.
    signed_distance: f64,
}

impl Ellipsoid {
    /// The image of the unit sphere under `p -> matrix * p + center`.
    pub(super) fn new(matrix: DMat3, center: DVec3) -> Self {
        let axes = perpendicular_columns(matrix);
        Self { center, axes, squares: axes.map(|a| a.length_squared()) }
    }

    /// Half the size of the box around it.
    pub(super) fn half_size(&self) -> DVec3 {
        let [a, b, c] = self.axes.map(|a| a * a);
        let sum = a + b + c;
        DVec3::new(sum.x.sqrt(), sum.y.sqrt(), sum.z.sqrt())
    }

    /// The nearest point: with `w` its coordinates along the semi-axes, `q_i = a_i . (p - center)`
    /// and `d_i = |a_i|^2`, it has `w_i = q_i / (d_i + lambda)` and `|w| = 1`.
    fn nearest(&self, p: DVec3) -> Nearest {
        let offset = p - self.center;
        let q = self.axes.map(|a| a.dot(offset));
        let w = unit_solution(q, self.squares);
        let sum = |f: [f64; 3]| self.axes[0] * f[0] + self.axes[1] * f[1] + self.axes[2] * f[2];
        let reach = sum(w);
        let outwards = sum(std::array::from_fn(|i| w[i] / self.squares[i])).normalize();
        Nearest {
            point: self.center + reach,
            outwards,
            signed_distance: (offset - reach).dot(outwards),
        }
    }

    /// The nearest point as seen from `center`, and the distance to it.
    pub(super) fn touch(&self, center: DVec3) -> (Touch, f64) {
        let nearest = self.nearest(center);
        let inside = nearest.signed_distance < 0.0;
        let normal = if inside { -nearest.outwards } else { nearest.outwards };
        (Touch { point: nearest.point, normal }, nearest.signed_distance.abs())
    }

    /// Height of the centre of a falling sphere at its first contact, and what it touches; a
    /// sphere that starts inside falls to the bottom of the shell.
    pub(super) fn drop_sphere(&self, drop: &Drop) -> Option<(f64, Touch)> {
        let reach = self.half_size() + drop.radius;
        let offset = drop.start() - self.center;
        if offset.x.abs() > reach.x || offset.z.abs() > reach.z || offset.y < -reach.y {
            return None;
        }
        if self.clearly_ends_below(drop) {
            return None;
        }
        let start_y = drop.start_y.min(self.center.y + reach.y);
        let start = self.nearest(drop.center(start_y));
        let y = if start.signed_distance.abs() <= drop.radius {
            start_y
        } else if start.signed_distance > 0.0 {
            self.fall_outside(drop, start_y)?
        } else {
            self.fall_inside(drop, start_y)
        };
        Some((y, self.touch(drop.center(y)).0))
    }

    /// Whether a fall from outside is still outside, and coming nearer, at the height where it stops
    /// to matter: the distance to a convex body is convex along a line, so all above is outside.
    fn clearly_ends_below(&self, drop: &Drop) -> bool {
        if !drop.down_to.is_finite() || drop.down_to >= drop.start_y {
            return false;
        }
        let last = self.nearest(drop.center(drop.down_to));
        last.signed_distance > drop.radius && last.outwards.y > 0.0
    }

    /// Newton's method from above. The distance to a convex body is convex along a line, so it
    /// never passes the root; where the distance grows again the sphere falls past.
    fn fall_outside(&self, drop: &Drop, mut y: f64) -> Option<f64> {
        for _ in 0..ITERATIONS {
            let nearest = self.nearest(drop.center(y));
            if nearest.outwards.y <= 0.0 {
                return None;
            }
            let next = y - (nearest.signed_distance - drop.radius) / nearest.outwards.y;
            if next >= y {
                break;
            }
            y = next;
        }
        Some(y)
    }

    /// Bisection between the start, deeper inside than the radius, and the bottom.
    fn fall_inside(&self, drop: &Drop, start_y: f64) -> f64 {
        let (mut low, mut high) = (self.center.y - self.half_size().y, start_y);
        for _ in 0..ITERATIONS {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                break;
            }
            if -self.nearest(drop.center(middle)).signed_distance > drop.radius {
                high = middle;
            } else {
                low = middle;
            }
        }
        high
    }
}

/// The columns of `matrix` after the rotation of its domain that makes them perpendicular
/// (one-sided Jacobi; Hestenes 1958, "Inversion of Matrices by Biorthogonalization").
fn perpendicular_columns(matrix: DMat3) -> [DVec3; 3] {
    const SWEEPS: usize = 30;
    let mut columns = [matrix.x_axis, matrix.y_axis, matrix.z_axis];
    for _ in 0..SWEEPS {
        let mut rotated = false;
        for (i, j) in [(0, 1), (0, 2), (1, 2)] {
            let (a, b) = (columns[i], columns[j]);
            let (aa, bb, ab) = (a.length_squared(), b.length_squared(), a.dot(b));
            if ab.abs() <= f64::EPSILON * (aa * bb).sqrt() {
                continue;
            }
            let zeta = (bb - aa) / (2.0 * ab);
            let tangent = 1.0f64.copysign(zeta) / (zeta.abs() + (1.0 + zeta * zeta).sqrt());
            let cosine = 1.0 / (1.0 + tangent * tangent).sqrt();
            let sine = cosine * tangent;
            columns[i] = a * cosine - b * sine;
            columns[j] = a * sine + b * cosine;
            rotated = true;
        }
        if !rotated {
            break;
        }
    }
    columns
}

/// The unit vector `w_i = q_i / (d_i + lambda)` with the largest `lambda`, that is `>= -min d`.
///
/// Solved for `s = lambda + min d` by Newton's method on `1 / |w|`, which is concave and nearly
/// straight (More and Sorensen 1983, "Computing a Trust Region Step", eq. 3.9), from the left,
/// where no component exceeds 1.
fn unit_solution(q: [f64; 3], squares: [f64; 3]) -> [f64; 3] {
    let least = squares[0].min(squares[1]).min(squares[2]);
    let excess = squares.map(|d| d - least);
    let mut s = (0..3).map(|i| q[i].abs() - excess[i]).fold(0.0, f64::max);
    let mut w = [0.0; 3];
    let mut length = 0.0;
    for _ in 0..ITERATIONS {
        w = std::array::from_fn(|i| if q[i] == 0.0 { 0.0 } else { q[i] / (excess[i] + s) });
        length = (w[0] * w[0] + w[1] * w[1] + w[2] * w[2]).sqrt();
        let slope: f64 =
            (0..3).filter(|&i| w[i] != 0.0).map(|i| w[i] * w[i] / (excess[i] + s)).sum();
        let next = s + (length - 1.0) * length * length / slope;
        if !(length > 1.0 && next > s) {
            break;
        }
        s = next;
    }
    if s == 0.0 && length < 1.0 {
        // Deep inside, on the plane across the shortest axis: both of its sides are as near.
        let shortest = (0..3).find(|&i| excess[i] == 0.0).unwrap_or(0);
        w[shortest] = (1.0 - length * length).sqrt();
        return w;
    }
    w.map(|w| w / length)
}
