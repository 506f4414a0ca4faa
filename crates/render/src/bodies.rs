//! Which body of snow a grain belongs to, and what follows from that: its stratum and its shape.
//!
//! Grains fall body by body, but lie in the order of their places.

use crate::RenderError;
use crate::description::{SceneDescription, SnowDescription};
use snowgrain_geometry::{GrainShape, Quantisation, QuantisedGrain, Shape, ShapeKind};
use snowgrain_grains::shapes::digest;
use snowgrain_grains::{FieldShapes, GrainField, GrainsError, Snowfall, turned_to_touch};
use std::collections::HashMap;

/// The bodies of the grains that are known.
///
/// Two of a hundred million grains share a digest by chance once in a thousand scenes.
#[derive(Debug)]
pub(crate) struct KnownGrains<'a> {
    description: &'a SceneDescription,
    wants_bodies: bool,
    body_of: HashMap<u64, u16>,
}

impl<'a> KnownGrains<'a> {
    /// For strata and shapes.
    pub(crate) fn of_scene(description: &'a SceneDescription) -> Self {
        let wants_strata = !description.strata.loads.is_empty();
        Self { wants_bodies: wants_strata, ..Self::of_shapes(description) }.or_for_shapes()
    }

    /// For shapes alone.
    pub(crate) fn of_shapes(description: &'a SceneDescription) -> Self {
        Self { description, wants_bodies: false, body_of: HashMap::new() }.or_for_shapes()
    }

    fn or_for_shapes(mut self) -> Self {
        self.wants_bodies |= self.description.has_shapes() && self.description.snow.len() > 1;
        self
    }

    /// Learns the grains of a body, which are those that were not there before.
    pub(crate) fn learn(&mut self, body: usize, snowfall: &Snowfall<'_>) {
        if self.wants_bodies {
            snowfall.for_each_grain(|grain| {
                self.body_of.entry(digest(grain)).or_insert(body as u16);
            });
        }
    }

    fn body(&self, grain: QuantisedGrain) -> usize {
        self.body_of.get(&digest(grain)).copied().unwrap_or(0).into()
    }

    /// The strata of all grains of the field in their order; empty where there are none.
    pub(crate) fn strata(&self, field: &GrainField) -> Vec<u8> {
        let strata = &self.description.strata;
        if strata.loads.is_empty() {
            return Vec::new();
        }
        field.quantised().map(|grain| strata.of_body(self.body(grain))).collect()
    }

    /// The field with the shapes of its grains, where they are not all spheres.
    ///
    /// # Errors
    /// More prototypes than can be told apart.
    pub(crate) fn shaped(&self, field: GrainField) -> Result<GrainField, RenderError> {
        let description = self.description;
        if !description.has_shapes() {
            return Ok(field);
        }
        let mut prototypes = Prototypes::default();
        let sphere = Shape::new(ShapeKind::Sphere).expect("a sphere has no number out of range");
        let sphere = GrainShape::upright(prototypes.index_of(&sphere, 0)?);
        let mut told = HashMap::new();
        let mut mixed = Vec::new();
        for (body, snow) in description.snow.iter().enumerate() {
            let shapes = description.shapes_of(body).map_or(&[][..], |mix| mix.shapes());
            let of_body: Result<Vec<usize>, RenderError> =
                shapes.iter().map(|mixed| prototypes.index_of(&mixed.shape, body)).collect();
            mixed.push(of_body?);
            if let (SnowDescription::Grains(placed), []) = (snow, shapes) {
                prototypes.tell(placed, field.quantisation, body, &mut told)?;
            }
        }
        let shape = |grain: QuantisedGrain| {
            let body = self.body(grain);
            if let Some(mix) = description.shapes_of(body) {
                let (which, quaternion) = mix.draw(grain);
                return GrainShape::new(mixed[body][which], quaternion);
            }
            // Grains in one place that differ in shape alone come in their order.
            let mut next = || told.get_mut(&digest(grain))?.pop();
            next().unwrap_or(sphere)
        };
        let of_grains = field.quantised().map(shape).collect();
        let shapes = FieldShapes { prototypes: prototypes.shapes.into(), of_grains };
        // What floats is turned, but for grains whose shapes a file tells.
        let turned = |_, grain, turn| {
            let body = self.body(grain);
            let (which, quaternion) = description.shapes_of(body)?.draw_again(grain, turn);
            Some(GrainShape::new(mixed[body][which], quaternion))
        };
        Ok(turned_to_touch(field.with_shapes(shapes), [0; 3], turned))
    }
}

/// Prototypes of a scene, each once.
#[derive(Default)]
struct Prototypes {
    shapes: Vec<Shape>,
}

impl Prototypes {
    fn index_of(&mut self, shape: &Shape, body: usize) -> Result<usize, RenderError> {
        if let Some(index) = self.shapes.iter().position(|known| known.name() == shape.name()) {
            return Ok(index);
        }
        if self.shapes.len() == GrainShape::MOST_PROTOTYPES {
            let reason = format!("a scene holds at most {} shapes", GrainShape::MOST_PROTOTYPES);
            let source = GrainsError::Setting { key: "shapes", reason };
            return Err(RenderError::Snow { index: body, source });
        }
        self.shapes.push(shape.clone());
        Ok(self.shapes.len() - 1)
    }

    /// Notes the shapes that a field tells, by the digests that its grains have in the scene; those of one
    /// digest last first.
    fn tell(
        &mut self,
        field: &GrainField,
        quantisation: Quantisation,
        body: usize,
        told: &mut HashMap<u64, Vec<GrainShape>>,
    ) -> Result<(), RenderError> {
        let Some(FieldShapes { prototypes, of_grains }) = field.shapes() else { return Ok(()) };
        let indices: Result<Vec<usize>, RenderError> =
            prototypes.iter().map(|shape| self.index_of(shape, body)).collect();
        let indices = indices?;
        for (grain, shape) in field.quantised().zip(of_grains) {
            let placed = if field.quantisation == quantisation {
                grain
            } else {
                let metres = field.quantisation.grain(grain);
                let rounded = quantisation.round(metres.center, metres.radius);
                rounded.map_err(|e| RenderError::Snow { index: body, source: e.into() })?
            };
            let shape = shape.with_prototype(indices[shape.prototype()]);
            told.entry(digest(placed)).or_default().insert(0, shape);
        }
        Ok(())
    }
}
