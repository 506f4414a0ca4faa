//! What a user asks of snow: resolved, in metres, checked by the functions that take it.

/// Radii of grains: uniform between `mean - variation` and `mean + variation` (the paper, section
/// 4.1), metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Radii {
    /// Mean radius r, metres, > 0.
    pub mean: f64,
    /// Half-width r_sigma of the uniform distribution, metres, between 0 and `mean`.
    pub variation: f64,
}

impl Radii {
    /// Largest radius that can be drawn, metres.
    #[must_use]
    pub fn largest(&self) -> f64 {
        self.mean + self.variation
    }
}

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
    /// Wanted density of the snow, kg/m^3 of ice union (ice is 917), or what the rule gives.
    pub density: Option<f64>,
    /// Where grains stop.
    pub rule: DepositRule,
    /// A grain whose contact normal is steeper than this many degrees from straight up is
    /// discarded (the paper's cliffs); 0..=90.
    pub max_slope_degrees: f64,
    /// Rectangle that grains fall on, `[x0, z0, x1, z1]` metres; `None`: box of the finite objects
    /// plus a margin.
    pub area: Option<[f64; 4]>,
    /// Seed of the snowfall.
    pub seed: u64,
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
    /// Wanted density, kg/m^3: sets the spacing.
    pub density: Option<f64>,
}
