//! What a grain of the medium does to a path.

use super::MediumKind;
use core::f64::consts::TAU;
use snowgrain_math::{DVec3, frame, trig};
use snowgrain_optics::scatter::Way;
use snowgrain_optics::{BohrenBarkstrom, Dielectric, ScatterTable};

/// What a grain does to a path: the closed form of a sphere, or that of its refracted light alone.
#[derive(Clone, Debug)]
pub(super) enum Scattering {
    /// Grains are points.
    Refracted(BohrenBarkstrom),
    /// Grains are spheres, by a table of their closed form.
    Sphere(ScatterTable),
}

/// How a path goes on from a grain. Lengths in its radii.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Passage {
    /// Unit direction.
    pub(super) direction: DVec3,
    /// From where the path met the grain to where it leaves it.
    pub(super) displacement: DVec3,
    /// Length in ice.
    pub(super) length: f64,
    /// Outward normal where the path met the grain; `None` where grains are points.
    pub(super) normal: Option<DVec3>,
}

impl Scattering {
    /// `None` where light meets no grains.
    pub(super) fn new(kind: MediumKind, eta: f64) -> Option<Self> {
        let medium = Dielectric { eta };
        match kind {
            MediumKind::Volume => Some(Self::Refracted(BohrenBarkstrom::new(medium))),
            MediumKind::Proxy => Some(Self::Sphere(ScatterTable::for_air(medium))),
            MediumKind::Dipole => None,
        }
    }

    /// How a path that arrives along `direction` goes on; four uniform numbers.
    pub(super) fn sample(&self, direction: DVec3, [a, b, c, turn]: [f64; 4]) -> Passage {
        let (s, t) = frame::tangents(direction);
        let (sin, cos) = trig::sin_cos(TAU * turn);
        let aside = s * cos + t * sin;
        match self {
            Self::Refracted(refracted) => {
                let ray = refracted.sample(a);
                Passage::of_point(turned(direction, aside, ray.cosine), ray.length)
            }
            Self::Sphere(table) => match table.sample([a, b, c]) {
                Some((cosine, way)) => Passage::through(direction, aside, cosine, way),
                // One ray in a million, of many reflections, that the table leaves out.
                None => Passage::of_point(direction, 0.0),
            },
        }
    }

    /// Density of scattering from one direction into another, 1/sr, and one way of those that make it up; two
    /// uniform numbers. `None` where there is none.
    pub(super) fn towards(
        &self,
        direction: DVec3,
        wanted: DVec3,
        random: [f64; 2],
    ) -> Option<(f64, Passage)> {
        let cosine = direction.dot(wanted).clamp(-1.0, 1.0);
        match self {
            Self::Refracted(refracted) => {
                let density = refracted.density(cosine);
                let length = refracted.length(cosine);
                (density > 0.0).then(|| (density, Passage::of_point(wanted, length)))
            }
            Self::Sphere(table) => {
                let way = table.way(cosine, random)?;
                let aside = (wanted - direction * cosine).try_normalize();
                let aside = aside.unwrap_or_else(|| frame::tangents(direction).0);
                Some((table.density(cosine), Passage::through(direction, aside, cosine, way)))
            }
        }
    }
}

impl Passage {
    fn of_point(direction: DVec3, length: f64) -> Self {
        Self { direction, displacement: DVec3::ZERO, length, normal: None }
    }

    /// A way through a sphere in the plane of two unit vectors across each other.
    fn through(direction: DVec3, aside: DVec3, cosine: f64, way: Way) -> Self {
        let normal = |angle: f64| {
            let (sin, cos) = trig::sin_cos(angle);
            direction * cos + aside * sin
        };
        let entry = normal(way.entry);
        Self {
            direction: turned(direction, aside, cosine),
            displacement: normal(way.exit) - entry,
            length: way.length,
            normal: Some(entry),
        }
    }
}

/// A direction turned towards a unit vector across it by an angle of this cosine.
fn turned(direction: DVec3, aside: DVec3, cosine: f64) -> DVec3 {
    let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
    (direction * cosine + aside * sine).normalize()
}
