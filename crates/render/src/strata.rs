//! Snow of which some bodies have impurities of their own.

use snowgrain_accel::STRATA;
use snowgrain_optics::Impurity;

/// The impurities of each stratum from 1 on, and the stratum of each body of snow: 0 where it has no
/// impurities of its own. Bodies with the same impurities are one stratum.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Strata {
    /// Of strata 1, 2, ...
    pub loads: Vec<Vec<Impurity>>,
    of_body: Vec<u8>,
}

impl Strata {
    /// Of bodies with these impurities; `None` where more than [`STRATA`] differ.
    #[must_use]
    pub fn of(bodies: &[Vec<Impurity>]) -> Option<Self> {
        let mut strata = Self::default();
        for impurities in bodies {
            let stratum = if impurities.is_empty() {
                0
            } else if let Some(at) = strata.loads.iter().position(|known| known == impurities) {
                at + 1
            } else {
                strata.loads.push(impurities.clone());
                strata.loads.len()
            };
            strata.of_body.push(stratum as u8);
        }
        (strata.loads.len() <= STRATA).then_some(strata)
    }

    /// The stratum of a body.
    pub(crate) fn of_body(&self, body: usize) -> u8 {
        self.of_body.get(body).copied().unwrap_or(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use snowgrain_optics::{ImpurityKind, Load};

    #[test]
    fn bodies_with_the_same_impurities_are_one_stratum_and_clean_ones_none() {
        let soot = |ppb: f64| {
            let load = Load::MassFraction(ppb * 1e-9);
            vec![Impurity { kind: ImpurityKind::BlackCarbon, load }]
        };
        let strata = Strata::of(&[soot(1.0), vec![], soot(2.0), soot(1.0)]).unwrap();
        assert_eq!(strata.of_body, [1, 0, 2, 1]);
        assert_eq!(strata.loads, [soot(1.0), soot(2.0)]);
        let many: Vec<_> = (1..9).map(|ppb| soot(f64::from(ppb))).collect();
        assert_eq!(Strata::of(&many), None);
    }
}
