//! What `[material]` and `[ice]` mean.

use super::super::SceneError;
use super::super::document::{IceTable, KeepName, PoresName};
use super::checks::Checks;
use super::{ReadOpticalConstants, impurities};
use snowgrain_optics::substance::REFERENCE_WAVELENGTH_NM;
use snowgrain_optics::{Absorption, MeasuredSubstance, Substance};
use snowgrain_render::description::{IceDescription, Pores};
use std::sync::Arc;

/// The grains' substance, and what `[ice]` says of it.
pub(super) fn grains(
    checks: &Checks<'_>,
    read: &mut ReadOpticalConstants<'_>,
) -> Result<IceDescription, SceneError> {
    let substance = substance(checks, read)?;
    let table = &checks.document().ice;
    let pores = match table.pores {
        PoresName::Air => Pores::Air,
        PoresName::Water => Pores::Water,
    };
    let mut grains = IceDescription { pores, ..IceDescription::clear(table.ior) };
    grains.disperses = checks.document().material.dispersion;
    if grains.disperses {
        check_dispersion(checks, &substance)?;
    }
    if substance == Substance::Ice {
        grains.absorption = ice_absorption(checks, table)?;
        grains.impurities = impurities(checks, "ice.impurities", &table.impurities)?;
        if !(1.0..=4.0).contains(&grains.ior) {
            return Err(checks.bad("ice.ior", "must be 1 to 4 (ice has 1.31)"));
        }
    } else {
        refuse_keys_of_ice(checks, &substance)?;
        grains.ior = substance.refractive_index(REFERENCE_WAVELENGTH_NM);
        grains.absorption = Absorption::Of(substance);
    }
    Ok(grains)
}

fn substance(
    checks: &Checks<'_>,
    read: &mut ReadOpticalConstants<'_>,
) -> Result<Substance, SceneError> {
    let table = &checks.document().material;
    if let Some(substance) = table.kind.built_in() {
        let is_measured = [("file", table.file.is_some()), ("density", table.density.is_some())];
        if let Some((key, _)) = is_measured.iter().find(|(_, written)| *written) {
            let mend = format!(
                "this is known of {}; remove it, or write kind = \"measured\"",
                substance.name()
            );
            return Err(checks.misplaced(&format!("material.{key}"), mend));
        }
        return Ok(substance);
    }
    let key = "material.file";
    let mend = "name the table of indices, as file = \"topaz.csv\"";
    let file = table.file.as_deref().ok_or_else(|| checks.missing(key, mend))?;
    if table.density.is_some_and(|density| !(density > 0.0 && density <= 1e5)) {
        return Err(checks.bad("material.density", "must be above 0 and at most 100000 kg/m^3"));
    }
    let path = checks.reference(key, file)?;
    let constants = read(&path).map_err(|cause| checks.unusable(key, cause))?;
    let measured = MeasuredSubstance { density: table.density, ..constants };
    Ok(Substance::Measured(Arc::new(measured)))
}

fn check_dispersion(checks: &Checks<'_>, substance: &Substance) -> Result<(), SceneError> {
    let key = "material.dispersion";
    if !substance.disperses() {
        let mend = format!("{} has one index for all colours; leave it out", substance.name());
        return Err(checks.misplaced(key, mend));
    }
    if checks.written_keys("ice").any(|key| key == "ior") {
        let mend = "with dispersion each colour has its measured index; remove this one";
        return Err(checks.misplaced("ice.ior", mend));
    }
    if checks.document().film.keep.contains(&KeepName::IcePaths) {
        let mend = "ice paths keep no wavelengths, which material.dispersion needs: leave out one of the two";
        return Err(checks.misplaced("film.keep", mend));
    }
    Ok(())
}

fn ice_absorption(checks: &Checks<'_>, ice: &IceTable) -> Result<Absorption, SceneError> {
    if let Absorption::Grey(per_metre) = ice.absorption.0
        && !(per_metre >= 0.0 && per_metre.is_finite())
    {
        return Err(checks.bad("ice.absorption", "must be a finite number of 1/m, at least 0"));
    }
    Ok(ice.absorption.0.clone())
}

/// # Errors
/// A key that is of ice alone, where the grains are of something else.
fn refuse_keys_of_ice(checks: &Checks<'_>, substance: &Substance) -> Result<(), SceneError> {
    let name = substance.name();
    let refused = |key: String| {
        let mend =
            format!("this is of ice, but the grains are of material.kind = \"{name}\"; remove it");
        Err(checks.misplaced(&key, mend))
    };
    let of_ice = ["ior", "absorption", "impurities"];
    if let Some(key) = checks.written_keys("ice").find(|key| of_ice.contains(key)) {
        return refused(format!("ice.{key}"));
    }
    for index in 0..checks.document().snow.len() {
        let path = format!("snow.{index}");
        let of_snow = ["kind", "wetness", "impurities"];
        if let Some(key) = checks.written_keys(&path).find(|key| of_snow.contains(key)) {
            return refused(format!("{path}.{key}"));
        }
    }
    Ok(())
}
