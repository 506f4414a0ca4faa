//! Lights within reach: luminous surfaces, and points that shine.

use super::area::Area;
use super::description::LightKind;
use super::emitters::{Emitter, SurfaceLight};
use snowgrain_accel::SurfaceId;
use snowgrain_math::{DVec3, trig};

/// A light within reach, of strength 1.
#[derive(Clone, Debug)]
pub(super) enum Near {
    /// A surface of this object, where it has points to be drawn.
    Surface(Option<Area>, Emitter, u32),
    Point(DVec3),
    Spot(Spot),
}

/// A point that shines into a cone.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spot {
    position: DVec3,
    axis: DVec3,
    /// Cosines of the angles from the axis within which it is whole, and from which on it is dark.
    inner: f64,
    outer: f64,
}

/// A way towards a light within reach.
pub(super) struct Way {
    pub(super) direction: DVec3,
    pub(super) distance: f64,
    /// Radiance; of a point its intensity over the square of the distance.
    pub(super) radiance: f64,
    /// Density of the direction, 1/sr; of a point 1.
    pub(super) density: f64,
    /// The surface that shines.
    pub(super) surface: Option<SurfaceId>,
}

impl Near {
    /// A light of this kind; `None` for one at infinity.
    pub(super) fn new(kind: &LightKind, surface: Option<SurfaceLight>) -> Option<Self> {
        if let Some(SurfaceLight { shape, transform, emitter, object }) = surface {
            return Some(Self::Surface(Area::new(&shape, &transform), emitter, object));
        }
        match *kind {
            LightKind::Point { position } => Some(Self::Point(position)),
            LightKind::Spot { position, direction, inner_degrees, outer_degrees } => {
                let cosine = |degrees: f64| trig::sin_cos(degrees.to_radians()).1;
                let axis = direction.normalize();
                let (inner, outer) = (cosine(inner_degrees), cosine(outer_degrees));
                Some(Self::Spot(Spot { position, axis, inner, outer }))
            }
            LightKind::Sky
            | LightKind::Uniform
            | LightKind::Overcast
            | LightKind::ClearSky { .. }
            | LightKind::Sun { .. }
            | LightKind::Environment { .. }
            | LightKind::Sphere { .. }
            | LightKind::Quad { .. }
            | LightKind::Object { .. } => None,
        }
    }

    /// A way from a point towards it; `None` where the numbers give none.
    pub(super) fn sample(&self, from: DVec3, u: [f64; 3]) -> Option<Way> {
        match self {
            Self::Surface(area, emitter, object) => {
                let point = area.as_ref()?.sample(from, u)?;
                let id = SurfaceId { object: *object, piece: point.piece };
                let seen = emitter.shines_towards(-point.direction);
                seen.then_some(Way {
                    direction: point.direction,
                    distance: point.distance,
                    radiance: 1.0,
                    density: point.density,
                    surface: Some(id),
                })
            }
            Self::Point(position) => towards_point(*position, from, |_| 1.0),
            Self::Spot(spot) => towards_point(spot.position, from, |away| spot.share(away)),
        }
    }

    /// Density of [`Self::sample`] of a point of its surface, 1/sr as seen from `from`.
    pub(super) fn density(&self, from: DVec3, point: DVec3, normal: DVec3) -> f64 {
        match self {
            Self::Surface(Some(area), emitter, _) if emitter.shines_towards(from - point) => {
                area.density(from, point, normal)
            }
            Self::Surface(..) | Self::Point(_) | Self::Spot(_) => 0.0,
        }
    }

    /// The mean area of its shadow; 0 for points.
    pub(super) fn shadow(&self) -> f64 {
        match self {
            Self::Surface(area, ..) => area.as_ref().map_or(0.0, Area::shadow),
            Self::Point(_) | Self::Spot(_) => 0.0,
        }
    }

    /// Where it is; `None` for a surface without end.
    pub(super) fn center(&self) -> Option<DVec3> {
        match self {
            Self::Surface(area, ..) => area.as_ref().map(Area::center),
            Self::Point(position) => Some(*position),
            Self::Spot(spot) => Some(spot.position),
        }
    }

    /// Whether it is a point, which no path meets.
    pub(super) fn is_point(&self) -> bool {
        matches!(self, Self::Point(_) | Self::Spot(_))
    }
}

/// A way to a point that shines by `share(direction away from it)`.
fn towards_point(position: DVec3, from: DVec3, share: impl Fn(DVec3) -> f64) -> Option<Way> {
    let offset = position - from;
    let distance = offset.length();
    let direction = offset / distance;
    let radiance = share(-direction) / (distance * distance);
    let reaches = radiance > 0.0 && radiance.is_finite();
    reaches.then_some(Way { direction, distance, radiance, density: 1.0, surface: None })
}

impl Spot {
    /// The share of its intensity in a direction: 1 within the inner cone, 0 beyond the outer, and between
    /// them 3 t^2 - 2 t^3 of the cosine's part t.
    fn share(&self, away: DVec3) -> f64 {
        let cosine = away.dot(self.axis);
        if cosine >= self.inner {
            return 1.0;
        }
        let t = ((cosine - self.outer) / (self.inner - self.outer)).max(0.0);
        t * t * (3.0 - 2.0 * t)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_falls_off_with_the_square_and_a_spot_with_the_angle() {
        let point = Near::new(&LightKind::Point { position: DVec3::Y * 3.0 }, None).unwrap();
        let way = point.sample(DVec3::Y, [0.5; 3]).unwrap();
        assert_eq!((way.direction, way.distance, way.radiance), (DVec3::Y, 2.0, 0.25));
        assert!(point.sample(DVec3::Y * 3.0, [0.5; 3]).is_none());
        let kind = LightKind::Spot {
            position: DVec3::Y,
            direction: DVec3::NEG_Y * 2.0,
            inner_degrees: 20.0,
            outer_degrees: 40.0,
        };
        let spot = Near::new(&kind, None).unwrap();
        let at = |degrees: f64| {
            let from = DVec3::new(trig::tan(degrees.to_radians()), 0.0, 0.0);
            spot.sample(from, [0.5; 3]).map(|way| way.radiance * way.distance * way.distance)
        };
        assert!((at(19.9).unwrap() - 1.0).abs() < 1e-12);
        assert!((0.1..0.9).contains(&at(32.0).unwrap()));
        assert_eq!(at(40.1), None);
    }
}
