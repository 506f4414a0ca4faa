//! The density that pilots are asked for, so that the snow itself has the one that is wanted.

use snowgrain_math::trig;

/// Most falls of the same snow in search of its density.
pub(crate) const MOST_FALLS: u32 = 6;
/// Relative difference at which snow that was measured does not fall anew.
const CLOSE_ENOUGH: f64 = 0.01;
/// Most by which the aim moves at once, as a logarithm.
const LONGEST_STEP: f64 = core::f64::consts::LN_2;

/// A fall: logarithms of what pilots were asked for, and of what the snow had, each over what is wanted.
#[derive(Clone, Copy)]
struct Fall {
    aim: f64,
    off: f64,
}

/// The search for an aim: while all snow is on one side of what is wanted, the aim moves by as much as the last
/// was off; then it is interpolated between the nearest falls of both sides (false position). The density of a
/// snow is not a smooth function of the aim, since each fall is another one; so the best one is kept.
pub(crate) struct Aim {
    wanted: f64,
    aim: f64,
    below: Option<Fall>,
    above: Option<Fall>,
}

impl Aim {
    /// Aims at what is wanted, kg/m^3.
    pub(crate) fn at(wanted: f64) -> Self {
        Self { wanted, aim: 0.0, below: None, above: None }
    }

    /// What pilots are asked for, kg/m^3.
    pub(crate) fn density(&self) -> f64 {
        self.wanted * trig::exp(self.aim)
    }

    /// How far this density is from what is wanted, as a logarithm.
    pub(crate) fn miss(&self, density: f64) -> f64 {
        trig::ln(density / self.wanted).abs()
    }

    /// Whether a density is close enough.
    pub(crate) fn is_met_by(&self, density: f64) -> bool {
        (density / self.wanted - 1.0).abs() <= CLOSE_ENOUGH
    }

    /// Aims anew after a fall gave this density, kg/m^3, above 0.
    pub(crate) fn correct(&mut self, density: f64) {
        let fall = Fall { aim: self.aim, off: trig::ln(density / self.wanted) };
        let side = if fall.off < 0.0 { &mut self.below } else { &mut self.above };
        if side.is_none_or(|known| fall.off.abs() < known.off.abs()) {
            *side = Some(fall);
        }
        self.aim = match (self.below, self.above) {
            (Some(low), Some(high)) => {
                (low.aim * high.off - high.aim * low.off) / (high.off - low.off)
            }
            _ => self.aim - fall.off.clamp(-LONGEST_STEP, LONGEST_STEP),
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The best of the densities that are met while the search goes on.
    fn best(wanted: f64, snow: impl Fn(f64) -> f64) -> f64 {
        let mut aim = Aim::at(wanted);
        let mut best = f64::INFINITY;
        for _ in 0..MOST_FALLS {
            let density = snow(aim.density());
            best = best.min(aim.miss(density));
            if aim.is_met_by(density) {
                break;
            }
            aim.correct(density);
        }
        best
    }

    #[test]
    fn an_aim_converges_whether_snow_answers_too_much_or_too_little() {
        for power in [0.5, 0.8, 1.0, 1.3, 1.8] {
            for factor in [0.8, 0.95, 1.1, 1.25] {
                let snow = |aim: f64| 250.0 * factor * trig::pow(aim / 250.0, power);
                let off = best(250.0, snow);
                assert!(off < 0.0101, "power {power}, factor {factor}: {off}");
            }
        }
    }

    #[test]
    fn a_density_that_jumps_is_left_at_its_nearer_side() {
        let off = best(100.0, |aim: f64| if aim < 98.0 { 0.97 * aim } else { 1.03 * aim });
        assert!(off < 0.05, "{off}");
    }
}
