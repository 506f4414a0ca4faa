//! Crystal lattices of spheres.
//!
//! Conventional cells stand along x, y, z and fill the box from the origin; the lowest grains touch
//! the planes x = 0, y = 0, z = 0 when neighbours touch (their least centre coordinate is half the
//! spacing). With spacing s between nearest neighbours the cells measure s (simple cubic), 2 s/3^½
//! (body-centred), 2^½ s (face-centred), and s x 3^½ s x (8/3)^½ s (hexagonal, orthogonal cell,
//! close-packed layers normal to z).

use crate::{GrainField, GrainsError, ICE_DENSITY, LatticeKind, LatticeSettings};
use snowgrain_geometry::{GeometryError, Quantisation, QuantisedGrain};
use snowgrain_math::sampler::split_mix;

/// Most grains of a lattice that is stored grain by grain.
const MOST_GRAINS: u64 = 1 << 32;

/// The conventional cell of a lattice on the quantisation lattice: the grain `b` of cell `i` (per
/// axis) lies exactly at `i * side_quanta + basis[b]`.
///
/// Sides are rounded to whole quanta such that touching neighbours stay apart: by less than three
/// quanta, 5e-4 of the radius, and not at all in the simple cubic lattice.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LatticeCell {
    /// Edges of the cell, quanta.
    pub side_quanta: [i32; 3],
    /// Grain centres of cell 0, quanta.
    pub basis: Vec<[i32; 3]>,
    /// Radius of every grain, quanta.
    pub radius: u16,
    /// Number of cells along each axis.
    pub counts: [u32; 3],
    /// Number of grains kept, of all `basis.len() * counts` of them; fewer where the settings give
    /// both a spacing and a lower density. Such a lattice has no implicit form.
    pub kept: u64,
}

impl LatticeCell {
    /// The cell for these settings.
    ///
    /// # Errors
    /// Settings without meaning; a density above that of the touching (or given) lattice, with the
    /// range that can be asked for; a lattice that reaches beyond the quantisation.
    pub fn new(
        settings: &LatticeSettings,
        quantisation: &Quantisation,
    ) -> Result<Self, GrainsError> {
        settings.check()?;
        let quantum = quantisation.quantum();
        let radius = (settings.radius / quantum).round();
        if !(1.0..=f64::from(Quantisation::MAX_RADIUS_QUANTA)).contains(&radius) {
            let (radius, largest) = (settings.radius, quantisation.largest_radius());
            let smallest = 0.5 * quantum;
            return Err(GeometryError::BadRadius { radius, smallest, largest }.into());
        }
        let spacing = spacing(settings)? / quantum;
        // A spacing of two radii means touching, whatever the two were rounded to.
        let touches = (spacing - 2.0 * radius).abs() <= 1.0;
        let spacing = if touches { 2.0 * radius } else { spacing };
        check_reach(settings.counts, 2.0 * spacing, quantum)?;
        let (side_quanta, basis) = cell(settings.kind, spacing);
        let mut cell = Self {
            side_quanta,
            basis,
            radius: radius as u16,
            counts: settings.counts,
            kept: settings.full_count(),
        };
        if let (Some(density), Some(given)) = (settings.density, settings.spacing) {
            if given < 2.0 * settings.radius * (1.0 - 1e-6) {
                let reason = "cannot be asked of grains that overlap; raise `spacing` to 2 radii";
                return Err(GrainsError::setting("density", reason));
            }
            let full = ICE_DENSITY * cell.solid_fraction();
            let part = density / full;
            if part > 1.0 + 1e-3 {
                return Err(too_dense(density, full));
            }
            cell.kept = (part.min(1.0) * cell.kept as f64).round() as u64;
        }
        Ok(cell)
    }

    /// Volume of the grains of a full cell over its volume (where grains do not overlap, the solid
    /// fraction of the ice).
    #[must_use]
    pub fn solid_fraction(&self) -> f64 {
        let radius = f64::from(self.radius);
        let [x, y, z] = self.side_quanta.map(f64::from);
        let sphere = 4.0 / 3.0 * core::f64::consts::PI * radius * radius * radius;
        self.basis.len() as f64 * sphere / (x * y * z)
    }

    /// The grains of the full lattice, cell by cell (x fastest, then y, then z).
    pub fn grains(&self) -> impl Iterator<Item = QuantisedGrain> + '_ {
        let [nx, ny, nz] = self.counts.map(u32::cast_signed);
        let cells =
            (0..nz).flat_map(move |k| (0..ny).flat_map(move |j| (0..nx).map(move |i| [i, j, k])));
        cells.flat_map(move |cell| {
            self.basis.iter().map(move |basis| QuantisedGrain {
                center: std::array::from_fn(|axis| {
                    cell[axis] * self.side_quanta[axis] + basis[axis]
                }),
                radius: self.radius,
            })
        })
    }
}

/// Refuses lattices whose cells, of at most `side` quanta, would leave the quantisation.
fn check_reach(counts: [u32; 3], side: f64, quantum: f64) -> Result<(), GrainsError> {
    let reach = f64::from(Quantisation::MAX_COORDINATE);
    let far = counts.map(|count| f64::from(count) * side);
    if far.iter().any(|&edge| edge > reach) {
        let [x, y, z] = far.map(|edge| edge * quantum);
        return Err(GeometryError::OutOfLattice { x, y, z, reach: reach * quantum }.into());
    }
    Ok(())
}

/// The grains of a lattice, cell by cell (x fastest, then y, then z). The lattice starts at the
/// quantisation's origin.
///
/// # Errors
/// As [`LatticeCell::new`]; more grains than can be stored one by one.
pub fn lattice_grains(
    settings: &LatticeSettings,
    quantisation: &Quantisation,
) -> Result<GrainField, GrainsError> {
    let cell = LatticeCell::new(settings, quantisation)?;
    let full = settings.full_count();
    if full > MOST_GRAINS {
        let reason = format!("make {full} grains, but at most {MOST_GRAINS} can be stored");
        return Err(GrainsError::setting("counts", reason));
    }
    let mut grains: Vec<_> = cell.grains().collect();
    if cell.kept < full {
        grains = thinned(grains, cell.kept as usize);
    }
    Ok(GrainField::new(*quantisation, grains))
}

/// Keeps the `kept` grains with the least hash of their index, in order.
fn thinned(grains: Vec<QuantisedGrain>, kept: usize) -> Vec<QuantisedGrain> {
    let mut ranks: Vec<u64> = (0..grains.len() as u64).map(split_mix).collect();
    if kept == 0 || kept >= ranks.len() {
        return if kept == 0 { Vec::new() } else { grains };
    }
    let (_, &mut greatest, _) = ranks.select_nth_unstable(kept - 1);
    (0u64..).zip(grains).filter(|&(i, _)| split_mix(i) <= greatest).map(|(_, g)| g).collect()
}

/// Distance between nearest neighbours, metres.
fn spacing(settings: &LatticeSettings) -> Result<f64, GrainsError> {
    let touching = 2.0 * settings.radius;
    match (settings.spacing, settings.density) {
        (Some(spacing), _) => Ok(spacing),
        (None, None) => Ok(touching),
        (None, Some(density)) => {
            let full = ICE_DENSITY * tightest_fraction(settings.kind);
            if density > full * (1.0 + 1e-3) {
                return Err(too_dense(density, full));
            }
            Ok(touching * cube_root(full / density).max(1.0))
        }
    }
}

fn too_dense(density: f64, full: f64) -> GrainsError {
    GrainsError::setting(
        "density",
        format!(
            "{density} kg/m3 is out of reach: this lattice gives up to {full:.1} kg/m3, and any \
             lower density; fcc and hcp, touching, give the most, 679 kg/m3"
        ),
    )
}

/// Solid fraction with touching neighbours.
fn tightest_fraction(kind: LatticeKind) -> f64 {
    use core::f64::consts::PI;
    match kind {
        LatticeKind::Sc => PI / 6.0,
        LatticeKind::Bcc => PI * 3.0f64.sqrt() / 8.0,
        LatticeKind::Fcc | LatticeKind::Hcp => PI * 2.0f64.sqrt() / 6.0,
    }
}

fn cube_root(x: f64) -> f64 {
    snowgrain_math::trig::pow(x, 1.0 / 3.0)
}

/// Edges and basis for nearest neighbours `spacing` quanta apart.
fn cell(kind: LatticeKind, spacing: f64) -> ([i32; 3], Vec<[i32; 3]>) {
    // Even, so that the middles are whole; up, so that neighbours do not overlap.
    let even = |length: f64| 2 * ((length / 2.0 - 1e-6).ceil() as i32);
    let low = (spacing / 2.0).round() as i32;
    let (side, relative) = match kind {
        LatticeKind::Sc => ([spacing.round() as i32; 3], vec![[0; 3]]),
        LatticeKind::Bcc => {
            let side = even(2.0 * spacing / 3.0f64.sqrt());
            ([side; 3], vec![[0; 3], [side / 2; 3]])
        }
        LatticeKind::Fcc => {
            let side = even(2.0f64.sqrt() * spacing);
            let h = side / 2;
            ([side; 3], vec![[0; 3], [h, h, 0], [h, 0, h], [0, h, h]])
        }
        LatticeKind::Hcp => {
            let x = even(spacing);
            let y = even(3.0f64.sqrt() * spacing);
            // The second layer sits over the hollows of the first; its rows are rounded, and the
            // layers kept far enough apart for the nearer of the two distances that result.
            let (half, third) = (y / 2, (f64::from(y) / 3.0).round() as i32);
            let nearer = f64::from(third).min(
                (f64::from(half - third) * f64::from(half - third)
                    + f64::from(x / 2) * f64::from(x / 2))
                .sqrt(),
            );
            let z = even(2.0 * (spacing * spacing - nearer * nearer).sqrt());
            let basis =
                vec![[0; 3], [x / 2, half, 0], [x / 2, half + third, z / 2], [0, third, z / 2]];
            ([x, y, z], basis)
        }
    };
    let basis = relative.into_iter().map(|b: [i32; 3]| b.map(|v| v + low)).collect();
    (side, basis)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Extent, PackReport};
    use snowgrain_math::DVec3;

    const KINDS: [LatticeKind; 4] =
        [LatticeKind::Sc, LatticeKind::Bcc, LatticeKind::Fcc, LatticeKind::Hcp];

    fn settings(kind: LatticeKind, counts: [u32; 3]) -> LatticeSettings {
        LatticeSettings { kind, counts, radius: 0.5, spacing: None, density: None }
    }

    fn quantisation() -> Quantisation {
        Quantisation::for_grains(DVec3::ZERO, 0.5)
    }

    #[test]
    fn simple_cubic_grains_sit_at_the_middles_of_their_cells() {
        let field = lattice_grains(&settings(LatticeKind::Sc, [3, 4, 5]), &quantisation()).unwrap();
        let mut expected = Vec::new();
        for k in 0..5 {
            for j in 0..4 {
                for i in 0..3 {
                    expected.push(DVec3::new(f64::from(i), f64::from(j), f64::from(k)) + 0.5);
                }
            }
        }
        for (grain, expected) in field.iter().zip(&expected) {
            assert!((grain.center - *expected).length() < 5.0 * field.quantisation.quantum());
        }
        assert_eq!(field.len(), 60);
    }

    #[test]
    fn neighbours_and_solid_fractions_are_those_of_the_crystals() {
        let expected =
            [(6.0, core::f64::consts::FRAC_PI_6), (8.0, 0.6802), (12.0, 0.7405), (12.0, 0.7405)];
        for (kind, (neighbours, fraction)) in KINDS.into_iter().zip(expected) {
            let settings = settings(kind, [12, 10, 11]);
            let cell = LatticeCell::new(&settings, &quantisation()).unwrap();
            let field = lattice_grains(&settings, &quantisation()).unwrap();
            assert!((cell.solid_fraction() - fraction).abs() < 4e-4, "{kind:?}");
            assert_eq!(field.len() as u64, settings.full_count());
            assert_eq!(inner_neighbours(&field, &cell), neighbours, "{kind:?}");
            let report = PackReport::of(&field, Extent::Block, &|_| false);
            assert_eq!(report.overlaps_per_grain, 0.0, "{kind:?}");
            assert_eq!(report.connected_fraction, 1.0);
            let measured = report.union_solid_fraction;
            let error = (measured.mean - fraction).abs();
            assert!(error < 0.06, "{kind:?} {measured:?}");
            let bounds = field.bounds();
            assert!(bounds.min.abs().max_element() <= 1.01 * field.quantisation.quantum());
        }
    }

    /// Mean number of grains nearer than 1.0003 spacings to the grains of an inner cell; none may
    /// overlap.
    fn inner_neighbours(field: &GrainField, cell: &LatticeCell) -> f64 {
        let touching = 2.0 * f64::from(cell.radius);
        let (mut near, mut cells) = (0u32, 0u32);
        for basis in &cell.basis {
            let inner = [0, 1, 2].map(|a| 2 * cell.side_quanta[a] + basis[a]);
            assert!(field.quantised().any(|g| g.center == inner));
            cells += 1;
            for grain in field.quantised() {
                let square: f64 = (0..3)
                    .map(|a| f64::from(grain.center[a]) - f64::from(inner[a]))
                    .map(|d| d * d)
                    .sum();
                assert!(square == 0.0 || square.sqrt() >= touching - 0.01, "{}", square.sqrt());
                near += u32::from(square > 0.0 && square.sqrt() < touching * 1.0003);
            }
        }
        f64::from(near) / f64::from(cells)
    }

    #[test]
    fn a_density_sets_the_spacing_or_thins_a_lattice_whose_spacing_is_given() {
        for kind in KINDS {
            let wide = LatticeSettings { density: Some(200.0), ..settings(kind, [8, 8, 8]) };
            let cell = LatticeCell::new(&wide, &quantisation()).unwrap();
            assert!((cell.solid_fraction() * ICE_DENSITY / 200.0 - 1.0).abs() < 1e-3);
            let thin = LatticeSettings { spacing: Some(1.0), ..wide.clone() };
            let cell = LatticeCell::new(&thin, &quantisation()).unwrap();
            let field = lattice_grains(&thin, &quantisation()).unwrap();
            assert_eq!(field.len() as u64, cell.kept);
            let part = field.len() as f64 / thin.full_count() as f64;
            let density = part * cell.solid_fraction() * ICE_DENSITY;
            assert!((density / 200.0 - 1.0).abs() < 2e-3, "{density}");
            let dense = LatticeSettings { density: Some(700.0), ..settings(kind, [1, 1, 1]) };
            let message = LatticeCell::new(&dense, &quantisation()).unwrap_err().to_string();
            assert!(message.starts_with("density: 700 kg/m3 is out of reach"), "{message}");
        }
    }

    #[test]
    fn lattices_out_of_range_are_refused() {
        let refused = |settings: LatticeSettings| LatticeCell::new(&settings, &quantisation());
        let good = settings(LatticeKind::Fcc, [1, 1, 1]);
        assert!(refused(LatticeSettings { counts: [0, 1, 1], ..good.clone() }).is_err());
        assert!(refused(LatticeSettings { counts: [u32::MAX; 3], ..good.clone() }).is_err());
        assert!(refused(LatticeSettings { radius: f64::NAN, ..good.clone() }).is_err());
        assert!(refused(LatticeSettings { radius: 0.6, ..good.clone() }).is_err());
        assert!(refused(LatticeSettings { spacing: Some(0.0), ..good.clone() }).is_err());
        let far = LatticeSettings { spacing: Some(1e300), ..good.clone() };
        assert!(refused(far).is_err());
    }
}
