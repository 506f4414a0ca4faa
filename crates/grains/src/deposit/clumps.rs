//! Aggregates that fall: each turned at random, along its line of fall, until one of its grains meets
//! what lies. They are followed one after another: several times as fast as rolling on all threads.

use super::rules::{Drop, center};
use super::{Falling, aggregates};
use crate::GrainsError;
use snowgrain_accel::{Fall, GrainStacks, GrainStacksError};
use snowgrain_geometry::QuantisedGrain;
use snowgrain_math::DVec3;

/// Aggregates followed between two looks at how much lies.
const AGGREGATES: u64 = 1 << 14;

/// Where an aggregate comes to rest.
enum Rest {
    /// With its middle here, quanta.
    Lies(DVec3),
    TooSteep,
    Missed,
}

impl Falling<'_> {
    /// Lets aggregates of `mean` grains fall, until `most` grains more lie or some time has passed.
    pub(super) fn batch_of_aggregates(&mut self, mean: f64, most: u64) -> Result<(), GrainsError> {
        let wanted = self.report.accepted + most;
        let mut shape = Vec::new();
        for _ in 0..AGGREGATES {
            let left = wanted - self.report.accepted;
            if left == 0 {
                break;
            }
            let index = self.drops;
            let count = aggregates::size(&self.drop, mean, index).min(left);
            aggregates::shape(&self.drop, count, index, &mut shape);
            self.drops += 1;
            self.drops_since_success += 1;
            match rest(&self.drop, self.stacks, &self.others, &shape, index) {
                Rest::Lies(middle) => {
                    for member in &shape {
                        let at = middle + center(*member);
                        store(self.stacks, self.drop.rounded(at, member.radius)?)?;
                    }
                    self.report.accepted += count;
                    self.drops_since_success = 0;
                }
                Rest::TooSteep => self.report.discarded += count,
                Rest::Missed => self.report.missed += count,
            }
        }
        Ok(())
    }
}

/// Follows an aggregate until it meets something.
fn rest(
    drop: &Drop<'_>,
    stacks: &GrainStacks,
    others: &[&GrainStacks],
    shape: &[QuantisedGrain],
    index: u64,
) -> Rest {
    let start = drop.start(index);
    let (x, z) = (f64::from(start.x), f64::from(start.z));
    let [drift_x, drift_z] = stacks.drift();
    let mut found: Option<(f64, DVec3)> = None;
    for member in shape {
        let (offset, radius) = (center(*member), f64::from(member.radius));
        let [x, z] = [x + offset.x - offset.y * drift_x, z + offset.z - offset.y * drift_z];
        let mut down_to = found.map_or(f64::NEG_INFINITY, |(height, _)| height + offset.y);
        for stacks in std::iter::once(stacks).chain(others.iter().copied()) {
            let fall = Fall { down_to, ..Fall::from_above(x, z, radius) };
            if let Some(hit) = stacks.first_contact(&fall) {
                down_to = hit.height;
                let normal = (stacks.point(x, z, hit.height) - center(hit.grain)).normalize();
                found = Some((hit.height - offset.y, normal));
            }
        }
        if let Some(ground) = drop.ground.drop_sphere(x, z, radius, [f64::INFINITY, down_to]) {
            found = Some((ground.height - offset.y, ground.normal));
        }
    }
    match found {
        None => Rest::Missed,
        Some((_, normal)) if normal.y < drop.least_cosine => Rest::TooSteep,
        // Up to a whole quantum, so that nothing overlaps where the fall is straight down.
        Some((height, _)) => Rest::Lies(stacks.point(x, z, height.ceil())),
    }
}

/// Stores a grain, wherever it lies.
fn store(stacks: &mut GrainStacks, grain: QuantisedGrain) -> Result<(), GrainsError> {
    match stacks.push(grain) {
        Err(GrainStacksError::OutsideArea) => {
            stacks.cover_grain(grain, 32 * i32::from(grain.radius.max(1)))?;
            stacks.push(grain)?;
        }
        stored => {
            stored?;
        }
    }
    Ok(())
}
