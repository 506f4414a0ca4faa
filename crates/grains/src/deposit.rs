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
//!   less than a quantum, 1/5450 of the largest radius.
//!
//! A fall is a function of (seed, number of the snowfall, number of the drop) and of what lies.

mod aggregates;
pub(crate) mod aim;
mod arc;
mod area;
mod batch;
mod calibrate;
mod clumps;
mod depth;
mod fill;
mod ground;
mod looks;
mod pile;
mod roll;
mod roof;
mod rules;
mod speculate;

use crate::fill::KnownPacks;
use crate::lattice::lattice_grains;
use crate::{
    Amount, DepositSettings, GrainField, GrainsError, ICE_DENSITY, LatticeSettings, Settling,
    ShapeMix,
};
use ground::Ground;
use pile::Pile;
use rules::Drop;

pub use calibrate::{Reached, reached_solid_fraction};
use snowgrain_accel::{GrainStacks, PlanRectangle, RegionEdge, SimdLevel, Surfaces};
use snowgrain_geometry::{Quantisation, QuantisedGrain};

/// Drops in a row without a grain that lies, after which a snowfall gives up (it looks after each
/// batch).
const HOPELESS_DROPS: u64 = 200_000;

/// What became of the grains of one snowfall.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
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
    /// How the density asked for is reached, where one was.
    pub reached: Option<Reached>,
}

/// Snow in the making: what lies, and what it lies on.
#[derive(Debug)]
pub struct Snowfall<'a> {
    quantisation: Quantisation,
    ground: Ground<'a>,
    /// Grains that can be fallen on; made by the first deposit.
    pile: Pile,
    /// Grains placed since the last deposit.
    placed: Vec<QuantisedGrain>,
    /// Packs that bodies were filled with.
    packs: KnownPacks,
    /// Shapes of the snow to come, which a density is that of.
    shapes: Option<ShapeMix>,
    snowfalls: u64,
    simd_level: SimdLevel,
    /// Follows drops one after another on all of the plan: the meaning of all other ways.
    sequential: bool,
}

impl<'a> Snowfall<'a> {
    /// Nothing has fallen yet on `surfaces`. `quantisation` must have been made for the largest
    /// grain of all the snow to come.
    #[must_use]
    pub fn on_surfaces(quantisation: Quantisation, surfaces: &'a Surfaces) -> Self {
        Self::on(quantisation, Ground::surfaces(surfaces, quantisation))
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
            pile: Pile::default(),
            placed: Vec::new(),
            packs: KnownPacks::default(),
            shapes: None,
            snowfalls: 0,
            simd_level: SimdLevel::detect(),
            sequential: false,
        }
    }

    pub(crate) fn quantisation(&self) -> Quantisation {
        self.quantisation
    }

    /// Packs that were made, and the shapes of those to come.
    pub(crate) fn known_packs(&mut self) -> (&mut KnownPacks, Option<&ShapeMix>) {
        (&mut self.packs, self.shapes.as_ref())
    }

    /// Snow to come has these shapes, spheres where there are none: densities are those of the union of what grains
    /// are, although they fall and are packed as spheres of equal volume.
    pub fn set_shapes(&mut self, shapes: Option<ShapeMix>) {
        self.shapes = shapes.filter(|mix| !mix.is_all_spheres());
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
        self.placed.len() as u64 + self.pile.all().map(GrainStacks::len).sum::<u64>()
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
            + self.pile.all().map(GrainStacks::bytes).sum::<usize>()
    }

    /// Puts the grains of `field` where they are.
    ///
    /// # Errors
    /// A position or radius that this snow's quantisation cannot hold.
    pub fn place(&mut self, field: &GrainField) -> Result<(), GrainsError> {
        if field.quantisation == self.quantisation {
            self.placed.reserve(field.len());
            self.placed.extend(field.quantised());
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
        self.deposit_telling(settings, &mut |_| ())
    }

    /// As [`Self::deposit`]; `fallen` is told several times a second how many grains lie.
    ///
    /// # Errors
    /// As [`Self::deposit`].
    pub fn deposit_telling(
        &mut self,
        settings: &DepositSettings,
        fallen: &mut dyn FnMut(u64),
    ) -> Result<DepositReport, GrainsError> {
        settings.check(self.quantisation.largest_radius())?;
        self.ground.turn(settings.drift());
        let area = self.area(settings)?;
        match settings.density {
            Some(density) => self.deposit_to_density(settings, density, area, fallen),
            None => {
                let settling = Settling::of_rule(settings.plain_rule());
                self.deposit_as(settings, settling, area, fallen)
            }
        }
    }

    /// Lets grains come to rest so, whatever density that gives.
    fn deposit_as(
        &mut self,
        settings: &DepositSettings,
        settling: Settling,
        area: PlanRectangle,
        fallen: &mut dyn FnMut(u64),
    ) -> Result<DepositReport, GrainsError> {
        let class = self.prepare_stacks((settings, settling), area)?;
        let lowest = self.lowest();
        let quantum = self.quantisation.quantum();
        let drawn = settings.radii.largest() / quantum;
        let drops = fill::expected_grains(settings, quantum, area);
        let plan = area::grown(area, drawn as u16);
        self.ground.prepare(plan, settling.surface_reach(drawn.ceil()), drops);
        let (stacks, others) = self.pile.split(class);
        let mut falling = Falling {
            drop: Drop::new(
                settings,
                settling,
                &self.quantisation,
                &self.ground,
                (area, lowest),
                self.snowfalls,
            ),
            fill: settings.density.map_or(1.0, |density| density / ICE_DENSITY),
            edge: batch::region_edge(stacks),
            sequential: self.sequential,
            stacks,
            others,
            report: DepositReport::default(),
            drops: 0,
            drops_since_success: 0,
            fallen,
        };
        self.snowfalls += 1;
        match settings.amount {
            Amount::Grains(grains) => falling.until(grains)?,
            Amount::Depth(depth) => falling.until_deep(depth / self.quantisation.quantum())?,
        }
        Ok(falling.report)
    }

    /// Height below which nothing lies or will lie, but on planes, quanta. Falls straight down end of
    /// themselves, and do not ask.
    fn lowest(&self) -> f64 {
        if !self.ground.leans() {
            return f64::NEG_INFINITY;
        }
        let bottom = |grain: QuantisedGrain| grain.center[1] - i32::from(grain.radius);
        let grains = self.pile.all().flat_map(GrainStacks::iter).map(bottom).map(f64::from);
        let largest = f64::from(Quantisation::MAX_RADIUS_QUANTA);
        grains.fold(self.ground.lowest(), f64::min) - 4.0 * largest
    }

    /// Shows all grains that lie so far.
    pub fn for_each_grain(&self, mut visit: impl FnMut(QuantisedGrain)) {
        let mut grains = Vec::new();
        for stacks in self.pile.all() {
            for part in 0..stacks.parts() {
                grains.clear();
                stacks.part(part, &mut grains);
                grains.iter().for_each(|&grain| visit(grain));
            }
        }
        self.placed.iter().for_each(|&grain| visit(grain));
    }

    /// The grains, in an order that depends on the input only.
    #[must_use]
    pub fn into_field(self) -> GrainField {
        GrainField::of_stacks(self.quantisation, self.pile.into_stacks(), self.placed)
    }
}

/// One snowfall in progress.
struct Falling<'f> {
    drop: Drop<'f>,
    /// Stacks that grow.
    stacks: &'f mut GrainStacks,
    /// Those of grains of other sizes, which only lie there.
    others: Vec<&'f GrainStacks>,
    /// Edge of the regions that threads own.
    edge: RegionEdge,
    sequential: bool,
    /// Solid fraction asked for; 1 where none is.
    fill: f64,
    report: DepositReport,
    drops: u64,
    drops_since_success: u64,
    /// Told how many grains lie.
    fallen: &'f mut dyn FnMut(u64),
}

impl Falling<'_> {
    /// Drops grains until `grains` of this snowfall lie.
    fn until(&mut self, grains: u64) -> Result<(), GrainsError> {
        self.drops_since_success = 0;
        while self.report.accepted < grains {
            self.batch(grains - self.report.accepted)?;
            (self.fallen)(self.report.accepted);
            if self.drops_since_success >= HOPELESS_DROPS {
                let DepositReport { accepted, discarded, missed, .. } = self.report;
                let drops = self.drops_since_success;
                return Err(GrainsError::NothingComesToRest { drops, accepted, discarded, missed });
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod order_tests;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod wind_tests;
