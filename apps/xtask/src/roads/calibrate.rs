//! What the proxy's grains differ by from real ones: measured on slabs.

use anyhow::{Context as _, Result};
use snowgrain_grains::{PackSettings, Radii};
use snowgrain_render::measure::{PackedSlab, SlabMeasure, measure_slab, measure_slab_in_medium};
use snowgrain_render::transport::medium::{CALIBRATION, Calibration, Medium, MediumKind};
use std::fmt::Write as _;

/// Radius of the grains, metres, and their relative index.
const RADIUS: f64 = 0.5e-3;
const ETA: f64 = 1.31;
/// kg/m^3.
const DENSITIES: [f64; 4] = [150.0, 275.0, 400.0, 500.0];
/// Depth of the slabs, radii, and seed: of those by which is calibrated, and of those by which that is judged.
pub(super) const CALIBRATING: (f64, u64) = (60.0, 11);
pub(super) const JUDGING: (f64, u64) = (35.0, 12);
/// Times that the part that passes straight is mended.
const STEPS: u32 = 4;

/// A slab of one density, and what light does in it.
pub(super) struct Calibrated {
    slab: PackedSlab,
    exact: SlabMeasure,
}

impl Calibrated {
    pub(super) fn all(paths: u64, (depth, seed): (f64, u64)) -> Result<Vec<Self>> {
        let slab = |density| {
            let radii = Radii::Uniform { mean: RADIUS, variation: 0.0 };
            let pack = PackSettings { radii, density, seed };
            let slab = PackedSlab::new(&pack, (depth * RADIUS, ETA), (paths, seed))?;
            let exact = measure_slab(&slab.world, &slab.settings);
            Ok(Self { slab, exact })
        };
        DENSITIES.into_iter().map(slab).collect()
    }

    fn with(&self, kind: MediumKind, table: &[Calibration]) -> Result<SlabMeasure> {
        let medium = Medium::in_the_dark(kind, &self.slab.world, table);
        let medium = medium.context("a slab holds grains")?;
        Ok(measure_slab_in_medium(&self.slab.world, &medium, &self.slab.settings))
    }

    /// The part that passes straight by which as much light comes through.
    pub(super) fn solve(&self) -> Result<Calibration> {
        let mut calibration = Calibration { solid: self.slab.solid_fraction, straight: 0.0 };
        // The way that light takes to come through grows as the grains that turn it: 1/T less about one.
        let way = |measure: &SlabMeasure| 1.0 / measure.transmittance.mean - 1.072;
        for _ in 0..STEPS {
            let found = self.with(MediumKind::Proxy, &[calibration])?;
            calibration.straight =
                1.0 - (1.0 - calibration.straight) * way(&self.exact) / way(&found);
        }
        Ok(calibration)
    }

    /// Whether the proxy visits as many grains, and travels as far in ice, but for this part and three standard errors.
    pub(super) fn keeps_visits(&self, part: f64) -> Result<bool> {
        let found = self.with(MediumKind::Proxy, &CALIBRATION)?;
        let visits = found.grain_visits.mean / (2.0 * self.slab.tau);
        let noise = 3.0 * found.grain_visits.standard_error / (2.0 * self.slab.tau);
        let ice = found.ice_path.mean / self.exact.ice_path.mean;
        let exact = self.exact.ice_path;
        let of_ice = noise + 3.0 * exact.standard_error / exact.mean;
        Ok((visits - 1.0).abs() <= part + noise && (ice - 1.0).abs() <= part + of_ice)
    }

    /// A line of the table of what is left.
    pub(super) fn row(&self) -> Result<String> {
        let [exact, proxy, volume] = [
            self.exact.clone(),
            self.with(MediumKind::Proxy, &CALIBRATION)?,
            self.with(MediumKind::Volume, &CALIBRATION)?,
        ];
        let mut row = format!("| {:.3} | {:.1} |", self.slab.solid_fraction, self.slab.tau);
        for measure in [&exact, &proxy, &volume] {
            let visits = measure.grain_visits;
            let ice = measure.ice_path.mean / self.exact.ice_path.mean;
            write!(
                row,
                " {:.4} ({:.4}) | {:.3} ({:.3}) | {:.3} |",
                measure.transmittance.mean,
                measure.transmittance.standard_error,
                visits.mean / (2.0 * self.slab.tau),
                visits.standard_error / (2.0 * self.slab.tau),
                ice,
            )?;
        }
        row.push('\n');
        Ok(row)
    }
}

/// Prints the table of the code.
pub(super) fn print(paths: u64) -> Result<()> {
    println!("    Calibration {{ solid: 0.0, straight: 0.0 }},");
    for slab in Calibrated::all(paths, CALIBRATING)? {
        let Calibration { solid, straight } = slab.solve()?;
        println!("    Calibration {{ solid: {solid:.3}, straight: {straight:.3} }},");
    }
    Ok(())
}
