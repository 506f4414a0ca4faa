//! Glints: crystals that send the image of a sun into the camera, counted by where the light went.
//!
//! A face mirrors a sun into the camera where its normal halves the angle between the two. Of faces whose normals
//! point in all directions alike that is the part
//!
//! ```text
//! Omega / (16 pi cos theta_h)
//! ```
//!
//! with the solid angle Omega of the sun and half the angle theta_h between sun and camera, since the direction of
//! the mirrored light turns by 4 cos theta_h times the solid angle of the normal; the number among many grains is a
//! Poisson variable. Outer reflections are counted so face by face. What is refracted through a crystal, or reflected
//! within, is counted by the chains of rays that the camera sends through it ([`chain`]): all rays by the same faces
//! leave along the same direction, and are one glint.

use crate::World;
use crate::camera::{Bundle, Camera};
use crate::measure::in_tasks;
use core::f64::consts::PI;
use snowgrain_accel::flight::chain;
use snowgrain_accel::{Probe, ProbeAnswer, Probes, SimdLevel};
use snowgrain_geometry::shape::FlatFace;
use snowgrain_geometry::{Grain, GrainShape, Shape};
use snowgrain_grains::{FieldShapes, GrainField};
use snowgrain_math::sampler::{PathKey, numbers};
use snowgrain_math::{DMat3, DVec3, Ray, frame, trig};
use snowgrain_optics::Dielectric;

/// Middle of the lens.
const LENS: [f64; 2] = [0.5; 2];
/// Directions nearer than this are one.
const SAME_DIRECTION: f64 = 1e-9;

/// How light goes from a sun over a crystal to the camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GlintKind {
    /// Reflected by a face outside.
    Reflected,
    /// Through the crystal by one chord.
    Refracted,
    /// Reflected within, once or more.
    ReflectedWithin,
}

impl GlintKind {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Reflected, Self::Refracted, Self::ReflectedWithin];

    fn after(chords: u32) -> Self {
        match chords {
            0 => Self::Reflected,
            1 => Self::Refracted,
            _ => Self::ReflectedWithin,
        }
    }
}

/// Glints of one kind.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GlintCount {
    /// Those that the geometry of sun, crystal and camera makes.
    pub made: u64,
    /// Of them, those that nothing hides from the sun or from the camera.
    pub seen: u64,
    /// Sum of the parts of the sun's radiance that those which are made show.
    pub weight: f64,
}

/// All glints of one sun.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GlintMeasure {
    /// Grains in the picture that are single crystals with flat faces.
    pub crystals: u64,
    /// Grains in the picture that are not, and are passed over.
    pub passed_over: u64,
    /// Outward faces of the crystals.
    pub faces: u64,
    /// Faces that would mirror the sun if their normals pointed in all directions alike.
    pub expected: f64,
    /// Of each [`GlintKind::ALL`].
    pub counts: [GlintCount; 3],
}

/// A sun, far away.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GlintSun {
    /// Unit vector towards it.
    pub direction: DVec3,
    /// Angle across it, degrees.
    pub diameter_degrees: f64,
}

impl GlintSun {
    fn cosine(&self) -> f64 {
        trig::sin_cos(0.5 * self.diameter_degrees.to_radians()).1
    }
}

/// Counts the glints of a sun among the grains of a field, packed in `world`, that the middle of the camera's lens
/// sees, with so many rays through each crystal; `seed` chooses them.
#[must_use]
pub fn measure_glints(
    (world, field): (&World, &GrainField),
    camera: &Camera,
    sun: GlintSun,
    (rays, seed): (u32, u64),
    level: SimdLevel,
) -> GlintMeasure {
    let grains = field.grains();
    let none = GlintMeasure { passed_over: grains.len() as u64, ..GlintMeasure::default() };
    let Some(shapes) = field.shapes() else { return none };
    let faces: Vec<Vec<FlatFace>> = shapes.prototypes.iter().map(faces_of).collect();
    let task = |first: u64, count: u64| {
        let probes = Probes::new(&world.grid, &world.surfaces, world.eta, level);
        let measure = GlintMeasure::default();
        let mut counter =
            Counter { world, camera, sun, shapes, faces: &faces, probes, rays, seed, measure };
        for index in first as usize..(first + count) as usize {
            let grain = field.quantisation.grain(grains[index]);
            counter.add(index as u64, grain, shapes.of_grains[index]);
        }
        counter.measure
    };
    in_tasks(grains.len() as u64, task).iter().fold(GlintMeasure::default(), GlintMeasure::with)
}

/// Of a single convex polyhedron; none of other shapes.
fn faces_of(shape: &Shape) -> Vec<FlatFace> {
    match shape.parts() {
        [part] => part.flat_faces(),
        _ => Vec::new(),
    }
}

impl GlintMeasure {
    fn with(mut self, other: &Self) -> Self {
        self.crystals += other.crystals;
        self.passed_over += other.passed_over;
        self.faces += other.faces;
        self.expected += other.expected;
        for (sum, count) in self.counts.iter_mut().zip(&other.counts) {
            sum.made += count.made;
            sum.seen += count.seen;
            sum.weight += count.weight;
        }
        self
    }
}

/// Counts for one thread.
struct Counter<'a> {
    world: &'a World,
    camera: &'a Camera,
    sun: GlintSun,
    shapes: &'a FieldShapes,
    faces: &'a [Vec<FlatFace>],
    probes: Probes<'a>,
    rays: u32,
    seed: u64,
    measure: GlintMeasure,
}

/// A crystal in its place.
struct Crystal {
    center: DVec3,
    radius: f64,
    rotation: DMat3,
    /// Unit vector to the camera.
    to_camera: DVec3,
}

/// Where light leaves a crystal towards the camera, and where it met it from the sun, from its centre, metres.
#[derive(Clone, Copy)]
struct Ends {
    camera: DVec3,
    sun: DVec3,
}

/// A way through a crystal by the same faces.
struct Way {
    chords: u32,
    towards: DVec3,
    weight: f64,
    /// Whether some ray of it is.
    seen: bool,
}

impl Counter<'_> {
    fn add(&mut self, index: u64, grain: Grain, shape: GrainShape) {
        if !self.is_in_picture(grain.center) {
            return;
        }
        let faces = &self.faces[shape.prototype()];
        if faces.is_empty() {
            self.measure.passed_over += 1;
            return;
        }
        let (center, radius, rotation) = (grain.center, grain.radius, shape.rotation());
        let to_camera = self.to_camera(center);
        let crystal = Crystal { center, radius, rotation, to_camera };
        self.measure.crystals += 1;
        self.measure.faces += faces.len() as u64;
        let cosine = 0.5 * (to_camera + self.sun.direction).length();
        if cosine > 0.0 {
            let omega = 2.0 * PI * (1.0 - self.sun.cosine());
            self.measure.expected += faces.len() as f64 * omega / (16.0 * PI * cosine);
        }
        self.count_faces(&crystal, faces);
        self.count_chains(index, &crystal, &self.shapes.prototypes[shape.prototype()]);
    }

    fn is_in_picture(&self, point: DVec3) -> bool {
        self.camera.project(point, LENS).is_some_and(|(x, y)| self.camera.shows(x, y))
    }

    fn to_camera(&self, point: DVec3) -> DVec3 {
        match self.camera.bundle(LENS) {
            Bundle::Through(eye) => (eye - point).normalize(),
            Bundle::Along(forward) => -forward,
        }
    }

    /// Faces that mirror the sun into the camera.
    fn count_faces(&mut self, crystal: &Crystal, faces: &[FlatFace]) {
        for face in faces {
            let normal = crystal.rotation * face.normal;
            let at = crystal.rotation * face.centroid * crystal.radius;
            let to_camera = self.to_camera(crystal.center + at);
            let cosine = normal.dot(to_camera);
            let mirrored = normal * (2.0 * cosine) - to_camera;
            if cosine > 0.0 && mirrored.dot(self.sun.direction) >= self.sun.cosine() {
                let weight = Dielectric { eta: self.world.eta }.reflectance_from_outside(cosine);
                let seen = self.is_seen(crystal, Ends { camera: at, sun: at }, mirrored);
                self.book(GlintKind::Reflected, weight, seen);
            }
        }
    }

    /// What goes through the crystal from the sun into the camera, each way by the same faces once.
    fn count_chains(&mut self, index: u64, crystal: &Crystal, shape: &Shape) {
        let back = crystal.rotation.transpose();
        let along = back * -crystal.to_camera;
        let (s, t) = frame::tangents(along);
        let reach = shape.bounding_radius();
        let mut found: Vec<Way> = Vec::new();
        for ray in 0..self.rays {
            let [u, v, _] = numbers(PathKey::new(self.seed, index, 0), ray).map(f64::from);
            let (sin, cos) = trig::sin_cos(2.0 * PI * v);
            let aside = (s * cos + t * sin) * (reach * u.sqrt());
            let origin = aside - along * (2.0 * reach);
            let Some(chain) = chain(shape, &Ray::new(origin, along), self.world.eta) else {
                continue;
            };
            let Some(entry) = chain.outgoing.first().filter(|out| out.chords == 0) else {
                continue;
            };
            let entry = crystal.rotation * entry.ray.origin * crystal.radius;
            for out in chain.outgoing.iter().filter(|out| out.chords > 0) {
                let towards = (crystal.rotation * out.ray.direction).normalize();
                if towards.dot(self.sun.direction) < self.sun.cosine() {
                    continue;
                }
                let is_same = |known: &&mut Way| {
                    known.chords == out.chords
                        && (known.towards - towards).length() < SAME_DIRECTION
                };
                let exit = crystal.rotation * out.ray.origin * crystal.radius;
                let ends = Ends { camera: entry, sun: exit };
                match found.iter_mut().find(is_same) {
                    Some(known) if known.seen => {}
                    Some(known) => known.seen = self.is_seen(crystal, ends, towards),
                    None => {
                        let (chords, weight) = (out.chords, out.weight);
                        let seen = self.is_seen(crystal, ends, towards);
                        found.push(Way { chords, towards, weight, seen });
                    }
                }
            }
        }
        for way in found {
            self.book(GlintKind::after(way.chords), way.weight, way.seen);
        }
    }

    fn book(&mut self, kind: GlintKind, weight: f64, seen: bool) {
        let count = &mut self.measure.counts[kind as usize];
        count.made += 1;
        count.seen += u64::from(seen);
        count.weight += weight;
    }

    /// Whether the way from the camera and that to the sun, along `towards`, are clear.
    fn is_seen(&mut self, crystal: &Crystal, ends: Ends, towards: DVec3) -> bool {
        let at = crystal.center + ends.camera;
        let distance = match self.camera.bundle(LENS) {
            Bundle::Through(eye) => (eye - at).length(),
            Bundle::Along(_) => f64::INFINITY,
        };
        self.is_in_picture(at)
            && self.is_clear(crystal, ends.camera, (self.to_camera(at), distance))
            && self.is_clear(crystal, ends.sun, (towards, f64::INFINITY))
    }

    /// Whether neither a grain nor an object is in the way from a point of the crystal's surface.
    fn is_clear(
        &mut self,
        crystal: &Crystal,
        from: DVec3,
        (along, distance): (DVec3, f64),
    ) -> bool {
        let surfaces = &self.world.surfaces;
        let ray = Ray::new(crystal.center + from, along);
        if !surfaces.is_empty() && surfaces.intersect(&ray, distance, None).is_some() {
            return false;
        }
        let (grid, reach) = (&self.world.grid, from.length());
        let quanta = |metres: f64| (metres / grid.quantum()).min(1e30) as f32;
        let grain = (grid.locate(crystal.center), quanta(reach));
        let probe = Probe::leaving(grid, grain, from / reach, along, quanta(distance));
        let Some(probe) = probe else { return true };
        let mut is_clear = false;
        self.probes.follow(&[probe], |_, answer| {
            is_clear = match answer {
                ProbeAnswer::Clear => true,
                ProbeAnswer::Through(_) | ProbeAnswer::Met { .. } | ProbeAnswer::Covered => false,
            };
        });
        is_clear
    }
}
