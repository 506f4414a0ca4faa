//! Where a rolling grain looked for others, and whether it would have seen one more.

use super::rules::center;
use snowgrain_accel::GrainStacks;
use snowgrain_geometry::QuantisedGrain;
use snowgrain_math::DVec3;

/// Quanta by which a look is taken to reach farther than it did, against rounding.
const MARGIN: f64 = 1.0;

/// One question that a rolling grain asked of what lies; quanta.
#[derive(Clone, Copy, Debug)]
pub(super) enum Look {
    /// What does a sphere meet first on the line of fall through this place of the plan? It was
    /// followed between these heights of its centre.
    Line { place: [f64; 2], from: f64, to: f64, radius: f64 },
    /// What comes within `reach` of a point?
    Ball { center: DVec3, reach: f64 },
}

/// A grain that came to rest.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rest {
    pub(super) grain: QuantisedGrain,
    /// Its place on the plan, in the period around 0.
    pub(super) place: [f64; 2],
}

/// The rectangle of the plan that holds the places of all grains that some looks may see.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shadow {
    pub(super) low: [f64; 2],
    pub(super) high: [f64; 2],
}

/// The direction of fall, and how the plan repeats.
#[derive(Clone, Copy, Debug)]
pub(super) struct Space {
    drift: [f64; 2],
    /// Height gained per length along a line of fall.
    rise: f64,
    /// Half-widths of the shadow on the plan of a unit ball.
    unit_shadow: [f64; 2],
    largest_radius: f64,
    period: Option<[f64; 2]>,
}

impl Space {
    pub(super) fn of(stacks: &GrainStacks) -> Self {
        let drift @ [x, z] = stacks.drift();
        Self {
            drift,
            rise: 1.0 / (1.0 + x * x + z * z).sqrt(),
            unit_shadow: drift.map(|d| (1.0 + d * d).sqrt()),
            largest_radius: stacks.largest_radius().into(),
            period: stacks.period().map(|period| period.map(f64::from)),
        }
    }

    /// The image of a difference that is nearest to 0.
    fn folded(&self, difference: [f64; 2]) -> [f64; 2] {
        let Some(period) = self.period else { return difference };
        [0, 1].map(|axis| {
            let d = difference[axis];
            d - (d / period[axis]).round() * period[axis]
        })
    }

    /// The images of an interval along x that meet the period around 0.
    pub(super) fn images_along_x(&self, [low, high]: [f64; 2]) -> impl Iterator<Item = [f64; 2]> {
        let period = self.period.map(|[x, _]| x);
        let image_of = |x: f64| period.map_or(0.0, |period| (x / period).round()) as i64;
        let images = (low <= high).then(|| image_of(low)..=image_of(high)).into_iter().flatten();
        images.map(move |image| {
            let shift = image as f64 * period.unwrap_or(0.0);
            [low - shift, high - shift]
        })
    }

    fn on_plan(&self, point: DVec3) -> [f64; 2] {
        [point.x - point.y * self.drift[0], point.z - point.y * self.drift[1]]
    }

    pub(super) fn rest(&self, grain: QuantisedGrain) -> Rest {
        Rest { grain, place: self.folded(self.on_plan(center(grain))) }
    }

    pub(super) fn shadow_of(&self, looks: &[Look]) -> Shadow {
        let mut shadow = Shadow { low: [f64::INFINITY; 2], high: [f64::NEG_INFINITY; 2] };
        for look in looks {
            let (place, reach) = match *look {
                Look::Line { place, radius, .. } => (place, radius),
                Look::Ball { center, reach } => (self.on_plan(center), reach),
            };
            for (axis, place) in place.into_iter().enumerate() {
                let half = (reach + self.largest_radius + 2.0 * MARGIN) * self.unit_shadow[axis];
                shadow.low[axis] = shadow.low[axis].min(place - half);
                shadow.high[axis] = shadow.high[axis].max(place + half);
            }
        }
        shadow
    }

    /// Whether any of `looks`, with this shadow, would have seen the grain.
    pub(super) fn is_seen(&self, shadow: &Shadow, looks: &[Look], rest: &Rest) -> bool {
        let from_middle = self.folded(
            [0, 1].map(|axis| rest.place[axis] - 0.5 * (shadow.low[axis] + shadow.high[axis])),
        );
        let beside =
            |axis: usize| 2.0 * from_middle[axis].abs() > shadow.high[axis] - shadow.low[axis];
        !beside(0) && !beside(1) && looks.iter().any(|look| self.sees(look, rest.grain))
    }

    fn sees(&self, look: &Look, grain: QuantisedGrain) -> bool {
        let at = center(grain);
        match *look {
            Look::Line { place, from, to, radius } => {
                let on_plan = self.on_plan(at);
                let [x, z] = self.folded([place[0] - on_plan[0], place[1] - on_plan[1]]);
                let along = (x * self.drift[0] + z * self.drift[1]) * self.rise;
                let reach = f64::from(grain.radius) + radius + MARGIN;
                let square = reach * reach - (x * x + z * z - along * along);
                let height = at.y + self.rise * (square.max(0.0).sqrt() - along);
                square >= 0.0 && height > to - MARGIN && height <= from + MARGIN
            }
            Look::Ball { center, reach } => {
                let d = at - center;
                let [x, z] = self.folded([d.x, d.z]);
                let reach = f64::from(grain.radius) + reach + MARGIN;
                x * x + d.y * d.y + z * z <= reach * reach
            }
        }
    }
}
