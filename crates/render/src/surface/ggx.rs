//! Rough faces as microfacets of the distribution of Trowbridge and Reitz (1975), called GGX by Walter,
//! Marschner, Li and Torrance 2007, "Microfacet Models for Refraction through Rough Surfaces".
//!
//! Vectors are unit vectors in the frame of the face, whose normal is z; `alpha` in (0, 1] is the slope
//! of the facets.

use core::f64::consts::{PI, TAU};
use snowgrain_math::{DVec3, trig};

/// The distribution of the normals of facets: area of facets per area of the face and solid angle, 1/sr
/// (Walter et al. 2007, eq. 33); 0 for normals below the face.
pub(super) fn normals(alpha: f64, facet: DVec3) -> f64 {
    if facet.z <= 0.0 {
        return 0.0;
    }
    let across = (facet.x * facet.x + facet.y * facet.y) / (alpha * alpha);
    let spread = across + facet.z * facet.z;
    1.0 / (PI * alpha * alpha * spread * spread)
}

/// Smith's auxiliary function: the part of a direction that is masked is `lambda / (1 + lambda)` (Heitz
/// 2014, "Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs", eq. 72). Either side.
pub(super) fn lambda(alpha: f64, direction: DVec3) -> f64 {
    let across = direction.x * direction.x + direction.y * direction.y;
    let height = direction.z * direction.z;
    0.5 * ((1.0 + alpha * alpha * across / height).sqrt() - 1.0)
}

/// The normal of a facet that is seen from `outgoing` (above the face), by two uniform numbers, with the
/// density [`visible_normals`] (Heitz 2018, "Sampling the GGX Distribution of Visible Normals", section
/// 3).
pub(super) fn visible_normal(alpha: f64, outgoing: DVec3, [u, v]: [f64; 2]) -> DVec3 {
    // On the hemisphere that the ellipsoid of the distribution becomes.
    let view = DVec3::new(alpha * outgoing.x, alpha * outgoing.y, outgoing.z).normalize();
    let across = view.x * view.x + view.y * view.y;
    let first =
        if across > 0.0 { DVec3::new(-view.y, view.x, 0.0) / across.sqrt() } else { DVec3::X };
    let second = view.cross(first);
    let radius = u.sqrt();
    let (sin, cos) = trig::sin_cos(TAU * v);
    let a = radius * cos;
    let lean = 0.5 * (1.0 + view.z);
    let b = (1.0 - lean) * (1.0 - a * a).max(0.0).sqrt() + lean * (radius * sin);
    let height = (1.0 - a * a - b * b).max(0.0).sqrt();
    let normal = first * a + second * b + view * height;
    DVec3::new(alpha * normal.x, alpha * normal.y, normal.z.max(1e-9)).normalize()
}

/// Density of [`visible_normal`], 1/sr (Heitz 2018, eq. 3).
pub(super) fn visible_normals(alpha: f64, outgoing: DVec3, facet: DVec3) -> f64 {
    let seen = outgoing.dot(facet);
    if seen <= 0.0 {
        return 0.0;
    }
    normals(alpha, facet) * seen / (outgoing.z * (1.0 + lambda(alpha, outgoing)))
}
