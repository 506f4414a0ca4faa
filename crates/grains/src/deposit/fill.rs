//! How many grains a snowfall takes, and the cells that suit it.

use crate::{Amount, DepositSettings, ICE_DENSITY, Settling};
use snowgrain_accel::PlanRectangle;

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
            let radius = settings.radii.mean() / quantum;
            let volume = 4.0 / 3.0 * core::f64::consts::PI * radius * radius * radius;
            let fill = settings.density.map_or(0.5, |density| density / ICE_DENSITY);
            fill * (depth / quantum) * plan_area(area) / volume
        }
    }
}

/// Side of the cells for a snowfall whose largest grain, or largest grain below it, has `radius`
/// quanta: twice the reach of a fall where the snow is deep, so that the four cells nearest to a fall
/// hold all that it may meet; wider, up to what a block's integers hold, where a cell would
/// otherwise get but a few of the 15 grains of a block.
pub(super) fn cell_side(
    (settings, settling): (&DepositSettings, Settling),
    quantum: f64,
    area: PlanRectangle,
    radius: i32,
) -> u16 {
    const GRAINS_PER_CELL: f64 = 20.0;
    let grains = expected_grains(settings, quantum, area);
    let wanted = (GRAINS_PER_CELL * plan_area(area) / grains).sqrt();
    let least = 2.0 * settling.reach(radius.into());
    let side = wanted.clamp(least, (2.4 * least).max(least));
    side.clamp(16.0, f64::from(u16::MAX)) as u16
}
