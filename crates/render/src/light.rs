//! Light from infinity.

use crate::description::LightDescription;
use snowgrain_math::DVec3;

/// What a path that escapes meets: the sum of all lights at infinity.
#[derive(Clone, Debug, PartialEq)]
pub struct Environment {
    /// Radiance from above the horizon (`y > 0`), linear RGB.
    above: [f32; 3],
    /// Radiance from below it.
    below: [f32; 3],
    /// The part of both that a camera ray sees directly.
    seen_above: [f32; 3],
    seen_below: [f32; 3],
    /// Whether the camera sees any light directly; else it sees the backdrop.
    backdrop: Option<[f32; 3]>,
}

impl Environment {
    /// The sum of `lights`; camera rays that meet nothing see those that are visible to the camera,
    /// or `backdrop` where none is.
    #[must_use]
    pub fn new(lights: &[LightDescription], backdrop: [f32; 3]) -> Self {
        let mut sum = Self {
            above: [0.0; 3],
            below: [0.0; 3],
            seen_above: [0.0; 3],
            seen_below: [0.0; 3],
            backdrop: Some(backdrop),
        };
        for light in lights {
            let (radiance, whole_sphere, visible) = match *light {
                LightDescription::Sky { radiance, visible_to_camera } => {
                    (radiance, false, visible_to_camera)
                }
                LightDescription::Uniform { radiance, visible_to_camera } => {
                    (radiance, true, visible_to_camera)
                }
            };
            add(&mut sum.above, radiance);
            if whole_sphere {
                add(&mut sum.below, radiance);
            }
            if visible {
                sum.backdrop = None;
                add(&mut sum.seen_above, radiance);
                if whole_sphere {
                    add(&mut sum.seen_below, radiance);
                }
            }
        }
        sum
    }

    /// Radiance along a path that escapes in `direction` after meeting something. The hemisphere is
    /// decided by the sign of `direction.y` (the paper, section 4.1).
    #[must_use]
    pub fn radiance(&self, direction: DVec3) -> [f32; 3] {
        if direction.y > 0.0 { self.above } else { self.below }
    }

    /// Radiance of a camera ray that meets nothing.
    #[must_use]
    pub fn seen_by_camera(&self, direction: DVec3) -> [f32; 3] {
        match self.backdrop {
            Some(backdrop) => backdrop,
            None if direction.y > 0.0 => self.seen_above,
            None => self.seen_below,
        }
    }
}

fn add(sum: &mut [f32; 3], radiance: [f32; 3]) {
    for (sum, radiance) in sum.iter_mut().zip(radiance) {
        *sum += radiance;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_camera_sees_the_backdrop_only_where_no_light_is_visible() {
        let sky =
            |visible_to_camera| LightDescription::Sky { radiance: [2.0; 3], visible_to_camera };
        let hidden = Environment::new(&[sky(false)], [0.1; 3]);
        assert_eq!(hidden.seen_by_camera(DVec3::Y), [0.1; 3]);
        assert_eq!(hidden.radiance(DVec3::Y), [2.0; 3]);
        assert_eq!(hidden.radiance(-DVec3::Y), [0.0; 3]);
        let visible = Environment::new(&[sky(true)], [0.1; 3]);
        assert_eq!(visible.seen_by_camera(DVec3::Y), [2.0; 3]);
        assert_eq!(visible.seen_by_camera(-DVec3::Y), [0.0; 3]);
    }
}
