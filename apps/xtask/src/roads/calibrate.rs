//! What the proxy's grains differ by from real ones: measured on slabs.

use anyhow::{Context as _, Result};
use snowgrain_geometry::{Shape, ShapeKind};
use snowgrain_grains::{
    Amount, DepositRule, DepositSettings, MixedShape, Orientation, PackSettings, Radii, ShapeMix,
};
use snowgrain_math::DVec3;
use snowgrain_render::measure::{
    CALIBRATION_PATHS, PackedSlab, SlabMeasure, calibrate_proxy, calibration_by, measure_slab,
    measure_slab_in_medium,
};
use snowgrain_render::transport::medium::{Calibration, InnerSnow, Medium, MediumKind};
use std::fmt::Write as _;
use std::sync::Arc;

/// Mean radius of the grains, metres.
const RADIUS: f64 = 0.5e-3;
/// Relative indices of ice and of rock salt.
const ICE: f64 = 1.31;
const SALT: f64 = 1.544;
/// kg/m^3: of equal spheres of ice, and of other grains.
const DENSITIES: [f64; 4] = [150.0, 275.0, 400.0, 500.0];
const OTHER_DENSITIES: [f64; 2] = [150.0, 300.0];
/// Depth of the slabs, radii, and seed: of those by which is calibrated, and of those by which that is judged.
const CALIBRATING: (f64, u64) = (60.0, 11);
const JUDGING: (f64, u64) = (35.0, 12);
/// Times that the part that passes straight is mended.
const STEPS: u32 = 4;

/// Grains of which slabs are made.
struct Grains {
    name: &'static str,
    radii: Radii,
    shapes: Vec<ShapeKind>,
    eta: f64,
    /// How it falls; `None`: as packs of its density.
    rule: Option<DepositRule>,
    orientation: Orientation,
}

impl Grains {
    fn spheres() -> Self {
        Self {
            name: "equal spheres",
            radii: Radii::equal(RADIUS),
            shapes: Vec::new(),
            eta: ICE,
            rule: None,
            orientation: Orientation::Random,
        }
    }

    /// Grains that are measured before a picture: sizes, shapes and indices.
    fn others() -> Vec<Self> {
        let spread = Radii::Uniform { mean: RADIUS, variation: 0.6 * RADIUS };
        let plate = ShapeKind::HexagonalPrism { aspect: 0.3, rounding: 0.2 };
        let column = ShapeKind::HexagonalPrism { aspect: 2.5, rounding: 0.0 };
        let rounded = ShapeKind::RandomPolyhedron { faces: 14, seed: 1, rounding: 0.4 };
        let rosette = ShapeKind::Rosette { arms: 4, aspect: 3.0, rounding: 0.0 };
        let cube = ShapeKind::Cube { rounding: 0.2 };
        let of =
            |name, shapes: &[ShapeKind]| Self { name, shapes: shapes.to_vec(), ..Self::spheres() };
        vec![
            Self {
                name: "spheres, `rule = \"ray\"`",
                rule: Some(DepositRule::Ray),
                ..Self::spheres()
            },
            Self {
                name: "spheres, `rule = \"roll\"`",
                rule: Some(DepositRule::Roll),
                ..Self::spheres()
            },
            Self { name: "spheres, r 40 to 160 %", radii: spread.clone(), ..Self::spheres() },
            of("plates", &[plate]),
            Self {
                orientation: Orientation::Horizontal { spread_degrees: 10.0 },
                ..of("plates that lie level, within 10 degrees", &[plate])
            },
            Self {
                orientation: Orientation::Horizontal { spread_degrees: 0.0 },
                ..of("plates that lie exactly level", &[plate])
            },
            Self {
                orientation: Orientation::Aligned {
                    axis: DVec3::new(1.0, 1.0, 0.0),
                    spread_degrees: 10.0,
                },
                ..of("plates that lie aslant, all alike", &[plate])
            },
            of("columns", &[column]),
            of("rosettes", &[rosette]),
            Self {
                radii: spread.clone(),
                ..of("plates, columns, polyhedra, r 40 to 160 %", &[plate, column, rounded])
            },
            Self { radii: spread, eta: SALT, ..of("cubes of salt, r 40 to 160 %", &[cube]) },
            Self { name: "spheres of salt", eta: SALT, ..Self::spheres() },
        ]
    }

    fn mix(&self) -> Result<Option<ShapeMix>> {
        if self.shapes.is_empty() {
            return Ok(None);
        }
        let mixed = self.shapes.iter().map(|kind| {
            let (shape, orientation) = (Arc::new(Shape::new(*kind)?), self.orientation);
            anyhow::Ok(MixedShape { shape, orientation, fraction: 1.0 })
        });
        Ok(Some(ShapeMix::new(mixed.collect::<Result<_>>()?, 5)?))
    }
}

/// A slab of one density, and what light does in it.
pub(super) struct Slab {
    name: &'static str,
    fell: Option<DepositSettings>,
    mix: Option<ShapeMix>,
    /// Whether light may come back to the grain that it left.
    is_hollow: bool,
    slab: PackedSlab,
    exact: SlabMeasure,
}

impl Slab {
    fn new(grains: &Grains, density: f64, (depth, seed): (f64, u64), paths: u64) -> Result<Self> {
        let (name, mix, radii) = (grains.name, grains.mix()?, grains.radii.clone());
        let size = (depth * RADIUS, grains.eta);
        let fell = grains.rule.map(|rule| DepositSettings {
            // The slab has its own.
            amount: Amount::Depth(RADIUS),
            radii: radii.clone(),
            density: None,
            rule: Some(rule),
            max_slope_degrees: 90.0,
            area: None,
            direction: DepositSettings::DOWN,
            seed,
        });
        let slab = match &fell {
            Some(snowfall) => PackedSlab::fallen((snowfall, mix.as_ref()), size, (paths, seed))?,
            None => {
                let pack = PackSettings { radii, density, seed };
                PackedSlab::new((&pack, mix.as_ref()), size, (paths, seed))?
            }
        };
        let exact = measure_slab(&slab.world, &slab.settings);
        let is_hollow = slab.prototypes.iter().any(|shape| shape.parts().len() > 1);
        Ok(Self { name, fell, mix, is_hollow, slab, exact })
    }

    /// Those by which the proxy is judged: of equal spheres of ice, or of other grains.
    pub(super) fn judging(paths: u64, of_others: bool) -> impl Iterator<Item = Result<Self>> {
        let (grains, densities) = match of_others {
            false => (vec![Grains::spheres()], DENSITIES.to_vec()),
            true => (Grains::others(), OTHER_DENSITIES.to_vec()),
        };
        grains.into_iter().flat_map(move |grains| {
            // A rule has a density of its own.
            let count = if grains.rule.is_some() { 1 } else { densities.len() };
            let slab = |density: &f64| Self::new(&grains, *density, JUDGING, paths);
            densities[..count].iter().map(slab).collect::<Vec<_>>()
        })
    }

    /// What the medium does, with the calibration that a picture has; and that.
    fn with(&self, kind: MediumKind) -> Result<(SlabMeasure, Option<Calibration>)> {
        let PackedSlab { world, prototypes, settings, .. } = &self.slab;
        let medium =
            Medium::in_the_dark(kind, (world, prototypes)).context("a slab holds grains")?;
        let snow = medium.inner_snow(self.fell.clone())?.filter(|snow| !snow.is_known());
        let snow = snow.map(|snow| InnerSnow { mix: self.mix.clone(), ..snow });
        let measured = snow.map(|snow| calibrate_proxy(&snow, CALIBRATION_PATHS)).transpose()?;
        let medium = match measured {
            Some(measured) => medium.calibrated(&Calibration::table_through(measured)),
            None => medium,
        };
        Ok((measure_slab_in_medium(world, &medium, settings), measured))
    }

    /// A line of the table of what is left, and whether the proxy visits as many grains, unless they are hollow, and travels as far in
    /// ice, but for this part and three standard errors.
    pub(super) fn row(&self, part: f64, with_volume: bool) -> Result<(String, bool)> {
        let (proxy, measured) = self.with(MediumKind::Proxy)?;
        let exact = &self.exact;
        let solid = self.slab.solid_fraction;
        let mut row = match measured {
            None => format!("| {solid:.3} | {:.1} | {} |", self.slab.tau, transmittance(exact)),
            Some(Calibration { straight, .. }) => format!(
                "| {} | {solid:.3} | {:.1} % | {} |",
                self.name,
                100.0 * straight,
                transmittance(exact)
            ),
        };
        let mut write = |measure: &SlabMeasure| {
            let [visits, ice] = self.ratios(measure);
            let (ratio, error) = visits;
            write!(
                row,
                " {} | {ratio:.3} ({error:.3}) | {:.3} ({:.3}) |",
                transmittance(measure),
                ice.0,
                ice.1
            )
        };
        write(&proxy)?;
        if with_volume {
            write(&self.with(MediumKind::Volume)?.0)?;
        }
        row.push('\n');
        let [visits, ice] = self.ratios(&proxy);
        let is_near = |(ratio, error): (f64, f64)| (ratio - 1.0).abs() <= part + 3.0 * error;
        Ok((row, is_near(ice) && (self.is_hollow || is_near(visits))))
    }

    /// Grains visited and length in ice over those of exact light, with standard errors.
    fn ratios(&self, found: &SlabMeasure) -> [(f64, f64); 2] {
        let exact = &self.exact;
        let pairs = [(found.grain_visits, exact.grain_visits), (found.ice_path, exact.ice_path)];
        pairs.map(|(found, exact)| {
            let relative = [found, exact].map(|of| of.standard_error / of.mean);
            let error = (relative[0] * relative[0] + relative[1] * relative[1]).sqrt();
            (found.mean / exact.mean, error)
        })
    }
}

fn transmittance(measure: &SlabMeasure) -> String {
    let of = measure.transmittance;
    format!("{:.4} ({:.4})", of.mean, of.standard_error)
}

/// Prints the table of the code.
pub(super) fn print(paths: u64) -> Result<()> {
    println!("    Calibration {{ solid: 0.0, straight: 0.0, ice: 1.0 }},");
    for density in DENSITIES {
        let Slab { slab, exact, .. } = Slab::new(&Grains::spheres(), density, CALIBRATING, paths)?;
        let Calibration { solid, straight, .. } = calibration_by(&slab, &exact, STEPS);
        println!("    Calibration {{ solid: {solid:.3}, straight: {straight:.3}, ice: 1.0 }},");
    }
    Ok(())
}
