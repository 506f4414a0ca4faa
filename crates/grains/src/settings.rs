//! What a user asks of snow: resolved, in metres, checked by the functions that take it.

use crate::{GrainsError, Radii};

/// Density of ice, kg/m^3.
pub const ICE_DENSITY: f64 = 917.0;

/// How much snow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Amount {
    /// Until this many grains lie.
    Grains(u64),
    /// Until the snow is this deep on level ground, metres (mean top of the pile over the area).
    Depth(f64),
}

/// Where a falling grain comes to rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum DepositRule {
    /// The paper's: a ray straight down, the grain's centre one radius along the normal of the hit.
    Ray,
    /// The falling sphere itself stops at its first contact.
    Stick,
    /// The falling sphere rolls over its contacts to a stable rest.
    Roll,
}

/// A snowfall.
#[derive(Clone, Debug, PartialEq)]
pub struct DepositSettings {
    /// How much.
    pub amount: Amount,
    /// Grain sizes.
    pub radii: Radii,
    /// Wanted density of the snow, kg/m^3 of ice union (ice is 917) between 20 and 80 % of its depth, or
    /// what the rule gives.
    pub density: Option<f64>,
    /// Where grains stop; `None`: as the density asks, or by the paper's rule where none is asked.
    pub rule: Option<DepositRule>,
    /// A grain whose contact normal is steeper than this many degrees from straight up is
    /// discarded (the paper's cliffs); 0..=90.
    pub max_slope_degrees: f64,
    /// Rectangle that grains fall on, `[x0, z0, x1, z1]` metres: where their lines of fall cross
    /// the plane y = 0. `None`: box of the finite objects, seen along the fall, plus a margin.
    pub area: Option<[f64; 4]>,
    /// Direction in which grains fall, of any length: straight down, or driven by a steady wind.
    /// Must point downwards, by at least a tenth of its length.
    pub direction: [f64; 3],
    /// Seed of the snowfall.
    pub seed: u64,
}

impl DepositSettings {
    /// Straight down.
    pub const DOWN: [f64; 3] = [0.0, -1.0, 0.0];
    /// Least part of the direction of fall that must point downwards: about 6 degrees.
    pub const LEAST_DESCENT: f64 = 0.1;

    /// How far along x and z a falling grain is from where it will be one length lower.
    #[must_use]
    pub fn drift(&self) -> [f64; 2] {
        let [x, y, z] = self.direction;
        // Not -0, so that straight down is one direction.
        [x / y + 0.0, z / y + 0.0]
    }

    fn check_direction(&self) -> Result<(), GrainsError> {
        let [x, y, z] = self.direction;
        let length = (x * x + y * y + z * z).sqrt();
        if !(length.is_finite() && -y >= Self::LEAST_DESCENT * length && y < 0.0) {
            let reason = format!(
                "[{x}, {y}, {z}] must point downwards: its y must be negative and at least a tenth \
                 of its length, as in [0.3, -1, 0]"
            );
            return Err(GrainsError::setting("direction", reason));
        }
        Ok(())
    }

    /// The same with another density, kg/m^3.
    pub(crate) fn with_density(&self, density: f64) -> Self {
        Self { density: Some(density), ..self.clone() }
    }

    /// Where grains stop while nothing is said of the density.
    pub(crate) fn plain_rule(&self) -> DepositRule {
        self.rule.unwrap_or(DepositRule::Ray)
    }

    /// # Errors
    /// The first setting that means nothing, or a radius above `largest_radius` (metres), the
    /// largest that the scene's quantisation was made for.
    pub fn check(&self, largest_radius: f64) -> Result<(), GrainsError> {
        self.radii.check()?;
        let largest = self.radii.largest();
        if largest > largest_radius * (1.0 + 1e-9) {
            let reason =
                format!("goes up to {largest} m, but grains here up to {largest_radius} m");
            return Err(GrainsError::setting("radius", reason));
        }
        if let Amount::Depth(depth) = self.amount
            && !(depth > 0.0 && depth.is_finite())
        {
            let reason = format!("is {depth} m, but must be a positive finite length");
            return Err(GrainsError::setting("depth", reason));
        }
        if !(0.0..=90.0).contains(&self.max_slope_degrees) {
            let reason = format!("is {} degrees, but must be in 0..=90", self.max_slope_degrees);
            return Err(GrainsError::setting("max_slope", reason));
        }
        self.check_direction()?;
        check_density(self.density)?;
        if let Some([x0, z0, x1, z1]) = self.area
            && !(x0 < x1 && z0 < z1 && [x0, z0, x1, z1].iter().all(|v| v.is_finite()))
        {
            let reason =
                format!("[{x0}, {z0}, {x1}, {z1}] must be [x0, z0, x1, z1], x0 < x1, z0 < z1");
            return Err(GrainsError::setting("area", reason));
        }
        Ok(())
    }
}

/// # Errors
/// A density that snow cannot have.
fn check_density(density: Option<f64>) -> Result<(), GrainsError> {
    match density {
        Some(density) if !(density > 0.0 && density <= ICE_DENSITY) => Err(GrainsError::setting(
            "density",
            format!(
                "is {density} kg/m3, but must lie above 0 and up to that of ice, {ICE_DENSITY}"
            ),
        )),
        _ => Ok(()),
    }
}

/// Crystal lattices of spheres.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum LatticeKind {
    /// Simple cubic: 1 grain a conventional cell.
    Sc,
    /// Body-centred cubic: 2.
    Bcc,
    /// Face-centred cubic (tightest): 4.
    Fcc,
    /// Hexagonal close packed (tightest), in its orthogonal cell: 4.
    Hcp,
}

impl LatticeKind {
    /// Grains of a conventional cell.
    #[must_use]
    pub fn grains_per_cell(self) -> u64 {
        match self {
            Self::Sc => 1,
            Self::Bcc => 2,
            Self::Fcc | Self::Hcp => 4,
        }
    }
}

/// A block of a crystal lattice that fills the box from `origin`.
#[derive(Clone, Debug, PartialEq)]
pub struct LatticeSettings {
    /// Which lattice.
    pub kind: LatticeKind,
    /// Conventional cells along x, y, z; each >= 1.
    pub counts: [u32; 3],
    /// Grain radius, metres.
    pub radius: f64,
    /// Distance between nearest neighbours, metres; `None`: touching (2 radius), or what `density`
    /// asks for.
    pub spacing: Option<f64>,
    /// Wanted density, kg/m^3: sets the spacing, or, where that is given too, the part of the
    /// grains that is kept.
    pub density: Option<f64>,
}

impl LatticeSettings {
    /// Grains of the full lattice.
    #[must_use]
    pub fn full_count(&self) -> u64 {
        self.counts.iter().fold(self.kind.grains_per_cell(), |n, &c| n.saturating_mul(c.into()))
    }

    /// # Errors
    /// The first setting that means nothing.
    pub fn check(&self) -> Result<(), GrainsError> {
        Radii::equal(self.radius).check()?;
        if self.counts.contains(&0) {
            return Err(GrainsError::setting("counts", "must each be at least 1"));
        }
        if let Some(spacing) = self.spacing
            && !(spacing >= self.radius && spacing.is_finite())
        {
            let reason = format!(
                "is {spacing} m, but must be finite and at least the radius, {} m",
                self.radius
            );
            return Err(GrainsError::setting("spacing", reason));
        }
        check_density(self.density)
    }
}
