//! Packs that repeat along all axes, of any density.
//!
//! Up to 520 kg/m^3 a pack is a slab from the middle of a snowfall of that density (see
//! [`Settling`]) whose top is laid on the image of its bottom; what overlaps there is
//! pushed apart. Denser ones start from grains that rolled, in a box that is made smaller: overlaps
//! are pushed apart up to a solid fraction of .62, which random packs of equal spheres reach without
//! order; beyond that the box shrinks further and neighbours overlap, as grains that sintered do.

mod attach;
mod relax;
mod vary;

use crate::deposit::aim::{Aim, MOST_FALLS};
use crate::measures::union_solid_fraction_of_pack;
use crate::{
    Amount, DepositRule, DepositSettings, GrainField, GrainsError, ICE_DENSITY, Radii, Settling,
    ShapeMix, Snowfall,
};
use core::f64::consts::PI;
use relax::Spheres;
use snowgrain_accel::tile_divisor;
use snowgrain_geometry::{Quantisation, QuantisedGrain};
use snowgrain_math::{DVec3, trig};
use std::fmt;
pub use vary::VARIANTS;

/// Density up to which snow falls as it is, kg/m^3: rolling reaches it at all sizes.
const MOST_FALLEN: f64 = 520.0;
/// Solid fraction up to which overlaps are pushed apart.
const MOST_COMPACTED: f64 = 0.62;
/// Densities that a pack can have, kg/m^3.
pub const PACK_DENSITIES: [f64; 2] = [20.0, 750.0];
/// Grains of a pack, about.
const GRAINS: f64 = 30_000.0;
/// Of snow lighter than this, kg/m^3, there are more grains, since its aggregates must be many, and more depth
/// is left below and above, in mean radii.
const LIGHT: f64 = 140.0;
const GRAINS_OF_LIGHT: f64 = 100_000.0;
const MARGIN_OF_LIGHT: f64 = 80.0;
/// Least period, in largest radii.
const LEAST_PERIOD: f64 = 24.0;
/// Depth left below and above the slab, in mean radii: where snow feels floor or sky.
const MARGIN: f64 = 24.0;
/// Depth, in largest radii, in which grains move at either end of a slab, so that its ends fit.
const SEAM: f64 = 8.0;
/// Quanta between grains that touch: those that fell were rounded before.
const TOUCH: f64 = 1.9;
/// Gap, quanta, that is left between grains: rounding them to whole quanta takes as much.
const GAP: f64 = 1.0;
/// Overlap, quanta, that the search may leave.
const TOLERANCE: f64 = 0.3;

/// Points at which packs of shapes are measured, and how far their density may be off, as a logarithm.
const SHAPED_POINTS: u32 = 400_000;
const SHAPED_TOLERANCE: f64 = 0.02;

/// A pack to make.
#[derive(Clone, Debug, PartialEq)]
pub struct PackSettings {
    /// Sizes of the grains.
    pub radii: Radii,
    /// Density, kg/m^3, union of the ice.
    pub density: f64,
    /// Seed.
    pub seed: u64,
}

/// How a pack was made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PackMethod {
    /// A slab of a snowfall.
    Fallen(Settling),
    /// Grains that rolled, pressed together and pushed apart.
    Compacted,
    /// The same, with overlaps.
    Sintered {
        /// Distance of neighbours that touched, by the sum of their radii.
        distance: f64,
    },
}

impl fmt::Display for PackMethod {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Fallen(settling) => write!(f, "{settling}"),
            Self::Compacted => write!(f, "grains that rolled, pressed together without overlap"),
            Self::Sintered { distance } => write!(
                f,
                "grains pressed together and sintered: neighbours overlap by {:.1} % of the radius",
                200.0 * (1.0 - distance)
            ),
        }
    }
}

/// A pack that repeats along x, y and z.
#[derive(Clone, Debug)]
pub struct PeriodicPack {
    /// Grains whose centres lie in one period from the origin of the quanta.
    pub field: GrainField,
    /// Periods along x, y and z, quanta.
    pub period: [i64; 3],
    /// Solid fraction, union of the ice.
    pub solid_fraction: f64,
    /// How it was made.
    pub method: PackMethod,
}

impl PackSettings {
    /// # Errors
    /// Sizes without meaning; a density that no pack has, with the range of those that they can have.
    pub fn check(&self) -> Result<(), GrainsError> {
        self.radii.check()?;
        let [low, high] = PACK_DENSITIES;
        if !(low..=high).contains(&self.density) {
            let reason = format!(
                "{} kg/m3 is out of reach: packs have {low:.0} to {high:.0} kg/m3",
                self.density
            );
            return Err(GrainsError::setting("density", reason));
        }
        Ok(())
    }

    /// Makes the pack on quanta of `quantum` metres: a pure function of these settings and it.
    ///
    /// # Errors
    /// As [`Self::check`]; radii that do not fit the quanta.
    pub fn make(&self, quantum: f64) -> Result<PeriodicPack, GrainsError> {
        self.check()?;
        let wanted = self.density / ICE_DENSITY;
        let fell = self.density <= MOST_FALLEN;
        let (mut spheres, settling) =
            if fell { self.slab_of_density(quantum)? } else { self.slab(self.density, quantum)? };
        let moves = if fell {
            // The top is drawn down to, or up from, the image of the bottom; the rest is as it fell.
            let height = spheres.period.y;
            spheres.widen_plan();
            spheres.period.y = spheres.whole(height * spheres.nominal() / wanted);
            let zone = SEAM * self.radii.largest() / quantum;
            let at_seam = |center: &DVec3| center.y < zone || center.y > height - zone;
            spheres.centers.iter().map(at_seam).collect()
        } else {
            let pressed = wanted.min(MOST_COMPACTED);
            spheres.scale(trig::cbrt(spheres.nominal() / pressed));
            vec![true; spheres.centers.len()]
        };
        spheres.radii.iter_mut().for_each(|radius| *radius += 0.5 * GAP);
        let left = spheres.relax(&moves, TOLERANCE);
        spheres.attach(TOUCH, 0);
        spheres.radii.iter_mut().for_each(|radius| *radius -= 0.5 * GAP);
        if left > 2.0 * GAP {
            let reason = format!("{} kg/m3 is not reached without overlap", self.density);
            return Err(GrainsError::setting("density", reason));
        }
        let method = if wanted > MOST_COMPACTED {
            PackMethod::Sintered { distance: spheres.sinter(wanted) }
        } else if fell {
            PackMethod::Fallen(settling)
        } else {
            PackMethod::Compacted
        };
        Ok(spheres.rounded(quantum, method))
    }

    /// Makes the pack whose grains, as the shapes that they are, have the density: by packs of spheres of equal volume,
    /// up to [`MOST_FALLS`] of them, as corners that reach into each other take room from the ice. The grains of the pack
    /// are those spheres still.
    ///
    /// # Errors
    /// As [`Self::make`]; a density that these shapes do not reach.
    pub(crate) fn make_of(
        &self,
        mix: &ShapeMix,
        quantum: f64,
    ) -> Result<PeriodicPack, GrainsError> {
        let mut aim = Aim::at(self.density);
        let mut best: Option<PeriodicPack> = None;
        for _ in 0..MOST_FALLS {
            let aimed = Self { density: aim.density(), ..self.clone() };
            let mut pack = match aimed.make(quantum) {
                Ok(pack) => pack,
                // What would make up for it is out of reach.
                Err(error) if best.is_none() => return Err(error),
                Err(_) => break,
            };
            let shaped = mix.drawn(pack.field.clone());
            let union =
                union_solid_fraction_of_pack(&shaped, pack.period, SHAPED_POINTS, self.seed);
            pack.solid_fraction = union.mean;
            let density = ICE_DENSITY * union.mean;
            if best
                .as_ref()
                .is_none_or(|best| aim.miss(density) < aim.miss(ICE_DENSITY * best.solid_fraction))
            {
                best = Some(pack);
            }
            if aim.is_met_by(density) {
                break;
            }
            aim.correct(density);
        }
        let pack = best.ok_or_else(|| self.out_of_reach(0.0))?;
        let reached = ICE_DENSITY * pack.solid_fraction;
        if aim.miss(reached) > SHAPED_TOLERANCE {
            return Err(self.out_of_reach(reached));
        }
        Ok(pack)
    }

    fn out_of_reach(&self, reached: f64) -> GrainsError {
        let reason = format!(
            "{} kg/m3 is out of reach: grains of these shapes overlap, and reach {reached:.0} kg/m3",
            self.density
        );
        GrainsError::setting("density", reason)
    }

    /// The slab that is nearest to the density, of up to [`MOST_FALLS`] snowfalls: what remains is made up
    /// for at the seam, which would be looser or closer than the rest.
    fn slab_of_density(&self, quantum: f64) -> Result<(Spheres, Settling), GrainsError> {
        let mut aim = Aim::at(self.density);
        let mut best = self.slab(self.density, quantum)?;
        let density = |slab: &(Spheres, Settling)| ICE_DENSITY * slab.0.nominal();
        let mut last = density(&best);
        for _ in 1..MOST_FALLS {
            if aim.is_met_by(last) {
                break;
            }
            aim.correct(last);
            // What would make up for it may be out of reach.
            let Ok(slab) = self.slab(aim.density(), quantum) else { break };
            last = density(&slab);
            if aim.miss(last) < aim.miss(density(&best)) {
                best = slab;
            }
        }
        Ok(best)
    }

    /// A slab of snow that fell by the settling that pilots found for this density, laid on itself, in quanta; its
    /// period is whole.
    fn slab(&self, aimed: f64, quantum: f64) -> Result<(Spheres, Settling), GrainsError> {
        let radii = &self.radii;
        let ball = 4.0 / 3.0 * PI * radii.mean_cube();
        let fallen = self.density.min(MOST_FALLEN);
        let is_light = self.density < LIGHT;
        let (grains, margin) =
            if is_light { (GRAINS_OF_LIGHT, MARGIN_OF_LIGHT) } else { (GRAINS, MARGIN) };
        let edge = trig::cbrt(grains * ball * ICE_DENSITY / fallen);
        let edge = edge.max(LEAST_PERIOD * radii.largest());
        let quantisation = Quantisation::from_parts(DVec3::ZERO, quantum);
        let mut snow = Snowfall::on_level_floor(quantisation, [edge; 2])?;
        let rolls = self.density > MOST_FALLEN;
        let report = snow.deposit(&DepositSettings {
            amount: Amount::Depth(edge + 2.0 * margin * radii.mean()),
            radii: radii.clone(),
            density: (!rolls).then_some(aimed),
            rule: rolls.then_some(DepositRule::Roll),
            max_slope_degrees: 90.0,
            direction: DepositSettings::DOWN,
            area: None,
            seed: self.seed,
        })?;
        let settling = report.reached.map_or(Settling::Roll, |reached| reached.settling);
        let [x, z] = snow.period().unwrap_or([edge; 2]).map(|edge| (edge / quantum).round());
        let bottom = margin * radii.mean() / quantum;
        let height = (edge / quantum).round();
        let (mut centers, mut sizes) = (Vec::new(), Vec::new());
        for grain in snow.into_field().quantised() {
            let [gx, gy, gz] = grain.center.map(f64::from);
            if (0.0..height).contains(&(gy - bottom)) {
                centers.push(DVec3::new(gx, gy - bottom, gz));
                sizes.push(f64::from(grain.radius));
            }
        }
        Ok((Spheres { centers, radii: sizes, period: DVec3::new(x, height, z) }, settling))
    }
}

impl Spheres {
    fn volume(&self) -> f64 {
        self.period.x * self.period.y * self.period.z
    }

    /// Sum of the volumes over that of a period.
    fn nominal(&self) -> f64 {
        let cubes: f64 = self.radii.iter().map(|radius| radius * radius * radius).sum();
        4.0 / 3.0 * PI * cubes / self.volume()
    }

    /// Moves everything nearer together by `factor`; periods stay whole.
    fn scale(&mut self, factor: f64) {
        let period = (self.period * factor).to_array().map(|edge| self.whole(edge));
        self.stretch_to(DVec3::from_array(period));
    }

    /// Moves everything a little apart along x and z, so that these periods can be cut into equal cells; not nearer, so
    /// that what touches does not overlap.
    fn widen_plan(&mut self) {
        let wider = |edge: f64| {
            let divisor = self.divisor(edge);
            (edge / divisor).ceil() * divisor
        };
        self.stretch_to(DVec3::new(wider(self.period.x), self.period.y, wider(self.period.z)));
    }

    fn stretch_to(&mut self, period: DVec3) {
        let factor = period / self.period;
        self.centers.iter_mut().for_each(|center| *center *= factor);
        self.period = period;
    }

    /// The number of equal cells that a period is cut into where tiles of the pack are packed for light.
    fn divisor(&self, edge: f64) -> f64 {
        let cubes: f64 = self.radii.iter().map(|radius| radius * radius * radius).sum();
        let count = self.radii.len() as f64;
        tile_divisor(edge, trig::cbrt(cubes / count), count, self.volume()) as f64
    }

    /// The nearest period that can be cut so.
    fn whole(&self, edge: f64) -> f64 {
        let divisor = self.divisor(edge);
        (edge / divisor).round() * divisor
    }

    /// Solid fraction of the union of spheres of which no three share a point, with all distances times
    /// `factor`: volumes less the lenses that pairs share.
    fn union(&self, pairs: &[(u32, u32)], factor: f64) -> f64 {
        let lens = |&(a, b): &(u32, u32)| {
            let (a, b) = (a as usize, b as usize);
            let (r, s, d) = (self.radii[a], self.radii[b], factor * self.distance(a, b));
            let overlap = (r + s - d).max(0.0);
            PI * overlap * overlap * (d * d + 2.0 * d * (r + s) - 3.0 * (r - s) * (r - s))
                / (12.0 * d)
        };
        let lenses: f64 = pairs.iter().map(lens).sum();
        (self.nominal() - lenses / self.volume()) / (factor * factor * factor)
    }

    /// Moves everything nearer together until the union fills `wanted`; gives the factor.
    fn sinter(&mut self, wanted: f64) -> f64 {
        const CLOSEST: f64 = 0.87;
        const HALVINGS: u32 = 40;
        let largest = self.radii.iter().copied().fold(0.0, f64::max);
        let near = self.neighbours(2.0 * largest * (1.0 / CLOSEST - 1.0));
        let pairs: Vec<(u32, u32)> = (0u32..)
            .zip(&near)
            .flat_map(|(a, near)| near.iter().filter(move |&&b| a < b).map(move |&b| (a, b)))
            .collect();
        let (mut close, mut wide) = (CLOSEST, 1.0);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (close + wide);
            if self.union(&pairs, middle) > wanted {
                close = middle;
            } else {
                wide = middle;
            }
        }
        self.scale(wide);
        wide
    }

    /// The pack on whole quanta.
    fn rounded(&self, quantum: f64, method: PackMethod) -> PeriodicPack {
        let period = self.period.to_array().map(|edge| edge as i64);
        let grain = |(center, radius): (&DVec3, &f64)| {
            let [x, y, z] = center.to_array().map(|c| c.round() as i64);
            let center =
                [x.rem_euclid(period[0]), y.rem_euclid(period[1]), z.rem_euclid(period[2])];
            QuantisedGrain { center: center.map(|c| c as i32), radius: *radius as u16 }
        };
        let grains: Vec<_> = self.centers.iter().zip(&self.radii).map(grain).collect();
        let near = self.neighbours(0.0);
        let pairs: Vec<(u32, u32)> = (0u32..)
            .zip(&near)
            .flat_map(|(a, near)| near.iter().filter(move |&&b| a < b).map(move |&b| (a, b)))
            .collect();
        PeriodicPack {
            field: GrainField::new(Quantisation::from_parts(DVec3::ZERO, quantum), grains),
            period,
            solid_fraction: self.union(&pairs, 1.0),
            method,
        }
    }
}

#[cfg(test)]
mod tests;
