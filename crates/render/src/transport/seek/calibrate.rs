//! What a search forgets, measured and made up for.
//!
//! A search takes the places at which paths strike grains to be random. They are not quite: light that
//! goes back the way it came finds it open, and grains that overlap hide a part of each other. So what
//! the search would find of a uniform light is compared with what paths find, which is exact: some paths
//! are followed before the picture, with random numbers of their own; at each arrival a way out is drawn
//! as if the place were random, and counted where it is clear, and so are the ways by which paths escape.
//! Factors on what the search finds make the counts agree (`gains`). In uniform light it is then right
//! on average; in any other what is left is how the ratio changes within a class.

use super::agreement::Agreement;
use super::gains::{Class, Tally};
use super::shadow::{Beginning, Brings, Condition};
use super::{LastArrival, LightSearch, PathState, Seeker, search_key};
use crate::camera::Camera;
use crate::transport::over_picture::PathsOverPicture;
use crate::transport::trace_with;
use crate::world::World;
use core::f64::consts::{PI, TAU};
use rayon::prelude::*;
use snowgrain_accel::{ArrivalFrom, GrainVisit, SimdLevel};
use snowgrain_math::sampler::{PathKey, numbers};
use snowgrain_math::{DVec3, frame, trig};
use snowgrain_optics::sphere::Impact;
use snowgrain_optics::{Dielectric, fresnel};

/// Paths of one task.
const TASK: u64 = 1 << 14;
/// What tells their random numbers from those of the picture.
const STREAM: u64 = 0xca11_b7a7_e5ee_d000;
/// What tells further random numbers of a way from its first.
const SECOND: u32 = 0x2ec0_0d5e;
/// The same of paths that only compare.
const CHECK: u64 = 0xc0a9_a7e5_7e57_0000;
impl LightSearch {
    /// The same search with factors for this scene, of which a picture of `size` pixels is seen; on the
    /// threads of the current pool, which do not show in the result.
    #[must_use]
    pub fn calibrated(
        self,
        (world, camera): (&World, &Camera),
        (size, paths): ([u32; 2], u64),
        seed: u64,
        level: SimdLevel,
    ) -> Self {
        if world.grid.grains() == 0 {
            return self;
        }
        let gains = self.tally((world, camera), (size, paths), seed ^ STREAM, level).gains();
        Self { gains, ..self }
    }

    /// How what this search finds of uniform light agrees with what paths meet, which other paths measure
    /// than those of the factors: what it is wrong by in a light of any direction.
    #[must_use]
    pub fn agreements(
        &self,
        (world, camera): (&World, &Camera),
        (size, paths): ([u32; 2], u64),
        seed: u64,
        level: SimdLevel,
    ) -> Vec<Agreement> {
        self.tally((world, camera), (size, paths), seed ^ CHECK, level).agreements(&self.gains)
    }

    fn tally(
        &self,
        (world, camera): (&World, &Camera),
        (size, paths): ([u32; 2], u64),
        seed: u64,
        level: SimdLevel,
    ) -> Tally {
        let size = size.map(f64::from);
        let tasks = (0..paths.div_ceil(TASK)).into_par_iter();
        tasks
            .map(|task| {
                let mut seeker = Seeker::new(world, camera, self, level);
                seeker.tally = Some(Tally::default());
                let range = task * TASK..((task + 1) * TASK).min(paths);
                let mut paths = PathsOverPicture { camera, size, seed, range, met: 0 };
                let (seeker, _) =
                    trace_with((world, self.medium.eta), level, (Some(seeker), None), &mut paths);
                seeker.and_then(|seeker| seeker.tally).unwrap_or_default()
            })
            .reduce(Tally::default, |sum, part| sum.merged(&part))
    }
}

impl Seeker<'_> {
    /// Draws a way out of a grain as if the path struck it at a random place.
    pub(super) fn try_a_way(
        &mut self,
        visit: &GrainVisit,
        last: &LastArrival,
        (order, seen_along): (u32, DVec3),
        state: &PathState,
    ) {
        let key = search_key(state.key);
        let random = numbers(key, visit.event).map(f64::from);
        let medium = self.search.medium;
        let turn = match (visit.from, last.prototype) {
            (ArrivalFrom::Air, None) => turn_from_air(medium, random),
            (ArrivalFrom::Air, Some(_)) => self.turn_of_shape(visit, last, (random, key)),
            (ArrivalFrom::Ice, _) => turn_from_ice(medium, random),
        };
        let Some([entry, exit, leaves]) = turn else { return };
        let (s, t) = frame::tangents(last.direction);
        let (sin, cos) = trig::sin_cos(TAU * random[2]);
        let across = s * cos + t * sin;
        let at = |angle: f64| -> DVec3 {
            let (sin, cos) = trig::sin_cos(angle);
            (last.direction * cos + across * sin).normalize()
        };
        let direction = at(leaves);
        let class = Class::new((visit.from, order), seen_along, [last.direction, direction]);
        let begins = |origin| Beginning {
            grain: (visit.center, visit.radius),
            direction: last.direction,
            normal: at(entry),
            origin,
            key,
            event: visit.event,
        };
        let condition = last.origin.map_or(Condition::Nothing, |at| Condition::Begins(begins(at)));
        let towards = (direction, f64::INFINITY, None);
        self.want(visit, (at(exit), visit.radius), towards, Brings::Count(class), condition);
    }
}

impl Seeker<'_> {
    /// The same as [`turn_from_air`] of a grain of a shape.
    fn turn_of_shape(
        &self,
        visit: &GrainVisit,
        last: &LastArrival,
        (random, key): ([f64; 3], PathKey),
    ) -> Option<[f64; 3]> {
        let key = PathKey { lo: key.lo ^ SECOND, ..key };
        let [which, place, _] = numbers(key, visit.event).map(f64::from);
        let table = self.search.table(visit.from, last.prototype);
        let (cosine, way) = table.sample([random[0], which, place])?;
        Some([way.entry, way.exit, trig::acos(cosine.clamp(-1.0, 1.0))])
    }
}

/// Angles, from the direction of arrival towards the side on which light arrives, of the normals at the
/// entry and at the exit, and of the direction in which light leaves: `random[0]` chooses the place on the disc, `random[1]` the order.
fn turn_from_air(medium: Dielectric, random: [f64; 3]) -> Option<[f64; 3]> {
    let impact = Impact::at_disc_fraction(medium, random[0]);
    let order = order_of(random[1], |order| impact.energy(order));
    let leaves = match order {
        0 => impact.deflection(0),
        _ => -impact.deflection(order),
    };
    let exit = PI - impact.theta_i - f64::from(order) * (PI - 2.0 * impact.theta_t);
    Some([PI - impact.theta_i, exit, leaves])
}

/// The same of light that is in the ice; `None` where it does not get out.
fn turn_from_ice(medium: Dielectric, random: [f64; 3]) -> Option<[f64; 3]> {
    let sine = random[0].sqrt();
    let outside = Some(medium.eta * sine).filter(|&sine| sine < 1.0)?;
    let (inside, outside) = (trig::asin(sine), trig::asin(outside));
    let reflectance = fresnel::reflectance((1.0 - random[0]).sqrt(), 1.0 / medium.eta);
    let order =
        order_of(random[1], |order| (1.0 - reflectance) * trig::pow(reflectance, f64::from(order)));
    let exit = inside - f64::from(order) * (PI - 2.0 * inside);
    Some([PI - inside, exit, exit - outside])
}

/// The order that a number chooses among orders of these shares.
fn order_of(random: f64, share: impl Fn(u32) -> f64) -> u32 {
    const LAST: u32 = 64;
    let mut sum = 0.0;
    for order in 0..LAST {
        sum += share(order);
        if random < sum {
            return order;
        }
    }
    LAST
}
