//! A level slab of snow, periodic along x and z, lit on its upper face, black below.

use crate::oracle::{Oracle, PathEnd};
use crate::packs;
use crate::search::Search;
use crate::statistics::{Estimate, estimate};
use snowgrain_geometry::Grain;
use snowgrain_math::sampler::{PathKey, numbers};
use snowgrain_math::{DVec3, frame};

/// Snow between y = 0 and y = `height`.
#[derive(Clone, Debug)]
pub struct Slab {
    /// The grains of one period.
    pub grains: Vec<Grain>,
    /// Periods along x and z.
    pub period: [f64; 2],
    /// Height of the upper face.
    pub height: f64,
    /// Index of refraction.
    pub eta: f64,
}

/// Light on the upper face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Illumination {
    /// From all sides with equal radiance.
    Lambertian,
    /// Along one unit direction (downwards).
    Collimated(DVec3),
}

/// What a slab does to light, per path.
#[derive(Clone, Copy, Debug)]
pub struct SlabMeasure {
    /// Fraction that leaves upwards.
    pub reflectance: Estimate,
    /// Fraction that leaves downwards.
    pub transmittance: Estimate,
    /// Fraction stopped by the guard of [`Oracle::TURNS_BEFORE_TRAPPED`].
    pub trapped: Estimate,
    /// Arrivals at ice from air.
    pub visits: Estimate,
    /// Fresnel decisions.
    pub interface_events: Estimate,
    /// Length in ice.
    pub ice_length: Estimate,
    /// Length in air between the faces, per visit; the error is that of the ratio.
    pub chord: Estimate,
}

impl Slab {
    /// `layers` layers of touching grains of radius 1/2 on the simple cubic lattice, axes along
    /// x, y, z.
    #[must_use]
    pub fn simple_cubic(layers: u32, eta: f64) -> Self {
        let grains = packs::simple_cubic([1, layers, 1], 0.5);
        Self { grains, period: [1.0; 2], height: f64::from(layers), eta }
    }

    /// `layers` (001) layers of touching grains of radius 1/2 on the face-centred cubic lattice.
    #[must_use]
    pub fn face_centred_cubic(layers: u32, eta: f64) -> Self {
        let grains = packs::face_centred_cubic_layers(layers, 0.5);
        let height = 1.0 + f64::from(layers - 1) * core::f64::consts::FRAC_1_SQRT_2;
        Self { grains, period: [1.0; 2], height, eta }
    }

    /// Grain surface seen from above per area, N pi r^2 / A.
    #[must_use]
    pub fn tau(&self) -> f64 {
        let discs: f64 =
            self.grains.iter().map(|g| core::f64::consts::PI * g.radius * g.radius).sum();
        discs / (self.period[0] * self.period[1])
    }

    /// Fraction of the space between the faces that is ice, for grains that do not overlap.
    #[must_use]
    pub fn solid_fraction(&self) -> f64 {
        let volume: f64 = self
            .grains
            .iter()
            .map(|g| 4.0 / 3.0 * core::f64::consts::PI * g.radius * g.radius * g.radius)
            .sum();
        volume / (self.period[0] * self.period[1] * self.height)
    }

    /// Traces `paths` paths. Event 0 of a path is its place on the upper face, event 1 its
    /// direction.
    #[must_use]
    pub fn measure(&self, light: Illumination, paths: u64, seed: u64) -> SlabMeasure {
        let oracle =
            Oracle::new(&self.grains, &[], self.eta, Search::Periodic { period: self.period });
        let [reflectance, transmittance, trapped, visits, interface_events, ice_length, void, sum] =
            estimate(paths, |index| self.sample(&oracle, light, PathKey::new(seed, index, 0)));
        let chord = Estimate::ratio(void, visits, sum);
        SlabMeasure {
            reflectance,
            transmittance,
            trapped,
            visits,
            interface_events,
            ice_length,
            chord,
        }
    }

    /// Reflected, transmitted, trapped (1 or 0), visits, events, ice, clipped void of one
    /// path, and the sum of its void and its visits.
    fn sample(&self, oracle: &Oracle, light: Illumination, key: PathKey) -> [f64; 8] {
        let [x, z, _] = numbers(key, 0).map(f64::from);
        let origin = DVec3::new(x * self.period[0], self.height, z * self.period[1]);
        let direction = match light {
            Illumination::Lambertian => {
                let [_, u1, u2] = numbers(key, 1).map(f64::from);
                frame::cosine_hemisphere(-DVec3::Y, [u1, u2])
            }
            Illumination::Collimated(direction) => direction,
        };
        let path = oracle.trace(origin, direction, key, 2);
        let (up, down, last) = match path.end {
            PathEnd::Escaped(d) if d.y > 0.0 => {
                (1.0, 0.0, (self.height - path.last_position.y) / d.y)
            }
            PathEnd::Escaped(d) => (0.0, 1.0, path.last_position.y / -d.y),
            PathEnd::Absorbed | PathEnd::Trapped => (0.0, 0.0, 0.0),
        };
        let (visits, void) = (f64::from(path.grain_visits), path.void_length + last);
        [
            up,
            down,
            1.0 - up - down,
            visits,
            f64::from(path.interface_events),
            path.ice_length,
            void,
            void + visits,
        ]
    }
}
