//! All that one convex body makes of a ray: reflected outside, and out again after each number of chords.

use super::body::{ELLIPSOID, LocalRay, entered, interval, left, normal};
use super::interface::Interface;
use crate::GrainGrid;
use crate::flight::ShapedArrival;
use crate::grain_grid::{Part, Placement, Prototype};
use snowgrain_geometry::Shape;
use snowgrain_math::{DVec3, Ray};

/// Weight below which a chain is not followed.
pub const LEAST_WEIGHT: f64 = 1e-5;
/// Interfaces after which a chain is not followed: total reflection takes no weight.
pub const MOST_INTERFACES: usize = 1000;

/// Faces are parallel whose normals are opposite to so much.
const PARALLEL: f64 = 1e-12;

/// A ray that leaves a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outgoing {
    /// From the surface on, in the prototype's space.
    pub ray: Ray,
    /// Its part of the light that arrived.
    pub weight: f64,
    /// Chords in the body before: 0 for what is reflected outside.
    pub chords: u32,
    /// Length in ice, in radii.
    pub ice_length: f64,
}

/// The chain of interfaces that a ray meets in one body, followed both ways at each.
#[derive(Clone, Debug, PartialEq)]
pub struct Chain {
    /// What leaves, by the number of chords.
    pub outgoing: Vec<Outgoing>,
    /// Chords that were followed.
    pub chords: u32,
    /// The weight that was still inside after them.
    pub rest: f64,
}

/// The chain of a ray (unit direction, in the prototype's space and in radii) that comes from outside, for ice of
/// relative index `eta`; `None` where it misses the shape, or where that is no single convex body, of which
/// a ray that leaves may meet another part.
#[must_use]
pub fn chain(shape: &Shape, ray: &Ray, eta: f64) -> Option<Chain> {
    let local = LocalRay { origin: ray.origin, direction: ray.direction };
    of_prototype(&Prototype::new(shape), local, eta)
}

impl GrainGrid {
    /// The chain of light that arrives at a shaped grain along the unit vector `direction`, in the axes of the
    /// world, from the centre of the grain and in its radii; `None` where it is no single convex body.
    #[must_use]
    pub fn chain(
        &self,
        arrival: &ShapedArrival,
        direction: DVec3,
        radius: f64,
        eta: f64,
    ) -> Option<Chain> {
        let ShapedArrival { shape, from_center } = *arrival;
        let prototype = self.shapes()?.prototypes.get(shape.prototype())?;
        let placement =
            Placement { rotation: shape.rotation(), radius, prototype: shape.prototype() };
        let local = LocalRay {
            origin: placement.to_prototype(from_center),
            direction: placement.turned_back(direction),
        };
        let mut chain = of_prototype(prototype, local, eta)?;
        for out in &mut chain.outgoing {
            let Ray { origin, direction, .. } = out.ray;
            out.ray = Ray::new(placement.rotation * origin, placement.rotation * direction);
        }
        Some(chain)
    }
}

fn of_prototype(prototype: &Prototype, mut local: LocalRay, eta: f64) -> Option<Chain> {
    let [part] = prototype.parts.as_slice() else { return None };
    let [enter, leave] = interval(part, &local)?;
    if leave <= 0.0 {
        return None;
    }
    let mut on = entered(part, &local, enter);
    let point = local.origin + local.direction * enter.max(0.0);
    let interface = Interface::new(local.direction, normal(part, on, point), 1.0 / eta);
    let reflected = 1.0 - interface.transmittance();
    let rest = interface.transmittance();
    let mut chain = Chain { outgoing: Vec::new(), chords: 0, rest };
    chain.add(reflected, Ray::new(point, interface.reflected()), [0.0, 0.0]);
    local = LocalRay { origin: point, direction: interface.refracted() };
    let mut length = 0.0;
    for chords in 1..MOST_INTERFACES {
        if chain.rest < LEAST_WEIGHT {
            break;
        }
        length += step(part, &mut local, &mut on);
        chain.chords = chords as u32;
        let outward = normal(part, on, local.origin);
        let interface = Interface::new(local.direction, -outward, eta);
        let weight = chain.rest * interface.transmittance();
        let out = Ray::new(local.origin, interface.refracted());
        chain.add(weight, out, [chords as f64, length]);
        chain.rest -= weight;
        local.direction = interface.reflected();
    }
    Some(chain)
}

/// How light goes straight through a body, by one chord between parallel faces.
#[derive(Clone, Copy, Debug)]
pub(super) struct Straight {
    pub(super) transmittance: f64,
    /// Length in ice, radii.
    pub(super) length: f64,
    /// Where it leaves.
    pub(super) leaves: DVec3,
}

/// How a ray that enters a body at `enter` of it goes straight through, if it does.
#[inline(always)]
pub(super) fn straight(part: &Part, ray: &LocalRay, enter: f64, eta: f64) -> Option<Straight> {
    let on = entered(part, ray, enter);
    if on == ELLIPSOID {
        return None;
    }
    let point = ray.origin + ray.direction * enter;
    let outward = normal(part, on, point);
    let interface = Interface::new(ray.direction, outward, 1.0 / eta);
    if interface.transmittance() == 0.0 {
        return None;
    }
    let mut inside = LocalRay { origin: point, direction: interface.refracted() };
    let mut through = on;
    let length = step(part, &mut inside, &mut through);
    if through == ELLIPSOID || normal(part, through, inside.origin).dot(outward) > PARALLEL - 1.0 {
        return None;
    }
    // It meets the other face at the angle at which it left this one.
    let transmittance = interface.transmittance() * interface.transmittance();
    Some(Straight { transmittance, length, leaves: inside.origin })
}

/// Along one chord; its length.
fn step(part: &Part, ray: &mut LocalRay, on: &mut u16) -> f64 {
    let (length, through) = left(part, ray, *on);
    *on = through;
    ray.origin += ray.direction * length;
    length
}

impl Chain {
    fn add(&mut self, weight: f64, ray: Ray, [chords, ice_length]: [f64; 2]) {
        if weight > 0.0 {
            self.outgoing.push(Outgoing { ray, weight, chords: chords as u32, ice_length });
        }
    }

    /// The parts of the light that leave along each direction, summed as a vector: the mean cosine with any
    /// direction is its dot product with that.
    #[must_use]
    pub fn mean_direction(&self) -> DVec3 {
        self.outgoing.iter().map(|out| out.ray.direction * out.weight).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use snowgrain_geometry::ShapeKind;
    use snowgrain_math::frame;
    use snowgrain_math::sampler::{PathKey, numbers};

    /// A ray of all that meet the ball of radius `reach` from all sides.
    fn arriving(index: u64, reach: f64) -> Ray {
        let [a, b, c] = numbers(PathKey::new(1, index, 0), 0).map(f64::from);
        let d = f64::from(numbers(PathKey::new(1, index, 0), 1)[0]);
        let y = 1.0 - 2.0 * a;
        let ring = (1.0 - y * y).max(0.0).sqrt();
        let (sin, cos) = snowgrain_math::trig::sin_cos(core::f64::consts::TAU * b);
        let direction = DVec3::new(ring * cos, y, ring * sin).normalize();
        let (s, t) = frame::tangents(direction);
        let (sin, cos) = snowgrain_math::trig::sin_cos(core::f64::consts::TAU * d);
        let aside = (s * cos + t * sin) * (reach * c.sqrt());
        Ray::new(aside - direction * (2.0 * reach), direction)
    }

    #[test]
    fn weights_sum_to_one_less_the_rest_and_rays_leave_the_body_for_good() {
        for kind in [
            ShapeKind::Sphere,
            ShapeKind::Spheroid { aspect: 0.4 },
            ShapeKind::Cube { rounding: 0.2 },
            ShapeKind::HexagonalPrism { aspect: 0.3, rounding: 0.0 },
            ShapeKind::RandomPolyhedron { faces: 14, seed: 2, rounding: 0.0 },
        ] {
            let shape = Shape::new(kind).expect("the shape is legal");
            let (mut met, mut rest) = (0, 0.0);
            for index in 0..2000 {
                let ray = arriving(index, shape.bounding_radius());
                let Some(chain) = chain(&shape, &ray, 1.31) else { continue };
                met += 1;
                rest += chain.rest;
                let sum: f64 = chain.outgoing.iter().map(|out| out.weight).sum();
                assert!((sum + chain.rest - 1.0).abs() < 1e-12, "{kind:?} {sum} {}", chain.rest);
                for out in &chain.outgoing {
                    let on = shape.parts()[0].interval(out.ray.origin, out.ray.direction);
                    assert!(on.is_none_or(|again| again.leave < 1e-7), "{kind:?} {out:?}");
                    assert!(!shape.contains(out.ray.at(0.01)));
                }
            }
            assert!(met > 800);
            assert!(rest / f64::from(met) < 2e-3, "{kind:?} {}", rest / f64::from(met));
        }
    }

    /// Mean cosine and length in a sphere: the closed forms of `snowgrain-optics`, 4 sigma (1 in 16 000 seeds).
    #[test]
    fn the_chain_of_a_sphere_has_the_asymmetry_and_absorption_of_its_closed_form() {
        let shape = Shape::new(ShapeKind::Sphere).expect("a sphere is legal");
        let (mut cosines, mut squares, mut length, mut n) = (0.0, 0.0, 0.0, 0.0);
        for index in 0..40_000 {
            let ray = arriving(index, 1.0);
            let Some(chain) = chain(&shape, &ray, 1.31) else { continue };
            let cosine = chain.mean_direction().dot(ray.direction);
            cosines += cosine;
            squares += cosine * cosine;
            length += chain.outgoing.iter().map(|out| out.weight * out.ice_length).sum::<f64>();
            n += 1.0;
        }
        let g = cosines / n;
        let sigma = ((squares / n - g * g) / n).sqrt();
        assert!((g - 0.78166).abs() < 4.0 * sigma + 1e-5, "{g} +- {sigma}");
        // B = mean length by the mean chord 4/3.
        assert!((length / n * 0.75 - 1.2535).abs() < 0.003, "{}", length / n * 0.75);
    }

    #[test]
    fn a_union_of_bodies_has_no_such_chain() {
        let kind = ShapeKind::Rosette { arms: 3, aspect: 2.0, rounding: 0.0 };
        let shape = Shape::new(kind).expect("the shape is legal");
        assert_eq!(chain(&shape, &arriving(0, 1.0), 1.31), None);
    }
}
