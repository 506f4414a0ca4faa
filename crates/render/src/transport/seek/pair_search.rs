//! How often images of a sun in two grains are looked for, and how their light is shared.
//!
//! Each path looks once, with a probability that falls where its own ray leaves far from the sun ([`Look::Wide`]).
//! Where an image is large (near caustics) rays all around leave close to the sun, yet few of the directions on its disc lead
//! back to where a path is: found once in a thousand paths it would weigh a thousand times as much. So a path whose ray
//! leaves close to the sun looks many times more ([`Look::Close`]), which few do.

use super::{SOLVED_ORDERS, Sun};
use core::f64::consts::PI;
use snowgrain_math::DVec3;
use snowgrain_optics::{PairPath, Passed, Pencil, SpherePair};

/// One path in so many looks, for all, for images of suns by so many chords of the second grain: most of the light comes
/// by one chord, the brightest images by none, of what the first grain gathers.
const PATHS_PER_SEARCH: [f64; SOLVED_ORDERS as usize + 1] = [1.0, 2.0, 4.0, 16.0];
/// The same behind a reflection, where one path in [`PATHS_PER_LOOK`] has looked at all and images are as bright.
const BEHIND_REFLECTION: [f64; SOLVED_ORDERS as usize + 1] = [1.0, 1.0, 2.0, 4.0];
/// One path in so many looks along the ray that its first grain would reflect ([`super::reflected`]).
pub(super) const PATHS_PER_LOOK: f64 = 4.0;
/// Times that a path looks beside the first whose ray leaves close to the sun, and closer.
const LOOKS: [f64; 2] = [15.0, 240.0];
/// Angles from the sun within which rays are so, radians; to twice that a smaller part of the paths looks. A sun that is as
/// wide itself is found without.
const CLOSE: [f64; 2] = [0.1, 0.02];
/// What a dimmer image is found to bring, of white ground across the sun's light, where it is kept: one in so many as it
/// is dimmer. To look often and to keep what is bright costs no more than to look seldom, as it is the random places
/// and rays of what is kept that take the time.
const KEPT_BRIGHTNESS: f64 = 0.25;
/// Part that is kept of the dimmest.
const LEAST_KEPT: f64 = 1.0 / 64.0;
/// Angle by which rays are turned apart behind two grains that meet the first a radius apart, radians: by chords of
/// the second. As a rule it is three times as large, but what is looked for so far away is as seldom found: with
/// that a sample takes a fifth longer and varies no less.
const TURNED: [f64; SOLVED_ORDERS as usize + 1] = [2.1, 2.1, 1.2, 2.1];
/// Part of the paths that look for a sun however far from it their rays leave: what they find takes no more than so many
/// times as long to weigh.
const LEAST_PROBABILITY: f64 = 1.0 / 64.0;
/// P ([`super::second_grain`]) as it is taken to be where searches and chance share light; how well it fits shows in the
/// noise only.
const TYPICAL_PART: f64 = 0.25;
/// A search goes no farther from where it begins than so many edges of its window.
const REACH: f64 = 1.5;

/// The rays of a place of the lens, and two grains that they pass by some orders.
#[derive(Clone, Copy)]
pub(super) struct PairSearch {
    pub(super) pencil: Pencil,
    pub(super) pair: SpherePair,
    /// Edge of a window, pixels and radii of the first grain.
    pub(super) edge: f64,
    pub(super) edge_radii: f64,
}

/// How a path comes to look for an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Look {
    /// As all do.
    Wide,
    /// Once more, as its own ray leaves close to the sun: the number of how close in [`CLOSE`].
    Close(usize),
}

impl Look {
    /// All of the second kind.
    pub(super) const CLOSE: [Self; 2] = [Self::Close(0), Self::Close(1)];

    /// Times that the paths look that do.
    fn times(self, sun: &Sun) -> f64 {
        match self {
            Self::Wide => 1.0,
            Self::Close(how) if sun.width < CLOSE[how] => LOOKS[how],
            Self::Close(_) => 0.0,
        }
    }

    /// Angle within which rays are close to any place of a sun, radians.
    fn close(how: usize, sun: &Sun) -> f64 {
        CLOSE[how] + sun.width
    }
}

impl PairSearch {
    /// The search from a place of the image into the direction of a sun.
    pub(super) fn solve(&self, start: [f64; 2], sun: DVec3) -> Option<PairPath> {
        self.pair.solve(&self.pencil, (start, REACH * self.edge), sun)
    }

    /// The same by so many chords of the second grain.
    pub(super) fn by_chords(mut self, order: u32) -> Self {
        self.pair.visits[1].order = order;
        self
    }

    /// One path in so many looks for it.
    pub(super) fn paths(&self) -> f64 {
        let [near, far] = self.pair.visits.map(|visit| visit.order as usize);
        if near == 0 { BEHIND_REFLECTION[far] } else { PATHS_PER_SEARCH[far] }
    }

    /// Part of these paths that look for a sun in this direction where their rays pass so: fewer where no image of it
    /// is to be expected near.
    pub(super) fn probability(&self, began: &[Passed; 2], sun: &Sun, look: Look) -> f64 {
        // Less the cosine.
        let apart = 1.0 - began[1].direction.dot(sun.towards);
        let turned = match look {
            Look::Wide => TURNED[self.pair.visits[1].order as usize] * self.edge_radii,
            Look::Close(how) => Look::close(how, sun),
        };
        let spread = 0.5 * turned * turned;
        let near = spread / apart.max(spread);
        match look {
            Look::Wide => (near * near).max(LEAST_PROBABILITY),
            // Beyond twice the angle.
            Look::Close(_) if near < 0.25 => 0.0,
            Look::Close(_) => near * near,
        }
    }

    /// How often a path whose ray leaves so looks close by, in the mean.
    pub(super) fn looks(&self, began: &[Passed; 2], sun: &Sun, look: Look) -> f64 {
        look.times(sun) * self.probability(began, sun, look) / self.paths()
    }

    /// Probability with which a path that meets the first grain comes to look for images behind it.
    pub(super) fn comes(&self, first: &Passed) -> f64 {
        match self.pair.visits[0].order {
            0 => 1.0 / PATHS_PER_LOOK,
            _ => self.pair.part(0, first).0,
        }
    }

    /// Part of the images such as this one that are kept.
    pub(super) fn kept(&self, path: &PairPath, sun: &Sun, look: Look) -> f64 {
        let [energy_near, energy_far] =
            [0, 1].map(|sphere: usize| self.pair.part(sphere, &path.passed[sphere]).0);
        let energy = energy_near * energy_far / self.comes(&path.passed[0]);
        let by_area = self.apart(path) * TYPICAL_PART;
        let brightness = PI * energy * self.paths() / by_area;
        let kept = (brightness / KEPT_BRIGHTNESS).clamp(LEAST_KEPT, 1.0);
        kept * self.close_part(path, sun, look)
    }

    /// Part that one search for a sun has of the light by this way, beside all others and rays
    /// that have it themselves.
    pub(super) fn share(&self, path: &PairPath, sun: &Sun, look: Look) -> f64 {
        let itself = self.itself(path);
        self.found(path, sun, look) / (self.all_found(path, sun) + itself)
    }

    /// Part of rays that have it themselves.
    pub(super) fn share_of_rays(&self, path: &PairPath, sun: &Sun) -> f64 {
        let itself = self.itself(path);
        itself / (self.all_found(path, sun) + itself)
    }

    /// How many find it by area of the image, where one ray would that has all light.
    fn all_found(&self, path: &PairPath, sun: &Sun) -> f64 {
        let of = |look: Look| look.times(sun) * self.found(path, sun, look);
        of(Look::Wide) + Look::CLOSE.into_iter().map(of).sum::<f64>()
    }

    /// The same by one search of a kind, of which none is certain to be begun.
    fn found(&self, path: &PairPath, sun: &Sun, look: Look) -> f64 {
        let part = TYPICAL_PART * self.close_part(path, sun, look);
        let per_path = part * self.kept(path, sun, look) / self.paths();
        self.apart(path) / sun.solid_angle * per_path * self.comes(&path.passed[0])
    }

    /// About the part of a window from which rays leave as close as that.
    fn close_part(&self, path: &PairPath, sun: &Sun, look: Look) -> f64 {
        match look {
            Look::Wide => 1.0,
            Look::Close(how) => {
                let close = Look::close(how, sun);
                let close = PI * close * close;
                close / self.apart(path).max(close)
            }
        }
    }

    /// Solid angle into which the rays of a window leave, sr.
    fn apart(&self, path: &PairPath) -> f64 {
        path.solid_angle() * self.edge * self.edge
    }

    /// The same by the ray itself, which comes to the second grain with this probability.
    fn itself(&self, path: &PairPath) -> f64 {
        self.pair.part(0, &path.passed[0]).0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use snowgrain_math::sampler::{PathKey, numbers};
    use snowgrain_math::{frame, trig};
    use snowgrain_optics::{Dielectric, SphereVisit};

    const ALL: [Look; 3] = [Look::Wide, Look::Close(0), Look::Close(1)];

    /// A sphere that parallel rays look at, and another beside and behind it, in a window of half a radius.
    fn search(orders: [u32; 2]) -> PairSearch {
        let visit = |center: DVec3, order: u32| SphereVisit { center, radius: 1.0, order };
        PairSearch {
            pencil: Pencil {
                origin: DVec3::Z * 10.0,
                direction: -DVec3::Z,
                origin_by: [DVec3::X, DVec3::Y],
                direction_by: [DVec3::ZERO; 2],
            },
            pair: SpherePair {
                medium: Dielectric { eta: 1.31 },
                visits: [
                    visit(DVec3::ZERO, orders[0]),
                    visit(DVec3::new(0.4, 0.0, -2.2), orders[1]),
                ],
            },
            edge: 0.5,
            edge_radii: 0.5,
        }
    }

    fn sun(towards: DVec3, degrees: f64) -> Sun {
        let width = degrees.to_radians();
        Sun { light: 0, towards, solid_angle: 0.25 * PI * width * width, width }
    }

    /// All ways to find an image share its light, and none has a part of what it never finds: a ray that leaves into any
    /// place of the sun always looks where that look is taken at all.
    #[test]
    fn looks_and_rays_share_all_light_and_rays_into_the_sun_look() {
        let mut close = 0;
        for index in 0..400 {
            let [x, y, _] = numbers(PathKey::new(5, index, 0), 0).map(f64::from);
            let search = search([1, (index % 3) as u32]);
            let Some(path) = search.pair.follow(&search.pencil, [1.6 * x - 0.8, 1.6 * y - 0.8])
            else {
                continue;
            };
            let direction = path.passed[1].direction;
            for degrees in [0.53, 2.0, 5.0, 30.0] {
                // The ray leaves into the sun's rim.
                let aside = frame::tangents(direction).0;
                let (sin, cos) = trig::sin_cos(f64::to_radians(0.5 * degrees));
                let sun = sun(direction * cos + aside * sin, degrees);
                let part = |look: Look| look.times(&sun) * search.share(&path, &sun, look);
                let parts = ALL.map(part);
                let all = parts.iter().sum::<f64>() + search.share_of_rays(&path, &sun);
                assert!((all - 1.0).abs() < 1e-12, "{degrees} {parts:?}");
                for look in [Look::Close(0), Look::Close(1)] {
                    assert_eq!(search.probability(&path.passed, &sun, look), 1.0, "{degrees}");
                }
                close += u32::from(parts[1] > 0.0);
                assert_eq!(parts[2] > 0.0, degrees < 1.0, "{degrees}");
            }
        }
        assert!(close > 200, "{close}");
    }

    /// Rays far from the sun do not look close by, and always once with some probability.
    #[test]
    fn rays_far_from_the_sun_look_once() {
        let search = search([1, 1]);
        let path = search.pair.follow(&search.pencil, [0.1, 0.2]).expect("it passes both");
        let away = sun(-path.passed[1].direction, 0.53);
        assert!(search.probability(&path.passed, &away, Look::Wide) >= LEAST_PROBABILITY);
        for look in Look::CLOSE {
            assert_eq!(search.looks(&path.passed, &away, look), 0.0);
        }
    }
}
