//! How densely a rule fills space, and the cells that suit a snowfall.

use super::Snowfall;
use crate::measures::{Slab, union_solid_fraction};
use crate::{Amount, DepositSettings, GrainsError, ICE_DENSITY};
use snowgrain_accel::PlanRectangle;
use snowgrain_geometry::Quantisation;
use snowgrain_math::DVec3;

/// Relative difference between the density asked for and reached that is let pass.
const DENSITY_TOLERANCE: f64 = 0.03;
/// Width of the level floor on which a rule is tried, in largest radii.
const TRIAL_WIDTH: f64 = 80.0;
/// Deepest trial, in mean radii: fill hardly changes below.
const TRIAL_DEPTH: f64 = 400.0;
/// Fewest grains of a trial.
const TRIAL_GRAINS: f64 = 500.0;

/// The solid fraction (union of the ice, between 20 and 80 % of the depth) that a snowfall with
/// these settings reaches over `area_m2` of level ground: measured, by letting the same rule, sizes
/// and amount per area fall on a small periodic floor.
///
/// # Errors
/// As [`Snowfall::deposit`].
pub fn reached_solid_fraction(
    settings: &DepositSettings,
    area_m2: f64,
) -> Result<f64, GrainsError> {
    let largest = settings.radii.largest();
    let quantisation = Quantisation::for_grains(DVec3::ZERO, largest);
    let width = TRIAL_WIDTH * largest;
    let deepest = TRIAL_DEPTH * settings.radii.mean;
    let amount = match settings.amount {
        Amount::Depth(depth) => Amount::Depth(depth.min(deepest)),
        Amount::Grains(grains) => {
            let share = grains as f64 * (width * width / area_m2);
            let volume = 4.0 / 3.0 * core::f64::consts::PI * settings.radii.mean_cube();
            let most = 0.45 * deepest * width * width / volume;
            Amount::Grains(share.min(most).max(TRIAL_GRAINS) as u64)
        }
    };
    let mut trial = Snowfall::on_level_floor(quantisation, [width, width])?;
    let settings = DepositSettings { amount, density: None, area: None, ..settings.clone() };
    trial.deposit(&settings)?;
    let period = trial.period().unwrap_or([width, width]);
    let field = trial.into_field();
    let slab = Slab::between_parts_of_depth(&field, Some(period), [0.2, 0.8]);
    Ok(union_solid_fraction(&field, &slab, 200_000, settings.seed).mean)
}

/// Refuses a density that the rule does not reach.
pub(super) fn check_density(
    settings: &DepositSettings,
    quantum: f64,
    area: PlanRectangle,
) -> Result<(), GrainsError> {
    let Some(density) = settings.density else { return Ok(()) };
    let edge = |axis: usize| (f64::from(area.max[axis]) - f64::from(area.min[axis])) * quantum;
    let reached = ICE_DENSITY * reached_solid_fraction(settings, edge(0) * edge(1))?;
    if (density - reached).abs() <= DENSITY_TOLERANCE * reached {
        return Ok(());
    }
    let [low, high] = [1.0 - DENSITY_TOLERANCE, 1.0 + DENSITY_TOLERANCE].map(|f| f * reached);
    Err(GrainsError::setting(
        "density",
        format!(
            "{density} kg/m3 is out of reach: this rule, with these radii and this much snow, \
             gives {reached:.1} kg/m3 (measured), so {low:.1} to {high:.1} can be asked for; leave \
             `density` out to take what it gives, or change `rule`"
        ),
    ))
}

fn plan_area(area: PlanRectangle) -> f64 {
    let edge = |axis: usize| f64::from(area.max[axis]) - f64::from(area.min[axis]);
    edge(0) * edge(1)
}

/// About how many grains a snowfall on `area` takes.
pub(super) fn expected_grains(
    settings: &DepositSettings,
    quantum: f64,
    area: PlanRectangle,
) -> f64 {
    match settings.amount {
        Amount::Grains(grains) => grains as f64,
        Amount::Depth(depth) => {
            let radius = settings.radii.mean / quantum;
            let volume = 4.0 / 3.0 * core::f64::consts::PI * radius * radius * radius;
            0.5 * (depth / quantum) * plan_area(area) / volume
        }
    }
}

/// Side of the cells for a snowfall whose largest grain, or largest grain below it, has `radius`
/// quanta: twice the reach of a fall where the snow is deep, so that the four cells nearest to a fall
/// hold all that it may meet; wider, up to what a block's integers hold, where a cell would
/// otherwise get but a few of the 15 grains of a block.
pub(super) fn cell_side(
    settings: &DepositSettings,
    quantum: f64,
    area: PlanRectangle,
    radius: i32,
) -> u16 {
    const GRAINS_PER_CELL: f64 = 20.0;
    let grains = expected_grains(settings, quantum, area);
    let wanted = (GRAINS_PER_CELL * plan_area(area) / grains).sqrt();
    let least = 2.0 * settings.rule.reach(radius.into());
    let side = wanted.clamp(least, (2.4 * least).max(least));
    side.clamp(16.0, f64::from(u16::MAX)) as u16
}
