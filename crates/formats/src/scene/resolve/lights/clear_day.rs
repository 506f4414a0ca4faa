//! Sun and sky of a clear day, by the angles of the sun or by place and time.

use super::super::super::SceneError;
use super::super::super::document::UnitsName;
use super::super::super::quantity::Triple;
use super::Light;
use core::f64::consts::PI;
use snowgrain_math::DVec3;
use snowgrain_optics::sun_position::{SunPosition, UniversalTime, sun_position};
use snowgrain_optics::{Illuminant, SunZenith, clear_sky};
use snowgrain_render::description::{LightDescription, LightKind};
use snowgrain_render::light::{direction_of, irradiance_of_disc};
use toml::value::{Datetime, Offset};

/// Sun and sky of a clear day over snow.
pub(super) struct ClearDay {
    /// Towards the sun.
    direction: DVec3,
    /// Zenith angle of the sun, degrees.
    zenith: f64,
}

impl ClearDay {
    /// Of a light of which the table says where the sun stands.
    pub(super) fn of(light: &Light<'_>) -> Result<Self, SceneError> {
        let SunPosition { elevation, azimuth } = match &light.table.time {
            Some(time) => light.sun_at(time)?,
            None => light.sun_by_angles()?,
        };
        Ok(Self { direction: direction_of(elevation, azimuth), zenith: 90.0 - elevation })
    }

    pub(super) fn sun(&self, light: &Light<'_>) -> Result<LightDescription, SceneError> {
        let diameter = light.table.angular_diameter.unwrap_or(clear_sky::SUN_DIAMETER_DEGREES);
        if !(1e-3..=90.0).contains(&diameter) {
            let mend = "must be 0.001 to 90 degrees (the sun has 0.533)";
            return Err(light.bad("angular_diameter", mend));
        }
        let [across, _] = self.illuminances(light);
        let strength = self.strength(light, across / irradiance_of_disc(diameter))?;
        let kind = LightKind::Sun { direction: self.direction, diameter_degrees: diameter };
        Ok(light.light(kind, strength, Illuminant::Sun(SunZenith::new(self.zenith))))
    }

    pub(super) fn sky(&self, light: &Light<'_>) -> Result<LightDescription, SceneError> {
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

impl Light<'_> {
    fn sun_by_angles(&self) -> Result<SunPosition, SceneError> {
        for (name, value) in
            [("latitude", self.table.latitude), ("longitude", self.table.longitude)]
        {
            if value.is_some() {
                let mend =
                    "a place says where the sun stands only with a time; write time, or remove it";
                return Err(self.checks.misplaced(&self.key(name), mend));
            }
        }
        let mend =
            "say how high the sun stands, as elevation = 30, or write time, latitude and longitude";
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
        Ok(SunPosition { elevation, azimuth: azimuth.rem_euclid(360.0) })
    }

    fn sun_at(&self, time: &str) -> Result<SunPosition, SceneError> {
        for (name, given) in [
            ("elevation", self.table.elevation.is_some()),
            ("azimuth", self.table.azimuth.is_some()),
        ] {
            if given {
                let mend = "time says where the sun stands, too; keep one of them";
                return Err(self.checks.misplaced(&self.key(name), mend));
            }
        }
        let degrees = |name: &str, value: Option<f64>, most: f64| {
            let mend = format!("say where, as {name} = 47");
            let value = value.ok_or_else(|| self.checks.missing(&self.key(name), mend))?;
            if (-most..=most).contains(&value) {
                return Ok(value);
            }
            Err(self.bad(name, &format!("must be {} to {most} degrees", -most)))
        };
        let latitude = degrees("latitude", self.table.latitude, 90.0)?;
        let longitude = degrees("longitude", self.table.longitude, 180.0)?;
        let when = universal_time(time).map_err(|mend| self.bad("time", &mend))?;
        let position = sun_position(latitude, longitude, when);
        if position.elevation <= 0.0 {
            let mend = format!(
                "the sun is then {:.1} degrees below the horizon and gives no light; choose another time",
                -position.elevation
            );
            return Err(self.bad("time", &mend));
        }
        Ok(position)
    }
}

/// The moment of a text like "2026-01-15T14:30:00+01:00".
fn universal_time(text: &str) -> Result<UniversalTime, String> {
    let form = "write it as \"2026-01-15T14:30:00+01:00\", with the offset from UTC";
    let known: Datetime = text.trim().parse().map_err(|_| form.to_owned())?;
    let (Some(date), Some(time), Some(offset)) = (known.date, known.time, known.offset) else {
        return Err(form.to_owned());
    };
    if !(1950..=2050).contains(&date.year) {
        return Err("must be of the years 1950 to 2050".to_owned());
    }
    let minutes = match offset {
        Offset::Z => 0,
        Offset::Custom { minutes } => minutes,
    };
    let seconds = f64::from(time.second.unwrap_or(0));
    let hours = f64::from(time.hour) + f64::from(time.minute) / 60.0 + seconds / 3600.0;
    let hours = hours - f64::from(minutes) / 60.0;
    Ok(UniversalTime::new(i32::from(date.year), date.month, date.day, hours))
}
