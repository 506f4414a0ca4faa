use super::*;
use crate::fresnel::{reflect, refract};
use core::f64::consts::TAU;
use snowgrain_math::sampler::{PathKey, numbers};
use snowgrain_math::trig;

const ICE: Dielectric = Dielectric { eta: 1.31 };

fn random(index: u64, event: u32) -> DVec3 {
    DVec3::from_array(numbers(PathKey::new(3, index, 0), event).map(f64::from))
}

fn direction(u: DVec3) -> DVec3 {
    let height = 2.0 * u.x - 1.0;
    let (sin, cos) = trig::sin_cos(TAU * u.y);
    let across = (1.0 - height * height).sqrt();
    DVec3::new(across * cos, height, across * sin)
}

/// A sphere of radius about 1 at the origin, which a pencil looks at, through a point or parallel, and another
/// near it; by these orders.
fn setting(index: u64, orders: [u32; 2]) -> (Pencil, SpherePair) {
    let from = direction(random(index, 0));
    let (right, down) = frame::tangents(-from);
    let distance = 5.0 + 20.0 * random(index, 1).x;
    let pencil = if index.is_multiple_of(2) {
        Pencil {
            origin: from * distance,
            direction: -from * distance,
            origin_by: [DVec3::ZERO; 2],
            direction_by: [right, down],
        }
    } else {
        Pencil {
            origin: from * distance,
            direction: -from,
            origin_by: [right, down],
            direction_by: [DVec3::ZERO; 2],
        }
    };
    let radii = [0.7 + 0.6 * random(index, 1).y, 0.7 + 0.6 * random(index, 1).z];
    let apart = radii[0] + radii[1] + random(index, 2).z;
    let centers = [DVec3::ZERO, direction(random(index, 2)) * apart];
    let visit = |sphere: usize| SphereVisit {
        center: centers[sphere],
        radius: radii[sphere],
        order: orders[sphere],
    };
    (pencil, SpherePair { medium: ICE, visits: [visit(0), visit(1)] })
}

/// Follows a ray by Snell's law, interface by interface.
fn by_interfaces(sphere: &SphereVisit, (origin, mut d): (DVec3, DVec3)) -> Option<(DVec3, DVec3)> {
    let from_center = origin - sphere.center;
    let middle = -from_center.dot(d);
    let half2 = sphere.radius * sphere.radius - (from_center + d * middle).length_squared();
    let t = middle - half2.max(0.0).sqrt();
    if half2 <= 0.0 || t <= 0.0 {
        return None;
    }
    let mut at = from_center + d * t;
    let normal = |at: DVec3| at / sphere.radius;
    if sphere.order == 0 {
        return Some((at + sphere.center, reflect(d, normal(at))));
    }
    d = refract(d, normal(at), ICE.eta)?;
    for chord in 1..=sphere.order {
        at += d * (-2.0 * at.dot(d));
        d = if chord == sphere.order {
            refract(d, -normal(at), 1.0 / ICE.eta)?
        } else {
            reflect(d, normal(at))
        };
    }
    Some((at + sphere.center, d))
}

fn all_orders() -> impl Iterator<Item = [u32; 2]> {
    (0..4).flat_map(|first| (0..4).map(move |second| [first, second]))
}

/// Rays leave as Snell's law at each interface says, into the solid angle that neighbouring rays span.
#[test]
fn rays_through_two_spheres_leave_as_interface_by_interface() {
    for orders in all_orders() {
        let mut count = 0;
        for index in 0..4_000 {
            let (pencil, pair) = setting(index, orders);
            let place = random(index, 3);
            let at = [2.0 * place.x - 1.0, 2.0 * place.y - 1.0];
            let leaves = |at: [f64; 2]| {
                let between = by_interfaces(&pair.visits[0], pencil.ray(at))?;
                by_interfaces(&pair.visits[1], between)
            };
            let (found, expected) = (pair.follow(&pencil, at), leaves(at));
            assert_eq!(pair.pass(&pencil, at), found.map(|found| found.passed));
            assert_eq!(found.is_some(), expected.is_some(), "{orders:?} {index}");
            let (Some(found), Some((exit, ways))) = (found, expected) else { continue };
            let [_, last] = found.passed;
            assert!((last.direction - ways).length() < 1e-9, "{orders:?} {index}");
            let second = &pair.visits[1];
            let off = (second.center + last.exit * second.radius - exit).length();
            assert!(off < 1e-9, "{orders:?} {index}: {off}");
            count += 1;
            if found.passed.iter().any(|passed| passed.cosine < 0.2) {
                continue; // At grazing incidence differences of rays say little.
            }
            let step = 1e-6;
            let leaves_at = |x: f64, y: f64| Some(leaves([at[0] + x, at[1] + y])?.1);
            let by = |x: f64, y: f64| {
                let (high, low) = (leaves_at(x, y)?, leaves_at(-x, -y)?);
                Some((high - low) / (2.0 * step))
            };
            let (Some(a), Some(b)) = (by(step, 0.0), by(0.0, step)) else { continue };
            let (spread, expected) = (found.solid_angle(), a.cross(b).length());
            let scale = a.length() * b.length();
            assert!((spread - expected).abs() < 1e-4 * scale, "{orders:?}: {spread} {expected}");
        }
        assert!(count > 5, "{orders:?}: {count}");
    }
}

/// Where a ray leaves, a search from near it comes back to it; and whatever a search from afar finds leaves so.
#[test]
fn searches_find_rays_that_leave_where_they_are_wanted() {
    let (mut starts, mut near, mut far) = (0, 0, 0);
    for orders in all_orders() {
        for index in 0..4_000 {
            let (pencil, pair) = setting(index, orders);
            let place = random(index, 3);
            let at = [2.0 * place.x - 1.0, 2.0 * place.y - 1.0];
            let Some(known) = pair.follow(&pencil, at) else { continue };
            let wanted = known.passed[1].direction;
            let shift = random(index, 4);
            starts += 1;
            for reach in [1e-4, 1.0] {
                let start = [at[0] + reach * (shift.x - 0.5), at[1] + reach * (shift.y - 0.5)];
                let Some(found) = pair.solve(&pencil, (start, reach), wanted) else { continue };
                let off = (found.passed[1].direction - wanted).length();
                assert!(off < 1e-6, "{orders:?} {index}: {off}");
                let moved = (found.at[0] - at[0]).abs().max((found.at[1] - at[1]).abs());
                near += u32::from(reach < 1e-3 && moved < 1e-6);
                far += u32::from(reach > 1e-3);
            }
        }
    }
    println!("{starts} starts: {near} from near, {far} from afar");
    assert!(near > starts * 9 / 10 && far > starts / 10, "{starts} {near} {far}");
}

/// Parts of light and lengths in ice are those of Fresnel's equations and Snell's law at each sphere.
#[test]
fn the_energies_of_both_visits_are_those_of_the_closed_form() {
    let mut count = 0;
    for index in 0..4_000 {
        let (pencil, pair) = setting(index, [1, 2]);
        let place = random(index, 5);
        let at = [2.0 * place.x - 1.0, 2.0 * place.y - 1.0];
        let Some(found) = pair.follow(&pencil, at) else { continue };
        count += 1;
        for (sphere, passed) in found.passed.iter().enumerate() {
            let ((energy, length), cosine) = (pair.part(sphere, passed), passed.cosine);
            let r = ICE.reflectance_from_outside(cosine);
            let expected = [(1.0 - r) * (1.0 - r), (1.0 - r) * (1.0 - r) * r][sphere];
            assert!((energy - expected).abs() < 1e-9, "{energy} {expected}");
            let inside = (1.0 - (1.0 - cosine * cosine) / (1.31 * 1.31)).sqrt();
            let chords = [2.0, 4.0][sphere] * inside * pair.visits[sphere].radius;
            assert!((length - chords).abs() < 1e-9, "{length} {chords}");
        }
    }
    assert!(count > 20, "{count}");
}
