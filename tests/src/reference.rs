//! Published or precomputed figures that several tests compare with, each with its source.

/// One row of the project's reference table of slabs, whose head says what it holds
/// (`data/packing_slab.csv`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlabRow {
    /// Grain surface seen from above per area.
    pub tau: f64,
    /// Fraction reflected.
    pub reflectance: f64,
    /// Fraction transmitted.
    pub transmittance: f64,
    /// Standard error of both.
    pub standard_error: f64,
    /// Mean grain visits.
    pub visits: f64,
    /// Mean interface events per visit.
    pub events_per_visit: f64,
}

impl SlabRow {
    /// Layers of a lattice of touching grains: each adds pi/4 to tau.
    #[must_use]
    pub fn layers(&self) -> u32 {
        (self.tau / core::f64::consts::FRAC_PI_4).round() as u32
    }
}

/// Light of a row of the table of slabs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TableLight {
    /// From all sides with equal radiance.
    Lambertian,
    /// Parallel; the cosine of its angle from the vertical.
    Parallel(f64),
}

/// The rows of a packing ("sc", "fcc", "bd_stick") under this light, by rising tau; none where the
/// table has none.
#[must_use]
pub fn slab_rows(packing: &str, light: TableLight) -> Vec<SlabRow> {
    let wanted = match light {
        TableLight::Lambertian => -1.0,
        TableLight::Parallel(cosine) => cosine,
    };
    include_str!("../data/packing_slab.csv")
        .lines()
        .filter(|line| !line.starts_with('#'))
        .skip(1)
        .filter_map(|line| {
            let mut fields = line.split(',');
            if fields.next() != Some(packing) {
                return None;
            }
            let number = |field: &str| field.parse().expect("the table holds numbers");
            let values: Vec<f64> = fields.map(number).collect();
            let [tau, mu0, _, reflectance, transmittance, standard_error, visits, events_per_visit] =
                values.try_into().expect("the table has nine columns");
            (mu0 == wanted).then_some(SlabRow {
                tau,
                reflectance,
                transmittance,
                standard_error,
                visits,
                events_per_visit,
            })
        })
        .collect()
}

/// The benchmark cube ([`crate::cube`]), index 1.31, 256 x 256 pixels: side N, and the mean
/// radiance of the interior pixels and of all pixels on the hull [0, N]^3, by a double-precision
/// walker of the lattice's cells, given to four and three decimals.
pub const CUBE_RADIANCE: [(u32, f64, f64); 3] =
    [(32, 0.4063, 0.372), (64, 0.4947, 0.472), (120, 0.5571, 0.543)];
