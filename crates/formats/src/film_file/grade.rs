//! The grade of a film, as TOML: `primaries`, `lights`, `absorption` (a source or 1/m), `enhancement`,
//! `exposure_stops` (where it is not 0) and `impurities`, each a mass fraction or cells per kilogram of ice.

use crate::laboratory::impurity_kind;
use crate::scene::Absorption;
use serde::Deserialize;
use snowgrain_optics::{Grade, Illuminant, Impurity, Load, Primaries};
use std::collections::BTreeMap;
use std::fmt::Write;

pub(super) fn to_toml(grade: &Grade) -> String {
    let lights: Vec<_> = grade.lights.iter().map(|light| light.name()).collect();
    let absorption = match grade.absorption {
        snowgrain_optics::Absorption::Grey(per_metre) => format!("{per_metre:?}"),
        snowgrain_optics::Absorption::Measured(source) => format!("\"{}\"", source.name()),
    };
    let exposure = match grade.exposure_stops {
        0.0 => String::new(),
        stops => format!("exposure_stops = {stops:?}\n"),
    };
    let mut text = format!(
        "primaries = \"{}\"\nlights = {lights:?}\nabsorption = {absorption}\nenhancement = {:?}\n\
         {exposure}\n[impurities]\n",
        grade.primaries.name(),
        grade.enhancement,
    );
    for Impurity { kind, load } in &grade.impurities {
        let (Load::MassFraction(amount) | Load::CellsPerKilogram(amount)) = load;
        // Writing to a string does not fail.
        let _ = writeln!(text, "{} = {amount:?}", kind.name());
    }
    text
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct GradeTable {
    primaries: String,
    lights: Vec<String>,
    absorption: Absorption,
    enhancement: f64,
    #[serde(default)]
    exposure_stops: f64,
    impurities: BTreeMap<String, f64>,
}

/// # Errors
/// What is wrong.
pub(super) fn from_toml(bytes: &[u8]) -> Result<Grade, String> {
    let text = std::str::from_utf8(bytes).map_err(|_| "its grade is not text")?;
    let table: GradeTable =
        toml::from_str(text).map_err(|error| format!("its grade: {}", error.message()))?;
    let unknown = |name: &str| format!("its grade names {name}, which is not known");
    let primaries = Primaries::ALL.into_iter().find(|known| known.name() == table.primaries);
    let light = |name: &String| Illuminant::from_name(name).ok_or_else(|| unknown(name));
    let impurity = |(name, &amount): (&String, &f64)| {
        let kind = impurity_kind(name)?;
        let load = if kind.is_counted() {
            Load::CellsPerKilogram(amount)
        } else {
            Load::MassFraction(amount)
        };
        Ok(Impurity { kind, load })
    };
    if !table.exposure_stops.is_finite() {
        return Err("its exposure is not a finite number".into());
    }
    Ok(Grade {
        primaries: primaries.ok_or_else(|| unknown(&table.primaries))?,
        lights: table.lights.iter().map(light).collect::<Result<_, _>>()?,
        absorption: table.absorption.0,
        impurities: table.impurities.iter().map(impurity).collect::<Result<_, String>>()?,
        enhancement: table.enhancement,
        exposure_stops: table.exposure_stops,
    })
}
