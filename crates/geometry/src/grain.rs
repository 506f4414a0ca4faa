//! Grains of ice and the one lattice on which they are stored.
//!
//! Every position is rounded once, when a grain is born, to a global lattice of quanta; later
//! grains and all light meet the rounded grain, so what is stored is what is rendered, and a grain
//! decodes to the same place from every cell that it touches (contract 4).

use crate::GeometryError;
use snowgrain_math::DVec3;

/// A sphere of ice. Lengths in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grain {
    /// Centre.
    pub center: DVec3,
    /// Radius.
    pub radius: f64,
}

/// A [`Grain`] in quanta of a [`Quantisation`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct QuantisedGrain {
    /// Centre, in quanta from the lattice's origin.
    pub center: [i32; 3],
    /// Radius in quanta, at most [`Quantisation::MAX_RADIUS_QUANTA`].
    pub radius: u16,
}

/// The lattice on which all grains of a scene are rounded.
///
/// The quantum has at most 20 significant bits, so `index * quantum` is exact in `f64` and a file
/// that stores positions as doubles gives back the same indices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantisation {
    origin: DVec3,
    quantum: f64,
}

impl Quantisation {
    /// Quanta in the radius of the largest grain of a scene: fine enough that rounding moves a
    /// grain by less than 1.6e-4 of that radius, coarse enough that a cell of ten radii with a margin
    /// of one radius on either side still fits 16 bits (`snowgrain_accel::GrainGrid`).
    pub const MAX_RADIUS_QUANTA: u16 = 5_450;

    /// Farthest coordinate that may be used, in quanta; leaves room for cells around it.
    pub const MAX_COORDINATE: i32 = 1 << 30;

    /// The lattice for grains of at most `largest_radius` metres around `origin`.
    ///
    /// # Panics
    /// If `largest_radius` is not a positive finite number (callers check user input before).
    #[must_use]
    pub fn for_grains(origin: DVec3, largest_radius: f64) -> Self {
        assert!(largest_radius > 0.0 && largest_radius.is_finite());
        let quantum = round_up_to_20_bits(largest_radius / f64::from(Self::MAX_RADIUS_QUANTA));
        Self { origin, quantum }
    }

    /// The lattice with this origin and quantum (metres), as read from a file.
    #[must_use]
    pub fn from_parts(origin: DVec3, quantum: f64) -> Self {
        Self { origin, quantum }
    }

    /// Edge of a quantum, metres.
    #[must_use]
    pub fn quantum(&self) -> f64 {
        self.quantum
    }

    /// Origin, metres.
    #[must_use]
    pub fn origin(&self) -> DVec3 {
        self.origin
    }

    /// Largest radius that can be stored, metres.
    #[must_use]
    pub fn largest_radius(&self) -> f64 {
        f64::from(Self::MAX_RADIUS_QUANTA) * self.quantum
    }

    /// Rounds a grain to the lattice (ties away from zero).
    ///
    /// # Errors
    /// A radius that is not finite, too large, or so small that it rounds to nothing; a position out of reach.
    pub fn round(&self, center: DVec3, radius: f64) -> Result<QuantisedGrain, GeometryError> {
        let quanta = (radius / self.quantum).round();
        if !(quanta >= 1.0 && quanta <= f64::from(Self::MAX_RADIUS_QUANTA)) {
            let (smallest, largest) = (0.5 * self.quantum, self.largest_radius());
            return Err(GeometryError::BadRadius { radius, smallest, largest });
        }
        let p = ((center - self.origin) / self.quantum).round();
        let reach = f64::from(Self::MAX_COORDINATE);
        let within = p.abs().cmple(DVec3::splat(reach)).all();
        if !within {
            return Err(GeometryError::OutOfLattice {
                x: center.x,
                y: center.y,
                z: center.z,
                reach: reach * self.quantum,
            });
        }
        Ok(QuantisedGrain { center: [p.x as i32, p.y as i32, p.z as i32], radius: quanta as u16 })
    }

    /// The grain in metres.
    #[must_use]
    pub fn grain(&self, grain: QuantisedGrain) -> Grain {
        let [x, y, z] = grain.center.map(f64::from);
        Grain {
            center: self.origin + DVec3::new(x, y, z) * self.quantum,
            radius: f64::from(grain.radius) * self.quantum,
        }
    }
}

/// The least number with 20 significant bits that is not below `x`; `x > 0`.
fn round_up_to_20_bits(x: f64) -> f64 {
    const DROPPED: u64 = (1 << 33) - 1;
    let bits = x.to_bits();
    f64::from_bits(if bits & DROPPED == 0 { bits } else { (bits | DROPPED) + 1 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_survive_a_trip_through_doubles() {
        let lattice = Quantisation::for_grains(DVec3::new(0.1, -3.0, 7.3), 0.47e-3);
        for i in [-1_000_000_000, -12_345_677, -1, 0, 1, 99_999_999, 1 << 30] {
            let grain = QuantisedGrain { center: [i, -i, i / 2], radius: 5_000 };
            let metres = lattice.grain(grain);
            assert_eq!(lattice.round(metres.center, metres.radius), Ok(grain));
        }
    }

    #[test]
    fn bad_radii_and_far_positions_are_refused() {
        let lattice = Quantisation::for_grains(DVec3::ZERO, 1e-3);
        assert!(lattice.round(DVec3::ZERO, f64::NAN).is_err());
        assert!(lattice.round(DVec3::ZERO, -1e-3).is_err());
        assert!(lattice.round(DVec3::ZERO, 2e-3).is_err());
        assert!(lattice.round(DVec3::new(1e6, 0.0, 0.0), 1e-3).is_err());
        assert!(lattice.round(DVec3::new(f64::NAN, 0.0, 0.0), 1e-3).is_err());
    }
}
