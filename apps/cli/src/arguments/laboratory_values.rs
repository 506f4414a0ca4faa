//! Values on the command line of the laboratory.

use super::series::{Series, plain, series};
use super::values::{finite, length, not_negative};
use snowgrain_formats::laboratory::{self, GRAIN_RADII, parse_load};
use snowgrain_optics::colour::VISIBLE_NM;
use snowgrain_optics::ice::{WAVELENGTHS_NM, radius_of_specific_surface_area};
use snowgrain_optics::{
    Absorption, IceAbsorption, Illuminant, Impurity, ImpurityKind, Load, Primaries, Substance,
};
use std::path::PathBuf;
use std::str::FromStr;

/// An impurity and the loads of it that are asked for.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ImpurityLoads(pub(crate) Vec<Impurity>);

impl FromStr for ImpurityLoads {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, loads) =
            text.split_once('=').ok_or("write NAME=LOAD, as black-carbon=100ppb")?;
        let kind = laboratory::impurity_kind(name.trim())?;
        let amount = |load: &str| parse_load(kind, load).map(amount);
        let Series(amounts) = series(loads, amount, amount)?;
        let of = |amount: f64| Impurity { kind, load: load(kind, amount) };
        Ok(Self(amounts.into_iter().map(of).collect()))
    }
}

/// How much a load is, in its own unit.
fn amount(load: Load) -> f64 {
    match load {
        Load::MassFraction(amount) | Load::CellsPerKilogram(amount) => amount,
    }
}

/// The load that is so much of the impurity.
fn load(kind: ImpurityKind, amount: f64) -> Load {
    if kind.is_counted() { Load::CellsPerKilogram(amount) } else { Load::MassFraction(amount) }
}

/// A wavelength, nm.
pub(super) fn wavelength(text: &str) -> Result<f64, String> {
    let [least, greatest] = WAVELENGTHS_NM;
    let wavelength: f64 = text.trim().parse().map_err(|_| {
        "write wavelengths in nm, as 420,520,620, or a range, as 350:1290:10".to_owned()
    })?;
    let known = (least..=greatest).contains(&wavelength);
    known.then_some(wavelength).ok_or_else(|| {
        format!("{wavelength} nm is out of range: ice is known from {least} to {greatest} nm")
    })
}

/// Wavelengths, nm.
pub(super) fn wavelengths(text: &str) -> Result<Series, String> {
    series(text, wavelength, plain)
}

/// Visible wavelengths, nm.
pub(super) fn visible_wavelengths(text: &str) -> Result<Series, String> {
    let [least, greatest] = VISIBLE_NM;
    let visible = |text: &str| {
        let nm = wavelength(text)?;
        let visible = (least..=greatest).contains(&nm);
        visible
            .then_some(nm)
            .ok_or_else(|| format!("{nm} nm is not visible: write {least} to {greatest} nm"))
    };
    series(text, visible, plain)
}

/// Numbers from 0 up.
pub(super) fn amounts(text: &str) -> Result<Series, String> {
    series(text, not_negative, plain)
}

/// A radius, metres.
pub(super) fn radius(text: &str) -> Result<f64, String> {
    laboratory::check_radius(length(text)?)
}

/// A density, kg/m^3.
pub(super) fn density(text: &str) -> Result<f64, String> {
    let density = text.trim().parse().map_err(|_| "write a number of kg/m^3".to_owned())?;
    laboratory::check_density(density)
}

/// A depth, metres; infinite for deep snow.
fn depth(text: &str) -> Result<f64, String> {
    if text.eq_ignore_ascii_case("inf") {
        return Ok(f64::INFINITY);
    }
    length(text).map_err(|error| format!("{error}, or inf"))
}

/// Depths, metres; infinite for deep snow.
pub(super) fn depths(text: &str) -> Result<Series, String> {
    series(text, depth, length)
}

/// Depths below the surface, metres; 0 is the surface.
pub(super) fn depths_below(text: &str) -> Result<Series, String> {
    series(text, |text| if text == "0" { Ok(0.0) } else { length(text) }, length)
}

/// Radii, metres.
pub(super) fn radii(text: &str) -> Result<Series, String> {
    series(text, radius, length)
}

/// Specific surface areas, m^2/kg.
pub(super) fn specific_surface_areas(text: &str) -> Result<Series, String> {
    series(text, specific_surface_area, plain)
}

fn specific_surface_area(text: &str) -> Result<f64, String> {
    let area: f64 = text.parse().map_err(|_| "write a number of m^2/kg".to_owned())?;
    let [least, greatest] = GRAIN_RADII;
    let fits = area > 0.0 && (least..=greatest).contains(&radius_of_specific_surface_area(area));
    fits.then_some(area).ok_or_else(|| {
        let of = snowgrain_optics::ice::specific_surface_area;
        format!("must be {:.3} to {:.0} m^2/kg", of(greatest), of(least))
    })
}

/// Densities, kg/m^3.
pub(super) fn densities(text: &str) -> Result<Series, String> {
    series(text, density, plain)
}

/// Numbers from 0 to 1.
pub(super) fn albedos(text: &str) -> Result<Series, String> {
    let albedo = |text: &str| {
        let albedo = text.parse::<f64>().ok().filter(|albedo| (0.0..=1.0).contains(albedo));
        albedo.ok_or_else(|| "write a number from 0 to 1".to_owned())
    };
    series(text, albedo, plain)
}

/// Zenith angles, degrees.
pub(super) fn zeniths(text: &str) -> Result<Series, String> {
    series(text, zenith, plain)
}

/// A zenith angle, degrees.
pub(super) fn zenith(text: &str) -> Result<f64, String> {
    let zenith = text.parse::<f64>().ok().filter(|zenith| (0.0..90.0).contains(zenith));
    zenith.ok_or_else(|| "write degrees from the vertical, 0 up to but not 90".to_owned())
}

/// Azimuths, degrees.
pub(super) fn azimuths(text: &str) -> Result<Series, String> {
    let azimuth = |text: &str| {
        let azimuth = finite(text).ok().filter(|azimuth| (-360.0..=360.0).contains(azimuth));
        azimuth.ok_or_else(|| "write degrees about the vertical, -360 to 360".to_owned())
    };
    series(text, azimuth, plain)
}

/// A standard error.
pub(super) fn standard_error(text: &str) -> Result<f64, String> {
    let error = text.trim().parse::<f64>().ok().filter(|error| (1e-6..=0.5).contains(error));
    error.ok_or_else(|| "write a number from 1e-6 to 0.5".into())
}

/// The one of `all` with this name.
fn named<T: Copy>(all: &[T], name: fn(T) -> &'static str, wanted: &str) -> Result<T, String> {
    all.iter().copied().find(|&one| name(one) == wanted).ok_or_else(|| {
        let names: Vec<_> = all.iter().map(|&one| name(one)).collect();
        format!("write {}", names.join(" or "))
    })
}

/// An absorption of ice: a source or 1/m.
pub(super) fn absorption(text: &str) -> Result<Absorption, String> {
    if let Ok(per_metre) = text.trim().parse::<f64>() {
        return if per_metre >= 0.0 && per_metre.is_finite() {
            Ok(Absorption::Grey(per_metre))
        } else {
            Err("write a finite number of 1/m, at least 0".into())
        };
    }
    ice_absorption(text)
        .map(Absorption::Measured)
        .map_err(|names| format!("{names} or a number of 1/m"))
}

/// One load of an impurity.
pub(super) fn impurity(text: &str) -> Result<Impurity, String> {
    match text.parse::<ImpurityLoads>()?.0[..] {
        [impurity] => Ok(impurity),
        _ => Err("write one load, as black-carbon=100ppb".into()),
    }
}

/// A substance that is built in.
pub(super) fn substance(name: &str) -> Result<Substance, String> {
    let known = Substance::BUILT_IN.into_iter().find(|substance| substance.name() == name);
    known.ok_or_else(|| {
        let names = Substance::BUILT_IN.map(|substance| substance.name());
        format!("write {}, or name a table by --indices", names.join(", "))
    })
}

/// A source of the absorption of ice.
pub(super) fn ice_absorption(name: &str) -> Result<IceAbsorption, String> {
    named(&IceAbsorption::ALL, IceAbsorption::name, name)
}

/// The spectrum of a light.
pub(super) fn illuminant(name: &str) -> Result<Illuminant, String> {
    Illuminant::from_name(name).ok_or_else(|| {
        let names = Illuminant::STANDARD.map(Illuminant::name).join(", ");
        format!("write {names}, sun-48.2 or clear-sky-48.2 (zenith angle of the sun, 0 to 75)")
    })
}

/// A set of primaries.
pub(super) fn primaries(name: &str) -> Result<Primaries, String> {
    named(&Primaries::ALL, Primaries::name, name)
}

/// An SVG file to be written.
pub(super) fn svg_file(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    let svg = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("svg"));
    if svg { Ok(path) } else { Err("the name must end in .svg".into()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wavelengths_are_listed_or_ranged_within_what_is_known_of_ice() {
        let of = |text: &str| wavelengths(text).map(|series| series.0);
        assert_eq!(of("420, 520,620").unwrap(), [420.0, 520.0, 620.0]);
        assert_eq!(of("350:1290:2").unwrap().len(), 471);
        assert_eq!(of("400:401:0.5").unwrap(), [400.0, 400.5, 401.0]);
        for bad in
            ["", "a", "500:400:10", "400:500:0", "400:500", "400:500:1:2", "299", "2501", "nan"]
        {
            assert!(of(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn lengths_in_ranges_have_units() {
        let radii = radii("100um:0.3mm:100um").unwrap().0;
        assert!(radii.len() == 3 && (radii[2] - 3e-4).abs() < 1e-12, "{radii:?}");
        assert_eq!(depths("1cm,inf").unwrap().0, [0.01, f64::INFINITY]);
        assert_eq!(depths_below("0:4cm:2cm").unwrap().0, [0.0, 0.02, 0.04]);
        assert!(depths("1cm:inf:1cm").is_err() && depths("0").is_err());
    }

    #[test]
    fn loads_have_units_of_their_impurity() {
        let of = |text: &str| text.parse::<ImpurityLoads>();
        assert_eq!(of("black-carbon=0ppb,100ppb").unwrap().0.len(), 2);
        assert_eq!(of("black-carbon=0ppb:1ppm:250ppb").unwrap().0.len(), 5);
        let cells = of("snow-algae=1000cells/mL:3000cells/mL:1000cells/mL").unwrap().0;
        assert!(cells.len() == 3 && cells[2].load == Load::CellsPerKilogram(3e6), "{cells:?}");
        assert!(of("black-carbon").is_err() && of("coal=1ppb").is_err());
        assert!(of("black-carbon=-1ppb").is_err() && of("snow-algae=3ppb").is_err());
    }
}
