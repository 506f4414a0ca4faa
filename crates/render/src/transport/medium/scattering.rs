//! What a grain of the medium does to a path.

use super::MediumKind;
use core::f64::consts::TAU;
use snowgrain_math::{DVec3, frame, trig};
use snowgrain_optics::scatter::{PassageTable, SpherePassage, Way};
use snowgrain_optics::{BohrenBarkstrom, Dielectric, ScatterTable};

/// What a grain does to a path: the closed form of a sphere, or that of its refracted light alone.
#[derive(Clone, Debug)]
pub(super) enum Scattering {
    /// Grains are points.
    Refracted(BohrenBarkstrom),
    /// Grains are spheres, by tables of their closed form: of passages, and of ways into a given direction.
    Sphere(PassageTable, ScatterTable),
}

/// Directions across another of which one is drawn.
#[derive(Clone, Debug)]
pub(super) struct Azimuths {
    cos_sin: Vec<[f32; 2]>,
}

impl Azimuths {
    const COUNT: u16 = 1 << 10;

    pub(super) fn new() -> Self {
        let at = |index: u16| {
            let (sin, cos) = trig::sin_cos(TAU * f64::from(index) / f64::from(Self::COUNT));
            [cos as f32, sin as f32]
        };
        Self { cos_sin: (0..Self::COUNT).map(at).collect() }
    }

    /// A unit vector across a direction, by a uniform number.
    #[inline]
    pub(super) fn across(&self, direction: DVec3, random: f64) -> DVec3 {
        let (s, t) = frame::tangents(direction);
        let [cos, sin] = self.cos_sin[(random * f64::from(Self::COUNT)) as usize];
        s * f64::from(cos) + t * f64::from(sin)
    }
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
            MediumKind::Proxy => {
                let ways = ScatterTable::for_air(medium);
                Some(Self::Sphere(PassageTable::for_air(medium), ways))
            }
            MediumKind::Dipole => None,
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
            Self::Sphere(_, table) => {
                let way = table.way(cosine, random)?;
                let aside = (wanted - direction * cosine).try_normalize();
                let aside = aside.unwrap_or_else(|| frame::tangents(direction).0);
                Some((table.density(cosine), Passage::through(direction, aside, cosine, way)))
            }
        }
    }
}

impl Passage {
    /// Of a point that refracts by an angle of this cosine, towards a unit vector across.
    pub(super) fn refracted(direction: DVec3, aside: DVec3, cosine: f64, length: f64) -> Self {
        Self::of_point(turned(direction, aside, cosine), length)
    }

    /// Through a sphere that is met on the side of a unit vector across the direction.
    #[inline]
    pub(super) fn of_sphere(direction: DVec3, aside: DVec3, passage: &SpherePassage) -> Self {
        let vector =
            |[along, across]: [f32; 2]| direction * f64::from(along) + aside * f64::from(across);
        let turned = vector(passage.direction);
        Self {
            // A step of Newton's towards unit length, which it has but for rounding.
            direction: turned * (1.5 - 0.5 * turned.length_squared()),
            displacement: vector(passage.displacement),
            length: f64::from(passage.length),
            normal: Some(vector(passage.entry)),
        }
    }

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
