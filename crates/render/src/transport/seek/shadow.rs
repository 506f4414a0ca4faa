//! Shadow rays, and whether light could have come to where their ways begin.
//!
//! A way through a grain that was found for a random place begins at some point of the grain. Where light
//! arrived from another grain, that point must see a grain too, not the open sky, from which the path did
//! not come; where it arrived from the camera, the open. The way is therefore dropped where its beginning
//! is of another kind than that of the path ([`Origin`]), and weighted by one over the part of the grain's
//! disc that is of the kind: on average the number of random places until one is (see
//! [`super::first_grain`]): where light goes out most easily none came in. Light that came through ice is
//! let be: to ask for a beginning within another grain doubles the variance. So is that of grains of other shapes
//! than spheres, whose ways begin nowhere in particular, and that of more than five grains.

use super::gains::Class;
use super::second_grain::PairSolution;
use super::{Seeker, Trail};
use crate::transport::Contribution;
use core::f64::consts::TAU;
use snowgrain_accel::{GridPosition, Passage, Probe, ProbeAnswer};
use snowgrain_math::sampler::{PathKey, numbers};
use snowgrain_math::{DVec3, Ray, frame, trig};

/// What tells the random numbers of places that are tried from others of a search.
const PLACES: u32 = 0x0b1a_ce55;

/// What a shadow ray brings if it is clear.
pub(super) struct Wanted {
    pub(super) lane: usize,
    pub(super) brings: Brings,
    /// Where it starts, how far surfaces may hide the light, and the object that shines.
    pub(super) ray: Ray,
    pub(super) distance: f64,
    pub(super) lamp: Option<u32>,
    pub(super) condition: Condition,
}

/// What the way to where a shadow ray starts must fulfil.
pub(super) enum Condition {
    /// Nothing more.
    Nothing,
    /// The way through a grain begins where light could have come from.
    Begins(Beginning),
    /// The way through two grains is open, and the light is divided by the probability of finding it.
    Connects(Box<PairSolution>),
}

/// What a clear shadow ray brings.
pub(super) enum Brings {
    Light(Contribution),
    /// A count.
    Count(Class),
}

/// Where a way through a grain begins.
#[derive(Clone, Copy)]
pub(super) struct Beginning {
    pub(super) grain: (GridPosition, f32),
    /// Direction in which light arrives there, and the outward normal.
    pub(super) direction: DVec3,
    pub(super) normal: DVec3,
    /// Where the light of the path came from.
    pub(super) origin: Origin,
    /// Random numbers of places that are tried.
    pub(super) key: PathKey,
    pub(super) event: u32,
}

/// What is seen from a point of a grain against the direction of light that arrives there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Origin {
    /// Nothing.
    Open,
    /// Another grain or a surface.
    Matter,
    /// The point lies within another grain: no light arrives there from air.
    Covered,
}

impl Beginning {
    /// The outward normal at a random place of the disc, number `trial`.
    fn random_normal(&self, trial: u32) -> DVec3 {
        let key = PathKey { lo: self.key.lo ^ PLACES, ..self.key };
        let [u, v, _] = numbers(key, self.event.wrapping_add(trial.wrapping_mul(0x9e37_79b9)));
        let (s, t) = frame::tangents(self.direction);
        let (sin, cos) = trig::sin_cos(TAU * f64::from(v));
        let (across, along) = (f64::from(u).sqrt(), (1.0 - f64::from(u)).sqrt());
        (s * (across * cos) + t * (across * sin) - self.direction * along).normalize()
    }
}

impl Seeker<'_> {
    /// Follows the shadow rays that wait, and books what those bring that are clear.
    pub(super) fn follow_shadow_rays(&mut self, trails: &mut [Trail]) {
        let passages = self.clear_rays();
        self.rays.clear();
        let wanted = std::mem::take(&mut self.wanted);
        let mut weights: Vec<f32> =
            passages.iter().map(|rays| if rays.is_some() { 1.0 } else { 0.0 }).collect();
        self.weigh_beginnings(&wanted, &mut weights);
        self.weigh_pairs(&wanted, &mut weights);
        for ((wanted, weight), passage) in wanted.into_iter().zip(weights).zip(passages) {
            let Some(passage) = passage.filter(|_| weight > 0.0) else { continue };
            match (wanted.brings, &mut self.tally) {
                (Brings::Light(light), _) => {
                    let light = self.behind(light, weight, &passage);
                    trails[wanted.lane].contributions.push(light);
                }
                (Brings::Count(class), Some(tally)) => {
                    tally.found(&class, f64::from(weight) * f64::from(passage.transmittance));
                }
                (Brings::Count(_), None) => {}
            }
        }
    }

    /// Light so many times, after what its shadow ray went straight through.
    fn behind(&self, mut light: Contribution, weight: f32, passage: &Passage) -> Contribution {
        let factor = weight * passage.transmittance;
        light.weight = light.weight.map(|channel| channel * factor);
        if passage.ice_length > 0.0 {
            let metres = |quanta: f32| f64::from(quanta) * self.world.grid.quantum();
            light.ice_length += metres(passage.ice_length);
            for (length, more) in light.ice_in_strata.iter_mut().zip(passage.ice_in_strata) {
                *length += metres(more);
            }
        }
        light
    }

    /// How those of the shadow rays that wait get through that nothing is in the way of.
    fn clear_rays(&mut self) -> Vec<Option<Passage>> {
        let mut clear = vec![None; self.rays.len()];
        self.probes.follow(&self.rays, |index, answer| {
            clear[index] = match answer {
                ProbeAnswer::Clear => Some(Passage { transmittance: 1.0, ..Passage::default() }),
                ProbeAnswer::Through(passage) => Some(passage),
                ProbeAnswer::Met { .. } | ProbeAnswer::Covered => None,
            };
        });
        let surfaces = &self.world.surfaces;
        if surfaces.is_empty() {
            return clear;
        }
        for (clear, wanted) in clear.iter_mut().zip(&self.wanted) {
            if clear.is_some() {
                let hit = surfaces.intersect(&wanted.ray, wanted.distance, None);
                if hit.is_some_and(|hit| wanted.lamp != Some(hit.id.object)) {
                    *clear = None;
                }
            }
        }
        clear
    }

    /// Sets the weights of those whose way begins where light could not have come from to 0, and divides
    /// the others by the part of the disc from which it could.
    fn weigh_beginnings(&mut self, wanted: &[Wanted], weights: &mut [f32]) {
        let beginnings = |weights: &[f32]| -> Vec<(usize, Beginning)> {
            let some = wanted.iter().zip(weights).enumerate();
            some.filter(|(_, (_, weight))| **weight > 0.0)
                .filter_map(|(index, (wanted, _))| match wanted.condition {
                    Condition::Begins(beginning) => Some((index, beginning)),
                    Condition::Nothing | Condition::Connects(_) => None,
                })
                .collect()
        };
        let mut open = beginnings(weights);
        for (&(index, _), fits) in open.iter().zip(self.fit(&open, |begins| begins.normal)) {
            if !fits {
                weights[index] = 0.0;
            }
        }
        open = beginnings(weights);
        let mut trial = 0;
        while !open.is_empty() {
            trial += 1;
            let fit = self.fit(&open, |begins| begins.random_normal(trial));
            let mut fit = fit.into_iter();
            open.retain(|&(index, _)| {
                let fits = fit.next() == Some(true);
                if fits {
                    weights[index] = trial as f32;
                }
                !fits
            });
        }
    }

    /// Whether light could have come from where that of each path came to the places with these normals.
    fn fit(
        &mut self,
        beginnings: &[(usize, Beginning)],
        normal: impl Fn(&Beginning) -> DVec3,
    ) -> Vec<bool> {
        let grid = &self.world.grid;
        let mut seen = vec![Origin::Open; beginnings.len()];
        let (mut rays, mut of_ray) = (Vec::new(), Vec::new());
        for (index, (_, begins)) in beginnings.iter().enumerate() {
            let back = -begins.direction;
            if let Some(ray) = Probe::leaving(grid, begins.grain, normal(begins), back, f32::MAX) {
                rays.push(ray);
                of_ray.push(index);
            }
        }
        self.probes.follow(&rays, |ray, answer| {
            seen[of_ray[ray]] = match answer {
                ProbeAnswer::Clear | ProbeAnswer::Through(_) => Origin::Open,
                ProbeAnswer::Met { .. } => Origin::Matter,
                ProbeAnswer::Covered => Origin::Covered,
            };
        });
        let surfaces = &self.world.surfaces;
        if !surfaces.is_empty() {
            for (ray, &index) in rays.iter().zip(&of_ray) {
                let ray = Ray::new(grid.world(ray.start), -beginnings[index].1.direction);
                let open = seen[index] == Origin::Open;
                if open && surfaces.intersect(&ray, f64::INFINITY, None).is_some() {
                    seen[index] = Origin::Matter;
                }
            }
        }
        seen.iter().zip(beginnings).map(|(seen, (_, begins))| *seen == begins.origin).collect()
    }
}
