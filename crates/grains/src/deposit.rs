//! Snow that falls: grains come down one after another and stay where their rule lets them.
//!
//! A [`Snowfall`] holds what lies already. [`Snowfall::deposit`] lets grains fall on it,
//! [`Snowfall::lattice`] and [`Snowfall::place`] put grains where they are told; later snow falls
//! on earlier. Each grain is rounded to the scene's quantisation lattice when it comes to rest and
//! later grains meet the rounded one, so what falls is what is stored is what is rendered.
//!
//! The rules ([`DepositRule`](crate::DepositRule)):
//!
//! - `Ray`: the paper's, section 4.2. A ray straight down from a random point above; the grain's
//!   centre lies one radius along the geometric normal at the first hit; discarded where that
//!   normal is too steep. Grains overlap.
//! - `Stick`: the falling sphere stops at its first contact; discarded where the normal of that
//!   contact is too steep. Its height is rounded up, so grains never overlap.
//! - `Roll`: after its first contact the sphere rolls down over the grains that it touches (see
//!   `roll.rs`) until they support it. Ice sticks to solid surfaces: a grain rests where it first
//!   meets one, and is discarded only where it falls on one that is too steep. Grains overlap by
//!   less than a quantum, 7e-5 of the largest radius.
//!
//! A fall is a function of (seed, number of the snowfall, number of the drop) and of what lies.

mod depth;
mod fill;
mod ground;
mod roll;
mod rules;

use crate::lattice::lattice_grains;
use crate::{Amount, DepositSettings, GrainField, GrainsError, LatticeSettings};
use ground::Ground;
use rules::{Drop, Fate};

pub use fill::reached_solid_fraction;
use snowgrain_accel::{GrainStacks, GrainStacksError, PlanRectangle, SimdLevel, Surfaces};
use snowgrain_geometry::{Quantisation, QuantisedGrain};

/// Drops in a row without a grain that lies, after which a snowfall gives up.
const HOPELESS_DROPS: u64 = 200_000;

/// What became of the grains of one snowfall.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DepositReport {
    /// Grains that lie.
    pub accepted: u64,
    /// Grains whose contact was too steep.
    pub discarded: u64,
    /// Grains that fell past everything.
    pub missed: u64,
    /// Of the accepted: rolling grains that were left where they touched others after too many
    /// turns, without a stable support.
    pub unsettled: u64,
}

/// Snow in the making: what lies, and what it lies on.
#[derive(Debug)]
pub struct Snowfall<'a> {
    quantisation: Quantisation,
    ground: Ground<'a>,
    /// Grains that can be fallen on; made by the first deposit.
    stacks: Option<GrainStacks>,
    /// Grains placed since the last deposit.
    placed: Vec<QuantisedGrain>,
    snowfalls: u64,
    simd_level: SimdLevel,
}

impl<'a> Snowfall<'a> {
    /// Nothing has fallen yet on `surfaces`. `quantisation` must have been made for the largest
    /// grain of all the snow to come.
    #[must_use]
    pub fn on_surfaces(quantisation: Quantisation, surfaces: &'a Surfaces) -> Self {
        Self::on(quantisation, Ground::Surfaces { surfaces, quantisation })
    }

    /// Nothing has fallen yet on a level floor at the height of the quantisation's origin, that
    /// repeats along x and z with periods as near to `widths` (metres) as whole quanta and cells
    /// of a grain's size allow; [`Self::period`] tells them.
    ///
    /// # Errors
    /// A width that is not finite or less than four largest radii.
    pub fn on_level_floor(
        quantisation: Quantisation,
        widths: [f64; 2],
    ) -> Result<Self, GrainsError> {
        Ok(Self::on(quantisation, Ground::level_floor(&quantisation, widths)?))
    }

    fn on(quantisation: Quantisation, ground: Ground<'a>) -> Self {
        Self {
            quantisation,
            ground,
            stacks: None,
            placed: Vec::new(),
            snowfalls: 0,
            simd_level: SimdLevel::detect(),
        }
    }

    /// Uses this SIMD level instead of the best one; the grains do not change.
    #[must_use]
    pub fn with_simd_level(mut self, level: SimdLevel) -> Self {
        self.simd_level = level;
        self
    }

    /// Periods along x and z, metres, where the plan repeats.
    #[must_use]
    pub fn period(&self) -> Option<[f64; 2]> {
        let period = self.ground.period()?;
        Some(period.map(|quanta| f64::from(quanta) * self.quantisation.quantum()))
    }

    /// Number of grains.
    #[must_use]
    pub fn len(&self) -> u64 {
        self.placed.len() as u64 + self.stacks.as_ref().map_or(0, GrainStacks::len)
    }

    /// Whether nothing lies yet.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Memory for the grains and what a fall asks, bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.placed.capacity() * size_of::<QuantisedGrain>()
            + self.stacks.as_ref().map_or(0, GrainStacks::bytes)
    }

    /// Puts the grains of `field` where they are.
    ///
    /// # Errors
    /// A position or radius that this snow's quantisation cannot hold.
    pub fn place(&mut self, field: &GrainField) -> Result<(), GrainsError> {
        if field.quantisation == self.quantisation {
            self.placed.extend_from_slice(&field.grains);
            return Ok(());
        }
        self.placed.reserve(field.len());
        for grain in field.iter() {
            self.placed.push(self.quantisation.round(grain.center, grain.radius)?);
        }
        Ok(())
    }

    /// Puts a crystal lattice in its place.
    ///
    /// # Errors
    /// As [`lattice_grains`].
    pub fn lattice(&mut self, settings: &LatticeSettings) -> Result<(), GrainsError> {
        self.place(&lattice_grains(settings, &self.quantisation)?)
    }

    /// Lets grains fall until `settings.amount` lies.
    ///
    /// Without an area, grains fall on the whole period of a periodic floor, or on the box of the
    /// finite surfaces, or where there are none of the grains that lie, plus a margin of two
    /// largest radii on each side.
    ///
    /// # Errors
    /// Settings without meaning; a density that the rule does not reach (the message names the
    /// range that it does); an area where nothing comes to rest; what cannot be stored. Grains
    /// that lay before, and those of this snowfall that came to rest before the error, stay.
    pub fn deposit(&mut self, settings: &DepositSettings) -> Result<DepositReport, GrainsError> {
        settings.check(self.quantisation.largest_radius())?;
        let area = self.area(settings)?;
        fill::check_density(settings, self.quantisation.quantum(), area)?;
        self.prepare_stacks(settings, area)?;
        let Some(stacks) = &mut self.stacks else { return Ok(DepositReport::default()) };
        let mut falling = Falling {
            drop: Drop::new(settings, &self.quantisation, &self.ground, area, self.snowfalls),
            stacks,
            report: DepositReport::default(),
            drops: 0,
        };
        self.snowfalls += 1;
        match settings.amount {
            Amount::Grains(grains) => falling.until(grains)?,
            Amount::Depth(depth) => falling.until_deep(depth / self.quantisation.quantum())?,
        }
        Ok(falling.report)
    }

    /// The grains, in an order that depends on the input only.
    #[must_use]
    pub fn into_field(self) -> GrainField {
        let mut grains = Vec::with_capacity(self.len() as usize);
        if let Some(stacks) = &self.stacks {
            grains.extend(stacks.iter());
        }
        grains.extend_from_slice(&self.placed);
        GrainField { quantisation: self.quantisation, grains }
    }

    /// The plan rectangle that grains fall on.
    fn area(&self, settings: &DepositSettings) -> Result<PlanRectangle, GrainsError> {
        if let Some([px, pz]) = self.ground.period() {
            return Ok(PlanRectangle { min: [0, 0], max: [px, pz] });
        }
        let rectangle = match settings.area {
            Some(area) => area,
            None => self.default_area(settings)?,
        };
        let (origin, quantum) = (self.quantisation.origin(), self.quantisation.quantum());
        let reach = f64::from(Quantisation::MAX_COORDINATE);
        let mut quanta = [0i32; 4];
        for (index, value) in rectangle.into_iter().enumerate() {
            let at = (value - if index % 2 == 0 { origin.x } else { origin.z }) / quantum;
            if !at.is_finite() || at.abs() > reach {
                let limit = reach * quantum;
                return Err(GrainsError::setting(
                    "area",
                    format!(
                        "{value} m is out of reach: grains of this size can lie up to {limit} m \
                         from ({}, {}); use larger grains or move the scene",
                        origin.x, origin.z
                    ),
                ));
            }
            quanta[index] = at.round() as i32;
        }
        let [x0, z0, x1, z1] = quanta;
        if x0 >= x1 || z0 >= z1 {
            return Err(GrainsError::setting(
                "area",
                "is narrower than a grain can tell; widen it",
            ));
        }
        Ok(PlanRectangle { min: [x0, z0], max: [x1, z1] })
    }

    fn default_area(&self, settings: &DepositSettings) -> Result<[f64; 4], GrainsError> {
        let mut bounds = self.ground.bounds();
        if bounds.is_empty() {
            let lying =
                self.stacks.iter().flat_map(GrainStacks::iter).chain(self.placed.iter().copied());
            bounds = crate::field::bounds_of(lying, &self.quantisation);
        }
        if bounds.is_empty() {
            return Err(GrainsError::setting(
                "area",
                "is needed: there is no finite object whose box could be the default",
            ));
        }
        let bounds = bounds.expanded(2.0 * settings.radii.largest());
        Ok([bounds.min.x, bounds.min.z, bounds.max.x, bounds.max.z])
    }

    /// Puts everything placed so far on the stacks, and lets them cover `area` and grains that
    /// come to rest a little outside it.
    fn prepare_stacks(
        &mut self,
        settings: &DepositSettings,
        area: PlanRectangle,
    ) -> Result<(), GrainsError> {
        let largest = self.placed.iter().map(|grain| grain.radius).max().unwrap_or(0);
        let drawn = (settings.radii.largest() / self.quantisation.quantum()).round() as u16;
        let radius = i32::from(largest.max(drawn));
        let margin = 16 * radius;
        let mut plan = PlanRectangle {
            min: area.min.map(|low| low.saturating_sub(margin)),
            max: area.max.map(|high| high.saturating_add(margin)),
        };
        for grain in &self.placed {
            for (axis, coordinate) in [grain.center[0], grain.center[2]].into_iter().enumerate() {
                plan.min[axis] = plan.min[axis].min(coordinate);
                plan.max[axis] = plan.max[axis].max(coordinate);
            }
        }
        if self.stacks.is_none() {
            let side = fill::cell_side(settings, self.quantisation.quantum(), area, radius);
            self.stacks = Some(self.ground.new_stacks(plan, side)?);
        }
        let Some(stacks) = &mut self.stacks else { return Ok(()) };
        stacks.set_level(self.simd_level);
        stacks.cover(plan)?;
        for grain in std::mem::take(&mut self.placed) {
            stacks.push(grain)?;
        }
        Ok(())
    }
}

/// One snowfall in progress.
struct Falling<'f> {
    drop: Drop<'f>,
    stacks: &'f mut GrainStacks,
    report: DepositReport,
    drops: u64,
}

impl Falling<'_> {
    /// Drops grains until `grains` of this snowfall lie.
    fn until(&mut self, grains: u64) -> Result<(), GrainsError> {
        let mut last_success = self.drops;
        while self.report.accepted < grains {
            let fate = self.drop.fall(self.stacks, self.drops)?;
            self.drops += 1;
            match fate {
                Fate::Rests(grain) => {
                    self.store(grain)?;
                    self.report.accepted += 1;
                    last_success = self.drops;
                }
                Fate::Unsettled(grain) => {
                    self.store(grain)?;
                    self.report.accepted += 1;
                    self.report.unsettled += 1;
                    last_success = self.drops;
                }
                Fate::TooSteep => self.report.discarded += 1,
                Fate::Missed => self.report.missed += 1,
            }
            if self.drops - last_success >= HOPELESS_DROPS {
                let DepositReport { accepted, discarded, missed, .. } = self.report;
                let drops = HOPELESS_DROPS;
                return Err(GrainsError::NothingComesToRest { drops, accepted, discarded, missed });
            }
        }
        Ok(())
    }

    /// Stores a grain; where it rolled out of the plan, the plan grows by as much again, which
    /// changes no answer.
    fn store(&mut self, grain: QuantisedGrain) -> Result<(), GrainsError> {
        let mut reach = 32 * i32::from(grain.radius.max(1));
        loop {
            match self.stacks.push(grain) {
                Err(GrainStacksError::OutsideArea) => {
                    let around = |c: i32| (c.saturating_sub(reach), c.saturating_add(reach));
                    let (x, z) = (around(grain.center[0]), around(grain.center[2]));
                    self.stacks.cover(PlanRectangle { min: [x.0, z.0], max: [x.1, z.1] })?;
                    reach = reach.saturating_mul(2);
                }
                stored => return Ok(stored.map(|_| ())?),
            }
        }
    }
}

#[cfg(test)]
mod tests;
