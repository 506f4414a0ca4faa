//! What a scene will cost, before anything of it is made.

use crate::camera::Camera;
use crate::description::{
    DirectView, IntegratorKind, LightDescription, LightFinding, LightKind, ObjectDescription,
    ObjectShape, Packing, SceneDescription, SnowDescription,
};
use crate::light::slots_of;
use crate::scene;
use crate::transport::deep::DeepSettings;
use core::f64::consts::PI;
use snowgrain_accel::STRATA;
use snowgrain_film::{IcePathLayout, LearntSums, PixelRect, PixelSums, ShadowSums};
use snowgrain_geometry::{Quantisation, QuantisedGrain, TriangleMesh, teapot::teapot};
use snowgrain_grains::{
    Amount, Body, DepositRule, DepositSettings, FillSettings, ICE_DENSITY, LatticeCell,
    LatticeSettings, VARIANTS,
};
use snowgrain_math::{Aabb, DVec3};
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

/// Bytes a grain of the packed grid: measured 58 to 74 in the built-in scenes and the benchmarks, more
/// where grains lie in fewer than about 10^5. The structure that grains fall on takes less (about 20)
/// and is gone before they are packed. Taken high: it decides whether a scene is let in.
const FAST_BYTES_PER_GRAIN: f64 = 110.0;
/// The same of the compact packing, measured 26 to 37.
const COMPACT_BYTES_PER_GRAIN: f64 = 60.0;
/// While grains with shapes are packed: the grain, its bounding sphere, its shape and its word.
const BYTES_PER_SHAPED_GRAIN: f64 = 48.0;
/// Bytes a grain while it falls and is written: the stacks (measured 13 to 20).
const FALL_BYTES_PER_GRAIN: f64 = 24.0;
/// Bytes a grain that is noted by its stratum until all are packed: a table that is at worst a quarter
/// full after it grew, and a list.
const BYTES_PER_NOTED_GRAIN: f64 = 45.0;
/// Edges of the packed grid's cells and bricks where snow is thin (`snowgrain_accel::GrainGrid`).
const SIDE_IN_RADII: f64 = 4.0;
const CELLS_PER_BRICK_EDGE: f64 = 8.0;
const BYTES_PER_BRICK: f64 = 2048.0;
/// Of snow made of tiles: edges of its cells, grains of a tile at most, bricks at the faces of a box that differ, those of
/// other bodies over the sides of the box around them, bytes of the cells of such a brick that no tile shows, bytes
/// while it is made, and seconds of a processor a brick and a tile.
const TILED_SIDE_IN_RADII: f64 = 2.5;
const GRAINS_PER_TILE: f64 = 100_000.0;
const BOX_BRICKS: f64 = 5_000.0;
const FACES_OVER_BOX: f64 = 1.5;
const FACE_BYTES_PER_BRICK: f64 = 8_000.0;
const TILE_BUILDING_BYTES: u64 = 300 << 20;
const SECONDS_PER_FACE_BRICK: f64 = 2e-4;
const SECONDS_PER_TILE: f64 = 1.0;
/// Bytes a triangle: as loaded, in the structure that finds it, and while that is built.
const BYTES_PER_TRIANGLE: f64 = 180.0;
/// Bytes a triangle with places in a picture.
const BYTES_PER_PLACED_TRIANGLE: f64 = size_of::<[[f32; 2]; 3]>() as f64;
/// Bytes an object: itself, its place and what finds it.
const BYTES_PER_OBJECT: f64 = 1024.0;
/// Bytes a pixel of what shadow catchers show.
const SHADOW_BYTES: u64 = size_of::<ShadowSums>() as u64;
/// The same of what is known of learnt light.
const LEARNT_BYTES: u64 = size_of::<LearntSums>() as u64;
/// Bytes a pixel beside the sums: layers, and their encoding.
const PICTURE_BYTES_PER_PIXEL: u64 = 180;
/// Films alive at once: the film and the pass that is being added to it.
const FILMS: u64 = 2;

/// Triangles of the built-in teapot.
const TEAPOT_TRIANGLES: f64 = 65_536.0;

/// Seconds of a processor to let a grain fall, by the three rules (measured, order of magnitude).
const SECONDS_PER_RAY_GRAIN: f64 = 0.8e-6;
const SECONDS_PER_STICK_GRAIN: f64 = 0.8e-6;
const SECONDS_PER_ROLL_GRAIN: f64 = 6e-6;
/// Seconds of a processor to pack a grain for light.
const SECONDS_PER_PACKED_GRAIN: f64 = 0.6e-6;
/// Seconds of a processor to follow a path that meets the box of the scene (measured on the built-in
/// scenes, order of magnitude: it depends on how deep light goes).
const SECONDS_PER_PATH: f64 = 12e-6;
/// How much longer a path takes where light is looked for on the way: 2.3 and 2.8 times on the built-in scenes
/// (`docs/performance.md`).
const SEARCHED_OVER_EXACT: f64 = 2.5;
/// How much longer a path takes that is followed to its end than one that may end deep in the snow, at least.
const EXACT_OVER_LEARNT: f64 = 2.0;
/// Of a path that is learnt from, its place and order; of learnt cells, how few paths there are to one, all sizes of
/// cells together, its place, and each outcome.
const BYTES_PER_LEARNT_PATH: u64 = 64;
const PATHS_PER_LEARNT_CELL: u64 = 64;
const BYTES_PER_LEARNT_CELL: u64 = 32;
const BYTES_PER_OUTCOME: u64 = 56;
/// Bytes a grain of the smoothed density that stands for it, while that is made.
const BYTES_PER_SMOOTHED_GRAIN: u64 = 40;
/// Pixels across and down that are asked whether they see the scene.
const PROBES: u32 = 48;

/// What a scene will cost. Memory is meant as an upper bound of what is usual, times as an order of
/// magnitude on one processor of today.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CostEstimate {
    /// Number of grains.
    pub grains: u64,
    /// Memory of the grains and their acceleration while rendering, bytes.
    pub grain_bytes: u64,
    /// Memory that only the making of the snow needs, bytes.
    pub building_bytes: u64,
    /// Memory of the surfaces, the pictures on them and maps of all directions, bytes.
    pub surface_bytes: u64,
    /// Memory of film and picture, bytes.
    pub film_bytes: u64,
    /// Of it, one copy of the sums, bytes; a film file is about as long.
    pub sums_bytes: u64,
    /// Processor seconds to make the snow, to measure the search for light and to learn.
    pub build_seconds: f64,
    /// Processor seconds to render.
    pub render_seconds: f64,
}

impl CostEstimate {
    /// Estimates the scene, rendered over `crop`; looks at vertices and at a few pixels' rays, and
    /// takes no memory to speak of.
    #[must_use]
    pub fn of(description: &SceneDescription, crop: PixelRect) -> Self {
        let mut cost = Self::default();
        let mut bounds = Aabb::EMPTY;
        let (mut meshes, mut textures) = (HashMap::new(), HashSet::new());
        for object in &description.objects {
            let known = meshes.len();
            bounds = bounds.union(&bounds_of(object, &mut meshes));
            let triangles = if meshes.len() > known { triangles(object) } else { 0.0 };
            cost.surface_bytes += (triangles * BYTES_PER_TRIANGLE + BYTES_PER_OBJECT) as u64;
            if let Some(map) = object.surface.texture() {
                if triangles > 0.0 {
                    cost.surface_bytes += (triangles * BYTES_PER_PLACED_TRIANGLE) as u64;
                }
                if textures.insert(Arc::as_ptr(&map.texture)) {
                    cost.surface_bytes += map.texture.memory_bytes();
                }
            }
        }
        cost.surface_bytes += description.lights.iter().map(map_bytes).sum::<u64>();
        let objects = bounds;
        for (index, snow) in description.snow.iter().enumerate() {
            let (grains, body) = match snow {
                SnowDescription::Deposit(settings) => fallen(settings, &bounds),
                SnowDescription::Filled(settings) => {
                    (settings.expected_grains(), settings.body.bounds())
                }
                SnowDescription::Lattice(settings) => {
                    (settings.full_count() as f64, lattice_box(settings))
                }
                SnowDescription::Grains(field) => (field.len() as f64, field.bounds()),
            };
            bounds = bounds.union(&body);
            cost.add_snow(snow, grains, description.packing.unwrap_or_default());
            cost.add_cells(grains, &body, radius_of(snow));
            if description.has_shapes() {
                cost.add_shapes(grains, description.reach_of(index));
            }
        }
        if let Some(bodies) = scene::tiled_bodies(description) {
            cost.replace_by_tiles(&bodies);
        }
        if implicit(description, &objects) {
            (cost.grain_bytes, cost.building_bytes, cost.build_seconds) = (0, 0, 0.0);
        }
        if !description.strata.loads.is_empty() {
            let noted = (cost.grains as f64 * BYTES_PER_NOTED_GRAIN) as u64;
            cost.building_bytes = cost.building_bytes.saturating_add(noted);
        }
        let kept = PixelSums::BYTES as u64 + Self::kept_bytes(description);
        cost.sums_bytes = crop.area() * kept;
        cost.film_bytes = FILMS * cost.sums_bytes + crop.area() * PICTURE_BYTES_PER_PIXEL;
        let paths = crop.area() as f64 * f64::from(description.film.samples_per_pixel);
        cost.render_seconds = paths * seen(description, crop, &bounds) * SECONDS_PER_PATH;
        if let Some(deep) = description.deep.filter(|_| cost.grains > 0) {
            cost.add_deep(description, &deep);
        }
        if description.integrator != IntegratorKind::Grains {
            let smoothed = cost.grains.saturating_mul(BYTES_PER_SMOOTHED_GRAIN);
            cost.grain_bytes = cost.grain_bytes.saturating_add(smoothed);
        }
        if let LightFinding::Sampled(settings) = description.light_finding {
            cost.render_seconds *= SEARCHED_OVER_EXACT;
            if cost.grains > 0 {
                cost.build_seconds += settings.calibration_paths as f64 * SECONDS_PER_PATH;
            }
        }
        cost
    }

    /// Counts the learning of what light brings from deep in the snow.
    fn add_deep(&mut self, description: &SceneDescription, settings: &DeepSettings) {
        let slots = slots_of(&description.lights, description.camera.backdrop).len() as u64;
        let paths = settings.learning_paths;
        let strata = if description.strata.loads.is_empty() { 0 } else { STRATA as u64 };
        let of_path = BYTES_PER_LEARNT_PATH + slots * 4 * (6 + strata);
        self.building_bytes = self.building_bytes.saturating_add(paths.saturating_mul(2 * of_path));
        let of_cell = BYTES_PER_LEARNT_CELL + slots * BYTES_PER_OUTCOME;
        self.surface_bytes += paths / PATHS_PER_LEARNT_CELL * of_cell;
        self.build_seconds += settings.learning_paths as f64 * SECONDS_PER_PATH;
        self.render_seconds /= EXACT_OVER_LEARNT;
    }

    /// Counts tiles of one pack in place of grains: the tiles, the table of bricks, and the bricks at the faces of bodies,
    /// of which those of boxes repeat from tile to tile.
    fn replace_by_tiles(&mut self, bodies: &[&FillSettings]) {
        let radius = bodies[0].pack.radii.largest();
        let edge = CELLS_PER_BRICK_EDGE * TILED_SIDE_IN_RADII * radius;
        let (mut table, mut faces) = (0.0, 0.0);
        for body in bodies {
            let size = body.body.bounds().size();
            let bricks = size / edge + 2.0;
            table += bricks.x * bricks.y * bricks.z;
            let around = bricks.x * bricks.y + bricks.y * bricks.z + bricks.z * bricks.x;
            faces += match body.body {
                Body::Box(_) => BOX_BRICKS.min(2.0 * around),
                Body::Solid(_) | Body::Heights(_) => FACES_OVER_BOX * around,
            };
        }
        let tiles = VARIANTS as f64 * GRAINS_PER_TILE * FAST_BYTES_PER_GRAIN;
        let brick = BYTES_PER_BRICK + FACE_BYTES_PER_BRICK;
        self.grain_bytes = (tiles + 4.0 * table + brick * faces) as u64;
        self.building_bytes = TILE_BUILDING_BYTES;
        self.build_seconds = faces * SECONDS_PER_FACE_BRICK + SECONDS_PER_TILE * VARIANTS as f64;
    }

    /// Bytes a pixel of what the film keeps beside its sums.
    fn kept_bytes(description: &SceneDescription) -> u64 {
        let slots = slots_of(&description.lights, description.camera.backdrop);
        // Layers that a film cannot have are refused when the scene is built.
        let layers = scene::light_layers(description, &slots).ok().flatten();
        let catches = |object: &ObjectDescription| object.direct_view == DirectView::ShadowCatcher;
        let shadows = if description.objects.iter().any(catches) { SHADOW_BYTES } else { 0 };
        let learnt = if description.deep.is_some() { LEARNT_BYTES } else { 0 };
        let layers = layers.map_or(0, |layers| layers.bytes()) + shadows + learnt;
        if !description.film.keep_ice_paths {
            return layers;
        }
        layers + IcePathLayout::for_radiance(slots.len() as u32, 1.0).bytes()
    }

    /// Counts so many more copies of the sums.
    pub fn add_films(&mut self, films: u64) {
        self.film_bytes = self.film_bytes.saturating_add(films.saturating_mul(self.sums_bytes));
    }

    /// The memory of so many grains that fall and are packed, whatever lies around them.
    #[must_use]
    pub fn of_grains(grains: u64) -> Self {
        let mut cost = Self::default();
        cost.add_grains(grains as f64, size_of::<QuantisedGrain>() as f64, 0.0, Packing::Fast);
        cost
    }

    /// The most memory that is needed at once, bytes.
    #[must_use]
    pub fn peak_bytes(&self) -> u64 {
        [self.building_bytes, self.surface_bytes, self.film_bytes]
            .into_iter()
            .fold(self.grain_bytes, u64::saturating_add)
    }

    /// The memory that `snowgrain deposit` takes: grains fall and are kept, nothing is packed.
    #[must_use]
    pub fn of_fall(description: &SceneDescription) -> Self {
        let all = Self::of(description, PixelRect::new(0, 0, 1, 1));
        let building_bytes = (all.grains as f64 * FALL_BYTES_PER_GRAIN) as u64;
        Self {
            grain_bytes: 0,
            building_bytes,
            film_bytes: 0,
            sums_bytes: 0,
            render_seconds: 0.0,
            ..all
        }
    }

    /// The table of bricks of cells, and the entries of those that hold grains: for snow that is
    /// spread thin they outweigh the grains.
    fn add_cells(&mut self, grains: f64, body: &Aabb, radius: f64) {
        if body.is_empty() || radius <= 0.0 {
            return;
        }
        let size = body.size() / (CELLS_PER_BRICK_EDGE * SIDE_IN_RADII * radius);
        let bricks = (size.x + 1.0) * (size.y + 1.0) * (size.z + 1.0);
        let held = bricks.min(8.0 * grains);
        self.grain_bytes += (4.0 * bricks + BYTES_PER_BRICK * held) as u64;
    }

    /// The words beside the blocks, which list more grains where those reach farther, and the shapes and
    /// bounding spheres of all grains while they are packed.
    fn add_shapes(&mut self, grains: f64, reach: f64) {
        let words = grains * FAST_BYTES_PER_GRAIN * (2.0 * reach * reach - 1.0);
        self.grain_bytes = self.grain_bytes.saturating_add(words as u64);
        self.building_bytes += (grains * BYTES_PER_SHAPED_GRAIN) as u64;
    }

    fn add_snow(&mut self, snow: &SnowDescription, grains: f64, packing: Packing) {
        let grain = size_of::<QuantisedGrain>() as f64;
        // What was placed is held once more while it becomes part of the snow.
        let (held, falling) = match snow {
            SnowDescription::Deposit(settings) => (grain, seconds_to_fall(settings)),
            SnowDescription::Filled(_)
            | SnowDescription::Lattice(_)
            | SnowDescription::Grains(_) => (2.0 * grain, 0.0),
        };
        self.add_grains(grains, held, falling, packing);
    }

    /// Grains that are held in `held` bytes each while they are packed, after `falling` seconds each.
    fn add_grains(&mut self, grains: f64, held: f64, falling: f64, packing: Packing) {
        let each = match packing {
            Packing::Fast => FAST_BYTES_PER_GRAIN,
            Packing::Compact => COMPACT_BYTES_PER_GRAIN,
        };
        self.grains = self.grains.saturating_add(grains as u64);
        self.grain_bytes = self.grain_bytes.saturating_add((grains * each) as u64);
        self.building_bytes = self.building_bytes.saturating_add((grains * held) as u64);
        self.build_seconds += grains * (falling + SECONDS_PER_PACKED_GRAIN);
    }
}

fn seconds_to_fall(settings: &DepositSettings) -> f64 {
    match settings.rule {
        Some(DepositRule::Ray) => SECONDS_PER_RAY_GRAIN,
        Some(DepositRule::Stick) => SECONDS_PER_STICK_GRAIN,
        Some(DepositRule::Roll) => SECONDS_PER_ROLL_GRAIN,
        None if settings.density.is_none() => SECONDS_PER_RAY_GRAIN,
        None => SECONDS_PER_ROLL_GRAIN,
    }
}

/// Part of space that the volumes of fallen grains make up, overlaps counted twice.
fn nominal_fraction(settings: &DepositSettings) -> f64 {
    match (settings.density, settings.rule) {
        (Some(density), Some(DepositRule::Ray)) => 1.2 * density / ICE_DENSITY,
        (Some(density), _) => density / ICE_DENSITY,
        (None, Some(DepositRule::Ray) | None) => 0.55,
        (None, Some(DepositRule::Stick)) => 0.2,
        (None, Some(DepositRule::Roll)) => 0.58,
    }
}

/// Number of grains of a snowfall and the box that they will fill, on what fills `below`.
pub(crate) fn fallen(settings: &DepositSettings, below: &Aabb) -> (f64, Aabb) {
    let margin = 2.0 * settings.radii.largest();
    let mut plan = if below.is_empty() { Aabb::new(DVec3::ZERO, DVec3::ZERO) } else { *below };
    match settings.area {
        Some([x0, z0, x1, z1]) => {
            (plan.min.x, plan.min.z, plan.max.x, plan.max.z) = (x0, z0, x1, z1);
        }
        None => plan = plan.expanded(margin),
    }
    let size = plan.size();
    let area = (size.x * size.z).max(f64::MIN_POSITIVE);
    let per_metre =
        area * nominal_fraction(settings) / (4.0 / 3.0 * PI * settings.radii.mean_cube());
    let (grains, depth) = match settings.amount {
        Amount::Grains(grains) => (grains as f64, grains as f64 / per_metre),
        Amount::Depth(depth) => (depth * per_metre, depth),
    };
    plan.max.y += depth + margin;
    (grains, plan)
}

pub(crate) fn lattice_box(settings: &LatticeSettings) -> Aabb {
    // Cells are at most two spacings wide; a loose box does, it only says what the camera sees.
    let spacing = settings.spacing.unwrap_or(2.0 * settings.radius);
    let cell = match settings.kind.grains_per_cell() {
        1 => spacing,
        2 => spacing * 1.155,
        _ => spacing * 1.5,
    };
    Aabb::new(DVec3::ZERO, DVec3::from_array(settings.counts.map(|n| f64::from(n) * cell)))
}

/// Radius of the grains of some snow, metres: the largest, where they differ.
fn radius_of(snow: &SnowDescription) -> f64 {
    match snow {
        SnowDescription::Deposit(settings) => settings.radii.largest(),
        SnowDescription::Filled(settings) => settings.pack.radii.largest(),
        SnowDescription::Lattice(settings) => settings.radius,
        SnowDescription::Grains(field) => {
            f64::from(field.largest_radius_quanta()) * field.quantisation.quantum()
        }
    }
}

/// Whether the snow is one whole lattice clear of all objects, which takes no memory.
fn implicit(description: &SceneDescription, objects: &Aabb) -> bool {
    let [SnowDescription::Lattice(settings)] = description.snow.as_slice() else { return false };
    if description.has_shapes() {
        return false;
    }
    let quantisation = Quantisation::for_grains(DVec3::ZERO, settings.radius);
    let Ok(cell) = LatticeCell::new(settings, &quantisation) else { return false };
    let sides = DVec3::from_array(cell.side_quanta.map(f64::from)) * quantisation.quantum();
    let body = lattice_box(settings);
    let body = Aabb::new(body.min - 2.0 * sides, body.max + 2.0 * sides);
    let packed = snowgrain_accel::LatticeCell {
        side_quanta: cell.side_quanta,
        basis: cell.basis,
        radius_quanta: cell.radius,
    };
    if cell.kept != settings.full_count() || packed.pieces().is_none() {
        return false;
    }
    let apart = objects.is_empty()
        || objects.max.cmplt(body.min).any()
        || objects.min.cmpgt(body.max).any();
    let infinite = description.objects.iter().any(|o| matches!(o.shape, ObjectShape::Plane));
    apart && !infinite
}

fn triangles(object: &ObjectDescription) -> f64 {
    match &object.shape {
        ObjectShape::Mesh(mesh) => mesh.triangles.len() as f64,
        ObjectShape::Teapot => TEAPOT_TRIANGLES,
        ObjectShape::Sphere | ObjectShape::Box | ObjectShape::Plane => 0.0,
    }
}

/// The box around a finite object, metres; empty for an infinite one. `meshes` holds the boxes of
/// the meshes seen before, the teapot as none.
pub(crate) fn bounds_of(
    object: &ObjectDescription,
    meshes: &mut HashMap<Option<*const TriangleMesh>, Aabb>,
) -> Aabb {
    let own = match &object.shape {
        ObjectShape::Plane => return Aabb::EMPTY,
        ObjectShape::Sphere | ObjectShape::Box => Aabb::new(-DVec3::ONE, DVec3::ONE),
        ObjectShape::Teapot => *meshes.entry(None).or_insert_with(|| teapot(8).bounds()),
        ObjectShape::Mesh(mesh) => {
            *meshes.entry(Some(Arc::as_ptr(mesh))).or_insert_with(|| mesh.bounds())
        }
    };
    (0..8u32).fold(Aabb::EMPTY, |bounds, corner| {
        let of = |axis: usize| if corner >> axis & 1 == 0 { own.min[axis] } else { own.max[axis] };
        bounds.including(object.transform.transform_point3(DVec3::from([0, 1, 2].map(of))))
    })
}

/// Part of the pixels of `crop` that look at `bounds`.
fn seen(description: &SceneDescription, crop: PixelRect, bounds: &Aabb) -> f64 {
    if bounds.is_empty() {
        return 1.0;
    }
    let camera = Camera::new(&description.camera, &description.film);
    let at = |start: u32, length: u32, probe: u32| {
        f64::from(start) + f64::from(length) * (f64::from(probe) + 0.5) / f64::from(PROBES)
    };
    let hits = (0..PROBES * PROBES)
        .filter(|probe| {
            let x = at(crop.x0, crop.width(), probe % PROBES);
            let y = at(crop.y0, crop.height(), probe / PROBES);
            bounds.intersect(&camera.ray(x, y, [0.5; 2])).is_some()
        })
        .count();
    hits as f64 / f64::from(PROBES * PROBES)
}

/// The memory of a light's map of all directions with what directions are drawn by, bytes.
fn map_bytes(light: &LightDescription) -> u64 {
    match &light.kind {
        LightKind::Environment { map, .. } => {
            map.pixels().len() as u64 * (size_of::<[f32; 3]>() + size_of::<f64>()) as u64
        }
        _ => 0,
    }
}

#[cfg(test)]
mod tests;
