//! Values on the command line of the laboratory.

use super::values::length;
use snowgrain_formats::laboratory::{self, GRAIN_RADII, parse_load};
use snowgrain_optics::colour::VISIBLE_NM;
use snowgrain_optics::ice::{WAVELENGTHS_NM, radius_of_specific_surface_area};
use snowgrain_optics::{Absorption, IceAbsorption, Illuminant, Impurity, Primaries};
use std::path::PathBuf;
use std::str::FromStr;

/// Most wavelengths of a range.
const MOST_WAVELENGTHS: f64 = 100_000.0;

/// Wavelengths, nm.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Wavelengths(pub(crate) Vec<f64>);

impl FromStr for Wavelengths {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let [least, greatest] = WAVELENGTHS_NM;
        let number = |text: &str| {
            text.trim().parse::<f64>().map_err(|_| {
                "write wavelengths in nm, as 420,520,620, or a range, as 350:1290:10".to_owned()
            })
        };
        let parts = text.split(':').map(number);
        let all = if let [from, to, step] = text.split(':').collect::<Vec<_>>()[..] {
            let (from, to, step) = (number(from)?, number(to)?, number(step)?);
            let steps = ((to - from) / step + 1e-9).floor();
            if !(step > 0.0 && (0.0..MOST_WAVELENGTHS).contains(&steps)) {
                return Err("a range goes up in steps above 0, as 350:1290:10".into());
            }
            (0..=steps as u32).map(|i| from + step * f64::from(i)).collect()
        } else if parts.count() == 1 {
            text.split(',').map(number).collect::<Result<Vec<f64>, String>>()?
        } else {
            return Err("write a range as FROM:TO:STEP, as 350:1290:10".into());
        };
        match all.iter().find(|wavelength| !(least..=greatest).contains(*wavelength)) {
            Some(wavelength) => Err(format!(
                "{wavelength} nm is out of range: ice is known from {least} to {greatest} nm"
            )),
            None => Ok(Self(all)),
        }
    }
}

/// Numbers: a list, or a range.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Range(pub(crate) Vec<f64>);

impl FromStr for Range {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = |text: &str| {
            let number = text.trim().parse::<f64>().ok().filter(|number| number.is_finite());
            number.ok_or_else(|| "write numbers, as 0,0.5,1, or a range, as 0:1:0.1".to_owned())
        };
        match text.split(':').collect::<Vec<_>>()[..] {
            [list] => list.split(',').map(number).collect::<Result<_, _>>().map(Self),
            [from, to, step] => {
                let (from, to, step) = (number(from)?, number(to)?, number(step)?);
                let steps = ((to - from) / step + 1e-9).floor();
                if !(step > 0.0 && (0.0..MOST_WAVELENGTHS).contains(&steps)) {
                    return Err("a range goes up in steps above 0, as 0:1:0.1".into());
                }
                Ok(Self((0..=steps as u32).map(|i| from + step * f64::from(i)).collect()))
            }
            _ => Err("write a range as FROM:TO:STEP, as 0:1:0.1".into()),
        }
    }
}

/// Visible wavelengths, nm.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct VisibleWavelengths(pub(crate) Vec<f64>);

impl FromStr for VisibleWavelengths {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let [least, greatest] = VISIBLE_NM;
        let Wavelengths(all) = text.parse()?;
        match all.iter().find(|wavelength| !(least..=greatest).contains(*wavelength)) {
            Some(wavelength) => {
                Err(format!("{wavelength} nm is not visible: write {least} to {greatest} nm"))
            }
            None => Ok(Self(all)),
        }
    }
}

/// A depth, metres; infinite for deep snow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Depth(pub(crate) f64);

impl FromStr for Depth {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text.trim().eq_ignore_ascii_case("inf") {
            return Ok(Self(f64::INFINITY));
        }
        length(text).map(Self).map_err(|error| format!("{error}, or inf"))
    }
}

/// A depth below the surface, metres; 0 is the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DepthBelow(pub(crate) f64);

impl FromStr for DepthBelow {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text.trim() == "0" { Ok(Self(0.0)) } else { length(text).map(Self) }
    }
}

/// An impurity and the loads of it that are asked for.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ImpurityLoads(pub(crate) Vec<Impurity>);

impl FromStr for ImpurityLoads {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, loads) =
            text.split_once('=').ok_or("write NAME=LOAD, as black-carbon=100ppb")?;
        let kind = laboratory::impurity_kind(name.trim())?;
        let impurity = |load: &str| Ok(Impurity { kind, load: parse_load(kind, load)? });
        loads.split(',').map(impurity).collect::<Result<_, String>>().map(Self)
    }
}

/// A wavelength, nm.
pub(super) fn wavelength(text: &str) -> Result<f64, String> {
    match text.parse::<Wavelengths>()?.0[..] {
        [wavelength] => Ok(wavelength),
        _ => Err("write one wavelength in nm".into()),
    }
}

/// A radius, metres.
pub(super) fn radius(text: &str) -> Result<f64, String> {
    laboratory::check_radius(length(text)?)
}

/// A specific surface area, m^2/kg.
pub(super) fn specific_surface_area(text: &str) -> Result<f64, String> {
    let area: f64 = text.trim().parse().map_err(|_| "write a number of m^2/kg".to_owned())?;
    let [least, greatest] = GRAIN_RADII;
    let fits = area > 0.0 && (least..=greatest).contains(&radius_of_specific_surface_area(area));
    fits.then_some(area).ok_or_else(|| {
        let of = snowgrain_optics::ice::specific_surface_area;
        format!("must be {:.3} to {:.0} m^2/kg", of(greatest), of(least))
    })
}

/// A density, kg/m^3.
pub(super) fn density(text: &str) -> Result<f64, String> {
    let density: f64 = text.trim().parse().map_err(|_| "write a number of kg/m^3".to_owned())?;
    laboratory::check_density(density)
}

/// A number from 0 to 1.
pub(super) fn albedo(text: &str) -> Result<f64, String> {
    let albedo = text.trim().parse::<f64>().ok().filter(|albedo| (0.0..=1.0).contains(albedo));
    albedo.ok_or_else(|| "write a number from 0 to 1".into())
}

/// A zenith angle, degrees.
pub(super) fn zenith(text: &str) -> Result<f64, String> {
    let zenith = text.trim().parse::<f64>().ok().filter(|zenith| (0.0..90.0).contains(zenith));
    zenith.ok_or_else(|| "write degrees from the vertical, 0 up to but not 90".into())
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

/// A source of the absorption of ice.
pub(super) fn ice_absorption(name: &str) -> Result<IceAbsorption, String> {
    named(&IceAbsorption::ALL, IceAbsorption::name, name)
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

/// A standard light.
pub(super) fn illuminant(name: &str) -> Result<Illuminant, String> {
    named(&Illuminant::ALL, Illuminant::name, name)
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
        let of = |text: &str| text.parse::<Wavelengths>().map(|wavelengths| wavelengths.0);
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
    fn loads_have_units_of_their_impurity() {
        let of = |text: &str| text.parse::<ImpurityLoads>();
        assert_eq!(of("black-carbon=0ppb,100ppb").unwrap().0.len(), 2);
        assert!(of("black-carbon").is_err() && of("coal=1ppb").is_err());
        assert!(of("black-carbon=-1ppb").is_err() && of("snow-algae=3ppb").is_err());
        assert!("inf".parse::<Depth>().unwrap().0.is_infinite() && "0".parse::<Depth>().is_err());
    }
}
