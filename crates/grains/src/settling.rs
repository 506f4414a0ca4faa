//! How the grains of a snowfall come to rest: a rule, and what of it is tuned so that a density is reached.

use crate::DepositRule;
use std::fmt;

/// How grains come to rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Settling {
    /// [`DepositRule::Ray`].
    Ray,
    /// [`DepositRule::Stick`].
    Stick,
    /// [`DepositRule::Roll`].
    Roll,
    /// Aggregates of grains fall, turned at random, and stick at their first contact.
    Aggregates {
        /// Mean number of grains of an aggregate, at least 1: the next lower and the next higher whole
        /// number are mixed.
        grains: f64,
    },
    /// Grains roll as under [`Self::Roll`], but may stick at each contact and at the end of each arc. (Were
    /// it decided once a grain, those that roll would sink through the branches of those that stick,
    /// and snow would be dense below and loose above.)
    StickOrRoll {
        /// Probability with which a grain rolls on each time.
        roll: f64,
    },
    /// Grains roll to a stable rest, each with a part of its radius, and are full size afterwards: what
    /// touched overlaps, as grains do that sintered.
    Sinter {
        /// That part: while it falls, a grain of radius r touches others within `touch` r of its centre.
        touch: f64,
    },
}

impl Settling {
    /// The rule as it is, where no density is asked for.
    #[must_use]
    pub fn of_rule(rule: DepositRule) -> Self {
        match rule {
            DepositRule::Ray => Self::Ray,
            DepositRule::Stick => Self::Stick,
            DepositRule::Roll => Self::Roll,
        }
    }

    /// How far from its line of fall a grain may meet others, where none has a larger radius.
    pub(crate) fn reach(self, radius: f64) -> f64 {
        match self {
            Self::Ray => radius,
            Self::Stick
            | Self::Roll
            | Self::Aggregates { .. }
            | Self::StickOrRoll { .. }
            | Self::Sinter { .. } => 2.0 * radius,
        }
    }

    /// How far beside it a falling or rolling grain may ask for surfaces.
    pub(crate) fn surface_reach(self, radius: f64) -> f64 {
        match self {
            Self::Ray => 0.0,
            Self::Stick | Self::Aggregates { .. } => radius,
            // The ball around half a turn over another grain, grown by the radius.
            Self::Roll | Self::StickOrRoll { .. } | Self::Sinter { .. } => 4.0 * radius,
        }
    }

    /// Whether grains overlap by more than rounding.
    #[must_use]
    pub fn overlaps(self) -> bool {
        match self {
            Self::Ray | Self::Sinter { .. } => true,
            Self::Stick | Self::Roll | Self::Aggregates { .. } | Self::StickOrRoll { .. } => false,
        }
    }
}

impl fmt::Display for Settling {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Ray => write!(f, "grains one radius from where a ray meets snow"),
            Self::Stick => write!(f, "grains that stick at their first contact"),
            Self::Roll => write!(f, "grains that roll to a stable rest"),
            Self::Aggregates { grains } => {
                write!(f, "aggregates of {grains:.1} grains that stick at their first contact")
            }
            Self::StickOrRoll { roll } => write!(
                f,
                "grains that at each contact roll on with probability {roll:.3}, else stick"
            ),
            Self::Sinter { touch } => write!(
                f,
                "grains that roll to a stable rest and sinter: neighbours overlap by {:.1} % of the \
                 radius",
                100.0 * (1.0 - touch)
            ),
        }
    }
}
