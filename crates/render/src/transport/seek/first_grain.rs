//! The first grain that a camera sees: its images of small lights, solved exactly.
//!
//! From one place of the lens light runs to the grain through one point (or all along one direction),
//! so that its ways through the sphere into a light's direction are known in closed form
//! ([`snowgrain_optics::Connector`]), and with each the place in the image where the light is seen. It
//! counts if that place is in the pixel and both ends are visible among the real grains.
//!
//! A path comes here because it met the grain, with the probability P with which rays do from a window
//! around its place of the image. The light is divided by P, whose inverse is, on average, the number of
//! rays from the window until one meets the grain again (Zeltner, Georgiev and Jakob 2020, "Specular
//! Manifold Sampling for Rendering High-Frequency Caustics and Glints", section 4.2): no cap, no bias.
//! The window is a pixel, or of the size of the grain where that is less, so that few grains share it; it
//! is placed at random and goes on at the other edge of the pixel.

use super::grains::turned;
use super::second_grain::{FirstGrain, solved_orders};
use super::shadow::{Brings, Condition};
use super::window::Window;
use super::{PathState, Seeker, Trail, View, product, scaled, search_key};
use crate::camera::Bundle;
use crate::light::LightRole;
use crate::transport::Contribution;
use snowgrain_accel::{GrainVisit, Probe, ProbeAnswer};
use snowgrain_math::sampler::{PathKey, numbers};
use snowgrain_math::{DVec3, trig};

/// Rays of a window that are followed at once.
const TRIALS: usize = 8;
/// What tells the random numbers of trials from others of a search.
const TRIAL: u32 = 0x7214_15ee;
/// One path in so many looks for the images of suns, for all: they hardly vary, and take as long to find as
/// several grains to cross.
const PATHS_PER_SEARCH: f64 = 16.0;
/// Least edge of a window, pixels.
const LEAST_WINDOW: f64 = 1.0 / 64.0;

/// The grain, in metres.
struct Grain {
    center: DVec3,
    radius: f64,
}

impl Seeker<'_> {
    /// Looks for the images of all small lights in the first grain of a path.
    pub(super) fn at_first_grain(
        &mut self,
        visit: &GrainVisit,
        trail: &mut Trail,
        state: &PathState,
    ) {
        let Some(view) = trail.view.filter(|_| !visit.meets_surface) else { return };
        let most = solved_orders(visit);
        trail.solved_orders = Some(most);
        let grid = &self.world.grid;
        let grain = Grain {
            center: grid.world(visit.center),
            radius: f64::from(visit.radius) * grid.quantum(),
        };
        let edge = self.window_edge(grain.center, grain.radius);
        trail.first_grain = Some(FirstGrain::new(visit));
        self.behind_reflection(visit, &view, state);
        let key = search_key(state.key);
        let [x, y, chosen] = numbers(key, 2 * visit.event).map(f64::from);
        if chosen * PATHS_PER_SEARCH >= 1.0 {
            return;
        }
        let window = Window::around(view.image, edge, [x, y]);
        for light in 0..self.search.lights.count() {
            if self.search.roles[light] != LightRole::Sun {
                continue;
            }
            let event = 2 * visit.event + 1;
            // Lights share no number: each has a key of its own.
            let key = PathKey { lo: key.lo.wrapping_add(light as u32), ..key };
            let random = numbers(key, event).map(f64::from);
            let sample = self.search.lights.sample_light(light, grain.center, random);
            let Some(sample) = sample else { continue };
            let (axis, ratio) = match view.bundle {
                Bundle::Through(point) => {
                    let to_center = grain.center - point;
                    let distance = to_center.length();
                    if distance <= grain.radius {
                        return;
                    }
                    (to_center / distance, grain.radius / distance)
                }
                Bundle::Along(direction) => (direction, 0.0),
            };
            let cosine = axis.dot(sample.direction).clamp(-1.0, 1.0);
            let mut connections = Vec::new();
            self.search.connector.connect(ratio, trig::acos(cosine), |connection| {
                if connection.order <= most {
                    connections.push(connection);
                }
            });
            for connection in connections {
                let at = |angle: f64| turned(axis, sample.direction, cosine, angle);
                let solution = Solution { entry: at(connection.entry), exit: at(connection.exit) };
                let Some(seen) = self.seen_at(&grain, &view, &window, &solution) else { continue };
                if !self.meets([seen].into_iter(), &view, &grain)[0] {
                    continue;
                }
                let trials = self.trials(&grain, &view, &window, key);
                let per_ray = match view.bundle {
                    Bundle::Through(_) => ratio * ratio,
                    Bundle::Along(_) => grain.radius * grain.radius,
                };
                let ray = self.camera.ray(seen[0], seen[1], view.lens);
                let density = self.camera.pixel_density(ray.direction);
                let weight = connection.energy
                    * connection.area
                    * per_ray
                    * density
                    * trials
                    * PATHS_PER_SEARCH
                    / (edge * edge * sample.pdf);
                let length = connection.length * grain.radius;
                let mut ice_in_strata = [0.0; snowgrain_accel::STRATA];
                if let Some(stratum) = usize::from(visit.stratum).checked_sub(1) {
                    ice_in_strata[stratum] = length;
                }
                let brings = Brings::Light(Contribution {
                    slot: sample.slot,
                    glint: true,
                    event: visit.event,
                    weight: scaled(product(state.throughput, sample.radiance), weight),
                    ice_length: length,
                    ice_in_strata,
                });
                let towards = (sample.direction, sample.distance, None);
                self.want(
                    visit,
                    (solution.exit, visit.radius),
                    towards,
                    brings,
                    Condition::Nothing,
                );
            }
        }
    }

    /// Edge of a window for a grain, pixels: as large as its radius is seen, or a pixel.
    pub(super) fn window_edge(&self, center: DVec3, radius: f64) -> f64 {
        let footprint = self.camera.pixel_footprint(self.camera.depth(center));
        (radius / footprint).clamp(LEAST_WINDOW, 1.0)
    }

    /// Where in the image the light of a solution is seen, if that is in the window.
    fn seen_at(
        &self,
        grain: &Grain,
        view: &View,
        window: &Window,
        solution: &Solution,
    ) -> Option<[f64; 2]> {
        let entry = grain.center + solution.entry * grain.radius;
        let (x, y) = self.camera.project(entry, view.lens)?;
        window.contains([x, y]).then_some([x, y])
    }

    /// How many rays of the window it takes until one meets the grain.
    fn trials(&mut self, grain: &Grain, view: &View, window: &Window, key: PathKey) -> f64 {
        let key = PathKey { lo: key.lo ^ TRIAL, ..key };
        for round in 0u32.. {
            let first = round * TRIALS as u32;
            let places = (first..first + TRIALS as u32).map(|trial| {
                let [x, y, _] = numbers(key, trial).map(f64::from);
                window.at([x, y])
            });
            let met = self.meets(places, view, grain);
            if let Some(index) = met.iter().position(|&met| met) {
                return f64::from(first) + index as f64 + 1.0;
            }
        }
        unreachable!("the grain was met once")
    }

    /// Whether the grain is what the rays through places of the image meet first.
    fn meets(
        &mut self,
        places: impl Iterator<Item = [f64; 2]>,
        view: &View,
        grain: &Grain,
    ) -> [bool; TRIALS] {
        let grid = &self.world.grid;
        let mut met = [false; TRIALS];
        let (mut rays, mut of_ray) = (Vec::with_capacity(TRIALS), Vec::with_capacity(TRIALS));
        for (index, [x, y]) in places.enumerate() {
            let ray = self.camera.ray(x, y, view.lens);
            let Some((t, start)) = grid.enter(&ray) else { continue };
            rays.push(Probe::through_air(start, ray.direction, f32::MAX));
            of_ray.push((index, ray, t));
        }
        let surfaces = &self.world.surfaces;
        let quantum = grid.quantum();
        self.probes.follow(&rays, |ray, answer| {
            let ProbeAnswer::Met { distance, grain: found } = answer else { return };
            let (index, ray, t) = of_ray[ray];
            let is_it =
                (grid.world(found.center) - grain.center).length_squared() < quantum * quantum;
            let reach = t + f64::from(distance) * quantum;
            met[index] =
                is_it && (surfaces.is_empty() || surfaces.intersect(&ray, reach, None).is_none());
        });
        met
    }
}

/// A connection in the world.
struct Solution {
    /// Outward normals of the grain where light from the camera enters and leaves.
    entry: DVec3,
    exit: DVec3,
}
