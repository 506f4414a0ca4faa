//! Light that is looked for: directions drawn towards lights.

use super::{Lights, Origin};
use snowgrain_accel::SurfaceId;
use snowgrain_math::DVec3;

/// A direction in which a light may be seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightSample {
    /// Which light.
    pub light: usize,
    /// Its slot.
    pub slot: usize,
    /// Unit vector towards it.
    pub direction: DVec3,
    /// How far it is, metres; infinite for a light at infinity.
    pub distance: f64,
    /// Its radiance, linear sRGB, where nothing is in between; of a point its intensity over the square of
    /// the distance.
    pub radiance: [f32; 3],
    /// Density of the direction, 1/sr, times the probability of the light; of a point the probability alone.
    pub pdf: f64,
    /// Whether the light is a point, which no path meets.
    pub is_point: bool,
    /// Of a luminous surface its piece: the light is seen where this is what a ray meets first.
    pub surface: Option<SurfaceId>,
}

impl Lights {
    /// A light by its power, and a direction towards it from the point `from` (metres), by three independent
    /// uniform numbers in [0, 1). For any function f of direction, f times radiance over pdf has the mean
    /// over all lights of the integral of f times their radiance, where nothing is in between (of points, of
    /// the sum of f times intensity over squared distance). `None` where no light shines, or what was
    /// drawn is turned away.
    ///
    /// The probability of a light is its luminous flux onto a sphere around the scene over that of all.
    #[must_use]
    pub fn sample(&self, from: DVec3, u: [f64; 3]) -> Option<LightSample> {
        let (light, rest) = self.choice.pick(u[0])?;
        self.draw(light, self.choice.probability(light), from, [rest, u[1], u[2]])
    }

    /// A direction towards a light that was chosen with this probability.
    fn draw(
        &self,
        light: usize,
        probability: f64,
        from: DVec3,
        u: [f64; 3],
    ) -> Option<LightSample> {
        let source = &self.sources[light];
        let slot = source.slot;
        match &source.origin {
            Origin::Distant(distant) => {
                let direction = distant.sample([u[1], u[2]])?;
                Some(LightSample {
                    light,
                    slot,
                    direction,
                    distance: f64::INFINITY,
                    radiance: source.radiance(direction),
                    pdf: probability * distant.density(direction),
                    is_point: false,
                    surface: None,
                })
            }
            Origin::Near(near) => {
                let way = near.sample(from, u)?;
                Some(LightSample {
                    light,
                    slot,
                    direction: way.direction,
                    distance: way.distance,
                    radiance: source.strength.map(|strength| strength * way.radiance as f32),
                    pdf: probability * way.density,
                    is_point: near.is_point(),
                    surface: way.surface,
                })
            }
        }
    }

    /// A direction towards this light from the point `from`, as [`Self::sample`] draws it once the light
    /// is chosen: the density is that of the direction alone.
    #[must_use]
    pub fn sample_light(&self, light: usize, from: DVec3, u: [f64; 3]) -> Option<LightSample> {
        self.draw(light, 1.0, from, u)
    }

    /// Density with which [`Self::sample`] gives a light at infinity in this direction, 1/sr; 0 for one within
    /// reach.
    #[must_use]
    pub fn pdf_at_infinity(&self, light: usize, direction: DVec3) -> f64 {
        match &self.sources[light].origin {
            Origin::Distant(distant) => self.choice.probability(light) * distant.density(direction),
            Origin::Near(_) => 0.0,
        }
    }

    /// Density with which [`Self::sample`] gives this point of a luminous surface with this normal, 1/sr as seen
    /// from `from`; 0 for other lights, and from behind.
    #[must_use]
    pub fn pdf_on_surface(&self, light: usize, from: DVec3, point: DVec3, normal: DVec3) -> f64 {
        match &self.sources[light].origin {
            Origin::Distant(_) => 0.0,
            Origin::Near(near) => {
                self.choice.probability(light) * near.density(from, point, normal)
            }
        }
    }

    /// Radiance of a light at infinity in a direction, linear sRGB; 0 for one within reach.
    #[must_use]
    pub fn radiance_at_infinity(&self, light: usize, direction: DVec3) -> [f32; 3] {
        self.sources[light].radiance(direction)
    }
}
