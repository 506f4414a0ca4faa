//! Light that a path meets by chance while others of it are looked for.

use super::{GRAINS_BEFORE_RANDOM, Seeker, Trail, Vertex, product, scaled};
use crate::light::Lights;
use crate::transport::{Contribution, PathResult};
use core::f64::consts::PI;
use snowgrain_accel::ArrivalFrom;
use snowgrain_math::DVec3;

/// What counts of a light that is met by chance.
#[derive(Clone, Copy)]
enum Chance<'a> {
    /// Nothing: it is found otherwise.
    Nothing,
    /// Its light as these lights have it.
    All(&'a Lights),
    /// The part that the balance heuristic leaves, where chance has this density (1/sr).
    Part(f64),
}

impl Seeker<'_> {
    /// Books the light that a path meets where it escapes; that which the camera sees directly is not
    /// here.
    pub(in super::super) fn at_escape(
        &self,
        trail: &mut Trail,
        direction: DVec3,
        path: &PathResult,
    ) {
        let search = self.search;
        let order = trail.order(path.grain_visits);
        if order == 0 && trail.vertex == Vertex::Camera {
            return;
        }
        for light in 0..search.lights.count() {
            let small = search.is_small[light];
            let chance = if search.is_sought[light] {
                self.chance(trail, (direction, path), order, small)
            } else {
                Chance::All(&search.lights)
            };
            let (lights, part) = match chance {
                Chance::Nothing => continue,
                Chance::All(lights) => (lights, 1.0),
                Chance::Part(density) => {
                    let pdf = search.sought.pdf_at_infinity(light, direction);
                    (&search.lights, density / (density + pdf))
                }
            };
            let radiance = lights.radiance_at_infinity(light, direction);
            if radiance == [0.0; 3] {
                continue;
            }
            trail.contributions.push(Contribution {
                slot: lights.slot_of(light),
                glint: small && trail.vertex == Vertex::Camera && order <= GRAINS_BEFORE_RANDOM,
                weight: scaled(product(path.throughput, radiance), part),
                ice_length: path.ice_length,
                ice_in_strata: path.ice_in_strata,
            });
        }
    }

    /// What counts of a light that is looked for.
    fn chance(
        &self,
        trail: &Trail,
        (direction, path): (DVec3, &PathResult),
        order: u32,
        small: bool,
    ) -> Chance<'_> {
        match (order, trail.vertex) {
            (0, Vertex::Surface(normal)) => Chance::Part(normal.dot(direction).max(0.0) / PI),
            (0..=GRAINS_BEFORE_RANDOM, _) if !small => Chance::All(&self.search.lights),
            (1, Vertex::Camera) if is_solved(trail, path) => Chance::Nothing,
            (0..=GRAINS_BEFORE_RANDOM, _) => Chance::All(&self.search.wide),
            _ => {
                let Some(last) = trail.last else { return Chance::All(&self.search.lights) };
                let table = match last.from {
                    ArrivalFrom::Air => &self.search.from_air,
                    ArrivalFrom::Ice => &self.search.from_ice,
                };
                Chance::Part(table.density(last.direction.dot(direction)))
            }
        }
    }
}

/// Whether a path that left the first grain did so by a way that was solved.
fn is_solved(trail: &Trail, path: &PathResult) -> bool {
    // A reflection outside is one interface, p chords are p + 1.
    let chords = path.interface_events.saturating_sub(1);
    !trail.through_ice && trail.solved_orders.is_some_and(|solved| chords <= solved)
}
