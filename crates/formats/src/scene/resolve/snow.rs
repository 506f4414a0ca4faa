//! What `[[snow]]` means.

use super::super::SceneError;
use super::super::document::{DepositRuleName, LatticeName, SnowSource, SnowTable};
use super::super::quantity::Length;
use super::ReadGrains;
use super::checks::Checks;
use snowgrain_grains::{Amount, DepositRule, DepositSettings, LatticeKind, LatticeSettings, Radii};
use snowgrain_math::trig;
use snowgrain_render::description::SnowDescription;
use std::sync::Arc;

/// Density of ice, kg/m^3.
const ICE_DENSITY: f64 = 917.0;

/// Most grains of one body of snow: beyond any memory, and no product of counts overflows.
const MOST_GRAINS: u64 = 1 << 40;

/// Keys that a source takes beside `source`.
fn keys_of(source: SnowSource) -> &'static [&'static str] {
    match source {
        SnowSource::Deposit => &[
            "grains",
            "depth",
            "radius",
            "shapes",
            "variation",
            "wetness",
            "impurities",
            "density",
            "rule",
            "max_slope",
            "direction",
            "area",
            "seed",
        ],
        SnowSource::Lattice => &[
            "lattice",
            "counts",
            "radius",
            "shapes",
            "wetness",
            "impurities",
            "spacing",
            "density",
        ],
        SnowSource::File => &["file", "shapes", "impurities"],
        SnowSource::Pack => &[],
    }
}

pub(super) fn snow(
    checks: &Checks<'_>,
    has_finite_object: bool,
    read_grains: &mut ReadGrains<'_>,
) -> Result<Vec<SnowDescription>, SceneError> {
    let mut bodies = Vec::new();
    for (index, table) in checks.document().snow.iter().enumerate() {
        let body = Body { checks, index, table };
        if table.source == SnowSource::Pack {
            let mend = "packings come in a later version; this one offers \"deposit\", \
                        \"lattice\" and \"file\"";
            return Err(checks.bad(&body.key("source"), mend));
        }
        body.refuse_foreign_keys()?;
        bodies.push(match table.source {
            SnowSource::Deposit => SnowDescription::Deposit(body.deposit(has_finite_object)?),
            SnowSource::Lattice => SnowDescription::Lattice(body.lattice()?),
            SnowSource::File | SnowSource::Pack => body.file(read_grains)?,
        });
    }
    Ok(bodies)
}

/// One `[[snow]]` under examination.
struct Body<'a> {
    checks: &'a Checks<'a>,
    index: usize,
    table: &'a SnowTable,
}

impl Body<'_> {
    fn key(&self, name: &str) -> String {
        format!("snow.{}.{name}", self.index)
    }

    fn bad(&self, name: &str, mend: &str) -> SceneError {
        self.checks.bad(&self.key(name), mend)
    }

    /// The value of a key that this source needs.
    fn needed<T>(&self, name: &str, value: Option<T>, mend: &str) -> Result<T, SceneError> {
        value.ok_or_else(|| self.checks.missing(&self.key(name), mend))
    }

    fn refuse_foreign_keys(&self) -> Result<(), SceneError> {
        let source = self.table.source;
        let own = keys_of(source);
        let path = format!("snow.{}", self.index);
        let written = self.checks.written_keys(&path);
        // Keys within a list of tables are looked at there.
        let mut written = written.filter(|key| !key.contains('.'));
        let foreign = written.find(|k| *k != "source" && !own.contains(k));
        foreign.map_or(Ok(()), |name| {
            let owners: Vec<String> = [SnowSource::Deposit, SnowSource::Lattice, SnowSource::File]
                .into_iter()
                .filter(|other| keys_of(*other).contains(&name))
                .map(|other| format!("\"{}\"", other.name()))
                .collect();
            let mend = format!(
                "not a key of source = \"{}\" but of {}; remove it or change the source ({} takes: {})",
                source.name(),
                owners.join(" and "),
                source.name(),
                own.join(", "),
            );
            Err(self.checks.misplaced(&self.key(name), mend))
        })
    }

    fn deposit(&self, has_finite_object: bool) -> Result<DepositSettings, SceneError> {
        let rule = match self.table.rule.unwrap_or(DepositRuleName::Ray) {
            DepositRuleName::Ray => DepositRule::Ray,
            DepositRuleName::Stick => DepositRule::Stick,
            DepositRuleName::Roll => DepositRule::Roll,
        };
        let max_slope_degrees = self.table.max_slope.unwrap_or(match rule {
            DepositRule::Ray => 80.0,
            DepositRule::Stick | DepositRule::Roll => 90.0,
        });
        if !(0.0..=90.0).contains(&max_slope_degrees) {
            return Err(self.bad("max_slope", "must be 0 to 90 degrees"));
        }
        let direction = self.direction()?;
        let area = self.area()?;
        if area.is_none() && !has_finite_object {
            let mend = "no finite object says where snow falls; write [x0, z0, x1, z1]";
            return Err(self.checks.missing(&self.key("area"), mend));
        }
        Ok(DepositSettings {
            amount: self.amount()?,
            radii: self.radii()?,
            density: self.density()?,
            rule,
            max_slope_degrees,
            direction,
            area,
            seed: self.table.seed.unwrap_or(self.index as u64),
        })
    }

    fn amount(&self) -> Result<Amount, SceneError> {
        match (self.table.grains, self.table.depth) {
            (Some(grains), None) if (1..=MOST_GRAINS).contains(&grains) => {
                Ok(Amount::Grains(grains))
            }
            (Some(0), None) => Err(self.bad("grains", "must be at least 1")),
            (Some(_), None) => Err(self.bad("grains", "more than any machine holds")),
            (None, Some(depth)) => Ok(Amount::Depth(self.checks.size(&self.key("depth"), depth)?)),
            (Some(_), Some(_)) => Err(self.checks.misplaced(
                &self.key("depth"),
                "both grains and depth say how much snow; keep one of them",
            )),
            (None, None) => Err(self.checks.missing(
                &self.key("grains"),
                "say how much snow: grains = 1_000_000 or depth = \"3 cm\"",
            )),
        }
    }

    fn radius(&self) -> Result<f64, SceneError> {
        let radius = self.needed("radius", self.table.radius, "write radius = \"0.5 mm\"")?;
        Ok(self.checks.size(&self.key("radius"), radius)? * self.growth()?)
    }

    /// By how much water makes grains larger: it joins them (the paper, section 3).
    fn growth(&self) -> Result<f64, SceneError> {
        match self.table.wetness.unwrap_or(0.0) {
            wetness if (0.0..=1.0).contains(&wetness) => Ok(trig::cbrt(1.0 + wetness)),
            _ => Err(self.bad("wetness", "must be 0 to 1, the volume of water by that of ice")),
        }
    }

    fn radii(&self) -> Result<Radii, SceneError> {
        let mean = self.radius()?;
        let variation = self.table.variation.unwrap_or(Length { metres: 0.0 }).metres;
        let variation = variation * self.growth()?;
        if !(variation >= 0.0 && variation <= mean) {
            let mend = format!("must be 0 to the radius, {mean} m");
            return Err(self.bad("variation", &mend));
        }
        Ok(Radii { mean, variation })
    }

    fn density(&self) -> Result<Option<f64>, SceneError> {
        match self.table.density {
            Some(d) if !(d > 0.0 && d <= ICE_DENSITY) => {
                Err(self.bad("density", "must be above 0 and at most 917 kg/m^3 (solid ice)"))
            }
            density => Ok(density),
        }
    }

    fn direction(&self) -> Result<[f64; 3], SceneError> {
        let Some(direction) = self.table.direction else { return Ok(DepositSettings::DOWN) };
        let [x, y, z] = direction;
        let length = (x * x + y * y + z * z).sqrt();
        if !(length.is_finite() && y < 0.0 && -y >= DepositSettings::LEAST_DESCENT * length) {
            let mend = "must point downwards: y below 0 and at least a tenth of the length, as in \
                        [0.3, -1, 0]";
            return Err(self.bad("direction", mend));
        }
        Ok(direction)
    }

    fn area(&self) -> Result<Option<[f64; 4]>, SceneError> {
        let Some(area) = self.table.area else { return Ok(None) };
        let [x0, z0, x1, z1] = self.checks.coordinates(&self.key("area"), area)?;
        if !(x0 < x1 && z0 < z1) {
            return Err(self.bad("area", "must be [x0, z0, x1, z1] with x0 < x1 and z0 < z1"));
        }
        Ok(Some([x0, z0, x1, z1]))
    }

    fn lattice(&self) -> Result<LatticeSettings, SceneError> {
        let name = self.needed("lattice", self.table.lattice, "write lattice = \"fcc\"")?;
        let (kind, grains_per_cell) = match name {
            LatticeName::Sc => (LatticeKind::Sc, 1),
            LatticeName::Bcc => (LatticeKind::Bcc, 2),
            LatticeName::Fcc => (LatticeKind::Fcc, 4),
            LatticeName::Hcp => (LatticeKind::Hcp, 4),
        };
        let counts = self.needed("counts", self.table.counts, "write counts = [100, 100, 100]")?;
        let grains = counts.iter().fold(grains_per_cell, |n: u128, &c| n * u128::from(c));
        if grains == 0 {
            return Err(self.bad("counts", "each must be at least 1"));
        }
        if grains > u128::from(MOST_GRAINS) {
            let mend = format!("{grains} grains, at most {MOST_GRAINS} are possible");
            return Err(self.bad("counts", &mend));
        }
        let radius = self.radius()?;
        let spacing = self.table.spacing.map(|s| self.checks.size(&self.key("spacing"), s));
        let density = self.density()?;
        if spacing.is_some() && density.is_some() {
            let mend = "both spacing and density say how dense the lattice is; keep one of them";
            return Err(self.checks.misplaced(&self.key("density"), mend));
        }
        Ok(LatticeSettings { kind, counts, radius, spacing: spacing.transpose()?, density })
    }

    fn file(&self, read_grains: &mut ReadGrains<'_>) -> Result<SnowDescription, SceneError> {
        let mend = "name the grains, as file = \"grains.ply\"";
        let file = self.needed("file", self.table.file.as_deref(), mend)?;
        let key = self.key("file");
        let path = self.checks.reference(&key, file)?;
        let field = read_grains(&path).map_err(|cause| self.checks.unusable(&key, cause))?;
        Ok(SnowDescription::Grains(Arc::new(field)))
    }
}
