//! The light on the surface of snow, at points, before a picture.

use super::density::is_within_solid;
use super::dipole::{Diffusion, Dipole, LitPiece};
use super::skin::Piece;
use super::walk::MediumPath;
use super::{Inside, Medium};
use crate::surface::Place;
use crate::transport::{Contribution, FirstHit};
use crate::world::World;
use core::f64::consts::PI;
use rayon::prelude::*;
use snowgrain_math::sampler::PathKey;
use snowgrain_math::{Ray, frame, trig};
use snowgrain_optics::{Dielectric, IceColour, sphere};

/// Paths by which the light on a piece of the surface is found.
const PATHS: u64 = 128;
/// What tells their random numbers from those of a picture.
const STREAM: u64 = 0x1aad_1a7e << 32;
/// How far outside of the surface they begin, cells.
const OUTSIDE: f64 = 0.25;
/// Length of ice, metres, by which is told how much of each channel it absorbs.
const LENGTH: f64 = 0.01;

impl Medium {
    /// Finds the light on the snow's surface, on the threads of the current pool, and what diffuses from there through ice that
    /// colours light so. `seed` is that of the picture.
    pub(crate) fn glowing(
        mut self,
        (world, places): (&World, &[Place]),
        ice: &IceColour,
        seed: u64,
    ) -> Self {
        let Inside::Skin(level, _) = self.inside else { return self };
        let mut pieces = self.density.surface(level);
        pieces.retain(|piece| !is_within_solid(piece.position, &world.surfaces, places));
        let light = |(index, piece): (usize, &Piece)| LitPiece {
            piece: *piece,
            irradiance: self.irradiance(world, piece, (seed, index as u64)),
        };
        let lit: Vec<LitPiece> = pieces.par_iter().enumerate().map(light).collect();
        let slots = self.lights.slots().len();
        let dipole = Dipole::new(self.diffusion(world, ice), slots, lit);
        self.inside = Inside::Skin(level, Some(dipole));
        self
    }

    /// Irradiance of each slot on a piece.
    fn irradiance(&self, world: &World, piece: &Piece, (seed, index): (u64, u64)) -> Vec<[f64; 3]> {
        let Piece { position, normal, .. } = *piece;
        let start = position + normal * (OUTSIDE * self.density.shortest_edge());
        let mut sums = vec![[0.0; 3]; self.lights.slots().len()];
        let mut found: Vec<Contribution> = Vec::new();
        for number in 0..PATHS {
            found.clear();
            let key = PathKey::new(seed ^ STREAM, index, number);
            let mut path = MediumPath::new((world, self), key, 0, &mut found);
            // Nothing of this is seen by the camera.
            let (albedo, is_shadow_catcher) = ([1.0; 3], false);
            path.first_hit = Some(FirstHit { position, normal, albedo, is_shadow_catcher });
            path.look_from_skin(start, normal);
            let [u, v, _] = path.random();
            let end = path.follow(Ray::new(start, frame::cosine_hemisphere(normal, [u, v])));
            path.light_at_end(&end);
            for light in &found {
                let sum = &mut sums[light.slot];
                sum.iter_mut().zip(light.weight).for_each(|(sum, w)| *sum += f64::from(w));
            }
        }
        sums.iter().map(|sum| sum.map(|sum| sum * PI / PATHS as f64)).collect()
    }

    /// How the snow diffuses light of each channel.
    fn diffusion(&self, world: &World, ice: &IceColour) -> [Diffusion; 3] {
        let (medium, extinction) = (Dielectric { eta: world.eta }, world.grid.extinction());
        let reduced = extinction * (1.0 - sphere::asymmetry(medium));
        let enhancement = sphere::absorption_enhancement(medium);
        // Volume by area: 4 r / 3.
        let solid = extinction * self.density.mean().radius * (4.0 / 3.0);
        let [clear, behind] = [0.0, LENGTH].map(|length| ice.apply([1.0; 3], length));
        std::array::from_fn(|channel| {
            let left = f64::from(behind[channel] / clear[channel]).clamp(1e-6, 1.0);
            Diffusion::new(reduced, -trig::ln(left) / LENGTH * enhancement * solid)
        })
    }
}
