//! What `[[snow]]` means.

mod packed;
mod sizes;

use super::super::SceneError;
use super::super::document::{DepositRuleName, LatticeName, SnowSource, SnowTable};
use super::checks::Checks;
use super::{Files, ReadGrains, ReadPlanImage, ReadSizes};
use snowgrain_grains::{Amount, DepositRule, DepositSettings, ICE_DENSITY};
use snowgrain_grains::{LatticeKind, LatticeSettings};
use snowgrain_render::description::{IceDescription, SnowDescription};
use std::sync::Arc;

/// Most grains of one body of snow: beyond any memory, and no product of counts overflows.
const MOST_GRAINS: u64 = 1 << 40;

/// All sources.
const SOURCES: [SnowSource; 5] = [
    SnowSource::Deposit,
    SnowSource::Pack,
    SnowSource::Fill,
    SnowSource::Lattice,
    SnowSource::File,
];

/// Keys that a source takes beside `source`.
fn keys_of(source: SnowSource) -> &'static [&'static str] {
    match source {
        SnowSource::Deposit => &[
            "kind",
            "grains",
            "depth",
            "radius",
            "shapes",
            "variation",
            "spread",
            "sizes",
            "wetness",
            "impurities",
            "density",
            "rule",
            "max_slope",
            "direction",
            "area",
            "seed",
        ],
        SnowSource::Pack => &[
            "kind",
            "box",
            "radius",
            "shapes",
            "variation",
            "spread",
            "sizes",
            "wetness",
            "impurities",
            "density",
            "seed",
        ],
        SnowSource::Fill => &[
            "kind",
            "file",
            "scale",
            "rotate",
            "translate",
            "height",
            "base",
            "area",
            "mask",
            "density_map",
            "radius",
            "shapes",
            "variation",
            "spread",
            "sizes",
            "wetness",
            "impurities",
            "density",
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
    }
}

/// How the files of snow are read.
pub(super) struct SnowFiles<'a, 'b, 'c> {
    pub(super) grains: &'b mut ReadGrains<'a>,
    pub(super) sizes: &'b mut ReadSizes<'a>,
    pub(super) plan_image: &'b mut ReadPlanImage<'a>,
    /// Those of meshes.
    pub(super) objects: &'c mut Files<'a, 'b>,
}

pub(super) fn snow(
    checks: &Checks<'_>,
    has_finite_object: bool,
    grains: &IceDescription,
    files: &mut SnowFiles<'_, '_, '_>,
) -> Result<Vec<SnowDescription>, SceneError> {
    let mut bodies = Vec::new();
    for (index, table) in checks.document().snow.iter().enumerate() {
        let body = Body { checks, index, table, grains };
        body.refuse_foreign_keys()?;
        bodies.push(match table.source {
            SnowSource::Deposit => {
                SnowDescription::Deposit(body.deposit(has_finite_object, files)?)
            }
            SnowSource::Pack => SnowDescription::Filled(body.pack(files)?),
            SnowSource::Fill => SnowDescription::Filled(body.fill(files)?),
            SnowSource::Lattice => SnowDescription::Lattice(body.lattice()?),
            SnowSource::File => body.file(files.grains)?,
        });
    }
    Ok(bodies)
}

/// One `[[snow]]` under examination.
struct Body<'a> {
    checks: &'a Checks<'a>,
    index: usize,
    table: &'a SnowTable,
    grains: &'a IceDescription,
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
            let owners: Vec<String> = SOURCES
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

    fn deposit(
        &self,
        has_finite_object: bool,
        files: &mut SnowFiles<'_, '_, '_>,
    ) -> Result<DepositSettings, SceneError> {
        let density = self.density()?;
        let rule = self.table.rule.map(|name| match name {
            DepositRuleName::Ray => DepositRule::Ray,
            DepositRuleName::Stick => DepositRule::Stick,
            DepositRuleName::Roll => DepositRule::Roll,
        });
        let rule = if density.is_none() { rule.or(Some(DepositRule::Ray)) } else { rule };
        let max_slope_degrees = self.table.max_slope.unwrap_or(match rule {
            Some(DepositRule::Ray) => 80.0,
            Some(DepositRule::Stick | DepositRule::Roll) | None => 90.0,
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
            radii: self.radii(files.sizes)?,
            density,
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

    /// The density that ice of the same solid fraction has, kg/m^3.
    fn density(&self) -> Result<Option<f64>, SceneError> {
        let Some(density) = self.table.density else { return Ok(None) };
        let substance = self.grains.absorption.substance();
        let (name, mend) = (substance.name(), "write how dense the substance itself is, in kg/m^3");
        let solid = substance.density();
        let solid = solid.ok_or_else(|| self.checks.missing("material.density", mend))?;
        if !(density > 0.0 && density <= solid) {
            let mend = format!("must be above 0 and at most {solid} kg/m^3 (solid {name})");
            return Err(self.bad("density", &mend));
        }
        Ok(Some(if solid == ICE_DENSITY { density } else { density * (ICE_DENSITY / solid) }))
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
