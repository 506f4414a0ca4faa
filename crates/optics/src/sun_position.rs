//! Where the sun stands, by place and time.
//!
//! Michalsky 1988, "The Astronomical Almanac's algorithm for approximate solar position (1950-2050)", Solar
//! Energy 40, 227: within .01 degrees in those years, with the mean refraction of air at sea level, which is
//! less well known near the horizon.

use snowgrain_math::trig;

/// Where the sun stands in the sky, degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SunPosition {
    /// Above the horizon, as seen through the air.
    pub elevation: f64,
    /// From north clockwise over east, in [0, 360).
    pub azimuth: f64,
}

/// A moment in Universal Time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UniversalTime {
    /// Days since noon of 1 January 2000.
    days: f64,
    /// Hours since midnight.
    hours: f64,
}

impl UniversalTime {
    /// So many hours (of any sign and size) after midnight of a day of the Gregorian calendar.
    #[must_use]
    pub fn new(year: i32, month: u8, day: u8, hours: f64) -> Self {
        // Fliegel and Van Flandern 1968, Commun. ACM 11, 657.
        let (year, month, day) = (i64::from(year), i64::from(month), i64::from(day));
        let late = (month - 14) / 12;
        let julian =
            day - 32_075 + 1461 * (year + 4800 + late) / 4 + 367 * (month - 2 - late * 12) / 12
                - 3 * ((year + 4900 + late) / 100) / 4;
        let whole = (hours / 24.0).floor();
        let days = (julian - 2_451_545) as f64 - 0.5 + whole;
        let hours = hours - 24.0 * whole;
        Self { days: days + hours / 24.0, hours }
    }
}

/// Where the sun stands as seen from a latitude (north is above 0) and a longitude (east is above 0), degrees.
#[must_use]
pub fn sun_position(latitude: f64, longitude: f64, time: UniversalTime) -> SunPosition {
    let UniversalTime { days, hours } = time;
    let sine = |degrees: f64| trig::sin_cos(degrees.rem_euclid(360.0).to_radians()).0;
    let anomaly = 357.528 + 0.985_600_3 * days;
    let longitude_in_ecliptic =
        280.460 + 0.985_647_4 * days + 1.915 * sine(anomaly) + 0.020 * sine(2.0 * anomaly);
    let (sin_l, cos_l) = trig::sin_cos(longitude_in_ecliptic.rem_euclid(360.0).to_radians());
    let (sin_o, cos_o) = trig::sin_cos((23.439 - 4e-7 * days).to_radians());
    let right_ascension = trig::atan2(cos_o * sin_l, cos_l).to_degrees();
    let sin_declination = sin_o * sin_l;
    let cos_declination = (1.0 - sin_declination * sin_declination).sqrt();
    let sidereal = 6.697_375 + 0.065_709_824_2 * days + hours;
    let hour_angle = (15.0 * sidereal + longitude - right_ascension).rem_euclid(360.0);
    let (sin_h, cos_h) = trig::sin_cos(hour_angle.to_radians());
    let (sin_b, cos_b) = trig::sin_cos(latitude.to_radians());
    let up = sin_declination * sin_b + cos_declination * cos_b * cos_h;
    let north = sin_declination * cos_b - cos_declination * sin_b * cos_h;
    let east = -cos_declination * sin_h;
    let elevation = trig::asin(up.clamp(-1.0, 1.0)).to_degrees();
    SunPosition {
        elevation: elevation + refraction(elevation),
        azimuth: trig::atan2(east, north).to_degrees().rem_euclid(360.0),
    }
}

/// By how many degrees air lifts the sun; nothing below the horizon.
fn refraction(elevation: f64) -> f64 {
    if elevation <= -0.56 {
        return 0.0;
    }
    3.51561 * (0.1594 + 0.0196 * elevation + 2e-5 * elevation * elevation)
        / (1.0 + 0.505 * elevation + 0.0845 * elevation * elevation)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sun_stands_where_a_precise_algorithm_says() {
        // Reda and Andreas 2004, "Solar position algorithm for solar radiation applications", Solar Energy 76,
        // 577, the example of the appendix: 17 October 2003, 12:30:30 at -7 h, zenith 50.112 degrees, azimuth
        // 194.340 degrees.
        let time = UniversalTime::new(2003, 10, 17, 12.0 + 30.5 / 60.0 + 7.0);
        let found = sun_position(39.742_476, -105.178_6, time);
        assert!((found.elevation - (90.0 - 50.112)).abs() < 0.05, "{found:?}");
        assert!((found.azimuth - 194.340).abs() < 0.05, "{found:?}");
    }

    #[test]
    fn noon_is_south_in_the_north_and_the_seasons_differ_by_twice_the_obliquity() {
        let noon = |month, latitude| {
            sun_position(latitude, 0.0, UniversalTime::new(2026, month, 21, 12.0))
        };
        let (june, december) = (noon(6, 47.0), noon(12, 47.0));
        assert!((june.elevation - december.elevation - 46.87).abs() < 0.1);
        assert!((june.azimuth - 180.0).abs() < 2.0);
        let south = noon(12, -47.0).azimuth;
        assert!(!(3.0..357.0).contains(&south), "{south}");
        assert!(sun_position(47.0, 0.0, UniversalTime::new(2026, 6, 21, 0.0)).elevation < -15.0);
    }

    #[test]
    fn hours_go_over_midnight_and_the_year() {
        let one = UniversalTime::new(2026, 1, 1, -1.0);
        let other = UniversalTime::new(2025, 12, 31, 23.0);
        assert_eq!(one, other);
        assert_eq!(UniversalTime::new(2000, 1, 1, 12.0).days, 0.0);
        assert_eq!(
            UniversalTime::new(2024, 3, 1, 0.0).days - UniversalTime::new(2024, 2, 28, 0.0).days,
            2.0
        );
    }
}
