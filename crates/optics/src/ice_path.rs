//! The ice that a path has crossed.

use snowgrain_math::trig;

/// Length in ice along a light path. Ice turns no light and absorbs little of it in the visible,
/// so a path carries this length instead of a colour, and one path serves every absorption
/// (white Monte Carlo, contract 3 of `ARCHITECTURE.md`).
///
/// ```
/// use snowgrain_optics::IcePath;
/// let mut path = IcePath::default();
/// path.add(0.25);
/// path.add(0.75);
/// assert!((path.transmittance(2.0) - 0.1353352832366127).abs() < 1e-15);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct IcePath {
    /// Metres.
    pub length: f64,
}

impl IcePath {
    /// Adds a stretch of `length` metres.
    pub fn add(&mut self, length: f64) {
        self.length += length;
    }

    /// The fraction of light that is left, `exp(-absorption * length)` (Beer, Lambert), for an
    /// absorption coefficient in 1/m, >= 0.
    #[must_use]
    pub fn transmittance(self, absorption_per_metre: f64) -> f64 {
        trig::exp(-absorption_per_metre * self.length)
    }
}
