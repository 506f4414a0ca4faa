//! One interface between air and ice, written from the textbook in terms of both indices.

use snowgrain_math::DVec3;

/// What an interface offers to a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interface {
    /// Reflectance of unpolarised light; exactly 1 in total internal reflection.
    pub reflectance: f64,
    /// The reflected unit direction.
    pub reflected: DVec3,
    /// The refracted unit direction; meaningless where the reflectance is 1.
    pub refracted: DVec3,
}

impl Interface {
    /// The interface met by `direction`, whose unit `normal` points back to the side that the ray
    /// comes from, between the index `n1` on that side and `n2` beyond.
    #[must_use]
    pub fn new(direction: DVec3, normal: DVec3, n1: f64, n2: f64) -> Self {
        let cos1 = (-direction.dot(normal)).clamp(0.0, 1.0);
        let reflected = (direction + normal * (2.0 * cos1)).normalize();
        let ratio = n1 / n2;
        let sin2_squared = ratio * ratio * (1.0 - cos1 * cos1);
        if sin2_squared >= 1.0 {
            return Self { reflectance: 1.0, reflected, refracted: direction };
        }
        let cos2 = (1.0 - sin2_squared).sqrt();
        let perpendicular = (n1 * cos1 - n2 * cos2) / (n1 * cos1 + n2 * cos2);
        let parallel = (n2 * cos1 - n1 * cos2) / (n2 * cos1 + n1 * cos2);
        Self {
            reflectance: (perpendicular * perpendicular + parallel * parallel) / 2.0,
            reflected,
            refracted: (direction * ratio + normal * (ratio * cos1 - cos2)).normalize(),
        }
    }
}
