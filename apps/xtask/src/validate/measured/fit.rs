//! One radius, fitted to one measured figure.

use crate::report::Section;
use crate::table::Table;
use crate::validate::Bench;
use anyhow::{Context as _, Result};

/// Assumed of the fresh snow, kg/m^3.
pub(super) const DENSITY: f64 = 100.0;
/// The wavelength of the fit, nm, at which the depth of 34 cm is no less than infinite.
pub(super) const FITTED: &str = "1100";
pub(super) const FITTED_MM: &str = "340";

/// Radii among which one is sought.
pub(super) struct Radii {
    /// From, to, step.
    pub(super) series: &'static str,
    /// Standard error of their albedos.
    pub(super) stderr: f64,
}

/// The radius, um: between the two of a series whose albedos are on either side of the measured one.
pub(super) fn fit(
    bench: &Bench,
    section: &mut Section,
    (measured, shapes): (&Table, &str),
    Radii { series, stderr }: &Radii,
) -> Result<f64> {
    let wanted = [("depth_mm", FITTED_MM), ("wavelength_nm", FITTED)];
    let target = measured.find(&wanted)?.number("albedo")?;
    let command = format!(
        "optics albedo --method homogeneous --shapes {shapes} --radius {series} --density {DENSITY} \
         --depth {FITTED_MM}mm --wavelengths {FITTED} --stderr {} --quiet",
        bench.choose(*stderr, 2.0 * stderr)
    );
    let table = bench.table(section, &command)?;
    let points: Result<Vec<[f64; 2]>> =
        table.rows().map(|row| Ok([row.number("radius_um")?, row.number("R")?])).collect();
    let points = points?;
    let pair = points.windows(2).find(|pair| pair[0][1] >= target && pair[1][1] < target);
    let [[low, above], [high, below]] = *pair.context("no radius of the series has the albedo")?
    else {
        unreachable!("windows are pairs");
    };
    Ok(low + (high - low) * (above - target) / (above - below))
}

/// What a command printed.
pub(super) fn predicted(
    found: &Table,
    density: f64,
    depth_mm: &str,
    wavelength: &str,
) -> Result<f64> {
    let depth = format!("{}", 1e-3 * depth_mm.parse::<f64>()?);
    let density = density.to_string();
    let wanted =
        [("density_kg_m3", density.as_str()), ("depth_m", &depth), ("wavelength_nm", wavelength)];
    found.find(&wanted)?.number("R")
}
