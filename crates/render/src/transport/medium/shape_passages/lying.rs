//! Passages of light through grains of one shape as they lie: for each direction in which light comes its own.

use super::super::composition::Lying;
use super::super::scattering::Passage;
use super::{ShapePassage, aside, ways};
use crate::laboratory::Passed;
use core::f64::consts::TAU;
use snowgrain_geometry::Shape;
use snowgrain_math::{DMat3, DVec3, frame, trig};

/// Classes of the cosine by which light of one direction is turned, of as many passages each.
const STEPS: usize = 16;
/// Classes of the side to which it is turned.
const SIDES: usize = 16;

/// Equally likely passages, by classes of the direction in which light comes.
#[derive(Clone, Debug)]
pub(super) struct LyingPassages {
    directions: Directions,
    /// By class; within by step and side, those that go straight on last.
    passages: Vec<LyingPassage>,
    classes: Vec<Class>,
}

/// Light that comes in directions of a class.
#[derive(Clone, Debug)]
struct Class {
    /// The first of its passages.
    first: usize,
    count: usize,
    /// Shadow over the mean of all directions.
    shadow: f64,
    /// Cosines between which the steps lie, in rising order.
    edges: [f64; STEPS + 1],
    /// Before each side of each step, so many of its passages; at last all that are turned.
    before: [u32; STEPS * SIDES + 1],
}

/// A passage, and the side to which light is turned: cosine and sine of the angle from upwards, about its direction.
#[derive(Clone, Copy, Debug)]
struct LyingPassage {
    passage: ShapePassage,
    side: [f32; 2],
}

/// Classes of directions: of the height in each half of the sphere, of about equal angles, by so many of the azimuth.
#[derive(Clone, Copy, Debug)]
struct Directions {
    heights: usize,
    azimuths: usize,
}

impl Directions {
    /// Where all azimuths are alike.
    const TURNED_ALIKE: Self = Self { heights: 32, azimuths: 1 };
    /// Where they are not.
    const AIMED: Self = Self { heights: 16, azimuths: 32 };

    fn count(self) -> usize {
        2 * self.heights * self.azimuths
    }

    #[inline]
    fn of(self, direction: DVec3) -> usize {
        let part = |of: f64, count: usize| ((of * count as f64) as usize).min(count - 1);
        // 2^.5 times the sine of half the angle from the pole.
        let from_pole = (1.0 - direction.y.abs()).max(0.0).sqrt();
        let height = part(from_pole, self.heights) + usize::from(direction.y < 0.0) * self.heights;
        if self.azimuths == 1 {
            return height;
        }
        height * self.azimuths + part(turn(direction.x, direction.z), self.azimuths)
    }

    /// The part of all directions that are of a class.
    fn part(self, class: usize) -> f64 {
        let step = (class / self.azimuths % self.heights) as f64;
        let area = (2.0 * step + 1.0) / (self.heights * self.heights) as f64;
        0.5 * area / self.azimuths as f64
    }
}

/// The angle of a vector in a plane, in turns from 0 to 1.
fn turn(x: f64, y: f64) -> f64 {
    0.5 + trig::atan2(y, x) / TAU
}

/// The unit vector across a direction that is most upwards.
#[inline]
fn upwards(direction: DVec3) -> DVec3 {
    let up = DVec3::Y - direction * direction.y;
    let length = up.length_squared();
    if length > 1e-12 { up / length.sqrt() } else { frame::tangents(direction).0 }
}

impl LyingPassages {
    /// Of a shape of this refractive index.
    pub(super) fn new((shape, lying): (&Shape, &Lying), eta: f64) -> Self {
        let (directions, wanted) = match lying.is_turned_alike() {
            true => (Directions::TURNED_ALIKE, 1 << 17),
            false => (Directions::AIMED, 1 << 18),
        };
        let mut by_class = vec![Vec::new(); directions.count()];
        // A way and its reversal are of one grain.
        for (number, way) in ways(shape, eta, wanted).enumerate() {
            let way = turned(&way, lying.rotation(number / 2));
            by_class[directions.of(way.incident)].push(LyingPassage::of(&way));
        }
        let (mut passages, mut classes) = (Vec::with_capacity(2 * wanted), Vec::new());
        for (class, mut of_class) in by_class.into_iter().enumerate() {
            let expected = (2 * wanted) as f64 * directions.part(class);
            classes.push(Class::of(&mut of_class, passages.len(), expected));
            passages.append(&mut of_class);
        }
        Self { directions, passages, classes }
    }

    /// Memory, bytes.
    pub(super) fn memory_bytes(&self) -> u64 {
        (size_of_val(self.passages.as_slice()) + size_of_val(self.classes.as_slice())) as u64
    }

    #[inline]
    fn class(&self, direction: DVec3) -> &Class {
        &self.classes[self.directions.of(direction)]
    }

    /// As [`super::ShapePassages::shadow`].
    #[inline]
    pub(super) fn shadow(&self, direction: DVec3) -> f64 {
        self.class(direction).shadow
    }

    /// As [`super::ShapePassages::largest_shadow`].
    pub(super) fn largest_shadow(&self) -> f64 {
        self.classes.iter().map(|class| class.shadow).fold(0.0, f64::max)
    }

    /// The passage of a class by a uniform number, the unit vector aside, and whether it goes straight on; `None` of a shadow of no area.
    #[inline]
    fn drawn(&self, direction: DVec3, random: f64) -> Option<(&ShapePassage, DVec3, bool)> {
        let class = self.class(direction);
        let index = (random * class.count as f64) as usize;
        let LyingPassage { passage, side } = self.passages.get(class.first + index)?;
        let [cos, sin] = side.map(f64::from);
        let up = upwards(direction);
        let aside = up * cos + direction.cross(up) * sin;
        Some((passage, aside, index >= class.turned()))
    }

    /// One of the passages of light that arrives along a direction, by a uniform number; and whether it goes straight on.
    #[inline]
    pub(super) fn draw(&self, direction: DVec3, random: f64) -> (Passage, bool) {
        match self.drawn(direction, random) {
            Some((passage, aside, is_straight)) => (passage.along(direction, aside), is_straight),
            None => (Passage::none(direction), true),
        }
    }

    /// The same where it is let straight through.
    #[inline]
    pub(super) fn draw_straight(&self, direction: DVec3, random: f64) -> Passage {
        match self.drawn(direction, random) {
            Some((passage, aside, _)) => passage.straight_along(direction, aside),
            None => Passage::none(direction),
        }
    }

    /// As [`super::ShapePassages::towards`].
    pub(super) fn towards(
        &self,
        direction: DVec3,
        wanted: DVec3,
        random: f64,
    ) -> Option<(f64, Passage)> {
        let class = self.class(direction);
        let cosine = direction.dot(wanted).clamp(-1.0, 1.0);
        let above = class.edges.partition_point(|&edge| edge <= cosine);
        let step = above.clamp(1, STEPS) - 1;
        let up = upwards(direction);
        let side = side_of(wanted.dot(up), wanted.dot(direction.cross(up)));
        let cell = step * SIDES + side;
        let [first, end] = [class.before[cell], class.before[cell + 1]].map(|at| at as usize);
        let width = class.edges[step + 1] - class.edges[step];
        if first == end || width <= 0.0 {
            return None;
        }
        let solid_angle = width * TAU / SIDES as f64;
        let density = (end - first) as f64 / (class.turned() as f64 * solid_angle);
        let index = class.first + first + (random * (end - first) as f64) as usize;
        Some((density, self.passages[index].passage.turned_towards(direction, wanted)))
    }
}

/// The class of a side.
fn side_of(up: f64, across: f64) -> usize {
    ((turn(up, across) * SIDES as f64) as usize).min(SIDES - 1)
}

/// A way through a grain that is turned.
fn turned(way: &Passed, rotation: DMat3) -> Passed {
    let Passed { incident, entry, exit, direction, length, across } = *way;
    let [incident, direction] = [incident, direction].map(|unit| (rotation * unit).normalize());
    Passed { incident, entry: rotation * entry, exit: rotation * exit, direction, length, across }
}

impl LyingPassage {
    fn of(way: &Passed) -> Self {
        let passage = ShapePassage::of(way);
        let up = upwards(way.incident);
        let aside = aside(way.incident, way.direction);
        let side = [up, way.incident.cross(up)].map(|axis| axis.dot(aside) as f32);
        Self { passage, side }
    }

    fn cosine(&self) -> f32 {
        self.passage.turn[0]
    }

    fn side(&self) -> usize {
        side_of(self.side[0].into(), self.side[1].into())
    }
}

impl Class {
    /// Of these passages, which it sorts; `first` is the number of the first, `expected` how many there would be of even shadows.
    fn of(passages: &mut [LyingPassage], first: usize, expected: f64) -> Self {
        passages.sort_by(|a, b| a.cosine().total_cmp(&b.cosine()));
        let turned = passages.partition_point(|passage| passage.cosine() < 1.0);
        let starts: [usize; STEPS + 1] = std::array::from_fn(|step| step * turned / STEPS);
        let mut edges = [-1.0; STEPS + 1];
        edges[STEPS] = 1.0;
        for step in 1..STEPS {
            if (1..turned).contains(&starts[step]) {
                let [below, above] = [starts[step] - 1, starts[step]]
                    .map(|index| f64::from(passages[index].cosine()));
                edges[step] = 0.5 * (below + above);
            }
        }
        let mut before = [turned as u32; STEPS * SIDES + 1];
        for step in 0..STEPS {
            let of_step = &mut passages[starts[step]..starts[step + 1]];
            of_step.sort_by_key(LyingPassage::side);
            for side in 0..SIDES {
                let below = of_step.partition_point(|passage| passage.side() < side);
                before[step * SIDES + side] = (starts[step] + below) as u32;
            }
        }
        let count = passages.len();
        Self { first, count, shadow: count as f64 / expected, edges, before }
    }

    /// Passages that are turned.
    #[inline]
    fn turned(&self) -> usize {
        self.before[STEPS * SIDES] as usize
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::composition::Lying;
    use super::*;
    use core::f64::consts::PI;
    use snowgrain_geometry::ShapeKind;
    use snowgrain_math::sampler::{PathKey, numbers};

    const ETA: f64 = 1.31;

    fn plate() -> Shape {
        Shape::new(ShapeKind::HexagonalPrism { aspect: 0.2, rounding: 0.0 }).unwrap()
    }

    /// Turned by these angles about the vertical.
    fn level(turns: usize) -> Lying {
        let angle = |turn: usize| TAU * turn as f64 / turns as f64;
        Lying::of((0..turns).map(|turn| DMat3::from_rotation_y(angle(turn))).collect())
    }

    fn directions(count: u32) -> impl Iterator<Item = DVec3> {
        (0..count).map(|index| {
            let [u, v, _] = numbers(PathKey::new(1, index.into(), 2), 0).map(f64::from);
            let (y, (sin, cos)) = (2.0 * u - 1.0, trig::sin_cos(TAU * v));
            let across = (1.0 - y * y).sqrt();
            DVec3::new(across * cos, y, across * sin)
        })
    }

    /// A convex prism that is turned in all ways about its upright axis throws a shadow of its base and of its sides.
    #[test]
    fn level_plates_throw_the_shadow_of_a_prism() {
        let plate = plate();
        let passages = LyingPassages::new((&plate, &level(4096)), ETA);
        let [low, high] = plate.extent(DVec3::new(1e-9, 0.0, 0.0), DVec3::Y).unwrap();
        let height = high - low;
        let base = Shape::VOLUME / height;
        let perimeter = 6.0 * (base / (1.5 * 3.0f64.sqrt())).sqrt();
        for step in 0..40 {
            let y = (f64::from(step) + 0.5) / 20.0 - 1.0;
            let sine = (1.0 - y * y).sqrt();
            let expected = base * y.abs() + perimeter * height / PI * sine;
            let expected = expected / plate.mean_projected_area();
            let found = passages.shadow(DVec3::new(sine, y, 0.0));
            // Five standard errors of some 4000 ways, and the width of a class.
            assert!((found - expected).abs() < 0.1 * expected + 0.03, "{y}: {found} {expected}");
        }
        let mean =
            directions(10_000).map(|direction| passages.shadow(direction)).sum::<f64>() / 1e4;
        assert!((mean - 1.0).abs() < 0.02, "{mean}");
    }

    /// From any direction the density of what is turned integrates to 1, and passages are drawn as it says.
    #[test]
    fn the_density_of_a_direction_integrates_to_one() {
        let aimed = Lying::of(vec![DMat3::from_rotation_x(0.4); 1000]);
        for passages in
            [&level(4096), &aimed].map(|lying| LyingPassages::new((&plate(), lying), ETA))
        {
            for direction in directions(20) {
                let class = passages.class(direction);
                let up = upwards(direction);
                let (mut all, mut mean) = (0.0, 0.0);
                for edges in class.edges.windows(2) {
                    let cosine = 0.5 * (edges[0] + edges[1]);
                    let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
                    for side in 0..SIDES {
                        let angle = TAU * (side as f64 + 0.5) / SIDES as f64;
                        let (sin, cos) = trig::sin_cos(angle);
                        let aside = up * cos + direction.cross(up) * sin;
                        let wanted = direction * cosine + aside * sine;
                        let towards = passages.towards(direction, wanted, 0.5);
                        let Some((density, passage)) = towards else { continue };
                        assert!(passage.direction == wanted && passage.length >= 0.0);
                        let part = density * (edges[1] - edges[0]) * TAU / SIDES as f64;
                        all += part;
                        mean += part * cosine;
                    }
                }
                assert!((all - 1.0).abs() < 1e-6, "{direction}: {all}");
                let drawn = (0..class.turned()).map(|index| {
                    let random = (index as f64 + 0.5) / class.count as f64;
                    let (passage, is_straight) = passages.draw(direction, random);
                    assert!(!is_straight && (passage.direction.length() - 1.0).abs() < 1e-9);
                    passage.direction.dot(direction)
                });
                let drawn = drawn.sum::<f64>() / class.turned() as f64;
                // Within a step the middle is not the mean.
                assert!((mean - drawn).abs() < 0.05, "{direction}: {mean} {drawn}");
            }
        }
    }

    /// Light is turned by a grain that lies aslant as it is by that grain upright.
    #[test]
    fn passages_turn_with_what_lies() {
        let mirrored = |passages: &LyingPassages, direction: DVec3| {
            let of = (0..4000).map(|index| passages.draw(direction, f64::from(index) / 4e3).0);
            of.map(|passage| passage.direction.dot(direction)).sum::<f64>() / 4e3
        };
        let upright = LyingPassages::new((&plate(), &Lying::of(vec![DMat3::IDENTITY; 1000])), ETA);
        let turn = DMat3::from_rotation_z(0.5 * PI);
        let aside = LyingPassages::new((&plate(), &Lying::of(vec![turn; 1000])), ETA);
        for direction in directions(10) {
            let [found, expected] =
                [mirrored(&aside, turn * direction), mirrored(&upright, direction)];
            assert!((found - expected).abs() < 0.1, "{direction}: {found} {expected}");
        }
    }
}
