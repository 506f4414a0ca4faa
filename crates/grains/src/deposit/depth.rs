//! Snow by depth.
//!
//! The depth is the mean height of the surface of the snow over what lay there before the
//! snowfall, both seen straight from above, at 64 x 64 evenly spread points of the area; points
//! above nothing, and points where the bare ground is steeper than the rule accepts, do not count.

use super::Falling;
use super::rules::Drop;
use crate::GrainsError;
use snowgrain_accel::{Fall, GrainStacks, PlanRectangle};

/// Points along each side of the area.
const POINTS: i32 = 64;
/// Drops between two looks at the depth, at least, as a part of one full layer of grains.
const LEAST_BATCH: f64 = 0.02;
/// Deepest snow, in mean radii, that the first batch is sure not to exceed.
const FIRST_BATCH_FILL: f64 = 0.05;

/// A place where the depth is looked at.
struct Probe {
    x: f64,
    z: f64,
    /// Height there before the snowfall, quanta.
    bare: f64,
}

impl Falling<'_> {
    /// Drops grains until the snow is `depth` quanta deep.
    pub(super) fn until_deep(&mut self, depth: f64) -> Result<(), GrainsError> {
        let probes = probes(&self.drop, &self.all_stacks());
        if probes.is_empty() {
            return Err(GrainsError::setting(
                "depth",
                "cannot be reached: nothing lies under the area that is level enough for snow; \
                 move `area` or raise `max_slope`",
            ));
        }
        let PlanRectangle { min, max } = self.drop.area;
        let area =
            (f64::from(max[0]) - f64::from(min[0])) * (f64::from(max[1]) - f64::from(min[1]));
        let radius = self.drop.radii.mean();
        let layer = area / (core::f64::consts::PI * radius * radius);
        let fill = FIRST_BATCH_FILL.min(0.25 * self.fill);
        let mut batch = fill * 0.75 * layer * depth / radius;
        loop {
            let wanted = self.report.accepted + batch.max(layer * LEAST_BATCH).ceil() as u64;
            self.until(wanted)?;
            let reached = mean_depth(&probes, &self.drop, &self.all_stacks());
            if reached >= depth {
                return Ok(());
            }
            let remaining = (depth - reached) / reached.max(0.1 * depth);
            batch = 0.5 * remaining * self.report.accepted as f64;
        }
    }
}

impl Falling<'_> {
    fn all_stacks(&self) -> Vec<&GrainStacks> {
        std::iter::once(&*self.stacks).chain(self.others.iter().copied()).collect()
    }
}

fn probes(drop: &Drop<'_>, stacks: &[&GrainStacks]) -> Vec<Probe> {
    let PlanRectangle { min, max } = drop.area;
    let at = |index: i32, axis: usize| {
        let part = (f64::from(index) + 0.5) / f64::from(POINTS);
        f64::from(min[axis]) + part * (f64::from(max[axis]) - f64::from(min[axis]))
    };
    let mut probes = Vec::new();
    for row in 0..POINTS {
        for column in 0..POINTS {
            let (x, z) = (at(column, 0), at(row, 1));
            if let Some((bare, cosine)) = surface(drop, stacks, x, z)
                && cosine >= drop.least_cosine
            {
                probes.push(Probe { x, z, bare });
            }
        }
    }
    probes
}

/// Height of what a ray from above meets, and, on solid ground, the y of its normal (1 on grains).
fn surface(drop: &Drop<'_>, stacks: &[&GrainStacks], x: f64, z: f64) -> Option<(f64, f64)> {
    let contact = |stacks: &&GrainStacks| stacks.first_contact(&Fall::from_above(x, z, 0.0));
    let snow = stacks.iter().filter_map(contact).map(|hit| hit.height).reduce(f64::max);
    match drop.ground.ray_down(x, z, snow.unwrap_or(f64::NEG_INFINITY)) {
        Some(ground) => Some((ground.height, ground.normal.y)),
        None => snow.map(|height| (height, 1.0)),
    }
}

fn mean_depth(probes: &[Probe], drop: &Drop<'_>, stacks: &[&GrainStacks]) -> f64 {
    let mut sum = 0.0;
    for probe in probes {
        if let Some((height, _)) = surface(drop, stacks, probe.x, probe.z) {
            sum += height - probe.bare;
        }
    }
    sum / probes.len() as f64
}
