//! What `[[light]]` means.

use super::super::SceneError;
use super::super::document::{LightKindName, LightTable, SpectrumName, UnitsName};
use super::super::quantity::Triple;
use super::checks::Checks;
use core::f64::consts::PI;
use snowgrain_math::DVec3;
use snowgrain_optics::{Illuminant, SunZenith, clear_sky};
use snowgrain_render::description::{LightDescription, LightKind};
use snowgrain_render::light::{direction_of, irradiance_of_disc};

/// Keys that every kind takes.
const SHARED: [&str; 4] = ["kind", "spectrum", "visible_to_camera", "group"];

/// Keys that a kind takes beside those.
fn keys_of(kind: LightKindName) -> &'static [&'static str] {
    match kind {
        LightKindName::Sky | LightKindName::Uniform | LightKindName::Overcast => &["radiance"],
        LightKindName::ClearSky => &["strength", "units", "elevation", "azimuth"],
        LightKindName::Sun | LightKindName::SunSky => {
            &["strength", "units", "elevation", "azimuth", "angular_diameter"]
        }
    }
}

pub(super) fn lights(checks: &Checks<'_>) -> Result<Vec<LightDescription>, SceneError> {
    let tables = &checks.document().light;
    if tables.is_empty() {
        let mend = "the picture would be black; add [[light]] with kind = \"sky\"";
        return Err(checks.missing("light", mend));
    }
    let mut lights = Vec::new();
    for (index, table) in tables.iter().enumerate() {
        let light = Light { checks, index, table };
        light.refuse_foreign_keys()?;
        light.check_group()?;
        lights.extend(light.describe()?);
    }
    Ok(lights)
}

/// One `[[light]]` under examination.
struct Light<'a> {
    checks: &'a Checks<'a>,
    index: usize,
    table: &'a LightTable,
}

impl Light<'_> {
    fn key(&self, name: &str) -> String {
        format!("light.{}.{name}", self.index)
    }

    fn bad(&self, name: &str, mend: &str) -> SceneError {
        self.checks.bad(&self.key(name), mend)
    }

    fn refuse_foreign_keys(&self) -> Result<(), SceneError> {
        let own = keys_of(self.table.kind);
        let path = format!("light.{}", self.index);
        let mut written = self.checks.written_keys(&path);
        let Some(name) = written.find(|key| !SHARED.contains(key) && !own.contains(key)) else {
            return Ok(());
        };
        let owners: Vec<String> = LightKindName::ALL
            .into_iter()
            .filter(|other| keys_of(*other).contains(&name))
            .map(|other| format!("\"{}\"", other.name()))
            .collect();
        let mend = format!(
            "not a key of kind = \"{}\" but of {}; remove it or change the kind ({} takes: {})",
            self.table.kind.name(),
            owners.join(", "),
            self.table.kind.name(),
            own.join(", "),
        );
        Err(self.checks.misplaced(&self.key(name), mend))
    }

    fn check_group(&self) -> Result<(), SceneError> {
        match &self.table.group {
            Some(group) if group.is_empty() || group.chars().any(char::is_control) => {
                Err(self.bad("group", "must be a name, as \"lamps\""))
            }
            _ => Ok(()),
        }
    }

    /// The lights that the table stands for.
    fn describe(&self) -> Result<Vec<LightDescription>, SceneError> {
        let kind = match self.table.kind {
            LightKindName::Sky => LightKind::Sky,
            LightKindName::Uniform => LightKind::Uniform,
            LightKindName::Overcast => LightKind::Overcast,
            LightKindName::ClearSky => return Ok(vec![self.clear_day()?.sky(self)?]),
            LightKindName::Sun => return Ok(vec![self.clear_day()?.sun(self)?]),
            LightKindName::SunSky => {
                let day = self.clear_day()?;
                return Ok(vec![day.sun(self)?, day.sky(self)?]);
            }
        };
        let radiance = self.table.radiance.unwrap_or(Triple([1.0; 3]));
        let radiance = self.checks.radiance(&self.key("radiance"), radiance)?;
        Ok(vec![self.light(kind, radiance, Illuminant::D65)])
    }

    /// A light with this spectrum, where the table says none.
    fn light(&self, kind: LightKind, strength: [f32; 3], spectrum: Illuminant) -> LightDescription {
        let group = self.table.group.clone();
        LightDescription {
            group: group.unwrap_or_else(|| kind.default_group().to_owned()),
            kind,
            strength,
            spectrum: self.table.spectrum.map_or(spectrum, illuminant),
            visible_to_camera: self.table.visible_to_camera,
        }
    }

    fn clear_day(&self) -> Result<ClearDay, SceneError> {
        let mend = "say how high the sun stands, as elevation = 30";
        let elevation = self.table.elevation;
        let elevation =
            elevation.ok_or_else(|| self.checks.missing(&self.key("elevation"), mend))?;
        if !(elevation > 0.0 && elevation <= 90.0) {
            let mend =
                "must be above 0 (the sun below the horizon gives no light) and at most 90 degrees";
            return Err(self.bad("elevation", mend));
        }
        let azimuth = self.table.azimuth.unwrap_or(0.0);
        let [azimuth] = self.checks.finite(&self.key("azimuth"), [azimuth])?;
        Ok(ClearDay {
            direction: direction_of(elevation, azimuth.rem_euclid(360.0)),
            zenith: 90.0 - elevation,
        })
    }
}

/// Sun and sky of a clear day over snow.
struct ClearDay {
    /// Towards the sun.
    direction: DVec3,
    /// Zenith angle of the sun, degrees.
    zenith: f64,
}

impl ClearDay {
    fn sun(&self, light: &Light<'_>) -> Result<LightDescription, SceneError> {
        let diameter = light.table.angular_diameter.unwrap_or(clear_sky::SUN_DIAMETER_DEGREES);
        if !(diameter >= 1e-3 && diameter <= 90.0) {
            let mend = "must be 0.001 to 90 degrees (the sun has 0.533)";
            return Err(light.bad("angular_diameter", mend));
        }
        let [across, _] = self.illuminances(light);
        let strength = self.strength(light, across / irradiance_of_disc(diameter))?;
        let kind = LightKind::Sun { direction: self.direction, diameter_degrees: diameter };
        Ok(light.light(kind, strength, Illuminant::Sun(SunZenith::new(self.zenith))))
    }

    fn sky(&self, light: &Light<'_>) -> Result<LightDescription, SceneError> {
        let [_, diffuse] = self.illuminances(light);
        let strength = self.strength(light, diffuse / PI)?;
        let kind = LightKind::ClearSky { sun: self.direction };
        Ok(light.light(kind, strength, Illuminant::ClearSky(SunZenith::new(self.zenith))))
    }

    /// By the sun across its light and by the sky on level ground, in the units of the light.
    fn illuminances(&self, light: &Light<'_>) -> [f64; 2] {
        let [across, diffuse] = clear_sky::illuminances(self.zenith);
        let unit = match light.table.units.unwrap_or_default() {
            UnitsName::CandelaPerSquareMetre => 1.0,
            UnitsName::Relative => PI / (across * self.direction.y + diffuse),
        };
        [across * unit, diffuse * unit]
    }

    /// So many times what the table says.
    fn strength(&self, light: &Light<'_>, times: f64) -> Result<[f32; 3], SceneError> {
        let Triple(strength) = light.table.strength.unwrap_or(Triple([1.0; 3]));
        let strength = Triple(strength.map(|strength| strength * times));
        light.checks.radiance(&light.key("strength"), strength)
    }
}

fn illuminant(name: SpectrumName) -> Illuminant {
    match name {
        SpectrumName::D65 => Illuminant::D65,
        SpectrumName::D55 => Illuminant::D55,
        SpectrumName::A => Illuminant::A,
        SpectrumName::EqualEnergy => Illuminant::EqualEnergy,
    }
}
