//! The settling that reaches a density: tried on a small level floor that repeats.
//!
//! What can be tuned is one number of a [`Settling`], along which the solid fraction rises or falls. It
//! is sought by the Illinois form of false position (Dowell & Jarratt 1971, BIT 11, 168) with
//! pilot snowfalls of the same sizes, depth and seed: a pure function of the settings.

use super::aim::{Aim, MOST_FALLS};
use super::pile::Pile;
use super::{DepositReport, Snowfall};
use crate::measures::{
    Slab, nominal_solid_fraction, solid_fractions_along_lines, union_solid_fraction,
};
use crate::{
    Amount, DepositRule, DepositSettings, GrainField, GrainsError, ICE_DENSITY, Settling, ShapeMix,
};
use snowgrain_accel::PlanRectangle;
use snowgrain_geometry::Quantisation;
use snowgrain_math::{DVec3, trig};

/// Relative difference between the density asked for and that of a rule that cannot be tuned which
/// is let pass.
const TOLERANCE: f64 = 0.02;
/// Relative difference at which the search ends.
const CLOSE: f64 = 2e-3;
/// Most grains that are measured.
const MOST_MEASURED: u64 = 20_000_000;
/// Most pilots of a search within a bracket.
const MOST_PILOTS: u32 = 12;
/// Grains of a pilot, and of one of aggregates, of which there must be many.
const PILOT_GRAINS: f64 = 40_000.0;
const PILOT_GRAINS_IN_AGGREGATES: f64 = 400_000.0;
/// Depth of a pilot at most, in mean radii: below, the fill changes by less than a hundredth.
const PILOT_DEPTH: f64 = 150.0;
/// Width of a pilot, in largest radii.
const PILOT_WIDTH: [f64; 2] = [40.0, 600.0];
/// Points at which overlapping grains are measured.
const POINTS: u32 = 400_000;
/// Largest aggregates.
const MOST_IN_AGGREGATE: f64 = 2048.0;
/// Least part of the radius at which sintered grains still touch: what touched then overlaps by half of
/// it.
const LEAST_TOUCH: f64 = 0.5;

/// How a density is reached.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reached {
    /// What the grains do.
    pub settling: Settling,
    /// Density asked for, kg/m^3.
    pub asked: f64,
    /// Density of the last pilot, kg/m^3: that of the same settling on a level floor.
    pub pilot: f64,
    /// Density of the snow itself, kg/m^3, where it was measured.
    pub measured: Option<f64>,
}

impl Reached {
    /// The best that is known of the density, kg/m^3.
    #[must_use]
    pub fn density(&self) -> f64 {
        self.measured.unwrap_or(self.pilot)
    }
}

/// The solid fraction (union of the ice, between 20 and 80 % of the depth) that a snowfall by the rule
/// of these settings reaches over `area_m2` of level ground: measured on a small periodic floor.
///
/// # Errors
/// As [`Snowfall::deposit`].
pub fn reached_solid_fraction(
    settings: &DepositSettings,
    area_m2: f64,
) -> Result<f64, GrainsError> {
    Pilots { settings, area_m2, shapes: None }.fill(Settling::of_rule(settings.plain_rule()))
}

impl Snowfall<'_> {
    /// Lets snow fall so that it has a density.
    ///
    /// Where nothing lay before, snow of single grains is measured, since it is less dense on steep ground and
    /// towards the edge of the area than pilots are on a level floor; it falls anew, up to
    /// [`MOST_FALLS`] times in search of a settling that makes up for that, and once more by the best of
    /// them where that was not the last.
    pub(super) fn deposit_to_density(
        &mut self,
        settings: &DepositSettings,
        density: f64,
        area: PlanRectangle,
        fallen: &mut dyn FnMut(u64),
    ) -> Result<DepositReport, GrainsError> {
        let quantum = self.quantisation.quantum();
        let edge = |axis: usize| (f64::from(area.max[axis]) - f64::from(area.min[axis])) * quantum;
        let area_m2 = edge(0) * edge(1);
        let may_fall_anew = self.is_empty() && self.period().is_none();
        let shapes = self.shapes.clone();
        let shapes = shapes.as_ref();
        let pilots = Pilots { settings, area_m2, shapes };
        let (mut settling, mut fill) = pilots.reach(density / ICE_DENSITY)?;
        let mut aim = Aim::at(density);
        let (mut falls, mut best) = (0, (f64::INFINITY, (settling, fill)));
        loop {
            let mut report = self.deposit_as(settings, settling, area, fallen)?;
            falls += 1;
            // Aggregates are as large as the squares in which snow is measured.
            let is_fine = !matches!(settling, Settling::Aggregates { .. });
            let measured = if may_fall_anew && is_fine { self.measured_density() } else { None };
            let pilot = ICE_DENSITY * fill;
            report.reached = Some(Reached { settling, asked: density, pilot, measured });
            let Some(measured) = measured.filter(|&measured| !aim.is_met_by(measured)) else {
                return Ok(report);
            };
            if aim.miss(measured) < best.0 {
                best = (aim.miss(measured), (settling, fill));
            }
            aim.correct(measured);
            let aimed = aim.density();
            let pilots = Pilots { settings: &settings.with_density(aimed), area_m2, shapes };
            // What would make up for it may be out of reach, or be what fell just now.
            let next =
                if falls < MOST_FALLS { pilots.reach(aimed / ICE_DENSITY).ok() } else { None };
            let next = next.filter(|next| *next != (settling, fill)).unwrap_or(best.1);
            if falls > MOST_FALLS || next == (settling, fill) {
                return Ok(report);
            }
            (settling, fill) = next;
            (self.pile, self.snowfalls) = (Pile::default(), self.snowfalls - 1);
        }
    }

    /// Density of all that lies, kg/m^3, where it is deep enough, and not so much that it could not be held
    /// twice.
    fn measured_density(&self) -> Option<f64> {
        if self.len() > MOST_MEASURED {
            return None;
        }
        let stacks = self.pile.all().cloned().collect();
        let field = GrainField::of_stacks(self.quantisation, stacks, Vec::new());
        let field = match &self.shapes {
            Some(mix) => mix.drawn(field),
            None => field,
        };
        let (union, _) = solid_fractions_along_lines(&field, 0);
        (union.mean > 0.0).then_some(ICE_DENSITY * union.mean)
    }
}

/// Snowfalls to try settlings by.
struct Pilots<'a> {
    settings: &'a DepositSettings,
    area_m2: f64,
    /// What grains are that are no spheres.
    shapes: Option<&'a ShapeMix>,
}

impl Pilots<'_> {
    fn reach(&self, wanted: f64) -> Result<(Settling, f64), GrainsError> {
        match self.settings.rule {
            Some(DepositRule::Ray) => {
                let fill = self.fill(Settling::Ray)?;
                if (wanted - fill).abs() > TOLERANCE * fill {
                    let range = [(1.0 - TOLERANCE) * fill, (1.0 + TOLERANCE) * fill];
                    return Err(self.out_of_reach(range, Some(DepositRule::Ray)));
                }
                Ok((Settling::Ray, fill))
            }
            rule @ Some(DepositRule::Stick) => {
                let stuck = self.fill(Settling::Stick)?;
                if wanted > (1.0 + CLOSE) * stuck {
                    let least = self.fill(Settling::Aggregates { grains: MOST_IN_AGGREGATE })?;
                    return Err(self.out_of_reach([least, stuck], rule));
                }
                self.aggregates(wanted, stuck)
            }
            rule @ Some(DepositRule::Roll) => {
                let stuck = self.fill(Settling::StickOrRoll { roll: 0.0 })?;
                if wanted < (1.0 - CLOSE) * stuck {
                    let most = self.fill(Settling::Sinter { touch: LEAST_TOUCH })?;
                    return Err(self.out_of_reach([stuck, most], rule));
                }
                self.rolling(wanted, stuck)
            }
            None => {
                let stuck = self.fill(Settling::Stick)?;
                if wanted <= stuck {
                    self.aggregates(wanted, stuck)
                } else {
                    self.rolling(wanted, stuck)
                }
            }
        }
    }

    /// Aggregates as large as the density asks: their number of grains is sought on a scale of ratios,
    /// on which the fill is nearly a power of it.
    fn aggregates(&self, wanted: f64, stuck: f64) -> Result<(Settling, f64), GrainsError> {
        let of = |log: f64| Settling::Aggregates { grains: trig::exp(log).max(1.0) };
        let mut low = (0.0, stuck);
        loop {
            let log = low.0 + trig::ln(4.0);
            if log > trig::ln(MOST_IN_AGGREGATE) + 1e-9 {
                return Err(self.out_of_reach([low.1, stuck], self.settings.rule));
            }
            let fill = self.fill(of(log))?;
            if fill <= wanted {
                return self.between([low, (log, fill)], wanted, of);
            }
            low = (log, fill);
        }
    }

    /// Grains that stick or roll, or that sinter where rolling does not pack them closely enough.
    fn rolling(&self, wanted: f64, stuck: f64) -> Result<(Settling, f64), GrainsError> {
        let rolled = self.fill(Settling::Roll)?;
        if wanted <= rolled {
            let of = |roll: f64| Settling::StickOrRoll { roll };
            return self.between([(0.0, stuck), (1.0, rolled)], wanted, of);
        }
        let of = |touch: f64| Settling::Sinter { touch };
        let closest = self.fill(of(LEAST_TOUCH))?;
        if wanted > closest {
            return Err(self.out_of_reach([stuck, closest], self.settings.rule));
        }
        self.between([(1.0, rolled), (LEAST_TOUCH, closest)], wanted, of)
    }

    /// What of the settlings between two brings the fill that is wanted; each end comes with its own.
    fn between(
        &self,
        [mut a, mut b]: [(f64, f64); 2],
        wanted: f64,
        settling: impl Fn(f64) -> Settling,
    ) -> Result<(Settling, f64), GrainsError> {
        let error = |fill: f64| trig::ln(fill / wanted);
        let mut best = if error(a.1).abs() < error(b.1).abs() { a } else { b };
        (a.1, b.1) = (error(a.1), error(b.1));
        for _ in 0..MOST_PILOTS {
            if error(best.1).abs() < CLOSE {
                break;
            }
            let at = (b.0 * a.1 - a.0 * b.1) / (a.1 - b.1);
            let fill = self.fill(settling(at))?;
            if error(fill).abs() < error(best.1).abs() {
                best = (at, fill);
            }
            let new = (at, error(fill));
            if new.1 * b.1 < 0.0 {
                a = b;
            } else {
                a.1 *= 0.5;
            }
            b = new;
        }
        Ok((settling(best.0), best.1))
    }

    /// The solid fraction of a pilot.
    fn fill(&self, settling: Settling) -> Result<f64, GrainsError> {
        let radii = &self.settings.radii;
        let typical = self.settings.density.map_or(0.4, |density| density / ICE_DENSITY);
        let ball = 4.0 / 3.0 * core::f64::consts::PI * radii.mean_cube();
        let depth = match self.settings.amount {
            Amount::Depth(depth) => depth,
            Amount::Grains(grains) => grains as f64 * ball / (typical * self.area_m2),
        };
        let depth = depth.min(PILOT_DEPTH * radii.mean());
        let wanted = match settling {
            Settling::Aggregates { .. } => PILOT_GRAINS_IN_AGGREGATES,
            _ => PILOT_GRAINS,
        };
        let [narrowest, widest] = PILOT_WIDTH.map(|width| width * radii.largest());
        let width = (wanted * ball / (typical * depth)).sqrt().clamp(narrowest, widest);
        let amount = match self.settings.amount {
            Amount::Depth(_) => Amount::Depth(depth),
            Amount::Grains(_) => {
                Amount::Grains((typical * depth * width * width / ball).ceil() as u64)
            }
        };
        let settings = DepositSettings { amount, area: None, ..self.settings.clone() };
        fill_of(&settings, settling, width, self.shapes)
    }

    fn out_of_reach(&self, [low, high]: [f64; 2], rule: Option<DepositRule>) -> GrainsError {
        let density = self.settings.density.unwrap_or(0.0);
        let [low, high] = [low, high].map(|fill| fill * ICE_DENSITY);
        let (rule, mend) = match rule {
            Some(DepositRule::Ray) => ("rule = \"ray\"", "; leave `rule` out for others"),
            Some(DepositRule::Stick) => ("rule = \"stick\"", "; leave `rule` out for denser snow"),
            Some(DepositRule::Roll) => ("rule = \"roll\"", "; leave `rule` out for lighter snow"),
            None => ("a snowfall", ""),
        };
        let reason = format!(
            "{density} kg/m3 is out of reach: with these radii and this much snow {rule} gives \
             {low:.1} to {high:.1} kg/m3 (measured){mend}"
        );
        GrainsError::setting("density", reason)
    }
}

/// The solid fraction of a snowfall on a level floor of this width, metres.
fn fill_of(
    settings: &DepositSettings,
    settling: Settling,
    width: f64,
    shapes: Option<&ShapeMix>,
) -> Result<f64, GrainsError> {
    let quantisation = Quantisation::for_grains(DVec3::ZERO, settings.radii.largest());
    let mut trial = Snowfall::on_level_floor(quantisation, [width, width])?;
    trial.ground.turn(settings.drift());
    let area = trial.area(settings)?;
    trial.deposit_as(settings, settling, area, &mut |_| ())?;
    let period = trial.period().unwrap_or([width, width]);
    let field = trial.into_field();
    let slab = Slab::between_parts_of_depth(&field, Some(period), [0.2, 0.8]);
    Ok(match shapes {
        // Those that float are turned afterwards, by which the overlap grows by half a hundredth of the ice.
        Some(mix) => union_solid_fraction(&mix.drawn(field), &slab, POINTS, settings.seed).mean,
        None if settling.overlaps() => {
            union_solid_fraction(&field, &slab, POINTS, settings.seed).mean
        }
        None => nominal_solid_fraction(&field, &slab),
    })
}
