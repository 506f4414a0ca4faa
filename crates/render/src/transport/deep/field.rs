//! The field of outcomes: coarse cells, and what paths bring from each.

use super::DeepSettings;
use super::levels::Levels;
use super::samples::Samples;
use super::scale::Scale;
use crate::camera::Camera;
use crate::light::Lights;
use crate::transport::Contribution;
use crate::world::World;
use snowgrain_accel::{ArrivalFrom, GrainVisit, GrainsBefore, Interior, STRATA, SimdLevel};
use snowgrain_geometry::Shape;
use snowgrain_math::DVec3;
use snowgrain_math::sampler::PathKey;

/// What paths bring from each place deep in the snow on. See the module's page.
#[derive(Clone, Debug)]
pub struct OutcomeField {
    pub(super) interior: Interior,
    pub(super) after: GrainsBefore,
    /// How far ahead of an arrival it counts, in coarse cells along each axis.
    ahead: DVec3,
    /// Unit of lengths in ice, metres.
    pub(super) unit: f64,
    pub(super) slots: usize,
    pub(super) has_strata: bool,
    pub(super) lights: Lights,
    levels: Levels,
}

impl OutcomeField {
    /// Nothing is learnt yet; `None` where no snow is deep.
    pub(super) fn unlearnt(
        (world, camera): (&World, &Camera),
        lights: &Lights,
        settings: &DeepSettings,
        scale: Scale,
    ) -> Option<Self> {
        let unit = scale.transport_length;
        let rings = (settings.depth / settings.cell).ceil() as u32;
        let grains = settings
            .after_grains
            .map(|grains| (f64::from(grains) * scale.grains_for_one).round() as u32);
        let width = |place: DVec3| {
            DeepSettings::width(camera.pixel_footprint(camera.depth(place)) / scale.radius)
        };
        let interior = world.grid.interior(settings.cell * unit, rings);
        interior.has_deep().then(|| Self {
            ahead: DVec3::splat(scale.ahead) / interior.edges(),
            interior,
            after: GrainsBefore::by_width(grains, &world.grid, width),
            unit,
            slots: lights.slots().len(),
            has_strata: world.grid.has_strata(),
            lights: lights.clone(),
            levels: Levels::default(),
        })
    }

    /// Samples of its slots and strata, none yet.
    pub(super) fn no_samples(&self) -> Samples {
        Samples::new(self.slots, if self.has_strata { STRATA } else { 0 })
    }

    /// The same with what paths brought; `None` where none of them came by.
    pub(super) fn learnt(mut self, samples: &Samples) -> Option<Self> {
        self.levels = Levels::of(samples);
        (samples.len() > 0).then_some(self)
    }

    /// What was learnt, as bytes under a key ([`super::LearntStore`]).
    #[must_use]
    pub fn to_bytes(&self, key: &[u8; 32]) -> Vec<u8> {
        self.levels.to_bytes(key)
    }

    /// The same as [`Self::learn`] gives, of such bytes; `None` where they are damaged, of another key or of other lights.
    #[must_use]
    pub fn from_bytes(
        (world, prototypes, camera): (&World, &[Shape], &Camera),
        lights: &Lights,
        settings: &DeepSettings,
        (key, bytes): (&[u8; 32], &[u8]),
        level: SimdLevel,
    ) -> Option<Self> {
        let levels = Levels::from_bytes(key, bytes)?;
        let scale = Scale::of(world, prototypes, level)?;
        let field = Self::unlearnt((world, camera), lights, settings, scale)?;
        (levels.slots == field.slots).then_some(Self { levels, ..field })
    }

    /// Relative standard error of all that is learnt together: by so much the mean of the learnt light of a whole picture
    /// may be off.
    #[must_use]
    pub fn relative_error(&self) -> f64 {
        self.levels.relative_error()
    }

    /// Whether an arrival of a path is deep in the snow.
    pub(super) fn is_deep(&self, visit: &GrainVisit, key: PathKey) -> bool {
        let cell = visit.center.cell;
        visit.from == ArrivalFrom::Air
            && self.interior.is_deep(cell)
            && self.after.are_met(visit.grain_visits - 1, cell, key)
    }

    /// Where an arrival counts, in coarse cells.
    pub(super) fn place(&self, visit: &GrainVisit) -> DVec3 {
        let direction = DVec3::from_array(visit.direction.map(f64::from));
        self.interior.coordinates(visit.center) + direction * self.ahead
    }

    /// Adds what a path of this throughput that ends at an arrival deep in the snow brings; gives its relative standard
    /// error.
    pub(crate) fn outcome(
        &self,
        visit: &GrainVisit,
        throughput: [f32; 3],
        quantum: f64,
        found: &mut Vec<Contribution>,
    ) -> f64 {
        let around = self.levels.around(self.place(visit));
        let length = f64::from(visit.ice_length) * quantum;
        let in_strata = visit.ice_in_strata.map(|length| f64::from(length) * quantum);
        let mean = f64::from(throughput.iter().sum::<f32>()) / 3.0;
        let (mut light, mut variance) = (0.0, 0.0);
        for slot in 0..self.slots {
            let outcome = self.levels.outcome(&around, slot);
            let about = (slot, visit.event, self.unit);
            let weights = outcome.weight.iter().zip(throughput);
            light += weights.map(|(weight, part)| f64::from(weight * part)).sum::<f64>() / 3.0;
            let error = mean * f64::from(outcome.standard_error);
            variance += error * error;
            found.extend(outcome.contributions(about, throughput, (length, in_strata)));
        }
        if light > 0.0 { variance.sqrt() / light } else { 0.0 }
    }

    /// Number of cells that are learnt.
    #[must_use]
    pub fn cells(&self) -> usize {
        self.levels.len()
    }

    /// Memory, bytes.
    #[must_use]
    pub fn memory_bytes(&self) -> u64 {
        self.levels.memory_bytes() + self.interior.memory_bytes()
    }
}
