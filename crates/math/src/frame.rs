//! Orthonormal frames and directions in them.

use crate::{DVec3, trig};

/// Two unit vectors that complete the unit vector `normal` to a right-handed frame, without a
/// branch near a pole (Duff et al. 2017, "Building an Orthonormal Basis, Revisited", eq. 4).
#[must_use]
pub fn tangents(normal: DVec3) -> (DVec3, DVec3) {
    let sign = 1.0f64.copysign(normal.z);
    let a = -1.0 / (sign + normal.z);
    let b = normal.x * normal.y * a;
    (
        DVec3::new(1.0 + sign * normal.x * normal.x * a, sign * b, -sign * normal.x),
        DVec3::new(b, sign + normal.y * normal.y * a, -normal.y),
    )
}

/// A direction on the side of `normal`, with density `cos_theta / pi`, from two uniform numbers.
#[must_use]
pub fn cosine_hemisphere(normal: DVec3, u: [f64; 2]) -> DVec3 {
    let (s, t) = tangents(normal);
    let radius = u[0].sqrt();
    let (sin_phi, cos_phi) = trig::sin_cos(core::f64::consts::TAU * u[1]);
    let height = (1.0 - u[0]).max(0.0).sqrt();
    (s * (radius * cos_phi) + t * (radius * sin_phi) + normal * height).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_orthonormal_at_the_poles_too() {
        for n in [DVec3::Z, -DVec3::Z, DVec3::X, DVec3::new(0.6, -0.8, 0.0), DVec3::Y] {
            let (s, t) = tangents(n);
            for (value, expected) in
                [(s.dot(t), 0.0), (s.dot(n), 0.0), (t.dot(n), 0.0), (s.length(), 1.0)]
            {
                assert!((value - expected).abs() < 1e-12, "{n}: {value}");
            }
        }
    }

    #[test]
    fn the_mean_cosine_of_a_lambertian_direction_is_two_thirds() {
        let mut mean = 0.0;
        let n = 200;
        for i in 0..n {
            for j in 0..n {
                let u = [(f64::from(i) + 0.5) / f64::from(n), (f64::from(j) + 0.5) / f64::from(n)];
                mean += cosine_hemisphere(DVec3::Y, u).y;
            }
        }
        assert!((mean / f64::from(n * n) - 2.0 / 3.0).abs() < 1e-3);
    }
}
