//! What a grain of the medium does to a path.

use super::composition::Composition;
use super::shape_passages::ShapeKinds;
use super::{Calibration, MediumKind};
use core::f64::consts::TAU;
use snowgrain_math::sampler::{PathKey, numbers};
use snowgrain_math::{DVec3, frame, trig};
use snowgrain_optics::scatter::{PassageTable, SpherePassage, Way};
use snowgrain_optics::{BohrenBarkstrom, Dielectric, ScatterTable};

/// What a grain does to a path: the closed form of a sphere, or that of its refracted light alone, or samples.
#[derive(Clone, Debug)]
pub(super) enum Scattering {
    /// Grains are points.
    Refracted(BohrenBarkstrom),
    /// Grains are spheres, by tables of their closed form: of passages, and of ways into a given direction.
    Sphere(PassageTable, ScatterTable),
    /// Grains have shapes, one for each kind.
    Shapes(ShapeKinds),
}

/// What tells the random numbers of grains that turn light twice.
const TWICE: u64 = 0x7_1ce;

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
    /// The direction from which it was turned into that, at last.
    pub(super) turned_from: DVec3,
    /// From where the path met the grain to where it leaves it.
    pub(super) displacement: DVec3,
    /// Length in ice.
    pub(super) length: f64,
    /// Where the path met the grain, from its centre; `None` where grains are points.
    pub(super) entry: Option<DVec3>,
    /// The kind of the grain that turned it at last.
    pub(super) kind: usize,
}

impl Scattering {
    /// Of grains of this composition and relative index. `None` where light meets no grains.
    pub(super) fn new(kind: MediumKind, composition: &Composition, eta: f64) -> Option<Self> {
        let medium = Dielectric { eta };
        match (kind, composition.shapes()) {
            (MediumKind::Volume, _) => Some(Self::Refracted(BohrenBarkstrom::new(medium))),
            (MediumKind::Proxy, None) => {
                let ways = ScatterTable::for_air(medium);
                Some(Self::Sphere(PassageTable::for_air(medium), ways))
            }
            (MediumKind::Proxy, Some(shapes)) => Some(Self::Shapes(ShapeKinds::new(&shapes, eta))),
            (MediumKind::Dipole, _) => None,
        }
    }

    /// Area of the shadows that light of a direction meets, over the mean of all directions, of grains that have these parts of that.
    #[inline]
    pub(super) fn shadow(&self, direction: DVec3, parts: &[u8]) -> f64 {
        match self {
            Self::Refracted(_) | Self::Sphere(..) => 1.0,
            Self::Shapes(kinds) => kinds.shadow(direction, parts),
        }
    }

    /// The largest of these.
    pub(super) fn largest_shadow(&self) -> f64 {
        match self {
            Self::Refracted(_) | Self::Sphere(..) => 1.0,
            Self::Shapes(kinds) => kinds.largest_shadow(),
        }
    }

    /// Whether grains do not do the same to light of all directions.
    pub(super) fn lies(&self) -> bool {
        matches!(self, Self::Shapes(kinds) if kinds.lie())
    }

    /// Memory of samples, bytes.
    pub(super) fn memory_bytes(&self) -> u64 {
        match self {
            Self::Refracted(_) | Self::Sphere(..) => 0,
            Self::Shapes(kinds) => kinds.memory_bytes(),
        }
    }

    /// Density of scattering from one direction into another, 1/sr, of light that a grain of a kind turns, and one way of those that make
    /// it up; two uniform numbers. `None` where there is none. The kind of the way is not told.
    pub(super) fn towards(
        &self,
        direction: DVec3,
        wanted: DVec3,
        (kind, random): (usize, [f64; 2]),
    ) -> Option<(f64, Passage)> {
        let cosine = direction.dot(wanted).clamp(-1.0, 1.0);
        match self {
            Self::Refracted(refracted) => {
                let density = refracted.density(cosine);
                let length = refracted.length(cosine);
                (density > 0.0).then(|| (density, Passage::of_point(direction, wanted, length)))
            }
            Self::Sphere(_, table) => {
                let way = table.way(cosine, random)?;
                let aside = (wanted - direction * cosine).try_normalize();
                let aside = aside.unwrap_or_else(|| frame::tangents(direction).0);
                Some((table.density(cosine), Passage::through(direction, aside, cosine, way)))
            }
            Self::Shapes(kinds) => kinds.towards(direction, wanted, (kind, random[0])),
        }
    }

    /// What a grain does to a path, and whether that goes straight on; two uniform numbers, and what grains there are (see
    /// [`drawn_of`]). Some let it straight through, or turn it twice, by a calibration.
    #[inline(always)]
    pub(super) fn draw(
        &self,
        direction: DVec3,
        (azimuths, calibration): (&Azimuths, &Calibration),
        (parts, [way, turn]): (&[u8], [f64; 2]),
    ) -> (Passage, bool) {
        let straight = calibration.straight;
        let (mut passage, is_straight) = if turn < straight {
            self.draw_lone(direction, azimuths, (parts, [way, turn / straight]), true)
        } else if turn < -straight {
            (self.draw_twice(direction, azimuths, (parts, [way, turn])), false)
        } else {
            let left = straight.abs();
            let turn = if left > 0.0 { (turn - left) / (1.0 - left) } else { turn };
            self.draw_lone(direction, azimuths, (parts, [way, turn]), false)
        };
        passage.length *= calibration.ice;
        (passage, is_straight)
    }

    /// As a lone grain does; or, where it lets light pass, straight on, with the ice of the way that it else would have.
    #[inline(always)]
    fn draw_lone(
        &self,
        direction: DVec3,
        azimuths: &Azimuths,
        (parts, [way, turn]): (&[u8], [f64; 2]),
        passes: bool,
    ) -> (Passage, bool) {
        match self {
            Self::Refracted(refracted) => {
                let aside = azimuths.across(direction, turn);
                let ray = refracted.sample(way);
                (Passage::refracted(direction, aside, ray.cosine, ray.length), false)
            }
            Self::Sphere(passages, _) => {
                let (passage, rest) = passages.draw(way);
                let aside = azimuths.across(direction, rest);
                let (kind, _) = drawn_of(parts, turn, |_| 1.0);
                let passage = match passes {
                    true => Passage::of_sphere(direction, aside, &passage.straight()),
                    false => Passage::of_sphere(direction, aside, passage),
                };
                (Passage { kind, ..passage }, passes)
            }
            Self::Shapes(kinds) => kinds.draw(direction, azimuths, (parts, [way, turn]), passes),
        }
    }

    /// As a lone grain does, and turned once more where it comes in or where it leaves, as likely: so light that goes back does the same.
    fn draw_twice(
        &self,
        direction: DVec3,
        azimuths: &Azimuths,
        (parts, drawn): (&[u8], [f64; 2]),
    ) -> Passage {
        let [way, turn] = drawn.map(f64::to_bits);
        let key = PathKey::new(way, turn, TWICE);
        let [first, second] = [0, 1].map(|event| numbers(key, event).map(f64::from));
        let once = |direction, [way, turn, _]: [f64; 3]| {
            self.draw_lone(direction, azimuths, (parts, [way, turn]), false).0
        };
        if first[2] < 0.5 {
            return once(once(direction, first).direction, second);
        }
        let passage = once(direction, first);
        let last = once(passage.direction, second);
        let (direction, turned_from, kind) = (last.direction, passage.direction, last.kind);
        Passage { direction, turned_from, kind, ..passage }
    }
}

/// One of the kinds of grains that have these parts of all in their mean shadows, each with a shadow over the mean; by a uniform number,
/// and what is left of that. The only one where there are no parts.
#[inline]
pub(super) fn drawn_of(parts: &[u8], random: f64, shadow: impl Fn(usize) -> f64) -> (usize, f64) {
    let part_of = |(kind, &part): (usize, &u8)| f64::from(part) * shadow(kind);
    let all: f64 = parts.iter().enumerate().map(part_of).sum();
    let mut wanted = random * all;
    for (kind, part) in parts.iter().enumerate() {
        let part = part_of((kind, part));
        if wanted < part {
            return (kind, (wanted / part).min(1.0f64.next_down()));
        }
        wanted -= part;
    }
    (0, random)
}

impl Passage {
    /// Of a point that refracts by an angle of this cosine, towards a unit vector across.
    pub(super) fn refracted(direction: DVec3, aside: DVec3, cosine: f64, length: f64) -> Self {
        Self::of_point(direction, turned(direction, aside, cosine), length)
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
            turned_from: direction,
            displacement: vector(passage.displacement),
            length: f64::from(passage.length),
            entry: Some(vector(passage.entry)),
            kind: 0,
        }
    }

    /// On as it came.
    pub(super) fn none(direction: DVec3) -> Self {
        Self::of_point(direction, direction, 0.0)
    }

    fn of_point(turned_from: DVec3, direction: DVec3, length: f64) -> Self {
        Self { direction, turned_from, displacement: DVec3::ZERO, length, entry: None, kind: 0 }
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
            turned_from: direction,
            displacement: normal(way.exit) - entry,
            length: way.length,
            entry: Some(entry),
            kind: 0,
        }
    }
}

/// A direction turned towards a unit vector across it by an angle of this cosine.
fn turned(direction: DVec3, aside: DVec3, cosine: f64) -> DVec3 {
    let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
    (direction * cosine + aside * sine).normalize()
}
