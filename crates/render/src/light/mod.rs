//! Lights: what a path that escapes meets, and how directions are drawn towards light.
//!
//! A film keeps the light of each *slot* apart: of each pair of a group's name and a spectrum. A light
//! belongs to one slot.

mod area;
mod choice;
mod clear_sky;
mod description;
mod direction_table;
mod distant;
mod emitters;
mod environment;
mod near;
mod sample;

pub use description::{LightDescription, LightKind, direction_of};
pub use distant::irradiance_of_disc;
pub use emitters::{Emitter, LitSurfaces};
pub use environment::{EnvironmentMap, LARGEST_MAP, check_map_size};
pub use sample::LightSample;

use choice::Choice;
use distant::{Distant, SPOT_OVER_SCALE};
use near::Near;
use snowgrain_math::{Aabb, DVec3};
use snowgrain_optics::Illuminant;

/// Group of what the camera sees where no light is.
pub const BACKDROP_GROUP: &str = "backdrop";

/// Solid angle, sr, below which light is hardly found by chance.
pub const SMALL_SOLID_ANGLE: f64 = 0.1;

/// How paths find a light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightRole {
    /// A whole sky: by themselves.
    Sky,
    /// A small disc at infinity: hardly ever.
    Sun,
    /// Anything else.
    Lamp,
}

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
    scene: Sphere,
}

/// A sphere around all that is finite in the scene, metres.
#[derive(Clone, Copy, Debug)]
struct Sphere {
    center: DVec3,
    radius: f64,
}

/// One light.
#[derive(Clone, Debug)]
struct Source {
    slot: usize,
    strength: [f32; 3],
    visible_to_camera: bool,
    origin: Origin,
}

/// Where light comes from.
#[derive(Clone, Debug)]
enum Origin {
    Distant(Distant),
    Near(Near),
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
    /// These lights in a scene of these surfaces, of which all but lamps is within `bounds` (metres; an empty
    /// box counts as one of a metre). Camera rays that meet nothing see what is visible to the camera, and
    /// `backdrop` (of D65) where none of it but discs is at infinity.
    #[must_use]
    pub fn new(
        lights: &[LightDescription],
        surfaces: &LitSurfaces,
        backdrop: [f32; 3],
        bounds: &Aabb,
    ) -> Self {
        let slots = slots_of(lights, backdrop);
        let slot = |group: &str, spectrum| {
            slots.iter().position(|slot| slot.group == group && slot.spectrum == spectrum)
        };
        let source = |(light, description): (usize, &LightDescription)| {
            let near = || Near::new(&description.kind, surfaces.of_light(light)).map(Origin::Near);
            Source {
                slot: slot(&description.group, description.spectrum).unwrap_or(0),
                strength: description.strength,
                visible_to_camera: description.visible_to_camera,
                origin: Distant::new(&description.kind)
                    .map(Origin::Distant)
                    .or_else(near)
                    .expect("every kind of light is at infinity, a surface or a point"),
            }
        };
        let sources = lights.iter().enumerate().map(source).collect();
        let backdrop = slot(BACKDROP_GROUP, Illuminant::D65)
            .filter(|_| shows_backdrop(lights, backdrop))
            .map(|slot| (slot, backdrop));
        Self::assemble(slots, sources, backdrop, Sphere::around(bounds))
    }

    fn assemble(
        slots: Vec<LightSlot>,
        sources: Vec<Source>,
        backdrop: Option<(usize, [f32; 3])>,
        scene: Sphere,
    ) -> Self {
        let constant = Constant::new(slots.len(), &sources, backdrop);
        let varies = |&light: &usize| match &sources[light].origin {
            Origin::Distant(distant) => !distant.is_constant(),
            Origin::Near(_) => false,
        };
        let varying = (0..sources.len()).filter(varies).collect();
        let choice = Choice::new(sources.iter().map(|source| source.power(scene)));
        Self { slots, sources, constant, varying, choice, scene }
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
        Self::assemble(self.slots.clone(), sources, None, self.scene)
    }

    /// The same slots and indices, with suns at least as wide as this angle (degrees) and as much less
    /// bright as leaves their light as it is; without the backdrop.
    #[must_use]
    pub fn widened(&self, diameter_degrees: f64) -> Self {
        let mut sources = self.sources.clone();
        for Source { origin, strength, .. } in &mut sources {
            let Origin::Distant(distant) = origin else { continue };
            let wide = distant.widened(diameter_degrees);
            let part = (distant.solid_angle() / wide.solid_angle()) as f32;
            *strength = strength.map(|strength| strength * part);
            *distant = wide;
        }
        Self::assemble(self.slots.clone(), sources, None, self.scene)
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

    /// What scales the ice paths of a film: the greatest component of any radiance, of discs and bright
    /// spots a small part.
    #[must_use]
    pub fn greatest_radiance(&self) -> f32 {
        let Constant { above, below, seen_above, seen_below } = &self.constant;
        let constant = [above, below, seen_above, seen_below].into_iter().flatten().flatten();
        let varying = self.sources.iter().flat_map(|source| {
            let scale = source.scale(self.scene);
            source.strength.map(|strength| strength * scale)
        });
        constant.copied().chain(varying).fold(0.0, f32::max)
    }

    /// Radiance of a luminous surface.
    #[must_use]
    pub fn emission(&self, light: usize) -> [f32; 3] {
        self.sources[light].strength
    }

    /// Adds the radiance of a luminous surface to those of each slot.
    pub fn add_emission(&self, light: usize, sums: &mut [[f32; 3]]) {
        let source = &self.sources[light];
        add(&mut sums[source.slot], source.strength);
    }

    /// Solid angle that a light fills as seen from the scene, sr: of one within reach from its distance to the
    /// middle of the scene, or from the radius of the scene where that is larger. 0 for points.
    #[must_use]
    pub fn solid_angle(&self, light: usize) -> f64 {
        self.sources[light].solid_angle(self.scene)
    }

    /// How paths find a light.
    #[must_use]
    pub fn role(&self, light: usize) -> LightRole {
        match &self.sources[light].origin {
            Origin::Distant(
                Distant::Sky | Distant::Uniform | Distant::Overcast | Distant::ClearSky(_),
            ) => LightRole::Sky,
            Origin::Distant(Distant::Sun(disc)) if disc.solid_angle() < SMALL_SOLID_ANGLE => {
                LightRole::Sun
            }
            Origin::Distant(Distant::Sun(_) | Distant::Environment(_)) | Origin::Near(_) => {
                LightRole::Lamp
            }
        }
    }

    /// Whether paths hardly find a light by chance: seen from the scene it fills less than
    /// [`SMALL_SOLID_ANGLE`].
    #[must_use]
    pub fn is_small(&self, light: usize) -> bool {
        self.solid_angle(light) < SMALL_SOLID_ANGLE
    }

    /// Whether a light is a point, which no path meets.
    #[must_use]
    pub fn is_point(&self, light: usize) -> bool {
        match &self.sources[light].origin {
            Origin::Distant(_) => false,
            Origin::Near(near) => near.is_point(),
        }
    }
}

impl Sphere {
    fn around(bounds: &Aabb) -> Self {
        if bounds.is_empty() {
            return Self { center: DVec3::ZERO, radius: 1.0 };
        }
        Self { center: bounds.center(), radius: bounds.size().length() * 0.5 }
    }

    /// The distance that a light within reach is seen from, squared.
    fn distance_squared(&self, near: &Near) -> f64 {
        let distance = near.center().map_or(0.0, |center| center.distance_squared(self.center));
        distance.max(self.radius * self.radius)
    }
}

impl Source {
    /// Radiance from infinity.
    fn radiance(&self, direction: DVec3) -> [f32; 3] {
        match &self.origin {
            Origin::Distant(distant) => {
                let radiance = distant.radiance(direction);
                std::array::from_fn(|channel| self.strength[channel] * radiance[channel])
            }
            Origin::Near(_) => [0.0; 3],
        }
    }

    fn solid_angle(&self, scene: Sphere) -> f64 {
        match &self.origin {
            Origin::Distant(distant) => distant.solid_angle(),
            Origin::Near(near) => near.shadow() / scene.distance_squared(near),
        }
    }

    /// Luminous flux onto a sphere around the scene, up to a common factor.
    fn power(&self, scene: Sphere) -> f64 {
        let total = match &self.origin {
            Origin::Distant(distant) => distant.total(),
            Origin::Near(near) if near.is_point() => 1.0 / scene.distance_squared(near),
            Origin::Near(_) => self.solid_angle(scene),
        };
        luminance(self.strength) * total
    }

    /// What scales the ice paths of a film, for a strength of 1.
    fn scale(&self, scene: Sphere) -> f32 {
        match &self.origin {
            Origin::Distant(distant) => distant.scale(),
            Origin::Near(near) if near.is_point() => 1.0 / scene.distance_squared(near) as f32,
            Origin::Near(_) if self.solid_angle(scene) < SMALL_SOLID_ANGLE => 1.0 / SPOT_OVER_SCALE,
            Origin::Near(_) => 1.0,
        }
    }
}

impl Constant {
    fn new(slots: usize, sources: &[Source], backdrop: Option<(usize, [f32; 3])>) -> Self {
        let dark = vec![[0.0; 3]; slots];
        let [mut above, mut below, mut seen_above, mut seen_below] =
            [dark.clone(), dark.clone(), dark.clone(), dark];
        for source in sources {
            let (slot, visible) = (source.slot, source.visible_to_camera);
            let whole_sphere = match &source.origin {
                Origin::Distant(Distant::Sky) => false,
                Origin::Distant(Distant::Uniform) => true,
                Origin::Distant(_) | Origin::Near(_) => continue,
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
        LightKind::Sky
        | LightKind::Uniform
        | LightKind::Overcast
        | LightKind::ClearSky { .. }
        | LightKind::Environment { .. } => light.visible_to_camera,
        LightKind::Sun { .. }
        | LightKind::Sphere { .. }
        | LightKind::Quad { .. }
        | LightKind::Object { .. }
        | LightKind::Point { .. }
        | LightKind::Spot { .. } => false,
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
