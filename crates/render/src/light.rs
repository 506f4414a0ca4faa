//! Light from infinity.

use crate::description::LightDescription;
use snowgrain_math::DVec3;
use snowgrain_optics::Illuminant;

/// Radiances of one direction, linear sRGB: one of each of the environment's spectra.
type Radiances = Vec<[f32; 3]>;

/// What a path that escapes meets: the sum of all lights at infinity, by spectrum.
#[derive(Clone, Debug, PartialEq)]
pub struct Environment {
    /// Each spectrum once.
    spectra: Vec<Illuminant>,
    /// From above the horizon (`y > 0`).
    above: Radiances,
    /// From below it.
    below: Radiances,
    /// What a camera ray sees directly: the visible lights, or the backdrop where none is.
    seen_above: Radiances,
    seen_below: Radiances,
}

impl Environment {
    /// The sum of `lights`; camera rays that meet nothing see those that are visible to the camera,
    /// or `backdrop` (of D65) where none is.
    #[must_use]
    pub fn new(lights: &[LightDescription], backdrop: [f32; 3]) -> Self {
        let shows_light = lights.iter().any(LightDescription::visible_to_camera);
        let behind = (!shows_light && backdrop != [0.0; 3]).then_some(Illuminant::D65);
        let mut spectra = Vec::new();
        for spectrum in lights.iter().map(LightDescription::spectrum).chain(behind) {
            if !spectra.contains(&spectrum) {
                spectra.push(spectrum);
            }
        }
        if spectra.is_empty() {
            spectra.push(Illuminant::D65);
        }
        let dark = vec![[0.0; 3]; spectra.len()];
        let slot = |spectrum| spectra.iter().position(|&known| known == spectrum).unwrap_or(0);
        let [mut above, mut below, mut seen_above, mut seen_below] =
            [dark.clone(), dark.clone(), dark.clone(), dark];
        for light in lights {
            let slot = slot(light.spectrum());
            let (radiance, whole_sphere) = match *light {
                LightDescription::Sky { radiance, .. } => (radiance, false),
                LightDescription::Uniform { radiance, .. } => (radiance, true),
            };
            let visible = light.visible_to_camera();
            let sums = [
                (&mut above, true),
                (&mut below, whole_sphere),
                (&mut seen_above, visible),
                (&mut seen_below, visible && whole_sphere),
            ];
            for (sum, _) in sums.into_iter().filter(|(_, shines)| *shines) {
                add(&mut sum[slot], radiance);
            }
        }
        if let Some(daylight) = behind {
            let slot = slot(daylight);
            (seen_above[slot], seen_below[slot]) = (backdrop, backdrop);
        }
        Self { spectra, above, below, seen_above, seen_below }
    }

    /// The spectra of its lights, each once, in the order of [`Self::radiances`].
    #[must_use]
    pub fn spectra(&self) -> &[Illuminant] {
        &self.spectra
    }

    /// Radiances along a path that escapes in `direction` after meeting something, of each spectrum. The
    /// hemisphere is decided by the sign of `direction.y` (the paper, section 4.1).
    #[must_use]
    pub fn radiances(&self, direction: DVec3) -> &[[f32; 3]] {
        if direction.y > 0.0 { &self.above } else { &self.below }
    }

    /// Radiances of a camera ray that meets nothing, of each spectrum.
    #[must_use]
    pub fn seen_by_camera(&self, direction: DVec3) -> &[[f32; 3]] {
        if direction.y > 0.0 { &self.seen_above } else { &self.seen_below }
    }

    /// The greatest component of any radiance.
    #[must_use]
    pub fn greatest_radiance(&self) -> f32 {
        let all = [&self.above, &self.below, &self.seen_above, &self.seen_below];
        all.into_iter().flatten().flatten().fold(0.0, |greatest, &value| greatest.max(value))
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

    fn sky(spectrum: Illuminant, visible_to_camera: bool) -> LightDescription {
        LightDescription::Sky { radiance: [2.0; 3], spectrum, visible_to_camera }
    }

    #[test]
    fn the_camera_sees_the_backdrop_only_where_no_light_is_visible() {
        let hidden = Environment::new(&[sky(Illuminant::D65, false)], [0.1; 3]);
        assert_eq!(hidden.seen_by_camera(DVec3::Y), [[0.1; 3]]);
        assert_eq!(hidden.radiances(DVec3::Y), [[2.0; 3]]);
        assert_eq!(hidden.radiances(-DVec3::Y), [[0.0; 3]]);
        let visible = Environment::new(&[sky(Illuminant::D65, true)], [0.1; 3]);
        assert_eq!(visible.seen_by_camera(DVec3::Y), [[2.0; 3]]);
        assert_eq!(visible.seen_by_camera(-DVec3::Y), [[0.0; 3]]);
        assert_eq!(visible.greatest_radiance(), 2.0);
    }

    #[test]
    fn lights_of_one_spectrum_add_and_others_stay_apart() {
        let lights = [
            sky(Illuminant::A, false),
            LightDescription::Uniform {
                radiance: [1.0, 0.5, 0.0],
                spectrum: Illuminant::A,
                visible_to_camera: false,
            },
        ];
        let lamps = Environment::new(&lights, [0.2; 3]);
        assert_eq!(lamps.spectra(), [Illuminant::A, Illuminant::D65]);
        assert_eq!(lamps.radiances(DVec3::Y), [[3.0, 2.5, 2.0], [0.0; 3]]);
        assert_eq!(lamps.radiances(-DVec3::Y), [[1.0, 0.5, 0.0], [0.0; 3]]);
        assert_eq!(lamps.seen_by_camera(DVec3::Y), [[0.0; 3], [0.2; 3]]);
    }
}
