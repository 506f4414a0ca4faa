use super::ggx;
use super::scatterer::{Kind, Scatterer};
use super::{Material, Surface};
use snowgrain_accel::{SurfaceShape, Surfaces};
use snowgrain_geometry::teapot;
use snowgrain_math::sampler::{PathKey, numbers};
use snowgrain_math::{DAffine3, DVec3, Ray, frame, trig};
use std::f64::consts::TAU;
use std::sync::Arc;

const SAMPLES: u32 = 40_000;
/// Bins of the cosine and of the azimuth, and steps of the quadrature in each of them along both.
const HEIGHTS: usize = 20;
const AZIMUTHS: usize = 8;
const STEPS: usize = 24;

/// In which the surface is neither level nor turned to an axis.
fn normal() -> DVec3 {
    DVec3::new(0.48, 0.6, 0.64)
}

fn scatterer(kind: Kind, cosine: f64) -> Scatterer {
    let (s, t) = frame::tangents(normal());
    let across = (1.0 - cosine * cosine).sqrt();
    let outgoing = normal() * cosine + (s * 0.8 + t * 0.6) * across;
    Scatterer::new(normal(), -outgoing.normalize(), kind)
}

/// Rough surfaces of all kinds from all sides, steep and grazing.
fn rough() -> Vec<Scatterer> {
    let mut all = Vec::new();
    for alpha in [0.16, 0.5, 1.0].map(Some) {
        for cosine in [0.95, 0.3] {
            for relative_index in [1.5, 1.0 / 1.5] {
                all.push(scatterer(Kind::Dielectric { relative_index, alpha }, cosine));
            }
            let reflectance = [1.0, 0.7, 0.2];
            all.push(scatterer(Kind::Conductor { reflectance, alpha }, cosine));
        }
    }
    all
}

fn direction(height: f64, azimuth: f64) -> DVec3 {
    let (s, t) = frame::tangents(normal());
    let across = (1.0 - height * height).max(0.0).sqrt();
    let (sin, cos) = trig::sin_cos(azimuth);
    (normal() * height + s * (across * cos) + t * (across * sin)).normalize()
}

/// The integral of a function of directions over each bin of the sphere.
fn integrals(of: impl Fn(DVec3) -> f64) -> Vec<f64> {
    let cells = (HEIGHTS * STEPS, AZIMUTHS * STEPS);
    let area = 2.0 / cells.0 as f64 * TAU / cells.1 as f64;
    let mut sums = vec![0.0; HEIGHTS * AZIMUTHS];
    for i in 0..cells.0 {
        for j in 0..cells.1 {
            let height = (i as f64 + 0.5) / cells.0 as f64 * 2.0 - 1.0;
            let azimuth = (j as f64 + 0.5) / cells.1 as f64 * TAU;
            sums[i / STEPS * AZIMUTHS + j / STEPS] += of(direction(height, azimuth)) * area;
        }
    }
    sums
}

fn bin_of(direction: DVec3) -> usize {
    let (s, t) = frame::tangents(normal());
    let height = direction.dot(normal());
    let azimuth = trig::atan2(direction.dot(t), direction.dot(s)).rem_euclid(TAU);
    let i = ((height + 1.0) * 0.5 * HEIGHTS as f64) as usize;
    let j = (azimuth / TAU * AZIMUTHS as f64) as usize;
    i.min(HEIGHTS - 1) * AZIMUTHS + j.min(AZIMUTHS - 1)
}

/// All samples of a surface, with what is lost.
fn samples(of: &Scatterer) -> impl Iterator<Item = Option<super::Scattered>> {
    (0..SAMPLES).map(move |sample| {
        let key = PathKey::new(11, 0, u64::from(sample));
        let [u, v, _] = numbers(key, 0).map(f64::from);
        of.sample([u, v], || f64::from(numbers(key, 1)[0]))
    })
}

/// 18 tests, each with up to 160 degrees of freedom; beyond 5 standard deviations of chi-square, by chance
/// once in 10^5 runs of all.
#[test]
fn directions_come_with_their_density_and_the_lost_are_the_rest() {
    for surface in rough() {
        let expected = integrals(|direction| surface.density(direction));
        let all: f64 = expected.iter().sum();
        assert!(all <= 1.001, "{surface:?}: {all}");
        let mut counts = vec![0.0; expected.len() + 1];
        for sample in samples(&surface) {
            let bin = sample.map_or(expected.len(), |sample| bin_of(sample.direction));
            counts[bin] += 1.0;
        }
        let lost = (1.0 - all).max(0.0);
        let (mut chi2, mut bins, mut rest) = (0.0, 0.0, [0.0, 0.0]);
        for (&count, share) in counts.iter().zip(expected.iter().copied().chain([lost])) {
            let mean = share * f64::from(SAMPLES);
            if mean < 10.0 {
                rest = [rest[0] + count, rest[1] + mean];
                continue;
            }
            chi2 += (count - mean) * (count - mean) / mean;
            bins += 1.0;
        }
        assert!((rest[0] - rest[1]).abs() < 5.0 * (rest[1] + 4.0).sqrt(), "{surface:?}: {rest:?}");
        let limit = bins + 5.5 * (2.0f64 * bins).sqrt();
        assert!(chi2 < limit, "{surface:?}: chi2 {chi2} of {bins} bins");
    }
}

#[test]
fn weights_are_scattering_over_density_and_no_light_is_gained() {
    for surface in rough() {
        let all: f64 = integrals(|direction| surface.value(direction).1).iter().sum();
        assert!(all <= 1.001, "{surface:?}: {all}");
        for sample in samples(&surface).flatten().take(500) {
            let (colour, value) = surface.value(sample.direction);
            let density = surface.density(sample.direction);
            for (weight, colour) in sample.weight.into_iter().zip(colour) {
                let expected = f64::from(colour) * value / density;
                assert!(weight <= 1.0, "{surface:?}: {weight}");
                assert!((f64::from(weight) - expected).abs() < 1e-5 * (1.0 + expected));
            }
        }
    }
}

#[test]
fn light_goes_either_way_alike() {
    let cosine = |d: DVec3| d.dot(normal()).abs();
    for alpha in [0.1, 0.6] {
        let metal = Kind::Conductor { reflectance: [0.3; 3], alpha: Some(alpha) };
        let glass = |relative_index| Kind::Dielectric { relative_index, alpha: Some(alpha) };
        for i in 0..200u32 {
            let [a, b, c] = numbers(PathKey::new(5, 0, u64::from(i)), 0).map(f64::from);
            let from = direction(0.05 + 0.9 * a, TAU * b);
            let above = direction(0.05 + 0.9 * c, TAU * (a + b));
            for kind in [metal, glass(1.5)] {
                let there = Scatterer::new(normal(), -from, kind).value(above);
                let back = Scatterer::new(normal(), -above, kind).value(from);
                let (there, back) = (there.1 / cosine(above), back.1 / cosine(from));
                assert!((there - back).abs() < 1e-9 * (1.0 + there), "{kind:?}: {there} {back}");
            }
            // Radiance over the square of the index: the ratio of the indices remains.
            let below = -above;
            let there = Scatterer::new(normal(), -from, glass(1.5)).value(below).1 / cosine(below);
            let back = Scatterer::new(-normal(), -below, glass(1.0 / 1.5)).value(from).1;
            let back = back / cosine(from) * 2.25;
            assert!((there - back).abs() < 1e-9 * (1.0 + there), "{there} {back}");
        }
    }
}

#[test]
fn white_metal_loses_what_facets_hide() {
    let kept = |roughness: f64| {
        let kind = Kind::Conductor { reflectance: [1.0; 3], alpha: super::slope(roughness) };
        let surface = scatterer(kind, 1.0);
        let weights = samples(&surface).map(|s| s.map_or(0.0, |s| f64::from(s.weight[0])));
        weights.sum::<f64>() / f64::from(SAMPLES)
    };
    assert_eq!(kept(0.0), 1.0);
    // The integral over the slopes of the facets, by another program.
    for (roughness, expected) in
        [(0.3, 0.9907), (0.5, 0.9158), (0.7, 0.6978), (1.0, 1.0 - core::f64::consts::LN_2)]
    {
        let found = kept(roughness);
        assert!((found - expected).abs() < 0.01, "{roughness}: {found}");
    }
}

#[test]
fn facets_cover_the_face_from_every_side() {
    // The area of all facets seen from a direction is that of the face seen from there.
    for alpha in [0.2, 0.7] {
        for cosine in [1.0, 0.4] {
            let outgoing = DVec3::new((1.0f64 - cosine * cosine).sqrt(), 0.0, cosine);
            let (n, m) = (400, 100);
            let mut sum = 0.0;
            for i in 0..n {
                for j in 0..m {
                    let z = (f64::from(i) + 0.5) / f64::from(n);
                    let (sin, cos) = trig::sin_cos((f64::from(j) + 0.5) / f64::from(m) * TAU);
                    let across = (1.0 - z * z).sqrt();
                    let facet = DVec3::new(across * cos, across * sin, z);
                    let seen = outgoing.dot(facet).max(0.0) / (1.0 + ggx::lambda(alpha, outgoing));
                    sum += ggx::normals(alpha, facet) * seen * TAU / f64::from(n * m);
                }
            }
            assert!((sum / cosine - 1.0).abs() < 2e-3, "{alpha} {cosine}: {}", sum / cosine);
        }
    }
}

#[test]
fn smooth_surfaces_mirror_and_refract() {
    let mirror = scatterer(Kind::Conductor { reflectance: [0.5; 3], alpha: None }, 0.6);
    assert!(mirror.is_smooth() && mirror.density(normal()) == 0.0);
    let sample = mirror.sample([0.3, 0.7], || 0.0).unwrap();
    assert!((sample.direction.dot(normal()) - 0.6).abs() < 1e-12);
    // Schlick: .5 + .5 * .4^5.
    assert!((sample.weight[0] - 0.505_12).abs() < 1e-6);
    let glass = scatterer(Kind::Dielectric { relative_index: 1.5, alpha: None }, 0.6);
    let through = glass.sample([0.3, 0.7], || 0.99).unwrap();
    let sine = (1.0 - through.direction.dot(normal()) * through.direction.dot(normal())).sqrt();
    assert!(through.direction.dot(normal()) < 0.0 && (sine - 0.8 / 1.5).abs() < 1e-12);
    let inside = scatterer(Kind::Dielectric { relative_index: 1.0 / 1.5, alpha: None }, 0.6);
    let all = inside.sample([0.3, 0.7], || 0.999_999).unwrap();
    assert!((all.direction.dot(normal()) - 0.6).abs() < 1e-12, "reflected as a whole");
}

/// A ray into a clear solid bends to the normal, a ray out of it away, however it is turned or mirrored.
#[test]
fn the_inside_of_a_solid_is_known_by_its_shape() {
    let pot = SurfaceShape::Mesh(Arc::new(teapot(4)));
    let mirrored = DAffine3::from_scale(DVec3::new(-1.0, 2.0, 0.5));
    let turned = DAffine3::from_rotation_x(2.0) * DAffine3::from_translation(DVec3::ONE);
    for (shape, inside) in [
        (SurfaceShape::Sphere, DVec3::new(0.1, 0.2, 0.3)),
        (SurfaceShape::Box, DVec3::new(0.3, -0.2, 0.5)),
        (SurfaceShape::Plane, DVec3::new(0.0, -1.0, 0.0)),
        (pot, DVec3::new(0.0, 1.0, 0.0)),
    ] {
        for transform in [DAffine3::IDENTITY, mirrored, turned, turned * mirrored] {
            let place = (shape.clone(), transform);
            let surfaces = Surfaces::new(std::slice::from_ref(&place));
            let glass = Surface::Dielectric { ior: 1.5, roughness: 0.0 };
            let material = Material::new(glass, &place, 1.0);
            let start = transform.transform_point3(inside);
            let way = transform.transform_vector3(DVec3::new(0.3, 0.9, 0.1)).normalize();
            let ray = Ray::new(start, way);
            let out = surfaces.intersect(&ray, f64::INFINITY, None).unwrap();
            for (ray, hit, leaves) in [(ray, out, true), {
                let back = Ray::new(ray.at(out.t * 1.000_001), -way);
                (back, surfaces.intersect(&back, f64::INFINITY, None).unwrap(), false)
            }] {
                let scatterer = material.scatterer(&hit, ray.at(hit.t), ray.direction);
                let Some(through) = scatterer.sample([0.5; 2], || 0.999_999) else { panic!() };
                let sine = |d: DVec3| d.cross(hit.normal).length();
                let cosine = ray.direction.dot(hit.normal);
                let ratio = sine(through.direction) / sine(ray.direction);
                let whole = leaves && 1.5 * sine(ray.direction) > 1.0;
                let expected = if whole {
                    1.0
                } else if leaves {
                    1.5
                } else {
                    1.0 / 1.5
                };
                assert!((ratio - expected).abs() < 1e-6, "{shape:?} {leaves} {cosine}: {ratio}");
            }
        }
    }
}
