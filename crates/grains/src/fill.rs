//! Bodies that are filled with snow of a density: a box, the inside of a closed mesh, or what lies under
//! a surface of heights.
//!
//! Space is tiled with a [`PeriodicPack`] whose first tile starts at the origin of the world; a body
//! holds the grains whose centres lie inside. So what is filled depends on the place alone, and bodies
//! that meet, filled with the same settings, hold the pack that one body of both would.

mod solid;
mod surface;
mod tiled;

pub use solid::Solid;
pub use surface::{HeightField, PlanImage};
pub use tiled::TiledFill;

use crate::pack::{PackMethod, PackSettings, PeriodicPack};
use crate::shapes::digest;
use crate::{GrainField, GrainsError, ICE_DENSITY, ShapeMix, Snowfall};
use rayon::prelude::*;
use snowgrain_geometry::{Quantisation, QuantisedGrain};
use snowgrain_math::sampler::{PathKey, numbers};
use snowgrain_math::{Aabb, DVec3};
use std::sync::Arc;

/// What tells the random numbers by which grains stay from others of their places.
const THINNING: u64 = 0xde75_17e5;

/// Most grains of a body: more than any memory holds.
const MOST_GRAINS: f64 = 4e9;

/// What is filled.
#[derive(Clone, Debug)]
pub enum Body {
    /// A box, metres.
    Box(Aabb),
    /// The inside of a closed mesh.
    Solid(Arc<Solid>),
    /// What lies under a surface.
    Heights(Arc<HeightField>),
}

impl Body {
    /// The box around it, metres.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        match self {
            Self::Box(bounds) => *bounds,
            Self::Solid(solid) => solid.bounds(),
            Self::Heights(heights) => heights.bounds(),
        }
    }

    /// Its volume, cubic metres.
    #[must_use]
    pub fn volume(&self) -> f64 {
        match self {
            Self::Box(bounds) => {
                let size = bounds.size();
                size.x * size.y * size.z
            }
            Self::Solid(solid) => solid.volume(),
            Self::Heights(heights) => heights.volume(),
        }
    }

    /// Whether a point, metres, lies inside.
    fn holds(&self, point: DVec3) -> Result<bool, GrainsError> {
        match self {
            Self::Box(bounds) => Ok(point.cmpge(bounds.min).all() && point.cmplt(bounds.max).all()),
            Self::Solid(solid) => solid.holds(point),
            Self::Heights(heights) => Ok(heights.holds(point)),
        }
    }
}

/// A body of snow to make.
#[derive(Clone, Debug)]
pub struct FillSettings {
    /// The snow.
    pub pack: PackSettings,
    /// Where it is.
    pub body: Body,
    /// Where on the plan it is at all: where the picture is at least half white.
    pub mask: Option<Arc<PlanImage>>,
    /// What part of the density of the snow there is over each place of the plan ([`PlanImage::check_parts`]):
    /// each grain stays with that probability.
    pub density_map: Option<Arc<PlanImage>>,
}

/// What became of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FillReport {
    /// Number of grains.
    pub grains: u64,
    /// Density asked for, kg/m^3.
    pub asked: f64,
    /// Density of the pack, kg/m^3.
    pub density: f64,
    /// How it was made.
    pub method: PackMethod,
}

/// Packs made so far, by what was asked.
#[derive(Debug, Default)]
pub(crate) struct KnownPacks(Vec<(PackSettings, Option<ShapeMix>, Arc<PeriodicPack>)>);

impl KnownPacks {
    fn pack(
        &mut self,
        (settings, shapes): (&PackSettings, Option<&ShapeMix>),
        quantum: f64,
    ) -> Result<Arc<PeriodicPack>, GrainsError> {
        let is_it = |known: &&(PackSettings, Option<ShapeMix>, Arc<PeriodicPack>)| {
            known.0 == *settings && known.1.as_ref() == shapes
        };
        if let Some((_, _, pack)) = self.0.iter().find(is_it) {
            return Ok(Arc::clone(pack));
        }
        let pack = Arc::new(match shapes {
            Some(mix) => settings.make_of(mix, quantum)?,
            None => settings.make(quantum)?,
        });
        self.0.push((settings.clone(), shapes.cloned(), Arc::clone(&pack)));
        Ok(pack)
    }
}

impl FillSettings {
    /// Whether the density over a grain's place lets it stay: a function of the seed and the grain.
    fn keeps(&self, grain: QuantisedGrain, at: DVec3) -> bool {
        let Some(map) = &self.density_map else { return true };
        let key = PathKey::new(self.pack.seed, digest(grain), THINNING);
        f64::from(numbers(key, 0)[0]) < map.at(at)
    }

    /// About how many grains it takes, where no mask takes any away and snow is of full density.
    #[must_use]
    pub fn expected_grains(&self) -> f64 {
        let ball = 4.0 / 3.0 * core::f64::consts::PI * self.pack.radii.mean_cube();
        self.pack.density / ICE_DENSITY * self.body.volume() / ball
    }
}

impl Snowfall<'_> {
    /// Fills a body with snow; what lay there before is not moved.
    ///
    /// # Errors
    /// As [`PackSettings::make`]; a mesh that crosses itself; a body that holds no grain, or too many; one
    /// beyond the lattice of quanta.
    pub fn fill(&mut self, settings: &FillSettings) -> Result<FillReport, GrainsError> {
        let quantisation = self.quantisation();
        let (packs, shapes) = self.known_packs();
        let pack = packs.pack((&settings.pack, shapes), quantisation.quantum())?;
        let grains = pack.within(&quantisation, settings)?;
        let report = FillReport {
            grains: grains.len() as u64,
            asked: settings.pack.density,
            density: ICE_DENSITY * pack.solid_fraction,
            method: pack.method,
        };
        self.place(&GrainField::new(quantisation, grains))?;
        Ok(report)
    }
}

impl PeriodicPack {
    /// The grains of this pack, repeated from the origin of the world, whose centres a body holds.
    fn within(
        &self,
        quantisation: &Quantisation,
        settings: &FillSettings,
    ) -> Result<Vec<QuantisedGrain>, GrainsError> {
        let bounds = settings.body.bounds();
        let (origin, quantum) = (quantisation.origin(), quantisation.quantum());
        let first = (-origin / quantum).round();
        let period = DVec3::from_array(self.period.map(|edge| edge as f64));
        let low = ((bounds.min - origin) / quantum - first) / period;
        let high = ((bounds.max - origin) / quantum - first) / period;
        let reach = f64::from(Quantisation::MAX_COORDINATE);
        let ends = [bounds.min, bounds.max].map(|end| ((end - origin) / quantum).abs());
        if bounds.is_empty() || !ends.iter().all(|end| end.cmple(DVec3::splat(reach)).all()) {
            let reason =
                format!("is out of reach: snow of such grains reaches {} m", reach * quantum);
            return Err(GrainsError::setting("body", reason));
        }
        let (low, high) = (low.floor(), high.floor());
        let counts = high - low + 1.0;
        let tiles = counts.x * counts.y * counts.z;
        let expected = settings.expected_grains();
        if expected > MOST_GRAINS || tiles > f64::from(u32::MAX) {
            let reason = format!("would hold {expected:.1e} grains; use larger grains");
            return Err(GrainsError::setting("body", reason));
        }
        let grains = self.field.grains();
        let of_tile = |tile: u64| {
            let (x, rest) = (tile % counts.x as u64, tile / counts.x as u64);
            let (y, z) = (rest % counts.y as u64, rest / counts.y as u64);
            let place = low + DVec3::new(x as f64, y as f64, z as f64);
            let corner = (first + place * period).to_array().map(|c| c as i64);
            let mut held = Vec::new();
            for grain in &*grains {
                let center = [0, 1, 2].map(|a| corner[a] + i64::from(grain.center[a]));
                let at = origin + DVec3::from_array(center.map(|c| c as f64)) * quantum;
                let within = at.cmpge(bounds.min).all() && at.cmple(bounds.max).all();
                if within
                    && settings.mask.as_ref().is_none_or(|mask| mask.at(at) >= 0.5)
                    && settings.body.holds(at)?
                {
                    let placed = QuantisedGrain { center: center.map(|c| c as i32), ..*grain };
                    held.extend(settings.keeps(placed, at).then_some(placed));
                }
            }
            Ok(held)
        };
        let held: Vec<Vec<QuantisedGrain>> =
            (0..tiles as u64).into_par_iter().map(of_tile).collect::<Result<_, GrainsError>>()?;
        let held = held.concat();
        if held.is_empty() {
            let reason =
                "holds no grain: it is smaller than a few of them, or lies beside its pictures";
            return Err(GrainsError::setting("body", reason));
        }
        Ok(held)
    }
}

#[cfg(test)]
mod tests;
