//! Lights: what a path that escapes meets, and how directions are drawn towards light.
//!
//! A film keeps the light of each *slot* apart: of each pair of a group's name and a spectrum. A light
//! belongs to one slot.

mod choice;
mod clear_sky;
mod description;
mod direction_table;
mod distant;
mod sample;

pub use description::{LightDescription, LightKind, direction_of};
pub use distant::irradiance_of_disc;
pub use sample::LightSample;

use choice::Choice;
use core::f64::consts::PI;
use distant::Distant;
use snowgrain_math::{Aabb, DVec3};
use snowgrain_optics::Illuminant;

/// Group of what the camera sees where no light is.
pub const BACKDROP_GROUP: &str = "backdrop";

/// Solid angle, sr, below which light is hardly found by chance.
pub const SMALL_SOLID_ANGLE: f64 = 0.1;

/// How many times brighter than what scales a film's ice paths the disc of a sun may be.
const DISC_OVER_SCALE: f32 = 32_768.0;

/// Lights that a film keeps together.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LightSlot {
    /// Name of their group.
    pub group: String,
    /// Their spectrum.
    pub spectrum: Illuminant,
}

/// All lights of a scene, by the index of their description.
#[derive(Clone, Debug)]
pub struct Lights {
    slots: Vec<LightSlot>,
    sources: Vec<Source>,
    constant: Constant,
    /// Indices of the lights at infinity that differ within a hemisphere.
    varying: Vec<usize>,
    choice: Choice,
    /// Radius of a sphere around all that is finite in the scene, metres.
    scene_radius: f64,
}

/// One light.
#[derive(Clone, Debug)]
struct Source {
    slot: usize,
    strength: [f32; 3],
    visible_to_camera: bool,
    distant: Distant,
}

/// Radiances by slot of what is the same all over a hemisphere.
#[derive(Clone, Debug)]
struct Constant {
    /// From above the horizon (`y > 0`), and from below it.
    above: Vec<[f32; 3]>,
    below: Vec<[f32; 3]>,
    /// What a camera ray sees directly.
    seen_above: Vec<[f32; 3]>,
    seen_below: Vec<[f32; 3]>,
}

impl Lights {
    /// These lights around a scene within `bounds` (metres; an empty box counts as one of a metre). Camera
    /// rays that meet nothing see what is visible to the camera, and `backdrop` (of D65) where none of it
    /// but discs is at infinity.
    #[must_use]
    pub fn new(lights: &[LightDescription], backdrop: [f32; 3], bounds: &Aabb) -> Self {
        let slots = slots_of(lights, backdrop);
        let slot = |group: &str, spectrum| {
            slots.iter().position(|slot| slot.group == group && slot.spectrum == spectrum)
        };
        let source = |light: &LightDescription| Source {
            slot: slot(&light.group, light.spectrum).unwrap_or(0),
            strength: light.strength,
            visible_to_camera: light.visible_to_camera,
            distant: Distant::new(&light.kind),
        };
        let sources = lights.iter().map(source).collect();
        let backdrop = slot(BACKDROP_GROUP, Illuminant::D65)
            .filter(|_| shows_backdrop(lights, backdrop))
            .map(|slot| (slot, backdrop));
        let scene_radius = if bounds.is_empty() { 1.0 } else { bounds.size().length() * 0.5 };
        Self::assemble(slots, sources, backdrop, scene_radius)
    }

    fn assemble(
        slots: Vec<LightSlot>,
        sources: Vec<Source>,
        backdrop: Option<(usize, [f32; 3])>,
        scene_radius: f64,
    ) -> Self {
        let constant = Constant::new(slots.len(), &sources, backdrop);
        let varies = |source: &Source| match source.distant {
            Distant::Sky | Distant::Uniform => false,
            Distant::Overcast | Distant::ClearSky(_) | Distant::Sun(_) => true,
        };
        let varying = (0..sources.len()).filter(|&light| varies(&sources[light])).collect();
        let choice = Choice::new(sources.iter().map(|source| source.power(scene_radius)));
        Self { slots, sources, constant, varying, choice, scene_radius }
    }

    /// The same slots and indices with only the lights that `keep` says; the others are dark, and so is the
    /// backdrop.
    #[must_use]
    pub fn select(&self, keep: impl Fn(usize) -> bool) -> Self {
        let mut sources = self.sources.clone();
        for (light, source) in sources.iter_mut().enumerate() {
            if !keep(light) {
                source.strength = [0.0; 3];
            }
        }
        Self::assemble(self.slots.clone(), sources, None, self.scene_radius)
    }

    /// The same slots and indices, with small lights at least as wide as this angle (degrees) and as
    /// much less bright as leaves their light as it is; without the backdrop.
    #[must_use]
    pub fn widened(&self, diameter_degrees: f64) -> Self {
        let mut sources = self.sources.clone();
        for source in &mut sources {
            let before = source.distant.solid_angle();
            if before < SMALL_SOLID_ANGLE {
                source.distant = source.distant.widened(diameter_degrees);
                let part = (before / source.distant.solid_angle()) as f32;
                source.strength = source.strength.map(|strength| strength * part);
            }
        }
        Self::assemble(self.slots.clone(), sources, None, self.scene_radius)
    }

    /// What a film keeps apart, each once, in the order of their first lights.
    #[must_use]
    pub fn slots(&self) -> &[LightSlot] {
        &self.slots
    }

    /// How many lights there are; they are named by indices below that.
    #[must_use]
    pub fn count(&self) -> usize {
        self.sources.len()
    }

    /// The slot of a light.
    #[must_use]
    pub fn slot_of(&self, light: usize) -> usize {
        self.sources[light].slot
    }

    /// Adds the radiances along a path that escapes in `direction` after meeting something to those of each
    /// slot. The hemisphere is decided by the sign of `direction.y` (the paper, section 4.1).
    pub fn add_radiances(&self, direction: DVec3, sums: &mut [[f32; 3]]) {
        let constant = &self.constant;
        add_all(sums, if direction.y > 0.0 { &constant.above } else { &constant.below });
        for source in self.varying.iter().map(|&light| &self.sources[light]) {
            add(&mut sums[source.slot], source.radiance(direction));
        }
    }

    /// Adds the radiances of a camera ray that meets nothing to those of each slot.
    pub fn add_seen_by_camera(&self, direction: DVec3, sums: &mut [[f32; 3]]) {
        let constant = &self.constant;
        let seen = if direction.y > 0.0 { &constant.seen_above } else { &constant.seen_below };
        add_all(sums, seen);
        for source in self.varying.iter().map(|&light| &self.sources[light]) {
            if source.visible_to_camera {
                add(&mut sums[source.slot], source.radiance(direction));
            }
        }
    }

    /// What scales the ice paths of a film: the greatest component of any radiance, of the disc of a sun
    /// a small part.
    #[must_use]
    pub fn greatest_radiance(&self) -> f32 {
        let Constant { above, below, seen_above, seen_below } = &self.constant;
        let constant = [above, below, seen_above, seen_below].into_iter().flatten().flatten();
        let varying = self.varying.iter().map(|&light| &self.sources[light]).flat_map(|source| {
            let factor = match &source.distant {
                Distant::Sun(_) => 1.0 / DISC_OVER_SCALE,
                Distant::ClearSky(sky) => sky.greatest() as f32,
                Distant::Sky | Distant::Uniform | Distant::Overcast => 1.0,
            };
            source.strength.map(|strength| strength * factor)
        });
        constant.copied().chain(varying).fold(0.0, f32::max)
    }

    /// Solid angle that a light fills as seen from the scene, sr.
    #[must_use]
    pub fn solid_angle(&self, light: usize) -> f64 {
        self.sources[light].distant.solid_angle()
    }

    /// Whether paths hardly find a light by chance: seen from the scene it fills less than
    /// [`SMALL_SOLID_ANGLE`].
    #[must_use]
    pub fn is_small(&self, light: usize) -> bool {
        self.solid_angle(light) < SMALL_SOLID_ANGLE
    }
}

impl Source {
    fn radiance(&self, direction: DVec3) -> [f32; 3] {
        let factor = self.distant.radiance(direction) as f32;
        self.strength.map(|strength| strength * factor)
    }

    /// Luminous power that enters a sphere of this radius, up to a common factor.
    fn power(&self, scene_radius: f64) -> f64 {
        luminance(self.strength) * self.distant.total() * PI * scene_radius * scene_radius
    }
}

impl Constant {
    fn new(slots: usize, sources: &[Source], backdrop: Option<(usize, [f32; 3])>) -> Self {
        let dark = vec![[0.0; 3]; slots];
        let [mut above, mut below, mut seen_above, mut seen_below] =
            [dark.clone(), dark.clone(), dark.clone(), dark];
        for source in sources {
            let (slot, visible) = (source.slot, source.visible_to_camera);
            let whole_sphere = match source.distant {
                Distant::Sky => false,
                Distant::Uniform => true,
                Distant::Overcast | Distant::ClearSky(_) | Distant::Sun(_) => continue,
            };
            let sums = [
                (&mut above, true),
                (&mut below, whole_sphere),
                (&mut seen_above, visible),
                (&mut seen_below, visible && whole_sphere),
            ];
            for (sum, _) in sums.into_iter().filter(|(_, shines)| *shines) {
                add(&mut sum[slot], source.strength);
            }
        }
        if let Some((slot, backdrop)) = backdrop {
            (seen_above[slot], seen_below[slot]) = (backdrop, backdrop);
        }
        Self { above, below, seen_above, seen_below }
    }
}

/// What a film keeps apart of these lights.
#[must_use]
pub fn slots_of(lights: &[LightDescription], backdrop: [f32; 3]) -> Vec<LightSlot> {
    let slot = |light: &LightDescription| LightSlot {
        group: light.group.clone(),
        spectrum: light.spectrum,
    };
    let behind = LightSlot { group: BACKDROP_GROUP.to_owned(), spectrum: Illuminant::D65 };
    let behind = shows_backdrop(lights, backdrop).then_some(behind);
    let mut slots = Vec::new();
    for slot in lights.iter().map(slot).chain(behind) {
        if !slots.contains(&slot) {
            slots.push(slot);
        }
    }
    if slots.is_empty() {
        slots.push(LightSlot { group: BACKDROP_GROUP.to_owned(), spectrum: Illuminant::D65 });
    }
    slots
}

/// Whether the camera sees a backdrop that is not black.
fn shows_backdrop(lights: &[LightDescription], backdrop: [f32; 3]) -> bool {
    let covers = |light: &LightDescription| match light.kind {
        LightKind::Sky | LightKind::Uniform | LightKind::Overcast | LightKind::ClearSky { .. } => {
            light.visible_to_camera
        }
        LightKind::Sun { .. } => false,
    };
    backdrop != [0.0; 3] && !lights.iter().any(covers)
}

/// Luminance of linear sRGB (IEC 61966-2-1).
fn luminance([r, g, b]: [f32; 3]) -> f64 {
    0.2126 * f64::from(r) + 0.7152 * f64::from(g) + 0.0722 * f64::from(b)
}

fn add_all(sums: &mut [[f32; 3]], radiances: &[[f32; 3]]) {
    sums.iter_mut().zip(radiances).for_each(|(sum, radiance)| add(sum, *radiance));
}

fn add(sum: &mut [f32; 3], radiance: [f32; 3]) {
    for (sum, radiance) in sum.iter_mut().zip(radiance) {
        *sum += radiance;
    }
}

#[cfg(test)]
mod tests;
