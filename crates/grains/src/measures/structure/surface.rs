//! The surface of a pack: what of the surfaces of its grains is bare.

use super::super::bodies::Body;
use super::super::buckets::Buckets;
use super::super::region::Region;
use super::ratio;
use crate::GrainField;
use core::f64::consts::{PI, TAU};
use snowgrain_math::sampler::{PathKey, numbers};
use snowgrain_math::{DVec3, frame, trig};

/// Points on the surface of each sphere at which it is seen whether it is bare, and lines through each grain of
/// another shape, at whose ends is looked.
const POINTS_A_GRAIN: u32 = 16;
/// Grains at whose surfaces is looked.
const MOST_LOOKED_AT: f64 = 200_000.0;

/// Surface of the union by volume of the region, 1/m.
pub(super) fn surface_per_volume(
    field: &GrainField,
    period: Option<[f64; 2]>,
    region: &Region,
) -> f64 {
    let buckets = Buckets::new(field, period);
    let quantisation = field.quantisation;
    let (origin, quantum) = (quantisation.origin(), quantisation.quantum());
    let every = (buckets.grains().len() as f64 / MOST_LOOKED_AT).ceil().max(1.0) as usize;
    let mut bare = 0.0;
    for (index, grain) in buckets.grains().iter().enumerate().step_by(every) {
        let [x, y, z] = grain.center.map(f64::from);
        let center = DVec3::new(x, y, z);
        let body = buckets.body(index, center);
        let (points, each) = match body.shape {
            None => on_sphere(&body, index as u64),
            Some(_) => on_lines(&body, index as u64),
        };
        let mut is_bare = vec![true; points.len()];
        buckets.around(center, |other, at, radius| {
            if other == index && at == center {
                return;
            }
            let other = buckets.body(other, at);
            for (point, bare) in points.iter().zip(&mut is_bare) {
                *bare &= match other.shape {
                    None => (*point - at).length_squared() >= radius * radius,
                    Some(_) => !(*bare && other.holds(*point)),
                };
            }
        });
        let holds = |point: &DVec3| region.holds(origin + *point * quantum);
        let found = points.iter().zip(is_bare).filter(|(point, bare)| *bare && holds(point));
        bare += found.count() as f64 * each * quantum * quantum;
    }
    ratio(bare * every as f64, region.volume())
}

/// Points on a sphere, each in a part of it of its own, and the surface that one stands for.
fn on_sphere(body: &Body<'_>, index: u64) -> (Vec<DVec3>, f64) {
    let point = |point: u32| body.center + direction(index, point) * body.radius;
    let each = 4.0 * PI * body.radius * body.radius / f64::from(POINTS_A_GRAIN);
    ((0..POINTS_A_GRAIN).map(point).collect(), each)
}

/// Where lines that are spread evenly over all that meet the bounding sphere enter and leave a grain: they cross its
/// surface S / (2 pi reach^2) times (Santalo, "Integral Geometry and Geometric Probability", chapter 14).
fn on_lines(body: &Body<'_>, index: u64) -> (Vec<DVec3>, f64) {
    let reach = body.reach();
    let mut points = Vec::new();
    for line in 0..POINTS_A_GRAIN {
        let along = direction(index, line);
        let [place, turn, _] = numbers(PathKey::new(0, index, 2), line).map(f64::from);
        let (s, t) = frame::tangents(along);
        let (sin, cos) = trig::sin_cos(TAU * turn);
        let origin = body.center + (s * cos + t * sin) * (reach * place.sqrt());
        let ends = body.stretches(origin, along).into_iter().flatten();
        points.extend(ends.map(|at| origin + along * at));
    }
    (points, TAU * reach * reach / f64::from(POINTS_A_GRAIN))
}

/// One of the directions in which is looked, each in a part of the sphere of its own.
fn direction(grain: u64, point: u32) -> DVec3 {
    let [u, v, _] = numbers(PathKey::new(0, grain, 1), point).map(f64::from);
    let y = 1.0 - 2.0 * (f64::from(point) + u) / f64::from(POINTS_A_GRAIN);
    let across = (1.0 - y * y).max(0.0).sqrt();
    let (sin, cos) = trig::sin_cos(TAU * v);
    DVec3::new(across * cos, y, across * sin)
}
