//! Light from infinity.

use crate::description::{LightDescription, MAIN_GROUP};
use snowgrain_math::DVec3;
use snowgrain_optics::Illuminant;

/// Radiances of one direction, linear sRGB: one of each of the environment's slots.
type Radiances = Vec<[f32; 3]>;

/// Lights whose light is kept together: those of a group that have the same spectrum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Slot {
    group: u32,
    spectrum: Illuminant,
}

/// What a path that escapes meets: the sum of all lights at infinity, by group and spectrum.
#[derive(Clone, Debug, PartialEq)]
pub struct Environment {
    /// Names of the groups, each once, in the order of the lights.
    groups: Vec<String>,
    /// Each pair of group and spectrum once.
    slots: Vec<Slot>,
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
        let mut groups: Vec<String> = Vec::new();
        let mut slots: Vec<Slot> = Vec::new();
        let mut slot_of = |group: &str, spectrum| {
            let group = index_or_push(&mut groups, group.to_owned()) as u32;
            index_or_push(&mut slots, Slot { group, spectrum })
        };
        let of_lights: Vec<_> =
            lights.iter().map(|light| slot_of(light.group(), light.spectrum())).collect();
        let of_backdrop = behind.map(|daylight| slot_of(MAIN_GROUP, daylight));
        if lights.is_empty() && of_backdrop.is_none() {
            slot_of(MAIN_GROUP, Illuminant::D65);
        }
        let dark = vec![[0.0; 3]; slots.len()];
        let [mut above, mut below, mut seen_above, mut seen_below] =
            [dark.clone(), dark.clone(), dark.clone(), dark];
        for (light, slot) in lights.iter().zip(of_lights) {
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
        if let Some(slot) = of_backdrop {
            (seen_above[slot], seen_below[slot]) = (backdrop, backdrop);
        }
        Self { groups, slots, above, below, seen_above, seen_below }
    }

    /// Names of the groups of its lights, each once.
    #[must_use]
    pub fn groups(&self) -> &[String] {
        &self.groups
    }

    /// The spectrum of each slot (a pair of group and spectrum), in the order of [`Self::radiances`].
    #[must_use]
    pub fn spectra(&self) -> Vec<Illuminant> {
        self.slots.iter().map(|slot| slot.spectrum).collect()
    }

    /// The index of the group of each slot.
    #[must_use]
    pub fn group_of_slot(&self) -> Vec<u32> {
        self.slots.iter().map(|slot| slot.group).collect()
    }

    /// Radiances along a path that escapes in `direction` after meeting something, of each slot. The
    /// hemisphere is decided by the sign of `direction.y` (the paper, section 4.1).
    #[must_use]
    pub fn radiances(&self, direction: DVec3) -> &[[f32; 3]] {
        if direction.y > 0.0 { &self.above } else { &self.below }
    }

    /// Radiances of a camera ray that meets nothing, of each slot.
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

/// The index of an entry, which is added where it is not there.
fn index_or_push<T: PartialEq>(entries: &mut Vec<T>, entry: T) -> usize {
    entries.iter().position(|known| *known == entry).unwrap_or_else(|| {
        entries.push(entry);
        entries.len() - 1
    })
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
        assert_eq!((lamps.groups(), lamps.group_of_slot()), (&["main".to_owned()][..], vec![0, 0]));
        assert_eq!(lamps.radiances(DVec3::Y), [[3.0, 2.5, 2.0], [0.0; 3]]);
        assert_eq!(lamps.radiances(-DVec3::Y), [[1.0, 0.5, 0.0], [0.0; 3]]);
        assert_eq!(lamps.seen_by_camera(DVec3::Y), [[0.0; 3], [0.2; 3]]);
    }
}
