//! Light that a path meets by chance while light is looked for as well.

use super::gains::Class;
use super::{GRAINS_BEFORE_SUNS, Seeker, Trail, Vertex, product, scaled};
use crate::light::{LightRole, Lights};
use crate::transport::{Contribution, PathResult};
use snowgrain_math::DVec3;

/// Where a path met light.
#[derive(Clone, Copy, Debug)]
pub(in super::super) enum Met {
    /// At infinity, in this direction.
    Infinity(DVec3),
    /// On the surface of a light, which it reached in this direction.
    Surface {
        /// Index of the light.
        light: usize,
        position: DVec3,
        normal: DVec3,
        direction: DVec3,
    },
}

/// What counts of a light that is met by chance.
#[derive(Clone, Copy)]
enum Chance<'a> {
    /// Nothing: it is found otherwise.
    Nothing,
    /// Its light as these lights have it.
    All(&'a Lights),
    /// The part that the balance heuristic leaves beside the search among these lights from this point,
    /// where chance has this density (1/sr).
    Beside(&'a Lights, DVec3, f64),
}

impl Seeker<'_> {
    /// Books the light that a path meets where it ends; that which the camera sees directly at infinity
    /// is not here.
    pub(in super::super) fn at_end(&mut self, trail: &mut Trail, met: Met, path: &PathResult) {
        let direction = match met {
            Met::Infinity(direction) | Met::Surface { direction, .. } => direction,
        };
        trail.turned = trail.turned_before(direction);
        // Grains that let it straight through do not count.
        let order = trail.turned.map_or(0, |turned| turned.order);
        if let Some(tally) = &mut self.tally {
            if let (Met::Infinity(direction), Some(turned)) = (met, trail.turned) {
                let ways = [turned.direction, direction];
                tally.escaped(&Class::new((turned.from, order), trail.seen_along, ways));
            }
            return;
        }
        match met {
            Met::Infinity(_) if path.grain_visits == 0 && trail.vertex == Vertex::Camera => {}
            Met::Infinity(_) => {
                for light in 0..self.search.lights.count() {
                    self.book(trail, light, met, (path, order));
                }
            }
            Met::Surface { light, .. } => self.book(trail, light, met, (path, order)),
        }
    }

    /// Books what a path meets of one light.
    fn book(&self, trail: &mut Trail, light: usize, met: Met, (path, order): (&PathResult, u32)) {
        let search = self.search;
        let direction = match met {
            Met::Infinity(direction) | Met::Surface { direction, .. } => direction,
        };
        let chance = if search.is_sought[light] {
            self.chance(trail, light, direction, (path, order))
        } else {
            Chance::All(&search.lights)
        };
        let (lights, part) = match chance {
            Chance::Nothing => return,
            Chance::All(lights) => (lights, 1.0),
            Chance::Beside(sought, from, density) => {
                let pdf = match met {
                    Met::Infinity(_) => sought.pdf_at_infinity(light, direction),
                    Met::Surface { position, normal, .. } => {
                        sought.pdf_on_surface(light, from, position, normal)
                    }
                };
                (&search.lights, density / (density + pdf))
            }
        };
        let radiance = match met {
            Met::Infinity(_) => lights.radiance_at_infinity(light, direction),
            Met::Surface { .. } => lights.emission(light),
        };
        if radiance == [0.0; 3] || part == 0.0 {
            return;
        }
        let sun = search.roles[light] == LightRole::Sun;
        trail.contributions.push(Contribution {
            slot: lights.slot_of(light),
            glint: sun && trail.vertex == Vertex::Camera && order <= GRAINS_BEFORE_SUNS,
            event: u32::MAX,
            weight: scaled(product(path.throughput, radiance), part),
            ice_length: path.ice_length,
            ice_in_strata: path.ice_in_strata,
        });
    }

    /// What counts of a light, by its index, that is looked for.
    fn chance(
        &self,
        trail: &Trail,
        light: usize,
        direction: DVec3,
        (path, order): (&PathResult, u32),
    ) -> Chance<'_> {
        let search = self.search;
        let role = search.roles[light];
        match (order, trail.vertex, trail.turned) {
            (0, Vertex::Surface(position, scatterer), _) => {
                Chance::Beside(&search.late, position, scatterer.density(direction))
            }
            (0, Vertex::Deep(true), _) if search.lights.is_small(light) => Chance::Nothing,
            (0, _, _) => Chance::All(&search.lights),
            (1..=GRAINS_BEFORE_SUNS, _, _) if role == LightRole::Sun => {
                let first = order == 1 && trail.vertex == Vertex::Camera;
                let shaped = trail.turned.is_some_and(|turned| turned.prototype.is_some());
                if is_solved(trail, (path, order)) {
                    Chance::Nothing
                } else if first && shaped {
                    // Chance finds what a face mirrors as often as it finds the face.
                    Chance::All(&search.lights)
                } else if is_in_spheres(trail, order) {
                    Chance::All(&search.wide_in_air)
                } else {
                    Chance::All(&search.wide)
                }
            }
            (_, _, None) => Chance::All(&search.lights),
            (_, _, Some(turned)) => {
                let table = search.table(turned.from, turned.prototype);
                let density = table.density(turned.direction.dot(direction));
                Chance::Beside(search.sought_at(order), turned.center, density)
            }
        }
    }
}

/// Whether all grains up to this order from the camera are spheres that the path met in air, some of whose orders are
/// solved.
fn is_in_spheres(trail: &Trail, order: u32) -> bool {
    let is_known =
        if order == 1 { trail.solved_orders.is_some() } else { trail.second_grain.is_some() };
    is_known && trail.vertex == Vertex::Camera && !trail.through_ice
}

/// Whether the way by which a path left the first grain, or the second, is solved.
fn is_solved(trail: &Trail, (path, order): (&PathResult, u32)) -> bool {
    if trail.vertex != Vertex::Camera || trail.through_ice {
        return false;
    }
    // A reflection outside is one interface, p chords are p + 1; a grain that lets light straight through has two.
    let straight = 2 * path.grain_visits.saturating_sub(trail.visits_before + order);
    let known = match (order, &trail.second_grain) {
        (1, _) => trail.solved_orders.map(|most| (0, most)),
        (_, second) => second.map(|second| (second.chords_before + 1, second.most)),
    };
    known.is_some_and(|(before, most)| {
        path.interface_events.saturating_sub(before + straight + 1) <= most
    })
}
