//! A digest of everything that decides the pixels.

use crate::Strata;
use crate::description::{
    DirectView, Focus, IceDescription, IntegratorKind, LightDescription, LightFinding, LightKind,
    ObjectShape, Packing, Projection, Sampler, SceneDescription, SnowDescription, Surface,
};
use crate::surface::Reflectance;
use crate::transport::deep::DeepSettings;
use crate::transport::medium::{MediumKind, ProxyStart};
use crate::transport::seek::Sought;
use snowgrain_geometry::{Quantisation, QuantisedGrain, TriangleMesh};
use snowgrain_grains::{FieldShapes, FillSettings, GrainField, LatticeCell};
use snowgrain_optics::{Absorption, Impurity, Load, Substance};
use std::collections::HashMap;
use std::sync::Arc;

/// Digest of grains as they are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct GrainDigest([u8; 32]);

impl GrainDigest {
    /// Of a whole lattice, by what defines its grains.
    pub(crate) fn of_lattice(quantisation: Quantisation, cell: &LatticeCell) -> Self {
        let mut hash = Hash(blake3::Hasher::new());
        hash.tag("lattice");
        hash.words(&cell.counts);
        hash.words(&cell.side_quanta.map(i32::cast_unsigned));
        for basis in &cell.basis {
            hash.words(&basis.map(i32::cast_unsigned));
        }
        hash.words(&[u32::from(cell.radius)]);
        hash.doubles(&quantisation.origin().to_array());
        hash.doubles(&[quantisation.quantum()]);
        Self(*hash.0.finalize().as_bytes())
    }

    /// Of bodies that are made of tiles, by the grains of these and what is asked for.
    pub(crate) fn of_tiles(
        quantisation: Quantisation,
        packing: Packing,
        variants: &[Vec<QuantisedGrain>],
        bodies: &[&FillSettings],
    ) -> Self {
        let mut hash = Hash(blake3::Hasher::new());
        hash.tag("tiles");
        for grains in variants {
            let field = GrainField::new(quantisation, grains.clone());
            hash.0.update(&Self::new(quantisation, packing, &field).0);
        }
        // What Debug writes of a number reads back as that number.
        bodies.iter().for_each(|body| hash.tag(&format!("{body:?}")));
        Self(*hash.0.finalize().as_bytes())
    }

    /// Of all grains, in their order, and their packing, in which light is rounded.
    #[must_use]
    pub(crate) fn new(quantisation: Quantisation, packing: Packing, field: &GrainField) -> Self {
        const BATCH: usize = 1 << 16;
        let mut hasher = blake3::Hasher::new();
        let mut bytes = Vec::with_capacity(BATCH + 14);
        for grain in field.quantised() {
            for coordinate in grain.center {
                bytes.extend_from_slice(&coordinate.to_le_bytes());
            }
            bytes.extend_from_slice(&grain.radius.to_le_bytes());
            if bytes.len() >= BATCH {
                hasher.update(&bytes);
                bytes.clear();
            }
        }
        hasher.update(&bytes);
        if let Some(FieldShapes { prototypes, of_grains }) = field.shapes() {
            prototypes.iter().for_each(|shape| {
                hasher.update(shape.name().as_bytes());
            });
            for shapes in of_grains.chunks(BATCH / size_of::<u64>()) {
                bytes.clear();
                shapes.iter().for_each(|s| bytes.extend_from_slice(&s.to_bits().to_le_bytes()));
                hasher.update(&bytes);
            }
        }
        let origin = quantisation.origin();
        for value in [origin.x, origin.y, origin.z, quantisation.quantum()] {
            hasher.update(&value.to_le_bytes());
        }
        match packing {
            Packing::Fast => {}
            Packing::Compact => {
                hasher.update(b"compact");
            }
        }
        Self(*hasher.finalize().as_bytes())
    }
}

/// Digest of what is asked for: the description of a scene and its seed, but neither samples nor crop, and the
/// version of this program. Known before anything is made, it tells whether a film is of the same render.
#[must_use]
pub fn recipe(scene: &SceneDescription) -> [u8; 32] {
    let mut hash = Hash(blake3::Hasher::new());
    hash.tag(env!("CARGO_PKG_VERSION"));
    hash.0.update(&scene.film.seed.to_le_bytes());
    let (packing, film) = (scene.packing, &scene.film);
    hash.tag(&format!(
        "{packing:?} {:?} {} {}",
        scene.tiled, film.keep_ice_paths, film.keep_light_groups
    ));
    for snow in &scene.snow {
        match snow {
            SnowDescription::Grains(field) => {
                let digest = GrainDigest::new(field.quantisation, Packing::Fast, field);
                hash.0.update(&digest.0);
            }
            // What Debug writes of a number reads back as that number.
            made => hash.tag(&format!("{made:?}")),
        }
    }
    hash.tag(&format!("{:?}", scene.shapes));
    hash_scene(scene, &GrainDigest(*hash.0.finalize().as_bytes()))
}

/// Digest of the resolved content: grains as stored, objects, camera, lights, ice and the size of
/// the picture; not the seed, the number of samples, or names.
#[must_use]
pub(crate) fn hash_scene(scene: &SceneDescription, grains: &GrainDigest) -> [u8; 32] {
    let mut hash = Hash(blake3::Hasher::new());
    hash.tag("film");
    hash.words(&[scene.film.width, scene.film.height]);
    hash.tag(scene.film.primaries.name());
    match scene.film.sampler {
        Sampler::Independent => {}
        Sampler::Sobol => hash.tag("sobol"),
    }
    hash.tag("camera");
    for vector in [scene.camera.from, scene.camera.at, scene.camera.up] {
        hash.doubles(&vector.to_array());
    }
    hash_projection(&mut hash, &scene.camera.projection);
    hash.floats(&scene.camera.backdrop);
    hash.tag("ice");
    hash_ice(&mut hash, &scene.ice);
    scene.lights.iter().for_each(|light| hash_light(&mut hash, light));
    match scene.light_finding {
        LightFinding::Exact => {}
        LightFinding::Sampled(settings) => {
            hash.tag(match settings.sought {
                Sought::NotSkies => "sampled",
                Sought::All => "all sampled",
            });
            hash.words(&[
                settings.calibration_paths as u32,
                (settings.calibration_paths >> 32) as u32,
            ]);
        }
    }
    match scene.integrator {
        IntegratorKind::Grains => {}
        IntegratorKind::Medium(MediumKind::Volume) => hash.tag("volume"),
        IntegratorKind::Medium(MediumKind::Proxy) => hash.tag("proxy"),
        IntegratorKind::Medium(MediumKind::Dipole) => hash.tag("dipole"),
        IntegratorKind::ProxyInDepth(ProxyStart { after_grains, depth, jumps }) => {
            hash.tag(if jumps { "shells in depth" } else { "proxy in depth" });
            hash.words(&[after_grains]);
            hash.doubles(&[depth]);
        }
    }
    if let Some(deep) = scene.deep {
        hash.tag("deep");
        let DeepSettings { after_grains, depth, cell, learning_paths } = deep;
        hash.words(&after_grains);
        hash.words(&[learning_paths as u32, (learning_paths >> 32) as u32]);
        hash.doubles(&[depth, cell]);
    }
    hash_strata(&mut hash, &scene.strata, scene.snow.len());
    let mut meshes = HashMap::new();
    for object in &scene.objects {
        hash.tag(match object.shape {
            ObjectShape::Sphere => "sphere",
            ObjectShape::Box => "box",
            ObjectShape::Plane => "plane",
            ObjectShape::Teapot => "teapot",
            ObjectShape::Mesh(_) => "mesh",
        });
        if let ObjectShape::Mesh(mesh) = &object.shape {
            hash.0.update(meshes.entry(Arc::as_ptr(mesh)).or_insert_with(|| mesh_digest(mesh)));
        }
        hash_surface(&mut hash, &object.surface);
        match object.direct_view {
            DirectView::Seen => {}
            DirectView::Holdout => hash.tag("holdout"),
            DirectView::ShadowCatcher => hash.tag("shadow catcher"),
        }
        if let (Some(_), ObjectShape::Mesh(mesh)) = (object.surface.texture(), &object.shape) {
            mesh.coordinates.as_flattened().iter().for_each(|place| hash.floats(place));
        }
        hash.doubles(&object.transform.to_cols_array());
    }
    hash.tag("grains");
    hash.0.update(&grains.0);
    *hash.0.finalize().as_bytes()
}

fn hash_surface(hash: &mut Hash, surface: &Surface) {
    match surface {
        Surface::Diffuse { albedo } => hash_reflectance(hash, albedo),
        Surface::Conductor { reflectance, edge, roughness } => {
            hash.tag("conductor");
            hash_reflectance(hash, reflectance);
            hash.floats(edge);
            hash.doubles(&[*roughness]);
        }
        Surface::Dielectric { ior, roughness } => {
            hash.tag("dielectric");
            hash.doubles(&[*ior, *roughness]);
        }
    }
}

fn hash_reflectance(hash: &mut Hash, reflectance: &Reflectance) {
    match reflectance {
        Reflectance::Colour(colour) => hash.floats(colour),
        Reflectance::Texture(map) => {
            hash.tag("texture");
            hash.0.update(&map.texture.digest());
            hash.floats(&map.factor);
            hash.doubles(&[map.metres]);
        }
    }
}

fn hash_projection(hash: &mut Hash, projection: &Projection) {
    match projection {
        Projection::Perspective { vertical_fov_degrees, lens } => {
            hash.doubles(&[*vertical_fov_degrees]);
            if let Some(lens) = lens {
                hash.tag("lens");
                hash.doubles(&[lens.diameter, lens.blade_rotation_degrees]);
                match lens.focus {
                    Focus::Distance(distance) => hash.doubles(&[distance]),
                    Focus::Surface => hash.tag("surface"),
                }
                hash.words(&[lens.blades]);
            }
        }
        Projection::Orthographic { height } => {
            hash.tag("orthographic");
            hash.doubles(&[*height]);
        }
    }
}

fn hash_light(hash: &mut Hash, light: &LightDescription) {
    hash.tag(match light.kind {
        LightKind::Sky => "sky",
        LightKind::Uniform => "uniform",
        LightKind::Overcast => "overcast",
        LightKind::ClearSky { .. } => "clear-sky",
        LightKind::Sun { .. } => "sun",
        LightKind::Environment { .. } => "environment",
        LightKind::Sphere { .. } => "sphere-light",
        LightKind::Quad { .. } => "quad-light",
        LightKind::Object { .. } => "object-light",
        LightKind::Point { .. } => "point-light",
        LightKind::Spot { .. } => "spot-light",
    });
    match &light.kind {
        LightKind::Sky | LightKind::Uniform | LightKind::Overcast => {}
        LightKind::ClearSky { sun } => hash.doubles(&sun.to_array()),
        LightKind::Sun { direction, diameter_degrees } => {
            hash.doubles(&direction.to_array());
            hash.doubles(&[*diameter_degrees]);
        }
        LightKind::Environment { map, rotation_degrees } => {
            hash.words(&[map.width() as u32, map.height() as u32]);
            map.pixels().iter().for_each(|pixel| hash.floats(pixel));
            hash.doubles(&[*rotation_degrees]);
        }
        LightKind::Sphere { center, radius } => {
            hash.doubles(&center.to_array());
            hash.doubles(&[*radius]);
        }
        LightKind::Quad { corner, edges: [u, v] } => {
            [corner, u, v].iter().for_each(|vector| hash.doubles(&vector.to_array()));
        }
        LightKind::Object { object } => hash.words(&[*object as u32]),
        LightKind::Point { position } => hash.doubles(&position.to_array()),
        LightKind::Spot { position, direction, inner_degrees, outer_degrees } => {
            [position, direction].iter().for_each(|vector| hash.doubles(&vector.to_array()));
            hash.doubles(&[*inner_degrees, *outer_degrees]);
        }
    }
    hash.floats(&light.strength);
    hash.tag(&light.spectrum.name());
    hash.words(&[u32::from(light.visible_to_camera)]);
    if light.group != light.kind.default_group() {
        hash.tag(&light.group);
    }
}

fn hash_ice(hash: &mut Hash, ice: &IceDescription) {
    hash.doubles(&[ice.eta()]);
    match &ice.absorption {
        Absorption::Grey(per_metre) => hash.doubles(&[*per_metre]),
        Absorption::Measured(source) => hash.tag(source.name()),
        Absorption::Of(substance) => hash_substance(hash, substance),
    }
    if ice.disperses {
        hash.tag("dispersion");
    }
    hash_impurities(hash, &ice.impurities);
}

fn hash_substance(hash: &mut Hash, substance: &Substance) {
    hash.tag(substance.name());
    if let Substance::Measured(measured) = substance {
        for spectrum in [&measured.index, &measured.imaginary] {
            spectrum.points().for_each(|(wavelength, value)| hash.doubles(&[wavelength, value]));
        }
    }
}

fn hash_impurities(hash: &mut Hash, impurities: &[Impurity]) {
    for impurity in impurities {
        hash.tag(impurity.kind.name());
        match impurity.load {
            Load::MassFraction(load) | Load::CellsPerKilogram(load) => hash.doubles(&[load]),
        }
    }
}

fn hash_strata(hash: &mut Hash, strata: &Strata, bodies: usize) {
    for load in &strata.loads {
        hash.tag("stratum");
        hash_impurities(hash, load);
    }
    if !strata.loads.is_empty() {
        let strata: Vec<u32> = (0..bodies).map(|body| u32::from(strata.of_body(body))).collect();
        hash.words(&strata);
    }
}

/// Digest of a mesh, whose placements share it.
fn mesh_digest(mesh: &TriangleMesh) -> [u8; 32] {
    let mut hash = Hash(blake3::Hasher::new());
    hash.words(&[mesh.positions.len() as u32, mesh.triangles.len() as u32]);
    for position in &mesh.positions {
        hash.doubles(&position.to_array());
    }
    for triangle in &mesh.triangles {
        hash.words(triangle);
    }
    *hash.0.finalize().as_bytes()
}

struct Hash(blake3::Hasher);

impl Hash {
    fn tag(&mut self, name: &str) {
        self.0.update(&(name.len() as u64).to_le_bytes());
        self.0.update(name.as_bytes());
    }

    fn doubles(&mut self, values: &[f64]) {
        for value in values {
            self.0.update(&value.to_le_bytes());
        }
    }

    fn floats(&mut self, values: &[f32]) {
        for value in values {
            self.0.update(&value.to_le_bytes());
        }
    }

    fn words(&mut self, values: &[u32]) {
        for value in values {
            self.0.update(&value.to_le_bytes());
        }
    }
}
