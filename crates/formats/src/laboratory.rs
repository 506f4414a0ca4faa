//! Layers of snow, shapes of grains and loads of impurities as users write them.

mod shapes;

pub use shapes::read_scatterers;

use crate::error::{Fault, FormatsError, Place};
use crate::input;
use crate::scene::Length;
use serde::Deserialize;
use snowgrain_optics::ice::{ICE_DENSITY, radius_of_specific_surface_area};
use snowgrain_optics::{Impurity, ImpurityKind, Load};
use snowgrain_render::laboratory::{MOST_LAYERS, Scatterers, SnowLayer};
use std::collections::BTreeMap;
use std::path::Path;

/// Radii of grains that the laboratory takes, metres: smaller ones are no matter of geometric optics,
/// larger ones no snow.
pub const GRAIN_RADII: [f64; 2] = [5e-6, 20e-3];

/// The radius, if it is one of a grain.
///
/// # Errors
/// What is wrong and how to mend it.
pub fn check_radius(radius: f64) -> Result<f64, String> {
    let [least, greatest] = GRAIN_RADII;
    (least..=greatest)
        .contains(&radius)
        .then_some(radius)
        .ok_or_else(|| format!("a radius of {radius} m is out of range: write 5 um to 20 mm"))
}

/// The density, if snow can have it.
///
/// # Errors
/// What is wrong and how to mend it.
pub fn check_density(density: f64) -> Result<f64, String> {
    let snow = density > 0.0 && density <= ICE_DENSITY;
    snow.then_some(density).ok_or_else(|| {
        format!("a density of {density} kg/m^3 is out of range: above 0, at most 917 (solid ice)")
    })
}

/// The impurity of that name; `soot` is black carbon.
///
/// # Errors
/// The names that there are.
pub fn impurity_kind(name: &str) -> Result<ImpurityKind, String> {
    let name = if name == "soot" { ImpurityKind::BlackCarbon.name() } else { name };
    let kind = ImpurityKind::ALL.into_iter().find(|kind| kind.name() == name);
    kind.ok_or_else(|| {
        let names = ImpurityKind::ALL.map(ImpurityKind::name).join(", ");
        format!("no impurity is called '{name}'; there are {names}")
    })
}

/// A load with its unit. Particles: `ppb` or `ng/g`, `ppm`, `ug/g` or `mg/kg`, by mass of ice; a bare
/// number is a mass fraction; `vol`, the volume of the impurity per volume of ice (the paper's P).
/// Cells: `cells/mL` of melt water.
///
/// # Errors
/// What is wrong and how to mend it.
pub fn parse_load(kind: ImpurityKind, text: &str) -> Result<Load, String> {
    const MASS_UNITS: [(&str, f64); 6] =
        [("ppb", 1e-9), ("ng/g", 1e-9), ("ppm", 1e-6), ("ug/g", 1e-6), ("mg/kg", 1e-6), ("", 1.0)];
    let text = text.trim();
    let amount = |unit: &str| {
        let number: f64 = text.strip_suffix(unit)?.trim_end().parse().ok()?;
        number.is_finite().then_some(number)
    };
    let name = kind.name();
    let amount_checked = |amount: f64| {
        let legal = amount >= 0.0;
        legal.then_some(amount).ok_or_else(|| format!("a load of {text} of {name} is negative"))
    };
    if kind.is_counted() {
        let cells = amount("cells/mL").or_else(|| amount("cells/ml")).ok_or_else(|| {
            format!(
                "{name} is counted: write cells in a millilitre of melt water, as 20000cells/mL"
            )
        })?;
        return Ok(Load::CellsPerKilogram(amount_checked(cells)? * 1000.0));
    }
    let fraction = match (amount("vol"), kind.density()) {
        (Some(volume), Some(density)) => Some(volume * density / ICE_DENSITY),
        _ => MASS_UNITS.iter().find_map(|(unit, scale)| Some(amount(unit)? * scale)),
    };
    let fraction = fraction.ok_or_else(|| {
        format!("write a load of {name} as 100ppb, 100ng/g, 5ppm, 5ug/g or 1e-7vol")
    })?;
    if amount_checked(fraction)? > 1.0 {
        return Err(format!("a load of {text} of {name} is more than there is ice"));
    }
    Ok(Load::MassFraction(fraction))
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct LayersFile {
    #[serde(default)]
    layer: Vec<LayerTable>,
}

/// A layer as written.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct LayerTable {
    bottom: Written,
    radius: Option<Written>,
    ssa: Option<f64>,
    shapes: Option<String>,
    density: f64,
    #[serde(default)]
    impurities: BTreeMap<String, Written>,
}

/// A number, or text with a unit.
#[derive(Debug, Deserialize)]
#[serde(untagged)]
enum Written {
    Number(f64),
    Text(String),
}

impl Written {
    fn metres(&self) -> Result<f64, String> {
        match self {
            Self::Number(metres) => Ok(*metres),
            Self::Text(text) if text.trim() == "inf" => Ok(f64::INFINITY),
            Self::Text(text) => Length::parse(text).map(|length| length.metres),
        }
    }
}

/// Reads a file of layers, from the top down. Their grains are `others` where a layer names none (`shapes`, see
/// [`read_scatterers`]); `seed` is for those.
///
/// # Errors
/// A file that cannot be read or is no such file; a key with a wrong value; layers that are not in
/// order. Every message names the file and the key.
pub fn read_layers(
    path: &Path,
    others: &Scatterers,
    seed: u64,
) -> Result<Vec<SnowLayer>, FormatsError> {
    let bytes = input::read_whole(path)?;
    let bad = |what: &str, mend: &str| Fault::whole(what, mend).of(path);
    let example = "write [[layer]] tables with bottom, radius and density";
    let text = String::from_utf8(bytes).map_err(|_| bad("this is not text", example))?;
    let file: LayersFile = toml::from_str(&text).map_err(|error| {
        let line = error.span().map_or(1, |span| 1 + text[..span.start].matches('\n').count());
        Fault::new(Place::Line(line as u64), error.message(), example).of(path)
    })?;
    if file.layer.is_empty() {
        return Err(bad("there is no layer", example));
    }
    if file.layer.len() > MOST_LAYERS {
        let what = format!("{} layers are too many", file.layer.len());
        return Err(bad(&what, &format!("write at most {MOST_LAYERS}")));
    }
    let mut top = 0.0;
    let mut named = BTreeMap::new();
    let mut layers = Vec::new();
    for (index, table) in file.layer.iter().enumerate() {
        let at = |key: &str, reason: String| {
            bad(&format!("layer.{index}.{key} cannot be used"), &reason)
        };
        let bottom = table.bottom.metres().map_err(|reason| at("bottom", reason))?;
        if bottom.is_nan() || bottom <= top {
            let reason =
                format!("{bottom} m does not lie below {top} m; write layers from the top down");
            return Err(at("bottom", reason));
        }
        let scatterers = match &table.shapes {
            Some(name) => scatterers_of_layer(&mut named, path, name, seed)?,
            None => others.clone(),
        };
        let radius = match (&table.radius, table.ssa) {
            (Some(radius), None) => {
                radius.metres().and_then(check_radius).map_err(|reason| at("radius", reason))?
            }
            (None, Some(area)) => {
                check_radius(radius_of_specific_surface_area(area) * scatterers.surface())
                    .map_err(|reason| at("ssa", reason))?
            }
            _ => return Err(at("radius", "write either radius or ssa".into())),
        };
        let density = check_density(table.density).map_err(|reason| at("density", reason))?;
        let impurity = |(name, load): (&String, &Written)| {
            let key = format!("impurities.{name}");
            let kind = impurity_kind(name).map_err(|reason| at("impurities", reason))?;
            let load = match load {
                Written::Number(number) => number.to_string(),
                Written::Text(text) => text.clone(),
            };
            let load = parse_load(kind, &load).map_err(|reason| at(&key, reason))?;
            Ok(Impurity { kind, load })
        };
        let impurities =
            table.impurities.iter().map(impurity).collect::<Result<_, FormatsError>>()?;
        let depth = bottom - top;
        layers.push(SnowLayer { scatterers, radius, density, depth, impurities });
        top = bottom;
    }
    Ok(layers)
}

/// The grains that a layer names; layers of one name share what is sampled. Files lie beside that of the layers.
fn scatterers_of_layer(
    named: &mut BTreeMap<String, Scatterers>,
    path: &Path,
    name: &str,
    seed: u64,
) -> Result<Scatterers, FormatsError> {
    if let Some(known) = named.get(name) {
        return Ok(known.clone());
    }
    let beside = path.parent().unwrap_or(Path::new("")).join(name);
    let is_file = beside.extension().is_some_and(|end| end == "toml");
    let read = match beside.to_str() {
        Some(file) if is_file => read_scatterers(file, seed)?,
        _ => read_scatterers(name, seed)?,
    };
    named.insert(name.to_owned(), read.clone());
    Ok(read)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Vec<SnowLayer>, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("layers.toml");
        std::fs::write(&path, text).unwrap();
        read_layers(&path, &Scatterers::Spheres, 0).map_err(|error| error.to_string())
    }

    #[test]
    fn layers_are_read_from_the_top_down() {
        let layers = read(
            "[[layer]]\nbottom = \"3 cm\"\nradius = \"100 um\"\ndensity = 250\n\
             impurities = { black-carbon = \"100 ppb\", snow-algae = \"200 cells/mL\" }\n\
             [[layer]]\nbottom = \"inf\"\nssa = 20\ndensity = 350\n",
        )
        .unwrap();
        assert_eq!((layers[0].radius, layers[0].depth, layers[0].density), (100e-6, 0.03, 250.0));
        assert_eq!(layers[0].impurities[0].load, Load::MassFraction(100.0 * 1e-9));
        assert_eq!(layers[0].impurities[1].load, Load::CellsPerKilogram(200_000.0));
        assert!((layers[1].radius - 163.577e-6).abs() < 1e-9 && layers[1].depth.is_infinite());
    }

    #[test]
    fn layers_of_one_name_share_their_shapes() {
        let layer = |bottom: u32, shapes: &str| {
            format!("[[layer]]\nbottom = {bottom}\nssa = 20\ndensity = 90\n{shapes}")
        };
        let named = "shapes = \"fresh\"\n";
        let text = layer(1, named) + &layer(2, "") + &layer(3, named);
        let layers = read(&text).unwrap();
        let [Scatterers::Shapes(one), Scatterers::Spheres, Scatterers::Shapes(other)] =
            [0, 1, 2].map(|index: usize| &layers[index].scatterers)
        else {
            panic!("{layers:?}");
        };
        assert!(std::sync::Arc::ptr_eq(one, other));
        // Plates have more surface than spheres of their volume, so those of one area are larger.
        assert!(layers[0].radius > 1.3 * layers[1].radius, "{layers:?}");
        let error = read(&layer(1, "shapes = \"slush\"\n")).unwrap_err();
        assert!(error.contains("slush"), "{error}");
    }

    #[test]
    fn what_is_wrong_is_named_with_its_key() {
        let layer = |keys: &str| format!("[[layer]]\n{keys}");
        for (text, told) in [
            (String::new(), "there is no layer"),
            (layer("bottom = 1\nradius = 1e-4\ndensity = 918"), "layer.0.density cannot be used"),
            (layer("bottom = 0\nradius = 1e-4\ndensity = 300"), "layer.0.bottom cannot be used"),
            (layer("bottom = 1\nradius = 1.0\ndensity = 300"), "layer.0.radius cannot be used"),
            (layer("bottom = 1\ndensity = 300"), "either radius or ssa"),
            (layer("bottom = 1\nradius = 1e-4\ndensity = 300\ncolour = 1"), "line 5"),
            (
                layer("bottom = 1\nradius = 1e-4\ndensity = 300\nimpurities = { coal = 1e-9 }"),
                "no impurity is called 'coal'",
            ),
            (
                layer("bottom = 1\nradius = 1e-4\ndensity = 3\nimpurities = { black-carbon = -1 }"),
                "is negative",
            ),
            (
                layer("bottom = \"2 cm\"\nradius = 1e-4\ndensity = 300\n")
                    + &layer("bottom = \"1 cm\"\nradius = 1e-4\ndensity = 300"),
                "layer.1.bottom cannot be used; 0.01 m does not lie below 0.02 m",
            ),
        ] {
            let message = read(&text).unwrap_err();
            assert!(message.contains(told) && message.contains("layers.toml"), "{message}");
        }
    }

    #[test]
    fn loads_mean_what_their_units_say() {
        let of = |text: &str| parse_load(ImpurityKind::BlackCarbon, text);
        for text in ["100ppb", "100 ng/g", "0.1ppm", "0.1ug/g", "0.1 mg/kg", "1e-7"] {
            let Load::MassFraction(fraction) = of(text).unwrap() else { panic!("{text}") };
            assert!((fraction / 1e-7 - 1.0).abs() < 1e-12, "{text}");
        }
        // The paper's P: a volume of 1270 kg/m^3 in one of 917.
        let Load::MassFraction(fraction) = of("1e-7vol").unwrap() else { panic!() };
        assert!((fraction / 1.385e-7 - 1.0).abs() < 1e-3);
        for text in ["", "ppb", "1kg", "nan", "inf", "2", "1cells/mL", "-1ppb"] {
            assert!(of(text).is_err(), "{text}");
        }
    }
}
