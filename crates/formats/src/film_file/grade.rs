//! The grade of a film, as TOML: `primaries`, `lights`, `absorption` (a source or 1/m of ice, a substance, or a table of one), `enhancement`,
//! `exposure_stops` (where it is not 0) and `impurities`, each a mass fraction or cells per kilogram of ice.

use crate::laboratory::impurity_kind;
use crate::scene::Absorption;
use crate::scene::document::SubstanceName;
use serde::Deserialize;
use snowgrain_optics::{
    Grade, Illuminant, Impurity, Load, MeasuredSubstance, Primaries, Spectrum, Substance,
};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::sync::Arc;

pub(super) fn to_toml(grade: &Grade) -> String {
    let lights: Vec<_> = grade.lights.iter().map(|light| light.name()).collect();
    let absorption = absorption_text(&grade.absorption);
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

/// A source, 1/m, the name of a substance other than ice, or the measurements of one.
fn absorption_text(absorption: &snowgrain_optics::Absorption) -> String {
    use snowgrain_optics::Absorption;
    match absorption {
        Absorption::Grey(per_metre) => format!("{per_metre:?}"),
        Absorption::Measured(source) => format!("\"{}\"", source.name()),
        Absorption::Of(Substance::Measured(measured)) => {
            let (wavelengths, index): (Vec<f64>, Vec<f64>) = measured.index.points().unzip();
            let imaginary: Vec<f64> = measured.imaginary.points().map(|(_, k)| k).collect();
            format!("{{ wavelengths_nm = {wavelengths:?}, n = {index:?}, k = {imaginary:?} }}")
        }
        Absorption::Of(substance) => format!("\"{}\"", substance.name()),
    }
}

/// What grains are made of, as written.
#[derive(Deserialize)]
#[serde(untagged)]
enum AbsorptionValue {
    Measured(MeasuredTable),
    BuiltIn(SubstanceName),
    OfIce(Absorption),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MeasuredTable {
    wavelengths_nm: Vec<f64>,
    n: Vec<f64>,
    k: Vec<f64>,
}

/// # Errors
/// Measurements that are no functions of the wavelength.
fn absorption(value: AbsorptionValue) -> Result<snowgrain_optics::Absorption, String> {
    let table = match value {
        AbsorptionValue::OfIce(absorption) => return Ok(absorption.0),
        AbsorptionValue::BuiltIn(name) => {
            let substance = name.built_in().ok_or("its grade names no substance")?;
            return Ok(snowgrain_optics::Absorption::Of(substance));
        }
        AbsorptionValue::Measured(table) => table,
    };
    let spectrum = |values: Vec<f64>| {
        Spectrum::new(table.wavelengths_nm.clone(), values)
            .ok_or("its grade holds indices that are no functions of the wavelength")
    };
    let (index, imaginary) = (spectrum(table.n)?, spectrum(table.k)?);
    let measured = MeasuredSubstance { index, imaginary, density: None };
    Ok(snowgrain_optics::Absorption::Of(Substance::Measured(Arc::new(measured))))
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct GradeTable {
    primaries: String,
    lights: Vec<String>,
    absorption: AbsorptionValue,
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
        absorption: absorption(table.absorption)?,
        impurities: table.impurities.iter().map(impurity).collect::<Result<_, String>>()?,
        enhancement: table.enhancement,
        exposure_stops: table.exposure_stops,
    })
}
