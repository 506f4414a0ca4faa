//! Where grains fall, and the stacks that they fall on.

use super::{Snowfall, fill};
use crate::{DepositSettings, GrainsError, Settling};
use snowgrain_accel::{GrainStacks, PlanRectangle};
use snowgrain_geometry::{Quantisation, QuantisedGrain};
use snowgrain_math::{Aabb, DVec3};

/// Placed grains this many times smaller than the largest of them get stacks of their own.
const CLASS_RATIO: u16 = 8;

impl Snowfall<'_> {
    /// The plan rectangle that grains fall on: where their lines of fall cross y = 0 of the lattice.
    pub(super) fn area(&self, settings: &DepositSettings) -> Result<PlanRectangle, GrainsError> {
        if let Some([px, pz]) = self.ground.period() {
            return Ok(PlanRectangle { min: [0, 0], max: [px, pz] });
        }
        let rectangle = match settings.area {
            Some([x0, z0, x1, z1]) => {
                // The same lines, where they cross the lattice's plane instead of that of the world.
                let [dx, dz] = settings.drift().map(|drift| drift * self.quantisation.origin().y);
                [x0 + dx, z0 + dz, x1 + dx, z1 + dz]
            }
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

    /// The box of the finite surfaces, or of what lies, and a margin, seen along the fall.
    fn default_area(&self, settings: &DepositSettings) -> Result<[f64; 4], GrainsError> {
        let mut bounds = self.ground.bounds();
        if bounds.is_empty() {
            let lying =
                self.pile.all().flat_map(GrainStacks::iter).chain(self.placed.iter().copied());
            bounds = crate::field::bounds_of(lying, &self.quantisation);
        }
        if bounds.is_empty() {
            return Err(GrainsError::setting(
                "area",
                "is needed: there is no finite object whose box could be the default",
            ));
        }
        let bounds = bounds.expanded(2.0 * settings.radii.largest());
        let [drift_x, drift_z] = settings.drift();
        let seen = [bounds.min.y, bounds.max.y].map(|y| {
            let rise = y - self.quantisation.origin().y;
            let shift = DVec3::new(rise * drift_x, 0.0, rise * drift_z);
            Aabb::new(bounds.min - shift, bounds.max - shift)
        });
        let seen = seen[0].union(&seen[1]);
        Ok([seen.min.x, seen.min.z, seen.max.x, seen.max.z])
    }

    /// Puts everything placed so far on stacks of its size, and gives the stacks that grow, which
    /// cover `area` and grains that come to rest a little outside it.
    pub(super) fn prepare_stacks(
        &mut self,
        (settings, settling): (&DepositSettings, Settling),
        area: PlanRectangle,
    ) -> Result<usize, GrainsError> {
        let drift = settings.drift();
        self.lean(drift)?;
        let drawn = (settings.radii.largest() / self.quantisation.quantum()).round() as u16;
        let quantum = self.quantisation.quantum();
        let side = fill::cell_side((settings, settling), quantum, area, drawn.into());
        let class = self.class(grown(area, drawn), drawn, side, drift)?;
        let mut left = std::mem::take(&mut self.placed);
        while let Some(largest) = left.iter().map(|grain| grain.radius).max() {
            let (now, smaller): (Vec<_>, Vec<_>) =
                left.into_iter().partition(|grain| grain.radius > largest / CLASS_RATIO);
            left = smaller;
            let plan = plan_of(&now, drift);
            let side = (2 * u32::from(largest)).max(16) as u16;
            let class = self.class(grown(plan, largest), largest, side, drift)?;
            let stacks = self.pile.stacks(class);
            for grain in now {
                stacks.push(grain)?;
            }
        }
        self.pile.stacks(class).expect_radius(drawn);
        let level = self.simd_level;
        self.pile.all_mut().for_each(|stacks| stacks.set_level(level));
        Ok(class)
    }

    /// The stacks for grains of up to `radius`, covering `plan`.
    fn class(
        &mut self,
        plan: PlanRectangle,
        radius: u16,
        side: u16,
        drift: [f64; 2],
    ) -> Result<usize, GrainsError> {
        let ground = &self.ground;
        let class = self.pile.class_for(radius, |number| {
            Ok(ground.new_stacks(plan, side, drift)?.numbered(number))
        })?;
        self.pile.stacks(class).cover(plan)?;
        Ok(class)
    }

    /// Lets all stacks be seen along the direction of this fall: those of another are made anew.
    fn lean(&mut self, drift: [f64; 2]) -> Result<(), GrainsError> {
        if self.pile.all().all(|stacks| stacks.drift() == drift) {
            return Ok(());
        }
        let ground = &self.ground;
        for (number, stacks) in (0u8..).zip(self.pile.all_mut()) {
            let grains: Vec<QuantisedGrain> = stacks.iter().collect();
            let radius = stacks.largest_radius();
            let plan = grown(plan_of(&grains, drift), radius);
            let mut leaning = ground.new_stacks(plan, stacks.side(), drift)?.numbered(number);
            leaning.expect_radius(radius);
            for grain in grains {
                leaning.push(grain)?;
            }
            *stacks = leaning;
        }
        Ok(())
    }
}

/// The rectangle with a margin for grains of up to `radius` that come to rest beside it.
pub(super) fn grown(plan: PlanRectangle, radius: u16) -> PlanRectangle {
    let margin = 16 * i32::from(radius);
    PlanRectangle {
        min: plan.min.map(|low| low.saturating_sub(margin)),
        max: plan.max.map(|high| high.saturating_add(margin)),
    }
}

/// The rectangle of the plan places of grains.
fn plan_of(grains: &[QuantisedGrain], drift: [f64; 2]) -> PlanRectangle {
    let mut plan = PlanRectangle { min: [i32::MAX; 2], max: [i32::MIN; 2] };
    for QuantisedGrain { center: [x, y, z], .. } in grains {
        for (axis, coordinate) in [x, z].into_iter().enumerate() {
            let at = (f64::from(*coordinate) - f64::from(*y) * drift[axis]).floor() as i32;
            plan.min[axis] = plan.min[axis].min(at);
            plan.max[axis] = plan.max[axis].max(at);
        }
    }
    if grains.is_empty() { PlanRectangle { min: [0; 2], max: [1; 2] } } else { plan }
}
