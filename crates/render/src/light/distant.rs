//! Lights at infinity: their radiance in a direction, and how directions are drawn towards them.

use super::clear_sky::ClearSky;
use super::description::LightKind;
use super::direction_table::direction_at;
use super::environment::Environment;
use core::f64::consts::{PI, TAU};
use snowgrain_math::{DVec3, frame, trig};
use std::sync::Arc;

/// A light at infinity, of strength 1.
#[derive(Clone, Debug)]
pub(super) enum Distant {
    Sky,
    Uniform,
    Overcast,
    ClearSky(ClearSky),
    Sun(Disc),
    Environment(Arc<Environment>),
}

/// A disc of directions.
#[derive(Clone, Copy, Debug)]
pub(super) struct Disc {
    middle: DVec3,
    /// One less the cosine of the angle from the middle to the rim, which keeps its digits.
    versine: f64,
}

impl Distant {
    /// A light of this kind; `None` for one within reach.
    pub(super) fn new(kind: &LightKind) -> Option<Self> {
        Some(match *kind {
            LightKind::Sky => Self::Sky,
            LightKind::Uniform => Self::Uniform,
            LightKind::Overcast => Self::Overcast,
            LightKind::ClearSky { sun } => Self::ClearSky(ClearSky::new(sun)),
            LightKind::Sun { direction, diameter_degrees } => {
                Self::Sun(Disc::new(direction, diameter_degrees))
            }
            LightKind::Environment { ref map, rotation_degrees } => {
                Self::Environment(Arc::new(Environment::new(map, rotation_degrees)))
            }
            LightKind::Sphere { .. }
            | LightKind::Quad { .. }
            | LightKind::Object { .. }
            | LightKind::Point { .. }
            | LightKind::Spot { .. } => return None,
        })
    }

    /// The same light, a disc at least as wide as this angle (degrees).
    pub(super) fn widened(&self, diameter_degrees: f64) -> Self {
        match self {
            Self::Sun(disc) => {
                let wide = Disc::new(disc.middle, diameter_degrees);
                Self::Sun(if wide.versine > disc.versine { wide } else { *disc })
            }
            other => other.clone(),
        }
    }

    /// Radiance from a direction.
    pub(super) fn radiance(&self, direction: DVec3) -> [f32; 3] {
        let above = direction.y > 0.0;
        let white = match self {
            Self::Sky => f64::from(u8::from(above)),
            Self::Uniform => 1.0,
            Self::Overcast if above => (1.0 + 2.0 * direction.y) / 3.0,
            Self::Overcast => 0.0,
            Self::ClearSky(sky) => sky.radiance(direction),
            Self::Sun(disc) => f64::from(u8::from(disc.contains(direction))),
            Self::Environment(environment) => return environment.radiance(direction),
        };
        [white as f32; 3]
    }

    /// A direction of its light.
    pub(super) fn sample(&self, u: [f64; 2]) -> Option<DVec3> {
        let around = |height: f64| direction_at(height, u[1]);
        match self {
            Self::Sky => Some(around(1.0 - u[0])),
            Self::Uniform => Some(around(1.0 - 2.0 * u[0])),
            Self::Overcast => {
                // The share of light below height y is (y + y^2) / 2.
                let below = 1.0 - u[0];
                Some(around(4.0 * below / (1.0 + (1.0 + 8.0 * below).sqrt())))
            }
            Self::ClearSky(sky) => sky.sample(u),
            Self::Sun(disc) => Some(disc.sample(u)),
            Self::Environment(environment) => environment.sample(u),
        }
    }

    /// Density of [`Self::sample`], 1/sr.
    pub(super) fn density(&self, direction: DVec3) -> f64 {
        let above = direction.y > 0.0;
        match self {
            Self::Sky => f64::from(u8::from(above)) / TAU,
            Self::Uniform => 0.5 / TAU,
            Self::Overcast if above => (1.0 + 2.0 * direction.y) / (2.0 * TAU),
            Self::Overcast => 0.0,
            Self::ClearSky(sky) => sky.density(direction),
            Self::Sun(disc) => f64::from(u8::from(disc.contains(direction))) / disc.solid_angle(),
            Self::Environment(environment) => environment.density(direction),
        }
    }

    /// Its luminance summed over all directions.
    pub(super) fn total(&self) -> f64 {
        match self {
            Self::Sky => TAU,
            Self::Uniform => 2.0 * TAU,
            Self::Overcast => 2.0 / 3.0 * TAU,
            Self::ClearSky(sky) => sky.total(),
            Self::Sun(disc) => disc.solid_angle(),
            Self::Environment(environment) => environment.total(),
        }
    }

    /// Solid angle that it fills, sr.
    pub(super) fn solid_angle(&self) -> f64 {
        match self {
            Self::Sky | Self::Overcast | Self::ClearSky(_) => TAU,
            Self::Uniform | Self::Environment(_) => 2.0 * TAU,
            Self::Sun(disc) => disc.solid_angle(),
        }
    }

    /// Whether its radiance is the same all over a hemisphere.
    pub(super) fn is_constant(&self) -> bool {
        match self {
            Self::Sky | Self::Uniform => true,
            Self::Overcast | Self::ClearSky(_) | Self::Sun(_) | Self::Environment(_) => false,
        }
    }

    /// What scales the ice paths of a film where it is so bright: about its greatest radiance, of discs and
    /// bright spots a small part.
    pub(super) fn scale(&self) -> f32 {
        match self {
            Self::Sky | Self::Uniform | Self::Overcast => 1.0,
            Self::ClearSky(sky) => sky.greatest() as f32,
            Self::Sun(_) => 1.0 / SPOT_OVER_SCALE,
            Self::Environment(environment) => {
                let mean = environment.total() / (2.0 * TAU);
                (environment.greatest() / SPOT_OVER_SCALE).max(mean as f32)
            }
        }
    }
}

/// How many times brighter than what scales a film's ice paths a spot may be.
pub(super) const SPOT_OVER_SCALE: f32 = 32_768.0;

impl Disc {
    fn new(middle: DVec3, diameter_degrees: f64) -> Self {
        // 1 - cos a = 2 sin^2 (a / 2), with a half of the diameter.
        let (sin, _) = trig::sin_cos((diameter_degrees * 0.25).to_radians());
        Self { middle, versine: 2.0 * sin * sin }
    }

    fn contains(&self, direction: DVec3) -> bool {
        // The square of the chord is twice the versine.
        (direction - self.middle).length_squared() <= 2.0 * self.versine
    }

    fn sample(&self, u: [f64; 2]) -> DVec3 {
        let (s, t) = frame::tangents(self.middle);
        let versine = u[0] * self.versine;
        let across = (versine * (2.0 - versine)).sqrt();
        let (sin, cos) = trig::sin_cos(TAU * u[1]);
        (self.middle * (1.0 - versine) + s * (across * cos) + t * (across * sin)).normalize()
    }

    pub(super) fn solid_angle(&self) -> f64 {
        TAU * self.versine
    }
}

/// Irradiance by a disc of radiance 1 of a plane across its light: pi times the square of the sine of the
/// angle from its middle to its rim.
#[must_use]
pub fn irradiance_of_disc(diameter_degrees: f64) -> f64 {
    let (sin, _) = trig::sin_cos((diameter_degrees * 0.5).to_radians());
    PI * sin * sin
}
