//! The grains that lie, by size: what falling grains meet.
//!
//! Each class of sizes has stacks of its own with cells of its size, so that fine snow on coarse
//! grains, or the other way round, costs hardly more than either alone. While a snowfall lasts it
//! changes the stacks of its own class only.

use crate::GrainsError;
use snowgrain_accel::{Fall, FallHit, GrainSlot, GrainStacks, Quad, StackRegion};
use snowgrain_geometry::QuantisedGrain;
use snowgrain_math::DVec3;

/// Grains share stacks that were made for others as long as their largest is between this part ...
const LEAST_OF_CLASS: f64 = 0.5;
/// ... and this multiple of the others' largest.
const MOST_OF_CLASS: f64 = 1.5;

/// Stacks for grains of about one size.
#[derive(Clone, Debug)]
pub(super) struct SizeClass {
    /// Largest radius that they were made for, quanta.
    radius: u16,
    pub(super) stacks: GrainStacks,
}

/// All stacks.
#[derive(Clone, Debug, Default)]
pub(super) struct Pile {
    classes: Vec<SizeClass>,
}

impl Pile {
    /// Index of the stacks for grains up to `radius`; new ones are made by `make`, which is given
    /// their number, where no others fit.
    pub(super) fn class_for(
        &mut self,
        radius: u16,
        make: impl FnOnce(u8) -> Result<GrainStacks, GrainsError>,
    ) -> Result<usize, GrainsError> {
        let fits = |class: &SizeClass| {
            let ratio = f64::from(radius) / f64::from(class.radius);
            (LEAST_OF_CLASS..=MOST_OF_CLASS).contains(&ratio)
        };
        if let Some(index) = self.classes.iter().position(fits) {
            return Ok(index);
        }
        let stacks = make(self.classes.len() as u8)?;
        self.classes.push(SizeClass { radius: radius.max(1), stacks });
        Ok(self.classes.len() - 1)
    }

    pub(super) fn stacks(&mut self, class: usize) -> &mut GrainStacks {
        &mut self.classes[class].stacks
    }

    pub(super) fn all(&self) -> impl Iterator<Item = &GrainStacks> {
        self.classes.iter().map(|class| &class.stacks)
    }

    pub(super) fn all_mut(&mut self) -> impl Iterator<Item = &mut GrainStacks> {
        self.classes.iter_mut().map(|class| &mut class.stacks)
    }

    pub(super) fn into_stacks(self) -> Vec<GrainStacks> {
        self.classes.into_iter().map(|class| class.stacks).collect()
    }

    /// The stacks of `class`, and all others.
    pub(super) fn split(&mut self, class: usize) -> (&mut GrainStacks, Vec<&GrainStacks>) {
        let (before, rest) = self.classes.split_at_mut(class);
        let (own, after) = rest.split_at_mut(1);
        let others = before.iter().chain(after.iter()).map(|class| &class.stacks).collect();
        (&mut own[0].stacks, others)
    }
}

/// What one thread's grains can meet: a region of the stacks that grow, and all others.
pub(super) struct Lying<'p, 'r> {
    pub(super) region: &'p StackRegion<'r>,
    pub(super) others: &'p [&'p GrainStacks],
}

impl Lying<'_, '_> {
    /// The first grain that `fall` meets.
    pub(super) fn first_contact(&self, fall: &Fall<'_>) -> Option<FallHit> {
        self.region_and_others(self.region.first_contact(fall), fall)
    }

    /// The same, with the cells of its line looked up.
    #[inline]
    pub(super) fn first_contact_at(&self, quad: &Quad, fall: &Fall<'_>) -> Option<FallHit> {
        self.region_and_others(self.region.first_contact_at(quad, fall), fall)
    }

    #[inline(always)]
    fn region_and_others(&self, mut first: Option<FallHit>, fall: &Fall<'_>) -> Option<FallHit> {
        for stacks in self.others {
            let down_to = first.map_or(fall.down_to, |hit| hit.height);
            first = stacks.first_contact(&Fall { down_to, ..*fall }).or(first);
        }
        first
    }

    /// All grains whose surface comes within `reach` of `center`.
    pub(super) fn near(
        &self,
        center: DVec3,
        reach: f64,
        out: &mut Vec<(GrainSlot, QuantisedGrain)>,
    ) {
        self.region.near(center, reach, out);
        for stacks in self.others {
            stacks.near(center, reach, out);
        }
    }
}
