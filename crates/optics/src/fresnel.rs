//! What happens to light at one smooth interface between two transparent media.
//!
//! `relative_index` is always the index of the medium that the light comes *towards* over that of
//! the medium it comes *from*: eta when light enters ice from air, 1/eta when it leaves.

use snowgrain_math::DVec3;

/// Reflectance of unpolarised light: the mean of Fresnel's two polarisations (Born & Wolf,
/// "Principles of Optics", 7th ed., section 1.5.3), 1 beyond the critical angle.
///
/// `cos_theta_i` in [0, 1] is the cosine of the angle of incidence; `relative_index` > 0.
#[must_use]
pub fn reflectance(cos_theta_i: f64, relative_index: f64) -> f64 {
    let [s, p] = polarised_reflectances(cos_theta_i, relative_index);
    0.5 * (s + p)
}

/// Reflectances of light polarised across the plane of incidence (s) and along it (p); 1 beyond the
/// critical angle.
///
/// `cos_theta_i` in [0, 1] is the cosine of the angle of incidence; `relative_index` > 0.
#[must_use]
pub fn polarised_reflectances(cos_theta_i: f64, relative_index: f64) -> [f64; 2] {
    if relative_index == 1.0 {
        return [0.0; 2];
    }
    let Some(cos_theta_t) = cos_refracted(cos_theta_i, relative_index) else { return [1.0; 2] };
    let s =
        (cos_theta_i - relative_index * cos_theta_t) / (cos_theta_i + relative_index * cos_theta_t);
    let p =
        (relative_index * cos_theta_i - cos_theta_t) / (relative_index * cos_theta_i + cos_theta_t);
    [s * s, p * p]
}

/// Cosine of the angle of refraction (Snell), `None` where all light is reflected.
#[must_use]
pub fn cos_refracted(cos_theta_i: f64, relative_index: f64) -> Option<f64> {
    let sin2_theta_i = (1.0 - cos_theta_i) * (1.0 + cos_theta_i);
    let cos2_theta_t = 1.0 - sin2_theta_i / (relative_index * relative_index);
    (cos2_theta_t > 0.0).then(|| cos2_theta_t.sqrt())
}

/// `direction` mirrored in the plane whose unit normal is `normal` (either side).
#[must_use]
pub fn reflect(direction: DVec3, normal: DVec3) -> DVec3 {
    direction - normal * (2.0 * direction.dot(normal))
}

/// The refracted unit direction, `None` where all light is reflected. `normal` is the unit normal
/// on the side from which `direction` (unit length) comes: `direction . normal <= 0`.
#[must_use]
pub fn refract(direction: DVec3, normal: DVec3, relative_index: f64) -> Option<DVec3> {
    let cos_theta_i = -direction.dot(normal);
    let cos_theta_t = cos_refracted(cos_theta_i, relative_index)?;
    let tangential = (direction + normal * cos_theta_i) / relative_index;
    Some((tangential - normal * cos_theta_t).normalize())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normal_incidence_and_grazing_have_their_limits() {
        for eta in [1.31f64, 1.5, 1.0 / 1.31] {
            let r0 = (eta - 1.0) / (eta + 1.0);
            assert!((reflectance(1.0, eta) - r0 * r0).abs() < 1e-15);
            assert!(reflectance(1e-9, eta) > 1.0 - 1e-7);
        }
        assert_eq!(reflectance(0.3, 1.0), 0.0);
    }

    #[test]
    fn brewsters_angle_leaves_half_of_the_senkrecht_reflectance() {
        let eta = 1.31f64;
        let cos = 1.0 / (1.0 + eta * eta).sqrt();
        let s = (1.0 - eta * eta) / (1.0 + eta * eta);
        assert!((reflectance(cos, eta) - 0.5 * s * s).abs() < 1e-15);
    }

    #[test]
    fn both_directions_of_a_refracted_ray_reflect_alike() {
        for i in 1..=1000 {
            let cos = f64::from(i) / 1000.0;
            let inside = cos_refracted(cos, 1.31).unwrap();
            assert!((reflectance(cos, 1.31) - reflectance(inside, 1.0 / 1.31)).abs() < 1e-12);
        }
    }

    #[test]
    fn light_beyond_the_critical_angle_is_reflected_whole() {
        let critical = (1.0 - 1.0 / (1.31f64 * 1.31)).sqrt();
        assert_eq!(reflectance(critical - 1e-9, 1.0 / 1.31), 1.0);
        assert!(reflectance(critical + 1e-9, 1.0 / 1.31) < 1.0);
        let grazing = DVec3::new(1.0, -0.1, 0.0).normalize();
        assert_eq!(refract(grazing, DVec3::Y, 1.0 / 1.31), None);
    }

    #[test]
    fn refraction_obeys_snell_stays_in_the_plane_and_turns_back() {
        let normal = DVec3::new(0.48, 0.6, 0.64);
        let direction = DVec3::new(-0.9, -0.3, 0.1).normalize();
        let inside = refract(direction, normal, 1.31).unwrap();
        let sine = |d: DVec3| d.cross(normal).length();
        assert!((sine(direction) - 1.31 * sine(inside)).abs() < 1e-14);
        assert!(direction.cross(normal).dot(inside).abs() < 1e-14);
        assert!((inside.length() - 1.0).abs() < 1e-15);
        let back = refract(-inside, -normal, 1.0 / 1.31).unwrap();
        assert!((back + direction).length() < 1e-14);
        assert!((reflect(direction, normal).dot(normal) + direction.dot(normal)).abs() < 1e-15);
    }
}
