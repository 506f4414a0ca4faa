//! Ways through a sphere from a given point, or direction, into another direction.
//!
//! Everything lies in the plane of the axis (from the point to the centre, or the given direction) and
//! the wanted direction; angles are told from the axis towards the latter. Light that meets the sphere
//! at the angle of incidence theta has left the axis by beta, with sin beta = (radius/distance) sin
//! theta, and leaves at beta - D_p(theta), D_p being its deflection at order p (van de Hulst, "Light
//! Scattering by Small Particles", chapter 12): one equation in theta for each order. D_p is monotone
//! on each side of the rainbow, whose place is known.

use crate::Dielectric;
use crate::sphere::Impact;
use core::f64::consts::{FRAC_PI_2, PI, TAU};
use snowgrain_math::trig;

/// Steps of a search, each at least a bisection.
const MOST_STEPS: u32 = 60;
/// A search ends where the angle is known so well.
const TOLERANCE: f64 = 1e-12;

/// A way through a sphere that connects a point, or a direction, with another direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Connection {
    /// Number of chords: 0 for light that is reflected outside.
    pub order: u32,
    /// Angle of the outward normal at the entry, radians, between -pi and pi.
    pub entry: f64,
    /// Angle of the outward normal at the exit.
    pub exit: f64,
    /// Length in the sphere, radii.
    pub length: f64,
    /// Part of the light that takes the way.
    pub energy: f64,
    /// Area of the disc of the sphere, in squares of its radius and as the light sees it, that sends
    /// light into a unit of solid angle around the wanted direction, 1/sr. Where light comes from a
    /// point, the solid angle there is this times the square of radius/distance.
    pub area: f64,
}

/// Finds the connections of the first few orders.
#[derive(Clone, Debug)]
pub struct Connector {
    medium: Dielectric,
    /// Of each order, the angles of incidence between which its deflection is monotone.
    branches: Vec<(u32, [f64; 2])>,
}

impl Connector {
    /// For light that arrives from outside and leaves by an order up to `greatest_order`.
    #[must_use]
    pub fn new(medium: Dielectric, greatest_order: u32) -> Self {
        let mut branches = Vec::new();
        // Beyond it all is reflected outside, where the surroundings are denser.
        let grazing = if medium.eta >= 1.0 { FRAC_PI_2 } else { trig::asin(medium.eta) };
        for order in 0..=greatest_order {
            match rainbow(medium, order) {
                Some(angle) if angle < grazing => {
                    branches.push((order, [0.0, angle]));
                    branches.push((order, [angle, grazing]));
                }
                _ if order == 0 => branches.push((order, [0.0, FRAC_PI_2])),
                _ => branches.push((order, [0.0, grazing])),
            }
        }
        Self { medium, branches }
    }

    /// Tells `found` of every connection. `ratio` is the radius over the distance of the point from the
    /// centre, in [0, 1), 0 for parallel light; `angle` that between the axis and the wanted direction,
    /// in [0, pi].
    pub fn connect(&self, ratio: f64, angle: f64, mut found: impl FnMut(Connection)) {
        for &(order, ends) in &self.branches {
            let leaves = ends.map(|theta| self.direction(order, ratio, theta));
            let (low, high) = (leaves[0].min(leaves[1]), leaves[0].max(leaves[1]));
            for side in [1.0, -1.0] {
                let first = ((low - side * angle) / TAU).ceil();
                let mut wanted = side * angle + TAU * first;
                while wanted < high {
                    let theta = self.solve(order, ratio, ends, leaves[0] > leaves[1], wanted);
                    if let Some(connection) = self.connection(order, ratio, theta, side, angle) {
                        found(connection);
                    }
                    wanted += TAU;
                }
            }
        }
    }

    /// The angle at which light leaves that meets the sphere at `theta` on the side where angles count
    /// as above 0.
    fn direction(&self, order: u32, ratio: f64, theta: f64) -> f64 {
        let beta = trig::asin(ratio * trig::sin_cos(theta).0);
        beta - self.deflection(order, theta)
    }

    /// Light that is reflected outside is turned towards the side on which it arrived.
    fn deflection(&self, order: u32, theta: f64) -> f64 {
        let impact = Impact::at_angle(self.medium, theta);
        if order == 0 { -impact.deflection(0) } else { impact.deflection(order) }
    }

    /// Slope of [`Self::direction`].
    fn slope(&self, order: u32, ratio: f64, theta: f64) -> f64 {
        let (sin, cos) = trig::sin_cos(theta);
        let beta = ratio * cos / (1.0 - ratio * ratio * sin * sin).sqrt();
        if order == 0 {
            return beta - 2.0;
        }
        let eta = self.medium.eta;
        let cos_t = (1.0 - sin * sin / (eta * eta)).max(1e-300).sqrt();
        beta - 2.0 + 2.0 * f64::from(order) * cos / (eta * cos_t)
    }

    /// The angle of incidence at which light leaves in the direction `wanted`: Newton's steps, and
    /// bisections where those would leave the bracket.
    fn solve(&self, order: u32, ratio: f64, ends: [f64; 2], falls: bool, wanted: f64) -> f64 {
        let [mut low, mut high] = ends;
        let mut theta = 0.5 * (low + high);
        for _ in 0..MOST_STEPS {
            let excess = self.direction(order, ratio, theta) - wanted;
            if (excess > 0.0) == falls {
                low = theta;
            } else {
                high = theta;
            }
            let next = theta - excess / self.slope(order, ratio, theta);
            let next = if next > low && next < high { next } else { 0.5 * (low + high) };
            let moved = (next - theta).abs();
            theta = next;
            if moved < TOLERANCE {
                break;
            }
        }
        theta
    }

    /// All about the way; `None` where it focuses (exactly forward, backward or at the rainbow).
    fn connection(
        &self,
        order: u32,
        ratio: f64,
        theta: f64,
        side: f64,
        angle: f64,
    ) -> Option<Connection> {
        let impact = Impact::at_angle(self.medium, theta);
        let (sin, cos) = trig::sin_cos(theta);
        let sin_beta = ratio * sin;
        let cos_beta = (1.0 - sin_beta * sin_beta).sqrt();
        let spread = cos_beta * trig::sin_cos(angle).0 * self.slope(order, ratio, theta).abs();
        let area = sin * cos / spread;
        let beta = trig::asin(sin_beta);
        let turned = f64::from(order) * (PI - 2.0 * impact.theta_t);
        let normal = |turned: f64| {
            let at = side * (beta + PI - theta - turned);
            at - TAU * ((at + PI) / TAU).floor()
        };
        area.is_finite().then(|| Connection {
            order,
            entry: normal(0.0),
            exit: normal(turned),
            length: f64::from(order) * impact.chord(),
            energy: impact.energy(order),
            area,
        })
    }
}

/// The angle of incidence at which the deflection of an order is least: cos^2 = (eta^2 - 1)/(p^2 - 1).
fn rainbow(medium: Dielectric, order: u32) -> Option<f64> {
    let p = f64::from(order);
    let square = (medium.eta * medium.eta - 1.0) / (p * p - 1.0);
    (order >= 2 && (0.0..1.0).contains(&square)).then(|| trig::acos(square.sqrt()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use snowgrain_math::DVec3;
    use snowgrain_math::sampler::{PathKey, numbers};

    const ICE: Dielectric = Dielectric { eta: 1.31 };

    fn at_angle(angle: f64) -> DVec3 {
        let (sin, cos) = trig::sin_cos(angle);
        DVec3::new(cos, sin, 0.0)
    }

    fn refract(d: DVec3, n: DVec3, eta: f64) -> DVec3 {
        // n against d; eta = inside over outside index of the interface as it is crossed.
        let cos = -d.dot(n);
        let cos_t = (1.0 - (1.0 - cos * cos) / (eta * eta)).sqrt();
        (d + n * cos) / eta - n * cos_t
    }

    /// Follows a ray by vectors through the unit sphere at the origin; where it leaves, and whither.
    fn follow(origin: DVec3, direction: DVec3, order: u32) -> Option<(DVec3, DVec3)> {
        let middle = -origin.dot(direction);
        let half2 = 1.0 - (origin + direction * middle).length_squared();
        let entry = origin + direction * (middle - half2.max(0.0).sqrt());
        if order == 0 {
            return Some((entry, direction - 2.0 * direction.dot(entry) * entry));
        }
        let mut d = refract(direction, entry, ICE.eta);
        let mut at = entry;
        for chord in 1..=order {
            at += d * (-2.0 * at.dot(d));
            if chord == order {
                return Some((at, refract(d, -at, 1.0 / ICE.eta)));
            }
            d -= 2.0 * d.dot(at) * at;
        }
        None
    }

    /// From points near and far: each connection, followed by vectors, leaves where and whither it says;
    /// and a bundle of rays around it covers the area that it says.
    #[test]
    fn connections_lead_where_they_say() {
        let connector = Connector::new(ICE, 3);
        let mut counts = [0; 4];
        for index in 0..400 {
            let [u, v, _] = numbers(PathKey::new(1, index, 0), 0).map(f64::from);
            let distance = 1.2 + 50.0 * u * u;
            let angle = PI * v;
            let origin = DVec3::new(-distance, 0.0, 0.0);
            let wanted = at_angle(angle);
            connector.connect(1.0 / distance, angle, |found| {
                let ray = (at_angle(found.entry) - origin).normalize();
                let (exit, leaves) = follow(origin, ray, found.order).unwrap();
                assert!((leaves - wanted).length() < 1e-6, "{found:?} {leaves} {wanted}");
                assert!((exit - at_angle(found.exit)).length() < 1e-6, "{found:?} {exit}");
                counts[found.order as usize] += 1;
                if found.area < 0.02 {
                    return; // At grazing incidence differences of rays say little.
                }
                // Two neighbouring rays, in the plane and across it.
                let step = 1e-6 / distance;
                let across = DVec3::Z;
                let along = across.cross(ray);
                let leave = |d: DVec3| follow(origin, d.normalize(), found.order).unwrap().1;
                let one = (leave(ray + along * step) - leave(ray - along * step)) / (2.0 * step);
                let two = (leave(ray + across * step) - leave(ray - across * step)) / (2.0 * step);
                let sent = one.cross(two).length();
                let expected = 1.0 / (found.area / (distance * distance));
                assert!((sent / expected - 1.0).abs() < 2e-3, "{found:?} {sent} {expected}");
            });
        }
        assert!(counts.iter().all(|&n| n > 100), "{counts:?}");
    }

    /// Over all directions the areas times the energies cover the disc.
    #[test]
    fn connections_of_parallel_light_share_out_the_disc() {
        let connector = Connector::new(ICE, 3);
        let parts = 20_000;
        let mut sums = [0.0; 4];
        for part in 0..parts {
            let angle = PI * (f64::from(part) + 0.5) / f64::from(parts);
            let solid_angle = TAU * trig::sin_cos(angle).0 * PI / f64::from(parts);
            connector.connect(0.0, angle, |found| {
                sums[found.order as usize] += found.area * found.energy * solid_angle / PI;
            });
        }
        for (order, sum) in (0..).zip(sums) {
            let expected = crate::sphere::energy(ICE, order);
            // Midpoints of rings miss some of the poles of the rainbows.
            let tolerance = if order < 2 { 0.002 } else { 0.06 };
            assert!((sum / expected - 1.0).abs() < tolerance, "{order}: {sum} {expected}");
        }
    }
}
